# SPDX-License-Identifier: GPL-3.0-or-later
"""Khronos' glTF validator finds nothing in exported files, and three.js loads every form of them as what it is. Needs node
and its packages gltf-validator and three: by NODE_PATH, where node looks, or from npm, which then puts them into the
build folder; is skipped, and says why, without them."""
import json
import sys
import unittest

import numpy as np

import meshes
import node_packages
import support

SCRIPT = """
const validator = require('gltf-validator'), fs = require('fs');
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])))
  .then(report => console.log(JSON.stringify(report.issues)));
"""
# GLTFLoader of three.js without a browser: pictures are not decoded, but their size is read.
LOAD = """
const fs = require('fs'), path = require('path'), url = require('url');
const root = path.dirname(path.dirname(require.resolve('three')));
const module_of = name => import(url.pathToFileURL(path.join(root, name)).href);
globalThis.self = globalThis;
globalThis.createImageBitmap = async blob => {
  const head = Buffer.from(await blob.arrayBuffer());
  return {width: head.readUInt32BE(16), height: head.readUInt32BE(20), close() {}};
};
(async () => {
  const THREE = await module_of('build/three.module.js');
  const {GLTFLoader} = await module_of('examples/jsm/loaders/GLTFLoader.js');
  const {MeshoptDecoder} = await module_of('examples/jsm/libs/meshopt_decoder.module.js');
  const data = fs.readFileSync(process.argv[1]);
  const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
  const gltf = await loader.parseAsync(data.buffer.slice(data.byteOffset, data.byteOffset + data.length), '');
  gltf.scene.updateMatrixWorld(true);
  const meshes = [];
  gltf.scene.traverse(object => {
    if (!object.isMesh) return;
    const {position} = object.geometry.attributes, index = object.geometry.index, corners = [];
    for (let k = 0; k < index.count; ++k)
      corners.push(...new THREE.Vector3().fromBufferAttribute(position, index.getX(k)).applyMatrix4(object.matrixWorld)
        .toArray());
    const size = picture => picture && [picture.image.width, picture.image.height];
    meshes.push({name: object.name, material: object.material.name, corners, map: size(object.material.map),
                 normalMap: size(object.material.normalMap)});
  });
  console.log(JSON.stringify(meshes));
})().catch(error => { console.error(error); process.exit(1); });
"""
FORMS = ((), ("--lod", "4", "--up", "z"), ("--quantize",), ("--compress",), ("--quantize", "--compress", "--up", "z"),
         ("--lod", "1,4,16"), ("--lod", "1,4", "--lod-mode", "nodes", "--quantize"), ("--power-of-two",),
         ("--lod", "1,2,8", "--quantize", "--compress", "--power-of-two"))


class GltfValidator(support.Folder):
    def issues(self, *arguments):
        exported = self.run_program(support.EXPORT, "x.dgm", "-o", "x.glb", *arguments)
        self.assertEqual(exported.returncode, 0, exported.stderr)
        report = self.run_program("node", "-e", SCRIPT, self.folder / "x.glb")
        self.assertEqual(report.returncode, 0, report.stderr)
        return json.loads(report.stdout)

    def check(self, mesh, *arguments):
        meshes.write_obj(self.folder / "x.obj", mesh)
        self.bake_well("x.obj", "-o", "x.dgm", *arguments)
        for options in FORMS:
            issues = self.issues(*options)
            self.assertEqual((issues["numErrors"], issues["numWarnings"]), (0, 0), (options, issues["messages"]))

    def test_kinds_of_maps(self):
        self.check(meshes.together(meshes.icosphere(2), meshes.sheet(8)), "--size", "33x29")
        self.check(meshes.sheet(8), "--size", "33x33", "--domain", "free")
        self.check(meshes.torus(), "--size", "33x33", "--precision", "u16", "--bump-size", "49x41")
        self.check(meshes.torus(), "--size", "33x33", "--layers", "geometry")
        vertices, faces = meshes.icosphere(2)
        self.check(([(x + 1e7, y, z) for x, y, z in vertices], faces), "--size", "33x33")

    def test_it_would_find_something(self):
        meshes.write_obj(self.folder / "x.obj", meshes.sheet(8))
        self.bake_well("x.obj", "-o", "x.dgm", "--size", "9x9")
        self.issues()
        data = bytearray((self.folder / "x.glb").read_bytes())
        data[-8:] = b"\xff" * 8  # indices beyond the vertices
        (self.folder / "x.glb").write_bytes(data)
        report = self.run_program("node", "-e", SCRIPT, self.folder / "x.glb")
        self.assertGreater(json.loads(report.stdout)["numErrors"], 0)

class ThreeJs(support.Folder):
    def loaded(self, *arguments):
        exported = self.run_program(support.EXPORT, "x.dgm", "-o", "x.glb", *arguments)
        self.assertEqual(exported.returncode, 0, exported.stderr)
        result = self.run_program("node", "-e", LOAD, self.folder / "x.glb")
        self.assertEqual(result.returncode, 0, (arguments, result.stderr))
        return json.loads(result.stdout)

    def test_every_form_has_the_shape(self):
        meshes.write_obj(self.folder / "x.obj", meshes.together(meshes.icosphere(2), meshes.sheet(8)))
        self.bake_well("x.obj", "-o", "x.dgm", "--size", "33x29")
        plain = self.loaded()
        self.assertEqual([m["name"] for m in plain], ["x_chart0", "x_chart1"])
        for form in FORMS:
            found = self.loaded(*form)
            levels = 2 if "nodes" in form else 1  # those of MSFT_lod are not in the scene
            self.assertEqual(len(found), 2 * levels, form)
            if "--lod" in form and not form[1].startswith("1,"):
                continue
            for wanted, mesh in zip(plain, found[::levels]):
                with self.subTest(form=form, mesh=mesh["name"]):
                    self.assertEqual(mesh["name"], wanted["name"])
                    self.assertEqual(mesh["material"], wanted["material"])
                    points = np.asarray(wanted["corners"]).reshape(-1, 3)
                    if "z" in form:
                        points = np.stack([points[:, 0], points[:, 2], -points[:, 1]], axis=1)
                    there = np.asarray(mesh["corners"]).reshape(-1, 3)
                    size = np.ptp(points, axis=0).max()
                    slack = size * (1.01 / 131070 if "--quantize" in form else 1e-6) + 1e-6 * size
                    if "--compress" in form:  # corners of a triangle may be turned
                        self.assertLess(abs(self.centres(there) - self.centres(points)).max(), slack)
                    else:
                        self.assertLess(abs(there - points).max(), slack)
                    sides = mesh["normalMap"]
                    self.assertTrue(sides)
                    if "--power-of-two" in form:
                        self.assertEqual([side & (side - 1) for side in sides], [0, 0])

    def centres(self, corners):
        return corners.reshape(-1, 3, 3).mean(axis=1)


if __name__ == "__main__":
    reason = node_packages.missing("gltf-validator", "three")
    if reason:
        print("skipped:", reason)
        sys.exit(77)
    unittest.main()
