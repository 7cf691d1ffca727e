# SPDX-License-Identifier: GPL-3.0-or-later
"""Are the bytes of the samples' bakes those of the last accepted change?

    test_hashes.py DGM_BAKE SAMPLES

Bytes are the same from run to run and from processor to processor, but another compiler's standard library may sort or
draw differently: on a platform other than the one in hashes.json the test is skipped. Wanted changes:
scripts/update_golden.py.
"""
import json
import sys
import unittest

import golden

BAKE, SAMPLES = sys.argv[1:3]


class Hashes(unittest.TestCase):
    def test_bytes(self):
        kept = json.loads(golden.HASHES.read_text(encoding="utf-8"))
        if kept["platform"] != golden.this_platform():
            self.skipTest(f"made on {kept['platform']}, this is {golden.this_platform()}")
        found = golden.hashes(BAKE, SAMPLES)
        self.assertEqual(sorted(found), sorted(golden.CASES["auto"]))
        self.assertEqual(found, kept["hashes"], "after a wanted change: scripts/update_golden.py")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
