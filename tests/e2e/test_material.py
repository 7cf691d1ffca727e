# SPDX-License-Identifier: GPL-3.0-or-later
"""Unit and material from the command line to the runtime: the file, h5py, EXR, a scene, and the physics that they make."""
import ctypes
import json
import os
import re
import unittest

import h5py
import numpy as np

import meshes
import support

PHYSICS = os.environ.get("DGM_PHYSICS_LIBRARY", "")
SIZE = ["--size", "17x17", "--method", "tutte", "--fit", "sample"]
CLOTH = "membrane = 150\nbending = 5e-4 # N m\ndensity = 4\npoisson = 0.25\n"
KEYS = ("membrane", "poisson", "bending", "foundation", "density", "viscosity")


class Error(ctypes.Structure):
    _fields_ = [("size", ctypes.c_uint32), ("code", ctypes.c_uint32), ("offset", ctypes.c_uint64), ("message", ctypes.c_char_p)]


class StepOptions(ctypes.Structure):
    _fields_ = [("size", ctypes.c_uint32), ("cycles", ctypes.c_uint32), ("gravity", ctypes.c_float * 3),
                ("tool_radius", ctypes.c_float), ("obstacles", ctypes.c_void_p), ("obstacle_count", ctypes.c_size_t),
                ("pins", ctypes.c_void_p), ("pin_count", ctypes.c_size_t)]


class Report(ctypes.Structure):
    _fields_ = [("size", ctypes.c_uint32), ("contacts", ctypes.c_uint32), ("cycles", ctypes.c_uint32), ("clamped", ctypes.c_uint32),
                ("volume_error", ctypes.c_double), ("pressure", ctypes.c_double), ("residual", ctypes.c_double),
                ("kinetic", ctypes.c_double), ("elastic", ctypes.c_double)]


