# SPDX-License-Identifier: GPL-3.0-or-later
"""Changed OBJ, 3DS and glTF files, material libraries and pictures through the real program: each is baked to a valid file, or refused with a code.

As a test: a few, always the same. By scripts/fuzz: new ones until the time is up.

    test_hostile_meshes.py --seconds S [--keep FOLDER]      what fails is copied to FOLDER; exit code 1 if anything did
"""
import base64
import json
import random
import shutil
import struct
import sys
import tempfile
import time
import unittest
import zlib
from pathlib import Path

import meshes
import support

WORDS = [b"nan", b"inf", b"-inf", b"1e308", b"-1e308", b"1e-320", b"0", b"-1", b"1", b"2147483647", b"4294967297", b"-99",
         b"1/1/1", b"//", b"1//", b"", b"v", b"f", b"vt", b"usemtl", b"mtllib x.mtl", b"\\", b"#", b"\0", b"\xff"]
WORST = ("DGM9001", "DGM9002", "DGM9003", "DGM9004")


def tds(mesh):
    """The bytes of a 3DS file of one object, with texture coordinates and a material."""
    def chunk(kind, *parts):
        body = b"".join(parts)
        return struct.pack("<HI", kind, 6 + len(body)) + body

    vertices, faces = mesh
    count = struct.pack("<H", len(vertices))
    points = chunk(0x4110, count, *(struct.pack("<3f", *v) for v in vertices))
    uvs = chunk(0x4140, count, *(struct.pack("<2f", v[0], v[1]) for v in vertices))
    groups = chunk(0x4130, b"skin\0", struct.pack("<H", len(faces)), *(struct.pack("<H", k) for k in range(len(faces))))
    smooth = chunk(0x4150, *(struct.pack("<I", 1) for _ in faces))
    triangles = chunk(0x4120, struct.pack("<H", len(faces)), *(struct.pack("<4H", *f, 0) for f in faces), groups, smooth)
    frame = chunk(0x4160, struct.pack("<12f", 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0))
    body = chunk(0x4000, b"body\0", chunk(0x4100, points, uvs, triangles, frame))
    colour = chunk(0xA020, chunk(0x0011, bytes([200, 100, 50])))
    material = chunk(0xAFFF, chunk(0xA000, b"skin\0"), colour, chunk(0xA200, chunk(0xA300, b"skin.png\0")))
    return chunk(0x4D4D, chunk(0x0002, struct.pack("<I", 3)), chunk(0x3D3D, material, body))


def gltf(mesh):
    """The text of a glTF file of one mesh, its buffer inside."""
    vertices, faces = mesh
    points = b"".join(struct.pack("<3f", *v) for v in vertices)
    indices = b"".join(struct.pack("<3H", *f) for f in faces)
    low, high = [[pick(v[k] for v in vertices) for k in range(3)] for pick in (min, max)]
    return json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "scale": [1, 1, 1], "rotation": [0, 0, 0, 1], "children": []}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 4, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 1], "baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0, "sampler": 0}], "samplers": [{"magFilter": 9729}], "images": [{"uri": "skin.png"}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3", "min": low, "max": high},
                      {"bufferView": 1, "componentType": 5123, "count": 3 * len(faces), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(points)},
                        {"buffer": 0, "byteOffset": len(points), "byteLength": len(indices)}],
        "buffers": [{"byteLength": len(points + indices), "uri": "data:application/octet-stream;base64," +
                     base64.b64encode(points + indices).decode()}]}, indent=1).encode()


def png(side=8):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + bytes((x * y * 4) & 255 for x in range(3 * side)) for y in range(side))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", side, side, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def textured(mesh, library):
    vertices, faces = mesh
    lines = [f"mtllib {library}"] + [f"v {x} {y} {z}\nvt {x / 2 + 0.5} {y / 2 + 0.5}" for x, y, z in vertices]
    return "\n".join(lines + ["usemtl skin"] + ["f " + " ".join(f"{v + 1}/{v + 1}" for v in f) for f in faces]) + "\n"


def changed_bytes(data, draw):
    data = bytearray(data)
    for _ in range(draw.choice((1, 1, 2, 4, 16))):
        where, what = draw.randrange(len(data)), draw.randrange(5)
        if what == 0:
            data[where] ^= 1 << draw.randrange(8)
        elif what == 1:
            data[where] = draw.choice((0, 1, 0x7F, 0x80, 0xFF))
        elif what == 2:
            data[where:where + 4] = struct.pack("<I", draw.choice((0, 5, 0x7FFFFFFF, 0xFFFFFFFF, len(data))))
        elif what == 3:
            del data[where:where + draw.randrange(1, 12)]
        else:
            data[where:where] = data[where:where + draw.randrange(1, 40)]
        if not data:
            return b"\0"
    return bytes(data[:draw.randrange(1, len(data) + 1)]) if draw.random() < 0.1 else bytes(data)


