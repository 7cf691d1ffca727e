# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps that somebody has made to do harm, with hashes and checksums that fit (tests/fuzz/rehashed_files), through the
real programs: none of them dies, and one file never ends a batch.

As a test: a few, always the same. By scripts/faults: many.

    test_rehashed.py --count N [--first K] [--keep FOLDER]      exit code 1 if a program did what it must not
"""
import argparse
import collections
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import meshes
import support

try:  # scripts/faults runs many mutants with any interpreter
    import h5py
except ImportError:
    h5py = None

FILES = os.environ.get("DGM_REHASHED_FILES", "")
CODES = (0, 2, 3, 5)
BATCH = 100
SECONDS = 600


class Batch:
    """Some mutants in a folder, and what the programs made of them."""

    def __init__(self, folder, ending, first, count):
        self.folder, self.ending = folder, ending
        self.maps = folder / "maps"
        shutil.rmtree(folder, ignore_errors=True)
        self.maps.mkdir(parents=True)
        subprocess.run([FILES, ending, str(first), str(count), str(self.maps)], check=True, timeout=SECONDS)
        self.names = sorted(p.name for p in self.maps.iterdir() if p.suffix == "." + ending and "." not in p.stem)
        self.wrong, self.codes = [], collections.Counter()

    def run(self, program, *arguments):
        result = subprocess.run([program, *arguments], cwd=self.maps, capture_output=True, text=True, errors="replace",
                                timeout=SECONDS, check=False)
        name = Path(program).name
        self.codes[f"{name} {result.returncode}"] += 1
        if result.returncode not in CODES:
            self.wrong.append(f"{name}: exit code {result.returncode}: {result.stderr[-300:]}")
        for code in ("DGM9001", "DGM9002"):
            if code in result.stderr + result.stdout:
                at = (result.stderr + result.stdout).index(code)
                self.wrong.append(f"{name}: {(result.stderr + result.stdout)[max(0, at - 100):at + 200]}")
        return result

    def validate(self):
        """Names of the files that are accepted."""
        result = self.run(support.VALIDATE, "--format", "json", *self.names)
        try:
            files = json.loads(result.stdout)["files"]
        except (ValueError, KeyError):
            self.wrong.append("dgm-validate: no report of the batch")
            return []
        if len(files) != len(self.names):
            self.wrong.append(f"dgm-validate: {len(self.names)} files, {len(files)} results")
        return [f["file"] for f in files if f["exit_code"] == 0]

    def inform(self):
        self.run(support.INFO, *self.names)
        self.run(support.INFO, "--json", *self.names)

    def export(self):
        for form in ("glb", "obj"):
            self.run(support.EXPORT, *self.names, "--format", form, "-o", "../out")

    def bake(self, count):
        """They stand where outputs go: each is baked anew, or found to be another's."""
        sources, out = self.folder / "meshes", self.folder / "baked"
        sources.mkdir()
        out.mkdir()
        for name in self.names[:count]:
            meshes.write_obj(sources / f"{Path(name).stem}.obj", meshes.icosphere(0))
            shutil.copy(self.maps / name, out / name)
        result = self.run(support.BAKE, str(sources), "-o", str(out), "--size", "3", "-q", "--progress", "none",
                          "--format", self.ending, "--report", str(self.folder / "report.json"))
        outcomes = collections.Counter(a["outcome"] for a in json.loads((self.folder / "report.json").read_text())["assets"])
        if outcomes["baked"] != min(count, len(self.names)):
            self.wrong.append(f"dgm-bake: {dict(outcomes)}: {result.stderr[-300:]}")


def try_all(batch, baked):
    accepted = batch.validate()
    batch.inform()
    batch.export()
    if baked:
        batch.bake(baked)
    return accepted


@unittest.skipIf(not FILES, "tests/fuzz is not built")
class Rehashed(support.Folder):
    def hold(self, ending):
        batch = Batch(self.folder / ending, ending, 1000, 40)  # 1006: normals, but none of the border
        self.assertEqual(len(batch.names), 40)
        accepted = try_all(batch, 6)
        self.assertEqual(batch.wrong, [])
        self.assertTrue(0 < len(accepted) < 40, accepted)

    def test_dgm(self):
        self.hold("dgm")

    def test_exr(self):
        self.hold("exr")


def with_values(file, layer, index, values):
    """Overwrites values of the first chart's layer, and makes the hashes fit again."""
    with h5py.File(file) as f:
        data = f["charts/0"][layer]
        changed, offset = data[...], data.id.get_offset()
    changed[index] = values
    with open(file, "r+b") as f:
        f.seek(offset)
        f.write(changed.tobytes())
    subprocess.run([FILES, "mend", file], check=True, timeout=SECONDS)


