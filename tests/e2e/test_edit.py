# SPDX-License-Identifier: GPL-3.0-or-later
"""dgm-edit: paint in an EXR, in plain maps or by h5py comes back into the map, and nothing else does."""
import json
import re
import shutil
import unittest

import h5py
import numpy as np

import meshes
import support
from test_up_to_date import write_textured, png

OIIOTOOL = shutil.which("oiiotool")
SIZE = ["--size", "33x33", "--method", "tutte", "--fit", "sample"]
SIDE = 33
BOX = (slice(4, 9), slice(3, 8))  # rows, columns
BOX_TEXT = "5x5+3+4"


class Edit(support.Folder):
    """A sphere with a seam all around its border, baked once for each test."""

    def setUp(self):
        super().setUp()
        meshes.write_obj(self.folder / "a.obj", meshes.icosphere(2))
        self.bake_well("a.obj", "-o", "a.dgm", *SIZE)

    def edit(self, *arguments, code=0):
        result = self.run_program(support.EDIT, *arguments)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result

    def run_well(self, program, *arguments):
        result = self.run_program(program, *arguments)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return result.stdout

    def layer(self, name, file="a.dgm"):
        with h5py.File(self.folder / file) as f:
            return f["charts/0"][name][...]

    def report(self, file="a.dgm"):
        with h5py.File(self.folder / file) as f:
            return json.loads(f["report"][()])

    def layers(self, file="a.dgm"):
        with h5py.File(self.folder / file) as f:
            return {name: item[...] for name, item in f["charts/0"].items()}

    def assert_seams_agree(self, values, file="a.dgm"):
        seams = self.layer("seams", file)
        self.assertGreater(len(seams), 0)
        flat = values.reshape(SIDE * SIDE, -1)
        np.testing.assert_array_equal(flat[seams[:, 0]], flat[seams[:, 1]])

    def assert_only(self, before, changed, file="a.dgm"):
        """All layers but those have the bits they had."""
        after = self.layers(file)
        self.assertEqual(before.keys(), after.keys())
        for name in before:
            same = before[name].tobytes() == after[name].tobytes()
            self.assertEqual(same, name not in changed, name)

    def paint_h5(self, name, layer, index, value):
        with h5py.File(self.folder / name, "r+") as f:
            data = f["charts/0"][layer]
            data[index] = value


