#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""No function whose bits depend on the machine decides a byte: reads every source of the tools, the formats, the sample
shapes and the runtime.

    scripts/check_math.py [ROOT]      prints FILE:LINE: MESSAGE for each fault; exit code 3 if any
    scripts/check_math.py --self-test check a made-up tree that must fail, and one that must pass

The C library's transcendental functions are chosen by the processor and differ from one library to the next: math::
(formats/math/portable.h) and portable_* (libdgm) stand in for them. <random>'s distributions are the standard
library's own, too; its engines are defined. dgm-bench is left out: its figures are times.
"""
import re

import checks

NAMES = ("exp exp2 expm1 log log2 log10 log1p pow sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh cbrt "
         "hypot erf erfc tgamma lgamma").split()
FOLDERS = ("cli", "formats", "libdgm", "samples/generate")
LEFT_OUT = ("cli/bench/",)
LIBRARY = re.compile(rf"(?<![\w:])(?:std)?::(?:{'|'.join(NAMES)})[fl]?\b(?!\s*::)|(?<![\w:.>])(?:{'|'.join(NAMES)})[fl]\(")
RANDOM = re.compile(r"std::\w+_distribution\b")


def faults_of(text):
    """(line, message) of each fault."""
    faults = []
    for number, line in enumerate(text.split("\n"), 1):
        code = line.split("//")[0]
        if match := LIBRARY.search(code):
            faults.append((number, f"{match.group().rstrip('(')} rounds as the processor and the C library like; "
                                   "use math/portable.h"))
        if match := RANDOM.search(code):
            faults.append((number, f"{match.group()} is another function in another standard library; use the engine's "
                                   "numbers"))
    return faults


def check(root):
    faults, checked = [], 0
    for relative in checks.files_of(root.resolve()):
        path = relative.as_posix()
        if relative.suffix not in (".h", ".cpp") or not path.startswith(tuple(f + "/" for f in FOLDERS)):
            continue
        if path.startswith(LEFT_OUT):
            continue
        checked += 1
        text = (root / relative).read_text(encoding="utf-8", errors="replace")
        faults += [f"{path}:{number}: {message}" for number, message in faults_of(text)]
    if checked == 0:
        faults.append(f"{root}: no source file found")
    return faults


GOOD = {
    "cli/geometry/a.cpp": "double f(double x) { return math::sin(x) + std::sqrt(x); }  // not std::sin\n",
    "cli/bench/b.cpp": "double f(double x) { return std::log(x); }\n",
    "formats/c.h": "StageLog log(progress);\nusing std::exponential;\nlog.pow(2);\n",
}
BAD = {  # file: (text, line of the fault, part of the message)
    "cli/geometry/call.cpp": ("\ndouble f(double x) { return std::sin(x); }\n", 2, "std::sin rounds"),
    "cli/geometry/name.cpp": ("auto f = std::pow;\n", 1, "std::pow rounds"),
    "formats/global.h": ("double y = ::exp(x);\n", 1, "::exp rounds"),
    "libdgm/src/base/single.cpp": ("float y = expf(x);\n", 1, "expf rounds"),
    "samples/generate/dice.cpp": ("std::normal_distribution<double> d;\n", 1, "another standard library"),
}


def self_test():
    return checks.tree_faults(check, GOOD, BAD)


if __name__ == "__main__":
    checks.main("check_math", __doc__, check, self_test)
