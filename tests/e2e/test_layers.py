# SPDX-License-Identifier: GPL-3.0-or-later
"""The file as HDF5 reads it and as the runtime maps it, value by value; and through EXR and back."""
import json
import unittest

import h5py
import numpy as np

import meshes
import support

TYPES = {1: "|u1", 2: "<u2", 3: "<u4", 4: "<i2", 5: "<f2", 6: "<f4"}


class Layers(support.Folder):
    def bake_example(self, *arguments):
        meshes.write_obj(self.folder / "two.obj", meshes.together(meshes.icosphere(2), meshes.sheet(8)))
        self.bake_well("two.obj", "-o", "two.dgm", "--size", "33x29", *arguments)
        return self.folder / "two.dgm"

    def mapped(self, path):
        """{(chart, layer): (array, file offset)} as the runtime maps it, and {chart: (rows, cols, method)}."""
        raw = self.folder / "raw"
        raw.mkdir(exist_ok=True)
        result = self.run_program(support.DUMP_LAYERS, path, raw)
        self.assertEqual(result.returncode, 0, result.stderr)
        layers, charts = {}, {}
        for line in result.stdout.splitlines():
            kind, chart, *rest = line.split()
            if kind == "chart":
                charts[int(chart)] = (int(rest[0]), int(rest[1]), rest[2])
                continue
            name, element, offset, *shape = rest
            data = (raw / f"{chart}.{name}.bin").read_bytes()
            array = np.frombuffer(data, dtype=TYPES[int(element)]).reshape([int(n) for n in shape])
            layers[int(chart), name] = (array, int(offset))
        return layers, charts

    def assert_hdf5_equals_runtime(self, path):
        layers, charts = self.mapped(path)
        found = set()
        with h5py.File(path, "r") as file:
            self.assertEqual(sorted(int(k) for k in file["charts"]), sorted(charts))
            for chart, (rows, cols, method) in charts.items():
                group = file[f"charts/{chart}"]
                self.assertEqual((int(group.attrs["rows"]), int(group.attrs["cols"])), (rows, cols))
                stored = group.attrs["method"]
                self.assertEqual(stored.decode() if isinstance(stored, bytes) else str(stored), method)
                for name, dataset in group.items():
                    array, offset = layers[chart, name]
                    self.assertEqual(dataset.dtype, array.dtype, name)
                    self.assertEqual(dataset.shape, array.shape, name)
                    self.assertTrue(np.array_equal(dataset[...].view(np.uint8), array.view(np.uint8)), name)
                    self.assertEqual(dataset.id.get_offset(), offset, name)
                    found.add((chart, name))
        self.assertEqual(found, set(layers))
        return layers, charts

    def test_hdf5_and_runtime_agree(self):
        layers, charts = self.assert_hdf5_equals_runtime(self.bake_example("--fit", "sample"))
        self.assertEqual(len(charts), 2)
        # The largest component has the grid asked for, the other one the same spacing of samples.
        self.assertEqual(max((rows, cols) for rows, cols, _ in charts.values()), (33, 29))
        for chart, (rows, cols, _) in charts.items():
            self.assertTrue(17 <= rows <= 33 and 17 <= cols <= 29, (rows, cols))
            for name in ("geometry", "normal", "collision", "cover", "deformation", "contact"):
                self.assertIn((chart, name), layers)
            self.assertEqual(layers[chart, "geometry"][0].shape, (rows, cols, 3))
        # The ball's samples lie on its facets, between the faces' inscribed sphere and the unit sphere.
        ball = max(charts, key=lambda c: layers[c, "geometry"][0].astype(float)[..., 2].max())
        lengths = np.linalg.norm(layers[ball, "geometry"][0].astype(float), axis=-1)
        self.assertLess(lengths.max(), 1 + 1e-6)
        self.assertGreater(lengths.min(), 0.95)

    def test_seam_copies_are_one_point(self):
        layers, charts = self.mapped(self.bake_example())
        ball = max(charts, key=lambda c: layers[c, "geometry"][0].astype(float)[..., 2].max())
        seams = layers[ball, "seams"][0]
        self.assertGreater(len(seams), 0)  # a closed surface must have been cut
        points = layers[ball, "geometry"][0].reshape(-1, 3)
        self.assertTrue(np.array_equal(points[seams[:, 0]].view(np.uint32), points[seams[:, 1]].view(np.uint32)))
        self.assertTrue((seams[:, 0] < seams[:, 1]).all())

    def test_quantised_positions(self):
        layers, charts = self.assert_hdf5_equals_runtime(self.bake_example("--precision", "u16"))
        for chart in charts:
            self.assertEqual(layers[chart, "geometry"][0].dtype, np.dtype("<u2"))

    def test_only_the_layers_asked_for(self):
        layers, _ = self.mapped(self.bake_example("--layers", "normal,geometry"))
        names = {name for _, name in layers}
        self.assertLessEqual({"geometry", "normal"}, names)
        self.assertFalse(names & {"texture", "bump", "collision", "cover", "deformation", "contact"})

    def test_through_exr_and_back(self):
        if not support.EXPORT:
            self.skipTest("dgm-export was not built")
        for layout in ("auto", "multipart"):
            with self.subTest(layout=layout):
                path = self.bake_example("--format", "dgm,exr", "--exr-layout", layout)
                back = self.folder / "back.dgm"
                result = self.run_program(support.EXPORT, path.with_suffix(".exr"), "-o", back)
                self.assertEqual(result.returncode, 0, result.stderr)
                before, _ = self.mapped(path)
                after, _ = self.mapped(back)
                self.assertEqual(list(before), list(after))
                for key, (array, _) in before.items():
                    self.assertEqual(array.dtype, after[key][0].dtype, key)
                    self.assertEqual(array.tobytes(), after[key][0].tobytes(), key)
                self.assertEqual(path.read_bytes(), back.read_bytes())

    def test_exported_level_of_detail_is_closed(self):
        """The torus stays closed at every stride; the surface stays where it was."""
        if not support.EXPORT:
            self.skipTest("dgm-export was not built")
        meshes.write_obj(self.folder / "torus.obj", meshes.torus())
        self.bake_well("torus.obj", "-o", "torus.dgm", "--size", "65x65")
        count = {}
        for stride, name in ((1, "full.obj"), (4, "four.obj"), (4, "four.ply"), (1000, "one.obj")):
            result = self.run_program(support.EXPORT, self.folder / "torus.dgm", "-o", self.folder / name,
                                      "--lod", str(stride))
            self.assertEqual(result.returncode, 0, result.stderr)
            if not name.endswith(".obj"):
                continue
            lines = [line.split() for line in (self.folder / name).read_text(encoding="ascii").splitlines()]
            points = np.array([line[1:4] for line in lines if line and line[0] == "v"], float)
            faces = np.array([[c.split("/")[0] for c in line[1:]] for line in lines if line and line[0] == "f"], int) - 1
            self.assertEqual(len(np.unique(faces)), len(points), "every vertex has a face")
            _, weld = np.unique(points, axis=0, return_inverse=True)
            corners = weld.reshape(-1)[faces]
            corners = corners[(corners != np.roll(corners, 1, axis=1)).all(1)]
            edges = np.sort(np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]), axis=1)
            _, uses = np.unique(edges, axis=0, return_counts=True)
            # One fan for the whole chart reaches a seam's point from both of its copies along one and the same line.
            self.assertTrue((uses % 2 == 0).all() if stride == 1000 else (uses == 2).all(), name)
            ring = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 1, points[:, 2])
            other = np.hypot(np.hypot(points[:, 0], points[:, 2]) - 1, points[:, 1])
            self.assertLess(abs(min((ring, other), key=np.std) - 0.4).max(), 0.06)
            count[name] = len(faces)
        self.assertLess(count["four.obj"], count["full.obj"] / 6)
        self.assertLess(count["one.obj"], count["four.obj"])
        refused = self.run_program(support.EXPORT, self.folder / "torus.dgm", "-o", self.folder / "x.png", "--lod", "2")
        self.assertEqual(refused.returncode, 1, refused.stderr)

    @unittest.skipUnless(support.INFO, "dgm-info is not built")
    def test_info_tells_what_differs(self):
        first = self.bake_example("--fit", "sample").rename(self.folder / "first.dgm")
        second = self.bake_example("--fit", "l2", "--layers", "geometry")
        same = self.run_program(support.INFO, first, first, "--diff")
        self.assertEqual((same.returncode, same.stdout), (0, "no difference\n"), same.stderr)

        with h5py.File(first, "r") as a, h5py.File(second, "r") as b:
            moves = [np.linalg.norm(a[name][...].astype(float) - b[name][...], axis=-1).max()
                     for name in ("charts/0/geometry", "charts/1/geometry")]
        result = self.run_program(support.INFO, first, second, "--diff", "--json")
        self.assertEqual(result.returncode, 7, result.stderr)
        found = json.loads(result.stdout)
        self.assertIs(found["equal"], False)
        self.assertIn("settings hash", found["fields"])
        self.assertAlmostEqual(found["largest_move"], max(moves), places=9)
        self.assertIn(("normal", "only in the first"), [(d["layer"], d["kind"]) for d in found["layers"]])
        self.assertEqual(self.run_program(support.INFO, first, "--diff").returncode, 1)


if __name__ == "__main__":
    unittest.main()