class ByH5py(Edit):
    def test_a_painted_copy_comes_back(self):
        before = self.layers()
        shutil.copy(self.folder / "a.dgm", self.folder / "painted.dgm")
        self.paint_h5("painted.dgm", "deformation", (*BOX, 3), 0.25)
        self.assertEqual(self.run_program(support.VALIDATE, "painted.dgm").returncode, 3)
        said = self.edit("a.dgm", "--from", "painted.dgm").stdout
        self.assertRegex(said, r"(?m)^  stiffness    25 of 1089 samples changed, by at most 0\.75$")
        self.assertTrue(said.endswith("a.dgm\n"))
        self.run_well(support.VALIDATE, "a.dgm", "--source", "a.obj")
        self.assert_only(before, {"deformation"})
        expected = before["deformation"].copy()
        expected[(*BOX, 3)] = 0.25
        np.testing.assert_array_equal(self.layer("deformation"), expected)
        (edit,) = self.report()["edits"]
        self.assertEqual((edit["layer"], edit["samples"], edit["source"]), ("stiffness", 25, "painted.dgm"))
        info = self.run_well(support.INFO, "a.dgm")
        self.assertIn(f"  edited    stiffness: 25 samples, from painted.dgm  {edit['source_hash']}\n", info)

    def test_repair_of_the_map_itself(self):
        before = self.layers()
        self.paint_h5("a.dgm", "contact", (*BOX, 1), 0.0)
        self.paint_h5("a.dgm", "bump", (10, 10), 0.5)
        result = self.edit("a.dgm", "--from", "a.dgm", code=3)
        self.assertIn("DGM1003", result.stderr)
        self.assertIn("dgm-edit --repair", result.stderr)
        self.edit("a.dgm", "--repair")
        self.run_well(support.VALIDATE, "a.dgm", "--source", "a.obj")
        self.assert_only(before, {"contact", "bump"})
        self.assertTrue((self.layer("contact")[(*BOX, 1)] == 0).all())
        self.assertEqual({e["layer"] for e in self.report()["edits"]}, {"mobility", "bump"})
        self.assertIn("nothing to change", self.edit("a.dgm", "--repair").stdout)

    def test_what_may_not_change_is_named(self):
        before = (self.folder / "a.dgm").read_bytes()
        index = {"geometry": (3, 4), "normal": (3, 4), "cover": (3, 4), "collision": (0, 1), "diagonals": (3, 4),
                 "seams": (1, 0), "deformation": (3, 4, 1), "contact": (3, 4, 0)}
        for layer, where in index.items():
            with self.subTest(layer):
                shutil.copy(self.folder / "a.dgm", self.folder / "painted.dgm")
                with h5py.File(self.folder / "painted.dgm", "r+") as f:
                    data = f["charts/0"][layer]
                    data[where] = data[where] + 1
                name = {"deformation": "metric", "contact": "contact_area"}.get(layer, layer)
                result = self.edit("a.dgm", "--from", "painted.dgm", code=3)
                self.assertRegex(result.stderr, rf"DGM1017: {name} may not be edited, since .*: 1 of \d+ samples differ, "
                                                r"by at most .*, first /charts/0/")
                self.assertIn("next: ", result.stderr)
                if layer not in ("deformation", "contact"):
                    result = self.edit("painted.dgm", "--repair", code=3)
                    self.assertIn(f"DGM1017: {name} may not be edited", result.stderr)
        self.assertEqual((self.folder / "a.dgm").read_bytes(), before)
        self.assertEqual(self.edit("painted.dgm", "--repair", code=3).stderr.count("DGM2009"), 1)  # areas do not add up

    def test_paint_goes_over_to_another_bake(self):
        shutil.copy(self.folder / "a.dgm", self.folder / "painted.dgm")
        self.paint_h5("painted.dgm", "deformation", (*BOX, 3), 0.25)
        self.edit("painted.dgm", "--repair")
        self.bake_well("a.obj", "-o", "b.dgm", *SIZE[:-1], "l2")
        self.assertIn("may not be edited", self.edit("b.dgm", "--from", "painted.dgm", code=3).stderr)
        self.edit("b.dgm", "--from", "painted.dgm", "--layer", "stiffness")
        self.run_well(support.VALIDATE, "b.dgm", "--source", "a.obj")
        np.testing.assert_array_equal(self.layer("deformation", "b.dgm")[:, :, 3], self.layer("deformation", "painted.dgm")[:, :, 3])

    def test_no_number_and_heights_beyond_the_layer(self):
        shutil.copy(self.folder / "a.dgm", self.folder / "painted.dgm")
        self.paint_h5("painted.dgm", "deformation", (4, 5, 3), np.nan)
        result = self.edit("a.dgm", "--from", "painted.dgm", code=3)
        self.assertIn("DGM2003: stiffness", result.stderr)
        self.assertIn("at: /charts/0/deformation[4][5]", result.stderr)

    def test_the_runtime_feels_it(self):
        contact, near = (16, 16), (18, 16)

        def moved():
            arguments = ["a.dgm", self.folder, *contact, 6, 9, 0, 0, 0.05, 1]
            self.run_well(support.DEFORM_SAMPLE, *arguments)
            rest, now = (np.fromfile(self.folder / name, "<f4").reshape(-1, 3) for name in ("rest.bin", "now.bin"))
            return np.linalg.norm((now - rest)[near[0] * SIDE + near[1]].astype(float))
        plain = moved()
        self.assertGreater(plain, 0)
        shutil.copy(self.folder / "a.dgm", self.folder / "painted.dgm")
        self.paint_h5("painted.dgm", "contact", (*near, 1), 0.5)
        self.edit("a.dgm", "--from", "painted.dgm")
        self.assertAlmostEqual(moved() / plain, 0.5, delta=1e-5)
        self.paint_h5("painted.dgm", "deformation", (*near, 3), 0.5)
        self.edit("a.dgm", "--from", "painted.dgm")
        self.assertAlmostEqual(2 * moved() / plain, np.exp(-4 / 9), delta=1e-4)  # eq. 7 with half the sigma


