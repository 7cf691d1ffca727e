# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces with one side: baked with a warning, valid, the copies beyond the seam marked and facing the other way, in every file."""
import collections
import json
import unittest

import h5py
import numpy as np

import hard_meshes as hard
import meshes
import support
from test_gltf import Glb

# name: mesh, boundary loops, crosscaps, least PSNR in dB at 33 x 33
SHAPES = {
    "moebius": (lambda: meshes.moebius(), 1, 1, 60),
    "klein": (lambda: hard.klein_bottle(), 0, 2, 45),
    "boy": (lambda: hard.projective_plane(), 0, 1, 40),
}
METHODS = ("auto", "stretch", "mvc", "tutte", "arap")


def decoded(codes):
    """Unit vectors of octahedral codes [...][2] (SPEC.md section 3.4)."""
    x, y = (np.maximum(codes[..., k] / 32767.0, -1) for k in (0, 1))
    z = 1 - abs(x) - abs(y)
    below = z < 0
    sign = lambda v: np.where(v < 0, -1.0, 1.0)
    n = np.stack([np.where(below, x + sign(x) * z, x), np.where(below, y + sign(y) * z, y), z], -1)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


class Chart:
    def __init__(self, path, number=0):
        with h5py.File(path, "r") as file:
            chart = file[f"charts/{number}"]
            read = lambda name: chart[name][...] if name in chart else None
            self.seams, self.reversed = read("seams"), read("reversed")
            geometry, border = read("geometry"), read("border_geometry")
            normal, border_normal = read("normal"), read("border_normal")
        self.positions = geometry.reshape(-1, 3) if border is None else np.vstack([geometry.reshape(-1, 3), border])
        codes = normal.reshape(-1, 2) if border_normal is None else np.vstack([normal.reshape(-1, 2), border_normal])
        self.normals = decoded(codes)


