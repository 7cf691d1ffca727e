# SPDX-License-Identifier: GPL-3.0-or-later
"""What a mesh names stays in its folder or in an asset root, and what a worker is given stays with it."""
import json
import os
import struct
import subprocess
import time
import unittest
import zlib
from pathlib import Path

import h5py

import meshes
import support
from test_said import write_gltf
from test_up_to_date import png, write_textured

SIZE = ["--size", "9", "--method", "tutte", "--fit", "sample", "--progress", "none"]
PRIVATE = (10, 200, 30)
# A pipe that somebody waits for is told at once; the time is that of a slow machine.
AT_ONCE_SECONDS = 30


def huge_png(side, depth, colour, rows):
    """A PNG of side x side pixels, of which `rows` rows are there, all black."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    channels = {0: 1, 2: 3, 6: 4}[colour]
    row, packer = bytes(1 + side * channels * depth // 8), zlib.compressobj(1)
    packed = b"".join(packer.compress(row * 64) for _ in range(rows // 64)) + packer.flush()
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, depth, colour, 0, 0, 0)) +
            chunk(b"IDAT", packed) + chunk(b"IEND", b""))


class References(support.Folder):
    def setUp(self):
        super().setUp()
        for name in ("in", "library", "private"):
            (self.folder / name).mkdir()
        (self.folder / "private" / "photo.png").write_bytes(png([[PRIVATE]]))
        (self.folder / "library" / "oak.png").write_bytes(png([[PRIVATE]]))

    def outcome(self, mesh, *arguments):
        result = self.bake_well(mesh, "-o", "out/m.dgm", *SIZE, "--report", "r.json", *arguments)
        (asset,) = json.loads((self.folder / "r.json").read_text())["assets"]
        return asset, result.stderr

    def colour(self):
        """A texel of the baked texture; None if it has none, as without pictures and colours."""
        with h5py.File(self.folder / "out" / "m.dgm") as file:
            layers = file["charts/0"]
            return tuple(int(x) for x in layers["texture"][0, 0][:3]) if "texture" in layers else None

    def test_private_pictures_are_not_baked(self):
        photo = self.folder / "private" / "photo.png"
        os.symlink(photo, self.folder / "in" / "link.png")
        os.symlink(photo.parent, self.folder / "in" / "folder")
        for name in (photo, "../private/photo.png", "..\\private\\photo.png", "link.png", "folder/photo.png",
                     f"file://{photo}", "-bm 2 ../private/photo.png"):
            with self.subTest(name=str(name)):
                write_textured(self.folder / "in" / "m.obj", "m.mtl", name)
                asset, said = self.outcome("in/m.obj")
                self.assertIn("warning: DGM3013: texture outside the mesh's folder: ", said)
                self.assertIn("allow its folder with --asset-root DIR", said)
                self.assertEqual(asset["outcome"], "baked")
                self.assertIsNone(self.colour())

    def test_libraries_stay_home(self):
        write_textured(self.folder / "in" / "m.obj", "m.mtl", "none.png")
        text = (self.folder / "in" / "m.obj").read_text()
        for name in ("../../../../../../etc/passwd", "/etc/passwd"):
            (self.folder / "in" / "m.obj").write_text(text.replace("mtllib m.mtl", f"mtllib {name}"))
            self.assertIn(f"DGM3013: material library outside the mesh's folder: {name};", self.outcome("in/m.obj")[1])

    def test_asset_roots_are_allowed(self):
        for name in ("../library/oak.png", "D:\\studio\\oak.png", self.folder / "library" / "oak.png"):
            with self.subTest(name=str(name)):
                write_textured(self.folder / "in" / "m.obj", "m.mtl", name)
                self.outcome("in/m.obj")
                self.assertIsNone(self.colour())
                asset, said = self.outcome("in/m.obj", "--asset-root", "private", "--asset-root", "library/")
                self.assertEqual((asset["outcome"], "DGM" in said), ("baked", False), said)
                self.assertEqual(self.colour(), PRIVATE)
                self.assertIn("--asset-root private --asset-root library/", asset["command"])
                again = self.outcome("in/m.obj", "--asset-root", "private", "--asset-root", "library")[0]
                self.assertEqual(again["outcome"], "up to date")
                self.assertEqual(self.outcome("in/m.obj")[0]["outcome"], "baked", "without a root it is another map")
        self.assertEqual(self.bake("in/m.obj", "--asset-root", "none").returncode, 1)

    def test_buffers_stay_home(self):
        write_gltf(self.folder / "in" / "m.gltf", meshes.sheet(4), "../library/oak.png")
        gltf = self.folder / "in" / "m.gltf"
        (self.folder / "in" / "m.bin").rename(self.folder / "library" / "m.bin")
        text = gltf.read_text()
        for uri in ("../library/m.bin", str(self.folder / "library" / "m.bin")):
            gltf.write_text(text.replace('"m.bin"', json.dumps(uri)))
            refused = self.bake("in/m.gltf", "-o", "out/m.dgm", *SIZE)
            self.assertEqual(refused.returncode, 3, refused.stderr)
            self.assertIn("DGM3013: it needs ", refused.stderr)
            self.assertIn("next: copy it beside the mesh, or allow its folder with --asset-root DIR", refused.stderr)
        gltf.write_text(text.replace('"m.bin"', '"../library/m.bin"'))
        asset, said = self.outcome("in/m.gltf", "--asset-root", "library")
        self.assertEqual((asset["outcome"], "DGM" in said), ("baked", False), said)
        self.assertEqual(self.colour(), PRIVATE)
        self.assertEqual(self.outcome("in/m.gltf", "--asset-root", "library")[0]["outcome"], "up to date")
        (self.folder / "library" / "oak.png").write_bytes(png([[(1, 2, 3)]]))
        self.assertEqual(self.outcome("in/m.gltf", "--asset-root", "library")[0]["outcome"], "baked")
        if support.VALIDATE:
            check = [support.VALIDATE, "out/m.dgm", "--source", "in/m.gltf", "-q"]
            self.assertNotEqual(self.run_program(*check).returncode, 0)
            self.assertEqual(self.run_program(*check, "--asset-root", "library").returncode, 0)

    def test_pages_of_a_report_find_what_the_bake_found(self):
        write_gltf(self.folder / "in" / "m.gltf", meshes.sheet(4))
        (self.folder / "in" / "m.bin").rename(self.folder / "library" / "m.bin")
        gltf = self.folder / "in" / "m.gltf"
        gltf.write_text(gltf.read_text().replace('"m.bin"', '"../library/m.bin"'))
        result = self.bake_well("in/m.gltf", "-o", "out/m.dgm", *SIZE, "--report", "r.html", "--asset-root", "library")
        self.assertIn("1 page made, 0 kept, 0 failed", result.stdout)

    def test_pipes_are_refused_at_once(self):
        for name in ("pipe.obj", "pipe.png", "pipe.bin", "pipe.ply"):
            os.mkfifo(self.folder / "in" / name)
        write_textured(self.folder / "in" / "m.obj", "m.mtl", "pipe.png")
        write_gltf(self.folder / "in" / "m.gltf", meshes.sheet(4))
        gltf = self.folder / "in" / "m.gltf"
        gltf.write_text(gltf.read_text().replace('"m.bin"', '"pipe.bin"'))
        start = time.monotonic()
        self.assertIn("DGM3014: texture is a pipe or a device: pipe.png", self.outcome("in/m.obj")[1])
        for mesh, exit_code, code in (("in/m.gltf", 3, "DGM3014: it needs pipe.bin"), ("in/pipe.obj", 2, "DGM5002"),
                                      ("in/pipe.ply", 2, "DGM5002"), ("/dev/zero", 2, "DGM5002")):
            refused = self.bake(mesh, "-o", "no.dgm", *SIZE)
            self.assertEqual(refused.returncode, exit_code, mesh + refused.stderr)
            self.assertIn(code, refused.stderr)
        if support.VALIDATE:
            checked = self.run_program(support.VALIDATE, "out/m.dgm", "--source", "in/pipe.obj")
            self.assertEqual(checked.returncode, 2, checked.stdout)
        self.assertLess(time.monotonic() - start, AT_ONCE_SECONDS)

    @unittest.skipIf(support.SANITIZED, "the address sanitizer needs unlimited address space")
    def test_short_memory_is_no_missing_picture(self):
        write_textured(self.folder / "in" / "m.obj", "m.mtl", "huge.png")
        (self.folder / "in" / "huge.png").write_bytes(huge_png(16384, 8, 0, 16384))
        failed = self.bake("in/m.obj", "-o", "out/m.dgm", *SIZE, "--memory-limit", "700MiB")
        self.assertEqual(failed.returncode, 3, failed.stderr)
        self.assertIn("DGM9004", failed.stderr)
        self.assertFalse((self.folder / "out" / "m.dgm").exists())

    def test_pictures_of_16_bits_that_are_too_large_are_called_so(self):
        write_textured(self.folder / "in" / "m.obj", "m.mtl", "huge.png")
        (self.folder / "in" / "huge.png").write_bytes(huge_png(16384, 16, 6, 64))
        self.assertIn("16384 x 16384 pixels of 16 bits: decoded it has 2 GiB or more", self.outcome("in/m.obj")[1])
        (self.folder / "in" / "huge.png").write_bytes(huge_png(512, 16, 6, 64))
        self.assertNotIn("2 GiB", self.outcome("in/m.obj")[1])


class WhatAWorkerHas(support.Folder):
    def test_neither_secrets_nor_files_of_the_caller(self):
        (self.folder / "hang.obj").write_text("a mesh that misbehaves\n")
        secret, writable = os.pipe()
        self.addCleanup(os.close, secret)
        self.addCleanup(os.close, writable)
        environment = dict(os.environ, SECRET_TOKEN="do-not-tell", PYTHONPATH="/x", LC_ALL="C.UTF-8")
        with subprocess.Popen([support.FAULTY_BAKE, "hang.obj", "--time-limit", "60", "--progress", "none"],
                              cwd=self.folder, env=environment, pass_fds=[secret], stderr=subprocess.PIPE) as program:
            try:
                worker = self.worker_of(program.pid)
                names = {entry.split(b"=")[0] for entry in (worker / "environ").read_bytes().split(b"\0")}
                self.assertNotIn(b"SECRET_TOKEN", names)
                self.assertNotIn(b"HOME", names)
                self.assertIn(b"LC_ALL", names)
                open_files = {int(entry.name): os.readlink(entry) for entry in (worker / "fd").iterdir()}
                self.assertEqual(sorted(open_files), [0, 1, 2, 3], open_files)
                limits = (worker / "limits").read_text()
                self.assertRegex(limits, r"Max file size +68719476736 +68719476736")
                self.assertRegex(limits, r"Max cpu time +\d+ +\d+")
                self.assertIn("NoNewPrivs:\t1", (worker / "status").read_text())
            finally:
                program.terminate()
                program.wait(20)

    def worker_of(self, parent):
        """The process below `parent` that has entered its sandbox."""
        deadline = time.monotonic() + 20
        while time.monotonic() < deadline:
            for entry in Path("/proc").iterdir():
                try:
                    if entry.name.isdigit() and f"PPid:\t{parent}\n" in (entry / "status").read_text():
                        if b"--worker" in (entry / "cmdline").read_bytes():
                            if "Seccomp:\t2" in (entry / "status").read_text():
                                return entry
                except OSError:
                    continue
            time.sleep(0.02)
        self.skipTest("no worker in a sandbox was seen")
        return None


if __name__ == "__main__":
    unittest.main()
