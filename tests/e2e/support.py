# SPDX-License-Identifier: GPL-3.0-or-later
"""Running the built programs. CMake hands their places over in the environment."""
import os
import shutil
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

BAKE = os.environ.get("DGM_BAKE", "")
FAULTY_BAKE = os.environ.get("DGM_FAULTY_BAKE", "")
VALIDATE = os.environ.get("DGM_VALIDATE", "")
INFO = os.environ.get("DGM_INFO", "")
EXPORT = os.environ.get("DGM_EXPORT", "")
EDIT = os.environ.get("DGM_EDIT", "")
BENCH = os.environ.get("DGM_BENCH", "")
DUMP_LAYERS = os.environ.get("DGM_DUMP_LAYERS", "")
DEFORM_SAMPLE = os.environ.get("DGM_DEFORM_SAMPLE", "")
FOOTPRINT_ERROR = os.environ.get("DGM_FOOTPRINT_ERROR", "")
SAMPLES = os.environ.get("DGM_SAMPLES", "")
SANITIZED = os.environ.get("DGM_SANITIZED", "") == "1"
TIMEOUT_SECONDS = 300


class Folder(unittest.TestCase):
    """A test with a folder of its own, where the programs run."""

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="dgm-e2e-")).resolve()
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def run_program(self, program, *arguments, cwd=None):
        return subprocess.run([program, *map(str, arguments)], cwd=cwd or self.folder, capture_output=True, text=True,
                              errors="replace", timeout=TIMEOUT_SECONDS, check=False)

    def bake(self, *arguments, cwd=None, program=None):
        return self.run_program(program or BAKE, *arguments, cwd=cwd)

    def bake_well(self, *arguments, cwd=None):
        result = self.bake(*arguments, cwd=cwd)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return result

    def names(self, folder=None):
        """Every file and folder below, hidden ones too, as sorted relative paths."""
        root = folder or self.folder
        return sorted(str(p.relative_to(root)) for p in root.rglob("*"))

    def workers_gone(self, seconds=5):
        """True once no process works below this test's folder."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            if not self.processes():
                return True
            time.sleep(0.05)
        return False

    def processes(self):
        found = []
        for entry in Path("/proc").iterdir():
            if entry.name.isdigit() and int(entry.name) != os.getpid():
                try:
                    if Path(os.readlink(entry / "cwd")) == self.folder:
                        found.append(int(entry.name))
                except OSError:
                    continue
        return found