def changed_text(data, draw):
    lines = [line.split(b" ") for line in data.split(b"\n")]
    for _ in range(draw.choice((1, 2, 5, 20))):
        line = draw.choice(lines)
        what = draw.randrange(4)
        if what == 0:
            line[draw.randrange(len(line))] = draw.choice(WORDS)
        elif what == 1:
            line.insert(draw.randrange(len(line) + 1), draw.choice(WORDS))
        elif what == 2:
            lines.insert(draw.randrange(len(lines) + 1), list(draw.choice(lines)))
        else:
            lines.remove(line)
            lines = lines or [[b"f"]]
    text = b"\n".join(b" ".join(line) for line in lines)
    return changed_bytes(text, draw) if draw.random() < 0.2 else text


def write_changed(folder, count, draw, scratch):
    """`count` changed files of each seed."""
    for name, mesh in (("ball", meshes.icosphere(1)), ("sheet", meshes.sheet(5)), ("ring", meshes.torus(8, 6))):
        text = meshes.write_obj(scratch / "seed.obj", mesh).read_bytes()
        binary = tds(mesh)
        (folder / f"{name}.3ds").write_bytes(binary)
        for k in range(count):
            (folder / f"{name}_{k}.obj").write_bytes(changed_text(text, draw) or b"\n")
            (folder / f"{name}_{k}.3ds").write_bytes(changed_bytes(binary, draw))


def write_changed_materials(folder, count, draw):
    """Good meshes with changed libraries, with changed pictures, and changed glTF files."""
    mesh = meshes.icosphere(1)
    library = b"newmtl skin\nKd 0.8 0.5 0.25\nmap_Kd -s 2 3 1 -o .5 -.5 0 skin.png\nbump -bm 0.5 skin.png\nd 0.5\n"
    (folder / "skin.png").write_bytes(png())
    for k in range(count):
        (folder / f"material_{k}.obj").write_text(textured(mesh, f"material_{k}.mtl"))
        (folder / f"material_{k}.mtl").write_bytes(changed_text(library, draw))
        (folder / f"picture_{k}.obj").write_text(textured(mesh, f"picture_{k}.mtl"))
        (folder / f"picture_{k}.mtl").write_bytes(library.replace(b"skin.png", f"picture_{k}.png".encode()))
        (folder / f"picture_{k}.png").write_bytes(changed_bytes(png(), draw))
        (folder / f"scene_{k}.gltf").write_bytes(changed_text(gltf(mesh), draw))


class Hostile(support.Folder):
    def hold(self, count, draw):
        """Bakes changed files. {file name: what is wrong}, and how many were baked."""
        source = self.folder / "in"
        source.mkdir()
        write_changed(source, count, draw, self.folder)
        write_changed_materials(source, count, draw)
        result = self.bake("in", "-o", "out", "--size", "9", "--time-limit", "60", "--memory-limit", "1GiB", "-q",
                           "--progress", "none", "--report", "report.json")
        wrong, baked = {}, 0
        if result.returncode not in (0, 3):
            wrong["(batch)"] = f"exit code {result.returncode}: {result.stderr[:300]}"
        for asset in json.loads((self.folder / "report.json").read_text())["assets"]:
            name = Path(asset["source"]).name
            if "error" in asset:
                if asset["error"]["code"] in WORST:
                    wrong[name] = f"{asset['error']['code']} {asset['error']['message']}"
                continue
            baked += 1
            written = next((self.folder / "out").glob(f"{name}.dgm"), None) or self.folder / asset["files"][0]["path"]
            checked = self.run_program(support.VALIDATE, written, "--source", source / name, "-q")
            if checked.returncode != 0:
                wrong[name] = f"not valid: {checked.stdout[:300]}{checked.stderr[:300]}"
        return wrong, baked

    def test_a_few(self):
        wrong, baked = self.hold(5, random.Random(20))
        self.assertEqual(wrong, {})
        self.assertGreater(baked, 10)


def run_for(seconds, keep):
    end, seed, found = time.monotonic() + seconds, int(time.time()), 0
    while time.monotonic() < end:
        case = Hostile()
        case.folder = Path(tempfile.mkdtemp(prefix="dgm-hostile-")).resolve()
        try:
            wrong, _ = case.hold(20, random.Random(seed))
            for name, what in wrong.items():
                found += 1
                print(f"{name}, seed {seed}: {what}", flush=True)
                if (case.folder / "in" / name).is_file():
                    shutil.copy(case.folder / "in" / name, Path(keep) / f"worker-{seed}-{name}")
        finally:
            shutil.rmtree(case.folder, ignore_errors=True)
        seed += 1
    return 1 if found else 0


if __name__ == "__main__":
    if "--seconds" in sys.argv:
        kept = sys.argv[sys.argv.index("--keep") + 1] if "--keep" in sys.argv else "."
        sys.exit(run_for(float(sys.argv[sys.argv.index("--seconds") + 1]), kept))
    unittest.main()
