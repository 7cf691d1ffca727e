# SPDX-License-Identifier: GPL-3.0-or-later
"""Hard cases of every kind, made by rule: (vertices, faces) with faces counted from 0, polygons of any size."""
import cmath
import math
import random

import meshes


def lattice(a, b, point, wrap_i=False, wrap_j=False):
    """Quads split in two over an a x b lattice of vertices point(i, j); a wrapped direction joins last to first."""
    vertices = [point(i, j) for i in range(a) for j in range(b)]
    faces = []
    for i in range(a if wrap_i else a - 1):
        for j in range(b if wrap_j else b - 1):
            p, q = i * b + j, (i + 1) % a * b + j
            p1, q1 = i * b + (j + 1) % b, (i + 1) % a * b + (j + 1) % b
            faces += [(p, q, q1), (p, q1, p1)]
    return vertices, faces


def rounded_sheet(n=40):
    """x and y rounded so far that most faces lie within a line, as single precision leaves far from the origin."""
    def point(i, j):
        x, y = i / (n - 1), j / (n - 1)
        return round(16 * x) / 16, round(2 * y) / 2, 0.2 * math.sin(6 * x) * math.cos(6 * y)
    return lattice(n, n, point)


def moved(mesh, scale=1.0, shift=(0.0, 0.0, 0.0)):
    vertices, faces = mesh
    return [tuple(scale * x + d for x, d in zip(v, shift)) for v in vertices], faces


def bent(mesh):
    """Without any symmetry."""
    vertices, faces = mesh
    return [(x * (1 + 0.25 * math.sin(2 * y + 1) + 0.1 * z), y * (1.3 + 0.2 * math.sin(3 * z + x)),
             z * (0.8 + 0.15 * math.cos(2 * x - y)) + 0.1 * x * x) for x, y, z in vertices], faces


def rotated(mesh, angles=(0.7, -1.1, 2.3)):
    """Turned about x, y and z in turn."""
    vertices, faces = mesh
    for axis, angle in enumerate(angles):
        c, s = math.cos(angle), math.sin(angle)
        a, b = (axis + 1) % 3, (axis + 2) % 3
        turned = []
        for v in vertices:
            w = list(v)
            w[a], w[b] = c * v[a] - s * v[b], s * v[a] + c * v[b]
            turned.append(tuple(w))
        vertices = turned
    return vertices, faces


def shuffled(mesh, seed=1):
    """Vertices and faces in another order, and each face from another corner on."""
    vertices, faces = mesh
    draw = random.Random(seed)
    order = list(range(len(vertices)))
    draw.shuffle(order)
    place = {old: new for new, old in enumerate(order)}
    out = []
    for face in faces:
        turn = draw.randrange(len(face))
        out.append(tuple(place[v] for v in face[turn:] + face[:turn]))
    draw.shuffle(out)
    return [vertices[old] for old in order], out


def cubes(cells, detail=1):
    """Surface of a body of unit cubes, wound outward; each square is cut into detail x detail smaller ones."""
    filled, index, vertices, faces = set(cells), {}, [], []
    for cell in sorted(filled):
        for axis in range(3):
            for side in (0, 1):
                beside = tuple(x + ((2 * side - 1) if k == axis else 0) for k, x in enumerate(cell))
                if beside in filled:
                    continue
                u, v = (axis + 1) % 3, (axis + 2) % 3
                for a in range(detail):
                    for b in range(detail):
                        corners = []
                        for da, db in ((0, 0), (1, 0), (1, 1), (0, 1)):
                            p = [0, 0, 0]
                            p[axis] = (cell[axis] + side) * detail
                            p[u], p[v] = cell[u] * detail + a + da, cell[v] * detail + b + db
                            key = tuple(p)
                            if key not in index:
                                index[key] = len(vertices)
                                vertices.append(tuple(x / detail for x in p))
                            corners.append(index[key])
                        if side == 0:
                            corners.reverse()
                        faces += [tuple(corners[:3]), (corners[0], corners[2], corners[3])]
    return vertices, faces


def plate(genus, detail=4):
    """A plate with `genus` holes in a row."""
    return cubes([(x, y, 0) for x in range(2 * genus + 1) for y in range(3) if x % 2 == 0 or y != 1], detail)


def lattice_of_bars(n=4):
    """The edges of an (n-1)^3 block of cells as square bars: genus n*n*(n-1)*3 - n**3 + 1, which is 81 for n = 4."""
    return cubes([(x, y, z) for x in range(2 * n - 1) for y in range(2 * n - 1) for z in range(2 * n - 1)
                  if (x % 2) + (y % 2) + (z % 2) <= 1])


def tube(ratio=1000, sides=6, rings=501):
    """An open tube `ratio` times as long as it is wide."""
    return lattice(rings, sides, lambda i, j: (0.5 * math.cos(2 * math.pi * j / sides), ratio * i / (rings - 1),
                                               0.5 * math.sin(2 * math.pi * j / sides)), wrap_j=True)


