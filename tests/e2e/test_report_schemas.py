# SPDX-License-Identifier: GPL-3.0-or-later
"""dgm-validate's SARIF and JUnit against the schemas beside this file, and that the schemas refuse what is wrong."""
import copy
import json
import os
import re
import subprocess
import unittest
from pathlib import Path

import jsonschema
import support

SCHEMAS = Path(__file__).resolve().parent / "schemas"
FIXTURES = os.environ.get("DGM_MAKE_VALIDATION_FIXTURES", "")


class Schemas(support.Folder):
    def setUp(self):
        super().setUp()
        made = self.run_program(FIXTURES, self.folder)
        self.assertEqual(made.returncode, 0, made.stderr)
        (self.folder / "bad mesh.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\n")
        self.maps = sorted(p.name for p in self.folder.iterdir() if p.suffix in (".dgm", ".exr") and p.name.count(".") == 1)
        self.assertGreater(len(self.maps), 20)

    def reports(self, form):
        """Outputs of all fixtures; of a good file alone; with a mesh, with a bad one, with a baseline, with nothing listed."""
        self.run_program(support.VALIDATE, *self.maps[::2], "--write-baseline", "known.json")
        for arguments in ([*self.maps, "absent.dgm"], ["good.dgm"], ["DGM4001_shifted.dgm", "--source", "DGM4001_shifted.obj"],
                          ["good.dgm", "--source", "bad mesh.obj"], [*self.maps, "--baseline", "known.json"],
                          [*self.maps, "--max-issues", "0"]):
            result = self.run_program(support.VALIDATE, *arguments, "--format", form)
            self.assertEqual(result.stderr, "")
            yield result.stdout

    def test_sarif(self):
        schema = json.loads((SCHEMAS / "sarif.schema.json").read_text(encoding="utf-8"))
        jsonschema.Draft7Validator.check_schema(schema)
        validator = jsonschema.Draft7Validator(schema)
        logs = [json.loads(text) for text in self.reports("sarif")]
        for log in logs:
            validator.validate(log)
            ids = [rule["id"] for rule in log["runs"][0]["tool"]["driver"]["rules"]]
            for result in log["runs"][0]["results"]:  # what a schema cannot say
                self.assertEqual(ids[result["ruleIndex"]], result["ruleId"])
        results = [result for log in logs for result in log["runs"][0]["results"]]
        self.assertEqual({r.get("baselineState") for r in results}, {None, "new", "unchanged"})
        regions = [r["locations"][0]["physicalLocation"].get("region") for r in results]
        self.assertIn({"startLine": 4, "startColumn": 1}, regions)
        uris = {r["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] for r in results}
        self.assertIn("bad%20mesh.obj", uris)

        def wrong(change):
            log = copy.deepcopy(logs[0])
            change(log, log["runs"][0], log["runs"][0]["results"][0])
            self.assertFalse(validator.is_valid(log))

        def put(holder, key, value):
            holder[key] = value

        wrong(lambda log, run, result: put(log, "version", "2.0.0"))
        wrong(lambda log, run, result: put(log, "surprise", 1))
        wrong(lambda log, run, result: run.pop("tool"))
        wrong(lambda log, run, result: run["tool"]["driver"].pop("name"))
        wrong(lambda log, run, result: run["tool"]["driver"]["rules"].append(run["tool"]["driver"]["rules"][0]))
        wrong(lambda log, run, result: result.pop("message"))
        wrong(lambda log, run, result: put(result, "level", "fatal"))
        wrong(lambda log, run, result: put(result, "ruleIndex", -2))
        wrong(lambda log, run, result: put(result["locations"][0]["physicalLocation"]["artifactLocation"], "uri", "a b"))
        wrong(lambda log, run, result: put(result["locations"][0]["physicalLocation"], "region", {"startLine": 0}))
        wrong(lambda log, run, result: put(result["locations"][0]["physicalLocation"], "region", {"startColumn": 3}))
        wrong(lambda log, run, result: put(result, "baselineState", "old"))

    def fits(self, text):
        file = self.folder / "report.xml"
        file.write_text(text, encoding="utf-8")
        done = subprocess.run(["xmllint", "--noout", "--nonet", "--schema", SCHEMAS / "junit.xsd", file],
                              capture_output=True, text=True, check=False)
        self.assertIn(done.returncode, (0, 1, 3), done.stderr)  # 1: no XML; 3: not as the schema says
        return done.returncode == 0

    def test_junit(self):
        reports = list(self.reports("junit"))
        for text in reports:
            self.assertTrue(self.fits(text))
        for tag in ("failure", "error", "skipped", "system-out"):
            self.assertTrue(any(f"<{tag}" in text for text in reports), tag)
        text = reports[0]
        for old, new in (("</testsuites>", ""), (' name="container"', ""), (' tests="4"', ' tests="four"'),
                         (' failures="', ' failed="'), ("<testcase ", "<case "), (r"<(failure|error) type=\"\w+\"", r"<\1"),
                         (r"(<failure[^>]*>[^<]*</failure>)", r"\1\1"), (r"(<testsuite .*?</testsuite>)", r"\1\1")):
            changed = re.sub(old, new, text, count=1, flags=re.S)
            self.assertNotEqual(changed, text, old)
            self.assertFalse(self.fits(changed), old)


if __name__ == "__main__":
    unittest.main()
