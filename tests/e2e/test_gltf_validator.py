# SPDX-License-Identifier: GPL-3.0-or-later
"""Khronos' glTF validator finds nothing in exported files. Needs node and its package gltf-validator: by NODE_PATH, where
node looks, or from npm, which then puts it into the build folder; is skipped, and says why, without them."""
import json
import os
import shutil
import subprocess
import sys
import unittest

import meshes
import support

PACKAGE = "gltf-validator@2.0.0-dev.3.10"
SCRIPT = """
const validator = require('gltf-validator'), fs = require('fs');
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])))
  .then(report => console.log(JSON.stringify(report.issues)));
"""


def missing():
    """The missing part, or None."""
    if shutil.which("node") is None:
        return "there is no node"
    if node_finds_it():
        return None
    folder = os.environ.get("DGM_NODE_FOLDER")
    if not folder or shutil.which("npm") is None:
        return "node does not find gltf-validator, and there is no npm to fetch it; set NODE_PATH"
    os.environ["NODE_PATH"] = os.path.join(folder, "node_modules")
    if node_finds_it():
        return None
    try:
        fetched = subprocess.run(["npm", "install", "--no-audit", "--no-fund", "--prefix", folder, PACKAGE],
                                 capture_output=True, text=True, timeout=120, check=False)
    except subprocess.TimeoutExpired:
        return "npm does not answer"
    if node_finds_it():
        return None
    return f"npm could not fetch {PACKAGE}: {fetched.stderr.strip()[-300:]}"


def node_finds_it():
    found = subprocess.run(["node", "-e", "require('gltf-validator')"], capture_output=True, timeout=60, check=False)
    return found.returncode == 0


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
        for options in ((), ("--lod", "4", "--up", "z")):
            issues = self.issues(*options)
            self.assertEqual((issues["numErrors"], issues["numWarnings"]), (0, 0), issues["messages"])

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


if __name__ == "__main__":
    reason = missing()
    if reason:
        print("skipped:", reason)
        sys.exit(77)
    unittest.main()
