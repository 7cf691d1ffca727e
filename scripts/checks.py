# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared by scripts/check_*.py: the files of the tree, made-up trees that test a check, and the command line."""
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def files_of(root):
    """Every file of the tree but builds, outputs and hidden folders other than .ci; sorted."""
    def skipped(relative):
        top = relative.parts[0]
        hidden = any(p.startswith(".") and p != ".ci" for p in relative.parts[:-1])
        return hidden or top == "out" or top.startswith("build") or "__pycache__" in relative.parts
    relatives = (p.relative_to(root) for p in sorted(root.rglob("*")) if p.is_file())
    return [r for r in relatives if not skipped(r)]


def plant(root, files):
    """Writes a made-up tree."""
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")


def tree_faults(check, good, bad):
    """Faults of a check itself, as text lines. `good`: files that must pass; `bad`: files, each with the line and a part
    of the message of the one fault that must be found in it. An empty tree must have one fault, too."""
    wrong = []
    with tempfile.TemporaryDirectory(prefix="check-") as folder:
        root = Path(folder)
        plant(root, good)
        wrong += [f"a good tree fails: {fault}" for fault in check(root)]
        plant(root, {name: text for name, (text, _, _) in bad.items()})
        faults = check(root)
        for name, (_, line, message) in bad.items():
            mine = [f for f in faults if f.startswith(name + ":")]
            if len(mine) != 1 or not mine[0].startswith(f"{name}:{line}:") or message not in mine[0]:
                wrong.append(f"{name}:{line}: expected one fault with \"{message}\", got {mine}")
        if len(faults) != len(bad):
            wrong.append(f"expected {len(bad)} faults, got {len(faults)}")
    with tempfile.TemporaryDirectory(prefix="check-") as folder:
        if len(check(Path(folder))) != 1:
            wrong.append("an empty tree passes")
    return wrong


def main(name, usage, check, self_test):
    """Runs check(root) or self_test(), prints the faults that they return and ends with 3 if there are any."""
    arguments = sys.argv[1:]
    if arguments == ["--self-test"]:
        faults = self_test()
    elif len(arguments) <= 1 and not any(a.startswith("-") for a in arguments):
        faults = check(Path(arguments[0]) if arguments else ROOT)
    else:
        print(usage, file=sys.stderr)
        sys.exit(1)
    for fault in faults:
        print(fault)
    print(f"{name}: {len(faults)} faults" if faults else f"{name}: ok")
    sys.exit(3 if faults else 0)
