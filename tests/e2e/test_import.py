# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes beside a map (--source) are read in a process of their own: what takes the importer down is one finding."""
import os
import signal
import subprocess
import time
import unittest
from pathlib import Path

import meshes
import support

FAULTY = os.environ.get("DGM_FAULTY_IMPORT", "")


class Import(support.Folder):
    def test_every_way_to_fail(self):
        cases = {"segfault": ("DGM9002", 4), "abort": ("DGM9002", 4), "killed": ("DGM9006", None), "hang": ("DGM9003", 3),
                 "hang-deaf": ("DGM9003", 3), "quit": ("DGM9002", 4), "quit-5": ("DGM9002", 4), "throw": ("DGM9001", 4),
                 "babble": ("DGM9002", 4), "lie": ("DGM9002", 4), "stray": ("DGM9002", 4), "memory": ("DGM9004", 3),
                 "chatty": ("320 faces", 0), "good": ("320 faces", 0)}
        if support.SANITIZED:
            del cases["memory"]
        for name, (said, code) in cases.items():
            with self.subTest(name):
                mesh = meshes.write_obj(self.folder / f"{name}.obj", meshes.icosphere(2))
                result = self.run_program(FAULTY, mesh, 2 if name.startswith("hang") else 100)
                self.assertTrue(result.stdout.startswith(said), result.stdout + result.stderr)
                if code is not None:
                    self.assertEqual(result.returncode, code)
                self.assertTrue(self.workers_gone())
        (self.folder / "empty.obj").write_text("v 0 0 0\nl 1 1\n")
        self.assertIn("DGM3001 no usable faces; 1 line elements @empty.obj:2:1", self.run_program(FAULTY, "empty.obj", 100).stdout)
        self.assertIn("DGM5001", self.run_program(FAULTY, "absent.3ds", 100).stdout)

    def test_attributes_come_through(self):
        """Materials, textures, normals, colours: compared to the byte by the program itself."""
        (self.folder / "a.mtl").write_text("newmtl red one\nKd 1 0 0\nmap_Kd tex.png\nbump -bm 0.5 tex.png\nnewmtl b\n")
        (self.folder / "tex.png").write_bytes(b"no picture, but a file")
        (self.folder / "a.obj").write_text(
            "mtllib a.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\n"
            "usemtl red one\nf 1/1/1 2/2/1 3/3/1\nusemtl b\nf 3/3/1 2/2/1 1/1/1\nl 1 2\nf 1 2 77\n")
        result = self.run_program(FAULTY, "a.obj", 100)
        self.assertEqual((result.returncode, result.stdout), (0, "2 faces\n"))

    def worker_of(self, process):
        """The importing process, or None if the program ended without one being seen."""
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        while process.poll() is None:
            try:
                for child in children.read_text().split():
                    if b"--worker" in Path(f"/proc/{child}/cmdline").read_bytes():
                        return int(child)
            except OSError:
                pass  # it ended meanwhile
        return None

    def test_the_validator_and_the_exporter_outlive_it(self):
        meshes.write_obj(self.folder / "ball.obj", meshes.icosphere(2))
        self.bake_well("ball.obj", "-o", "ball.dgm", "--size", "9")
        meshes.write_obj(self.folder / "large.obj", meshes.icosphere(6))  # 82 000 faces: long enough to be caught
        for program, arguments in ((support.VALIDATE, ["ball.dgm", "--source", "large.obj"]),
                                   (os.environ["DGM_EXPORT"], ["ball.dgm", "-o", "x.png", "--source", "large.obj"])):
            for _ in range(20):
                process = subprocess.Popen([program, *arguments], cwd=self.folder, stdout=subprocess.PIPE,
                                           stderr=subprocess.PIPE, text=True)
                worker = self.worker_of(process)
                if worker is not None:
                    try:
                        os.kill(worker, signal.SIGSEGV)
                    except ProcessLookupError:
                        worker = None
                out, errors = process.communicate(timeout=120)
                if worker is not None and "DGM9002" in out + errors:
                    break
                time.sleep(0.05)  # it was done before; try again
            self.assertIn("DGM9002", out + errors)
            self.assertEqual(process.returncode, 4)
            self.assertEqual(self.run_program(program, *arguments[:-1], "ball.obj").returncode, 0)


if __name__ == "__main__":
    unittest.main()
