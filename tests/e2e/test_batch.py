# SPDX-License-Identifier: GPL-3.0-or-later
"""A night's batch: patterns, warnings before the long part, progress, shards and their reports, jobs and memory."""
import json
import os
import pty
import re
import shutil
import subprocess
import unittest
from pathlib import Path

import meshes
import support

SIZE = ["--size", "17", "--method", "tutte", "--fit", "sample"]
SCHEMA = os.environ.get("DGM_REPORT_SCHEMA", "")


def timeless(report):
    """The part that two runs of the same batch have in common."""
    report = json.loads(json.dumps(report))
    for asset in report["assets"]:
        asset["seconds"] = 0
        for key in ("times", "cpu_seconds", "peak_memory_bytes"):
            asset.get("report", {}).pop(key, None)
        for chart in asset.get("report", {}).get("charts", []):
            for candidate in chart["candidates"]:
                candidate.pop("cpu_seconds", None)
    return report


class Batch(support.Folder):
    def fill(self, count=6):
        (self.folder / "in" / "deep" / "er").mkdir(parents=True)
        for k in range(count):
            folder = ["in", "in/deep", "in/deep/er"][k % 3]
            meshes.write_obj(self.folder / folder / f"m{k}.obj", meshes.sheet(4 + k))

    def report(self, name="report.json"):
        report = json.loads((self.folder / name).read_text())
        import jsonschema
        with open(SCHEMA, encoding="utf-8") as file:
            schema = json.load(file)
        jsonschema.Draft202012Validator.check_schema(schema)
        jsonschema.Draft202012Validator(schema).validate(report)
        return report

    def test_patterns(self):
        self.fill()
        (self.folder / "in" / "notes.txt").write_text("x")
        (self.folder / "in" / ".hidden.obj").write_text("x")
        for pattern, found in [("in/*.obj", ["m0", "m3"]), ("in/*/*.obj", ["deep/m1", "deep/m4"]),
                               ("in/**/*.obj", ["deep/er/m2", "deep/er/m5", "deep/m1", "deep/m4", "m0", "m3"]),
                               ("in/**/er/m[2-4].*", ["deep/er/m2"]), ("in/m?.o*", ["m0", "m3"]),
                               ("in/**", ["deep/er/m2", "deep/er/m5", "deep/m1", "deep/m4", "m0", "m3"])]:
            result = self.bake(pattern, "-o", "out", "--dry-run")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(result.stdout.splitlines(), [f"in/{f}.obj -> out/{f}.dgm" for f in found], pattern)
        result = self.bake("in/*.3ds", "-o", "out")
        self.assertEqual(result.returncode, 2)
        self.assertIn("the pattern matches no meshes", result.stderr)
        meshes.write_obj(self.folder / "odd[1].obj", meshes.sheet(4))  # a file of that very name is that file
        self.assertEqual(self.bake("odd[1].obj", "--dry-run").stdout, "odd[1].obj -> odd[1].dgm\n")

    def test_warnings_come_before_the_long_part(self):
        two = meshes.together(meshes.icosphere(2), meshes.sheet(4))
        meshes.write_obj(self.folder / "a.obj", two)
        text = (self.folder / "a.obj").read_text()
        (self.folder / "a.obj").write_text("mtllib a.mtl\nusemtl skin\n" + text)
        (self.folder / "a.mtl").write_text("newmtl skin\nmap_Kd skin.png\n")
        process = subprocess.Popen([support.BAKE, "a.obj", "--size", "257", "--fit", "best"], cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        said = []
        while len(said) < 3:
            line = process.stderr.readline()
            self.assertTrue(line, said)
            if not line.startswith("["):
                said.append(line.strip())
        self.assertIsNone(process.poll())
        self.assertEqual(self.names(), [n for n in self.names() if not n.endswith(".dgm") or n.startswith(".")])
        process.send_signal(2)
        process.communicate(timeout=30)
        self.assertEqual(said, ["dgm-bake: a.obj: warning: DGM3012: texture missing: skin.png; looked for beside the mesh and there "
                                "in textures, texture, maps, images, materials",
                                "dgm-bake: a.obj: note: 2 components: one chart each",
                                "dgm-bake: a.obj: note: open border (1 loop on 1 of 2 components): fine for cloth, odd "
                                "for an organ"])

    def test_repairs_are_told(self):
        vertices, faces = meshes.icosphere(1)
        faces = faces + [(faces[0][0], faces[0][1], len(vertices))]  # a third face on an edge
        meshes.write_obj(self.folder / "a.obj", (vertices + [(3, 3, 3)], faces))
        result = self.bake("a.obj", *SIZE)
        self.assertIn("note: repaired: 1 non-manifold edge taken apart\n", result.stderr)
        quiet = self.bake("a.obj", *SIZE, "-q", "--force")
        self.assertEqual(quiet.stderr, "")

    def test_progress_on_a_terminal(self):
        self.fill(3)
        parent, child = pty.openpty()
        process = subprocess.Popen([support.BAKE, "in", "-o", "out", "-j1", "--size", "129"], cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=child)
        os.close(child)
        said = b""
        try:
            while data := os.read(parent, 65536):
                said += data
        except OSError:
            pass  # how Linux says that the other end is closed
        os.close(parent)
        self.assertEqual(process.wait(timeout=60), 0)
        lines = [line.decode() for line in said.split(b"\r") if b"]" in line]
        self.assertTrue(any(re.match(r"\[#*\.*\] [0-3]/3  \d+:\d\d, \d+:\d\d to go  m\d\.obj: [a-z]+ \d+ %", line)
                            for line in lines), lines[-3:])
        self.assertRegex(said, rb"\r\x1b\[Kdgm-bake: notes: open border [^\x1b]*\n$", "the bar is taken off the screen")

    def test_progress_in_a_log(self):
        self.fill(3)
        plain = self.bake_well("in", "-o", "out", *SIZE, "-j1")
        starts = [line for line in plain.stderr.splitlines() if line.startswith("[")]
        self.assertEqual(starts, ["[1/3] m2.obj", "[2/3] m1.obj", "[3/3] m0.obj"])
        self.assertNotIn("\x1b", plain.stderr)
        silent = self.bake_well("in", "-o", "out", *SIZE, "--force", "--progress", "none")
        self.assertNotIn("[1/3]", silent.stderr)

    def test_shards_make_up_the_whole(self):
        self.fill(12)
        meshes.write_obj(self.folder / "in" / "bad.obj", meshes.line())
        whole = self.bake("in", "-o", "whole", *SIZE, "--report", "whole.json", "--dry-run")
        lines = []
        for k in (1, 2, 3):
            part = self.bake("in", "-o", "whole", *SIZE, "--shard", f"{k}/3", "--dry-run")
            lines += part.stdout.splitlines()
        self.assertEqual(sorted(lines), sorted(whole.stdout.splitlines()))
        before = {k: self.bake("in", "--shard", f"{k}/3", "--dry-run").stdout.splitlines() for k in (1, 2, 3)}
        self.assertGreater(min(map(len, before.values())), 0)
        for k in range(20):  # more meshes, from another working folder under another name: nobody moves
            meshes.write_obj(self.folder / "in" / f"new{k}.obj", meshes.sheet(3))
        for k in (1, 2, 3):
            after = self.bake(self.folder / "in", "--shard", f"{k}/3", "--dry-run", cwd="/").stdout
            for line in before[k]:
                self.assertIn(line.split(" -> ")[0] + " -> ", after)

    def test_merged_reports_are_those_of_a_local_run(self):
        self.fill(8)
        meshes.write_obj(self.folder / "in" / "bad.obj", meshes.line())
        local = self.bake("in", "-o", "out", *SIZE, "--report", "local.json")
        self.assertEqual(local.returncode, 3)
        bytes_of = {n: (self.folder / "out" / n).read_bytes() for n in self.names(self.folder / "out") if ".dgm" in n}
        shutil.rmtree(self.folder / "out")
        # One shard a process, as many at a time as xargs likes.
        shards = subprocess.run(["xargs", "-P2", "-I{}", support.BAKE, "in", "-o", "out", *SIZE, "--shard", "{}/4",
                                 "--report", "part{}.json", "-j2"], input="1\n2\n3\n4\n", text=True, cwd=self.folder,
                                capture_output=True, check=False)
        self.assertEqual(shards.returncode, 123, shards.stderr)  # xargs: some of them failed
        self.assertEqual({n: (self.folder / "out" / n).read_bytes() for n in bytes_of}, bytes_of)
        parts = [f"part{k}.json" for k in (1, 2, 3, 4)]
        merged = self.bake("--merge-reports", *parts, "-o", "all.json")
        self.assertEqual(merged.returncode, 3, merged.stderr)
        self.assertEqual(self.bake("--merge-reports", *parts[::-1], parts[0], "-o", "again.json").returncode, 3)
        self.assertEqual((self.folder / "all.json").read_bytes(), (self.folder / "again.json").read_bytes())
        local_report, all_report = self.report("local.json"), self.report("all.json")
        self.assertEqual(timeless(all_report)["assets"], timeless(local_report)["assets"])
        for key in ("exit_code", "summary", "run", "generator", "report_version"):
            self.assertEqual(all_report[key], local_report[key], key)

    def test_parallel_as_the_manual_says(self):
        """The line of docs/clusters.md, without its other hosts."""
        if not shutil.which("parallel"):
            self.skipTest("there is no GNU parallel")
        self.fill(4)
        self.bake_well("in", "-o", "local", *SIZE)
        line = next(l for l in (Path(__file__).resolve().parents[2] / "docs" / "clusters.md").read_text(encoding="utf-8").splitlines()
                    if l.startswith("parallel "))
        line = line.replace("-S host1,host2 ", "").replace("dgm-bake models/", f"{support.BAKE} in/ {' '.join(SIZE)}")
        result = subprocess.run(["bash", "-c", line], cwd=self.folder, capture_output=True, text=True, check=False,
                                env={**os.environ, "PARALLEL_HOME": str(self.folder)})
        self.assertEqual(result.returncode, 0, result.stderr)
        parts = sorted(p.name for p in self.folder.glob("part*.json"))
        self.assertEqual(len(parts), 8)
        self.assertEqual(self.bake("--merge-reports", *parts, "-o", "all.json").returncode, 0)
        self.assertEqual([a["outcome"] for a in self.report("all.json")["assets"]], ["baked"] * 4)
        for file in (self.folder / "local").rglob("*.dgm"):
            twin = self.folder / "baked" / file.relative_to(self.folder / "local")
            self.assertEqual(twin.read_bytes(), file.read_bytes(), file)

    def test_a_second_try_replaces_the_first(self):
        if not support.FAULTY_BAKE:
            self.skipTest("no faulty program")
        meshes.write_obj(self.folder / "killed-once.obj", meshes.sheet(4))
        os.environ["DGM_KILLED_MARK"] = str(self.folder / "mark")
        self.addCleanup(os.environ.pop, "DGM_KILLED_MARK")
        first = self.bake("killed-once.obj", *SIZE, "--report", "1.json", program=support.FAULTY_BAKE)
        self.assertEqual(first.returncode, 75, first.stderr)
        self.assertIn("DGM9006", first.stderr)
        self.assertIn("run it again", first.stderr)
        second = self.bake("killed-once.obj", *SIZE, "--report", "2.json", program=support.FAULTY_BAKE)
        self.assertEqual(second.returncode, 0, second.stderr)
        for order in (["1.json", "2.json"], ["2.json", "1.json"]):
            self.assertEqual(self.bake("--merge-reports", *order, "-o", "all.json").returncode, 0)
            report = self.report("all.json")
            self.assertEqual([a["outcome"] for a in report["assets"]], ["baked"])
        self.assertEqual(self.bake("--merge-reports", "1.json", "-o", "all.json").returncode, 75)

    def test_what_is_no_report_cannot_be_merged(self):
        for text in ("", "[]", "{}", '{"report_version": 1, "assets": []}', '{"report_version": 2, "assets": [3]}'):
            (self.folder / "r.json").write_text(text)
            result = self.bake("--merge-reports", "r.json", "-o", "all.json")
            self.assertEqual(result.returncode, 3, text)
            self.assertIn("DGM5008", result.stderr)
        self.assertEqual(self.bake("--merge-reports", "gone.json").returncode, 2)
        self.assertEqual(self.bake("--merge-reports").returncode, 1)

    def test_a_full_disk_is_trouble_that_may_pass(self):
        meshes.write_obj(self.folder / "a.obj", meshes.sheet(4))
        small = self.folder / "small"
        small.mkdir()
        if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", small], check=False,
                                               capture_output=True).returncode != 0:
            self.skipTest("a small file system cannot be mounted here")
        self.addCleanup(subprocess.run, ["umount", small], check=False)
        result = self.bake("a.obj", "-o", "small/", "--size", "257", "--method", "tutte", "--fit", "sample",
                           "--report", "report.json")
        self.assertEqual(result.returncode, 75, result.stderr)
        self.assertIn("DGM5006", result.stderr)
        self.assertIn("free some space", result.stderr)
        self.assertEqual(self.names(small), [])
        self.assertEqual(self.report()["assets"][0]["error"]["exit_code"], 75)

    def test_reports_follow_the_schema(self):
        self.fill(2)
        meshes.write_obj(self.folder / "in" / "bad.obj", meshes.line())
        meshes.write_obj(self.folder / "in" / "ball.obj", meshes.icosphere(2))
        self.bake("in", "gone.obj", "-o", "out", "--max-error", "1%", "--report", "report.json", "--format", "dgm,exr")
        outcomes = {asset["name"]: asset["outcome"] for asset in self.report()["assets"]}
        self.assertEqual(outcomes, {"m0.obj": "baked", "deep/m1.obj": "baked", "ball.obj": "baked",
                                    "bad.obj": "refused", "gone.obj": "failed"})
        self.bake("in", "-o", "out", *SIZE, "--layers", "normal", "--budget", "1MB", "--report", "report.json")
        self.report()
        self.bake("in", "-o", "out", *SIZE, "--layers", "normal", "--budget", "1MB", "--report", "report.json")
        self.assertEqual(self.report()["summary"]["up_to_date"], 3)

    def test_an_empty_shard_is_no_failure(self):
        meshes.write_obj(self.folder / "a.obj", meshes.sheet(4))
        codes = []
        for k in range(1, 6):
            result = self.bake("a.obj", "-o", "out/", *SIZE, "--shard", f"{k}/5", "--report", f"{k}.json")
            codes.append(result.returncode)
        self.assertEqual(codes, [0] * 5)
        counts = [self.report(f"{k}.json")["summary"]["assets"] for k in range(1, 6)]
        self.assertEqual(sorted(counts), [0, 0, 0, 0, 1])

    def test_wrong_shards(self):
        for wrong in ("0/3", "4/3", "3", "a/b", "1/0", "-1/2", "1/2/3"):
            result = self.bake("a.obj", f"--shard={wrong}")
            self.assertEqual(result.returncode, 1, wrong)


if __name__ == "__main__":
    unittest.main()
