# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces close to themselves, made by rule: thin double walls, stacked sheets, shells in shells, rolls."""
import math

from hard_meshes import lattice


def normals_of(vertices, faces):
    """Unit normal of each vertex, by area."""
    sums = [[0.0, 0.0, 0.0] for _ in vertices]
    for a, b, c in faces:
        p, q, r = vertices[a], vertices[b], vertices[c]
        u, v = [q[k] - p[k] for k in range(3)], [r[k] - p[k] for k in range(3)]
        n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        for corner in (a, b, c):
            for k in range(3):
                sums[corner][k] += n[k]
    out = []
    for n in sums:
        size = math.sqrt(sum(x * x for x in n))
        out.append(tuple(x / size for x in n) if size > 0 else (0.0, 0.0, 0.0))
    return out


def diagonal_of(vertices):
    spans = [max(v[k] for v in vertices) - min(v[k] for v in vertices) for k in range(3)]
    return math.sqrt(sum(s * s for s in spans))


def double_wall(sheet, gap):
    """The closed body between an oriented sheet and its offset by `gap` diagonals, as prints have: the same triangles
    on both sides, and a strip of quads along every border."""
    vertices, faces = sheet
    by, count = gap * diagonal_of(vertices), len(vertices)
    inner = [tuple(p - by * n for p, n in zip(v, m)) for v, m in zip(vertices, normals_of(vertices, faces))]
    out = list(faces) + [(count + a, count + c, count + b) for a, b, c in faces]
    edges = {(f[k], f[(k + 1) % 3]) for f in faces for k in range(3)}
    for a, b in sorted(edges):
        if (b, a) not in edges:
            out += [(b, a, count + a), (b, count + a, count + b)]
    return list(vertices) + inner, out


def cup(sides=96, rings=24, needles=False):
    """A cylinder with a floor and no lid: its floor is one fan, and its wall one ring of needles if asked for."""
    rings = 1 if needles else rings
    wall = [(math.cos(2 * math.pi * j / sides), math.sin(2 * math.pi * j / sides), 2.0 * i / rings)
            for i in range(rings + 1) for j in range(sides)]
    faces = []
    for i in range(rings):
        for j in range(sides):
            p, q = i * sides + j, i * sides + (j + 1) % sides
            faces += [(p, q, q + sides), (p, q + sides, p + sides)]
    wall.append((0.0, 0.0, 0.0))
    return wall, faces + [(len(wall) - 1, (j + 1) % sides, j) for j in range(sides)]


def ribbed(n=64, ribs=12, height=0.08):
    """A plate with square ribs, as stiffened walls have."""
    def point(i, j):
        x = i / (n - 1)
        return x, j / (n - 1), height * (math.floor(2 * ribs * x) % 2)
    return lattice(n, n, point)


def perforated(n=61, step=4):
    """A bent plate with a square hole in every cell of `step` x `step` quads."""
    vertices, faces = lattice(n, n, lambda i, j: (math.cos(2.4 * i / (n - 1)), math.sin(2.4 * i / (n - 1)),
                                                  1.5 * j / (n - 1)))
    kept = []
    for k, f in enumerate(faces):
        i, j = k // 2 // (n - 1), k // 2 % (n - 1)
        if not (0 < i < n - 2 and 0 < j < n - 2 and i % step == 2 and j % step == 2):
            kept.append(f)
    used = sorted({v for f in kept for v in f})
    place = {old: new for new, old in enumerate(used)}
    return [vertices[v] for v in used], [tuple(place[v] for v in f) for f in kept]


def roll(turns=6, n=400, m=24, pitch=0.02):
    """A sheet rolled up, its turns `pitch` apart."""
    def point(i, j):
        a = 2 * math.pi * turns * i / (n - 1)
        r = 0.3 + pitch * a / (2 * math.pi)
        return r * math.cos(a), r * math.sin(a), j / (m - 1)
    return lattice(n, m, point)


def pleats(folds=40, per_fold=8, m=30, width=0.02):
    """A zigzag: walls that stand `width` apart."""
    n = folds * per_fold + 1
    return lattice(n, m, lambda i, j: (width * i / per_fold, (1 - abs(1 - 2 * (i % (2 * per_fold)) / (2 * per_fold))),
                                       j / (m - 1)))


def ball(n=48, open_at=0.15):
    """A sphere with a round hole at the top."""
    a = [math.pi * (open_at + (1 - open_at) * i / n) for i in range(n)]
    vertices = [(math.sin(t) * math.cos(2 * math.pi * j / (2 * n)), math.sin(t) * math.sin(2 * math.pi * j / (2 * n)),
                 math.cos(t)) for t in a for j in range(2 * n)]
    faces = []
    for i in range(n - 1):
        for j in range(2 * n):
            p, q = i * 2 * n + j, i * 2 * n + (j + 1) % (2 * n)
            faces += [(p, p + 2 * n, q + 2 * n), (p, q + 2 * n, q)]
    vertices.append((0.0, 0.0, -1.0))
    last = (n - 1) * 2 * n
    return vertices, faces + [(last + j, len(vertices) - 1, last + (j + 1) % (2 * n)) for j in range(2 * n)]


def stack(copies, gap, n=30, joined=False):
    """Copies of a wavy sheet above each other, `gap` apart; `joined`: at one edge to the copy below and at the other
    to the one above, so that all are one surface."""
    def point(i, j):
        x, y = i / (n - 1), j / (n - 1)
        return x, y, 0.1 * math.sin(4 * x) * math.cos(3 * y)
    one, faces = lattice(n, n, point)
    vertices, out = [], []
    for k in range(copies):
        vertices += [(x, y, z + gap * k) for x, y, z in one]
        base = k * len(one)
        out += [tuple(base + v for v in (f if k % 2 == 0 or not joined else f[::-1])) for f in faces]
        if joined and k > 0:
            row = (n - 1) * n if k % 2 else 0
            for j in range(n - 1):
                a, b = base - len(one) + row + j, base - len(one) + row + j + 1
                c, d = a + len(one), b + len(one)
                out += [(b, a, c), (b, c, d)]
    return vertices, out


def shells(count, gap, n=12):
    """Balls in each other, `gap` apart."""
    vertices, faces = [], []
    for k in range(count):
        v, f = ball(n)
        base = len(vertices)
        vertices += [tuple((1 + gap * k) * x for x in p) for p in v]
        faces += [tuple(base + x for x in g) for g in f]
    return vertices, faces
