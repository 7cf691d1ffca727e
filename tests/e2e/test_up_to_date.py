# SPDX-License-Identifier: GPL-3.0-or-later
"""Finished work is not done twice, changed work is, and build systems get the inputs of each output."""
import json
import os
import shutil
import struct
import subprocess
import time
import unittest

import h5py

import meshes
import support
from pictures import png

SIZE = ["--size", "17", "--method", "tutte", "--fit", "sample"]
FINE = ["--size", "129", "--method", "tutte", "--fit", "sample"]


def write_textured(path, library, texture):
    vertices, faces = meshes.sheet(4)
    lines = [f"mtllib {library}", "usemtl skin"]
    lines += ["v {} {} {}".format(*v) for v in vertices]
    lines += ["vt {} {}".format(v[0], v[1]) for v in vertices]
    lines += ["f " + " ".join(f"{k + 1}/{k + 1}" for k in f) for f in faces]
    path.write_text("\n".join(lines) + "\n")
    (path.parent / library).write_text(f"newmtl skin\nKd 1 1 1\nmap_Kd {texture}\n")


def tiny_3ds(texture):
    """A square of two triangles whose material names a texture."""
    def chunk(kind, data):
        return struct.pack("<HI", kind, 6 + len(data)) + data
    name = texture.encode() + b"\0"
    material = chunk(0xAFFF, chunk(0xA000, b"skin\0") + chunk(0xA200, chunk(0x0030, b"\x64\0") + chunk(0xA300, name)))
    points = struct.pack("<H12f", 4, 0, 0, 0, 1, 0, 0, 1, 1, .2, 0, 1, 0)
    faces = struct.pack("<H8H", 2, 0, 1, 2, 0, 0, 2, 3, 0) + chunk(0x4130, b"skin\0" + struct.pack("<3H", 2, 0, 1))
    coords = struct.pack("<H8f", 4, 0, 0, 1, 0, 1, 1, 0, 1)
    surface = chunk(0x4100, chunk(0x4110, points) + chunk(0x4120, faces) + chunk(0x4140, coords))
    mesh = chunk(0x4000, b"sheet\0" + surface)
    return chunk(0x4D4D, chunk(0x3D3D, material + mesh))


