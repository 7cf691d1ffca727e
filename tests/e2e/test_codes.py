# SPDX-License-Identifier: GPL-3.0-or-later
"""Every code has an input that makes the tools give it, and every report keeps its form.

tests/golden/validation.txt is what dgm-validate says of the fixtures; DGM_UPDATE_GOLDEN=1 writes it anew.
"""
import json
import os
import re
import subprocess
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import jsonschema
import meshes
import support

ROOT = Path(__file__).resolve().parents[2]
GOLDEN = ROOT / "tests" / "golden" / "validation.txt"
FIXTURES = os.environ.get("DGM_MAKE_VALIDATION_FIXTURES", "")

# Codes that no file can be made to give.
NO_INPUT = {
    3003: "needs a mesh on which every method fails; none is known",
    3011: "is a warning: test_said.py",
    3012: "is a warning: test_said.py",
    3013: "needs files beside the mesh's folder: test_references.py",
    3014: "needs a pipe that a mesh names: test_references.py",
    3017: "is a warning: test_one_sided.py",
    3007: "needs an input beyond the tool's limits: gigabytes",
    5006: "needs a full disk: test_files.py",
    5007: "needs a failing disk or network share",
    9001: "stands for errors in the tools themselves",
    9005: "needs a signal at the right moment: test_interrupt.py",
    9006: "needs a signal at the right moment: test_slurm.py",
    9007: "needs a machine that has no process left",
}


