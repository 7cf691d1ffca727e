# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the programs that README.md and docs/engines.md show, beside a map of the name that they open.

    test_examples.py DGM_BAKE SAMPLES README_EXAMPLE ENGINES_EXAMPLE
"""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

BAKE, SAMPLES, README, ENGINES = sys.argv[1], Path(sys.argv[2]), sys.argv[3], sys.argv[4]
SIDE = 33


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="examples-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        subprocess.run([BAKE, "-q", SAMPLES / "stomach/stomach.obj", "-o", cls.folder / "stomach.dgm",
                        "--size", str(SIDE), "--domain", "square"], check=True, timeout=200)

    def run_in(self, folder, program):
        return subprocess.run([program], cwd=folder, timeout=60, capture_output=True, text=True, check=False)

    def test_readme(self):
        result = self.run_in(self.folder, README)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stdout, rf"^{SIDE * SIDE} samples, pressed at sample [0-9]+\n$")

    def test_engines(self):
        self.assertEqual(self.run_in(self.folder, ENGINES).returncode, 0)

    def test_without_a_map(self):
        with tempfile.TemporaryDirectory(prefix="examples-") as empty:
            for program in (README, ENGINES):
                result = self.run_in(empty, program)
                self.assertEqual(result.returncode, 1)
                self.assertTrue((result.stdout + result.stderr).strip(), "says why")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