@unittest.skipUnless(OIIOTOOL, "needs openimageio-tools")
class ByPictures(Edit):
    def tool(self, *arguments):
        return self.run_well(OIIOTOOL, *arguments)

    def export(self, *arguments):
        self.run_well(support.EXPORT, "a.dgm", *arguments)

    def paint_channel(self, source, channel, value, target, box=BOX_TEXT, *options):
        """The box of one channel of an EXR, by OpenImageIO: all else as it was read."""
        names = re.search(r"channel list: (.*)", self.tool("--info", "-v", source)).group(1)
        names = [name.split(" (")[0] for name in names.split(", ")]
        self.assertIn(channel, names)
        painted = ",".join(f"{name}={value}" if name == channel else name for name in names)
        place = "+" + box.split("+", 1)[1]
        self.tool(source, "--ch", painted, "--cut", box, source, "--paste", place, *options, "-o", target)

    def test_an_exr_without_paint_changes_nothing(self):
        before = (self.folder / "a.dgm").read_bytes()
        for layout in ("auto", "multipart"):
            self.export("-o", f"{layout}.exr", "--exr-layout", layout)
            self.tool(f"{layout}.exr", "--compression", "piz", "-o", f"again-{layout}.exr")
            for name in (layout, f"again-{layout}"):
                said = self.edit("a.dgm", "--from", f"{name}.exr", "-o", "new.dgm").stdout
                self.assertIn("stiffness    unchanged\n", said)
                self.assertEqual((self.folder / "new.dgm").read_bytes(), before)
        # Saved as half, even positions are what halves hold of them.
        self.tool("auto.exr", "-d", "half", "-o", "half.exr")
        self.edit("a.dgm", "--from", "half.exr", "-o", "new.dgm")
        self.assertEqual((self.folder / "new.dgm").read_bytes(), before)

    def test_an_exr_with_paint(self):
        before = self.layers()
        self.export("-o", "a.exr")
        self.paint_channel("a.exr", "deformation-stiffness.V", 0.25, "painted.exr")
        said = self.edit("a.dgm", "--from", "painted.exr", "--dry-run").stdout
        self.assertIn("stiffness    25 of 1089 samples changed, by at most 0.75\n", said)
        self.assertTrue(said.endswith("a.dgm: would be written\n"))
        self.assert_only(before, set())
        self.edit("a.dgm", "--from", "painted.exr", "-o", "new.dgm")
        self.assert_only(before, {"deformation"}, "new.dgm")
        np.testing.assert_array_equal(self.layer("deformation", "new.dgm")[(*BOX, 3)], np.full((5, 5), 0.25, "f4"))
        self.run_well(support.VALIDATE, "new.dgm", "--source", "a.obj")
        self.assertEqual(self.edit("a.dgm", "--from", "painted.exr", "-o", "two.dgm").returncode, 0)
        self.assertEqual((self.folder / "two.dgm").read_bytes(), (self.folder / "new.dgm").read_bytes())
        # Saved as half: only what was painted is taken.
        self.tool("painted.exr", "-d", "half", "-o", "half.exr")
        self.edit("a.dgm", "--from", "half.exr", "-o", "half.dgm")
        self.assertEqual(self.layer("deformation", "half.dgm").tobytes(), self.layer("deformation", "new.dgm").tobytes())
        # Without the other channels and all of the description.
        self.tool("painted.exr", "--ch", "deformation-stiffness.V", "--eraseattrib", "dgm.*", "-o", "alone.exr")
        self.edit("a.dgm", "--from", "alone.exr", "-o", "alone.dgm")
        self.assertEqual(self.layer("deformation", "alone.dgm").tobytes(), self.layer("deformation", "new.dgm").tobytes())

    def test_paint_on_a_seam_reaches_the_other_side(self):
        self.export("-o", "a.exr")
        self.paint_channel("a.exr", "contact-mobility.V", 0.5, "painted.exr", "1x9+0+12")
        said = self.edit("a.dgm", "--from", "painted.exr").stdout
        self.assertRegex(said, r"mobility     9 of 1089 samples changed, by at most 0\.5; \d+ seam samples? joined\n")
        mobility = self.layer("contact")[:, :, 1]
        self.assertTrue((mobility[12:21, 0] == 0.5).all())
        self.assertGreaterEqual((mobility == 0.5).sum(), 17)
        self.assert_seams_agree(mobility)
        self.run_well(support.VALIDATE, "a.dgm", "--source", "a.obj")

    def test_positions_in_an_exr_are_refused(self):
        self.export("-o", "a.exr")
        self.paint_channel("a.exr", "R", 9, "painted.exr")
        result = self.edit("a.dgm", "--from", "painted.exr", code=3)
        self.assertIn("DGM1017: geometry may not be edited", result.stderr)
        self.assertIn("25 of 1089 samples differ", result.stderr)
        self.tool("--create", "33x33", "1", "--chnames", "weather.V", "-o", "other.exr")
        self.assertIn("DGM1018: none of its channels is one of the map's; it has weather.V",
                      self.edit("a.dgm", "--from", "other.exr", code=3).stderr)
        self.tool("a.exr", "--resize", "16x16", "-o", "small.exr")
        self.assertIn("DGM1018", self.edit("a.dgm", "--from", "small.exr", code=3).stderr)

    def test_plain_maps(self):
        before = self.layers()
        data = (self.folder / "a.dgm").read_bytes()
        self.export("--maps", "maps")
        for source in ("maps", "maps/a_maps.json", "maps/a_mobility.exr"):
            self.edit("a.dgm", "--from", source, "-o", "new.dgm")
            self.assertEqual((self.folder / "new.dgm").read_bytes(), data)
        self.tool("maps/a_stiffness.exr", "--fill:color=0.2,0.2,0.2", BOX_TEXT, "-d", "uint8", "-o", "maps/a_stiffness.png")
        both = self.edit("a.dgm", "--from", "maps", code=1)
        self.assertIn("a_stiffness.exr and a_stiffness.png are both there", both.stderr)
        (self.folder / "maps/a_stiffness.exr").unlink()
        self.edit("a.dgm", "--from", "maps", "-o", "new.dgm")
        self.assert_only(before, {"deformation"}, "new.dgm")
        np.testing.assert_array_equal(self.layer("deformation", "new.dgm")[(*BOX, 3)], np.full((5, 5), 51 / 255, "f4"))
        self.assertEqual(self.report("new.dgm")["edits"][0]["source"], "a_stiffness.png")
        self.run_well(support.VALIDATE, "new.dgm", "--source", "a.obj")

    def test_heights_and_their_range(self):
        self.export("--maps", "maps")
        name = "bump_full" if (self.folder / "maps/a_bump_full.exr").exists() else "bump"
        before = self.layer("bump").astype(float)
        self.assertGreater(np.ptp(before), 0)
        high = float(before.max())
        text = f"{high},{high},{high}"
        self.tool(f"maps/a_{name}.exr", f"--fill:color={text}", "9x9+20+20", "-o", f"maps/a_{name}.exr")
        self.edit("a.dgm", "--from", f"maps/a_{name}.exr")
        after = self.layer("bump").astype(float)
        np.testing.assert_array_equal(after[20:29, 20:29], high)
        before[20:29, 20:29] = high
        np.testing.assert_array_equal(after, before)
        self.assertIsNone(self.report()["error"]["normal_rms_bump_degrees"])
        self.run_well(support.VALIDATE, "a.dgm", "--source", "a.obj")

    def test_a_texture_of_a_free_chart(self):
        write_textured(self.folder / "sheet.obj", "sheet.mtl", "skin.png")
        (self.folder / "skin.png").write_bytes(png([[(200, 10, 10)]]))
        self.bake_well("sheet.obj", "-o", "a.dgm", "--size", "17", "--domain", "free")
        self.export("--maps", "maps")
        self.edit("a.dgm", "--from", "maps", "-o", "new.dgm")
        self.assertEqual((self.folder / "a.dgm").read_bytes(), (self.folder / "new.dgm").read_bytes())
        before = self.layers()
        picture = "maps/a_texture_full.png"
        self.tool(picture, "--fill:color=0,1,0,1", "4x4+12+12", "-o", picture)
        self.edit("a.dgm", "--from", picture)
        self.assert_only(before, {"texture"})
        texture = self.layer("texture")
        self.assertTrue((texture[12:16, 12:16] == (0, 255, 0, 255)).all())
        self.assertEqual((texture != before["texture"]).any(axis=2).sum(), 16)
        self.run_well(support.VALIDATE, "a.dgm")
        # The small one shows the same texels, but cannot be put back.
        self.tool("maps/a_texture.png", "--fill:color=0,0,1,1", "4x4+6+6", "-o", "maps/a_texture.png")
        self.assertIn("_full", self.edit("a.dgm", "--from", "maps/a_texture.png", code=3).stderr)


