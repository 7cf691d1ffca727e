# SPDX-License-Identifier: GPL-3.0-or-later
"""Asking by error, by file size and by number of samples: what was promised is measured again."""
import json
import math
import unittest

import meshes
import support


def bumpy_ball(subdivisions=3):
    """A closed surface with bumps that no small grid holds."""
    vertices, faces = meshes.icosphere(subdivisions)
    scaled = [tuple(c * (1 + 0.1 * math.sin(5 * x) * math.sin(4 * y) * math.cos(3 * z)) for c in (x, y, z))
              for x, y, z in vertices]
    return scaled, faces


def long_sheet():
    """A wavy strip four times as long as wide, waves along it."""
    n, m = 96, 24
    vertices = [(4 * i / n, j / m, 0.1 * math.sin(12 * i / n) + 0.03 * math.cos(4 * j / m))
                for i in range(n + 1) for j in range(m + 1)]
    faces = []
    for i in range(n):
        for j in range(m):
            a, b = i * (m + 1) + j, (i + 1) * (m + 1) + j
            faces += [(a, b, b + 1), (a, b + 1, a + 1)]
    return vertices, faces


class Ask(support.Folder):
    def setUp(self):
        super().setUp()
        meshes.write_obj(self.folder / "ball.obj", bumpy_ball())
        meshes.write_obj(self.folder / "sheet.obj", meshes.sheet(48))

    def report(self, source, *arguments):
        """Bakes to x.dgm; the asset's report."""
        self.bake_well(source, "-o", "x.dgm", "--report", "report.json", *arguments)
        asset = json.loads((self.folder / "report.json").read_text())["assets"][0]
        self.assertEqual(asset["files"][0]["bytes"], (self.folder / "x.dgm").stat().st_size)
        return asset["report"]

    def holds(self, file, source, *limits):
        result = self.run_program(support.VALIDATE, file, "--source", source, *limits)
        self.assertIn(result.returncode, (0, 3), result.stdout + result.stderr)
        return result.returncode == 0

    def refused(self, code, *arguments):
        result = self.bake(*arguments, "-o", "out.dgm")
        self.assertEqual(result.returncode, 3, result.stdout + result.stderr)
        self.assertIn(f" DGM{code}: ", result.stderr)
        self.assertIn("  next: ", result.stderr)
        self.assertEqual(self.names(), ["ball.obj", "sheet.obj"])
        return result.stderr

    def test_the_asked_error_is_held_and_the_next_smaller_grid_does_not(self):
        for source, asked in (("ball.obj", 0.1), ("sheet.obj", 0.02)):
            with self.subTest(source=source):
                search = self.report(source, "--max-error", f"{asked}%", "--fit", "sample")["search"]
                self.assertEqual(search["goal"], "max-error")
                self.assertAlmostEqual(search["asked_percent"], asked, places=12)
                self.assertLessEqual(search["reached_percent"], asked)
                self.assertTrue(self.holds("x.dgm", source, "--max-rms", f"{asked}%"))
                smaller = search["next"]
                self.assertLess(smaller["rows"] * smaller["cols"], search["rows"] * search["cols"])
                self.assertGreater(smaller["rms"] * 1.01, search["asked"])
                self.assertGreater(smaller["rows"] * smaller["cols"], 0.8 * search["rows"] * search["cols"])
                self.assertIn(smaller, search["trials"])
        # The sheet has no cut to find, so the smaller grid is the same surface when it is baked by name.
        self.bake_well("sheet.obj", "-o", "y.dgm", "--size", f"{smaller['rows']}x{smaller['cols']}",
                       "--fit", "sample")
        self.assertTrue(self.holds("y.dgm", "sheet.obj"))
        self.assertFalse(self.holds("y.dgm", "sheet.obj", "--max-rms", f"{asked / 1.011}%"))

    def test_quantised_positions_and_the_largest_distance_count(self):
        search = self.report("ball.obj", "--max-error", "0.5%", "--max-error-kind", "hausdorff", "--precision", "u16",
                             "--fit", "l2")["search"]
        self.assertEqual(search["kind"], "hausdorff")
        self.assertTrue(self.holds("x.dgm", "ball.obj", "--max-hausdorff", "0.5%"))

    def test_source_units(self):
        report = self.report("sheet.obj", "--max-error", "0.001", "--size", "129x65", "--fit", "sample")
        self.assertEqual(report["search"]["asked"], 0.001)
        self.assertLessEqual(report["error"]["rms"], 0.001)
        self.assertLessEqual(report["search"]["rows"], 129)
        # The cap's aspect is the ladder's.
        rows, cols = report["search"]["rows"] - 1, report["search"]["cols"] - 1
        self.assertAlmostEqual(rows / cols, 2, delta=0.25)

    def test_the_report_says_what_speed_costs(self):
        report = self.report("sheet.obj", "--max-error", "0.05%")
        for trial in report["search"]["trials"] + report["search"]["shapes"]:
            self.assertGreater(trial["cpu_seconds"], 0)
        for candidate in report["charts"][0]["candidates"]:
            self.assertGreater(candidate["cpu_seconds"], 0)
            self.assertGreater(candidate["psnr"], 0)
        stages = [time["stage"] for time in report["times"]]
        self.assertIn("measure", stages)
        self.assertLessEqual(sum(time["cpu_seconds"] for time in report["times"]), report["cpu_seconds"])
        self.assertGreater(sum(time["cpu_seconds"] for time in report["times"]), 0.5 * report["cpu_seconds"])

    def test_out_of_reach(self):
        story = self.refused(3009, "ball.obj", "--max-error", "0.01%", "--size", "33")
        self.assertIn("0.01 % of the diagonal) was asked for; 33x33 reaches", story)
        self.refused(3010, "ball.obj", "--budget", "1000")
        self.refused(3010, "ball.obj", "--max-error", "0.05%", "--budget", "30kB")

    def test_the_budget_is_held_by_the_file(self):
        for budget, size in (("100KiB", 102400), ("250kB", 250000)):
            for layers in ((), ("--layers", "geometry,normal")):
                search = self.report("ball.obj", "--budget", budget, *layers)["search"]
                self.assertEqual(search["asked_bytes"], size)
                self.assertLessEqual((self.folder / "x.dgm").stat().st_size, size)
                larger = search["next"]
                self.assertGreater(larger["bytes"], size)
                self.bake_well("ball.obj", "-o", "y.dgm", "--size", f"{larger['rows']}x{larger['cols']}", *layers)
                self.assertGreater((self.folder / "y.dgm").stat().st_size, 0.97 * size)

    def test_a_number_of_samples_takes_the_shape_of_the_surface(self):
        meshes.write_obj(self.folder / "long.obj", long_sheet())
        report = self.report("long.obj", "--size", "auto:4225", "--domain", "square")
        rows, cols = report["charts"][0]["rows"], report["charts"][0]["cols"]
        self.assertLessEqual(rows * cols, 4225)
        self.assertGreater(rows * cols, 0.9 * 4225)
        self.assertGreater(max(rows, cols) / min(rows, cols), 1.9)
        square = self.report("long.obj", "--size", "65", "--domain", "square")
        self.assertLess(report["error"]["rms"], square["error"]["rms"])

    def test_the_same_question_has_the_same_answer(self):
        for name in ("one", "two"):
            self.bake_well("ball.obj", "-o", f"{name}.dgm", "--max-error", "0.3%", "--budget", "1MB",
                           "-j", "1" if name == "one" else "2")
        self.assertEqual((self.folder / "one.dgm").read_bytes(), (self.folder / "two.dgm").read_bytes())


if __name__ == "__main__":
    unittest.main()
