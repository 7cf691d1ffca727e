# SPDX-License-Identifier: GPL-3.0-or-later
"""Eq. 7 on the sample stomach, with footprints across seams, against an unfolding worked out here from the file."""
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

import support

SIZE = 65
REACH = 7  # b of eq. 7: |di| < b and |dj| < b
SIGMA = 16.0
PUSH = (0.5, -0.25, 1.0)  # exact in f32, as are SIGMA and D_MAX
D_MAX = 2.0
INWARD = {"top": (1, 0), "bottom": (-1, 0), "left": (0, 1), "right": (0, -1)}


class Chart:
    """The layers of chart 0 as h5py reads them, and the straight parts of its cut paths."""

    def __init__(self, path):
        with h5py.File(path, "r") as file:
            self.geometry = file["charts/0/geometry"][...]
            self.seams = file["charts/0/seams"][...]
            domain = file["charts/0"].attrs["domain"]
            self.domain = domain.decode() if isinstance(domain, bytes) else str(domain)
        self.rows, self.cols = self.geometry.shape[:2]
        copies = {}
        for representative, copy in self.seams.tolist():
            copies.setdefault(representative, [representative]).append(copy)
        self.classes = [[divmod(s, self.cols) for s in members] for members in copies.values()]
        # Inside a cut path a point has just two copies; more, or one only, are its nodes and ends.
        self.mate = {}
        for members in self.classes:
            if len(members) == 2:
                self.mate[members[0]], self.mate[members[1]] = members[1], members[0]

    def side(self, sample):
        """The side a border sample lies on; None for corners, which lie on two, and inside."""
        i, j = sample
        sides = [name for name, on in (("top", i == 0), ("bottom", i == self.rows - 1), ("left", j == 0),
                                       ("right", j == self.cols - 1)) if on]
        return sides[0] if len(sides) == 1 else None

    def is_straight(self, centre, half):
        """Whether both copies of the path run straight from `half` steps before a border sample to `half` beyond."""
        side = self.side(centre)
        a, b = INWARD[side]
        run = [(centre[0] + s * b, centre[1] + s * a) for s in range(-half, half + 1)]
        if any(self.side(p) != side or p not in self.mate for p in run):
            return False
        mates = np.array([self.mate[p] for p in run])
        steps = np.diff(mates, axis=0)
        return (np.abs(steps[0]).sum() == 1 and (steps == steps[0]).all()
                and all(self.side(tuple(p)) == self.side(tuple(mates[0])) is not None for p in mates.tolist()))

    def contacts(self):
        """For each side of the square and the side of its mates: the border sample amid the longest straight path."""
        best = {}
        for centre in sorted(self.mate):
            half = REACH  # one step more than the footprint: no node within reach
            if self.side(centre) is None or not self.is_straight(centre, half):
                continue
            while self.is_straight(centre, half + 1):
                half += 1
            sides = self.side(centre), self.side(self.mate[centre])
            if half > best.get(sides, (0, None))[0]:
                best[sides] = half, centre
        return {sides: centre for sides, (_, centre) in best.items()}

    def footprint(self, centre, depth):
        """{sample: least di^2 + dj^2} of the window around the sample `depth` steps inward from border sample `centre`,
        laid over the path; and the samples that the mate's side brings in.

        s runs along the path, e inward from the contact: -depth is the path. Beyond it lies the mate's side, rolled out
        outward: q steps inward from the mate of the border sample at s are q steps farther from the contact.
        """
        a, b = INWARD[self.side(centre)]
        c, d = INWARD[self.side(self.mate[centre])]
        squares, beyond = {}, set()
        for s in range(1 - REACH, REACH):
            i, j = centre[0] + s * b, centre[1] + s * a
            for e in range(-depth, REACH):
                sample = i + (depth + e) * a, j + (depth + e) * b
                squares[sample] = min(squares.get(sample, np.inf), s * s + e * e)
            k, l = self.mate[i, j]
            for q in range(REACH - depth):
                sample = k + q * c, l + q * d
                squares[sample] = min(squares.get(sample, np.inf), s * s + (depth + q) ** 2)
                beyond.add(sample)
        return squares, beyond


