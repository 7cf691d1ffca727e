# SPDX-License-Identifier: GPL-3.0-or-later
"""Our EXR files and plain maps in OpenImageIO; scripts/clients asks Blender and three.js, too."""
import json
import re
import shutil
import unittest

import numpy as np

import meshes
import support

OIIOTOOL = shutil.which("oiiotool")
PIXEL = re.compile(r"Pixel \((\d+), (\d+)\): (.*)")


@unittest.skipUnless(OIIOTOOL and support.EXPORT, "needs openimageio-tools and dgm-export")
class Clients(support.Folder):
    def baked(self, shape, *arguments):
        meshes.write_obj(self.folder / "a.obj", shape)
        self.bake_well("a.obj", "-o", "a.dgm", *arguments)
        return self.folder / "a.dgm"

    def export(self, *arguments):
        result = self.run_program(support.EXPORT, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def tool(self, *arguments):
        result = self.run_program(OIIOTOOL, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def pixels(self, path):
        """[height, width, channels] as OpenImageIO reads it."""
        rows = [(int(x), int(y), [float(v) for v in values.replace(")", " ").replace("(", " ").split()[:4]])
                for x, y, values in PIXEL.findall(self.tool("--dumpdata", path))]
        width, height = max(x for x, _, _ in rows) + 1, max(y for _, y, _ in rows) + 1
        out = np.zeros((height, width, len(rows[0][2])))
        for x, y, values in rows:
            out[y, x] = values
        return out

    def vertices(self, path):
        return np.array([[float(word) for word in line.split()[1:4]] for line in path.read_text().splitlines()
                         if line.startswith("v ")])

    def test_saved_again_it_is_the_same_map(self):
        dgm = self.baked(meshes.together(meshes.icosphere(2), meshes.sheet(8)), "--size", "33x29")
        for layout in ("auto", "multipart"):
            with self.subTest(layout=layout):
                folder = self.folder / layout
                again = self.folder / f"{layout}-again"
                folder.mkdir()
                again.mkdir()
                self.export(dgm, "-o", folder / "a.exr", "--exr-layout", layout)
                for path in sorted(folder.iterdir()):
                    self.tool(path, "--compression", "piz", "-o", again / path.name)
                self.assertNotEqual((folder / "a.exr").read_bytes(), (again / "a.exr").read_bytes())
                self.export(again / "a.exr", "-o", again / "back.dgm")
                self.assertEqual(dgm.read_bytes(), (again / "back.dgm").read_bytes())

    def test_what_was_lost_is_named(self):
        dgm = self.baked(meshes.icosphere(2), "--size", "17")
        self.export(dgm, "-o", "a.exr")
        for change, said in ((["--eraseattrib", "dgmReport"], "dgmReport"),
                             (["--eraseattrib", "dgmChart0.table.collision"], "dgmChart0.table.collision"),
                             (["-d", "half"], "half"), (["--ch", "R,G,B"], "channel normal-code.U"),
                             (["--crop", "9x9+0+0"], "9 x 9")):
            with self.subTest(change=change):
                self.tool("a.exr", *change, "-o", "changed.exr")
                result = self.run_program(support.EXPORT, "changed.exr", "-o", "b.dgm")
                self.assertEqual(result.returncode, 3, result.stderr)
                self.assertIn(said, result.stderr)
                self.assertFalse((self.folder / "b.dgm").exists())

    def test_a_file_of_layers_is_named_when_missing(self):
        dgm = self.baked(meshes.icosphere(2), "--size", "17")
        self.export(dgm, "-o", "a.exr")
        beside = [name for name in self.names() if re.fullmatch(r"a\..+\.exr", name)]
        self.assertTrue(beside)
        for name in beside:
            result = self.run_program(support.EXPORT, name, "-o", "b.dgm")
            self.assertEqual(result.returncode, 3, result.stderr)
            self.assertIn("another file describes", result.stderr)
        (self.folder / beside[0]).unlink()
        result = self.run_program(support.EXPORT, "a.exr", "-o", "b.dgm")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn(beside[0], result.stderr)

    def test_a_bake_replaces_all_files_of_an_exr(self):
        meshes.write_obj(self.folder / "a.obj", meshes.icosphere(2))
        bake = ["a.obj", "-o", "out", "--format", "exr", "--size", "17"]
        self.bake_well(*bake, "--report", "report.json")
        self.assertIn("out/a.bump.exr", self.names())
        files = json.loads((self.folder / "report.json").read_text())["assets"][0]["files"]
        self.assertEqual([file["bytes"] for file in files],
                         [sum(path.stat().st_size for path in (self.folder / "out").iterdir())])
        self.bake_well(*bake, "--layers", "geometry,normal")
        self.assertEqual(self.names(self.folder / "out"), ["a.exr"])
        self.bake_well(*bake)
        self.export("out/a.exr", "-o", "back.dgm")
        self.bake_well("a.obj", "-o", "plain.dgm", "--size", "17", "--layers", "geometry,normal")
        self.export("plain.dgm", "-o", "out/a.exr")
        self.assertEqual(self.names(self.folder / "out"), ["a.exr"])

    def test_another_file_with_the_name_is_kept(self):
        meshes.write_obj(self.folder / "a.obj", meshes.icosphere(2))
        (self.folder / "a.bump.exr").write_text("mine")
        result = self.bake("a.obj", "-o", "a.exr", "--size", "17")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("a.bump.exr", result.stderr)
        self.assertEqual(self.names(), ["a.bump.exr", "a.obj"])
        self.assertEqual((self.folder / "a.bump.exr").read_text(), "mine")

    def test_a_position_map_displaces_a_grid_to_the_vertices_of_the_mesh(self):
        dgm = self.baked(meshes.icosphere(2), "--size", "17")
        self.export(dgm, "-o", "a.obj.obj")
        self.export(dgm, "--maps", "maps")
        position = self.pixels("maps/a_position.exr")
        self.assertEqual(position.shape, (17, 17, 4))
        vertices = self.vertices(self.folder / "a.obj.obj")
        self.assertEqual(len(vertices), 17 * 17)
        np.testing.assert_allclose(position[:, :, :3].reshape(-1, 3), vertices, rtol=0, atol=1e-6)
        self.assertTrue((position[:, :, 3] == 1).all())
        chart = json.loads((self.folder / "maps" / "a_maps.json").read_text())["charts"][0]
        row = chart["maps"][0]
        self.assertEqual((row["name"], row["file"], row["width"], row["height"]), ("position", "a_position.exr", 17, 17))
        np.testing.assert_allclose(row["min"][:3], position.min(axis=(0, 1))[:3], rtol=0, atol=1e-7)
        np.testing.assert_allclose(row["max"][:3], position.max(axis=(0, 1))[:3], rtol=0, atol=1e-7)

    def test_maps_have_one_size_and_a_tight_window(self):
        dgm = self.baked(meshes.icosphere(2), "--size", "17x33")
        for folder, options, size in (("maps", [], (33, 17)), ("two", ["--power-of-two"], (64, 32))):
            self.export(dgm, "--maps", folder, *options)
            chart = json.loads((self.folder / folder / "a_maps.json").read_text())["charts"][0]
            self.assertEqual((chart["width"], chart["height"]), size)
            names = {row["name"] for row in chart["maps"]}
            self.assertLessEqual({"position", "normal", "bump", "stiffness", "contact_area", "cover"}, names)
            self.assertEqual({"a_maps.json"} | {row["file"] for row in chart["maps"]},
                             set(self.names(self.folder / folder)))
            for row in chart["maps"]:
                info = self.tool("--info", "-v", f"{folder}/{row['file']}")
                self.assertRegex(info, rf"{row['width']} x +{row['height']}, ")
                self.assertNotIn("full/display size", info)
                if not row["name"].endswith("_full"):
                    self.assertEqual((row["width"], row["height"]), size, row)

    def test_resampling_keeps_corners_and_seams(self):
        dgm = self.baked(meshes.icosphere(2), "--size", "17")
        self.export(dgm, "--maps", "one")
        self.export(dgm, "--maps", "two", "--power-of-two")
        one, two = self.pixels("one/a_position.exr"), self.pixels("two/a_position.exr")
        self.assertEqual(two.shape, (32, 32, 4))
        for y in (0, -1):
            for x in (0, -1):
                np.testing.assert_array_equal(one[y, x], two[y, x])
        # Linear interpolation along the first row, by NumPy's own.
        at = np.arange(32) * 16 / 31
        for c in range(3):
            np.testing.assert_allclose(two[0, :, c], np.interp(at, np.arange(17), one[0, :, c]), rtol=0, atol=1e-6)
        normals = self.pixels("two/a_normal.exr")
        np.testing.assert_allclose(np.linalg.norm(normals, axis=2), 1, rtol=0, atol=1e-6)

    def test_maps_of_a_free_chart_say_where_the_surface_is(self):
        dgm = self.baked(meshes.sheet(8), "--size", "17", "--domain", "free")
        self.export(dgm, "--maps", "maps")
        position = self.pixels("maps/a_position.exr")
        self.assertEqual(set(np.unique(position[:, :, 3])), {0.0, 1.0})
        mask = self.pixels("maps/a_mask.png")
        np.testing.assert_allclose(mask[:, :, 0] > 0.5, position[:, :, 3] == 1)
        self.assertTrue((position[:, :, :3][position[:, :, 3] == 0] == 0).all())

    def test_refusals(self):
        dgm = self.baked(meshes.icosphere(1), "--size", "9")
        for arguments, said in (([dgm], "--maps"), ([dgm, "-o", "x.obj", "--maps", "m"], "--maps"),
                                ([dgm, "--maps", "m", "--chart", "7"], "chart 7")):
            result = self.run_program(support.EXPORT, *arguments)
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertIn(said, result.stderr)
        self.assertNotIn("m", self.names())


if __name__ == "__main__":
    unittest.main()
