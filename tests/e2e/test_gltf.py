# SPDX-License-Identifier: GPL-3.0-or-later
"""The .glb of baked meshes, read here from its bytes: structure, shape, texture, normal map, levels of detail."""
import io
import json
import struct
import unittest

import h5py
import numpy as np
from PIL import Image

import meshes
import pictures
import support

COMPONENTS = {5123: "<u2", 5125: "<u4", 5126: "<f4"}
NUMBERS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Glb:
    def __init__(self, data):
        self.data = data
        magic, version, length = struct.unpack("<4sII", data[:12])
        assert (magic, version, length) == (b"glTF", 2, len(data))
        json_length, json_type = struct.unpack("<I4s", data[12:20])
        assert json_type == b"JSON" and json_length % 4 == 0
        self.json = json.loads(data[20:20 + json_length])
        at = 20 + json_length
        length, kind = struct.unpack("<I4s", data[at:at + 8])
        assert kind == b"BIN\0" and length % 4 == 0 and at + 8 + length == len(data)
        self.binary = data[at + 8:]
        assert 0 <= length - self.json["buffers"][0]["byteLength"] < 4

    def view(self, index):
        view = self.json["bufferViews"][index]
        assert view["byteOffset"] % 4 == 0 and view["byteOffset"] + view["byteLength"] <= len(self.binary)
        return self.binary[view["byteOffset"]:view["byteOffset"] + view["byteLength"]]

    def accessor(self, index):
        accessor = self.json["accessors"][index]
        values = np.frombuffer(self.view(accessor["bufferView"]), COMPONENTS[accessor["componentType"]])
        assert len(values) == accessor["count"] * NUMBERS[accessor["type"]]
        return values if accessor["type"] == "SCALAR" else values.reshape(accessor["count"], -1)

    def chart_nodes(self):
        """The node of an only chart, or the children of the root."""
        (top,) = self.json["scenes"][0]["nodes"]
        root = self.json["nodes"][top]
        return [self.json["nodes"][k] for k in root["children"]] if "children" in root else [root]

    def primitives(self):
        """(material, translation, indices, {attribute: values}) of each chart."""
        for node in self.chart_nodes():
            (primitive,) = self.json["meshes"][node["mesh"]]["primitives"]
            attributes = {name: self.accessor(a) for name, a in primitive["attributes"].items()}
            bounds = self.json["accessors"][primitive["attributes"]["POSITION"]]
            assert bounds["min"] == attributes["POSITION"].min(0).astype(float).tolist()
            assert bounds["max"] == attributes["POSITION"].max(0).astype(float).tolist()
            yield (self.json["materials"][primitive["material"]], node.get("translation", [0, 0, 0]),
                   self.accessor(primitive["indices"]).reshape(-1, 3), attributes)

    def picture(self, texture):
        return png(self.view(self.json["images"][self.json["textures"][texture]["source"]]["bufferView"]))


def png(data):
    """RGBA of an 8-bit PNG without interlacing: [rows][columns][4]."""
    depth, colour, _, _, interlace = data[24:29]
    assert (depth, colour, interlace) == (8, 6, 0)
    at = 8
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        assert kind in (b"IHDR", b"IDAT", b"IEND"), f"a chunk that may differ from run to run: {kind}"
        at += 12 + length
    return np.asarray(Image.open(io.BytesIO(data))).astype(np.int64)


def noise():
    return np.random.default_rng(7).integers(0, 256, (40, 50, 3), np.uint8)


def read_obj(path):
    """Positions and faces, faces counted from 0."""
    positions, faces = [], []
    for line in path.read_text().splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            positions.append([float(x) for x in rest[:3]])
        elif word == "f":
            faces.append([int(corner.split("/")[0]) - 1 for corner in rest])
    return np.array(positions), np.array(faces)


def read_ply(path):
    """Vertices as a structured array, and faces, of a binary PLY with triangles."""
    data = path.read_bytes()
    head, body = data.split(b"end_header\n", 1)
    kinds = {"float": "<f4", "double": "<f8", "uchar": "u1"}
    fields, counts = [], []
    for line in head.decode().splitlines():
        words = line.split()
        if words[0] == "element":
            counts.append(int(words[2]))
        elif words[0] == "property" and words[1] != "list":
            fields.append((words[2], kinds[words[1]]))
    vertices = np.frombuffer(body, np.dtype(fields), counts[0])
    faces = np.frombuffer(body[vertices.nbytes:], np.dtype([("n", "u1"), ("v", "<u4", 3)]), counts[1])
    assert (faces["n"] == 3).all() and vertices.nbytes + faces.nbytes == len(body)
    return vertices, faces["v"]


