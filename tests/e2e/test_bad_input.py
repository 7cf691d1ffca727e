# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad input and bad command lines: each its own message and exit code, and nothing left behind."""
import json
import math
import os
import time
import unittest
from pathlib import Path

import meshes
import support


class BadInput(support.Folder):
    def refuse(self, exit_code, code, words, *arguments):
        """Bakes and expects one story with this code and these words, no result, and no file that was not there."""
        before = self.names()
        result = self.bake(*arguments)
        self.assertEqual(result.returncode, exit_code, result.stdout + result.stderr)
        self.assertEqual(result.stdout, "")
        stories = [line for line in result.stderr.splitlines() if line.startswith("dgm-bake: ")]
        self.assertEqual(len(stories), 1, result.stderr)
        self.assertIn(f" DGM{code}: ", stories[0])
        for word in words:
            self.assertIn(word, result.stderr)
        self.assertIn("\n  next: ", result.stderr)
        self.assertEqual(self.names(), before)
        return result

    def sheet(self, name="sheet.obj"):
        return meshes.write_obj(self.folder / name, meshes.sheet(8))

    def test_missing_file(self):
        self.refuse(2, 5001, ["no-such.obj", "no such file"], "no-such.obj", "-o", "out")

    def test_empty_file(self):
        (self.folder / "empty.obj").touch()
        self.refuse(3, 3001, ["empty.obj"], "empty.obj", "-o", "out")

    def test_folder_without_meshes(self):
        (self.folder / "texts" / "deep").mkdir(parents=True)
        (self.folder / "texts" / "deep" / "notes.txt").write_text("no mesh\n")
        self.refuse(2, 5004, ["texts", "the folder holds no meshes"], "texts", "-o", "out")

    def test_polygons_that_crash_the_importer_of_off(self):
        circle = "".join(f"{math.cos(k):.6f} {math.sin(k):.6f} 0\n" for k in range(8000))
        for count in (700, 900, 8000):  # of corners: a line below 4096 bytes, one beyond, and one that crashed
            line = f"{count} " + " ".join(map(str, range(count))) + "\n"
            (self.folder / "a.off").write_text(f"OFF\n8000 1 0\n{circle}{line}")
            result = self.bake("a.off", "--size", "9", "--method", "tutte", "--fit", "sample")
            if len(line) <= 4096:
                self.assertNotIn("DGM3005", result.stderr)
            else:
                self.assertEqual(result.returncode, 3, result.stderr)
                self.assertRegex(result.stderr, r"DGM3005: a line of \d+ bytes")
            self.assertNotIn("DGM9002", result.stderr)
            self.assertTrue(self.workers_gone())

    def test_faces_on_one_edge(self):
        count = 70_000
        points = "".join(f"v {math.cos(k):.9f} {math.sin(k):.9f} 0.5\n" for k in range(count))
        faces = "".join(f"f 1 2 {k + 3}\n" for k in range(count))
        (self.folder / "fan.obj").write_text("v 0 0 0\nv 0 0 1\n" + points + faces)
        begun = time.monotonic()
        result = self.bake("fan.obj", "--size", "65")
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertIn("DGM3007", result.stderr)
        self.assertLess(time.monotonic() - begun, 30)

    def test_nan_only(self):
        (self.folder / "nan.obj").write_text("v nan nan nan\n" * 3 + "f 1 2 3\n")
        self.refuse(3, 3001, ["nan.obj"], "nan.obj", "-o", "out")

    def test_points_without_faces(self):
        (self.folder / "points.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
        self.refuse(3, 3001, ["points.obj"], "points.obj", "-o", "out")

    def test_read_only_output_folder(self):
        self.sheet()
        if os.getuid() == 0:
            # Permissions do not stop root. No one creates files at the top of sysfs.
            target = Path("/sys")
            if not target.is_dir():
                self.skipTest("root, and no sysfs")
        else:
            target = self.folder / "locked"
            target.mkdir()
            target.chmod(0o555)
        before = sorted(os.listdir(target))
        self.refuse(2, 5003, ["no file can be created"], "sheet.obj", "-o", str(target) + "/")
        self.assertEqual(sorted(os.listdir(target)), before)

    def test_output_folder_that_is_a_file(self):
        self.sheet()
        (self.folder / "taken").write_text("mine\n")
        self.refuse(2, 5003, ["taken by a file"], "sheet.obj", "-o", "taken")
        self.assertEqual((self.folder / "taken").read_text(), "mine\n")

    def test_output_folder_that_cannot_be_made(self):
        self.sheet()
        (self.folder / "taken").write_text("mine\n")
        self.refuse(2, 5003, ["cannot be made"], "sheet.obj", "-o", "taken/b/c")

    def test_output_name_is_a_folder(self):
        self.sheet()
        (self.folder / "out" / "sheet.dgm").mkdir(parents=True)
        self.refuse(2, 5003, ["taken by a folder"], "sheet.obj", "-o", "out")

    def test_unknown_method(self):
        self.sheet()
        self.refuse(1, 6001, ['there is no method "strech"', "did you mean stretch?", "lscm"],
                    "sheet.obj", "--method", "strech")

    def test_unknown_words(self):
        self.sheet()
        for option, value, words in [("--layers", "geometry,normals", ["did you mean normal?"]),
                                     ("--domain", "round", ["square, free"]),
                                     ("--fit", "worst", ["sample, l2, best"]),
                                     ("--precision", "f16", ["f32, u16"]),
                                     ("--format", "dgm,png", ['"png"']),
                                     ("--exr-layout", "scan", ["multipart"]),
                                     ("--ablate", "newton,brakes", ['"brakes"', "cut-search, newton"]),
                                     ("--progress", "loud", ["plain"]),
                                     ("--report-format", "xml", ["json"])]:
            with self.subTest(option=option):
                self.refuse(1, 6001, [option, *words], "sheet.obj", option, value)

    def test_bad_numbers(self):
        self.sheet()
        for option, value in [("--size", "0"), ("--size", "2"), ("--size", "99999"), ("--size", "33x"),
                              ("--size", "33x33x33"), ("--size", "-5"), ("--size", "1e2"), ("--size", "4294967299"),
                              ("--texture-size", "0"), ("--bump-size", "1"), ("--time-limit", "0"), ("--time-limit", "-1"),
                              ("--time-limit", "nan"), ("--memory-limit", "lots"), ("--memory-limit", "-1"),
                              ("--memory-limit", "1e999"), ("-j", "-1"), ("-j", "many")]:
            with self.subTest(option=option, value=value):
                self.refuse(1, 6001, [], "sheet.obj", f"{option}={value}" if option[:2] == "--" else option + value)

    def test_no_input_and_unknown_option(self):
        self.refuse(1, 6001, ["INPUT is required"])
        self.refuse(1, 6001, ["--frobnicate"], "sheet.obj", "--frobnicate", "1/2")

    def test_output_is_an_input(self):
        path = self.sheet("sheet.dgm")
        text = path.read_text()
        self.refuse(1, 6001, ["overwrite an input"], "sheet.dgm", "-o", "./sheet.dgm")
        self.assertEqual(path.read_text(), text)
        self.sheet("a.obj")
        self.refuse(1, 6001, ["like a mesh"], "a.obj", "-o", "b.obj")
        self.refuse(1, 6001, ["overwrite an input"], "a.obj", "-o", "out", "--report", "a.obj", "--report-format", "json")

    def test_one_file_for_several_assets(self):
        self.sheet("a.obj")
        self.sheet("b.obj")
        self.refuse(1, 6001, ["several assets"], "a.obj", "b.obj", "-o", "both.dgm")

    def test_missing_texture(self):
        self.sheet()
        self.refuse(2, 5001, ["denim.png"], "sheet.obj", "-o", "out", "--texture", "denim.png")

    def test_old_file_survives_a_refusal(self):
        (self.folder / "nan.obj").write_text("v nan nan nan\n" * 3 + "f 1 2 3\n")
        (self.folder / "nan.dgm").write_bytes(b"the good old file")
        self.refuse(3, 3001, [], "nan.obj")
        self.assertEqual((self.folder / "nan.dgm").read_bytes(), b"the good old file")


class Batch(support.Folder):
    def test_one_bad_asset_among_good_ones(self):
        source = self.folder / "in"
        (source / "sub").mkdir(parents=True)
        meshes.write_obj(source / "a.obj", meshes.sheet(8))
        meshes.write_obj(source / "b_line.obj", meshes.line())
        meshes.write_obj(source / "sub" / "c.OBJ", meshes.sheet(6))
        (source / ".hidden.obj").write_text("v nan nan nan\nf 1 1 1\n")
        result = self.bake("in", "gone.obj", "-o", "out", "--size", "17", "--report", "report.json")
        self.assertEqual(result.returncode, 2, result.stderr)  # the missing file is worse than the refused mesh
        self.assertEqual(self.names(self.folder / "out"), ["a.dgm", "sub", "sub/c.dgm"])
        self.assertEqual([line.split(":")[0] for line in result.stdout.splitlines()],
                         ["out/a.dgm", "out/sub/c.dgm", "4 assets"])
        self.assertIn("4 assets: 2 baked, 1 refused, 1 failed", result.stdout)
        self.assertIn("DGM3001", result.stderr)
        self.assertIn("DGM5001", result.stderr)

        report = json.loads((self.folder / "report.json").read_text())
        self.assertEqual(report["exit_code"], 2)
        self.assertEqual(report["summary"], {"assets": 4, "baked": 2, "up_to_date": 0, "refused": 1, "failed": 1,
                                             "interrupted": 0, "not_started": 0})
        self.assertEqual([asset["source"] for asset in report["assets"]],
                         ["in/a.obj", "in/b_line.obj", "in/sub/c.OBJ", "gone.obj"])
        baked = report["assets"][0]
        self.assertEqual(baked["files"][0]["bytes"], (self.folder / "out" / "a.dgm").stat().st_size)
        chart = baked["report"]["charts"][0]
        self.assertEqual((chart["rows"], chart["cols"]), (17, 17))
        self.assertEqual(chart["map"]["flips"], 0)
        error = baked["report"]["error"]
        self.assertAlmostEqual(error["rms_percent"], 100 * error["rms"] / error["diagonal"], places=12)
        self.assertEqual(report["assets"][1]["error"]["code"], "DGM3001")
        self.assertEqual(report["assets"][1]["error"]["exit_code"], 3)

    def test_colliding_names_go_below_their_folders(self):
        for folder, names in [("a", ["x.obj", "y.obj"]), ("b", ["x.obj"])]:
            (self.folder / folder).mkdir()
            for name in names:
                meshes.write_obj(self.folder / folder / name, meshes.sheet(4))
        (self.folder / "a" / "x.3ds").write_bytes(b"MM")
        result = self.bake("a", "b", "-o", "out", "--dry-run")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stdout.splitlines(), ["a/x.3ds -> out/x.3ds.dgm", "a/x.obj -> out/a/x.dgm",
                                                      "a/y.obj -> out/y.dgm", "b/x.obj -> out/b/x.dgm"])
        self.assertFalse((self.folder / "out").exists())

    def test_a_file_named_twice_is_baked_once(self):
        meshes.write_obj(self.folder / "x.obj", meshes.sheet(4))
        result = self.bake("x.obj", "./x.obj", self.folder, "--dry-run")
        self.assertEqual(result.stdout, "x.obj -> x.dgm\n")

    def test_stop_on_error(self):
        meshes.write_obj(self.folder / "b.obj", meshes.sheet(4))
        result = self.bake("gone.obj", "b.obj", "-o", "out", "-j1", "--stop-on-error")
        self.assertEqual(result.returncode, 2)
        self.assertIn("1 failed, 1 not started", result.stdout)
        self.assertFalse((self.folder / "out").exists())

    def test_quiet_and_verbose(self):
        meshes.write_obj(self.folder / "x.obj", meshes.sheet(4))
        quiet = self.bake_well("x.obj", "--size", "9", "-q")
        self.assertEqual((quiet.stdout, quiet.stderr), ("", ""))
        verbose = self.bake_well("x.obj", "--size", "9", "-v", "--force")
        self.assertRegex(verbose.stdout.splitlines()[0],
                         r"^x\.dgm: [a-z ]+, max \S+ % \(\S+ units\), rms \S+ % \(\S+ units\), \w+ 9x9, \S+ kB, \d+\.\d s")
        self.assertRegex(verbose.stdout.splitlines()[1], r"^  \d+\.\d dB, 0 flips, \d+ turned faces?, seam gap 0$")
        self.assertIn("chart 0: ", verbose.stdout)
        again = self.bake_well("x.obj", "--size", "9", "-v")
        self.assertRegex(again.stdout, r"^x\.dgm: up to date, [a-z ]+, max \S+ % \(\S+ units\), rms \S+ % \(\S+ units\), \S+ kB\n")
        self.assertIn("chart 0: ", again.stdout)

    def test_help_and_version(self):
        version = self.bake_well("--version")
        self.assertRegex(version.stdout, r"^dgm-bake \d+\.\d+\.\d+( \(.*\))?\n$")
        for method in ["stretch", "sphere", "mvc", "authalic", "conformal", "tutte", "lscm", "arap", "slim", "uv"]:
            self.assertIn(method, self.bake_well("--help").stdout)


if __name__ == "__main__":
    unittest.main()