class Deform(support.Folder):
    @classmethod
    def setUpClass(cls):
        folder = Path(tempfile.mkdtemp(prefix="dgm-e2e-"))
        cls.addClassCleanup(shutil.rmtree, folder, ignore_errors=True)
        cls.asset = folder / "stomach.dgm"
        result = subprocess.run(
            [support.BAKE, Path(support.SAMPLES) / "stomach/stomach.obj", "-o", cls.asset, "--size", f"{SIZE}x{SIZE}",
             "--domain", "square"], capture_output=True, text=True, timeout=support.TIMEOUT_SECONDS, check=False)
        if result.returncode != 0:
            raise AssertionError(result.stdout + result.stderr)
        cls.chart = Chart(cls.asset)

    def deform(self, contact, displacement, d_max=D_MAX):
        """Rest and present positions, the table's error bound, the samples in reach, whether a seam was crossed."""
        result = self.run_program(support.DEFORM_SAMPLE, self.asset, self.folder, *contact, REACH, SIGMA, *displacement,
                                  d_max)
        self.assertEqual(result.returncode, 0, result.stderr)
        bound, samples, crossed = result.stdout.split()
        shape = self.chart.geometry.shape
        rest, now = (np.fromfile(self.folder / name, "<f4").reshape(shape) for name in ("rest.bin", "now.bin"))
        return rest, now, float(bound), int(samples), crossed == "1"

    def assert_copies_equal(self, points):
        bits = np.ascontiguousarray(points).view(np.uint32).reshape(-1, 3)
        self.assertGreater(len(self.chart.seams), 0)
        self.assertTrue(np.array_equal(bits[self.chart.seams[:, 0]], bits[self.chart.seams[:, 1]]))

    def assert_eq7(self, centre, depth, displacement, clamped, d_max=D_MAX):
        """Every sample of the chart after a touch with `displacement`, which the clamp makes `clamped`."""
        chart = self.chart
        a, b = INWARD[chart.side(centre)]
        contact = centre[0] + depth * a, centre[1] + depth * b
        rest, now, bound, samples, crossed = self.deform(contact, displacement, d_max)
        self.assertTrue(np.array_equal(rest.view(np.uint32), chart.geometry.view(np.uint32)))
        self.assertTrue(crossed)
        self.assertLess(bound, 1e-7)  # the comparison below is only as good as what the table states

        squares, beyond = chart.footprint(centre, depth)
        self.assertEqual(samples, len(squares))
        weights, in_reach = np.zeros(rest.shape[:2]), np.zeros(rest.shape[:2], dtype=bool)
        for sample, square in squares.items():
            weights[sample] = np.exp(-square / SIGMA)
            in_reach[sample] = True
        expected = rest.astype(float) + weights[..., None] * np.asarray(clamped)
        # Beside the table's error: d_c and weight * d_c rounded to f32 (2^-24 each), and the sum (half its last place).
        tolerance = np.abs(clamped) * (bound + 2 * 2.0**-24) + np.spacing(np.abs(expected).astype(np.float32)) / 2
        error = np.abs(now.astype(float) - expected)
        worst = np.unravel_index(np.argmax(np.where(in_reach[..., None], error - tolerance, -1)), error.shape)
        self.assertTrue((error <= tolerance)[in_reach].all(),
                        f"contact {contact}, sample {worst}: off by {error[worst]}, allowed {tolerance[worst]}")
        unmoved = (now.view(np.uint32) == rest.view(np.uint32)).all(axis=-1)
        self.assertTrue(unmoved[~in_reach].all(), "a sample out of reach moved")
        # Deep beyond the seam, past its own samples, as well as on the contact's side.
        moved_beyond = [p for p in beyond if chart.side(p) is None and not unmoved[p]]
        self.assertEqual(len(moved_beyond), (2 * REACH - 1) * (REACH - depth - 1))
        self.assertFalse(unmoved[in_reach].any(), "a sample in reach stayed")
        self.assert_copies_equal(rest)
        self.assert_copies_equal(now)
        return contact, rest, now

    def test_chart_has_seams_to_cross(self):
        self.assertEqual(self.chart.domain, "square")
        self.assertEqual(self.chart.geometry.shape, (SIZE, SIZE, 3))
        contacts = self.chart.contacts()
        self.assertGreaterEqual(len(contacts), 2)  # at least one path, from both its sides

    def test_eq7_across_seams(self):
        for sides, centre in self.chart.contacts().items():
            for depth in (0, 2, 3):  # 0: the contact is on the seam itself
                with self.subTest(sides=sides, centre=centre, depth=depth):
                    contact, rest, now = self.assert_eq7(centre, depth, PUSH, PUSH)
                    # The contact itself moves by d_c.
                    np.testing.assert_allclose(now[contact].astype(float) - rest[contact], PUSH, atol=2e-6, rtol=0)

    def test_pull_is_the_opposite_push(self):
        centre = next(iter(self.chart.contacts().values()))
        pull = tuple(-x for x in PUSH)
        _, rest, pulled = self.assert_eq7(centre, 2, pull, pull)
        _, _, pushed = self.assert_eq7(centre, 2, PUSH, PUSH)
        np.testing.assert_allclose(pulled.astype(float) - rest, rest - pushed.astype(float), atol=2e-6, rtol=0)

    def test_long_displacements_are_shortened(self):
        centre = next(iter(self.chart.contacts().values()))
        # |(3, -6, 2)| = 7, so d_max 0.875 leaves an eighth of it: exact.
        for sign in (1, -1):
            asked = tuple(sign * x for x in (3.0, -6.0, 2.0))
            contact, rest, now = self.assert_eq7(centre, 3, asked, tuple(x / 8 for x in asked), d_max=0.875)
            self.assertAlmostEqual(float(np.linalg.norm(now[contact].astype(float) - rest[contact])), 0.875, places=5)


if __name__ == "__main__":
    unittest.main()
