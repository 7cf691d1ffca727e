#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Do the links of our documents lead somewhere?

    scripts/check_links.py [ROOT]      check the tree; prints FILE:LINE: MESSAGE for each fault; exit code 3 if any
    scripts/check_links.py --self-test check a made-up tree that must fail, and one that must pass

Three kinds are checked: relative links and pictures in Markdown files, with their anchors; files and folders that
Markdown names in back quotes (`cli/bake`, `libdgm/src/rows/*.h`); and citations of a numbered section
(`docs/design.md section 4`) in any source. Links to other hosts are not followed. Code blocks are left out.
"""
import re
import urllib.parse
from pathlib import Path

import checks

LINK = re.compile(r"!?\[(?:[^\]\[]|\[[^\]]*\])*\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)")
REFERENCE = re.compile(r"^\s{0,3}\[[^\]]+\]:\s+<?(\S+?)>?(?:\s+\"[^\"]*\")?\s*$")
HTML = re.compile(r"<(?:a|img|source)\b[^>]*?\b(?:href|src|srcset)=\"([^\"\s]+)\"")
HEADING = re.compile(r"^#{1,6}\s+(.*?)\s*#*\s*$")
NUMBER = re.compile(r"^#{1,6}\s+(\d+(?:\.\d+)*)\.?\s")
OUTSIDE = re.compile(r"[a-z][a-z0-9+.-]*:|//", re.IGNORECASE)
CITATION = re.compile(r"((?:docs|formats)/[\w-]+\.md),? +section +(\d+(?:\.\d+)*)")
NAMED = re.compile(r"`((?:cli|docs|formats|libdgm|samples|scripts|tests)/[\w./*-]+)`")
SOURCES = {".h", ".hpp", ".c", ".cpp", ".py", ".sh", ".cmake", ".md", ".toml", ".txt"}


def text_of(path):
    return path.read_text(encoding="utf-8", errors="replace")


def prose(text):
    """(number, line) of a document's lines outside code blocks; inline code is blanked."""
    fence = None
    for number, line in enumerate(text.splitlines(), 1):
        mark = re.match(r"\s*(```+|~~~+)", line)
        if fence is None and mark:
            fence = mark.group(1)
        elif fence is not None:
            if mark and mark.group(1).startswith(fence):
                fence = None
        else:
            yield number, line


def anchor_of(heading):
    """The anchor that GitHub gives a heading: lower case, punctuation dropped, a hyphen for each space."""
    heading = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading)  # links: their text
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def anchors_of(text):
    """All anchors of a document; equal headings are numbered."""
    found, seen = set(), {}
    for _, line in prose(text):
        heading = HEADING.match(line)
        if heading:
            anchor = anchor_of(heading.group(1))
            count = seen.get(anchor, 0)
            seen[anchor] = count + 1
            found.add(f"{anchor}-{count}" if count else anchor)
        found.update(re.findall(r"<a\s+(?:id|name)=\"([^\"]+)\"", line))
    return found


def sections_of(text):
    """Numbers of the numbered headings of a document."""
    return {match.group(1) for _, line in prose(text) if (match := NUMBER.match(line))}


def link_fault(root, relative, target):
    """Says what is wrong with a link of a document, or None."""
    if OUTSIDE.match(target):
        return None
    path, _, anchor = urllib.parse.unquote(target).partition("#")
    if path.startswith("/"):
        return f"`{target}` is absolute; links are relative to their document"
    to = ((root / relative).parent / path).resolve() if path else root / relative
    if not to.is_relative_to(root):
        return f"`{target}` leads out of the repository"
    if not to.exists():
        return f"`{target}` does not exist"
    if anchor and to.suffix == ".md" and anchor not in anchors_of(text_of(to)):
        return f"`{target}`: no heading has that anchor"
    return None