def open_edges(points, faces):
    """Edges with one face, after welding equal positions."""
    _, weld = np.unique(points, axis=0, return_inverse=True)
    corners = weld.reshape(-1)[faces]
    edges = np.sort(np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    return int((count == 1).sum())


class Gltf(support.Folder):
    def baked(self, name, mesh, *arguments):
        meshes.write_obj(self.folder / f"{name}.obj", mesh)
        self.bake_well(f"{name}.obj", "-o", f"{name}.dgm", *arguments)
        return self.folder / f"{name}.dgm"

    def exported(self, source, name, *arguments):
        result = self.run_program(support.EXPORT, source, "-o", name, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.folder / name

    def glb(self, source, *arguments):
        return Glb(self.exported(source, "out.glb", *arguments).read_bytes())

    def check_attributes(self, glb):
        for material, _, indices, attributes in glb.primitives():
            count = len(attributes["POSITION"])
            self.assertEqual({len(values) for values in attributes.values()}, {count})
            self.assertEqual(sorted(set(indices.reshape(-1).tolist())), list(range(count)))  # each vertex is used
            self.assertEqual(indices.dtype, np.dtype("<u2" if count <= 65535 else "<u4"))
            normals, tangents = attributes["NORMAL"], attributes["TANGENT"]
            self.assertLess(abs(np.linalg.norm(normals, axis=1) - 1).max(), 1e-6)
            self.assertLess(abs(np.linalg.norm(tangents[:, :3], axis=1) - 1).max(), 1e-6)
            self.assertLess(abs((normals * tangents[:, :3]).sum(1)).max(), 1e-6)
            self.assertTrue((tangents[:, 3] == 1).all())
            self.assertEqual(material["pbrMetallicRoughness"]["metallicFactor"], 0)

    def check_is_the_obj(self, source, *arguments):
        glb = self.glb(source, *arguments)
        self.check_attributes(glb)
        points, faces = read_obj(self.exported(source, "out.obj", *arguments))
        wanted = points[faces]
        parts = [np.asarray(translation) + attributes["POSITION"].astype(float)[indices]
                 for _, translation, indices, attributes in glb.primitives()]
        found = np.concatenate(parts)
        self.assertEqual(found.shape, wanted.shape)
        size = np.ptp(points, axis=0).max()
        self.assertLess(abs(found - wanted).max(), 1e-7 * size + 1e-15 * abs(points).max())
        return glb

    def test_shape_is_that_of_the_obj(self):
        two = self.baked("two", meshes.together(meshes.icosphere(3), meshes.sheet(8)), "--size", "33x29")
        glb = self.check_is_the_obj(two)
        self.assertEqual(glb.json["asset"]["version"], "2.0")
        sides = sorted(material.get("doubleSided", False) for material, *_ in glb.primitives())
        self.assertEqual(sides, [False, True])  # the ball is closed, the sheet is open
        self.check_is_the_obj(two, "--lod", "4")
        self.check_is_the_obj(self.baked("codes", meshes.torus(), "--size", "33x33", "--precision", "u16"))
        self.check_is_the_obj(self.baked("free", meshes.sheet(8), "--size", "33x33", "--domain", "free"))

    def test_garments_can_share_a_scene(self):
        names = []
        for name, mesh in (("robe", meshes.sheet(8)), ("hat", meshes.icosphere(2)),
                           ("pair of shoes", meshes.together(meshes.icosphere(2), meshes.sheet(8)))):
            glb = self.glb(self.baked(name, mesh, "--size", "17x17"))
            for node in glb.chart_nodes():
                mesh = glb.json["meshes"][node["mesh"]]
                material = glb.json["materials"][mesh["primitives"][0]["material"]]
                self.assertEqual(node["name"], mesh["name"])
                self.assertEqual(node["name"], material["name"])
                names.append(node["name"])
            obj = self.exported(f"{name}.dgm", f"{name} out.obj")
            objects = [line[2:] for line in obj.read_text().splitlines() if line.startswith("o ")]
            self.assertEqual(objects, [n["name"].replace(" ", "_") for n in glb.chart_nodes()])
        self.assertEqual(names, ["robe", "hat", "pair of shoes_chart0", "pair of shoes_chart1"])

    def test_meshes_of_free_charts_hold_no_strays(self):
        sheet = self.baked("free", meshes.sheet(8), "--size", "33x33", "--domain", "free", "--method", "lscm")
        points, faces = read_obj(self.exported(sheet, "out.obj"))
        self.assertEqual(sorted(set(faces.reshape(-1).tolist())), list(range(len(points))))
        with h5py.File(sheet, "r") as file:
            self.assertLess(file["charts/0/mask"][...].min(), 1)  # there are samples outside
        vertices, triangles = read_ply(self.exported(sheet, "out.ply"))
        self.assertEqual(len(vertices), len(points))
        self.assertEqual(sorted(set(triangles.reshape(-1).tolist())), list(range(len(points))))
        self.assertTrue(np.allclose([vertices["x"], vertices["y"], vertices["z"]], points.T, rtol=1e-6, atol=1e-9))
        self.assertLess(0.5, np.ptp(vertices["s"]))
        self.assertTrue(((vertices["t"] >= 0) & (vertices["t"] <= 1)).all())

    def test_ply_shows_its_texture_where_the_colours_are(self):
        (self.folder / "cloth.png").write_bytes(pictures.png(noise()))
        ball = self.baked("ball", meshes.icosphere(2), "--size", "33x33", "--texture", "cloth.png", "--texture-size",
                          "70x48")
        path = self.exported(ball, "out.ply")
        vertices, _ = read_ply(path)
        (line,) = [l for l in path.read_bytes().split(b"end_header")[0].splitlines() if b"TextureFile" in l]
        picture = png((self.folder / line.decode().split(" ", 2)[2]).read_bytes())
        x = np.floor(vertices["s"] * picture.shape[1]).astype(int)
        y = np.floor((1 - vertices["t"].astype(float)) * picture.shape[0]).astype(int)
        for channel, name in enumerate(("red", "green", "blue")):
            self.assertTrue((picture[y, x, channel] == vertices[name]).all(), name)

    def test_a_folder_of_maps(self):
        for name in ("in/robe", "in/deep/hat"):
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            self.baked(name, meshes.sheet(8), "--size", "17x17")
        (self.folder / "in" / "broken.dgm").write_bytes(b"no map at all")
        result = self.run_program(support.EXPORT, "in", "none.dgm", "-o", "out", "--format", "glb,obj", "--quantize")
        self.assertEqual(result.returncode, 2, result.stderr)  # a missing file is worse than a damaged one
        self.assertEqual(result.stdout.splitlines(), ["out/deep/hat.glb", "out/deep/hat.obj", "out/robe.glb",
                                                      "out/robe.obj", "4 maps: 2 exported, 2 failed"])
        tail = result.stderr.splitlines()[-3:]
        self.assertEqual(tail[0], "dgm-export: 2 of 4 maps failed:")
        self.assertTrue(tail[1].startswith("  in/broken.dgm: DGM1001: "), tail)
        self.assertTrue(tail[2].startswith("  none.dgm: DGM5001: "), tail)
        self.assertEqual(self.names(self.folder / "out"), sorted(
            ["deep", "deep/hat.glb", "deep/hat.mtl", "deep/hat.obj", "deep/hat_normal.png", "robe.glb", "robe.mtl",
             "robe.obj", "robe_normal.png"]))
        self.assertIn("KHR_mesh_quantization", Glb((self.folder / "out/robe.glb").read_bytes()).json["extensionsRequired"])
        before = self.names()
        for arguments, word in (((["in", "-o", "x.glb"]), "folder"), (["in"], "--format"),
                                (["in", "-o", "out/"], "--format"), (["in", "--format", "glbs"], "did you mean glb?"),
                                (["in/robe.dgm", "-o", "in/", "--format", "dgm"], "overwrite an input"),
                                (["in/robe.dgm", "-o", "x.glb", "--lod", "4,"], "--lod"),
                                (["in/robe.dgm", "-o", "x.glb", "--lod-mode", "msft"], "--lod 1,4,16")):
            refused = self.run_program(support.EXPORT, *arguments)
            self.assertEqual(refused.returncode, 1, arguments)
            self.assertIn(word, refused.stderr)
        self.assertEqual(self.names(), before)

    def test_levels_in_one_file(self):
        ball = self.baked("ball", meshes.icosphere(3), "--size", "65x65")
        glb = self.glb(ball, "--lod", "8", "--lod-mode", "msft")  # beside the full surface
        node = glb.chart_nodes()[0]
        (lod,) = node["extensions"]["MSFT_lod"]["ids"]
        coarse = glb.json["nodes"][lod]
        self.assertEqual(coarse["name"], "ball_lod8")
        full, thin = (glb.json["meshes"][n["mesh"]]["primitives"][0] for n in (node, coarse))
        points = glb.accessor(full["attributes"]["POSITION"])
        faces = glb.accessor(thin["indices"]).reshape(-1, 3)
        self.assertEqual(open_edges(points, faces), 0)
        alone = next(self.glb(ball, "--lod", "8").primitives())
        self.assertTrue(np.array_equal(points[faces], alone[3]["POSITION"][alone[2]]))

    def test_quantized_is_the_same_shape(self):
        two = self.baked("two", meshes.together(meshes.icosphere(3), meshes.sheet(8)), "--size", "33x29")
        plain, small = self.glb(two), self.glb(two, "--quantize")
        self.assertLess(len(small.data), 0.9 * len(plain.data))
        for one, other in zip(plain.chart_nodes(), small.chart_nodes()):
            (a,), (b,) = (g.json["meshes"][n["mesh"]]["primitives"] for g, n in ((plain, one), (small, other)))
            wanted = plain.accessor(a["attributes"]["POSITION"]) + np.asarray(one.get("translation", [0, 0, 0]))
            accessor = small.json["accessors"][b["attributes"]["POSITION"]]
            codes = np.frombuffer(small.view(accessor["bufferView"]), "<u2").reshape(-1, 4)[:, :3]
            self.assertEqual(accessor["min"], codes.min(0).tolist())
            self.assertEqual(accessor["max"], codes.max(0).tolist())
            scale = other.get("scale", [1, 1, 1])
            self.assertEqual(len(set(scale)), 1)
            found = np.asarray(other.get("translation", [0, 0, 0])) + scale[0] * codes / 65535
            size = np.ptp(wanted, axis=0).max()
            self.assertLess(abs(found - wanted).max(), 1.01 * size / 131070 + 1e-6 * size)

    def test_far_away_surfaces_keep_their_digits(self):
        vertices, faces = meshes.icosphere(2)
        far = self.baked("far", ([(x + 1e7, y - 2e7, z) for x, y, z in vertices], faces), "--size", "33x33")
        glb = self.check_is_the_obj(far)
        ((_, translation, _, attributes),) = glb.primitives()
        self.assertLess(abs(np.asarray(translation) - [1e7, -2e7, 0]).max(), 1)
        self.assertLess(abs(attributes["POSITION"]).max(), 1.5)

    def test_seam_copies_have_equal_bits_and_levels_stay_closed(self):
        ball = self.baked("ball", meshes.icosphere(3), "--size", "65x65", "--precision", "u16")
        with h5py.File(ball, "r") as file:
            seams = file["charts/0/seams"][...]
        self.assertGreater(len(seams), 60)
        ((_, _, _, full),) = self.glb(ball).primitives()
        for name in ("POSITION", "NORMAL"):
            bits = np.ascontiguousarray(full[name]).view("<u4")
            self.assertTrue((bits[seams[:, 0]] == bits[seams[:, 1]]).all(), name)
        for lod in (1, 3, 8, 64):
            ((_, _, indices, attributes),) = self.glb(ball, "--lod", lod).primitives()
            self.assertEqual(open_edges(attributes["POSITION"], indices), 0, lod)

    def test_normal_map_gives_the_sources_normals(self):
        # A coarse grid of a finely bumped sheet: what the vertices' normals miss the map must bring back.
        def height(x, y):
            return 0.02 * np.sin(25 * x) * np.sin(25 * y)
        n = 100
        vertices = [(i / n, j / n, height(i / n, j / n)) for i in range(n + 1) for j in range(n + 1)]
        faces = []
        for i in range(n):
            for j in range(n):
                a = i * (n + 1) + j
                faces += [(a, a + n + 1, a + n + 2), (a, a + n + 2, a + 1)]
        # Samples stay in rows: a fit lays their cells along the waves, and what is asked here is the file's tangent space.
        sheet = self.baked("bumpy", (vertices, faces), "--size", "17x17", "--bump-size", "97x97", "--fit", "sample")
        ((material, _, indices, attributes),) = self.glb(sheet).primitives()
        glb = self.glb(sheet)
        picture = glb.picture(material["normalTexture"]["index"])[..., :3]
        self.assertEqual(picture.shape, (97, 97, 3))
        uvs = attributes[f"TEXCOORD_{material['normalTexture'].get('texCoord', 0)}"]
        plain, mapped = [], []
        for face in indices:
            for weights in ((0.6, 0.2, 0.2), (1 / 3, 1 / 3, 1 / 3), (0.1, 0.45, 0.45)):
                def at(values):
                    return sum(w * values[v].astype(float) for w, v in zip(weights, face))
                p = at(attributes["POSITION"])
                wanted = np.array([-0.5 * np.cos(25 * p[0]) * np.sin(25 * p[1]),
                                   -0.5 * np.sin(25 * p[0]) * np.cos(25 * p[1]), 1])
                wanted /= np.linalg.norm(wanted)
                normal, tangent = at(attributes["NORMAL"]), at(attributes["TANGENT"])[:3]
                normal, tangent = normal / np.linalg.norm(normal), tangent / np.linalg.norm(tangent)
                x, y = at(uvs) * 97 - 0.5  # texel centres, bilinear
                i, j = min(max(int(y), 0), 95), min(max(int(x), 0), 95)
                s, t = y - i, x - j
                texel = ((1 - s) * ((1 - t) * picture[i, j] + t * picture[i, j + 1])
                         + s * ((1 - t) * picture[i + 1, j] + t * picture[i + 1, j + 1])) / 127.5 - 1
                shaded = texel[0] * tangent + texel[1] * np.cross(normal, tangent) + texel[2] * normal
                plain.append(np.degrees(np.arccos(np.clip(normal @ wanted, -1, 1))))
                mapped.append(np.degrees(np.arccos(np.clip(shaded @ wanted / np.linalg.norm(shaded), -1, 1))))
        plain, mapped = (np.sqrt(np.mean(np.square(a))) for a in (plain, mapped))
        self.assertGreater(plain, 5)
        self.assertLess(mapped, 0.5 * plain, (plain, mapped))

    def test_texture_is_the_layer(self):
        (self.folder / "cloth.png").write_bytes(pictures.png(noise()))
        ball = self.baked("ball", meshes.icosphere(2), "--size", "33x33", "--layers", "geometry,normal,texture",
                          "--texture", "cloth.png", "--texture-size", "70x48")
        glb = self.glb(ball)
        ((material, *_, attributes),) = glb.primitives()
        self.assertNotIn("normalTexture", material)
        self.assertNotIn("TANGENT", attributes)
        with h5py.File(ball, "r") as file:
            layer = file["charts/0/texture"][...]
        self.assertGreater(layer[..., :3].std(), 10)
        picture = glb.picture(material["pbrMetallicRoughness"]["baseColorTexture"]["index"])
        self.assertTrue(np.array_equal(picture, layer))
        # Corner samples lie on the middles of corner texels, row 0 at the top.
        rows, cols = layer.shape[:2]
        uvs = attributes["TEXCOORD_0"]
        self.assertLess(abs(uvs[0] - [0.5 / cols, 0.5 / rows]).max(), 1e-7)
        self.assertLess(abs(uvs[32] - [1 - 0.5 / cols, 0.5 / rows]).max(), 1e-7)
        self.assertLess(abs(uvs[32 * 33] - [0.5 / cols, 1 - 0.5 / rows]).max(), 1e-7)

    def test_z_up_is_turned(self):
        sheet = self.baked("sheet", meshes.sheet(8), "--size", "17x17")
        self.assertNotIn("matrix", self.glb(sheet).json["nodes"][0])
        turn = np.array(self.glb(sheet, "--up", "z").json["nodes"][0]["matrix"]).reshape(4, 4).T
        self.assertEqual((turn @ [0, 0, 1, 1]).tolist(), [0, 1, 0, 1])   # z becomes up
        self.assertEqual((turn @ [1, 0, 0, 1]).tolist(), [1, 0, 0, 1])
        self.assertEqual(np.linalg.det(turn), 1)

    def test_same_bytes_again_and_nothing_half_made(self):
        sheet = self.baked("sheet", meshes.sheet(8), "--size", "17x17")
        first = self.exported(sheet, "a.glb").read_bytes()
        (self.folder / "elsewhere").mkdir()
        self.assertEqual(self.exported(sheet, "elsewhere/b.glb").read_bytes(), first)
        exr = self.exported(sheet, "sheet.exr")
        self.assertEqual(self.exported(exr, "c.glb").read_bytes(), first)
        (self.folder / "file").touch()
        before = self.names()
        result = self.run_program(support.EXPORT, sheet, "-o", "file/d.glb")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertEqual(self.names(), before)


if __name__ == "__main__":
    unittest.main()