class OneSided(support.Folder):
    def check_file(self, name, path, loops, crosscaps):
        chart = Chart(path)
        self.assertEqual(len(chart.reversed), len(chart.seams))
        self.assertEqual(set(chart.reversed.tolist()) - {0}, {1})
        first, copy = chart.seams.T
        self.assertTrue(np.array_equal(chart.positions[first], chart.positions[copy]))
        wanted = np.where(chart.reversed[:, None] == 1, -1, 1) * chart.normals[first]
        self.assertLess(abs(wanted - chart.normals[copy]).max(), 1e-6)
        validated = self.run_program(support.VALIDATE, path, "--source", f"{name}.obj")
        self.assertEqual(validated.returncode, 0, validated.stdout + validated.stderr)
        self.assertNotIn("warning", validated.stdout)
        self.assertIn(", one side", self.run_program(support.INFO, path).stdout)
        return chart

    def test_every_shape_by_every_method(self):
        for name, (make, loops, crosscaps, floor) in SHAPES.items():
            meshes.write_obj(self.folder / f"{name}.obj", make())
            for method in METHODS:
                with self.subTest(shape=name, method=method):
                    result = self.bake_well(f"{name}.obj", "-o", f"{name}.{method}.dgm", "--size", "33", "--method", method,
                                            "--report", "report.json", "--progress", "none")
                    self.assertIn("DGM3017", result.stdout + result.stderr)
                    (asset,) = json.loads((self.folder / "report.json").read_text())["assets"]
                    (chart,) = asset["report"]["charts"]
                    for which in ("source_topology", "map_topology"):
                        self.assertEqual([chart[which][k] for k in ("components", "boundary_loops", "genus", "manifold",
                                                                    "oriented")], [1, loops, crosscaps, True, False])
                    self.assertEqual((chart["map"]["flips"], chart["seam_gap"]), (0, 0))
                    if method == "auto":
                        self.assertGreaterEqual(asset["report"]["error"]["psnr"], floor)
                        self.assertEqual(chart["turned_faces"], 0)
                    self.check_file(name, f"{self.folder}/{name}.{method}.dgm", loops, crosscaps)

    def test_beside_other_components(self):
        meshes.write_obj(self.folder / "mixed.obj", hard.side_by_side(meshes.icosphere(2), meshes.moebius(), meshes.torus()))
        result = self.bake_well("mixed.obj", "-o", "mixed.dgm", "--size", "33", "--progress", "none")
        self.assertIn("1 of 3 components has one side", result.stdout + result.stderr)
        with h5py.File(self.folder / "mixed.dgm", "r") as file:
            self.assertEqual(["reversed" in file[f"charts/{k}"] for k in range(3)], [False, True, False])
        validated = self.run_program(support.VALIDATE, "mixed.dgm", "--source", "mixed.obj")
        self.assertEqual(validated.returncode, 0, validated.stdout + validated.stderr)

    def test_same_bytes_whatever_the_threads(self):
        meshes.write_obj(self.folder / "klein.obj", hard.klein_bottle())
        for jobs in (1, 2):
            self.bake_well("klein.obj", "-o", f"{jobs}.dgm", "--size", "33", "-j", str(jobs), "--progress", "none")
        self.assertEqual((self.folder / "1.dgm").read_bytes(), (self.folder / "2.dgm").read_bytes())

    def test_meshes_are_watertight_and_keep_both_normals(self):
        meshes.write_obj(self.folder / "klein.obj", hard.klein_bottle())
        self.bake_well("klein.obj", "-o", "klein.dgm", "--size", "33", "--progress", "none")
        result = self.run_program(support.EXPORT, "klein.dgm", "-o", "klein.glb")
        self.assertEqual(result.returncode, 0, result.stderr)
        glb = Glb((self.folder / "klein.glb").read_bytes())
        ((material, _, faces, attributes),) = glb.primitives()
        self.assertTrue(material["doubleSided"])
        self.check_mesh(attributes["POSITION"], attributes["NORMAL"], faces, 1e-5)

        result = self.run_program(support.EXPORT, "klein.dgm", "-o", "mesh.obj")
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = [line.split() for line in (self.folder / "mesh.obj").read_text().splitlines()]
        vertices = np.array([list(map(float, l[1:4])) for l in lines if l and l[0] == "v"])
        normals = np.array([list(map(float, l[1:4])) for l in lines if l and l[0] == "vn"])
        corners = [[[int(x) - 1 for x in c.split("/")] for c in l[1:]] for l in lines if l and l[0] == "f"]
        by_vertex = np.zeros_like(vertices)
        for face in corners:
            for v, _, n in face:
                by_vertex[v] = normals[n]
        self.check_mesh(vertices, by_vertex, np.array([[c[0] for c in face] for face in corners]), 1e-4)

    def check_mesh(self, positions, normals, faces, rounding):
        """Closed once equal positions are one; at some of them normals are opposite, nowhere anything between."""
        points = {}
        place = np.array([points.setdefault(p.tobytes(), len(points)) for p in np.asarray(positions)])
        uses = collections.Counter(tuple(sorted((place[f[k]], place[f[(k + 1) % 3]]))) for f in faces for k in range(3))
        self.assertEqual(set(uses.values()), {2})
        groups = collections.defaultdict(list)
        for v in np.unique(faces):
            groups[place[v]].append(normals[v])
        cosines = [float(np.dot(group[0], other)) for group in groups.values() for other in group[1:]]
        self.assertGreater(sum(c < 0 for c in cosines), 0)
        self.assertGreater(sum(c > 0 for c in cosines), 0)
        self.assertLess(max(1 - abs(c) for c in cosines), rounding)

    def test_exr_and_back(self):
        meshes.write_obj(self.folder / "boy.obj", hard.projective_plane())
        self.bake_well("boy.obj", "-o", "boy", "--size", "33", "--format", "dgm,exr", "--progress", "none")
        files = {path.suffix: path for path in self.folder.rglob("boy.*") if path.name in ("boy.dgm", "boy.exr")}
        validated = self.run_program(support.VALIDATE, files[".exr"])
        self.assertEqual(validated.returncode, 0, validated.stdout + validated.stderr)
        same = self.run_program(support.INFO, "--diff", files[".dgm"], files[".exr"])
        self.assertEqual(same.returncode, 0, same.stdout + same.stderr)


if __name__ == "__main__":
    unittest.main()
