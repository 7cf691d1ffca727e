# SPDX-License-Identifier: GPL-3.0-or-later
"""Promises of deform.h about footprints, on baked maps of several kinds: beside exact geodesics (CGAL), worst case first."""
import json
import unittest

import support

CONTACTS = "24"
MAPS = {  # sample, options: closed and open, square and free, coarse and fine, two cuts
    "stomach_81": ("stomach/stomach.obj", "--size", "81x81", "--method", "stretch"),
    "stomach_33": ("stomach/stomach.obj", "--size", "33x33", "--method", "sphere"),
    "liver_129": ("liver/liver.obj", "--size", "129x129"),
    "cover_81": ("cushion/cover.obj", "--size", "81x81"),
    "cushion_arap": ("cushion/cushion.obj", "--size", "65x65", "--method", "arap"),
}
LARGEST = {"surface": 0.10, "geodesic": 0.02}


class Footprints(support.Folder):
    def figures(self, name):
        mesh, *options = MAPS[name]
        self.bake_well(f"{support.SAMPLES}/{mesh}", "-o", "map.dgm", "--fit", "l2", *options)
        result = self.run_program(support.FOOTPRINT_ERROR, self.folder / "map.dgm", CONTACTS, "16", "11")
        self.assertEqual(result.returncode, 0, result.stderr)
        return [json.loads(line) for line in result.stdout.splitlines()]

    def test_promises(self):
        for name in MAPS:
            with self.subTest(name):
                lines = self.figures(name)
                self.assertTrue({line["footprint"] for line in lines} >= {"surface", "geodesic", "grid"})
                for line in lines:
                    print(name, line)
                    self.assertEqual(line["torn"], 0, line)
                    if line["footprint"] == "grid":
                        continue
                    self.assertLess(line["largest"], LARGEST[line["footprint"]], line)
                    self.assertLess(line["farthest"], 1.25, line)
                    self.assertLess(line["half"], 1.25, line)
                    self.assertLess(line["jump"], 1.5, line)
                    self.assertEqual(line["truncated"], 0, line)


if __name__ == "__main__":
    unittest.main()