class MeshesBesideTheMap(support.Folder):
    FORMATS = ["--format", "dgm,exr,glb,obj,ply"]

    def setUp(self):
        super().setUp()
        write_textured(self.folder / "sheet.obj", "sheet.mtl", "skin.png")
        (self.folder / "skin.png").write_bytes(png([[(200, 10, 10)]]))

    def outcome(self, *arguments):
        result = self.bake("sheet.obj", "-o", "out", *(arguments or self.FORMATS), *SIZE, "--report", "r.json")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        (asset,) = json.loads((self.folder / "r.json").read_text())["assets"]
        return asset

    def test_they_are_those_of_the_exporter(self):
        asset = self.outcome()
        self.assertEqual(asset["settings"]["format"], ["dgm", "exr", "glb", "obj", "ply"])
        names = ["sheet.dgm", "sheet.exr", "sheet.glb", "sheet.mtl", "sheet.obj", "sheet.ply", "sheet_normal.png",
                 "sheet_texture.png"]
        beside = ["sheet.bump.exr", "sheet.texture.exr"]  # layers of the EXR, a part of that file
        self.assertEqual(self.names(self.folder / "out"), sorted(names + beside))
        self.assertEqual(sorted({os.path.basename(file["path"]) for file in asset["files"]}), names)
        self.assertEqual(asset["files"][0]["path"], "out/sheet.dgm")
        for file in asset["files"]:
            parts = [file["path"]] + ([f"out/{name}" for name in beside] if file["path"].endswith(".exr") else [])
            self.assertEqual(file["bytes"], sum((self.folder / part).stat().st_size for part in parts))
        if not support.EXPORT:
            self.skipTest("dgm-export was not built")
        again = self.run_program(support.EXPORT, "out/sheet.dgm", "-o", "again", "--format", "glb,obj,ply")
        self.assertEqual(again.returncode, 0, again.stderr)
        for name in names[2:]:
            self.assertEqual((self.folder / "again" / name).read_bytes(), (self.folder / "out" / name).read_bytes(), name)

    def test_each_of_them_counts(self):
        self.assertEqual(self.outcome()["outcome"], "baked")
        again = self.outcome()
        self.assertEqual(again["outcome"], "up to date")
        self.assertEqual(len(again["files"]), 5)
        out = self.folder / "out"
        for name in ("sheet.glb", "sheet.obj", "sheet.ply", "sheet.mtl", "sheet_texture.png", "sheet_normal.png"):
            with self.subTest(missing=name):
                whole = (out / name).read_bytes()
                (out / name).unlink()
                self.assertEqual(self.outcome()["outcome"], "baked")
                self.assertEqual((out / name).read_bytes(), whole)
                self.assertEqual(self.outcome()["outcome"], "up to date")
        for name in ("sheet.glb", "sheet.obj", "sheet.ply"):
            with self.subTest(short=name):
                (out / name).write_bytes((out / name).read_bytes()[:-1])
                self.assertEqual(self.outcome()["outcome"], "baked")
        (self.folder / "skin.png").write_bytes(png([[(10, 200, 10)]]))
        old = (out / "sheet.glb").read_bytes()
        self.assertEqual(self.outcome()["outcome"], "baked")
        self.assertNotEqual((out / "sheet.glb").read_bytes(), old)
        # Another map with meshes of the old one beside it.
        self.bake_well("sheet.obj", "-o", "out", *SIZE, "--precision", "u16")
        self.assertEqual(self.outcome("--format", "dgm,glb", "--precision", "u16")["outcome"], "baked")
        self.assertEqual(self.outcome("--format", "dgm,glb", "--precision", "u16")["outcome"], "up to date")

    def test_what_the_mesh_was_read_from_is_kept(self):
        before = {name: (self.folder / name).read_bytes() for name in self.names()}
        refused = self.bake("sheet.obj", "--format", "dgm,obj", *SIZE)
        self.assertEqual(refused.returncode, 1)
        self.assertIn("overwrite", refused.stderr)
        # cloth.obj would bring cloth.mtl, and that is the library that it was read with.
        shutil.copy(self.folder / "sheet.mtl", self.folder / "cloth.mtl")
        (self.folder / "in").mkdir()
        text = (self.folder / "sheet.obj").read_text().replace("mtllib sheet.mtl", "mtllib ../cloth.mtl")
        (self.folder / "in" / "cloth.obj").write_text(text)
        (self.folder / "in" / "skin.png").write_bytes(png([[(9, 9, 9)]]))
        refused = self.bake("in/cloth.obj", "--asset-root", ".", "-o", ".", "--format", "dgm,obj", *SIZE)
        self.assertEqual(refused.returncode, 1, refused.stdout + refused.stderr)
        self.assertIn("cloth.mtl", refused.stderr)
        self.assertEqual((self.folder / "cloth.mtl").read_bytes(), before["sheet.mtl"])
        self.assertFalse((self.folder / "cloth.dgm").exists())
        self.assertEqual([n for n in self.names() if n.startswith(".")], [])
        for name, content in before.items():
            self.assertEqual((self.folder / name).read_bytes(), content, name)