class Bakes(Edit):
    def paint(self, file="a.dgm"):
        self.paint_h5(file, "deformation", (*BOX, 3), 0.25)
        self.edit(file, "--repair")

    def test_an_edited_map_is_kept(self):
        self.paint()
        painted = (self.folder / "a.dgm").read_bytes()
        said = self.bake_well("a.obj", "-o", "a.dgm", *SIZE).stdout
        self.assertIn("up to date", said)
        self.assertIn(", edited: stiffness", said)
        vertices, faces = meshes.icosphere(2)
        meshes.write_obj(self.folder / "a.obj", ([(1.1 * x, y, z) for x, y, z in vertices], faces))
        result = self.bake("a.obj", "-o", "a.dgm", *SIZE, "--report", "r.json")
        self.assertEqual(result.returncode, 3, result.stdout)
        self.assertIn("DGM1019", result.stderr)
        self.assertIn("stiffness", result.stderr)
        self.assertIn("--force", result.stderr)
        (asset,) = json.loads((self.folder / "r.json").read_text())["assets"]
        self.assertEqual(asset["outcome"], "refused")
        self.assertEqual((self.folder / "a.dgm").read_bytes(), painted)
        self.bake_well("a.obj", "-o", "a.dgm", *SIZE, "--force")
        self.assertNotIn("edits", self.report())

    def test_prune_leaves_it(self):
        (self.folder / "in").mkdir()
        for name in ("x.obj", "y.obj", "z.obj"):
            meshes.write_obj(self.folder / "in" / name, meshes.icosphere(1))
        self.bake_well("in", "-o", "out", "--size", "17", "--method", "tutte", "--fit", "sample")
        with h5py.File(self.folder / "out/x.dgm", "r+") as f:
            f["charts/0/contact"][3, 3, 1] = 0
        self.edit("out/x.dgm", "--repair")
        for name in ("x.obj", "y.obj"):
            (self.folder / "in" / name).unlink()
        self.bake_well("in", "-o", "out", "--size", "17", "--method", "tutte", "--fit", "sample", "--prune")
        self.assertEqual(self.names(self.folder / "out"), ["x.dgm", "z.dgm"])

    def test_meshes_beside_it_have_to_show_it(self):
        bake = ["a.obj", "-o", "out", *SIZE, "--format", "dgm,exr,glb"]
        self.bake_well(*bake)
        self.paint("out/a.dgm")
        result = self.bake(*bake)
        self.assertEqual(result.returncode, 3, result.stdout)
        self.assertIn("DGM1019: the map was edited since its bake; it, or a mesh beside it, is not up to date: "
                      "stiffness", result.stderr)
        self.assertIn("write what is beside the map anew: dgm-export out/a.dgm -o out/a.glb", result.stderr)
        self.run_well(support.EXPORT, "out/a.dgm", "-o", "out/a.glb")
        self.assertIn("up to date, ", self.bake_well(*bake).stdout)

    def test_the_report_has_it(self):
        self.paint()
        self.bake_well("a.obj", "-o", "a.dgm", *SIZE, "--report", "r.json")
        (asset,) = json.loads((self.folder / "r.json").read_text())["assets"]
        self.assertEqual([edit["layer"] for edit in asset["report"]["edits"]], ["stiffness"])


