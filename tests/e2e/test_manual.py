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
            "dgm-export": support.EXPORT, "dgm-edit": support.EDIT}
if support.BENCH:
    PROGRAMS["dgm-bench"] = support.BENCH
SECTIONS = ["Examples", "Files", "Environment", "Exit codes"]  # of every help, in this order, at its end
PAGE_SECTIONS = ["EXAMPLES", "FILES", "ENVIRONMENT", "EXIT STATUS", "SEE ALSO"]
READS_SCENES = ("dgm-bake", "dgm-info")
COLUMNS = 100
REPOSITORY = Path(__file__).resolve().parents[2]
COMMANDS = {"dgm-bench": ("bake", "run", "physics", "cloth", "stability", "scale")}


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

    def helps(self):
        """(name, text) of each help: of every program, and of every command of one."""
        for name, program in PROGRAMS.items():
            yield name, self.run_program(program, "--help").stdout
            for command in COMMANDS.get(name, ()):
                yield f"{name} {command}", self.run_program(program, command, "--help").stdout

    def page(self, name):
        return (MANUAL / f"{name}.1").read_text().replace("\\-", "-").replace("\\e", "\\")

    def test_every_help_has_the_same_sections(self):
        for name, text in self.helps():
            headings = [line[:-1] for line in text.splitlines() if re.fullmatch(r"\S.*:", line)]
            scenes = ["Scene files"] if name in READS_SCENES else []
            self.assertEqual(headings[-len(scenes + SECTIONS):], scenes + SECTIONS, name)
            self.assertEqual("Scene files" in headings, bool(scenes), name)
            usage = text.splitlines().index(next(line for line in text.splitlines() if line.startswith("Usage: ")))
            self.assertTrue(text.splitlines()[usage].startswith(f"Usage: {name} "), text)
            self.assertGreaterEqual(usage, 2, "a description comes first")
            if name not in ("dgm-bench cloth", "dgm-bench stability", "dgm-bench scale"):  # which take no files
                self.assertEqual(headings[0], "Commands" if name in COMMANDS else "Arguments", name)
            self.assertEqual(text.count(f"\n  {name} ") + text.count(f"\n  {name}\n"), len(
                re.findall(rf"^  {name}(?: .*)?\n      \S", text, re.MULTILINE)), f"{name}: each example says what it does")
            self.assertGreater(text.count(f"\n  {name} "), 0, name)

    def test_every_page_has_the_same_sections(self):
        for name in PROGRAMS:
            headings = re.findall(r"^\.SH (.*)$", self.page(name), re.MULTILINE)
            middle = (["COMMANDS"] if name in COMMANDS else []) + (["SCENE FILES"] if name in READS_SCENES else [])
            self.assertEqual(headings, ["NAME", "SYNOPSIS", "OPTIONS"] + middle + PAGE_SECTIONS, name)

    def test_help_of_all_programs_uses_the_same_words(self):
        """What one option or code means, it means in all of them."""
        texts = dict(self.helps())
        for line in ("  -h,--help                   show this and stop", "  -V,--version                show the version and stop",
                     "  1    the command line is wrong", "  2    a file cannot be read or written"):
            for name, text in texts.items():
                if "--version" not in line or " " not in name:
                    self.assertIn(line, text.splitlines(), name)
        for name, text in texts.items():
            self.assertRegex(text, r"\n  4    internal error(, or a library crashed)?\n", name)
            self.assertNotRegex(text, r"\b(TEXT|UINT|INT|FLOAT|REQUIRED|Needs|Excludes)\b", name)

    def test_help_fits_a_terminal(self):
        for name, text in self.helps():
            for line in text.splitlines():
                self.assertLessEqual(len(line), COLUMNS, f"{name}: {line}")

    def test_usage_is_the_synopsis(self):
        for name in PROGRAMS:
            text = self.run_program(PROGRAMS[name], "--help").stdout
            usage = text.split("Usage: ")[1].split("\n\n")[0]
            synopsis = self.page(name).split(".SH SYNOPSIS\n.nf\n")[1].split("\n.fi")[0]
            self.assertEqual([line.strip() for line in usage.splitlines()], synopsis.splitlines(), name)

    def test_scene_keys(self):
        """Help, page, document and the reader know the same keys."""
        document = (REPOSITORY / "docs/scenes.md").read_text()
        table = document.split("| key | meaning | default |")[1].split("\n\n")[0]
        known = {key for row in table.splitlines() if row.startswith("| `") for key in re.findall(r"`(\w+)`", row.split("|")[1])}
        (self.folder / "scene.toml").write_text('[scene]\nwrong = 1\n[[asset]]\nsource = "x.obj"\n')
        self.assertIn("tick_budget", self.keys_of(self.run_program(PROGRAMS["dgm-info"], "scene.toml").stderr))
        (self.folder / "scene.toml").write_text('[[asset]]\nsource = "x.obj"\nwrong = 1\n')
        result = self.run_program(PROGRAMS["dgm-info"], "scene.toml")
        reader = self.keys_of(result.stderr)
        self.assertGreater(len(reader), 20)
        self.assertEqual(known, reader, "docs/scenes.md")
        for name in READS_SCENES:
            text = " ".join(self.run_program(PROGRAMS[name], "--help").stdout.split())
            self.assertEqual(set(text.split(" Keys: ")[1].split(". Their")[0].split(", ")), reader | {"tick_budget"}, name)
            section = self.page(name).split(".SH SCENE FILES\n")[1].split("\n.SH ")[0]
            self.assertEqual(set(re.findall(r"^\.B (.*)$", section, re.MULTILINE)), reader | {"tick_budget"}, name)

    @staticmethod
    def keys_of(message):
        return set(message.split("there are: ")[1].splitlines()[0].split(", "))

    def test_the_sample_scene_of_the_page_is_one(self):
        sample = self.page("dgm-info").split(".SH SCENE FILES\n")[1].split(".nf\n")[1].split("\n.fi")[0]
        (self.folder / "scene.toml").write_text(sample)
        (self.folder / "stomach.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        result = self.run_program(PROGRAMS["dgm-info"], "scene.toml")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("stomach", result.stdout)

    def test_version(self):
        """The project's version in all programs, and the commit where the sources are a checkout of git."""
        number = re.search(r"project\(dgm VERSION ([\d.]+)", (REPOSITORY / "CMakeLists.txt").read_text()).group(1)
        versions = set()
        for name, program in PROGRAMS.items():
            text = self.run_program(program, "--version").stdout
            self.assertEqual(text, self.run_program(program, "-V").stdout)
            match = re.fullmatch(rf"{name} ({re.escape(number)}(?: \([0-9a-f]{{7,40}}(?:, modified)?\))?)\n", text)
            self.assertIsNotNone(match, text)
            versions.add(match.group(1))
            self.assertIn(f'"dgm {number}"', self.page(name).splitlines()[0])
        self.assertEqual(len(versions), 1, versions)
        if (REPOSITORY / ".git").exists() and shutil.which("git"):
            self.assertIn("(", versions.pop())

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
        """The offers of TAB at the end of the last word."""
        start = "autoload -U compinit bashcompinit; compinit -u -D; bashcompinit; " if shell == "zsh" else ""
        typed = " ".join(f"'{word}'" for word in words)
        script = (f"{start}source '{MANUAL}/{name}.bash'; COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; _{name.replace('-', '_')} {name} '{words[-1]}' '{words[-2]}'; "
                  "printf '%s\\n' \"${COMPREPLY[@]}\"")
        result = subprocess.run([shell, "-c", script], cwd=self.folder, capture_output=True, text=True, check=False)
        # zsh itself drops the offers that do not begin with the word.
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
        for name in PROGRAMS:
            command = COMMANDS.get(name, ("",))[:1]
            words = [word for word in command if word]
            needed = ["-o", "x.ply"] if name == "dgm-export" else []
            result = self.run_program(PROGRAMS[name], *words, "x.dgm", "--entirely-different", *needed)
            self.assertEqual(result.stderr.splitlines(),
                             [f"{name}: DGM6001: there is no option --entirely-different",
                              f"  see all with: {' '.join([name, *words])} --help", "  next: see --help"])

    def test_a_missing_argument(self):
        for name, argument in [("dgm-bake", "INPUT"), ("dgm-validate", "FILE"), ("dgm-info", "FILE"),
                               ("dgm-export", "FILE"), ("dgm-bench", "A subcommand")]:
            if name not in PROGRAMS:
                continue
            needed = ["-o", "x.ply"] if name == "dgm-export" else []
            result = self.run_program(PROGRAMS[name], *needed)
            self.assertEqual(result.returncode, 1, name)
            self.assertRegex(result.stderr, rf"^{name}: DGM6001: {argument} is required; for instance: {name} .*\n  next: see --help\n$")

    @unittest.skipUnless(shutil.which("groff"), "groff is not installed")
    def test_pages_are_set(self):
        for name in PROGRAMS:
            page = subprocess.run(["groff", "-man", "-Tutf8", MANUAL / f"{name}.1"], capture_output=True, text=True,
                                  check=False)
            self.assertIn("EXIT STATUS", re.sub(r".\x08|\x1b\[[0-9;]*m", "", page.stdout), name)


if __name__ == "__main__":
    unittest.main()