def link_faults(root, relative, text):
    """(line, message) of each link of a document that leads nowhere."""
    for number, line in prose(text):
        plain = re.sub(r"(`+)(?!`).*?(?<!`)\1(?!`)", "code", line)
        targets = LINK.findall(plain) + HTML.findall(plain)
        targets += [m.group(1) for m in [REFERENCE.match(plain)] if m]
        for target in targets:
            if fault := link_fault(root, relative, target):
                yield number, fault
        if relative.name != "CHANGELOG.md":  # which names files of its time
            for path in NAMED.findall(line):
                if not any(root.glob(path.rstrip("/"))):
                    yield number, f"`{path}` does not exist"


def citation_faults(root, text):
    """(line, message) of each citation of a section that is not there; a citation may run over a comment's line end."""
    joined = re.sub(r"\n[ \t]*(?:///?|#|\*)?[ \t]*", lambda m: " " * len(m.group()), text)
    for match in CITATION.finditer(joined):
        document, section = match.groups()
        number = text.count("\n", 0, match.start()) + 1
        if not (root / document).is_file():
            yield number, f"{document} does not exist"
        elif section not in sections_of(text_of(root / document)):
            yield number, f"{document} has no section {section}"


def check(root):
    """All faults of a tree, as text lines."""
    root = root.resolve()
    faults, documents = [], 0
    for relative in checks.files_of(root):
        if relative.suffix not in SOURCES:
            continue
        text = text_of(root / relative)
        found = list(citation_faults(root, text)) if relative.name != Path(__file__).name else []
        if relative.suffix == ".md":
            documents += 1
            found += link_faults(root, relative, text)
        faults += [f"{relative.as_posix()}:{line}: {message}" for line, message in sorted(found)]
    if documents == 0:
        faults.append(f"{root}: no document found")
    return faults


GOOD = {
    "README.md": "# A\n\n[b](docs/b.md), [c](docs/b.md#2-to-c), [out](https://example.org/x#y), "
                 "[self](#a-1), ![p](p.png)\n"
                 "[folder](docs) `[no](link.md)` [with `code`](docs/b.md#the-code-of-it)\n\n# A\n\n"
                 "```\n[no](link.md)\n```\n",
    "docs/b.md": "# B\n\n## 2. To C\n\n### 2.1 Deeper\n\n[up](../README.md)\n\n## The `code` of [it](b.md)\n",
    "docs/c.md": "`docs/*.md`, `docs/b.md`, `build/x`\n",
    "CHANGELOG.md": "`docs/gone`\n",
    "p.png": "x",
    "src/a.h": "// docs/b.md section 2, and docs/b.md\n// section 2.1.\n/// (docs/b.md section 2.1)\n",
    "build/c.md": "[not ours](nowhere.md)\n",
}
BAD = {  # file: (text, line of the fault, part of the message)
    "one.md": ("x\n\n[gone](gone.md)\n", 3, "does not exist"),
    "two.md": ("[no anchor](docs/b.md#nothing)\n", 1, "no heading"),
    "three.md": ("![picture](docs/gone.png \"title\")\n", 1, "does not exist"),
    "four.md": ("[root](/README.md)\n", 1, "is absolute"),
    "five.md": ("[out](../../outside.md)\n", 1, "out of the repository"),
    "six.md": ("text [a][b]\n\n[b]: gone.md\n", 3, "does not exist"),
    "seven.md": ("<img src=\"gone.svg\" alt=\"\">\n", 1, "does not exist"),
    "eight.md": ("x\n`docs/gone.md`\n", 2, "does not exist"),
    "nine.md": ("`docs/*.cpp`\n", 1, "does not exist"),
    "src/b.h": ("// x\n// docs/b.md section 7\n", 2, "no section 7"),
    "src/c.cpp": ("/// (docs/b.md\n/// section 2.9)\n", 1, "no section 2.9"),
    "src/d.py": ("# docs/gone.md section 1\n", 1, "docs/gone.md does not exist"),
}


def self_test():
    return checks.tree_faults(check, GOOD, BAD)


if __name__ == "__main__":
    checks.main("check_links", __doc__, check, self_test)
