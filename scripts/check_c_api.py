#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The C header explains itself: reads libdgm/include/dgm/dgm.h and asks for the comments a C programmer needs.

    scripts/check_c_api.py [ROOT]      check the tree; prints FILE:LINE: MESSAGE for each fault; exit code 3 if any
    scripts/check_c_api.py --self-test check headers that must fail, and one that must pass

- Each function, struct, enum and handle has a comment directly above it. That of a function names each parameter but
  `error` and the handle in front.
- Each field but struct_size has a comment, above it or behind it.
- A uint32_t field that stands for a choice names its enum: always if its name ends as that of an enum does (`kind`,
  `dgm_tool_kind`), and instead of a list such as "0 plane, 1 sphere". Each enum is named by a field or a parameter, or
  returned.
- libdgm/src/**/c_api*.cpp compares each enumerator with the C++ interface in a static_assert.
"""
import dataclasses
import re
import tempfile
from pathlib import Path

import checks

HEADER = "libdgm/include/dgm/dgm.h"
SOURCES = "libdgm/src", "c_api*.cpp"

COMMENT = re.compile(r"/\*.*?\*/", re.S)
FUNCTION = re.compile(r"^DGM_API\s+(?P<returns>[\w\s*]+?)(?P<name>\w+)\((?P<parameters>[^;]*)\);", re.M)
BLOCK = re.compile(r"^typedef (?P<kind>struct|enum) (?P<name>\w+) \{\n(?P<body>.*?)^\} \w+;", re.M | re.S)
HANDLE = re.compile(r"^typedef struct (?P<name>\w+) \w+;", re.M)
ENUMERATOR = re.compile(r"\b(DGM_\w+) = ")
LISTED_NUMBERS = re.compile(r"\b(\d+):? [a-z][^,;]*[,;] (\d+):? [a-z]")


@dataclasses.dataclass(frozen=True)
class Field:
    name: str
    type: str
    line: int
    comment: str  # "" if there is none


def line_of(text, place):
    return text.count("\n", 0, place) + 1


def words_of(comment):
    """A comment's text without its marks."""
    return " ".join(re.sub(r"^\s*\*", "", line) for line in comment.strip("/* ").splitlines()).strip()


def comment_above(text, place):
    """Text of the comment that ends on the line above `place`, which starts a line; "" if there is none."""
    before = text[:place].removesuffix("\n")
    if not before.endswith("*/"):
        return ""
    start = before.rfind("/*")
    alone = before[before.rfind("\n", 0, start) + 1:start].strip() == ""
    return words_of(before[start:]) if alone else ""


def names_in(declarator):
    """Names that one declaration declares: `float a, b[3]` has two."""
    pointer = re.search(r"\(\*(\w+)\)", declarator)
    if pointer:
        return [pointer.group(1)]
    return [re.search(r"(\w+)\s*(\[\w*\])?$", part.strip()).group(1) for part in declarator.split(",")]


def fields_of(text, block):
    """The fields of a struct, each with the comment above or behind it."""
    fields, above = [], ""
    body, start = block.group("body"), block.start("body")
    place = 0
    while match := re.compile(r"\s*(/\*.*?\*/|[^;/]+;)", re.S).match(body, place):
        piece, place = match.group(1), match.end()
        if piece.startswith("/*"):
            above = words_of(piece)
            continue
        behind = re.compile(r"[ \t]*(/\*.*?\*/)", re.S).match(body, place)
        if behind:
            place = behind.end()
        declaration = " ".join(piece.rstrip(";").split())
        comment = words_of(behind.group(1)) if behind else above
        for name in names_in(declaration):
            fields.append(Field(name, declaration.split()[0], line_of(text, start + match.start(1)), comment))
        above = ""
    return fields


def field_faults(struct, field, enums):
    if field.name == "struct_size":
        return []
    if not field.comment:
        return [f"{struct}.{field.name} has no comment"]
    if field.type != "uint32_t" or any(re.search(rf"\b{enum}\b", field.comment) for enum in enums):
        return []
    last = field.name.split("_")[-1]
    fitting = [enum for enum in enums if enum.split("_")[-1] == last]
    if fitting:
        return [f"the comment of {struct}.{field.name} names no enum, e.g. {fitting[0]}"]
    numbers = LISTED_NUMBERS.search(field.comment)
    if numbers and int(numbers.group(2)) == int(numbers.group(1)) + 1:
        return [f"the comment of {struct}.{field.name} lists numbers; name an enum"]
    return []


def function_faults(function, comment):
    name = function.group("name")
    if not comment:
        return [f"{name}() has no comment directly above it"]
    parameters = [p.strip() for p in function.group("parameters").split(",")]
    asked = []
    for k, parameter in enumerate(parameters):
        handle = k == 0 and re.match(r"(const )?dgm_\w+\* \w+$", parameter)
        found = re.search(r"(\w+)(\[\d*\])?$", parameter).group(1)
        if parameter != "void" and not handle and found != "error":
            asked.append(found)
    return [f"the comment of {name}() does not name the parameter `{p}`"
            for p in asked if not re.search(rf"\b{p}\b", comment)]


