#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lengths of functions and classes in our C and C++ sources.

    scripts/check_sizes.py [ROOT]      check the tree; prints FILE:LINE: MESSAGE for each fault; exit code 3 if any
    scripts/check_sizes.py --self-test check a sample whose lengths are known
    scripts/check_sizes.py --list N    print the N longest of each

A length is that of the lines from the head to the closing brace; a class counts its members' bodies where they stand
inside it. Exceptions stand in LONGER, with the length each may have: the list may only shrink.
"""
import dataclasses
import re
import sys

import checks

MOST_FUNCTION, MOST_CLASS = 60, 250
FOLDERS = ("libdgm", "formats", "cli", "samples")
LONGER = {}  # "file: name": lines

TOKENS = re.compile(r"""
    //[^\n]* | /\*.*?\*/ | R"(\w*)\(.*?\)\1" | "(?:\\.|[^"\\\n])*" | '(?:\\.|[^'\\\n])+' |
    ^[ \t]*\#(?:[^\n]*\\\n)*[^\n]*
""", re.X | re.S | re.M)
HEAD = re.compile(r"\b(class|struct|union|enum|namespace)\b")
CONTROL = re.compile(r"^\s*(?:else\s+)?(if|for|while|switch|do|else|try|catch)\b")
MEMBER = re.compile(r"\)\s*(?:noexcept\s*)?:(?!:)[^;]*[\w>]\s*$", re.S)
NAME = re.compile(r"([~\w:]+(?:\s*<[^<>]*>)?|operator\s*[^\s(]+)\s*\($")


@dataclasses.dataclass(frozen=True)
class Block:
    kind: str  # "function" or "class"
    file: str
    name: str
    line: int
    lines: int

    def key(self):
        return f"{self.file}: {self.name}"


def plain(text):
    """Comments, literals and preprocessor lines become spaces; lines stay."""
    return TOKENS.sub(lambda m: re.sub(r"[^\n]", " ", m.group(0)), text)


def head_kind(head):
    """Kind and name of the block that a brace opens, from the text before it; None for anything inside a function."""
    head = re.sub(r"\[\[.*?\]\]|alignas\s*\([^()]*\)|__attribute__\s*\(\(.*?\)\)", " ", head, flags=re.S)
    without_templates = re.sub(r"^\s*template\s*<.*?>\s*(?=\w)", " ", head, flags=re.S)
    scope = HEAD.search(without_templates)
    if scope and "(" not in without_templates[scope.start():] and "=" not in without_templates[:scope.start()]:
        names = re.findall(r"[\w:]+", without_templates[scope.end():].split(":", 1)[0] if "::" not in head else
                           without_templates[scope.end():])
        names = [n for n in names if n not in ("final", "class", "struct")]
        kind = "class" if scope.group(1) in ("class", "struct", "union") else "scope"
        return kind, names[0] if names else "(unnamed)"
    if CONTROL.match(head) or head.rstrip().endswith(("=", ",", "(", "return", "]")):
        return None
    depth, start = 0, None
    for at, c in enumerate(head):  # the first argument list outside of brackets
        if c == "(":
            if depth == 0 and NAME.search(head[:at + 1]):
                start = at
                break
            depth += 1
        elif c == ")":
            depth -= 1
    if start is None:
        return None
    return "function", re.sub(r"\s+", "", NAME.search(head[:start + 1]).group(1))


def blocks_of(file, text):
    """Functions and classes outside of functions, with their lengths."""
    found, stack, begin = [], [], 0
    clean = plain(text)
    depth_in_function = 0
    for m in re.finditer(r"[{};]", clean):
        c = m.group(0)
        head = clean[begin:m.start()]
        if c == "{" and MEMBER.search(head):  # a brace of a constructor's initialisers: the head goes on
            stack.append("member")
            continue
        if c == "}" and stack and stack[-1] == "member":
            stack.pop()
            continue
        if c == "{":
            what = None if depth_in_function else head_kind(head)
            first = begin + len(head) - len(head.lstrip())
            stack.append((what, clean.count("\n", 0, first) + 1))
            if what is None or what[0] == "function":
                depth_in_function += 1
        elif c == "}" and stack:
            what, line = stack.pop()
            if what is None or what[0] == "function":
                depth_in_function -= 1
            if what is not None and what[0] != "scope":
                found.append(Block(what[0], file, what[1], line, clean.count("\n", 0, m.start()) + 2 - line))
        begin = m.end()
    return found


def measure(root):
    blocks = []
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in (".h", ".cpp", ".c"):
                blocks += blocks_of(path.relative_to(root).as_posix(), path.read_text(encoding="utf-8"))
    return blocks


def check(root):
    blocks, most = measure(root), {"function": MOST_FUNCTION, "class": MOST_CLASS}
    if not blocks:
        return [f"{root}: no function found"]
    faults = [f"{b.file}:{b.line}: {b.kind} {b.name} has {b.lines} lines, {LONGER.get(b.key(), most[b.kind])} at most"
              for b in blocks if b.lines > LONGER.get(b.key(), most[b.kind])]
    keys = {b.key() for b in blocks if b.lines > most[b.kind]}
    return faults + [f"{key} is not longer than allowed any more: take it out of LONGER" for key in LONGER
                     if key not in keys]


SAMPLE = """
namespace a { // {
template <class T>
class Long : public Base<T> {
  int f() const noexcept {
    if (x) { y(); }
    const auto g = [&](int k) {
      return k;
    };
  }
  int v = {1};
};
enum class E { a, b };
}
Result<void> a::b::free(std::function<int(int)> f, int (*g)(int)) noexcept {
  for (;;) {
  }
}
A::A(int x) : x_(x), y_{x} {
}
"""


def self_test():
    found = {(b.kind, b.name): b.lines for b in blocks_of("sample.cpp", SAMPLE)}
    wanted = {("class", "Long"): 10, ("function", "f"): 6, ("function", "a::b::free"): 4, ("function", "A::A"): 2}
    return [f"the check itself: {k} has {found.get(k)} lines, not {n}" for k, n in wanted.items() if found.get(k) != n]


def print_longest(count):
    blocks = measure(checks.ROOT)
    for kind in ("class", "function"):
        for b in sorted((b for b in blocks if b.kind == kind), key=lambda b: -b.lines)[:count]:
            print(f"{b.lines:5} {b.kind} {b.name}  {b.file}:{b.line}")
    lengths = sorted(b.lines for b in blocks if b.kind == "function")
    print(f"{len(lengths)} functions: median {lengths[len(lengths) // 2]} lines, "
          f"p99 {lengths[int(0.99 * (len(lengths) - 1))]}, largest {lengths[-1]}")


if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1] == "--list":
        print_longest(int(sys.argv[2]))
    else:
        checks.main("check_sizes", __doc__, check, self_test)
