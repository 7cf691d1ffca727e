# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever fails, a program says so and leaves the old file or a whole new one.

Every n-th allocation, read, write, fsync, rename, open, map, fork and thread of every program fails (fail_calls.c), once
or from then on; processes are killed at the n-th of these calls, and at any time; files end early. As a test: a few of
each. By scripts/faults: many, or all.

    test_faults.py --long [--most N] [--kills N] [--only CASE]      exit code 1 if any run broke a law
"""
import argparse
import collections
import itertools
import json
import os
import random
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import meshes
import support
import test_hostile_meshes as hostile

FAIL_CALLS = os.environ.get("DGM_FAIL_CALLS", "")
KINDS = ("memory", "read", "write", "sync", "rename", "open", "map", "fork", "thread")
ALL_KINDS = KINDS + ("remove", "any")
COUNT_BYTES = 256
CODES = (0, 2, 3, 4, 5, 75, 130)
SECONDS = 90
SAID_BY_FILES = ("read", "write", "sync", "rename")  # faults of a file: the message has to name it

Case = collections.namedtuple("Case", "name program arguments outputs")
Run = collections.namedtuple("Run", "code text left counts")


def write_inputs(folder):
    (folder / "ball.obj").write_text(hostile.textured(meshes.icosphere(1), "ball.mtl"))
    (folder / "ball.mtl").write_text("newmtl skin\nmap_Kd skin.png\n")
    (folder / "skin.png").write_bytes(hostile.png())


def all_cases(long=False):
    bake = ("ball.obj", "--size", "9", "-j1", "--progress", "none", "-o")
    every = [
        Case("bake", support.BAKE, [*bake, "out", "--format", "dgm,exr,glb", "--report", "out/report.json"],
             ["out/ball.dgm", "out/ball.exr", "out/ball.glb", "out/report.json"]),
        Case("validate", support.VALIDATE, ["map.dgm", "map.exr", "--source", "ball.obj"], []),
        Case("info", support.INFO, ["map.dgm", "map.exr", "--json"], []),
        Case("export", support.EXPORT, ["map.dgm", "-o", "out/ball.glb"], ["out/ball.glb"]),
        Case("maps", support.EXPORT, ["map.dgm", "--maps", "out"], []),
        Case("exr", support.EXPORT, ["map.dgm", "-o", "out/ball.exr"], ["out/ball.exr"]),
    ]
    slow = [
        Case("merge", support.BAKE, ["--merge-reports", "one.json", "one.json", "-o", "out/merged.json"],
             ["out/merged.json"]),
        Case("page", support.BAKE, [*bake, "out/ball.dgm", "--force", "--report", "out/page.html", "-M", "out/deps.d"],
             ["out/ball.dgm", "out/page.html", "out/deps.d"]),
        Case("found", support.VALIDATE, ["map.dgm", "--report", "json=out/found.json"], ["out/found.json"]),
    ]
    return [case for case in every + (slow if long else []) if case.program]


class Place:
    """A folder with inputs and old outputs, and what a run without faults leaves in it."""

    def __init__(self, folder, case):
        self.case, self.folder, self.template = case, folder / "work", folder / "template"
        self.counts = folder / "counts"
        self.template.mkdir(parents=True)
        write_inputs(self.template)
        (self.template / "out").mkdir()
        bake = [support.BAKE, "ball.obj", "--progress", "none", "-q", "--size"]
        subprocess.run([*bake, "9", "-o", "map.dgm", "--report", "one.json"], cwd=self.template, check=True)
        subprocess.run([*bake, "9", "-o", "map.exr"], cwd=self.template, check=True)
        subprocess.run([*bake, "5", "-o", "out/ball.dgm"], cwd=self.template, check=True)
        for name in case.outputs:  # what stood there before: never half of it
            if not (self.template / name).exists():
                (self.template / name).write_bytes(b"what stood here before\n")
        self.old = self.contents(self.template)
        whole = self.run("memory:0")
        if whole.code != 0:
            raise RuntimeError(f"{case.name} fails without a fault: {whole.text}")
        self.new, self.calls = whole.left, whole.counts

    @staticmethod
    def contents(folder):
        return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}

    def run(self, fault, kill_after=None):
        shutil.rmtree(self.folder, ignore_errors=True)
        shutil.copytree(self.template, self.folder)
        self.counts.write_bytes(bytes(COUNT_BYTES))
        environment = dict(os.environ, LD_PRELOAD=FAIL_CALLS, DGM_FAULT=fault, DGM_FAULT_COUNTS=str(self.counts))
        return self.finish([self.case.program, *self.case.arguments], environment, kill_after)

    def strays(self, left):
        return sorted(name for name in left if name not in self.old and name not in self.new)

    def left_for_good(self, strays):
        """Of what a program without memory or descriptors left behind: what the next one does not remove. A destructor
        that finds no memory ends a program at once."""
        again = self.finish([self.case.program, *self.case.arguments], dict(os.environ))
        return sorted({*self.strays(again.left), *(name for name in strays if not is_staged(name))})

    def finish(self, command, environment, kill_after=None):
        with subprocess.Popen(command, cwd=self.folder, env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, start_new_session=True) as process:
            try:
                text, _ = process.communicate(timeout=kill_after or SECONDS)
                code = process.returncode
            except subprocess.TimeoutExpired:
                process.kill()
                text, _ = process.communicate()
                code = -signal.SIGKILL if kill_after else "hangs"
        counts = struct.unpack("<11Q", self.counts.read_bytes()[:88])
        return Run(code, text.decode(errors="replace"), self.contents(self.folder), dict(zip(ALL_KINDS, counts)))


def is_staged(name):
    return any(part.startswith(".dgm-") for part in Path(name).parts)


def is_whole(name, data, place):
    """The old file, the new one, or (reports have times in them) one of the new kind that is complete."""
    if data in (place.old.get(name), place.new.get(name)):
        return True
    if name.endswith(".json"):
        try:
            json.loads(data)
            return True
        except ValueError:
            return False
    if name.endswith(".html"):
        return data.rstrip().endswith(b"</html>")
    if name.endswith(".d"):
        return data.endswith(b"\n") or not data  # rules of what was baked
    return False


def broken_laws(place, fault, run, killed_itself=False):
    """What a run did that no run may do, as short lines."""
    kind = fault.split(":")[0]
    killed = run.code == -signal.SIGKILL and (fault.endswith(":kill") or killed_itself)
    laws = []
    if run.code not in CODES and not killed:
        laws.append(f"exit code {run.code}")
    if "DGM9001" in run.text:
        laws.append("a resource failed and the tool calls it its own fault (DGM9001)")
    if "terminate called" in run.text:
        laws.append("std::terminate")
    if run.code not in (0,) and not killed:
        named = [word for word in (*place.old, *place.new, "out", "stdout", "standard output") if word in run.text]
        if not run.text.strip():
            laws.append("fails without a word")
        elif kind in SAID_BY_FILES and not named:
            laws.append("the message names no file")
    may_miss = run.code != 0
    for name in {**place.old, **place.new}:
        if name not in run.left:
            is_page = name.startswith("out/assets/")  # a page that cannot be made is told of, and costs no bake its good end
            if name in place.old or not (may_miss or is_page):
                laws.append(f"{name} is gone" if name in place.old else f"{name} is missing after exit code 0")
        elif not is_whole(name, run.left[name], place):
            laws.append(f"{name} is neither old nor new")
        elif run.code == 0 and name in place.case.outputs and run.left[name] == place.old.get(name) and \
                place.new.get(name) != place.old.get(name):
            laws.append(f"{name} is still old after exit code 0")
    strays = place.strays(run.left)
    if strays and (kind == "memory" or fault.endswith(":on")):
        strays = place.left_for_good(strays)
    if strays and not killed:
        laws.append("left behind: " + ", ".join(strays))
    return laws


def chosen(count, most, draw):
    """Numbers 1 .. count: all, or `most` of them, the first and the last ones for sure."""
    if count <= most:
        return list(range(1, count + 1))
    some = {1, count} if most < 6 else {1, 2, 3, count - 1, count}
    while len(some) < most:
        some.add(draw.randrange(1, count + 1))
    return sorted(some)


def faults_of(place, most, draw, kills):
    for kind in KINDS:
        for n in chosen(place.calls[kind], most, draw):
            yield f"{kind}:{n}:once"
        for n in chosen(place.calls[kind], max(1, most // 3), draw):
            yield f"{kind}:{n}:on"
    for n in chosen(place.calls["any"], kills, draw):
        yield f"any:{n}:kill"


def system_call_kills(place, most, draw):
    """Kills at the n-th call of a name of any process, through strace: those that glibc makes for itself, too."""
    plain = {k: v for k, v in os.environ.items() if k != "LD_PRELOAD"}
    trace = place.counts.with_name("trace")
    command = [place.case.program, *place.case.arguments]
    shutil.rmtree(place.folder, ignore_errors=True)
    shutil.copytree(place.template, place.folder)
    place.finish(["strace", "-f", "-qq", "-o", str(trace), *command], plain)
    calls = collections.Counter()
    for line in trace.read_text(errors="replace").splitlines():
        words = line.split(None, 1)
        if len(words) == 2 and "(" in words[1] and not words[1].startswith(("+", "-", "<")):
            calls[words[0], words[1].split("(")[0]] += 1
    most_of = collections.Counter()
    for (_, name), count in calls.items():
        most_of[name] = max(most_of[name], count)
    spots = [(name, n) for name, count in sorted(most_of.items()) for n in range(1, count + 1)]
    for name, n in sorted(draw.sample(spots, min(most, len(spots)))):
        shutil.rmtree(place.folder, ignore_errors=True)
        shutil.copytree(place.template, place.folder)
        inject = f"inject={name}:signal=KILL:when={n}"
        run = place.finish(["strace", "-f", "-qq", "-o", "/dev/null", "-e", f"trace={name}", "-e", inject, *command], plain)
        yield f"{name}:{n}:kill", run


class Tally:
    """Counts runs, and keeps one example of every way to break a law."""

    def __init__(self):
        self.runs, self.codes, self.broken = 0, collections.Counter(), {}

    def add(self, place, fault, run, killed_itself=False):
        self.runs += 1
        self.codes[str(run.code)] += 1
        for law in broken_laws(place, fault, run, killed_itself):
            key = (place.case.name, fault.split(":")[0], law)
            self.broken.setdefault(key, []).append((fault, run.text.strip()[-400:]))

    def lines(self):
        for (case, _, law), examples in sorted(self.broken.items()):
            fault, text = examples[0]
            yield f"{case}: DGM_FAULT={fault}: {law} ({len(examples)} runs)\n    {text}"


def cut_files(folder, data, ending, cuts):
    names = []
    for size in cuts:
        names.append(f"cut{size:07}{ending}")
        (folder / names[-1]).write_bytes(data[:size])
    return names


def refused_cuts(folder, names):
    """Names of files that end early and are called valid; a batch ends in a report of all of them."""
    wrong = []
    for first in range(0, len(names), 200):
        some = names[first:first + 200]
        result = subprocess.run([support.VALIDATE, "--format", "json", *some], cwd=folder, capture_output=True,
                                text=True, timeout=SECONDS, check=False)
        if result.returncode not in (2, 3):
            return [f"dgm-validate: exit code {result.returncode}: {result.stderr[-300:]}"]
        files = json.loads(result.stdout)["files"]
        if len(files) != len(some):
            wrong.append(f"{len(some)} files, {len(files)} results")
        wrong += [f["file"] for f in files if f["exit_code"] == 0]
    return wrong


@unittest.skipIf(support.SANITIZED or not FAIL_CALLS, "another library is preloaded already")
class Faults(support.Folder):
    def test_a_few_of_each_kind(self):
        draw, tally = random.Random(20), Tally()
        for case in all_cases():
            place = Place(self.folder / case.name, case)
            self.assertGreater(place.calls["memory"], 50, "the library is not loaded")
            for fault in faults_of(place, 2, draw, 3):
                tally.add(place, fault, place.run(fault))
        self.assertFalse(tally.broken, "\n".join(tally.lines()))
        self.assertGreater(sum(n for code, n in tally.codes.items() if code != "0"), 50)

    def test_validation_ends_where_no_copy_of_it_can_begin(self):
        case = next(case for case in all_cases(long=True) if case.name == "validate")
        place = Place(self.folder / case.name, case)
        for fault in ("map:3:on", "map:4:on"):
            run = place.run(fault)
            self.assertEqual((run.code, broken_laws(place, fault, run)), (75, []), run.text)
            self.assertIn("could not begin", run.text)

    def test_a_file_that_ends_early(self):
        write_inputs(self.folder)
        self.bake_well("ball.obj", "--size", "5", "--format", "dgm,exr")
        for name in ("ball.dgm", "ball.exr"):
            data = (self.folder / name).read_bytes()
            cuts = sorted({*range(0, 64, 7), *range(64, len(data), max(1, len(data) // 120)), len(data) - 1})
            self.assertEqual(refused_cuts(self.folder, cut_files(self.folder, data, Path(name).suffix, cuts)), [])

    def test_kills_at_any_time(self):
        draw, tally = random.Random(7), Tally()
        place = Place(self.folder / "kills", all_cases()[0])
        for _ in range(12):
            tally.add(place, "time:0:kill", place.run("memory:0", draw.uniform(0.01, 0.4)), True)
        self.assertFalse(tally.broken, "\n".join(tally.lines()))


def run_long(most, kills, only):
    folder, draw, tally = Path(tempfile.mkdtemp(prefix="dgm-faults-")).resolve(), random.Random(), Tally()
    start = time.monotonic()
    try:
        for case in all_cases(long=True):
            if only and case.name not in only.split(","):
                continue
            place = Place(folder / case.name, case)
            before = tally.runs
            for fault in faults_of(place, most, draw, kills):
                tally.add(place, fault, place.run(fault))
            for _ in range(kills if case.name == "bake" else 0):
                tally.add(place, "time:0:kill", place.run("memory:0", draw.uniform(0.005, 0.5)), True)
            if shutil.which("strace") and case.name in ("bake", "export"):
                for spot, run in system_call_kills(place, kills, draw):
                    tally.add(place, spot, run, True)
            print(f"faults: {case.name}: {tally.runs - before} runs; calls: "
                  f"{', '.join(f'{k} {n}' for k, n in place.calls.items())}", flush=True)
        if not only or "cuts" in only:
            write_inputs(folder)
            subprocess.run([support.BAKE, "ball.obj", "--size", "5", "--format", "dgm,exr", "-q"], cwd=folder, check=True)
            for name in ("ball.dgm", "ball.exr"):
                data = (folder / name).read_bytes()
                cuts = range(len(data)) if most > 500 else sorted(draw.sample(range(len(data)), 4 * most))
                wrong = refused_cuts(folder, cut_files(folder, data, Path(name).suffix, cuts))
                print(f"faults: {len(cuts)} of {len(data)} ends of {name}: {len(wrong)} wrong {wrong[:3]}", flush=True)
                if wrong:
                    tally.broken["cuts", name, "called valid"] = [(name, str(wrong[:3]))]
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    print("\n".join(tally.lines()))
    print(f"faults: {tally.runs} runs in {time.monotonic() - start:.0f} s, exit codes "
          f"{dict(sorted(tally.codes.items()))}, {len(tally.broken)} ways to break a law")
    return 1 if tally.broken else 0


if __name__ == "__main__":
    if "--long" in sys.argv:
        parser = argparse.ArgumentParser()
        parser.add_argument("--long", action="store_true")
        parser.add_argument("--most", type=int, default=200, help="of each kind, program and action")
        parser.add_argument("--kills", type=int, default=500)
        parser.add_argument("--only", default="")
        asked = parser.parse_args()
        sys.exit(run_long(asked.most, asked.kills, asked.only))
    unittest.main()
