# SPDX-License-Identifier: GPL-3.0-or-later
"""Skirts and tubes: unrolled between opposite sides of the grid, whose shape suits them unless it was named."""
import json
import math
import unittest

import h5py
import numpy as np

import meshes
import support

HEIGHT = 2.0


def skirt(around=120, along=30, pleats=9):
    """A ring: wider below than above, in pleats."""
    vertices = []
    for i in range(along + 1):
        for j in range(around):
            t, down = 2 * math.pi * j / around, i / along
            r = 1 + down * (0.5 + 0.1 * math.cos(pleats * t))
            vertices.append((r * math.cos(t), r * math.sin(t), -HEIGHT * down))
    faces = []
    for i in range(along):
        for j in range(around):
            p, q = i * around + j, i * around + (j + 1) % around
            faces += [(p, p + around, q + around), (p, q + around, q)]
    return vertices, faces


class Rings(support.Folder):
    def bake_skirt(self, *arguments, name="skirt"):
        """The report of the one chart, and its positions by row and column."""
        self.bake_well("skirt.obj", "-o", f"{name}.dgm", "--report", f"{name}.json", *arguments)
        asset = json.loads((self.folder / f"{name}.json").read_text(encoding="utf-8"))["assets"][0]
        with h5py.File(self.folder / f"{name}.dgm", "r") as file:
            positions = file["charts/0/geometry"][...]
            seams = file["charts/0/seams"][...]
        return asset["report"], asset["report"]["charts"][0], positions, seams

    def setUp(self):
        super().setUp()
        meshes.write_obj(self.folder / "skirt.obj", skirt())

    def check_unrolled(self, report, chart, positions, seams):
        chosen = [c["outcome"] for c in chart["candidates"] if c["outcome"].startswith("chosen")]
        self.assertEqual(len(chosen), 1)
        self.assertIn("loops on opposite sides", chosen[0])
        rows, cols = positions.shape[:2]
        if abs(positions[0, 0, 2] - positions[-1, 0, 2]) > HEIGHT / 2:  # the loops are the first and last rows
            positions = positions.transpose(1, 0, 2)
        along = positions.shape[0]
        for column in (0, -1):
            z = positions[:, column, 2]
            self.assertLess(np.ptp(z), 1e-5, "one loop, all of it")
            self.assertAlmostEqual(min(abs(z[0]), abs(z[0] + HEIGHT)), 0, places=5)
            turns = np.unwrap(np.arctan2(positions[:, column, 1], positions[:, column, 0]))
            self.assertAlmostEqual(abs(turns[-1] - turns[0]), 2 * math.pi, places=4)
        self.assertTrue(np.array_equal(positions[0], positions[-1]), "the cut's copies have the same bits")
        self.assertEqual(len(seams), rows * cols // along, "and there are no other copies")
        self.assertEqual(chart["seam_gap"], 0)
        self.assertEqual(chart["map"]["flips"], 0)
        self.assertEqual((chart["map_topology"]["boundary_loops"], chart["map_topology"]["genus"]), (2, 0))
        self.assertEqual(sum(c["turned_faces"] for c in report["charts"]), 0)

    def test_the_shape_suits_the_ring(self):
        report, chart, positions, seams = self.bake_skirt("--size", "auto:2401", "--layers", "geometry")
        self.assertLessEqual(chart["rows"] * chart["cols"], 2401)
        self.assertGreater(max(chart["rows"], chart["cols"]), 2 * min(chart["rows"], chart["cols"]))
        self.check_unrolled(report, chart, positions, seams)
        named, square, _, _ = self.bake_skirt("--size", "49x49", "--layers", "geometry", name="named")
        self.assertEqual((square["rows"], square["cols"]), (49, 49), "a size that is named is the size")
        self.assertGreater(report["error"]["psnr"], named["error"]["psnr"] + 3)
        valid = self.run_program(support.VALIDATE, "skirt.dgm", "--source", "skirt.obj")
        self.assertEqual(valid.returncode, 0, valid.stdout + valid.stderr)

    def test_without_a_size_rings_get_theirs(self):
        report, chart, positions, seams = self.bake_skirt("--layers", "geometry")
        self.assertLessEqual(chart["rows"] * chart["cols"], 257 * 257)
        self.assertGreater(chart["rows"] * chart["cols"], 0.9 * 257 * 257)
        self.assertGreater(max(chart["rows"], chart["cols"]), 2 * min(chart["rows"], chart["cols"]))
        self.assertEqual(((chart["rows"] - 1) % 8, (chart["cols"] - 1) % 8), (0, 0), "three levels keep the borders")
        self.check_unrolled(report, chart, positions, seams)
        again = self.bake_well("skirt.obj", "-o", "skirt.dgm", "--layers", "geometry")
        self.assertIn("up to date", again.stdout + again.stderr)
        meshes.write_obj(self.folder / "ball.obj", meshes.icosphere(3))
        self.bake_well("ball.obj", "-o", "ball.dgm", "--layers", "geometry")
        with h5py.File(self.folder / "ball.dgm", "r") as file:
            self.assertEqual(file["charts/0/geometry"].shape, (257, 257, 3))


if __name__ == "__main__":
    unittest.main()