def fan(valence=10000):
    """A flat disk whose centre meets `valence` faces."""
    rim = [(math.cos(2 * math.pi * k / valence), math.sin(2 * math.pi * k / valence), 0.0) for k in range(valence)]
    return [(0.0, 0.0, 0.0)] + rim, [(0, 1 + k, 1 + (k + 1) % valence) for k in range(valence)]


def bipyramid(valence=2000):
    """A closed body with two vertices of that valence."""
    rim = [(math.cos(2 * math.pi * k / valence), math.sin(2 * math.pi * k / valence), 0.0) for k in range(valence)]
    faces = []
    for k in range(valence):
        a, b = 2 + k, 2 + (k + 1) % valence
        faces += [(0, a, b), (1, b, a)]
    return [(0.0, 0.0, 0.6), (0.0, 0.0, -0.6)] + rim, faces


def graded_disk(rings=60, sides=16, factor=0.6):
    """Rings that shrink exponentially: the innermost is factor**rings of the outermost."""
    vertices, faces = lattice(rings, sides, lambda i, j: (factor ** i * math.cos(2 * math.pi * j / sides),
                                                          factor ** i * math.sin(2 * math.pi * j / sides), 0.0),
                              wrap_j=True)
    centre, last = len(vertices), (rings - 1) * sides
    vertices.append((0.0, 0.0, 0.0))
    return vertices, faces + [(last + j, centre, last + (j + 1) % sides) for j in range(sides)]


def finger(length=30, sides=12, rings=150):
    """A disk with one long finger: on it the values of Tutte's map fall exponentially, below the smallest double."""
    def point(i, j):
        a = 2 * math.pi * j / sides
        return math.cos(a), length * i / (rings - 1), math.sin(a)
    vertices, faces = lattice(rings, sides, point, wrap_j=True)
    tip, last = len(vertices), (rings - 1) * sides
    vertices.append((0.0, length + 1.0, 0.0))
    return vertices, faces + [(last + j, tip, last + (j + 1) % sides) for j in range(sides)]


def spiky_ball(spikes=12, height=3.0):
    """A ball with thin spikes of one vertex each."""
    vertices, faces = meshes.icosphere(3)
    vertices = list(vertices)
    for k in range(spikes):
        v = k * len(vertices) // spikes
        vertices[v] = tuple(height * x for x in vertices[v])
    return vertices, faces


def tree(levels=3):
    """A branching body of cubes: each limb ends in two others."""
    cells = set()

    def grow(x, y, z, level, axis):
        length = 2 ** (level + 1)
        for _ in range(length):
            cells.add((x, y, z))
            y += 1
        if level == 0:
            return
        for side in (-1, 1):
            p = [x, y, z]
            for _ in range(2 ** level + 1):
                cells.add(tuple(p))
                p[axis] += side
            grow(p[0], p[1], p[2], level - 1, 2 - axis)

    grow(0, 0, 0, levels, 0)
    return cubes(sorted(cells))


