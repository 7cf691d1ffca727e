# SPDX-License-Identifier: GPL-3.0-or-later
"""The same mesh and settings give the same bytes, whatever is different around them."""
import os
import unittest

import meshes
import support


class Determinism(support.Folder):
    def setUp(self):
        super().setUp()
        source = self.folder / "in"
        source.mkdir()
        meshes.write_obj(source / "ball.obj", meshes.icosphere(2))
        meshes.write_obj(source / "sheet.obj", meshes.sheet(12))
        meshes.write_obj(source / "two.obj", meshes.together(meshes.torus(16, 10), meshes.sheet(6)))

    def contents(self, folder):
        return {name: (self.folder / folder / name).read_bytes() for name in self.names(self.folder / folder)}

    def assert_same(self, one, other):
        first, second = self.contents(one), self.contents(other)
        self.assertEqual(list(first), list(second))
        # Beside these, layers of another size have files of their own.
        self.assertLessEqual({f"{stem}.{end}" for stem in ("ball", "sheet", "two") for end in ("dgm", "exr")}, set(first))
        for name, content in first.items():
            self.assertTrue(content == second[name], f"{name} differs between {one} and {other}")

    def test_bytes(self):
        settings = ["--size", "33", "--format", "dgm,exr"]
        self.bake_well("in", "-o", "one", "-j1", *settings)
        self.bake_well("in", "-o", "again", "-j1", *settings)
        self.assert_same("one", "again")
        self.bake_well("in", "-o", "two", "-j2", *settings)
        self.assert_same("one", "two")
        # Another spelling of the paths, another working folder, time zone and locale.
        elsewhere = self.folder / "elsewhere"
        elsewhere.mkdir()
        old = {key: os.environ.get(key) for key in ("LC_ALL", "TZ")}
        os.environ.update(LC_ALL="de_DE.UTF-8", TZ="Pacific/Chatham")
        try:
            self.bake_well(self.folder / "in", "-o", self.folder / "absolute", "-j1", *settings, cwd=elsewhere)
        finally:
            for key, value in old.items():
                os.environ.pop(key)
                if value is not None:
                    os.environ[key] = value
        self.assert_same("one", "absolute")

    def test_addresses(self):
        """With the system's random addresses, and always the same ones: pointers decide nothing."""
        self.bake_well("in/two.obj", "-o", "random/", "--size", "33")
        fixed = self.run_program("setarch", "-R", support.BAKE, "in/two.obj", "-o", "fixed/", "--size", "33")
        if fixed.returncode != 0 and "personality" in fixed.stderr:
            self.skipTest("this system does not let a program ask for fixed addresses")
        self.assertEqual(fixed.returncode, 0, fixed.stderr)
        self.assertEqual((self.folder / "random/two.dgm").read_bytes(), (self.folder / "fixed/two.dgm").read_bytes())

    def test_an_exr_beside_it_changes_nothing(self):
        self.bake_well("in/ball.obj", "-o", "a/", "--size", "17")
        self.bake_well("in/ball.obj", "-o", "b/", "--size", "17", "--format", "exr,dgm")
        self.assertEqual((self.folder / "a/ball.dgm").read_bytes(), (self.folder / "b/ball.dgm").read_bytes())

    def test_settings_change_the_bytes(self):
        self.bake_well("in/sheet.obj", "-o", "a.dgm", "--size", "17")
        self.bake_well("in/sheet.obj", "-o", "b.dgm", "--size", "17x19")
        self.assertNotEqual((self.folder / "a.dgm").read_bytes(), (self.folder / "b.dgm").read_bytes())


if __name__ == "__main__":
    unittest.main()
