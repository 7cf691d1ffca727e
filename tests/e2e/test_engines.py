# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/engines.md shows the lines of the program that libdgm.consumer builds and runs, and no others."""
import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


class Engines(unittest.TestCase):
    def test_c_blocks_are_in_the_program(self):
        program = (ROOT / "tests/e2e/consumer/engine.c").read_text(encoding="utf-8")
        blocks = re.findall(r"^```c\n(.*?)^```$", (ROOT / "docs/engines.md").read_text(encoding="utf-8"), re.M | re.S)
        self.assertEqual(len(blocks), 3)
        for block in blocks:
            self.assertIn(block, program, "change docs/engines.md with tests/e2e/consumer/engine.c")


if __name__ == "__main__":
    unittest.main()
