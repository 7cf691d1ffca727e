# SPDX-License-Identifier: GPL-3.0-or-later
"""One wording for one fault: whichever program meets it, the same code, the same words and the file's name."""
import re
import unittest

import support

BAKE, VALIDATE, INFO, EXPORT, BENCH = support.BAKE, support.VALIDATE, support.INFO, support.EXPORT, support.BENCH
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
NOWHERE = "/proc/no-such-folder"  # not even root makes a folder there


class Wording(support.Folder):
    def setUp(self):
        super().setUp()
        (self.folder / "tri.obj").write_text(TRIANGLE)
        self.bake_well("tri.obj", "--size", "5")

    def fault(self, *command):
        """(exit code, the line with the code without the program's name) of a run that fails."""
        result = self.run_program(*command)
        text = result.stderr + result.stdout
        lines = [line for line in text.splitlines() if re.search(r"DGM\d{4}", line)]
        self.assertGreaterEqual(len(lines), 1, f"{command}\n{text}")
        self.assertNotEqual(result.returncode, 0, command)
        return result.returncode, re.sub(r"^dgm-\w+: ", "", lines[0])

    def runs(self, *commands):
        """Those whose program was built."""
        return [command for command in commands if command[0]]

    def expect(self, exit_code, code, place, message, commands):
        for command in self.runs(*commands):
            got, line = self.fault(*command)
            if command[0] == VALIDATE and "error:" in line:  # a finding, as dgm-validate lists it
                self.assertRegex(line, rf"^{code} error: {re.escape(place)}: (?:[\w ]+: )?{message} — ", command)
            else:
                self.assertRegex(line, rf"^{re.escape(place)}: (?:import: )?{code}: {message}$", command)
            self.assertEqual(got, exit_code, command)

    def test_a_missing_file(self):
        self.expect(2, "DGM5001", "no.dgm", "there is no such file", [
            (INFO, "no.dgm"), (INFO, "tri.dgm", "no.dgm", "--diff"), (BENCH, "run", "no.dgm"),
            (VALIDATE, "no.dgm")])
        self.expect(2, "DGM5001", "no.exr", "there is no such file", [(VALIDATE, "no.exr")])
        self.expect(2, "DGM5001", "no.dgm", "there is no such file or folder", [(EXPORT, "no.dgm", "-o", "x.ply")])
        self.expect(2, "DGM5001", "no.obj", "there is no such file",
                    [(EXPORT, "tri.dgm", "-o", "x.png", "--source", "no.obj"), (VALIDATE, "tri.dgm", "--source", "no.obj"),
                     (BENCH, "bake", "no.obj")])
        self.expect(2, "DGM5001", "no.obj", "there is no such file or folder", [(BAKE, "no.obj")])
        self.expect(2, "DGM5001", "no.toml", "there is no such file", [(BAKE, "no.toml"), (INFO, "no.toml")])
        self.expect(2, "DGM5001", "no.json", "there is no such file",
                    [(BAKE, "--merge-reports", "no.json"), (VALIDATE, "tri.dgm", "--baseline", "no.json"),
                     (BENCH, "run", "tri.dgm", "--compare", "no.json")])
        self.expect(2, "DGM5001", "no.png", "there is no such file", [(BAKE, "tri.obj", "--texture", "no.png")])
        self.expect(2, "DGM5001", "no.csv", "there is no such file", [(BENCH, "run", "tri.dgm", "--path", "no.csv")])

    def test_a_folder_instead_of_a_file(self):
        (self.folder / "folder.dgm").mkdir()
        self.expect(2, "DGM5002", "folder.dgm", "not a regular file", [(BENCH, "run", "folder.dgm")])
        self.expect(2, "DGM5001", "folder.dgm", "the folder holds no maps",
                    [(INFO, "folder.dgm"), (EXPORT, "folder.dgm", "-o", "x.ply"), (VALIDATE, "folder.dgm")])

    def test_the_wrong_kind_of_file(self):
        for name in ("text.dgm", "mesh.dgm"):
            (self.folder / name).write_text("hello\n" if name == "text.dgm" else TRIANGLE)
            self.expect(3, "DGM1001", name, "no DGM index at the start of the file", [
                (INFO, name), (EXPORT, name, "-o", "x.ply"), (BENCH, "run", name), (VALIDATE, name)])

    def test_an_unknown_word(self):
        for command in self.runs((BAKE, "tri.obj", "--layers", "nomral"), (EXPORT, "tri.dgm", "-o", "x.png", "--layer", "nomral"),
                                 (BENCH, "bake", "tri.obj", "--layers", "nomral")):
            result = self.run_program(*command)
            self.assertIn('there is no layer "nomral"; did you mean normal?\n', result.stderr)
            self.assertRegex(result.stderr, r"\n  there are: geometry, normal")
        for command in self.runs((BAKE, "tri.obj", "--method", "stretc"), (BENCH, "stability", "--methods", "stretc"),
                                 (BENCH, "bake", "tri.obj", "--methods", "stretc")):
            result = self.run_program(*command)
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertIn('there is no method "stretc"; did you mean stretch?\n', result.stderr)

    def test_an_unwritable_output(self):
        self.expect(2, "DGM5003", f"{NOWHERE}/x.ply", "the file cannot be written: No such file or directory",
                    [(EXPORT, "tri.dgm", "-o", f"{NOWHERE}/x.ply")])
        self.expect(2, "DGM5003", f"{NOWHERE}/x.json", "the file cannot be written: No such file or directory",
                    [(VALIDATE, "tri.dgm", "--report", f"json={NOWHERE}/x.json"),
                     (VALIDATE, "tri.dgm", "--write-baseline", f"{NOWHERE}/x.json")])
        self.expect(2, "DGM5003", NOWHERE, "the folder cannot be made: No such file or directory",
                    [(BAKE, "tri.obj", "-o", f"{NOWHERE}/x.dgm"), (BENCH, "run", "tri.dgm", "-o", NOWHERE)])


if __name__ == "__main__":
    unittest.main()
