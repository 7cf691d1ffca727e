#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layout of our C and C++ sources: what clang-format 14 makes of them with the tree's .clang-format, and at most 120
columns in comments, which the formatter leaves alone (it would break sentences).

    scripts/check_format.py [ROOT]      check the tree; prints FILE:LINE: MESSAGE for each fault; exit code 3 if any,
                                        77 where clang-format-14 is not installed
    scripts/check_format.py --self-test check a sample tree whose faults are known
"""
import re
import shutil
import subprocess
import sys

import checks

FORMATTER = "clang-format-14"
COLUMNS = 120
COMMENT = re.compile(r"//|^\s*/?\*")
ENDINGS = (".c", ".cpp", ".h")
FAULT = re.compile(r"^(.*?):(\d+):\d+: \w+: code should be clang-formatted", re.M)


def check(root):
    """One fault a file, at its first line that is laid out otherwise, and one for each comment that is too long."""
    files = [f for f in checks.files_of(root) if f.suffix in ENDINGS]
    if not files:
        return ["no sources found"]
    command = [FORMATTER, f"--style=file:{checks.ROOT / '.clang-format'}", "--dry-run", *map(str, files)]
    printed = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False).stderr
    first = {}
    for file, line in FAULT.findall(printed):
        first.setdefault(file, line)
    faults = [f"{file}:{line}: laid out otherwise; run {FORMATTER} -i {file}" for file, line in first.items()]
    for file in files:
        for number, line in enumerate((root / file).read_text(encoding="utf-8").split("\n"), 1):
            if len(line) > COLUMNS and COMMENT.search(line):
                faults.append(f"{file}:{number}: {len(line)} columns, {COLUMNS} allowed")
    return faults


def self_test():
    """Faults of the check itself, as text lines."""
    good = {"a/good.h": f"// {'x' * (COLUMNS - 3)}\nint twice(int x);\n", "a/good.c": "int twice(int x) {\n    return 2 * x;\n}\n"}
    bad = {"a/wide.cpp": ("int a;\nint twice( int x );\n", 2, "laid out otherwise"),
           "a/tab.c": ("int once(int x) {\n\treturn x;\n}\n", 1, "clang-format-14 -i a/tab.c"),
           "a/long.h": (f"// {'x' * (COLUMNS - 2)}\nint x;\n", 1, "121 columns")}
    return checks.tree_faults(check, good, bad)


if __name__ == "__main__":
    if not shutil.which(FORMATTER):
        print(f"check_format: {FORMATTER} is not installed")
        sys.exit(77)
    checks.main("check_format", __doc__, check, self_test)
