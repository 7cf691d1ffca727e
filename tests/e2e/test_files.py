# SPDX-License-Identifier: GPL-3.0-or-later
"""Output files when things go wrong: processes killed at any moment, full disks, two bakes on one name.

    test_files.py [--kills N]      N bakes are killed instead of 30
"""
import os
import random
import shutil
import signal
import subprocess
import sys
import threading
import time
import unittest

import meshes
import support

KILLS = 30
FAIL_CALLS = os.environ.get("DGM_FAIL_CALLS", "")


class Files(support.Folder):
    def setUp(self):
        super().setUp()
        meshes.write_obj(self.folder / "ball.obj", meshes.icosphere(2))

    def valid(self, name):
        return self.run_program(support.VALIDATE, name, "-q").returncode == 0

    def strays(self):
        """Everything but the mesh and the result, temporary files of killed parents among it."""
        return [n for n in self.names() if n not in ("ball.obj", "ball.dgm", "report.json")]

    def start(self, *arguments, **more):
        process = subprocess.Popen([support.BAKE, "ball.obj", "-o", "ball.dgm", "-q", "--progress", "none", *arguments],
                                   cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **more)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def test_killed_at_any_moment(self):
        """Old file, new file, or none; never half a file. Parent or worker, at a moment anywhere in the bake."""
        self.bake_well("ball.obj", "-o", "ball.dgm", "--size", "9")
        old = (self.folder / "ball.dgm").read_bytes()
        begun = time.monotonic()
        self.bake_well("ball.obj", "-o", "ball.dgm", "--size", "33")
        duration = time.monotonic() - begun
        new = (self.folder / "ball.dgm").read_bytes()
        self.assertNotEqual(old, new)
        draw, seen = random.Random(7), {"old": 0, "new": 0, "none": 0}
        for k in range(KILLS):
            before = k % 3 != 0  # every third time there is no file before
            if before:
                (self.folder / "ball.dgm").write_bytes(old)
            else:
                (self.folder / "ball.dgm").unlink(missing_ok=True)
            process = self.start("--size", "33")
            time.sleep(draw.random() * duration * 1.1)
            victims = [p for p in self.processes() if p != process.pid] if k % 2 else []
            for victim in victims or [process.pid]:
                try:
                    os.kill(victim, signal.SIGKILL)
                except ProcessLookupError:
                    pass  # it had ended
            process.wait(timeout=60)
            self.assertTrue(self.workers_gone())
            content = (self.folder / "ball.dgm").read_bytes() if (self.folder / "ball.dgm").exists() else None
            if content == new:
                seen["new"] += 1
            elif before:
                self.assertTrue(content == old, f"kill {k}: neither the old file nor the new one")
                seen["old"] += 1
            else:
                self.assertIsNone(content, f"kill {k}: a file that is not the new one")
                seen["none"] += 1
            for stray in self.strays():
                # A killed parent cannot clean up. Its files are in a folder that no one takes for a result.
                self.assertRegex(stray, r"^\.dgm-[^./]{6}(/|$)")
        self.assertGreater(seen["old"], 0, seen)
        self.assertGreater(seen["none"], 0, seen)
        self.bake_well("ball.obj", "-o", "ball.dgm", "--size", "33")  # and the next bake goes through
        self.assertEqual((self.folder / "ball.dgm").read_bytes(), new)
        self.assertEqual([stray for stray in self.strays() if "/" in stray], [], "the next bake cleans up")
        self.assertTrue(self.valid("ball.dgm"))

    def full_disk(self, allowed, *arguments):
        environment = dict(os.environ, LD_PRELOAD=FAIL_CALLS, DGM_DISK_BYTES=str(allowed))
        return subprocess.run([support.BAKE, "ball.obj", "-o", "ball.dgm", "--size", "17", *arguments], cwd=self.folder,
                              env=environment, capture_output=True, text=True, timeout=support.TIMEOUT_SECONDS, check=False)

    @unittest.skipIf(support.SANITIZED or not FAIL_CALLS, "another library is preloaded already")
    def test_full_disk(self):
        self.bake_well("ball.obj", "-o", "ball.dgm", "--size", "17")
        size = (self.folder / "ball.dgm").stat().st_size
        self.assertEqual(self.full_disk(10 * size).returncode, 0)  # the library itself does no harm
        self.bake_well("ball.obj", "-o", "ball.dgm", "--size", "9")
        old = (self.folder / "ball.dgm").read_bytes()
        # The gaps between aligned datasets are never written: an eighth of the size is well below what is.
        for allowed, formats in ((0, "dgm"), (1, "dgm"), (4096, "dgm,exr"), (size // 8, "dgm"), (size // 8, "exr,dgm")):
            with self.subTest(allowed=allowed, formats=formats):
                result = self.full_disk(allowed, "--format", formats)
                self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
                self.assertIn("DGM5003", result.stderr)
                self.assertEqual((self.folder / "ball.dgm").read_bytes(), old)
                self.assertEqual(self.strays(), [])

    def test_file_size_limit(self):
        """RLIMIT_FSIZE: the kernel's signal must not look like a crash."""
        self.bake_well("ball.obj", "-o", "ball.dgm", "--size", "9")
        old = (self.folder / "ball.dgm").read_bytes()
        result = subprocess.run(["sh", "-c", 'ulimit -f 64; exec "$0" ball.obj -o ball.dgm --size 33', support.BAKE],
                                cwd=self.folder, capture_output=True, text=True, timeout=support.TIMEOUT_SECONDS, check=False)
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        self.assertIn("DGM5003", result.stderr)
        self.assertEqual((self.folder / "ball.dgm").read_bytes(), old)
        self.assertEqual(self.strays(), [])

    def test_a_mesh_that_cannot_be_written(self):
        """The map was written already, and must not appear without the mesh that was asked for."""
        self.bake_well("ball.obj", "-o", "out/", "--size", "9")
        old = (self.folder / "out" / "ball.dgm").read_bytes()
        self.bake_well("ball.obj", "-o", "whole/", "--size", "33", "--format", "dgm,ply,obj")
        sizes = {path.suffix: path.stat().st_size for path in (self.folder / "whole").iterdir()}
        self.assertLess(sizes[".dgm"], sizes[".obj"])
        blocks = (sizes[".dgm"] + sizes[".obj"]) // 2 // 512
        result = subprocess.run(["sh", "-c", f'ulimit -f {blocks}; exec "$0" ball.obj -o out/ --size 33 --format '
                                 "dgm,ply,obj", support.BAKE], cwd=self.folder, capture_output=True, text=True,
                                timeout=support.TIMEOUT_SECONDS, check=False)
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        self.assertRegex(result.stderr, r"DGM5003(.|\n)*ball\.obj\n  next")
        self.assertEqual((self.folder / "out" / "ball.dgm").read_bytes(), old)
        self.assertEqual(self.names(self.folder / "out"), ["ball.dgm"])

    def test_two_bakes_on_one_file(self):
        """The last one to finish wins; the file is one of the two, whole."""
        whole = {}
        for size in ("17", "25"):
            self.bake_well("ball.obj", "-o", "ball.dgm", "--size", size)
            whole[size] = (self.folder / "ball.dgm").read_bytes()
        for _ in range(3):
            (self.folder / "ball.dgm").unlink()
            both = [self.start("--size", size) for size in whole]
            self.assertEqual([process.wait(timeout=300) for process in both], [0, 0])
            self.assertIn((self.folder / "ball.dgm").read_bytes(), whole.values())
            self.assertEqual(self.strays(), [])

    def test_folder_that_disappears(self):
        """The output's folder is removed while the bake runs."""
        (self.folder / "out").mkdir()
        process = subprocess.Popen([support.BAKE, "ball.obj", "-o", "out/ball.dgm", "--size", "513",
                                    "--fit", "best"], cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.kill)
        # Where the folder is missing at the start, it is made.
        late = threading.Timer(60, process.kill)
        late.start()
        begun = next((line for line in process.stderr if ": map" in line or ": fit" in line), "")
        late.cancel()
        self.assertTrue(begun, "the bake did not tell of its progress")
        shutil.rmtree(self.folder / "out")
        _, errors = process.communicate(timeout=300)
        self.assertEqual(process.returncode, 2, errors)
        self.assertRegex(errors, "DGM500[0-9]")
        self.assertEqual(self.names(), ["ball.obj"])


if __name__ == "__main__":
    if "--kills" in sys.argv:
        place = sys.argv.index("--kills")
        KILLS = int(sys.argv[place + 1])
        del sys.argv[place:place + 2]
    unittest.main()
