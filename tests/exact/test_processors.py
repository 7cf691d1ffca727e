# SPDX-License-Identifier: GPL-3.0-or-later
"""Do bakes give the same bytes on other processors, with other C libraries and numbers of threads?

    test_processors.py DGM_BAKE_BITS ROUGH_MATHS SAMPLES
"""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, ROUGH_MATHS, SAMPLES = sys.argv[1:4]
# Both spellings: glibc has renamed them, and ignores those that it does not know.
NO_FMA = "glibc.cpu.hwcaps=" + ",".join(f"-{name}{end}" for name in ("AVX512F", "AVX2", "FMA", "FMA4", "AVX")
                                        for end in ("", "_Usable"))


def bits(*arguments, before=(), **environment):
    """{case: hashes} of one run."""
    with tempfile.TemporaryDirectory(prefix="dgm-exact-") as folder:
        result = subprocess.run([*before, PROGRAM, SAMPLES, folder, *arguments], env={**os.environ, **environment},
                                capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise RuntimeError(f"exit code {result.returncode}\n{result.stdout}{result.stderr}")
    return dict(line.split(" ", 1) for line in result.stdout.splitlines())


class Processors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.here = bits()

    def compare(self, there, here=None, at_least=5):
        here = here or self.here
        self.assertEqual(list(there), list(here))
        self.assertGreaterEqual(len(there), at_least)
        different = [name for name in here if here[name] != there[name] and name != "control"]
        self.assertEqual(different, [])

    def test_one_thread_no_fused_instructions_another_c_library(self):
        """All three at once, as each takes all cases; only where that fails, one by one, to say which it was."""
        changes = ((("--threads", "1"), {}), ((), {"GLIBC_TUNABLES": NO_FMA}), ((), {"LD_PRELOAD": ROUGH_MATHS}))
        there = bits(*(argument for arguments, _ in changes for argument in arguments),
                     **{name: value for _, environment in changes for name, value in environment.items()})
        self.assertNotEqual(there["control"], self.here["control"], "nothing was put before the C library's functions")
        try:
            self.compare(there)
        except AssertionError:
            for arguments, environment in changes:
                with self.subTest(arguments=arguments, environment=environment):
                    self.compare(bits(*arguments, **environment))
            raise

    def test_this_processor_has_fused_instructions(self):
        if bits("--case", "none", GLIBC_TUNABLES=NO_FMA)["control"] == self.here["control"]:
            self.skipTest("or this C library takes no advice: the test before this one compared less")

    def test_emulated_processors(self):
        """Libraries that choose their loops, and blocks for caches, by what the processor says of itself."""
        qemu = shutil.which("qemu-x86_64")
        if not qemu or os.uname().machine != "x86_64":
            self.skipTest("needs qemu-x86_64 (Debian: qemu-user) and an x86-64 machine")
        # An emulator takes five times as long for AVX2 and fused instructions: there one bake stands for the others.
        few = bits("--few")
        sheet = {name: few[name] for name in ("control", "sheet")}
        for model, cases, here in (("Nehalem", ["--few"], few), ("Haswell", ["--case", "sheet"], sheet)):
            with self.subTest(model=model):
                self.compare(bits(*cases, before=(qemu, "-cpu", model)), here, len(here))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