def sheet_with_holes(n=45, step=3):
    """A wavy sheet without every third quad each way: n = 45 has 225 holes."""
    vertices, faces = meshes.sheet(n)
    kept = [f for k, f in enumerate(faces) if not (0 < k // 2 // n < n - 1 and 0 < k // 2 % n < n - 1
                                                   and k // 2 // n % step == 1 and k // 2 % n % step == 1)]
    return vertices, kept


def slivers(n=20, thin=1e-12):
    """A sheet whose every other row has hardly any height."""
    def row(i):
        return (i // 2) / n + (i % 2) * thin
    return lattice(2 * n + 1, n + 1, lambda i, j: (row(i), j / n, 0.1 * math.sin(3 * row(i)) * math.cos(2 * j / n)))


def bow_tie():
    return [(0, 0, 0), (-1, 1, 0), (-1, -1, 0), (1, -1, 0), (1, 1, 0)], [(0, 1, 2), (0, 3, 4)]


def klein_bottle(a=32, b=12):
    """Closed, one-sided."""
    def point(i, j):
        u, v = 2 * math.pi * i / a, 2 * math.pi * (j + 0.5) / b
        x, y = math.sin(v), math.sin(2 * v)
        r = 3 + math.cos(u / 2) * x - math.sin(u / 2) * y
        return r * math.cos(u), r * math.sin(u), math.sin(u / 2) * x + math.cos(u / 2) * y
    vertices, faces = lattice(a, b, point, wrap_j=True)
    last = (a - 1) * b
    for j in range(b):
        p, q, s, t = last + j, last + (j + 1) % b, b - 1 - j, b - 1 - (j + 1) % b
        faces += [(p, s, t), (p, t, q)]
    return vertices, faces


def projective_plane(rings=12, n=48):
    """Boy's surface, closed and one-sided, immersed with a triple point [Bryant, Kusner]: a disk |w| <= 1 whose border points
    w and -w are one."""
    def point(w):
        below = w ** 6 + math.sqrt(5) * w ** 3 - 1
        g = (-1.5 * (w * (1 - w ** 4) / below).imag, -1.5 * (w * (1 + w ** 4) / below).real,
             ((1 + w ** 6) / below).imag - 0.5)
        squared = sum(x * x for x in g)
        return tuple(x / squared for x in g)
    vertices = [point(0j)]
    for k in range(1, rings + 1):
        vertices += [point(k / rings * cmath.exp(2j * math.pi * i / n)) for i in range(n if k < rings else n // 2)]
    def at(k, i):
        return 1 + (k - 1) * n + i % (n if k < rings else n // 2)
    faces = [(0, at(1, i), at(1, i + 1)) for i in range(n)]
    for k in range(1, rings):
        for i in range(n):
            faces += [(at(k, i), at(k + 1, i), at(k + 1, i + 1)), (at(k, i), at(k + 1, i + 1), at(k, i + 1))]
    return vertices, faces


def side_by_side(*parts):
    """Meshes in one file, each moved along x by 4 from the one before."""
    vertices, faces = [], []
    for k, (points, polygons) in enumerate(parts):
        first = len(vertices)
        vertices += [(x + 4 * k, y, z) for x, y, z in points]
        faces += [tuple(v + first for v in polygon) for polygon in polygons]
    return vertices, faces


def with_bad_faces(mesh):
    """Every seventh face twice, every eleventh turned as well, and faces without area."""
    vertices, faces = mesh
    doubled = [f for k, f in enumerate(faces) if k % 7 == 0] + [f[::-1] for k, f in enumerate(faces) if k % 11 == 0]
    return vertices, faces + doubled + [(0, 0, 1), (2, 2, 2), (3, 4, 3)]


def randomly_wound(mesh, seed=5):
    vertices, faces = mesh
    draw = random.Random(seed)
    return vertices, [f if draw.random() < 0.5 else f[::-1] for f in faces]


def unwelded(mesh):
    """Every face with vertices of its own."""
    vertices, faces = mesh
    return [vertices[v] for f in faces for v in f], [tuple(range(3 * k, 3 * k + 3)) for k in range(len(faces))]


def with_values(mesh, values):
    """Vertex -> another position (NaN and infinities, for instance)."""
    vertices, faces = mesh
    return [values.get(k, v) for k, v in enumerate(vertices)], faces


def soup(count, size=0.1, seed=1):
    """Loose triangles, up to `size` wide, anywhere in a cube."""
    draw = random.Random(seed)
    vertices = []
    for _ in range(count):
        middle = [draw.random() for _ in range(3)]
        vertices += [tuple(x + size * (draw.random() - 0.5) for x in middle) for _ in range(3)]
    return vertices, [(3 * k, 3 * k + 1, 3 * k + 2) for k in range(count)]


def book(pages=3):
    """Squares that share one edge: no surface there."""
    vertices, faces = [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)], []
    for k in range(pages):
        a, v = 2 * math.pi * k / pages, len(vertices)
        vertices += [(math.cos(a), math.sin(a), 1.0), (math.cos(a), math.sin(a), 0.0)]
        faces += [(0, 1, v), (0, v, v + 1)]
    return vertices, faces


def prism(outline, height):
    """A simple polygon, counterclockwise, pulled up: the importer cuts needles out of its two ends."""
    count = len(outline)
    vertices = [(x, y, z) for z in (0.0, height) for x, y in outline]
    sides = [(k, (k + 1) % count, count + (k + 1) % count, count + k) for k in range(count)]
    return vertices, [tuple(reversed(range(count))), tuple(range(count, 2 * count))] + sides


def star(points=60):
    """Narrow points around a small middle."""
    return prism([(r * math.cos(a), r * math.sin(a)) for k in range(2 * points)
                  for r, a in [(1.0 if k % 2 == 0 else 0.35, math.pi * k / points)]], 0.2)


def toothed_comb(teeth=20):
    """Long teeth on a narrow back."""
    outline = [(0.0, 0.0), (0.3 * teeth, 0.0)]
    for k in reversed(range(teeth)):
        right, left = 0.3 * k + 0.2, 0.3 * k + 0.1
        outline += [(right, 0.4), (right, 3.0), (left, 3.0), (left, 0.4)]
    outline[2:2] = [(0.3 * teeth, 0.4)]
    return prism(outline + [(0.0, 0.4)], 0.3)


def gear(teeth=30, sides=240):
    """Square teeth on a disk."""
    def radius(a):
        return 1.12 if math.sin(teeth * a + 0.01) > 0 else 0.88
    return prism([(radius(a) * math.cos(a), radius(a) * math.sin(a)) for a in (2 * math.pi * k / sides for k in range(sides))], 0.3)
