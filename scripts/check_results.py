#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""No value() of a Result that may hold an error: inside the runtime each is asked first.

    scripts/check_results.py [ROOT]      check libdgm/; prints FILE:LINE: MESSAGE for each fault; exit code 3 if any
    scripts/check_results.py --self-test check lines that must fail, and some that must pass

Result::value() of an error aborts the process that loaded the library. So value() is asked only of a variable, never of
a call, and only after `if (!x)`, `if (auto x = ...)` or `x ? ...` in the same function. One
such question is enough for a `const auto x = ...`: it never changes.
"""
import re

import checks

USE = re.compile(r"(?P<of>[\w.\]\[>-]+|\w+\([^()]*\)|\))\s*\.value\(\)")
MOVED = re.compile(r"std::move\((\w+)\)\s*\.value\(\)")


def asked(name, before):
    """Some line of the function so far branches on whether the result is ok."""
    n = re.escape(name)
    question = (rf"if \(!{n}\)|if \(!{n} (?:&&|\|\|)|if \((?:const )?auto&? {n} =|\b{n} \?|if \({n}\)|!{n} \|\||{n}\.ok\(\)")
    return re.search(question, before) is not None


def faults_of(text):
    faults, function = [], 0
    lines = text.split("\n")
    for number, line in enumerate(lines):
        if re.match(r"[A-Za-z]", line) and not line.startswith(("namespace", "struct", "class")) and "(" in line:
            function = number  # a function starts at the margin
        code = line.split("//")[0]
        if ".value()" not in code:
            continue
        moved = MOVED.findall(code)
        rest = MOVED.sub("", code)
        before = "\n".join(lines[function:number + 1])
        for name in moved:
            if not asked(name, before):
                faults.append((number + 1, f"value() of {name}, which has not been asked whether it is one"))
        for use in USE.finditer(rest):
            name = use.group("of")
            if name.endswith(")"):
                faults.append((number + 1, "value() of a call, which may have failed"))
            elif not asked(name, before):
                faults.append((number + 1, f"value() of {name}, which has not been asked whether it is one"))
    return faults


def check(root):
    return [f"{path.relative_to(root)}:{number}: {message}" for path in sorted((root / "libdgm").rglob("*"))
            if path.suffix in (".cpp", ".h") for number, message in faults_of(path.read_text(encoding="utf-8"))]


def self_test():
    bad = ("void f() {\n    out = g(1, 2).value();\n}\n",
           "void f() {\n    auto x = g();\n    use(x.value());\n}\n",
           "void f() {\n    if (!x) return;\n}\nvoid h() {\n    use(x.value());\n}\n",
           "void f() {\n    auto x = g();\n    use(std::move(x).value());\n}\n")
    good = ("void f() {\n    auto x = g();\n    if (!x) return;\n    use(x.value());\n}\n",
            "void f() {\n    if (const auto x = g()) use(x.value());\n}\n",
            "void f() {\n    auto x = g();\n    if (!x) return;\n    use(std::move(x).value());\n}\n")
    return ([f"no fault in:\n{text}" for text in bad if len(faults_of(text)) != 1] +
            [f"a fault in:\n{text}" for text in good if faults_of(text)])


if __name__ == "__main__":
    checks.main("check_results", __doc__, check, self_test)
