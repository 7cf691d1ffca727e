# SPDX-License-Identifier: GPL-3.0-or-later
"""What deform.h says of geodesic footprints, on organs: their weights beside those of exact geodesics (CGAL)."""
import unittest

import support

CONTACTS = 40


class Geodesic(support.Folder):
    def errors(self, organ):
        self.bake_well(f"{support.SAMPLES}/{organ}/{organ}.obj", "-o", "map.dgm", "--size", "129x129", "--method",
                       "stretch")
        result = self.run_program(support.GEODESIC_ERROR, self.folder / "map.dgm", str(CONTACTS))
        self.assertEqual(result.returncode, 0, result.stderr)
        count, *errors = result.stdout.split()
        print(f"{organ}: {count} contacts; median, 90th percentile and largest error: {' '.join(errors)}")
        self.assertGreater(int(count), CONTACTS * 3 // 4)
        return map(float, errors)

    def test_organs(self):
        for organ in ("stomach", "liver"):
            with self.subTest(organ):
                median, most, worst = self.errors(organ)
                self.assertLess(median, 0.005)
                self.assertLess(most, 0.02)
                self.assertLess(worst, 0.03)


if __name__ == "__main__":
    unittest.main()
