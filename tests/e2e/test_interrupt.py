# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C in the middle of every stage: over within a second, and nothing left behind."""
import os
import signal
import subprocess
import time
import unittest

import meshes
import support

ALLOWED_SECONDS = 5 if support.SANITIZED else 1


class Interrupt(support.Folder):
    @classmethod
    def setUpClass(cls):
        cls.mesh = meshes.icosphere(5)  # 20 480 faces

    def start(self, *arguments):
        """The bake, with a bar on stderr that names the stage it is in."""
        process = subprocess.Popen([support.BAKE, "ball.obj", "-o", "out/ball.dgm", "--progress", "bar", *arguments],
                                   cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        os.set_blocking(process.stderr.fileno(), False)
        return process

    def wait_for(self, process, stage):
        """True once the bar shows the stage; False if the bake ended before."""
        said = b""
        while process.poll() is None:
            said = said[-200:] + (process.stderr.read() or b"")
            if b"ball.obj: " + stage.encode() in said.rpartition(b"\r")[2]:
                return True
            time.sleep(0.005)
        return False

    def interrupt(self, process, number, done=()):
        """`done`: files that may be there, complete, since the signal can come after the rename, or after all is done."""
        begun = time.monotonic()
        process.send_signal(number)
        process.wait(timeout=30)
        taken = time.monotonic() - begun
        self.assertIn(process.returncode, (130, 0) if done else (130,))
        self.assertLess(taken, ALLOWED_SECONDS)
        self.assertEqual([name for name in self.names() if name not in done], ["ball.obj", "out"])
        self.assertTrue(self.workers_gone())

    def test_every_stage(self):
        meshes.write_obj(self.folder / "ball.obj", self.mesh)
        (self.folder / "out").mkdir()
        hit, must = set(), ("import", "cut", "map", "fit")
        # On a busy machine this process may sleep while a short stage goes by: those that must be hit are tried again.
        for stage in ("import", "repair", "cut", "map", "fit", "layers", "measure", "write", *must * 4):
            if stage in hit:
                continue
            with self.subTest(stage=stage):
                process = self.start("--size", "257", "--fit", "l2", "--method", "stretch")
                if self.wait_for(process, stage):
                    self.interrupt(process, signal.SIGINT, ["out/ball.dgm"] if stage == "write" else [])
                    hit.add(stage)
                    written = self.folder / "out" / "ball.dgm"
                    if written.exists():
                        self.assertEqual(self.run_program(support.VALIDATE, written).returncode, 0)
                        written.unlink()
                else:  # too short to be caught in
                    self.assertEqual(process.returncode, 0)
                    (self.folder / "out" / "ball.dgm").unlink()
        self.assertGreaterEqual(hit, set(must))

    def test_a_search_by_budget(self):
        meshes.write_obj(self.folder / "ball.obj", meshes.icosphere(4))
        (self.folder / "out").mkdir()
        for pause in (0.3, 0.8, 1.4):  # it writes a file for each grid it tries
            process = self.start("--budget", "1MB")
            self.assertTrue(self.wait_for(process, ""))  # any stage
            time.sleep(pause)
            self.assertIsNone(process.poll())
            self.interrupt(process, signal.SIGTERM)

    def test_before_anything_is_baked(self):
        meshes.write_obj(self.folder / "ball.obj", meshes.icosphere(2))
        (self.folder / "out").mkdir()
        for pause in (0.0, 0.005, 0.01, 0.02):
            process = self.start()
            while not self.processes():
                time.sleep(0.0005)
            time.sleep(pause)
            process.send_signal(signal.SIGINT)
            process.wait(timeout=30)
            # Before the program has installed its handler, the signal itself ends it.
            self.assertIn(process.returncode, (130, -signal.SIGINT))
            self.assertEqual(self.names(), ["ball.obj", "out"])


if __name__ == "__main__":
    unittest.main()
