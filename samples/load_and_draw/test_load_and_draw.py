# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes two samples, runs load_and_draw on them and works out from the HDF5 file what it should have written.

    test_load_and_draw.py LOAD_AND_DRAW DGM_BAKE SAMPLES
"""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy

LOAD_AND_DRAW, BAKE, SAMPLES = sys.argv[1], sys.argv[2], Path(sys.argv[3])
SIGMA, REACH, DEPTH = 16, 11, 0.05  # as the program sets them


class LoadAndDraw(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="load-and-draw-")
        self.addCleanup(folder.cleanup)
        self.dgm, self.obj = Path(folder.name) / "map.dgm", Path(folder.name) / "map.obj"

    def run_on(self, mesh, *options):
        subprocess.run([BAKE, "-q", SAMPLES / mesh, "-o", self.dgm, *options], check=True, timeout=200)
        told = subprocess.run([LOAD_AND_DRAW, self.dgm, self.obj], check=True, timeout=60, capture_output=True,
                              text=True).stdout
        rows = {key: [] for key in ("v", "vt", "vn", "f")}
        for line in self.obj.read_text(encoding="ascii").splitlines():
            key, *words = line.split()
            rows[key].append(words)
        points = numpy.array(rows["v"], float)
        faces = numpy.array([[corner.split("/")[0] for corner in face] for face in rows["f"]], int) - 1
        return told, points, faces

    def test_dent_is_equation_7(self):
        """The sheet is flat: each sample must stand where eq. 7 puts it, by its distance in mean steps."""
        told, points, faces = self.run_on("sheet/sheet.obj", "--size", "65x49", "--domain", "square")
        with h5py.File(self.dgm) as file:
            rest = file["charts/0/geometry"][...].astype(float)
        m, n, _ = rest.shape
        self.assertEqual((m, n), (65, 49))
        self.assertEqual(faces.shape, (2 * (m - 1) * (n - 1), 3))
        low, high = rest.min((0, 1)), rest.max((0, 1))
        ci, cj = divmod(int(numpy.linalg.norm(rest - (low + high) / 2, axis=2).argmin()), n)
        self.assertIn(f"pressed sample ({ci}, {cj})", told)

        moved = points.reshape(m, n, 3) - rest
        depth = DEPTH * numpy.linalg.norm(high - low)
        self.assertAlmostEqual(numpy.linalg.norm(moved[ci, cj]), depth, delta=1e-4 * depth)
        step = numpy.sqrt((high - low)[0] * (high - low)[1] / ((m - 1) * (n - 1)))
        distance = numpy.linalg.norm(rest - rest[ci, cj], axis=2) / step
        self.assertIn(f"{(distance < REACH).sum()} samples moved", told)
        weight = numpy.where(distance < REACH, numpy.exp(-(distance**2) / SIGMA), 0)
        inside = abs(distance - REACH) > 0.01  # the kernel as printed has a step there
        self.assertLess(abs(moved - weight[..., None] * moved[ci, cj])[inside].max(), 1e-4 * depth)

    def test_closed_surface_stays_closed(self):
        """Samples that are one point of the stomach are one point of the dented stomach."""
        _, points, faces = self.run_on("stomach/stomach.obj", "--size", "65x65", "--method", "mvc")
        with h5py.File(self.dgm) as file:
            seams = file["charts/0/seams"][...]
        self.assertGreater(len(seams), 0)
        self.assertTrue((points[seams[:, 0]] == points[seams[:, 1]]).all())
        _, welded = numpy.unique(points, axis=0, return_inverse=True)
        corners = welded.reshape(-1)[faces]
        edges = numpy.sort(numpy.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]), axis=1)
        _, uses = numpy.unique(edges[edges[:, 0] != edges[:, 1]], axis=0, return_counts=True)
        self.assertTrue((uses == 2).all())

    def test_refuses_what_is_no_map(self):
        self.dgm.write_bytes(b"not a map" * 1000)
        result = subprocess.run([LOAD_AND_DRAW, self.dgm, self.obj], timeout=60, capture_output=True, text=True,
                                check=False)
        self.assertEqual(result.returncode, 3)
        self.assertIn("NOT_DGM", result.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