class UpToDate(support.Folder):
    def outcomes(self, *arguments, cwd=None):
        """Which meshes were baked, and which were left alone."""
        result = self.bake(*arguments, *SIZE, "--report", self.folder / "r.json", cwd=cwd)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        report = json.loads((self.folder / "r.json").read_text())
        return {asset["name"]: asset["outcome"] for asset in report["assets"]}

    def baked(self, *arguments, cwd=None):
        (outcome,) = self.outcomes(*arguments, cwd=cwd).values()
        self.assertIn(outcome, ("baked", "up to date"))
        return outcome == "baked"

    def test_whatever_the_spelling_of_the_path(self):
        (self.folder / "in").mkdir()
        (self.folder / "else").mkdir()
        mesh = self.folder / "in" / "a.obj"
        meshes.write_obj(mesh, meshes.sheet(4))
        os.symlink(self.folder / "in", self.folder / "link")
        self.assertTrue(self.baked("in/a.obj", "-o", "a.dgm"))
        before = (self.folder / "a.dgm").stat()
        for spelling in ("in/a.obj", "./in/../in//a.obj", mesh, "link/a.obj"):
            self.assertFalse(self.baked(spelling, "-o", "a.dgm"), spelling)
        self.assertFalse(self.baked("../in/a.obj", "-o", self.folder / "a.dgm", cwd=self.folder / "else"))
        os.utime(mesh)  # contents count, not times
        self.assertFalse(self.baked("in/a.obj", "-o", "a.dgm"))
        after = (self.folder / "a.dgm").stat()
        self.assertEqual((before.st_ino, before.st_mtime_ns), (after.st_ino, after.st_mtime_ns))
        # The folder may move, outputs with it.
        shutil.move(self.folder / "in", self.folder / "moved")
        shutil.move(self.folder / "a.dgm", self.folder / "moved" / "a.dgm")
        self.assertFalse(self.baked("moved/a.obj", "-o", "moved/a.dgm"))

    def test_what_is_baked_again(self):
        mesh = self.folder / "a.obj"
        meshes.write_obj(mesh, meshes.sheet(4))
        bake = ["a.obj", "-o", "a.dgm"]
        self.assertTrue(self.baked(*bake))
        self.assertFalse(self.baked(*bake))
        self.assertTrue(self.baked(*bake, "--force"))
        self.assertTrue(self.baked(*bake, "--precision", "u16"))
        self.assertTrue(self.baked(*bake))
        # The number of jobs, limits and what is printed are no settings of the result.
        self.assertFalse(self.baked(*bake, "-j1", "--time-limit", "99", "-v"))
        with open(mesh, "a", encoding="ascii") as file:
            file.write("# changed\n")
        self.assertTrue(self.baked(*bake))
        # A damaged output is none: one bit of a layer or of the index, a lost end, another program's file.
        good = (self.folder / "a.dgm").read_bytes()
        with h5py.File(self.folder / "a.dgm", "r") as file:
            layer = file["charts/0/geometry"].id.get_offset()
        for damage in (layer + 5, 60, 200):
            bad = bytearray(good)
            bad[damage] ^= 1
            (self.folder / "a.dgm").write_bytes(bad)
            self.assertTrue(self.baked(*bake), damage)
            self.assertEqual((self.folder / "a.dgm").read_bytes(), good)
        for bad in (good[:-1], b"", b"not ours"):
            (self.folder / "a.dgm").write_bytes(bad)
            self.assertTrue(self.baked(*bake))
        self.assertFalse(self.baked(*bake))
        # Another source in the same place.
        meshes.write_obj(self.folder / "b.obj", meshes.sheet(4))
        self.assertTrue(self.baked("b.obj", "-o", "a.dgm"))

    def test_materials_and_textures(self):
        (self.folder / "textures").mkdir()
        write_textured(self.folder / "a.obj", "my skins.mtl", "C:\\art\\Skin.PNG")
        self.assertTrue(self.baked("a.obj"))
        self.assertFalse(self.baked("a.obj"))
        texture = self.folder / "textures" / "skin.png"
        texture.write_bytes(png([[(255, 0, 0)]]))  # it was missing, and turns up
        self.assertTrue(self.baked("a.obj"))
        self.assertFalse(self.baked("a.obj"))
        texture.write_bytes(png([[(0, 255, 0)]]))
        self.assertTrue(self.baked("a.obj"))
        (self.folder / "unused.png").write_bytes(b"")
        self.assertFalse(self.baked("a.obj"))
        with open(self.folder / "my skins.mtl", "a", encoding="ascii") as library:
            library.write("# changed\n")
        self.assertTrue(self.baked("a.obj"))
        texture.unlink()
        self.assertTrue(self.baked("a.obj"))
        self.assertFalse(self.baked("a.obj"))
        (self.folder / "fabric.png").write_bytes(png([[(1, 2, 3)]]))
        self.assertTrue(self.baked("a.obj", "--texture", "fabric.png"))
        self.assertFalse(self.baked("a.obj", "--texture", self.folder / "fabric.png"))
        (self.folder / "fabric.png").write_bytes(png([[(3, 2, 1)]]))
        self.assertTrue(self.baked("a.obj", "--texture", "fabric.png"))

    def test_3ds(self):
        (self.folder / "a.3ds").write_bytes(tiny_3ds("SKIN.JPG"))
        self.assertTrue(self.baked("a.3ds"))
        self.assertFalse(self.baked("a.3ds"))
        (self.folder / "skin.jpg").write_bytes(png([[(255, 0, 0)]]))
        self.assertTrue(self.baked("a.3ds"))
        self.assertFalse(self.baked("a.3ds"))
        (self.folder / "skin.jpg").write_bytes(png([[(0, 255, 0)]]))
        self.assertTrue(self.baked("a.3ds"))

    def test_exr(self):
        meshes.write_obj(self.folder / "a.obj", meshes.sheet(4))
        both = ["a.obj", "--format", "dgm,exr", "-o", "out"]
        self.assertTrue(self.baked(*both))
        self.assertFalse(self.baked(*both))
        self.assertFalse(self.baked("a.obj", "-o", "out"))
        self.assertTrue(self.baked(*both, "--exr-layout", "multipart"))
        self.assertFalse(self.baked(*both, "--exr-layout", "multipart"))
        exr = self.folder / "out" / "a.exr"
        exr.write_bytes(exr.read_bytes()[:-100])
        self.assertTrue(self.baked(*both, "--exr-layout", "multipart"))
        exr.unlink()
        self.assertTrue(self.baked(*both))

    def test_the_report_is_that_of_the_bake(self):
        meshes.write_obj(self.folder / "a.obj", meshes.sheet(4))
        reports = []
        for _ in range(2):
            self.bake_well("a.obj", *SIZE, "--report", "r.json")
            (asset,) = json.loads((self.folder / "r.json").read_text())["assets"]
            reports.append(asset)
        self.assertEqual([asset["outcome"] for asset in reports], ["baked", "up to date"])
        self.assertEqual(reports[0]["files"], reports[1]["files"])
        for key in ("times", "cpu_seconds", "peak_memory_bytes"):
            self.assertNotIn(key, reports[1]["report"])
            del reports[0]["report"][key]
        for asset in reports:
            for chart in asset["report"]["charts"]:
                for candidate in chart["candidates"]:
                    candidate.pop("cpu_seconds", None)
        self.assertEqual(reports[0]["report"], reports[1]["report"])

    def test_it_goes_on_where_it_was_interrupted(self):
        (self.folder / "in").mkdir()
        for k in range(4):
            meshes.write_obj(self.folder / "in" / f"{k}.obj", meshes.icosphere(4))
        process = subprocess.Popen([support.BAKE, "in", "-o", "out", "-j1", *FINE], cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        process.stdout.readline()  # the first is done
        process.send_signal(2)
        process.communicate(timeout=30)
        self.assertEqual(process.returncode, 130)
        done = self.names(self.folder / "out")
        self.assertTrue(1 <= len(done) < 4, done)
        self.assertTrue(all(name.endswith(".dgm") for name in done), done)
        result = self.bake_well("in", "-o", "out", "-j1", *FINE)
        self.assertIn(f"4 assets: {4 - len(done)} baked, {len(done)} up to date", result.stdout)
        for k in range(4):
            self.assertEqual(self.run_program(support.VALIDATE, f"out/{k}.dgm").returncode, 0)

    def test_contents_count_and_not_folders(self):
        """Of sixty folders with one mesh each, and a copy of one output, none is baked again."""
        for k in range(60):
            (self.folder / "in" / str(k)).mkdir(parents=True)
            (self.folder / "out" / str(k)).mkdir(parents=True)
        meshes.write_obj(self.folder / "in" / "0" / "m.obj", meshes.sheet(120))
        arguments = ["in", "-o", "out", "--size", "257", "--method", "tutte", "--fit", "sample"]
        self.bake_well(*arguments)
        outputs = [self.folder / "out" / str(k) / "m.dgm" for k in range(60)]
        for k in range(1, 60):
            shutil.copy(self.folder / "in" / "0" / "m.obj", self.folder / "in" / str(k))
            shutil.copy(outputs[0], outputs[k])
        before = [(output.stat().st_ino, output.stat().st_mtime_ns) for output in outputs]
        result = self.bake_well(*arguments)
        self.assertIn("60 assets: 60 up to date", result.stdout)
        self.assertEqual([(output.stat().st_ino, output.stat().st_mtime_ns) for output in outputs], before)


class BuildTools(support.Folder):
    """The depfile in the hands of those it is for. Names with everything both can read in them."""
    NAME = "a b#c$d"

    def setUp(self):
        super().setUp()
        write_textured(self.folder / f"{self.NAME}.obj", "my skin$.mtl", "sk in.png")
        (self.folder / "sk in.png").write_bytes(png([[(1, 2, 3)]]))

    def builds_after_changes(self, build, log):
        def baked():
            result = self.run_program(*build)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            lines = (self.folder / log).read_text().splitlines() if (self.folder / log).exists() else []
            return len(lines)
        self.assertEqual(baked(), 1)
        self.assertEqual(baked(), 1)
        count = 1
        for name in (f"{self.NAME}.obj", "my skin$.mtl", "sk in.png"):
            time.sleep(0.05)
            path = self.folder / name
            if name.endswith(".png"):
                path.write_bytes(png([[(3, 2, 1)]]))
            else:
                path.write_text(path.read_text() + "# changed\n")
            count += 1
            self.assertEqual(baked(), count, f"{name} has changed")
            self.assertEqual(baked(), count)
        time.sleep(0.05)
        (self.folder / f"{self.NAME}.obj").touch()  # by time it is new, by content it is not
        content = (self.folder / f"{self.NAME}.dgm").read_bytes()
        count += 1
        self.assertEqual(baked(), count)
        self.assertEqual(baked(), count)
        self.assertEqual((self.folder / f"{self.NAME}.dgm").read_bytes(), content)
        # A deleted file does not stop the build.
        (self.folder / "sk in.png").unlink()
        self.assertEqual(baked(), count + 1)

    def command(self):
        return (f"echo x >> log && '{support.BAKE}' '{self.NAME}.obj' -o '{self.NAME}.dgm' -q -MF deps.d "
                + " ".join(SIZE))

    def test_make(self):
        target = self.NAME.replace("$", "$$").replace("#", "\\#").replace(" ", "\\ ")
        (self.folder / "Makefile").write_text(
            f"all: {target}.dgm\n{target}.dgm: {target}.obj\n\t{self.command().replace('$', '$$')}\n-include deps.d\n")
        self.builds_after_changes(["make"], "log")

    def test_ninja(self):
        def escape(text):
            return text.replace("$", "$$").replace(" ", "$ ").replace(":", "$:")
        (self.folder / "build.ninja").write_text(
            f"rule bake\n  command = {self.command().replace('$', '$$')}\n  depfile = deps.d\n"
            f"build {escape(self.NAME)}.dgm: bake {escape(self.NAME)}.obj\n")
        self.builds_after_changes(["ninja"], "log")

    def test_every_asset_has_a_rule_of_its_own(self):
        meshes.write_obj(self.folder / "x.obj", meshes.sheet(3))
        meshes.write_obj(self.folder / "bad.obj", meshes.line())
        result = self.bake("x.obj", f"{self.NAME}.obj", "bad.obj", "--format", "dgm,exr", "-o", "out", "-MF", "d",
                           *SIZE)
        self.assertEqual(result.returncode, 3)
        self.assertEqual((self.folder / "d").read_text(),
                         "out/x.dgm out/x.exr: \\\n  x.obj\n"
                         "out/a\\ b\\#c$$d.dgm out/a\\ b\\#c$$d.exr: \\\n  a\\ b\\#c$$d.obj \\\n"
                         "  my\\ skin$$.mtl \\\n  sk\\ in.png\n"
                         "\nmy\\ skin$$.mtl:\n\nsk\\ in.png:\n")


if __name__ == "__main__":
    unittest.main()
