#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What scripts/clients runs: exports maps in every form and lets other programs open them.

    run_clients.py --build BUILD --node FOLDER --out OUT MESH|MAP|FOLDER...

Prints one line a check and program; OUT/clients.json has each file's result. Exit code 3 if any failed.
"""
import argparse
import json
import shutil
import struct
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
LAYERS = "geometry,normal,texture,bump,collision,deformation,contact"


def run(*command, check=False, timeout=600):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, errors="replace", timeout=timeout,
                          check=check)


def channels_of(path):
    """The names of all channels of an EXR, part by part, straight from its header."""
    data = path.read_bytes()
    at, parts = 8, []
    several = data[5] & 0x10

    def text():
        nonlocal at
        end = data.index(b"\0", at)
        out, at = data[at:end].decode(), end + 1
        return out

    while data[at]:
        names = []
        while name := text():
            kind = text()
            (size,) = struct.unpack_from("<i", data, at)
            at += 4
            end = at + size
            if name == "channels" and kind == "chlist":
                while data[at]:
                    names.append(text())
                    at += 16
            at = end
        parts.append(names)
        if not several:
            break
    return parts


def expected_passes(path):
    """As Blender names them: `layer.pass.C`; letters alone are the pass Combined, or a plain picture."""
    names = {name for part in channels_of(path) for name in part}
    passes = set()
    for name in names:
        words = name.split(".")
        passes.add((".".join(words[:-2]), words[-2]) if len(words) > 1 else ("", "Combined"))
    return {("", "Image")} if passes == {("", "Combined")} else passes


def is_picture(path):
    """A file of one part shows a picture; those of several charts have several parts."""
    parts = channels_of(path)
    return len(parts) == 1 and ({"R", "G", "B"} <= set(parts[0]) or "Y" in parts[0])


def vertices_of(obj):
    with obj.open(encoding="utf-8") as file:
        return [[float(number) for number in line.split()[1:4]] for line in file if line.startswith("v ")]


class Clients:
    def __init__(self, arguments):
        self.tools = Path(arguments.build) / "cli"
        self.node = Path(arguments.node)
        self.out = Path(arguments.out).resolve()
        self.results = {}   # check -> {file: None or what was wrong}
        self.exrs, self.pictures, self.glbs, self.maps = [], [], [], []

    def note(self, check, file, wrong=None):
        self.results.setdefault(check, {})[str(file)] = wrong

    def tool(self, name):
        return self.tools / name.removeprefix("dgm-") / name

    def bake(self, inputs):
        meshes = [i for i in inputs if i.suffix != ".dgm" and not (i.is_dir() and any(i.rglob("*.dgm")))]
        found = []
        for path in inputs:
            if path not in meshes:
                found += [path] if path.is_file() else sorted(path.rglob("*.dgm"))
        if meshes:
            baked = self.out / "baked"
            result = run(self.tool("dgm-bake"), *meshes, "-o", baked, "--size", 65, "--layers", LAYERS, timeout=None)
            print(result.stdout.splitlines()[-1] if result.stdout else result.stderr[-500:])
            found += sorted(baked.rglob("*.dgm"))
        return found

    def export(self, dgm, name):
        """All forms of one map; each in a folder of its own, since names repeat."""
        folder = self.out / "files" / name
        shutil.rmtree(folder, ignore_errors=True)
        forms = [("auto", ["-o", folder / "auto" / f"{name}.exr"]),
                 ("multipart", ["-o", folder / "multipart" / f"{name}.exr", "--exr-layout", "multipart"]),
                 ("maps", ["--maps", folder / "maps"]),
                 ("power_of_two", ["--maps", folder / "power_of_two", "--power-of-two"]),
                 ("obj", ["-o", folder / "obj" / f"{name}.obj"]), ("glb", ["-o", folder / "glb" / f"{name}.glb"])]
        for form, options in forms:
            (folder / form).mkdir(parents=True)
            result = run(self.tool("dgm-export"), dgm, *options)
            self.note(f"export {form}", dgm, result.stderr if result.returncode else None)
        self.exrs += sorted(folder.glob("auto/*.exr")) + sorted(folder.glob("multipart/*.exr"))
        self.pictures += [path for path in sorted(folder.glob("auto/*.exr")) if is_picture(path)]
        self.pictures += sorted(folder.glob("maps/*.exr")) + sorted(folder.glob("power_of_two/*.exr"))
        self.glbs += sorted(folder.glob("glb/*.glb"))
        for index in folder.glob("maps/*.json"):
            self.maps.append((dgm, index, next(folder.glob("obj/*.obj"))))

    def displacements(self):
        """Position maps of square charts, and the vertices that the OBJ has for their samples."""
        jobs = []
        for _, index, obj in self.maps:
            charts = json.loads(index.read_text())["charts"]
            if any(chart["domain"] != "square" for chart in charts):
                continue
            vertices, first = vertices_of(obj), 0
            for chart in charts:
                count = chart["width"] * chart["height"]
                part = [[v - o for v, o in zip(vertex, chart["origin"])] for vertex in vertices[first:first + count]]
                size = max(high - low for low, high in zip(chart["bbox"]["min"], chart["bbox"]["max"]))
                jobs.append({"map": str(index.parent / chart["maps"][0]["file"]), "vertices": part,
                             "tolerance": 1e-5 * max(size, max(abs(x) for v in part for x in v))})
                first += count
        return jobs

    def blender(self):
        files, jobs = [str(path) for path in self.exrs], self.displacements()
        job, answer = self.out / "blender_job.json", self.out / "blender_result.json"
        while files or jobs:
            job.write_text(json.dumps({"list": files, "displace": jobs}))
            answer.write_text('{"passes": {}, "displaced": {}, "at": "start"}')
            run("blender", "-b", "--factory-startup", "--python", HERE / "blender_maps.py", "--", job, answer,
                timeout=3600)
            result = json.loads(answer.read_text())
            for path, passes in result["passes"].items():
                # A pass "Combined" brings a socket "Alpha", a picture one more for its depth.
                seen = {(layer, name) for layer, name, _ in passes} - {("", "Alpha"), ("", "Depth")}
                wrong = expected_passes(Path(path)) ^ seen
                self.note("Blender lists all passes", path, f"differs: {sorted(wrong)}" if wrong else None)
            for entry in jobs:
                distance = result["displaced"].get(entry["map"])
                if distance is not None:
                    wrong = None if distance <= entry["tolerance"] else f"{distance} off"
                    self.note("Blender displaces a grid to the OBJ's vertices", entry["map"], wrong)
            if at := result["at"]:
                self.note("Blender lists all passes", at, "Blender ended while it opened the file")
            done = {*result["passes"], *result["displaced"], result["at"]}
            if result["at"] == "start":
                break
            files = [path for path in files if path not in done]
            jobs = [entry for entry in jobs if entry["map"] not in done]

    def three(self):
        firsts = {entry["map"]: entry["vertices"][0] for entry in self.displacements()}
        wanted = self.pictures + self.glbs
        for start in range(0, len(wanted), 200):
            chunk = wanted[start:start + 200]
            result = run("node", self.node / "three_files.mjs", *chunk)
            lines = {}
            for line in result.stdout.splitlines():
                if line.startswith("{"):
                    row = json.loads(line)
                    lines[row["file"]] = row
            for path in chunk:
                row = lines.get(str(path), {"error": result.stderr[-300:] or "no answer"})
                wrong = row.get("error")
                if not wrong and str(path) in firsts:
                    off = max(abs(a - b) for a, b in zip(row["first"], firsts[str(path)]))
                    scale = max(1e-30, *(abs(x) for x in firsts[str(path)]))
                    wrong = f"first pixel {off} off" if off > 1e-5 * scale else None
                kind = "GLTFLoader" if path.suffix == ".glb" else "EXRLoader"
                self.note(f"three.js {kind} reads", path, wrong)

    def openexr(self):
        for path in self.exrs:
            result = run("exrinfo", "-v", path)
            self.note("OpenEXR's exrinfo reads", path, result.stdout + result.stderr if result.returncode else None)

    def rewritten(self):
        """Saved again by OpenImageIO, then back to .dgm: the same bytes as before."""
        for dgm, index, _ in self.maps:
            for form in ("auto", "multipart"):
                folder = index.parent.parent / form
                again = folder / "again"
                again.mkdir()
                wrong = None
                for path in sorted(folder.glob("*.exr")):
                    result = run("oiiotool", path, "-o", again / path.name)
                    wrong = wrong or (result.stderr if result.returncode else None)
                main = min(again.glob("*.exr"), key=lambda path: len(path.name), default=None)
                if main is not None:
                    result = run(self.tool("dgm-export"), main, "-o", again / "back.dgm")
                    wrong = wrong or (result.stderr if result.returncode else None)
                if not wrong and (again / "back.dgm").read_bytes() != dgm.read_bytes():
                    wrong = "other bytes than before"
                self.note("oiiotool rewrites, dgm-export reads back", folder, wrong)
                shutil.rmtree(again)

    def report(self):
        failed = False
        for check, files in self.results.items():
            bad = {file: wrong for file, wrong in files.items() if wrong}
            failed = failed or bool(bad)
            print(f"{len(files) - len(bad):6} of {len(files):<6} {check}")
            for file, wrong in list(bad.items())[:5]:
                print(f"       {file}: {wrong.strip()[:300]}")
        (self.out / "clients.json").write_text(json.dumps(self.results, indent=1, sort_keys=True) + "\n")
        return 3 if failed else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", required=True)
    parser.add_argument("--node", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("inputs", nargs="+", type=Path)
    arguments = parser.parse_args()
    clients = Clients(arguments)
    clients.out.mkdir(parents=True, exist_ok=True)
    for number, dgm in enumerate(clients.bake(arguments.inputs)):
        clients.export(dgm, f"{number:03}_{dgm.stem}")
    clients.blender()
    clients.three()
    clients.openexr()
    clients.rewritten()
    return clients.report()


if __name__ == "__main__":
    sys.exit(main())