@unittest.skipIf(not FILES or h5py is None, "tests/fuzz is not built, or h5py is missing")
class Refused(support.Folder):
    """What dgm-validate refuses, dgm-export does not pass on, though all hashes fit."""

    def setUp(self):
        super().setUp()
        meshes.write_obj(self.folder / "ball.obj", meshes.icosphere(2))
        self.bake_well("ball.obj", "-o", "ball.dgm", "--size", "9x9", "--method", "tutte", "--fit", "sample")

    def codes_of(self, name):
        result = self.run_program(support.VALIDATE, name, "--format", "json")
        report = json.loads(result.stdout)["files"][0]
        return result.returncode, {f["code"] for f in report["findings"] if f["severity"] == "error"}

    def test_a_map_whose_hashes_were_mended_for_nothing_is_exported(self):
        before = (self.folder / "ball.dgm").read_bytes()
        subprocess.run([FILES, "mend", self.folder / "ball.dgm"], check=True, timeout=SECONDS)
        self.assertEqual((self.folder / "ball.dgm").read_bytes(), before)
        self.assertEqual(self.codes_of("ball.dgm"), (0, set()))
        result = self.run_program(support.EXPORT, "ball.dgm", "-o", "ball.glb")
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_dgm_export_refuses_what_dgm_validate_refuses(self):
        with h5py.File(self.folder / "ball.dgm") as f:
            representative, copy = (int(x) for x in f["charts/0/seams"][0])
        columns = 9
        harms = {
            "huge": ("geometry", (4, 4, 1), 3e38, "DGM2007"),
            "not_a_number": ("geometry", (4, 4, 1), math.nan, "DGM2003"),
            "torn": ("geometry", (copy // columns, copy % columns, 0), 7.0, "DGM2004"),
            "inner_seam": ("seams", (0, 1), 4 * columns + 4, "DGM2005"),
            "no_diagonal": ("diagonals", (0, 0), 7, "DGM2007"),
            "far_corner": ("geometry", (representative // columns, representative % columns, 2), -5.0, "DGM2004"),
        }
        for name, (layer, index, value, code) in harms.items():
            with self.subTest(name):
                shutil.copy(self.folder / "ball.dgm", self.folder / f"{name}.dgm")
                with_values(self.folder / f"{name}.dgm", layer, index, value)
                exit_code, codes = self.codes_of(f"{name}.dgm")
                self.assertEqual(exit_code, 3)
                self.assertIn(code, codes)
                self.assertNotIn("DGM1003", codes)  # the hashes fit
                for ending in ("glb", "obj", "ply", "exr", "html", "png"):
                    result = self.run_program(support.EXPORT, f"{name}.dgm", "-o", f"{name}.out.{ending}")
                    self.assertEqual(result.returncode, 3, f"{ending}: {result.stderr}")
                    self.assertTrue(any(c in result.stderr for c in codes), f"{ending}: {codes}: {result.stderr}")
                self.assertEqual([n for n in self.names() if n.startswith(f"{name}.")], [f"{name}.dgm"])

    def test_one_of_them_does_not_keep_the_others_from_being_exported(self):
        shutil.copy(self.folder / "ball.dgm", self.folder / "huge.dgm")
        with_values(self.folder / "huge.dgm", "geometry", (4, 4, 1), 3e38)
        result = self.run_program(support.EXPORT, "huge.dgm", "ball.dgm", "--format", "glb", "-o", "out")
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertEqual(self.names(self.folder / "out"), ["ball.glb"])


def run_many(first, count, keep):
    folder, wrong = Path(tempfile.mkdtemp(prefix="dgm-rehashed-")).resolve(), 0
    try:
        for ending in ("dgm", "exr"):
            start, codes, accepted = time.monotonic(), collections.Counter(), 0
            for at in range(first, first + count, BATCH):
                batch = Batch(folder / "batch", ending, at, min(BATCH, first + count - at))
                accepted += len(try_all(batch, 5))
                codes += batch.codes
                for what in batch.wrong:
                    wrong += 1
                    print(f"rehashed: {ending} {at}..{at + BATCH - 1}: {what}", flush=True)
                    if keep:
                        shutil.copytree(batch.maps, Path(keep) / f"rehashed-{ending}-{at}", dirs_exist_ok=True)
            print(f"rehashed: {count} {ending} files from {first} in {time.monotonic() - start:.0f} s: {accepted} accepted, "
                  f"exit codes {dict(sorted(codes.items()))}, {wrong} wrong", flush=True)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    if "--count" in sys.argv:
        parser = argparse.ArgumentParser()
        parser.add_argument("--count", type=int)
        parser.add_argument("--first", type=int, default=1)
        parser.add_argument("--keep", default="")
        asked = parser.parse_args()
        sys.exit(run_many(asked.first, asked.count, asked.keep))
    unittest.main()