class Codes(support.Folder):
    def setUp(self):
        super().setUp()
        made = self.run_program(FIXTURES, self.folder)
        self.assertEqual(made.returncode, 0, made.stderr)
        os.mkfifo(self.folder / "DGM5002_pipe.dgm")

    def validate(self, *arguments):
        return self.run_program(support.VALIDATE, *arguments)

    def maps(self):
        """Without files of layers, which have two dots and are part of a map."""
        return sorted(p.name for p in self.folder.iterdir() if p.suffix in (".dgm", ".exr") and p.name.count(".") == 1)

    def source_of(self, name):
        mesh = Path(name).with_suffix(".obj")
        return ["--source", mesh] if (self.folder / mesh).exists() else []

    def outcome(self, name, *arguments):
        return self.validate(name, *self.source_of(name), *arguments)

    def explained(self):
        """{number: name} of all codes."""
        text = self.validate("--explain", "all").stdout
        return {int(n): name for n, name in re.findall(r"^DGM(\d{4}) ([A-Z0-9_]+) \(", text, re.M)}

    def paint_a_map(self):
        """painted.dgm: baked from sheet.obj, with mobility of another hand."""
        import h5py
        for program, arguments in ((support.BAKE, ["sheet.obj", "-o", "painted.dgm", "--size", "9"]),
                                   (support.EDIT, ["painted.dgm", "--repair"])):
            result = self.run_program(program, *arguments)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            if program == support.BAKE:
                with h5py.File(self.folder / "painted.dgm", "r+") as file:
                    file["charts/0/contact"][4, 4, 1] = 0.5

    def bake_outcomes(self):
        """Codes by commands other than validating one file: (number, program, arguments)."""
        folder = self.folder
        write = lambda name, mesh: meshes.write_obj(folder / name, mesh)
        write("sheet.obj", meshes.sheet(8))
        write("torus.obj", meshes.torus())
        vertices, faces = meshes.sheet(12)  # two faces a quad; every other quad of every other row is a hole
        write("sieve.obj", (vertices, [f for k, f in enumerate(faces)
                                       if not (k // 2 % 2 == 1 and k // 24 % 2 == 1 and k // 24 < 11 and k // 2 % 12 < 11)]))
        (folder / "points.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
        (folder / "huge.obj").write_text("v 0 0 0\nv 1e300 0 0\nv 0 1e300 0\nf 1 2 3\n")
        corners = range(1200)  # in an order that crosses every other edge
        (folder / "crossed.obj").write_text("".join(f"v {k * 7919 % 1201} {k * k % 1193} 0\n" for k in corners) + "f " +
                                            " ".join(str(k + 1) for k in corners) + "\n")
        (folder / "broken.3ds").write_bytes(b"MM\x00\x00 nothing of the sort")
        (folder / "broken.png").write_bytes(b"no picture")
        (folder / "texts").mkdir()
        (folder / "baseline.json").write_text("{}")
        (folder / "scene.toml").write_text("assets = 3\n")
        (folder / "stiff.toml").write_text("membrane = 1\nbending = 1e9\ndensity = 1\n")
        (folder / "wrong.toml").write_text("membrane = 0\n")
        for fault in ("segfault", "hang", "memory", "refuse"):
            (folder / f"{fault}.obj").write_text("a mesh that misbehaves\n")
        bake, validate, faulty, edit = support.BAKE, support.VALIDATE, support.FAULTY_BAKE, support.EDIT
        small = ["-o", "out", "--size", "9"]
        self.paint_a_map()
        cases = [
            (1017, edit, ["good.dgm", "--from", "good.dgm", "--layer", "geometry"]),
            (1018, edit, ["good.dgm", "--from", "texts"]), (1019, bake, ["sheet.obj", "-o", "painted.dgm", "--size", "11"]),
            (3001, bake, ["points.obj", *small]), (3002, faulty, ["refuse.obj", *small]),
            (3004, bake, ["sheet.obj", *small, "--method", "uv"]), (3005, bake, ["broken.3ds", *small]),
            (3006, bake, ["sieve.obj", "-o", "out", "--size", "3", "--method", "tutte"]), (3008, bake, ["huge.obj", *small]),
            (3009, bake, ["torus.obj", *small, "--max-error", "1e-9%"]),
            (3010, bake, ["sheet.obj", *small, "--budget", "100B"]),
            (3018, bake, ["sheet.obj", *small, "--unit", "mm", "--material", "stiff.toml"]),
            (3019, bake, ["crossed.obj", *small]),
            (6005, bake, ["sheet.obj", *small, "--unit", "mm", "--material", "wrong.toml"]),
            (5001, validate, ["absent.dgm"]), (5003, validate, ["good.dgm", "--report", "json=points.obj/under/a/file.json"]),
            (5004, bake, ["texts", "-o", "out"]), (5005, bake, ["sheet.obj", *small, "--texture", "broken.png"]),
            (6001, validate, ["--frob"]), (6002, os.environ["DGM_INFO"], ["scene.toml", "--json"]),
            (6004, bake, ["scene.toml"]),
            (5008, bake, ["--merge-reports", "baseline.json", "-o", "all.json"]),
            (6003, validate, ["good.dgm", "--baseline", "baseline.json"]),
            (9002, faulty, ["segfault.obj", *small]), (9003, faulty, ["hang.obj", *small, "--time-limit", "1"]),
        ]
        if not support.SANITIZED:
            cases.append((9004, faulty, ["memory.obj", *small, "--memory-limit", "512MiB"]))
        return cases

    def test_every_code_has_an_input_that_gives_it(self):
        codes = self.explained()
        self.assertGreater(len(codes), 50)
        tried = set(NO_INPUT)
        for name in self.maps():
            number = re.match(r"DGM(\d{4})", name)
            if number is None:
                continue
            with self.subTest(name):
                result = self.outcome(name)
                self.assertIn(f"DGM{number[1]} ", result.stdout, result.stderr)
                self.assertEqual(result.stderr, "")
            tried.add(int(number[1]))
        for number, program, arguments in self.bake_outcomes():
            with self.subTest(number):
                result = self.run_program(program, *arguments)
                self.assertNotEqual(result.returncode, 0)
                self.assertRegex(result.stdout + result.stderr, rf"\bDGM{number}\b")
            tried.add(number)
        if support.SANITIZED:
            tried.add(9004)
        self.assertEqual(sorted(set(codes) - tried), [], "codes without a fixture")
        self.assertEqual(sorted(tried - set(codes)), [], "fixtures of codes that are gone")

    def test_files_that_other_tools_wrote_again(self):
        """Does as h5repack: every object copied into a new file behind the old user block."""
        import h5py
        good = self.folder / "good.dgm"
        for name, options in (("plain", {}), ("gzip", {"compression": "gzip", "chunks": True})):
            copy = self.folder / f"{name}.dgm"
            with h5py.File(good) as old, h5py.File(copy, "w", userblock_size=4096) as new:
                new.attrs.update(old.attrs)

                def put(path, item):
                    if isinstance(item, h5py.Group):
                        made = new.require_group(path)
                    else:
                        made = new.create_dataset(path, data=item[()], **(options if item.shape else {}))
                    made.attrs.update(item.attrs)

                old.visititems(put)
            with open(copy, "r+b") as file:
                file.write(good.read_bytes()[:4096])
            result = self.validate(copy.name)
            self.assertEqual(result.returncode, 3)
            self.assertRegex(result.stdout, r"^DGM100[45] error: ")
            # As large as the old one, it is found by its hashes.
            with open(copy, "r+b") as file:
                file.truncate(good.stat().st_size)
            result = self.validate(copy.name)
            self.assertEqual(result.returncode, 3)
            self.assertIn("DGM1003 error: ", result.stdout)

    def test_good_files_pass(self):
        for name in ("good.dgm", "good.exr"):
            result = self.validate(name)
            self.assertEqual((result.returncode, result.stdout), (0, f"{name}: ok (2 charts)\n"))

    def test_golden_report(self):
        text = "".join(self.outcome(name).stdout for name in self.maps())
        # The words of other libraries change with their versions.
        text = re.sub(r"OpenEXR: [^—]* —", "OpenEXR: ... —", text)
        if os.environ.get("DGM_UPDATE_GOLDEN") == "1":
            GOLDEN.write_text(text)
        self.assertEqual(text, GOLDEN.read_text())

    def test_docs_are_made_of_the_table(self):
        page = self.validate("--explain", "all", "--format", "markdown")
        self.assertEqual(page.returncode, 0, page.stderr)
        self.assertEqual((ROOT / "docs" / "codes.md").read_text(), page.stdout,
                         "write it with: dgm-validate --explain all --format markdown >docs/codes.md")

    def test_json_fits_its_schema(self):
        schema = json.loads((ROOT / "docs" / "schemas" / "validate.schema.json").read_text())
        jsonschema.Draft7Validator.check_schema(schema)
        result = self.validate(*self.maps(), "absent.dgm", "--format", "json")
        report = json.loads(result.stdout)
        jsonschema.validate(report, schema)
        self.assertEqual(report["exit_code"], result.returncode)
        self.assertEqual([f["file"] for f in report["files"]], [*self.maps(), "absent.dgm"])
        codes = self.explained()
        for file in report["files"]:
            errors = [f for f in file["findings"] if f["severity"] == "error" and not f["known"]]
            self.assertEqual(len(errors), file["counts"]["errors"])
            self.assertEqual(file["exit_code"] != 0, bool(errors), file)
            for finding in file["findings"]:
                self.assertEqual(codes[int(finding["code"][3:])], finding["name"])
        with_source = self.outcome("DGM4001_shifted.dgm", "--format", "json")
        jsonschema.validate(json.loads(with_source.stdout), schema)
        # The schema is strict: what is not in it does not pass.
        report["files"][0]["surprise"] = 1
        with self.assertRaises(jsonschema.ValidationError):
            jsonschema.validate(report, schema)

    def test_junit(self):
        self.validate(*self.maps(), "absent.dgm", "-q", "--report", "junit=out.xml")
        report = json.loads(self.validate(*self.maps(), "absent.dgm", "--format", "json").stdout)
        suites = ElementTree.parse(self.folder / "out.xml").getroot()
        self.assertEqual(suites.tag, "testsuites")
        self.assertEqual([s.get("name") for s in suites], [f["file"] for f in report["files"]])
        totals = {"tests": 0, "failures": 0, "errors": 0}
        for suite, file in zip(suites, report["files"]):
            # As Jenkins, GitLab and others read it: names, counts that add up, and these children alone.
            self.assertEqual(suite.tag, "testsuite")
            cases = list(suite)
            self.assertEqual([c.tag for c in cases], ["testcase"] * 4)
            self.assertEqual([c.get("name") for c in cases], ["file", "container", "layers", "source"])
            self.assertEqual({c.get("classname") for c in cases}, {file["file"]})
            for case in cases:
                self.assertLessEqual({child.tag for child in case}, {"failure", "error", "skipped", "system-out"})
                for bad in [*case.findall("failure"), *case.findall("error")]:
                    self.assertRegex(bad.get("type"), r"^DGM\d{4}$")
                    self.assertTrue(bad.get("message"))
                    self.assertIn(bad.get("type"), bad.text)
            for key, tag in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
                self.assertEqual(int(suite.get(key)), len(suite.findall(f"testcase/{tag}")))
            self.assertEqual(int(suite.get("tests")), len(cases))
            failed = int(suite.get("failures")) + int(suite.get("errors"))
            self.assertEqual(failed > 0, file["exit_code"] != 0, file["file"])
            for key in totals:
                totals[key] += int(suite.get(key))
        self.assertEqual({key: int(suites.get(key)) for key in totals}, totals)
        # The same input gives the same bytes: no times, no hosts.
        self.assertEqual((self.folder / "out.xml").read_text(),
                         self.validate(*self.maps(), "absent.dgm", "-j3", "--format", "junit").stdout)

    def test_sarif(self):
        log = json.loads(self.validate(*self.maps(), "--format", "sarif").stdout)
        report = json.loads(self.validate(*self.maps(), "--format", "json").stdout)
        # The rules of SARIF 2.1.0 for the parts that are used (3.13, 3.14, 3.19, 3.27, 3.49).
        self.assertEqual(set(log), {"$schema", "version", "runs"})
        self.assertEqual(log["version"], "2.1.0")
        run, = log["runs"]
        self.assertEqual(set(run), {"tool", "results"})
        driver = run["tool"]["driver"]
        self.assertEqual(driver["name"], "dgm-validate")
        rules = driver["rules"]
        self.assertEqual(len({r["id"] for r in rules}), len(rules))
        for rule in rules:
            for text in (rule["shortDescription"], rule["fullDescription"], rule["help"]):
                self.assertTrue(text["text"])
        wanted = [(f["file"], x["code"], x["severity"]) for f in report["files"] for x in f["findings"]]
        found = []
        for result in run["results"]:
            self.assertEqual(rules[result["ruleIndex"]]["id"], result["ruleId"])
            self.assertIn(result["level"], ("error", "warning", "note"))
            self.assertTrue(result["message"]["text"])
            location, = result["locations"]
            uri = location["physicalLocation"]["artifactLocation"]["uri"]
            self.assertRegex(uri, r"^[A-Za-z0-9._~/%-]+$")
            self.assertRegex(result["partialFingerprints"]["dgmFinding/v1"], r"^[0-9a-f]{32}$")
            found.append((uri, result["ruleId"], result["level"]))
        self.assertEqual(found, wanted)
        prints = [r["partialFingerprints"]["dgmFinding/v1"] for r in run["results"]]
        self.assertGreater(len(set(prints)), 0.9 * len(prints))

    def test_baseline_round_trip(self):
        names = self.maps()
        first = self.validate(*names, "--write-baseline", "base/line.json")
        self.assertEqual(first.returncode, 0, first.stderr)
        again = self.validate(*names, "--baseline", "base/line.json")
        self.assertEqual(again.returncode, 0, again.stdout)
        self.assertIn(" known", again.stdout.splitlines()[-1])
        new = self.validate(*names, "absent.dgm", "--baseline", "base/line.json", "-q")
        self.assertEqual(new.returncode, 2)
        self.assertEqual(len(new.stdout.splitlines()), 1, new.stdout)

    def test_a_cap_hides_no_error(self):
        capped = self.validate(*self.maps(), "--max-issues", "0")
        self.assertEqual(capped.returncode, self.validate(*self.maps()).returncode)
        self.assertNotIn(" error: ", capped.stdout)
        self.assertRegex(capped.stdout.splitlines()[-1], r"\d+ files: \d+ ok, \d+ failed; \d+ errors")

    def test_limits(self):
        name = "DGM4003_other.dgm"  # on its source, but for rounding
        passes = self.outcome(name, "--max-rms", "1e-3%", "--max-hausdorff", "1e-3%")
        self.assertEqual(passes.returncode, 0, passes.stdout)
        fails = self.outcome("DGM4001_shifted.dgm", "--max-rms", "0.01%", "--max-hausdorff", "0.01%")
        self.assertEqual(fails.returncode, 3)
        for code in ("DGM4001", "DGM4002", "DGM2011"):  # the report claims less, too
            self.assertIn(f"{code} error: ", fails.stdout)

    def test_ci_samples_are_yaml_and_name_real_options(self):
        import yaml
        help_text = self.validate("--help").stdout + self.bake("--help").stdout
        for name, step in (("github-actions.yml", "jobs"), ("gitlab-ci.yml", "validate")):
            text = (ROOT / "samples" / "ci" / name).read_text()
            self.assertIn(step, yaml.safe_load(text))
            commands = re.sub(r"#.*", "", text)
            for option in re.findall(r"(?<=\s)--[a-z-]+", commands):
                self.assertIn(option, help_text, name)
        job = yaml.safe_load((ROOT / "samples" / "ci" / "github-actions.yml").read_text())["jobs"]["bake-and-validate"]
        for step in job["steps"]:
            self.assertEqual(len({"uses", "run"} & set(step)), 1, step)

    def test_the_action_runs_as_a_workflow_would_run_it(self):
        import yaml
        action = yaml.safe_load((ROOT / "samples" / "ci" / "action" / "action.yml").read_text())
        (self.folder / "assets").mkdir()
        meshes.write_obj(self.folder / "assets" / "ball.obj", meshes.icosphere())
        inputs = {name: entry.get("default", "") for name, entry in action["inputs"].items()}
        inputs |= {"assets": "assets/", "options": "--size 33x33 -MF extra.d"}
        outputs = self.folder / "outputs"
        tools = os.pathsep.join(str(Path(tool).parent) for tool in (support.BAKE, support.VALIDATE))
        for step in action["runs"]["steps"]:
            self.assertEqual(step["shell"], "bash")
            values = {name: re.sub(r"\$\{\{ inputs\.(\w+) \}\}", lambda m: inputs[m[1]], text)
                      for name, text in step["env"].items()}
            ran = subprocess.run(["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]], cwd=self.folder,
                                 env=os.environ | values | {"GITHUB_OUTPUT": str(outputs),
                                                            "PATH": tools + os.pathsep + os.environ["PATH"]},
                                 capture_output=True, text=True, timeout=support.TIMEOUT_SECONDS, check=False)
            self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        written = dict(line.split("=", 1) for line in outputs.read_text().splitlines())
        for name, entry in action["outputs"].items():
            step, key = re.search(r"steps\.(\w+)\.outputs\.(\w+)", entry["value"]).groups()
            self.assertIn(step, [s["id"] for s in action["runs"]["steps"]])
            self.assertTrue((self.folder / written[key]).is_file(), name)
        self.assertTrue((self.folder / "extra.d").is_file())
        self.assertTrue((self.folder / "baked" / "ball.dgm").is_file())


if __name__ == "__main__":
    unittest.main()