class CommandLine(Edit):
    def test_layers_are_named_one_by_one(self):
        shutil.copy(self.folder / "a.dgm", self.folder / "painted.dgm")
        for layer, number in (("deformation", 3), ("contact", 1)):
            self.paint_h5("painted.dgm", layer, (*BOX, number), 0.25)
        self.paint_h5("painted.dgm", "bump", (10, 10), 0.5)
        before = self.layers()
        self.edit("--layer", "stiffness", "--layer", "mobility", "a.dgm", "--from", "painted.dgm")
        self.assert_only(before, {"deformation", "contact"})

    def test_refusals(self):
        for arguments, code, said in (
                (["a.dgm"], 1, "--from is required"), (["a.dgm", "--from", "x", "--repair"], 1, "--repair goes without"),
                (["a.dgm", "--from", "x.exr"], 2, "there is no such file or folder"),
                (["a.obj", "--from", "a.dgm"], 3, "bake it first"), (["a.dgm", "--from", "a.obj"], 3, "bake it first"),
                (["no.dgm", "--from", "x.exr"], 2, "there is no such file"),
                (["a.dgm", "--from", "a.dgm", "--layer", "stifness"], 1, "did you mean stiffness?"),
                (["a.dgm", "--from", "a.dgm", "--layer", "geometry"], 3, "DGM1017: --layer geometry: it is the shape"),
                (["a.dgm", "--from", "a.dgm", "-o", "x.exr"], 1, "must end in .dgm"),
                (["a.dgm", "--from", "."], 3, "DGM1018: the folder has no maps.json")):
            with self.subTest(arguments):
                self.assertIn(said, self.edit(*arguments, code=code).stderr)
        self.assertEqual(self.names(), ["a.dgm", "a.obj"])


if __name__ == "__main__":
    unittest.main()
