# SPDX-License-Identifier: GPL-3.0-or-later
"""dgm-bench: what a sweep leaves behind, and its page in a browser."""
import csv
import json
import re
import socket
import unittest
from pathlib import Path

import numpy
from browser import run_browser, screenshot
from support import BENCH, SAMPLES, Folder

SHEET = Path(SAMPLES) / "sheet" / "sheet.obj"


class Bench(Folder):
    def bench(self, *arguments, code=0):
        result = self.run_program(BENCH, *arguments)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result

    def sweep(self, out, *more):
        return self.bench("bake", SHEET, "--sizes", "9,17", "--methods", "auto,tutte", "--fits", "sample,l2",
                          "--precisions", "f32", "--layers", "all", "--repeat", "3", "-o", out, *more)

    def read(self, name):
        return json.loads((self.folder / name).read_text(encoding="utf-8"))

    def test_bake_leaves_csv_json_and_page(self):
        said = self.sweep("out")
        self.assertRegex(said.stdout, r"sheet\.obj: for .* % rms use \d+x\d+ \w+ f32 fit \w+: ")
        self.assertEqual(self.names(self.folder / "out"), ["bake-facts.csv", "bake.csv", "bake.html", "bake.json"])
        run = self.read("out/bake.json")
        self.assertNotIn(socket.gethostname(), json.dumps(run["machine"]).split('"'))
        self.assertGreater(int(run["machine"]["cores"]), 0)
        table = run["tables"][0]
        keys = [c["key"] for c in table["columns"]]
        rows = [dict(zip(keys, row)) for row in table["rows"]]
        paper = [row for row in rows if row["point"] == "paper"]
        self.assertEqual([(r["grid"], r["fit"]) for r in paper], [("81x81", "sample")])
        for row in rows:
            cpu = row["cpu_seconds"]
            self.assertEqual(cpu["n"], 3)
            self.assertLess(cpu["low"], cpu["median"])
            self.assertGreater(cpu["high"], cpu["median"])
            self.assertEqual(row["flips"], 0)
            self.assertLess(row["rms_percent"], 1e-3)  # a flat sheet
            self.assertGreater(row["bytes"], row["geometry_bytes"])
        by_grid = {row["grid"]: row["geometry_bytes"] for row in rows if row["method"] == "auto"}
        self.assertEqual(by_grid["17x17"] // 17 ** 2, 12)  # three floats a sample, a diagonal bit a quad
        with open(self.folder / "out/bake.csv", encoding="utf-8", newline="") as file:
            lines = list(csv.DictReader(file))
        self.assertEqual([float(line["cpu_seconds"]) for line in lines], [row["cpu_seconds"]["median"] for row in rows])
        self.assertEqual({line["cpu_seconds_n"] for line in lines}, {"3"})

    def test_compare_tells_of_changes_only(self):
        self.sweep("one")
        run = self.read("one/bake.json")
        table = run["tables"][0]
        keys = [c["key"] for c in table["columns"]]
        for row in table["rows"]:  # an older program: ten times slower, files twice as large
            row[keys.index("bytes")] *= 2
            cpu = row[keys.index("cpu_seconds")]
            for key in ("median", "low", "high"):
                cpu[key] *= 10
        (self.folder / "old.json").write_text(json.dumps(run), encoding="utf-8")
        said = self.sweep("two", "--compare", "old.json").stdout
        rows = len(table["rows"])
        self.assertEqual(len(re.findall(r"^smaller: .* file: ", said, re.M)), rows)
        self.assertGreater(len(re.findall(r"^faster: .* bake CPU: ", said, re.M)), rows // 2)
        self.assertEqual(re.findall(r"^(?:better|worse): .* rms: ", said, re.M), [])
        self.look_at_page(self.folder / "two" / "bake.html")
        self.assertRegex(said, r"\d+ changed; \d+ within the noise; \d+ taken fewer than 3 times, so nothing is said; 0 points")

    def test_one_run_gives_no_ratio(self):
        once = ("bake", SHEET, "--sizes", "9", "--methods", "auto", "--repeat", "1")
        self.bench(*once, "-o", "one")
        said = self.bench(*once, "-o", "two", "--compare", "one/bake.json").stdout
        self.assertEqual(re.findall(r"^(?:faster|slower): .* bake ", said, re.M), [])

    def test_wrong_words_are_told_at_once(self):
        self.bench("bake", SHEET, "--methods", "magic", code=1)
        self.bench("bake", "missing.obj", code=2)
        (self.folder / "bad.json").write_text("{}", encoding="utf-8")
        self.bench("bake", SHEET, "--compare", "bad.json", code=1)
        self.bench("stability", "--families", "nonsense", code=1)
        (self.folder / "bad.path").write_text("1 2 3\n4 5\n", encoding="utf-8")
        said = self.bench("run", SHEET, "--path", "bad.path", "--ticks", "1000", code=2).stderr
        self.assertIn("bad.path:2", said)
        (self.folder / "tools.txt").write_text("0 1 2 3 touch\n0 1 2 3 touch:2\n0.1 1 2 3 touch:9\n", encoding="utf-8")
        said = self.bench("run", SHEET, "--path", "tools.txt", "--ticks", "1000", code=1).stderr
        self.assertIn("tools.txt:3", said)
        self.assertIn("touch:9", said)

    def test_run_moves_all_tools_of_a_path(self):
        # Two places of the sheet: the first tool is below it all the time, the second one in one tick of three.
        first, second = "{0} 10 10 -1 touch\n", "{0} 30 10 {1} grasp:2\n"
        found = {}
        for name, lines in (("one.txt", first.format(0) + first.format(.002)),
                            ("two.txt", first.format(0) + second.format(0, -1) + first.format(.002) + second.format(.002, 1))):
            (self.folder / name).write_text(lines, encoding="utf-8")
            self.bench("run", SHEET, "--sizes", "81", "--ticks", "1500", "--path", name, "-o", name[:3])
            table = next(t for t in self.read(f"{name[:3]}/run.json")["tables"] if t["key"] == "ticks")
            rows = [dict(zip([c["key"] for c in table["columns"]], row)) for row in table["rows"]]
            found[name] = next(row for row in rows if row["setting"] == "recorded path")
        self.assertAlmostEqual(found["one.txt"]["hit_share"], 1, delta=.01)
        self.assertAlmostEqual(found["two.txt"]["hit_share"], 2 / 3, delta=.01)
        # Places off the grid differ by a few samples.
        self.assertAlmostEqual(found["two.txt"]["samples"] / found["one.txt"]["samples"], 2, delta=.02)

    def test_run_compares_with_exact_answers(self):
        (self.folder / "strokes").write_text("# x y z\n10 10 0.5\n11 10 -0.5\n12 10 -1\n", encoding="utf-8")
        self.bench("run", SHEET, "--sizes", "81", "--ticks", "2000", "--path", "strokes", "-o", "out")
        tables = {t["key"]: [dict(zip([c["key"] for c in t["columns"]], row)) for row in t["rows"]]
                  for t in self.read("out/run.json")["tables"]}
        ticks = {row["setting"]: row for row in tables["ticks"]}
        self.assertEqual((ticks["paper"]["grid"], ticks["paper"]["rule"], ticks["paper"]["end"]),
                         ("81x81", "printed", "printed"))
        self.assertTrue(all(row["wrong_nearest"] == 0 for row in tables["ticks"]))
        self.assertLess(ticks["paper"]["table_error"], 1e-6)
        # On a flat sheet the grid's distance is the surface's: what is left is the end at b, exp(-121/16) = 5e-4.
        self.assertLess(ticks["paper"]["inside_error_max"], 2e-3)
        self.assertLess(ticks["smooth force"]["force_jump"], ticks["paper"]["force_jump"])
        recorded = ticks["recorded path"]
        self.assertAlmostEqual(recorded["hit_share"], 2 / 3, delta=0.01)  # two of its three points are below the sheet
        self.assertEqual({row["path"] for row in tables["tracking"]}, {"stroke", "random", "recorded"})
        tracking = {(row["search"], row["a"], row["path"]): row["missed_share"] for row in tables["tracking"]}
        self.assertEqual(tracking["window, certified", "4", "random"], 0)
        self.assertEqual(tracking["pyramid", "", "random"], 0)
        self.assertGreater(tracking["window", "1", "random"], 0)  # leaps are lost
        levels = {row["stride"]: row for row in tables["levels"]}
        self.assertEqual(levels["1"]["rms_percent"], 0)
        self.assertLess(levels["4"]["triangles"], levels["1"]["triangles"] / 4)
        kernels = {(row["way"], row["entries"]): row["error"] for row in tables["kernels"]}
        self.assertLess(kernels["table, linear", "1024"], kernels["table, nearest", "1024"] / 10)

    def rows(self, run, key):
        table = next(t for t in run["tables"] if t["key"] == key)
        return [dict(zip([c["key"] for c in table["columns"]], row)) for row in table["rows"]]

    def test_without_an_asset_the_sample_is_measured(self):
        few = ("--sizes", "9", "--methods", "auto", "--fits", "l2", "--precisions", "f32", "--layers", "all", "--repeat", "1")
        self.bench("bake", *few, "-o", "made")
        self.bench("bake", Path(SAMPLES) / "stomach" / "stomach.obj", *few, "-o", "named")
        made, named = (self.rows(self.read(f"{out}/bake.json"), "bake") for out in ("made", "named"))
        for row in made + named:  # what a clock or a scheduler may change
            for key in [k for k in row if k.endswith(("_seconds", "_ms", "_mib"))]:
                del row[key]
        self.assertEqual([row["asset"] for row in made], ["stomach.obj"] * len(made))
        self.assertEqual(made, named)  # the very sample of dgm-make-samples: same bytes, same errors
        self.assertEqual(self.read("made/bake.json")["settings"]["asset"], "the sample stomach of dgm-make-samples")
        for file in (self.folder / "made").iterdir():  # nothing of where it was made
            self.assertNotIn("/tmp", file.read_text(encoding="utf-8"), file.name)

        self.bench("run", "--sizes", "81", "--ticks", "1000", "-o", "pressed")
        ticks = self.rows(self.read("pressed/run.json"), "ticks")
        self.assertEqual({(row["asset"], row["grid"]) for row in ticks}, {("stomach.obj", "81x81")})
        self.assertIn("made on the spot", " ".join(self.bench("bake", "--help").stdout.split()))

    def test_its_own_recording_presses_any_mesh(self):
        self.bench("run", SHEET, "--sizes", "81", "--ticks", "4000", "-o", "out")
        recorded = next(row for row in self.rows(self.read("out/run.json"), "ticks") if row["path"] == "recorded")
        # The share of the lines of samples/paths/recorded_touch.csv that are below the surface.
        lines = (Path(__file__).resolve().parents[2] / "samples/paths/recorded_touch.csv").read_text().splitlines()[1:]
        below = sum(float(line.split(",")[3]) < 0 for line in lines) / len(lines)
        self.assertGreater(below, 0.2)
        self.assertAlmostEqual(recorded["hit_share"], below, delta=0.1)
        self.assertEqual(recorded["wrong_nearest"], 0)

    def test_cloth_hangs_as_the_closed_form_says(self):
        arguments = ("cloth", "--sizes", "17,33", "--substeps", "1,2", "--cycles", "1", "--frames", "100")
        said = self.bench(*arguments, "--levels", "0,1", "-o", "out").stdout
        self.assertRegex(said, r"33x33, 1 substeps, 1 cycles, all levels: p50 [\d.]+ us a frame, stretch 0\.0049 %, exactly 0\.0049 %")
        self.assertEqual(self.names(self.folder / "out"), ["cloth-drape.csv", "cloth-facts.csv", "cloth.csv", "cloth.html", "cloth.json"])
        rows = self.rows(self.read("out/cloth.json"), "cloth")
        self.assertEqual([(row["grid"], row["substeps"], row["levels"]) for row in rows],
                         [(grid, h, k) for grid in ("17x17", "33x33") for k in ("all", "1") for h in ("1", "2")])
        for row in rows:
            self.assertAlmostEqual(row["exact_percent"], 100 * 0.2 * 9.81 / (2 * 20000), delta=1e-9)
            self.assertLess(row["off_percent"], 1e-4, "a thousandth of the 0.1 % that are asked for")
            self.assertGreater(row["off_percent"], 0)
            self.assertLess(row["energy_rise"], 1e-4)
            self.assertGreater(row["p50_us"]["median"], 0)
        rows = self.rows(self.read("out/cloth.json"), "drape")
        things = ("plane", "sphere", "surface", "surface that goes", "surface, itself")
        self.assertEqual([(row["grid"], row["below"], row["substeps"]) for row in rows],
                         [(grid, on, h) for grid in ("17x17", "33x33") for on in things for h in ("1", "2")])
        for row in rows:
            self.assertGreater(row["contacts"], 0)
            self.assertGreater(row["p50_us"]["median"], 0)
            if row["below"] != "surface, itself":
                self.assertEqual(row["touches"], 0)
        whole = {row["grid"]: row["contacts"] for row in rows if row["below"] == "plane"}
        self.assertEqual(whole, {"17x17": 17 * 17, "33x33": 33 * 33})
        self.bench(*arguments, "--modulus", "200", "-o", "soft")
        for row in self.rows(self.read("soft/cloth.json"), "cloth"):
            self.assertAlmostEqual(row["exact_percent"], 0.4905, delta=1e-6)
            self.assertLess(row["off_percent"], 0.005)
        for wrong in (("--cycles", "0"), ("--modulus", "0"), ("--frames", "99"), ("--sizes", "2")):
            self.assertIn("DGM6001", self.bench("cloth", *wrong, code=1).stderr)

    def test_physics_comes_nearer_with_every_cycle(self):
        said = self.bench("physics", Path(SAMPLES) / "stomach" / "stomach.obj", SHEET, "--sizes", "17", "--cycles", "1,3,20",
                          "--milliseconds", "1,10", "--steps", "100", "-o", "out").stdout
        self.assertRegex(said, r"stomach\.obj 17x17, steps of 1 ms, multigrid: \d+ cycles come within 1 % of the converged step, p99 ")
        self.assertEqual(self.names(self.folder / "out"),
                         ["physics-beside.csv", "physics-facts.csv", "physics.csv", "physics.html", "physics.json"])
        rows = self.rows(self.read("out/physics.json"), "physics")
        self.assertEqual({(row["asset"], row["grid"], row["dt_ms"], row["cycles"]) for row in rows},
                         {(asset, "17x17", ms, k) for asset in ("stomach.obj", "sheet.obj") for ms in ("1", "10")
                          for k in ("1", "3", "20")})
        for row in rows:
            self.assertEqual(row["outcome"], "solved")
            self.assertGreater(row["contacts"], 0, row)
            if row["p50_us"]["median"] is not None:  # on a busy machine no step may be left to itself
                self.assertLessEqual(row["p50_us"]["median"], row["p99_us"]["median"])
            self.assertLess(abs(row["volume_error"]), 1e-8)
        for asset in ("stomach.obj", "sheet.obj"):
            for ms in ("1", "10"):
                error = [row["error"] for row in rows if row["asset"] == asset and row["dt_ms"] == ms]
                self.assertGreater(error[0], error[2], "a step of 20 cycles is nearer to the converged one")
                self.assertGreater(error[0], 0)
        rows = [row for row in self.rows(self.read("out/physics.json"), "beside") if row["asset"] == "stomach.obj"]
        self.assertEqual([row["beside"] for row in rows],
                         ["nothing", "a plane", "a surface", "a surface that goes", "a surface that is written"])
        self.assertEqual([row["contacts"] > 0 for row in rows], [False] + 4 * [True])
        self.bench("physics", SHEET, "--sizes", "33", "--cycles", "5", "--strides", "1,2,8,32", "--steps", "100", "-o", "detail")
        levels = {row["stride"]: row for row in self.rows(self.read("detail/physics.json"), "detail")}
        self.assertEqual([levels[k]["outcome"] for k in ("1", "2", "8")], ["solved"] * 3)
        self.assertEqual(levels["32"]["outcome"], "the stride leaves fewer than 3 x 3 samples")
        self.assertEqual([levels[k]["simulated"] for k in ("1", "2", "8")], ["1089", "289", "25"])
        self.assertEqual(levels["1"]["error"], 0, "physics of all samples, shown on all")
        self.assertLess(levels["2"]["error"], levels["8"]["error"])
        self.assertLess(levels["2"]["error"], 0.3)
        said = self.bench("physics", SHEET, "--sizes", "17", "--cycles", "1", "--steps", "100", "--metres-per-unit", "1e-8",
                          "-o", "refused").stdout
        self.assertEqual(self.rows(self.read("refused/physics.json"), "physics")[0]["outcome"],
                         "the material bends over a length beyond the body: check unit and moduli")
        self.bench("physics", SHEET, "--cycles", "0", code=1)

    def look_at_page(self, page):
        self.assertLess(page.stat().st_size, 2 << 20)
        dom, console = run_browser(page, "--dump-dom")
        self.assertEqual(console, [])
        self.assertGreater(int(re.search(r'data-drawn="(\d+)"', dom).group(1)), 15)
        self.assertEqual(len(re.findall(r"<svg ", dom)), 6)
        self.assertIn("Pareto front", dom)
        self.assertIn("within the noise", dom)
        corners = {}
        for theme in ("light", "dark"):
            pixels, console = screenshot(page, self.folder / f"{theme}.png", f"#{theme}")
            self.assertEqual(console, [])
            corners[theme] = pixels[2, 2].tolist()
            plots = pixels[pixels.shape[0] // 4:].reshape(-1, 3)
            _, counts = numpy.unique(plots, axis=0, return_counts=True)
            self.assertGreater((counts > 20).sum(), 12, "nothing but paper is drawn")
        self.assertEqual(corners["light"], [255, 255, 255])
        self.assertLess(max(corners["dark"]), 48)


if __name__ == "__main__":
    unittest.main()
