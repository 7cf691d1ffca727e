#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Who may include whom, and which licence each file names: reads the table below and every #include line.

    scripts/check_layers.py [ROOT]      check the tree; prints FILE:LINE: MESSAGE for each fault; exit code 3 if any
    scripts/check_layers.py --self-test check a made-up tree that must fail, and one that must pass

Arrows point down: a part may include itself and the parts its row names. A library from outside may be included only
by the parts whose row names it, so that HDF5 can be replaced in one folder, CGAL's licence and compile time stay in
one folder, and the runtime never grows a dependency.
"""
import dataclasses
import re

import checks

SYSTEM, XXHASH, PNG, STB, SECCOMP = "the operating system", "xxHash", "libpng", "stb", "libseccomp"
EIGEN, CGAL, EMBREE, TBB, BOOST = "Eigen", "CGAL", "Embree", "TBB", "Boost"
HDF5, OPENEXR, ASSIMP = "HDF5", "OpenEXR", "assimp"
FMT, JSON, TOML, CLI11, GTEST = "fmt", "nlohmann-json", "toml++", "CLI11", "GoogleTest"
INTRINSICS, BENCHMARK, NANOFLANN, BULLET = "processor intrinsics", "Google Benchmark", "nanoflann", "Bullet"
MESHOPT, ZLIB = "meshoptimizer", "zlib"


@dataclasses.dataclass(frozen=True)
class Part:
    folder: str          # the longest folder that matches a file is its part
    level: float
    uses: tuple          # folders of parts below
    libraries: tuple     # beside the C and C++ standard libraries
    why: str


RUNTIME = ("libdgm/include",)


def rooms(*names):
    return RUNTIME + tuple(f"libdgm/src/{name}" for name in names)


DATA = RUNTIME + ("formats/math", "formats/model", "formats/files", "formats/image")
KERNEL = DATA + ("cli/geometry/mesh",)
MESHES = KERNEL + ("cli/geometry/spatial", "cli/geometry/cut", "cli/geometry/simplify", "cli/geometry/metrics")
MAPS = MESHES + ("cli/geometry/solve", "cli/geometry/parameterize")
CHARTS = MAPS + ("cli/geometry/resample", "cli/geometry/chart")
GEOMETRY = CHARTS + ("cli/geometry/repair", "cli/geometry/cut_search", "cli/geometry/fit", "cli/geometry/layers")
CONTAINERS = ("formats/files", "formats/dgm", "formats/exr", "formats/mesh", "formats/path")
BAKING = ("cli/process", "cli/baking", "cli/worker", "cli/batch")
BELOW_PROGRAMS = GEOMETRY + CONTAINERS + BAKING + ("cli/geometry/cgal", "cli/render", "cli/export", "cli/report", "cli/scene",
                                                  "cli/tool")

PARTS = (
    Part("libdgm/include", 0, (), (), "what users include: the standard library alone, ever"),
    Part("libdgm/src/base", 0, RUNTIME, (SYSTEM,), "memory, and functions that round alike everywhere"),
    Part("libdgm/src/rows", 0, rooms("base"), (INTRINSICS,), "loops over rows of samples, chosen by the processor"),
    Part("libdgm/src/file", 0, rooms("base"), (SYSTEM, XXHASH),
         "maps files and judges what they hold; xxHash is inlined, nothing is linked"),
    Part("libdgm/src/surface", 0, rooms("base", "rows", "file"), (), "the welded surface: seams, normals, boxes, changes"),
    Part("libdgm/src/touch", 0, rooms("base", "rows", "file", "surface"), (), "footprints, deformation, fading, ticks"),
    Part("libdgm/src/contact", 0, rooms("base", "rows", "file", "surface", "touch"), (), "obstacles and volume"),
    Part("libdgm/src/query", 0, rooms("base", "rows", "file", "surface", "touch"), (), "triangles, rays, nearest samples"),
    Part("libdgm/src/c_api", 0, rooms("base", "rows", "file", "surface", "touch", "contact", "query"), (), "the C ABI"),
    Part("libdgm/src/physics", 0, rooms("base", "rows", "file", "surface", "touch", "contact", "c_api"), (INTRINSICS,),
         "mass and material, by multigrid; a library of its own, with its own C ABI"),
    Part("libdgm/src/cloth", 0, rooms("base", "rows", "file", "surface", "touch", "contact", "c_api"), (INTRINSICS,),
         "cloth; a library of its own, with its own C ABI"),
    Part("libdgm/web", 0, RUNTIME, (), "the C ABI for scripts: plain numbers, as WebAssembly"),
    Part("formats/math", 0.5, (), (), "functions that round alike everywhere; the C library's do not"),
    Part("formats/model", 1, RUNTIME, (), "plain structs that every reader and writer speaks"),
    Part("formats/files", 1, ("formats/model",), (SYSTEM,), "opens inputs that may be anything, puts outputs in place"),
    Part("formats/path", 1, RUNTIME + ("formats/model",), (), "recorded tool paths"),
    Part("formats/image", 1, ("formats/model", "formats/files"), (PNG, STB), "pixels in and out; no other part decodes pictures"),
    # The rooms of the geometry: pure functions on meshes. All build without CGAL, and most without Eigen.
    Part("cli/geometry/mesh", 2, DATA, (), "the kernel: half-edges, predicates, areas, closest points"),
    Part("cli/geometry/solve", 2, (), (EIGEN,), "sparse systems; knows no mesh"),
    Part("cli/geometry/spatial", 2.1, KERNEL, (EMBREE, TBB), "a mesh in a search tree"),
    Part("cli/geometry/cut", 2.1, KERNEL, (), "cuts of a mesh, and the disk they open"),
    Part("cli/geometry/simplify", 2.1, KERNEL, (), "fewer faces"),
    Part("cli/geometry/repair", 2.1, KERNEL, (), "manifold components of a mesh as it was read"),
    Part("cli/geometry/metrics", 2.2, KERNEL + ("cli/geometry/spatial",), (TBB,),
         "distances, distortion and topology, measured"),
    Part("cli/geometry/parameterize", 2.3, MESHES + ("cli/geometry/solve",), (EIGEN,), "maps of a disk to the plane"),
    Part("cli/geometry/resample", 2.4, MAPS, (), "samples of a map"),
    Part("cli/geometry/chart", 2.5, MAPS + ("cli/geometry/resample",), (), "a component on its grid"),
    Part("cli/geometry/cut_search", 2.6, CHARTS, (TBB,), "the choice of a cut, by the charts it gives"),
    Part("cli/geometry/fit", 2.6, CHARTS, (TBB,), "a chart's samples moved closer to the source"),
    Part("cli/geometry/layers", 2.7, GEOMETRY, (TBB,), "a chart's layers"),
    Part("cli/geometry/cgal", 3, GEOMETRY, (CGAL, EIGEN), "the only folder to see CGAL: its licence and compile time"),
    Part("formats/dgm", 3, DATA, (HDF5, XXHASH, SYSTEM), "the only folder to see HDF5"),
    Part("formats/exr", 3, DATA, (OPENEXR, XXHASH, SYSTEM), "the only folder to see OpenEXR and Imath"),
    Part("formats/mesh", 3, DATA, (ASSIMP, SYSTEM), "the only folder to see assimp"),
    Part("cli/render", 3, GEOMETRY, (EMBREE, TBB, STB, FMT), "pictures by ray tracing; captions by stb_truetype"),
    Part("cli/tool", 3, ("formats/model", "formats/files"), (CLI11, FMT), "what every program's main() does alike"),
    Part("cli/page", 3.1, DATA + ("formats/dgm",), (FMT, ZLIB), "maps, runtime and viewer as one page"),
    Part("cli/export", 3.5, GEOMETRY + CONTAINERS + ("cli/page", "cli/render", "cli/tool"), (FMT, JSON, MESHOPT, SYSTEM),
         "maps as meshes and pictures; a bake may ask for them, too; the only folder to see meshoptimizer"),
    Part("cli/process", 4, ("formats/model", "formats/files", "formats/mesh", "formats/dgm", "formats/exr", "formats/image"),
         (FMT, JSON, SYSTEM, SECCOMP),
         "disposable copies of the program, whatever their work; files of strangers are read in them"),
    Part("cli/baking", 4, GEOMETRY + CONTAINERS + ("cli/geometry/cgal", "cli/export"), (FMT, JSON, TBB),
         "the stages in order, in this process; introduces the parameterizers to the geometry"),
    Part("cli/worker", 5, CONTAINERS + ("formats/model", "cli/process", "cli/baking", "cli/export"), (FMT, JSON, TBB, SYSTEM),
         "the process that bakes one asset, and its files"),
    Part("cli/batch", 6, CONTAINERS + ("formats/model", "cli/process", "cli/baking", "cli/worker"), (FMT, JSON, SYSTEM),
         "many assets: the plan, the workers, the report"),
    Part("cli/report", 7, GEOMETRY + CONTAINERS + BAKING + ("cli/render", "cli/page", "cli/export"), (FMT, JSON, TBB, SYSTEM),
         "the pages of --report: pictures and words about what was baked"),
    Part("cli/scene", 7, BELOW_PROGRAMS, (FMT, JSON, TOML), "what a scene asks for, and the batch that answers it"),
    Part("cli/bench", 8, BELOW_PROGRAMS + ("samples/generate",), (CLI11, FMT, JSON, SYSTEM), "a program"),
    Part("cli/bake", 8, BELOW_PROGRAMS, (CLI11, FMT, JSON, SYSTEM), "a program"),
    Part("cli/validate", 8, BELOW_PROGRAMS, (CLI11, FMT, JSON, TBB, SYSTEM), "a program"),
    Part("cli/info", 9, BELOW_PROGRAMS + ("cli/validate",), (CLI11, FMT, JSON),
         "a program; warns of maps that dgm-validate refuses"),
    Part("cli/edit", 9, BELOW_PROGRAMS + ("cli/validate",), (CLI11, FMT, JSON, SYSTEM),
         "a program; checks what it writes as dgm-validate does"),
    Part("cli/export/program", 9, BELOW_PROGRAMS + ("cli/validate",), (CLI11, FMT, JSON, SYSTEM),
         "a program; exports what dgm-validate passes"),
    Part("samples/generate", 4, ("formats/math", "formats/model"), (PNG,), "makes meshes; knows nothing of baking"),
    Part("samples/load_and_draw", 5, RUNTIME, (), "what a user of the runtime would write"),
    Part("samples/support", 5, DATA + ("formats/path", "cli/render"), (), "what samples share: maps to press, pictures"),
    Part("samples", 6, DATA + ("formats/path", "cli/render", "samples/support"), (), "the paper's figures, on the runtime"),
    Part("tests", 9, ("",), (SYSTEM, XXHASH, PNG, STB, EIGEN, CGAL, EMBREE, TBB, BOOST, HDF5, OPENEXR, ASSIMP, FMT,
                             JSON, CLI11, GTEST, BENCHMARK, NANOFLANN, BULLET, MESHOPT, ZLIB), "tests may look at everything"),
    Part("tests/e2e/consumer", 9, RUNTIME, (), "a user's project: knows the installed runtime only"),
)

LIBRARIES = (  # patterns of headers, first match wins
    (r"CGAL/", CGAL), (r"Eigen/|unsupported/Eigen/", EIGEN), (r"embree3/", EMBREE), (r"(oneapi/)?tbb/", TBB),
    (r"boost/", BOOST), (r"hdf5|H5[A-Z]?\w*\.h", HDF5), (r"OpenEXR/|Imath/|Imf|Imath|half\.h|Iex|IlmThread", OPENEXR),
    (r"assimp/", ASSIMP), (r"png(conf|libconf)?\.h", PNG), (r"stb[/_]", STB), (r"fmt/", FMT), (r"nlohmann/", JSON),
    (r"toml\+\+/", TOML), (r"meshoptimizer\.h", MESHOPT), (r"zlib\.h", ZLIB), (r"CLI/", CLI11), (r"benchmark/", BENCHMARK), (r"nanoflann", NANOFLANN), (r"BulletSoftBody/|btBulletDynamicsCommon\.h", BULLET), (r"([a-z]*mmintrin|wasm_simd128|arm_neon)\.h", INTRINSICS),
    (r"seccomp\.h", SECCOMP), (r"g(test|mock)/", GTEST), (r"xxh(ash|3)\.h", XXHASH),
    (r"(sys|linux|net|netinet|arpa)/|(fcntl|fnmatch|unistd|poll|malloc|dirent|dlfcn|pthread|sched|signal|spawn|termios|"
     r"windows|io)\.h", SYSTEM),
)
STANDARD = re.compile(r"[a-z_0-9]+|(assert|ctype|errno|float|inttypes|limits|locale|math|stdarg|stddef|stdint|stdio|"
                      r"stdlib|string|strings|time)\.h")
INCLUDE = re.compile(r'\s*#\s*include\s*(?:<([^>]+)>|"([^"]+)")')
# Where <...> and "..." of ours are looked up, after the including file's own folder for the latter.
SEARCH = {"<": ("libdgm/include",), '"': ("cli", "formats", "libdgm/src", "samples", "libdgm/include", "tests",
                                          "tests/support",
                                          "tests/unit/formats")}

CODE = {".h", ".hpp", ".c", ".cpp"}
MARKED = CODE | {".py", ".sh", ".cmake", ".md"}
MARKED |= {".js", ".css"}
LICENCES = {"libdgm": "MIT", "cli/page/web": "MIT"}  # by folder; what goes into users' files is MIT
DEFAULT_LICENCE = "GPL-3.0-or-later"
SPDX = re.compile(r"(?://|#|/\*|<!--) SPDX-License-Identifier: ([\w.-]+)(?: \*/| -->)?\s*")


def part_of(relative):
    """The row of PARTS a file belongs to, or None."""
    path = relative.as_posix()
    fitting = [p for p in PARTS if path.startswith(p.folder + "/")]
    return max(fitting, key=lambda p: len(p.folder), default=None)


def library_of(header):
    """Name of the library a <header> comes from: "" for the standard one, None if unknown."""
    if STANDARD.fullmatch(header):
        return ""
    return next((name for pattern, name in LIBRARIES if re.match(pattern, header)), None)


def resolve(root, relative, kind, header):
    """The file of ours an include means, relative to root, or None."""
    folders = [root / place for place in SEARCH[kind]]
    if kind == '"':
        folders.insert(0, (root / relative).parent)
    for folder in folders:
        candidate = (folder / header).resolve()
        if candidate.is_file() and candidate.is_relative_to(root):
            return candidate.relative_to(root)
    return None


def include_fault(root, relative, part, angled, quoted):
    """The fault of one include, or None."""
    kind, header = ("<", angled) if angled else ('"', quoted)
    target = resolve(root, relative, kind, header)
    if target is not None:
        other = part_of(target)
        if other is None:
            return f'"{header}" is in no part of the table'
        if other is part or other.folder in part.uses or "" in part.uses:
            return None
        return f"{part.folder} (level {part.level}) may not include {other.folder} (level {other.level}): {part.why}"
    if kind == '"':
        return f'"{header}" is no file of ours; name headers of libraries in <>'
    library = library_of(header)
    if library is None:
        return f"<{header}> belongs to no library of the table; add it with a reason, or do without"
    if library == "" or library in part.libraries:
        return None
    return f"{part.folder} (level {part.level}) may not include {library} (<{header}>): {part.why}"


def include_faults(root, relative):
    """(line, message) of each include that is not allowed."""
    lines = (root / relative).read_text(encoding="utf-8", errors="replace").splitlines()
    found = [(k, match) for k, line in enumerate(lines, 1) if (match := INCLUDE.match(line))]
    part = part_of(relative)
    if part is None:
        return [(1, "is in no part of the table: give its folder a row")]
    faults = [(k, include_fault(root, relative, part, *match.groups())) for k, match in found]
    return [(k, message) for k, message in faults if message]


def licence_fault(root, relative):
    """(line, message) if the file does not name its licence, or None."""
    with open(root / relative, encoding="utf-8", errors="replace") as file:
        first, second = file.readline(), file.readline()
    script = first.startswith("#!")
    if relative.suffix not in MARKED and relative.name != "CMakeLists.txt" and not script:
        return None
    line, text = (2, second) if script else (1, first)
    wanted = next((name for folder, name in LICENCES.items() if relative.is_relative_to(folder)), DEFAULT_LICENCE)
    match = SPDX.fullmatch(text)
    if not match:
        return line, f"the line should be: SPDX-License-Identifier: {wanted}"
    if match.group(1) != wanted:
        return line, f"the licence here is {wanted}, not {match.group(1)}"
    return None


def check(root):
    """All faults of a tree, as text lines."""
    root = root.resolve()
    faults, checked = [], 0
    for relative in checks.files_of(root):
        found = [fault] if (fault := licence_fault(root, relative)) else []
        if relative.suffix in CODE:
            checked += 1
            found += include_faults(root, relative)
        faults += [f"{relative.as_posix()}:{line}: {message}" for line, message in found]
    if checked == 0:
        faults.append(f"{root}: no source file found")
    return faults


GOOD = {
    "libdgm/include/dgm/vec.h": "// SPDX-License-Identifier: MIT\n#include <cmath>\n",
    "libdgm/src/file/hash.cpp": "// SPDX-License-Identifier: MIT\n#include <dgm/vec.h>\n#include <xxhash.h>\n",
    "formats/model/mesh.h": "// SPDX-License-Identifier: GPL-3.0-or-later\n#include <dgm/vec.h>\n",
    "formats/dgm/writer.cpp": "// SPDX-License-Identifier: GPL-3.0-or-later\n#include <hdf5.h>\n"
                              '#include "model/mesh.h"\n',
    "cli/baking/pipeline.h": "// SPDX-License-Identifier: GPL-3.0-or-later\n",
    "cli/geometry/chart/chart.h": "// SPDX-License-Identifier: GPL-3.0-or-later\n",
    "scripts/demo": "#!/bin/sh\n# SPDX-License-Identifier: GPL-3.0-or-later\n",
    "build/x.cpp": "not ours\n",
}
BAD = {  # file: (text, line of the fault, part of the message)
    "libdgm/include/dgm/big.h": ("// SPDX-License-Identifier: MIT\n#include <fmt/format.h>\n", 2, "include fmt"),
    "libdgm/src/file/up.cpp": ('// SPDX-License-Identifier: MIT\n\n#include "model/mesh.h"\n', 3, "formats/model (level 1)"),
    "libdgm/src/file/gpl.cpp": ("// SPDX-License-Identifier: GPL-3.0-or-later\n", 1, "the licence here is MIT"),
    "formats/model/h5.h": ("// SPDX-License-Identifier: GPL-3.0-or-later\n# include <hdf5.h>\n", 2, "include HDF5"),
    "formats/exr/side.cpp": ("// SPDX-License-Identifier: GPL-3.0-or-later\n#include \"dgm/writer.h\"\n", 2,
                             "may not include formats/dgm"),
    "formats/dgm/writer.h": ("#pragma once\n", 1, "SPDX-License-Identifier: GPL-3.0-or-later"),
    "cli/geometry/cut/cut.cpp": ("// SPDX-License-Identifier: GPL-3.0-or-later\n#include <CGAL/Surface_mesh.h>\n", 2,
                                 "include CGAL"),
    "cli/geometry/metrics/up.cpp": ("// SPDX-License-Identifier: GPL-3.0-or-later\n"
                                    '#include "baking/pipeline.h"\n', 2, "may not include cli/baking"),
    "cli/geometry/parameterize/up.cpp": ("// SPDX-License-Identifier: GPL-3.0-or-later\n"
                                         '#include "geometry/chart/chart.h"\n', 2,
                                         "may not include cli/geometry/chart"),
    "cli/bake/odd.cpp": ("// SPDX-License-Identifier: GPL-3.0-or-later\n#include <openssl/md5.h>\n", 2, "no library"),
    "cli/bake/lost.cpp": ("// SPDX-License-Identifier: GPL-3.0-or-later\n#include \"lost.h\"\n", 2, "no file of ours"),
    "cli/new/new.cpp": ("// SPDX-License-Identifier: GPL-3.0-or-later\n", 1, "no part"),
    "scripts/run.sh": ("#!/bin/sh\nset -e\n", 2, "SPDX-License-Identifier"),
}


def self_test():
    return checks.tree_faults(check, GOOD, BAD)


if __name__ == "__main__":
    checks.main("check_layers", __doc__, check, self_test)
