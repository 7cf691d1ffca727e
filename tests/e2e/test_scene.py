#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scene files through the programs: every tolerance holds when it is measured again, and wishes decide the layers."""
import json
import os
import unittest

import meshes
import support

INFO = os.environ.get("DGM_INFO", "")

SCENE = """
[scene]
name = "test"
budget = "1MiB"

[defaults]
fit = "l2"
largest = "65x65"
tolerance = "0.5%"

[[asset]]
source = "torus.obj"
touched = true

[[asset]]
source = "sheet.obj"
name = "far/sheet"
tolerance = "2px"
distance = 10
lit = false
textured = false
"""


class SceneFiles(support.Folder):
    def setUp(self):
        super().setUp()
        meshes.write_obj(self.folder / "torus.obj", meshes.torus())
        meshes.write_obj(self.folder / "sheet.obj", meshes.sheet(12))

    def write(self, text):
        (self.folder / "scene.toml").write_text(text)

    def bake(self, *arguments):
        return self.run_program(support.BAKE, "scene.toml", "-o", "out", *arguments)

    def test_bakes_what_the_scene_asks_for(self):
        self.write(SCENE)
        result = self.bake("--report", "report.json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("scene test: ", result.stdout)
        report = json.loads((self.folder / "report.json").read_text())
        scene = report["scene"]
        self.assertEqual([a["name"] for a in scene["assets"]], ["torus", "far/sheet"])
        self.assertFalse(scene["over_budget"])
        self.assertLess(scene["bytes"], scene["one_size_bytes"] / 2)
        for asset in scene["assets"]:
            self.assertLessEqual(asset["reached_percent"], asset["asked_percent"])
            self.assertEqual(asset["bytes"], (self.folder / "out" / (asset["name"] + ".dgm")).stat().st_size)
        torus, sheet = scene["assets"]
        self.assertEqual(torus["asked_percent"], 0.5)
        self.assertGreater(torus["tick"]["median_seconds"], 0)
        self.assertNotIn("tick", sheet)
        # 2 px at 10 units, 60 degrees over 1080 rows.
        diagonal = next(a for a in report["assets"] if a["name"] == "far/sheet")["report"]["error"]["diagonal"]
        units = 2 * 2 * 10 * 3 ** -0.5 / 1080
        self.assertAlmostEqual(sheet["asked_percent"], 100 * units / diagonal, places=6)
        # Measured again by another program, within the same limit.
        for name, mesh, percent in (("torus", "torus.obj", 0.5), ("far/sheet", "sheet.obj", sheet["asked_percent"])):
            check = self.run_program(support.VALIDATE, f"out/{name}.dgm", "--source", mesh, "--max-rms", f"{percent}%")
            self.assertEqual(check.returncode, 0, check.stdout + check.stderr)
        self.assertEqual(self.layers("out/far/sheet.dgm") & {"normal", "texture", "bump", "collision", "contact"}, set())
        self.assertLessEqual({"normal", "collision", "deformation", "contact"}, self.layers("out/torus.dgm"))
        self.assertNotIn("bump", self.layers("out/torus.dgm"))

        again = self.bake("-v")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertIn("up to date", again.stdout)
        self.assertNotIn("tried", again.stderr)

    def layers(self, file):
        import h5py
        with h5py.File(self.folder / file) as data:
            return set(data["charts/0"])

    def test_plan_without_baking(self):
        self.write(SCENE)
        for result in (self.run_program(INFO, "scene.toml"), self.bake("--dry-run")):
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("torus <- torus.obj", result.stdout)
            self.assertIn("tolerance 2 px at distance 10 (1080 rows over 60 degrees): 0.0214 units rms", result.stdout)
            self.assertIn("layers geometry (not touched, no contact, not lit, no texture)", result.stdout)
        self.assertFalse((self.folder / "out").exists())

    def test_too_small_a_budget(self):
        self.write(SCENE.replace('"1MiB"', '"4KiB"'))
        result = self.bake()
        self.assertEqual(result.returncode, 3)
        self.assertIn("DGM3010", result.stderr)
        self.assertIn("4.1 kB", result.stderr)
        self.assertTrue((self.folder / "out" / "torus.dgm").exists(), "each asset holds what it was asked for")

    def test_tolerance_out_of_reach_is_one_failed_asset(self):
        self.write(SCENE.replace('source = "torus.obj"', 'source = "torus.obj"\ntolerance = "1e-7%"\nlargest = "9x9"'))
        result = self.bake()
        self.assertEqual(result.returncode, 3)
        self.assertIn("DGM3009", result.stderr)
        self.assertFalse((self.folder / "out" / "torus.dgm").exists())
        self.assertTrue((self.folder / "out" / "far" / "sheet.dgm").exists())

    def test_mistakes_are_told_with_their_place(self):
        self.write(SCENE.replace("touched = true", "tuched = true"))
        for result in (self.bake(), self.run_program(INFO, "scene.toml")):
            self.assertEqual(result.returncode, 3)
            self.assertIn("DGM6004", result.stderr)
            self.assertIn("scene.toml:13:1", result.stderr)
            self.assertIn("did you mean touched?", result.stderr)
        self.assertFalse((self.folder / "out").exists())

    def test_missing_source(self):
        self.write(SCENE.replace("torus.obj", "no.obj"))
        result = self.bake()
        self.assertEqual(result.returncode, 2)
        self.assertIn("DGM5001", result.stderr)
        self.assertTrue((self.folder / "out" / "far" / "sheet.dgm").exists())

    def test_command_line_beside_a_scene(self):
        self.write(SCENE)
        for extra in (["--size", "33"], ["torus.obj"], ["--max-error", "1%"], ["--layers", "normal"]):
            result = self.bake(*extra)
            self.assertEqual(result.returncode, 1, extra)
            self.assertIn("DGM6001", result.stderr)
        result = self.run_program(support.BAKE, "scene.toml", "-o", "x.dgm")
        self.assertEqual(result.returncode, 1)

    def test_an_output_never_overwrites_a_source(self):
        (self.folder / "out").mkdir()
        meshes.write_obj(self.folder / "out" / "torus.dgm", meshes.torus())
        self.write(SCENE.replace("torus.obj", "out/torus.dgm"))
        result = self.bake()
        self.assertEqual(result.returncode, 1)
        self.assertIn("overwrite", result.stderr)


if __name__ == "__main__":
    unittest.main()
