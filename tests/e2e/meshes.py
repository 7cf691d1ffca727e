# SPDX-License-Identifier: GPL-3.0-or-later
"""Small meshes for the tests, as (vertices, faces) with faces counted from 0, and their OBJ files."""
import math


def icosphere(subdivisions=2):
    """A closed surface of genus 0: 20 * 4**subdivisions faces on the unit sphere."""
    g = (1 + math.sqrt(5)) / 2
    raw = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g),
           (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
             (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11),
             (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    vertices = [unit(v) for v in raw]
    for _ in range(subdivisions):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(vertices)
                vertices.append(unit([x + y for x, y in zip(vertices[a], vertices[b])]))
            return middles[key]

        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = finer
    return vertices, faces


def unit(v):
    length = math.sqrt(sum(x * x for x in v))
    return tuple(x / length for x in v)


def torus(rings=24, sides=12, radius=1.0, tube=0.4):
    """A closed surface of genus 1."""
    vertices = []
    for i in range(rings):
        a = 2 * math.pi * i / rings
        for j in range(sides):
            b = 2 * math.pi * j / sides
            r = radius + tube * math.cos(b)
            vertices.append((r * math.cos(a), r * math.sin(a), tube * math.sin(b)))
    faces = []
    for i in range(rings):
        for j in range(sides):
            p, q = i * sides + j, ((i + 1) % rings) * sides + j
            p1, q1 = i * sides + (j + 1) % sides, ((i + 1) % rings) * sides + (j + 1) % sides
            faces += [(p, q, q1), (p, q1, p1)]
    return vertices, faces


def sheet(n=16, height=0.2):
    """A disk: a wavy square of n x n quads."""
    vertices = [(i / n, j / n, height * math.sin(3 * i / n) * math.cos(2 * j / n))
                for i in range(n + 1) for j in range(n + 1)]
    faces = []
    for i in range(n):
        for j in range(n):
            a, b = i * (n + 1) + j, (i + 1) * (n + 1) + j
            faces += [(a, b, b + 1), (a, b + 1, a + 1)]
    return vertices, faces


def line(n=6):
    """Faces whose corners all lie on one line: no bake takes them (DGM3001)."""
    return [(k, 2 * k, 3 * k) for k in range(n)], [(k, k + 1, k + 2) for k in range(n - 2)]


def moebius(n=40, width=4):
    """A band with one side: its last column meets its first turned over."""
    vertices = []
    for i in range(n):
        a = 2 * math.pi * i / n
        for j in range(width + 1):
            s = 0.3 * (2 * j / width - 1)
            r = 1 + s * math.cos(a / 2)
            vertices.append((r * math.cos(a), r * math.sin(a), s * math.sin(a / 2)))
    faces = []
    for i in range(n):
        for j in range(width):
            if i + 1 < n:
                c, d = (i + 1) * (width + 1) + j, (i + 1) * (width + 1) + j + 1
            else:
                c, d = width - j, width - j - 1
            a, b = i * (width + 1) + j, i * (width + 1) + j + 1
            faces += [(a, c, d), (a, d, b)]
    return vertices, faces


def together(*parts):
    """Several meshes as one, side by side along x."""
    vertices, faces = [], []
    for k, (part_vertices, part_faces) in enumerate(parts):
        start = len(vertices)
        vertices += [(x + 4 * k, y, z) for x, y, z in part_vertices]
        faces += [tuple(start + i for i in face) for face in part_faces]
    return vertices, faces


def write_obj(path, mesh):
    vertices, faces = mesh
    with open(path, "w", encoding="ascii") as out:
        for v in vertices:
            out.write("v " + " ".join(repr(float(x)) for x in v) + "\n")
        for face in faces:
            out.write("f " + " ".join(str(i + 1) for i in face) + "\n")
    return path