class Material(support.Folder):
    def setUp(self):
        super().setUp()
        meshes.write_obj(self.folder / "ball.obj", meshes.icosphere(2))  # radius 1

    def run_well(self, program, *arguments):
        result = self.run_program(program, *arguments)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return result.stdout

    def stored(self, file="ball.dgm"):
        """(attribute, layer) as h5py reads them; None for what is not there."""
        with h5py.File(self.folder / file) as f:
            chart = f["charts/0"]
            return (chart["geometry"].attrs.get("metres_per_unit"), chart["material"][...] if "material" in chart else None)

    def fall(self, file="ball.dgm"):
        """Kinetic energy after one step of 1 ms in which nothing but gravity works, and the code of creation."""
        library = ctypes.CDLL(PHYSICS)
        error, asset, state, physics = Error(ctypes.sizeof(Error)), ctypes.c_void_p(), ctypes.c_void_p(), ctypes.c_void_p()
        self.assertEqual(library.dgm_asset_open(os.fsencode(self.folder / file), None, None, ctypes.byref(asset), ctypes.byref(error)), 0)
        self.assertEqual(library.dgm_state_create(asset, 0, None, None, ctypes.byref(state), ctypes.byref(error)), 0)
        code = library.dgm_physics_create(state, None, None, ctypes.byref(physics), ctypes.byref(error))
        report = Report(ctypes.sizeof(Report))
        if code == 0:
            options = StepOptions(ctypes.sizeof(StepOptions), 20, (ctypes.c_float * 3)(0, 0, -10))
            self.assertEqual(library.dgm_physics_step(state, physics, ctypes.byref(options), None, 0, None, ctypes.byref(report), ctypes.byref(error)), 0)
        for handle, end in ((physics, library.dgm_physics_destroy), (state, library.dgm_state_destroy), (asset, library.dgm_asset_close)):
            end(handle)
        return report.kinetic, code, (error.message or b"").decode()

    def test_without_them_the_file_is_as_before(self):
        self.bake_well("ball.obj", *SIZE)
        self.assertEqual(self.stored(), (None, None))
        self.assertNotIn("material", self.run_well(support.INFO, "ball.dgm"))
        if PHYSICS:
            _, code, message = self.fall()
            self.assertNotEqual(code, 0)
            self.assertIn("--unit", message)

    def test_every_reader_finds_them(self):
        (self.folder / "m.toml").write_text(CLOTH)
        self.bake_well("ball.obj", *SIZE, "--unit", "cm", "--material", "m.toml", "--report", "r.json", "-MF", "d.d")
        unit, material = self.stored()
        self.assertEqual(unit.dtype, np.float64)
        np.testing.assert_array_equal(unit, [0.01])
        np.testing.assert_array_equal(material, np.float32([0.01, 150, 0.25, 5e-4, 0, 4, 0]))
        self.run_well(support.VALIDATE, "ball.dgm", "--source", "ball.obj")
        self.assertIn("a unit is 0.01 m; membrane 150 N/m, poisson 0.25, bending 0.0005 N m, foundation 0 N/m^3, density 4 kg/m^2, "
                      "viscosity 0 s", self.run_well(support.INFO, "ball.dgm"))
        chart = json.loads(self.run_well(support.INFO, "ball.dgm", "--json"))["files"][0]["charts"][0]
        self.assertAlmostEqual(chart["metres_per_unit"], 0.01, places=8)
        self.assertEqual(sorted(chart["material"]), sorted(KEYS))
        settings = json.loads((self.folder / "r.json").read_text())["assets"][0]["settings"]
        self.assertEqual(settings["metres_per_unit"], 0.01)
        self.assertEqual(settings["material"]["density"], 4)
        self.assertIn("m.toml", (self.folder / "d.d").read_text())
        # There and back through EXR: the same file.
        self.run_well(support.EXPORT, "ball.dgm", "-o", "ball.exr")
        self.run_well(support.EXPORT, "ball.exr", "-o", "back.dgm")
        self.assertEqual((self.folder / "ball.dgm").read_bytes(), (self.folder / "back.dgm").read_bytes())

    @unittest.skipUnless(PHYSICS and not support.SANITIZED, "needs the shared library, and Python has no sanitizer")
    def test_the_runtime_takes_them(self):
        """A body that falls for h has m (g h)^2 / 2, and m is the density times the area in square metres."""
        for unit, metres in (("mm", 1e-3), ("cm", 1e-2), ("m", 1.)):
            for material, density in (("tissue", 5), ("cotton", .15), ("denim", .45), ("satin", .12)):
                with self.subTest(unit=unit, material=material):
                    self.bake_well("ball.obj", *SIZE, "--unit", unit, "--material", material)
                    with h5py.File(self.folder / "ball.dgm") as f:
                        area = float(f["charts/0/contact"][..., 0].astype(np.float64).sum())
                        foundation = float(f["charts/0/material"][4])
                    kinetic, code, message = self.fall()
                    self.assertEqual(code, 0, message)
                    # The foundation of the tissue holds back: m / (m + h^2 kappa area) of the way.
                    share = 1 / (1 + 1e-6 * foundation / density)
                    expected = .5 * density * area * metres ** 2 * (10 * 1e-3 * share) ** 2
                    self.assertAlmostEqual(kinetic / expected, 1, delta=2e-3)

    def test_what_changed_is_baked_again(self):
        (self.folder / "m.toml").write_text(CLOTH)
        command = ("ball.obj", *SIZE, "--unit", "mm", "--material", "m.toml")
        self.bake_well(*command)
        self.assertIn("up to date", self.bake_well(*command).stdout)
        (self.folder / "m.toml").write_text("# a remark\n" + CLOTH)
        self.assertIn("up to date", self.bake_well(*command).stdout)
        (self.folder / "m.toml").write_text(CLOTH.replace("150", "160"))
        self.assertNotIn("up to date", self.bake_well(*command).stdout)
        self.assertEqual(self.stored()[1][1], 160)
        self.assertNotIn("up to date", self.bake_well("ball.obj", *SIZE, "--unit", "mm").stdout)
        self.assertEqual(len(self.stored()[1]), 1)

    def test_refusals_have_a_code_a_place_and_a_remedy(self):
        (self.folder / "bad.toml").write_text(CLOTH.replace("4\n", "four\n"))
        (self.folder / "stiff.toml").write_text("membrane = 1\nbending = 1e3\ndensity = 4\n")
        for arguments, code, text in (
                (["--material", "denim"], 1, "--unit"),
                (["--unit", "inch"], 1, "mm"),
                (["--unit", "mm", "--material", "silk"], 1, "cotton"),
                (["--unit", "mm", "--material", "none.toml"], 2, "none.toml"),
                (["--unit", "mm", "--material", "bad.toml"], 3, "DGM6005"),
                (["--unit", "mm", "--material", "stiff.toml"], 3, "DGM3018")):
            with self.subTest(arguments=arguments):
                result = self.bake("ball.obj", *SIZE, *arguments, "-o", "no.dgm")
                self.assertEqual(result.returncode, code, result.stdout + result.stderr)
                self.assertIn(text, result.stdout + result.stderr)
                self.assertFalse((self.folder / "no.dgm").exists())
        self.assertRegex(self.bake("ball.obj", "--unit", "mm", "--material", "bad.toml").stderr, r"bad\.toml:3:\d+")

    def test_scenes_have_them_too(self):
        (self.folder / "sub").mkdir()
        (self.folder / "sub/m.toml").write_text(CLOTH)
        (self.folder / "sub/scene.toml").write_text(
            '[defaults]\nunit = "cm"\nlargest = "17x17"\ntolerance = "50%"\nmaterial = "m.toml"\n'
            '[[asset]]\nsource = "../ball.obj"\nname = "a"\n[[asset]]\nsource = "../ball.obj"\nname = "b"\nunit = "m"\nmaterial = "satin"\n')
        self.bake_well("sub/scene.toml", "-o", "out")
        np.testing.assert_array_equal(self.stored("out/a.dgm")[1], np.float32([0.01, 150, 0.25, 5e-4, 0, 4, 0]))
        np.testing.assert_array_equal(self.stored("out/b.dgm")[1], np.float32([1, 1000, 0.2, 2e-6, 0, 0.12, 2e-3]))
        self.assertRegex(self.run_well(support.INFO, "sub/scene.toml"), re.compile(r"a unit is 0\.01 m.*membrane 150", re.S))
        good = (self.folder / "sub/scene.toml").read_text()
        for old, new in (('unit = "cm"\n', ""), ('"m.toml"', '"m.tomb"'), ('"satin"', '"sateen"')):
            (self.folder / "sub/bad.toml").write_text(good.replace(old, new))
            result = self.bake("sub/bad.toml", "-o", "bad")
            self.assertEqual(result.returncode, 3, result.stdout + result.stderr)
            self.assertIn("DGM6004", result.stderr)


if __name__ == "__main__":
    unittest.main()
