# SPDX-License-Identifier: GPL-3.0-or-later
"""Physics of organs through the C library on baked files: what is out of range is refused by name and changes nothing."""
import ctypes
import os
import unittest

import numpy as np

import meshes
import support

PHYSICS = os.environ.get("DGM_PHYSICS_LIBRARY", "")
SIZE = ("--size", "17x17", "--method", "tutte", "--fit", "sample")
BAD_ARGUMENT, LIMIT_EXCEEDED, UNSUPPORTED = 1, 17, 20
NONE = (float("nan"), float("inf"), -float("inf"))
u32, f32, f64, pointer = ctypes.c_uint32, ctypes.c_float, ctypes.c_double, ctypes.c_void_p


class Sized(ctypes.Structure):
    """A struct of the C interface: its size comes first."""
    def __init__(self, **values):
        super().__init__(ctypes.sizeof(type(self)), **values)


class Error(Sized):
    _fields_ = [("size", u32), ("code", u32), ("offset", ctypes.c_uint64), ("message", ctypes.c_char_p)]


class PhysicsOptions(Sized):
    _fields_ = [("size", u32)] + [
        (name, f32) for name in ("membrane", "poisson", "bending", "foundation", "density", "viscosity", "dt")] + [
        ("metres_per_unit", f64), ("max_bytes", ctypes.c_uint64), ("free_volume", u32), ("plain_loops", u32),
        ("solver", u32), ("reserved", u32)]


class Pin(Sized):
    _fields_ = [("size", u32), ("sample", u32), ("position", f32 * 3)]


class Tool(Sized):
    _fields_ = [("size", u32), ("tool", u32), ("kind", u32), ("lifted", u32), ("position", f32 * 3)]


class Obstacle(Sized):
    _fields_ = [("size", u32), ("kind", u32), ("point", f32 * 3), ("normal", f32 * 3), ("end", f32 * 3), ("radius", f32),
                ("half", f32 * 3), ("rotation", f32 * 9), ("surface", pointer), ("reach", f32)]


class StepOptions(Sized):
    _fields_ = [("size", u32), ("cycles", u32), ("gravity", f32 * 3), ("tool_radius", f32), ("obstacles", ctypes.POINTER(Obstacle)),
                ("obstacle_count", ctypes.c_size_t), ("pins", ctypes.POINTER(Pin)), ("pin_count", ctypes.c_size_t),
                ("tool_layer", f32), ("friction", f32)]


class Report(Sized):
    _fields_ = [("size", u32), ("contacts", u32), ("cycles", u32), ("clamped", u32)] + [
        (name, f64) for name in ("volume_error", "pressure", "residual", "kinetic", "elastic")]