def header_faults(text):
    """(line, message) of each comment that is missing or says too little."""
    faults = []
    blocks = list(BLOCK.finditer(text))
    enums = [b.group("name") for b in blocks if b.group("kind") == "enum"]
    explained = ""
    for item in blocks + list(HANDLE.finditer(text)):
        if not comment_above(text, item.start()):
            faults.append((line_of(text, item.start()), f"{item.group('name')} has no comment directly above it"))
    for block in (b for b in blocks if b.group("kind") == "struct"):
        for field in fields_of(text, block):
            explained += field.comment + "\n"
            faults += [(field.line, fault) for fault in field_faults(block.group("name"), field, enums)]
    functions = list(FUNCTION.finditer(text))
    for function in functions:
        comment = comment_above(text, function.start())
        explained += comment + "\n" + function.group("returns") + "\n"
        faults += [(line_of(text, function.start()), fault) for fault in function_faults(function, comment)]
    code = COMMENT.sub("", text)
    if len(functions) != len(re.findall(r"^DGM_API\b", code, re.M)) or not functions or not enums:
        faults.append((1, "the check cannot read all declarations of this header"))
    for block in (b for b in blocks if b.group("kind") == "enum"):
        if not re.search(rf"\b{block.group('name')}\b", explained):
            faults.append((line_of(text, block.start()), f"no field and no parameter names {block.group('name')}"))
    return sorted(faults)


def assertion_faults(text, sources):
    """(line, message) of each enumerator that no static_assert compares."""
    asserted = set(re.findall(r"\bDGM_\w+", " ".join(re.findall(r"static_assert\((.*?)\);", sources, re.S))))
    faults = []
    for block in (b for b in BLOCK.finditer(text) if b.group("kind") == "enum"):
        for match in ENUMERATOR.finditer(COMMENT.sub(lambda c: " " * len(c.group()), block.group("body"))):
            if match.group(1) not in asserted:
                line = line_of(text, block.start("body")) + block.group("body").count("\n", 0, match.start())
                faults.append((line, f"no static_assert in {'/**/'.join(SOURCES)} compares {match.group(1)}"))
    return faults


def check(root):
    """All faults of a tree, as text lines."""
    text = (root / HEADER).read_text(encoding="utf-8")
    sources = "".join(p.read_text(encoding="utf-8") for p in sorted((root / SOURCES[0]).rglob(SOURCES[1])))
    return [f"{HEADER}:{line}: {message}" for line, message in header_faults(text) + assertion_faults(text, sources)]


GOOD = """\
/* A thing. */
typedef struct dgm_thing dgm_thing;

/* Kinds of things. */
typedef enum dgm_thing_kind {
    DGM_THING_KIND_A = 0, /* the first */
    DGM_THING_KIND_B = 1  /* the second */
} dgm_thing_kind;

/* How to make a thing. */
typedef struct dgm_options {
    uint32_t struct_size;
    uint32_t kind;      /* dgm_thing_kind */
    uint32_t fast;      /* 1: in a hurry */
    uint32_t max_count; /* 1 .. 64; 0: 4 */
    /* Both in metres. */
    float low, high[3];
    /* Called at the end. */
    void (*done)(void* user, size_t bytes);
} dgm_options;

/* Makes one.
 *
 * options  NULL: defaults
 * thing    receives the handle */
DGM_API int dgm_make(const dgm_options* options, dgm_thing** thing, dgm_error* error);

/* Destroys a thing. */
DGM_API void dgm_destroy(dgm_thing* thing);
"""
ASSERTS = "static_assert(same(DGM_THING_KIND_A, Kind::A));\nstatic_assert(DGM_THING_KIND_B == int(Kind::B));\n"
BAD = (  # text in GOOD, its replacement, line of the fault, part of its message
    ("/* Destroys a thing. */\n", "", 28, "dgm_destroy() has no comment"),
    ("/* Destroys a thing. */\n", "/* Destroys a thing. */\n\n", 30, "dgm_destroy() has no comment"),
    ("/* A thing. */\n", "", 1, "dgm_thing has no comment"),
    ("/* How to make a thing. */\n", "", 10, "dgm_options has no comment"),
    (" * thing    receives the handle */", " */", 26, "`thing`"),
    ("/* 1: in a hurry */", "", 14, "dgm_options.fast has no comment"),
    ("    /* Both in metres. */\n", "", 16, "dgm_options.low has no comment"),
    ("/* dgm_thing_kind */", "/* which one */", 13, "names no enum"),
    ("/* 1: in a hurry */", "/* 0 slow, 1 fast */", 14, "lists numbers"),
    ("uint32_t kind;      /* dgm_thing_kind */", "uint32_t sort;      /* which one */", 5, "names dgm_thing_kind"),
    ("    DGM_THING_KIND_B = 1 ", "    DGM_THING_KIND_C = 1 ", 7, "compares DGM_THING_KIND_C"),
    ("DGM_API void dgm_destroy(", "DGM_API (dgm_destroy)(", 1, "cannot read"),
)


def planted(text):
    """Faults of a tree whose header is `text`."""
    with tempfile.TemporaryDirectory(prefix="check-c-api-") as folder:
        checks.plant(Path(folder), {HEADER: text, f"{SOURCES[0]}/c_api/c_api_things.cpp": ASSERTS})
        return check(Path(folder))


def self_test():
    """Faults of the check itself, as text lines."""
    wrong = [f"a good header fails: {fault}" for fault in planted(GOOD)]
    for before, after, line, message in BAD:
        if GOOD.count(before) != 1:
            wrong.append(f"{before!r} does not occur once")
        faults = planted(GOOD.replace(before, after))
        if not any(fault.startswith(f"{HEADER}:{line}: ") and message in fault for fault in faults):
            wrong.append(f"{before!r} -> {after!r}: expected a fault at line {line} with \"{message}\", got {faults}")
    bare = planted(COMMENT.sub("", GOOD))
    for name in ("dgm_make()", "dgm_destroy()", "dgm_options.kind", "dgm_options.high"):
        if not any(name in fault for fault in bare):
            wrong.append(f"a header without comments: no fault for {name}")
    return wrong


if __name__ == "__main__":
    checks.main("check_c_api", __doc__, check, self_test)
