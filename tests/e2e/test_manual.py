# SPDX-License-Identifier: GPL-3.0-or-later
"""Help, man pages and completion tell of the same options, and of those that are there; errors name the next step."""
import os
import re
import shutil
import subprocess
import unittest
from pathlib import Path

import support

MANUAL = Path(os.environ.get("DGM_MANUAL", "."))
PROGRAMS = {"dgm-bake": support.BAKE, "dgm-validate": support.VALIDATE, "dgm-info": os.environ.get("DGM_INFO", ""),
            "dgm-export": support.EXPORT}
if support.BENCH:
    PROGRAMS["dgm-bench"] = support.BENCH
COMMANDS = {"dgm-bench": ("bake", "run", "stability", "scale")}


class Manual(support.Folder):
    def options_in_help(self, program):
        text = self.run_program(program, "--help").stdout
        return text, self.options_of(text)

    @staticmethod
    def options_of(text):
        return set(re.findall(r"^ +(?:-\w,)?(--[a-z-]+)", text, re.MULTILINE))

    def options_of_commands(self, name):
        """Those of each command of a program: {"bake": {"--sizes", ...}, ...}."""
        return {command: self.options_of(self.run_program(PROGRAMS[name], command, "--help").stdout)
                for command in COMMANDS.get(name, ())}

    def test_the_page_has_what_help_has(self):
        for name, program in PROGRAMS.items():
            text, options = self.options_in_help(program)
            self.assertIn("--version", options, name)
            self.assertIn("Examples:", text)
            self.assertIn("Exit codes:", text)
            page = (MANUAL / f"{name}.1").read_text()
            in_page = set(re.findall(r"\\fB(--[a-z-]+)\\fR", page.replace("\\-", "-")))
            commands = self.options_of_commands(name)
            self.assertEqual(in_page, options.union(*commands.values()), name)
            for command, its in commands.items():  # in the part of the page that is about it
                part = page.split(f"\n.SS {command}\n")[1].split("\n.SS ")[0].split("\n.SH ")[0]
                self.assertEqual(set(re.findall(r"\\fB(--[a-z-]+)\\fR", part.replace("\\-", "-"))), its, command)
            for line in text.splitlines():  # each example as it stands in the help
                if line.startswith(f"  {name} "):
                    self.assertIn(line.strip(), page.replace("\\-", "-").replace("\\e", "\\"))

    @unittest.skipUnless(shutil.which("groff"), "groff is not installed")
    def test_groff_has_nothing_to_complain_about(self):
        for name in PROGRAMS:
            result = subprocess.run(["groff", "-man", "-ww", "-Tutf8", "-z", MANUAL / f"{name}.1"], capture_output=True,
                                    text=True, check=False)
            self.assertEqual((result.returncode, result.stderr), (0, ""), name)

    def complete(self, name, *words, shell="bash"):
        """What TAB offers at the end of the last word."""
        start = "autoload -U compinit bashcompinit; compinit -u -D; bashcompinit; " if shell == "zsh" else ""
        typed = " ".join(f"'{word}'" for word in words)
        script = (f"{start}source '{MANUAL}/{name}.bash'; COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; _{name.replace('-', '_')} {name} '{words[-1]}' '{words[-2]}'; "
                  "printf '%s\\n' \"${COMPREPLY[@]}\"")
        result = subprocess.run([shell, "-c", script], cwd=self.folder, capture_output=True, text=True, check=False)
        # Of what it is offered, zsh itself drops what does not begin with the word.
        return [word.strip() for word in result.stdout.splitlines()
                if word.strip() and (shell == "bash" or word.startswith(words[-1]))]

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not installed")
    def test_completion_of_zsh_itself(self):
        """What the function hands to zsh's _arguments; with each command of a program, for its options."""
        for name, program in PROGRAMS.items():
            commands = self.options_of_commands(name)
            for command, options in [("", self.options_in_help(program)[1]), *commands.items()]:
                script = ("_files() { }; _arguments() { print -rl -- \"$@\"; state=rest; }; "
                          f"words=({command}); source '{MANUAL}/_{name}'")
                result = subprocess.run(["zsh", "-f", "-c", script], cwd=self.folder, capture_output=True, text=True,
                                        check=False, timeout=60)
                self.assertEqual((result.returncode, result.stderr), (0, ""), name)
                specs = result.stdout.splitlines()
                offered = set(re.findall(r"^\([^)]*\)(--[a-z-]+)\[", "\n".join(specs), re.MULTILINE))
                self.assertEqual(offered, self.options_in_help(program)[1] | options, f"{name} {command}")
                if name == "dgm-bake":
                    self.assertIn("(--fit)--fit[sample\\: samples lie on the surface]:sample|l2|best:(sample l2 best)", specs)

    @unittest.skipUnless(shutil.which("fish"), "fish is not installed")
    def test_completion_in_fish(self):
        def offered(name, typed):
            script = f"source '{MANUAL}/{name}.fish'; complete -C '{typed}'"
            result = subprocess.run(["fish", "--no-config", "-c", script], cwd=self.folder, capture_output=True, text=True,
                                    check=False)
            self.assertEqual(result.stderr, "")
            return [line.split("\t")[0] for line in result.stdout.splitlines()]
        for name, program in PROGRAMS.items():
            self.assertEqual(set(offered(name, f"{name} --")), self.options_in_help(program)[1], name)
        self.assertEqual(sorted(offered("dgm-bake", "dgm-bake --fit ")), ["best", "l2", "sample"])
        (self.folder / "two words.obj").write_text("")
        self.assertEqual(offered("dgm-bake", "dgm-bake -o tw"), ["two words.obj"])
        if support.BENCH:
            self.assertTrue(set(COMMANDS["dgm-bench"]) <= set(offered("dgm-bench", "dgm-bench ")))

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not installed")
    def test_completion_in_zsh(self):
        (self.folder / "two words.obj").write_text("")
        self.assertEqual(self.complete("dgm-bake", "dgm-bake", "--fit", "", shell="zsh"), ["sample", "l2", "best"])
        self.assertEqual(self.complete("dgm-bake", "dgm-bake", "--rep", shell="zsh"), ["--report", "--report-format"])
        self.assertEqual(self.complete("dgm-bake", "dgm-bake", "tw", shell="zsh"), ["two words.obj"])

    def test_completion(self):
        (self.folder / "two words.obj").write_text("")
        (self.folder / "twins.json").write_text("")
        for name, program in PROGRAMS.items():
            offered = set(self.complete(name, name, "--"))
            self.assertEqual(offered, self.options_in_help(program)[1], name)
        for name, commands in COMMANDS.items():
            if name in PROGRAMS:
                self.assertEqual(self.complete(name, name, ""), list(commands))
                for command, options in self.options_of_commands(name).items():
                    self.assertEqual(set(self.complete(name, name, command, "--")), options, command)
                self.assertEqual(sorted(self.complete(name, name, commands[0], "tw")), ["twins.json", "two words.obj"])
        self.assertEqual(self.complete("dgm-bake", "dgm-bake", "--fit", ""), ["sample", "l2", "best"])
        self.assertEqual(self.complete("dgm-bake", "dgm-bake", "--method", "sl"), ["slim"])
        self.assertEqual(self.complete("dgm-bake", "dgm-bake", "--rep"), ["--report", "--report-format"])
        self.assertEqual(sorted(self.complete("dgm-bake", "dgm-bake", "-o", "tw")), ["twins.json", "two words.obj"])
        self.assertEqual(sorted(self.complete("dgm-bake", "dgm-bake", "tw")), ["twins.json", "two words.obj"])

    def test_what_was_meant(self):
        for program, wrong, right in [("dgm-bake", "--siez", "--size"), ("dgm-bake", "--max-eror=1%", "--max-error"),
                                      ("dgm-bake", "--fource", "--force"), ("dgm-validate", "--sorce", "--source"),
                                      ("dgm-info", "--jsn", "--json"), ("dgm-export", "--shet", "--sheet")]:
            needed = ["-o", "x.ply"] if program == "dgm-export" else []
            result = self.run_program(PROGRAMS[program], "x.dgm", wrong, *needed)
            self.assertEqual(result.returncode, 1, wrong)
            self.assertIn(f"there is no option {wrong.split('=')[0]}; did you mean {right}?", result.stderr)
            self.assertIn("next: ", result.stderr)
        result = self.bake("x.obj", "--entirely-different")
        self.assertIn("there is no option --entirely-different\n", result.stderr)
        self.assertIn("dgm-bake --help", result.stderr)

    def test_lines_fit_a_terminal(self):
        for name, program in PROGRAMS.items():
            page = subprocess.run(["groff", "-man", "-Tutf8", MANUAL / f"{name}.1"], capture_output=True, text=True,
                                  check=False) if shutil.which("groff") else None
            if page is not None:
                self.assertIn("EXIT STATUS", re.sub(r".\x08|\x1b\[[0-9;]*m", "", page.stdout))


if __name__ == "__main__":
    unittest.main()