@unittest.skipUnless(PHYSICS and not support.SANITIZED, "needs the shared library, and Python has no sanitizer")
class PhysicsInput(support.Folder):
    def setUp(self):
        super().setUp()
        self.library = ctypes.CDLL(PHYSICS)
        self.library.dgm_state_positions.restype = ctypes.c_size_t
        self.library.dgm_physics_set_dt.argtypes = [pointer, f32, pointer]
        self.error = Error()

    def call(self, name, *arguments):
        code = getattr(self.library, name)(*arguments, ctypes.byref(self.error))
        if code:
            self.assertTrue(self.error.message, "a refusal says why")
        return code

    def open(self, file, chart=0):
        asset, state = pointer(), pointer()
        self.assertEqual(self.call("dgm_asset_open", os.fsencode(self.folder / file), None, None, ctypes.byref(asset)), 0)
        self.addCleanup(self.library.dgm_asset_close, asset)
        self.assertEqual(self.call("dgm_state_create", asset, chart, None, None, ctypes.byref(state)), 0, self.error.message)
        self.addCleanup(self.library.dgm_state_destroy, state)
        return state

    def create(self, state, **options):
        """(code, handle): no handle where it is refused."""
        physics = pointer()
        code = self.call("dgm_physics_create", state, ctypes.byref(PhysicsOptions(**options)), None, ctypes.byref(physics))
        self.assertEqual(code == 0, physics.value is not None)
        if code == 0:
            self.addCleanup(self.library.dgm_physics_destroy, physics)
        return code, physics

    def step(self, state, physics, tool=None, pins=(), obstacle=None, **options):
        tools, held = (Tool * 1)(*([tool] if tool else [])), (Pin * max(1, len(pins)))(*pins)
        if obstacle:
            options.update(obstacles=ctypes.pointer(obstacle), obstacle_count=1)
        how = StepOptions(pins=held, pin_count=len(pins), **options)
        self.report = Report()
        return self.call("dgm_physics_step", state, physics, ctypes.byref(how), tools if tool else None, 1 if tool else 0, None,
                         ctypes.byref(self.report))

    def shape(self, state):
        xyz = (ctypes.POINTER(f32) * 3)()
        count = self.library.dgm_state_positions(state, xyz)
        return np.array([np.ctypeslib.as_array(p, (count,)) for p in xyz])

    def bake_mesh(self, mesh, *options):
        meshes.write_obj(self.folder / "m.obj", mesh)
        self.bake_well("m.obj", *options, "-o", "m.dgm")
        return self.open("m.dgm")

    def falls(self, state):
        code, physics = self.create(state)
        self.assertEqual(code, 0, self.error.message)
        self.assertEqual(self.step(state, physics, gravity=(0, 0, -10)), 0, self.error.message)
        self.assertEqual(self.report.clamped, 0)
        self.assertGreater(self.report.kinetic, 0)
        self.assertTrue(np.isfinite(self.shape(state)).all())

    def test_materials_and_units_out_of_range(self):
        state = self.bake_mesh(meshes.icosphere(2), *SIZE, "--unit", "cm")
        rest = self.shape(state).tobytes()
        bad = {"membrane": (1e-7, 1e13), "poisson": (.5, 1), "bending": (1e13,), "foundation": (1e13,), "density": (1e-7, 1e13),
               "viscosity": (1e7,), "dt": (-1, 1e-6, 11), "metres_per_unit": (-1, 1e-10, 1e10)}
        words = {"poisson": "Poisson", "dt": "time step", "metres_per_unit": "unit"}
        for name, values in bad.items():
            # In C a negative number means none, -infinity too, and 0 the default.
            for value in values + (NONE if name in ("dt", "metres_per_unit") else NONE[:2]):
                with self.subTest(name=name, value=value):
                    self.assertEqual(self.create(state, **{name: value})[0], BAD_ARGUMENT)
                    self.assertIn(words.get(name, name), self.error.message.decode())
        self.assertEqual(self.create(state, bending=1e6)[0], LIMIT_EXCEEDED)
        self.assertIn("bends over a length beyond the body", self.error.message.decode())
        self.assertEqual(self.create(state, solver=7)[0], BAD_ARGUMENT)
        self.assertEqual(self.create(state, max_bytes=1000)[0], LIMIT_EXCEEDED)
        self.assertEqual(self.shape(state).tobytes(), rest)

    def test_steps_that_are_refused_leave_nothing_behind(self):
        state, twin = self.bake_mesh(meshes.icosphere(2), *SIZE, "--unit", "cm"), self.open("m.dgm")
        (_, physics), (_, other) = self.create(state), self.create(twin)
        good = {"tool": Tool(position=(0, 0, 1.1)), "tool_radius": .2, "gravity": (0, 0, -10),
                "friction": .5, "obstacle": Obstacle(point=(0, 0, -1.05), normal=(0, 0, 1))}
        for s, p in ((state, physics), (twin, other)):
            self.assertEqual(self.step(s, p, **good), 0, self.error.message)
        before = self.shape(state).tobytes()
        faults = [{"cycles": 1001}, {"pins": [Pin(sample=17 * 17)]}, {"pins": [Pin(sample=5)] * 2}, {"tool_radius": 0},
                  {"tool_radius": -1}, {"tool_layer": -1}, {"tool_layer": .5}, {"friction": -1}, {"friction": 101}, {"tool": Tool(kind=9)},
                  {"obstacle": Obstacle(kind=9)}, {"obstacle": Obstacle()}]
        for value in NONE + (1e30,):
            faults += [{"gravity": (0, value, 0)}, {"tool": Tool(position=(value, 0, 0))}, {"tool_radius": value},
                       {"tool_layer": value}, {"friction": value},
                       {"pins": [Pin(sample=5, position=(0, 0, value))]},
                       {"obstacle": Obstacle(point=(0, 0, value), normal=(0, 0, 1))}]
        for fault in faults:
            with self.subTest(fault=str(fault)):
                self.assertIn(self.step(state, physics, **{**good, **fault}), (BAD_ARGUMENT, UNSUPPORTED))
                self.assertEqual(self.shape(state).tobytes(), before)
        for value in NONE + (0, -1, 11):
            self.assertEqual(self.call("dgm_physics_set_dt", physics, value), BAD_ARGUMENT)
        for s, p in ((state, physics), (twin, other)):
            self.assertEqual(self.step(s, p, **good), 0)
        self.assertEqual(self.shape(state).tobytes(), self.shape(twin).tobytes(), "the next step is that of a body which met none")
        self.assertNotEqual(self.shape(state).tobytes(), before)

    def test_maps_that_are_no_closed_square(self):
        state = self.bake_mesh(meshes.icosphere(2), *SIZE)
        self.assertEqual(self.create(state)[0], UNSUPPORTED)
        self.assertIn("--unit", self.error.message.decode())
        smallest = (*SIZE[2:], "--domain", "square", "--size")
        # A closed body needs 5 x 5: the bake refuses 3 x 3 and says so.
        for name, mesh, options in (("open", meshes.sheet(), SIZE), ("3 x 3", meshes.sheet(), (*smallest, "3x3")),
                                    ("closed, 5 x 5", meshes.icosphere(2), (*smallest, "5x5")),
                                    ("torus", meshes.torus(), ("--size", "17x17"))):
            with self.subTest(name):
                self.falls(self.bake_mesh(mesh, *options, "--unit", "cm"))
        for name, mesh, options, word in (("mask", meshes.sheet(), ("--size", "17x17", "--domain", "free"), "free domain"),
                                          ("one side", meshes.moebius(), ("--size", "17x17"), "one side")):
            with self.subTest(name):
                self.assertEqual(self.create(self.bake_mesh(mesh, *options, "--unit", "cm"))[0], UNSUPPORTED)
                self.assertIn(word, self.error.message.decode())

    def test_each_chart_of_several_is_a_body(self):
        v, f = meshes.icosphere(2)
        self.bake_mesh(meshes.together((v, f), ([(x + 5, y, z) for x, y, z in v], f)), *SIZE, "--unit", "cm")
        for chart in (0, 1):
            self.falls(self.open("m.dgm", chart))


if __name__ == "__main__":
    unittest.main()
