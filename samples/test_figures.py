# SPDX-License-Identifier: GPL-3.0-or-later
"""Replays two of the paper's figures on small maps: what is drawn, what is told, what is refused.

    test_figures.py PRESS_AND_PULL PINCH_SHEET POKE_AND_LET_GO SWING_ORGAN LAY_ON_TABLE DRAPE_CLOTH WALK_IN_SKIRT
        DGM_BAKE SAMPLES PATHS
"""
import re
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PRESS, PINCH, POKE, SWING, LAY, DRAPE, WALK, BAKE = sys.argv[1:9]
SAMPLES, PATHS = Path(sys.argv[9]), Path(sys.argv[10])


class Figures(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="figures-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def bake(self, mesh, *options, size="65x65"):
        map_file = self.folder / (Path(mesh).stem + ".dgm")
        subprocess.run([BAKE, "-q", SAMPLES / mesh, "-o", map_file, "--size", size, *options], check=True,
                       timeout=200)
        return map_file

    def sample(self, program, *arguments):
        return subprocess.run([program, *arguments], timeout=200, capture_output=True, text=True, check=False)

    def told_by(self, pattern, program, *arguments):
        """What a sample says that works: the match of all of it."""
        result = self.sample(program, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        told = re.fullmatch(pattern, result.stdout)
        self.assertIsNotNone(told, result.stdout)
        return told

    def size_of(self, picture):
        data = picture.read_bytes()
        self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
        return struct.unpack(">II", data[16:24])

    def test_pinched_sheet(self):
        sheet, picture = self.bake("sheet/sheet.obj"), self.folder / "a.png"
        result = self.sample(PINCH, sheet, PATHS / "sheet_pinch.txt", picture)
        self.assertEqual(result.returncode, 0, result.stderr)
        width, height = self.size_of(picture)
        self.assertEqual(width, 2 * 640)
        self.assertEqual(height % 2, 0)  # two kernels, a row each
        flat = self.folder / "flat.txt"
        flat.write_text("0 0 0 9 away\n1 0 0 9 away up\n2 0 0 9 away down\n", encoding="ascii")
        still = self.folder / "b.png"
        self.assertEqual(self.sample(PINCH, sheet, flat, still).returncode, 0)
        self.assertNotEqual(picture.read_bytes(), still.read_bytes())

    def test_poked_liver_swings_back(self):
        picture = self.folder / "a.png"
        liver = self.bake("liver/liver.obj", "--unit", "cm", "--material", "tissue")
        told = self.told_by(r"1701 steps of 1 ms, strongest force ([\d.]+) N, volume kept to (\S+); "
                            r"at the end (\S+) of (\S+) J left, (\S+) cm from rest\n",
                            POKE, liver, PATHS / "liver_poke_and_let_go.txt", picture)
        self.assertGreater(float(told[1]), 0.1)
        self.assertLess(float(told[1]), 100)
        self.assertLess(float(told[2]), 1e-8)
        # It is back but for a dent or two that have snapped through (docs/physics.md).
        self.assertLess(float(told[3]), 0.05 * float(told[4]))
        self.assertLess(float(told[5]), 0.5)
        self.assertEqual(self.size_of(picture)[0], 4 * 400)
        # A map without a unit is refused, with the remedy.
        result = self.sample(POKE, self.bake("liver/liver.obj"), PATHS / "liver_poke_and_let_go.txt", picture)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("--unit", result.stderr)

    def test_sheet_on_a_seat(self):
        options = ("--domain", "square", "--unit", "cm")
        sheet = self.bake("sheet/sheet.obj", *options, size="33x33")
        seat = self.bake("chair/seat.obj", *options, size="33x33")
        picture = self.folder / "a.png"
        told = self.told_by(r"150 frames; at the end (\d+) samples bear, (\S+) J of motion, \d+ places kept apart at most, "
                            r"([\d.]+) cm deep\n",
                            DRAPE, sheet, seat, picture, "40")
        self.assertGreater(int(told[1]), 50)
        self.assertLess(float(told[2]), 2e-3)  # a sheet of 0.1 kg that fell by 10 cm had 0.1 J
        self.assertLess(float(told[3]), 0.1)
        self.assertEqual(self.size_of(picture)[0], 3 * 480)

    def test_skirt_on_hips_that_walk(self):
        picture = self.folder / "a.png"
        told = self.told_by(r"240 frames; at most (\d+) samples bear, ([\d.]+) cm deep; hem between -([\d.]+) and "
                            r"-([\d.]+) cm\n",
                            WALK, self.bake("skirt/skirt.obj", "--unit", "cm", "--fit", "sample", size="17x65"), picture)
        self.assertGreater(int(told[1]), 20)
        self.assertLess(float(told[2]), 0.1)
        # 48 cm along the slope: it hangs lower than the 45 at rest, and threads stretch little.
        self.assertGreater(float(told[4]), 42)
        self.assertLess(float(told[3]), 50)
        self.assertEqual(self.size_of(picture)[0], 4 * 400)

    def test_stomach_with_weight(self):
        stomach = self.bake("stomach/stomach.obj", "--unit", "cm", "--material", "tissue", size="33x33")
        picture = self.folder / "a.png"
        told = self.told_by(r"4201 steps of 1 ms, strongest force ([\d.]+) N, volume kept to (\S+), (\S+) J of motion "
                            r"at the end\n",
                            SWING, stomach, PATHS / "stomach_swung.txt", picture)
        # 550 cm2 of 5 kg/m2 weigh 2.7 N; swung by 3.5 cm at 1 Hz it pulls up to three times as strongly.
        self.assertGreater(float(told[1]), 2.7)
        self.assertLess(float(told[1]), 9)
        self.assertLess(float(told[2]), 1e-7)
        self.assertLess(float(told[3]), 0.02)
        self.assertEqual(self.size_of(picture)[0], 6 * 300)
        result = self.sample(LAY, stomach, PATHS / "stomach_on_table.txt", picture)
        self.assertEqual(result.returncode, 0, result.stderr)
        touching = [int(n) for n in re.findall(r": (\d+) samples touch", result.stdout)]
        self.assertEqual(len(touching), 6, result.stdout)
        self.assertEqual(touching[0], 0)  # in the air
        self.assertGreater(touching[3], 10)  # by its own weight
        self.assertGreater(touching[4], touching[3])  # and a ball's
        told = re.search(r"and let be: \d+ samples touch, (\S+) J of motion\n3101 steps of 1 ms, strongest force "
                         r"[\d.]+ N, volume kept to (\S+)\n$", result.stdout)
        self.assertIsNotNone(told, result.stdout)
        self.assertLess(float(told[1]), 1e-3)
        self.assertLess(float(told[2]), 1e-7)
        self.assertEqual(self.size_of(picture)[0], 3 * 500)

    def test_pressed_stomach(self):
        stomach, picture = self.bake("stomach/stomach.obj", "--method", "mvc"), self.folder / "a.png"
        path = self.folder / "short.txt"
        path.write_text("0 4 -6 0 touch\n0.05 4 -1.5 0 touch pressed\n", encoding="ascii")
        told = self.told_by(r"51 ticks, (\d+) samples .*, strongest force ([\d.]+) N\n",
                            PRESS, stomach, path, picture)
        self.assertGreater(int(told[1]), 20)
        # The front wall is at y = -3: one to two and a half centimetres deep of five. Eqs. 8-10: 3 N (d / 5)^3.
        self.assertGreater(float(told[2]), 0.024)
        self.assertLess(float(told[2]), 0.375)
        self.assertEqual(self.size_of(picture)[0], 400)

    def test_refusals(self):
        sheet, picture = self.bake("sheet/sheet.obj"), self.folder / "a.png"
        path = self.folder / "bad.txt"
        for text, message in (("0 0 0 0 grasp\n1 0 0 grasp\n", ":2: "), ("0 0 0 0 wave\n", "wave"),
                              ("1 0 0 0 poke\n1 0 0 1 poke\n", "increase"), ("# nothing\n", "empty"),
                              ("1e9 0 0 0 poke\n", "hour")):
            path.write_text(text, encoding="ascii")
            result = self.sample(PINCH, sheet, path, picture)
            self.assertEqual(result.returncode, 1, text)
            self.assertIn(message, result.stderr)
        self.assertEqual(self.sample(PINCH, path, path, picture).returncode, 3)
        self.assertEqual(self.sample(PINCH, sheet, self.folder / "none.txt", picture).returncode, 2)
        path.write_text("0 nan 0 0 grasp\n", encoding="ascii")
        self.assertNotEqual(self.sample(PINCH, sheet, path, picture).returncode, 0)
        self.assertFalse(picture.exists())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
