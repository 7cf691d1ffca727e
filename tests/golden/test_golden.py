# SPDX-License-Identifier: GPL-3.0-or-later
"""Did a bake change? Bakes the samples and compares with golden.json.

    test_golden.py DGM_BAKE SAMPLES METHOD

A refusal must keep its code. Topology, flips, degenerate faces and seam gaps must be equal. Errors and stretch may get
better, and worse only by what a different compiler or maths library may do to an iterative solver. Which method `auto`
picked is not compared: two candidates may be as good as each other, and the error of the winner is compared. Wanted
changes: scripts/update_golden.py.
"""
import json
import sys
import unittest

import golden

BAKE, SAMPLES, METHOD = sys.argv[1:4]
PSNR_LOSS = 0.5            # dB
PSNR_CAP = 120             # dB; beyond it (the flat sheet) the error is the rounding of f32
MAX_ERROR_GROWTH = 1.25    # one sample in one corner decides it
STRETCH_L2_GROWTH = 1.02
STRETCH_LINF_GROWTH = 1.25
EXACT = ("size", "flips", "degenerate", "seam_gap", "source_topology", "map_topology")


class Golden(unittest.TestCase):
    def test_bakes(self):
        kept = json.loads(golden.FILE.read_text(encoding="utf-8"))["bakes"][METHOD]
        found = golden.measure(BAKE, SAMPLES, METHOD)
        self.assertEqual(sorted(found), sorted(golden.CASES[METHOD]))
        self.assertEqual(sorted(found), sorted(kept), "run scripts/update_golden.py after a change of CASES")
        for name, charts in found.items():
            if isinstance(kept[name], str) or isinstance(charts, str):
                with self.subTest(sample=name):
                    self.assertEqual(charts, kept[name])
                continue
            self.assertEqual(len(charts), len(kept[name]), name)
            for k, (now, then) in enumerate(zip(charts, kept[name])):
                with self.subTest(sample=name, chart=k, method=now["method"], psnr=now["psnr"]):
                    self.compare(now, then)

    def compare(self, now, then):
        for key in EXACT:
            self.assertEqual(now[key], then[key], key)
        self.assertEqual((now["flips"], now["degenerate"], now["seam_gap"]), (0, 0, 0))
        self.assertEqual(now["map_topology"], now["source_topology"])
        self.assertGreaterEqual(now["psnr"], min(then["psnr"], PSNR_CAP) - PSNR_LOSS, "PSNR, dB")
        self.assertLessEqual(now["max_percent"], then["max_percent"] * MAX_ERROR_GROWTH + 1e-4, "largest distance, %")
        if now["method"] == then["method"]:
            self.assertLessEqual(now["stretch_l2"], then["stretch_l2"] * STRETCH_L2_GROWTH)
            self.assertLessEqual(now["stretch_linf"], then["stretch_linf"] * STRETCH_LINF_GROWTH)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
