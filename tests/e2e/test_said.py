# SPDX-License-Identifier: GPL-3.0-or-later
"""A tool that says what it did: every way in which a newcomer once had to guess."""
import base64
import json
import os
import re
import shutil
import struct
import subprocess
import time
import unittest

import h5py
import numpy as np

import meshes
import support
from pictures import png

SIZE = ["--size", "17", "--method", "tutte", "--fit", "sample"]


def write_stl(path, mesh):
    vertices, faces = mesh
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *vertices[a], *vertices[b], *vertices[c], 0) for a, b, c in faces)
    path.write_bytes(b"solid by a test".ljust(80) + struct.pack("<I", len(faces)) + body)


def write_ply(path, mesh):
    vertices, faces = mesh
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}", "property float x", "property float y",
             "property float z", f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    lines += ["{} {} {}".format(*v) for v in vertices] + ["3 {} {} {}".format(*f) for f in faces]
    path.write_text("\n".join(lines) + "\n")


def write_gltf(path, mesh, texture=None):
    """Separate files: NAME.gltf and NAME.bin, with a picture that need not be there."""
    vertices, faces = mesh
    points = b"".join(struct.pack("<3f", *v) for v in vertices)
    coords = b"".join(struct.pack("<2f", v[0], v[1]) for v in vertices)
    indices = b"".join(struct.pack("<3I", *f) for f in faces)
    buffer = points + coords + indices
    path.with_suffix(".bin").write_bytes(buffer)
    views, at = [], 0
    for part in (points, coords, indices):
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(part)})
        at += len(part)
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "buffers": [{"uri": path.with_suffix(".bin").name, "byteLength": len(buffer)}], "bufferViews": views,
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3",
                       "min": [min(v[k] for v in vertices) for k in range(3)],
                       "max": [max(v[k] for v in vertices) for k in range(3)]},
                      {"bufferView": 1, "componentType": 5126, "count": len(vertices), "type": "VEC2"},
                      {"bufferView": 2, "componentType": 5125, "count": 3 * len(faces), "type": "SCALAR"}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}} if texture else {}}]}
    if texture:
        document |= {"textures": [{"source": 0}], "images": [{"uri": texture}]}
    path.write_text(json.dumps(document))


class Said(support.Folder):
    def report(self, name="r.json"):
        return json.loads((self.folder / name).read_text())

    def stumble(self, program, exit_code, words, *arguments):
        result = self.run_program(program, *arguments)
        self.assertEqual(result.returncode, exit_code, result.stdout + result.stderr)
        for word in words:
            self.assertIn(word, result.stdout + result.stderr)
        return result

    def test_a_folder_of_all_formats(self):
        folder = self.folder / "in"
        folder.mkdir()
        sheet = meshes.sheet(4)
        meshes.write_obj(folder / "a.obj", sheet)
        write_stl(folder / "b.stl", sheet)
        write_ply(folder / "c.ply", sheet)
        write_gltf(folder / "d.gltf", sheet)
        for name in ("e.blend", "f.max", "sub.max", "g.md3", "skin.png", "a.mtl"):
            (folder / name).write_text("x")
        result = self.bake_well("in", "-o", "out", *SIZE, "--report", "r.json")
        self.assertEqual(self.names(self.folder / "out"), ["a.dgm", "b.dgm", "c.dgm", "d.dgm"])
        self.assertIn("4 assets: 4 baked\n", result.stdout)
        left = [line for line in result.stdout.splitlines() if line.startswith("left out: ")]
        self.assertEqual([line.split(":")[1] for line in left], [" 1 .blend file", " 2 .max files", " 1 .md3 file"])
        self.assertEqual([entry["path"] for entry in self.report()["left_out"]],
                         ["in/e.blend", "in/f.max", "in/g.md3", "in/sub.max"])
        self.assertIn("left out: in/f.max: ", self.bake_well("in", "-o", "out", *SIZE, "-v").stdout)
        self.bake_well("in", "-o", "out", *SIZE, "--report", "r.html")
        self.assertIn("<h2>Left out</h2>", (self.folder / "r.html").read_text())
        # A single asset has no sum, but what was left out is said all the same.
        for name in ("b.stl", "c.ply", "d.gltf", "d.bin"):
            (folder / name).unlink()
        self.assertIn("left out: 2 .max files", self.bake_well("in", "-o", "one", *SIZE).stdout)

    def test_formats_that_only_an_import_knows_are_not_baked_twice(self):
        write_gltf(self.folder / "a.gltf", meshes.sheet(4), "my skin.png")
        first = self.bake_well("a.gltf", *SIZE)
        self.assertIn("DGM3012: texture missing: my skin.png; looked for beside the mesh and there in textures",
                      first.stderr)
        self.assertIn(": up to date, ", self.bake_well("a.gltf", *SIZE).stdout)
        (self.folder / "textures").mkdir()
        (self.folder / "textures" / "My Skin.png").write_bytes(bytes.fromhex(
            "89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de0000000c49444154789c63f8cfc000000301010018dd"
            "8db00000000049454e44ae426082"))
        self.assertNotIn("up to date", self.bake_well("a.gltf", *SIZE).stdout)
        depfile = self.bake_well("a.gltf", *SIZE, "-MF", "deps/a.d")
        self.assertIn(": up to date, ", depfile.stdout)
        rule = (self.folder / "deps" / "a.d").read_text()
        self.assertIn("a.bin", rule)
        self.assertIn("textures/My\\ Skin.png", rule)
        write_gltf(self.folder / "a.gltf", meshes.sheet(4, 0.3), "my skin.png")  # the JSON stays as it was
        self.assertNotIn("up to date", self.bake_well("a.gltf", *SIZE).stdout)

    def test_a_picture_inside_the_mesh_file_is_its_texture(self):
        picture = png([[(255, 0, 0), (0, 0, 255)], [(0, 255, 0), (255, 255, 0)]])
        write_gltf(self.folder / "a.gltf", meshes.sheet(4), "data:image/png;base64," + base64.b64encode(picture).decode())
        result = self.bake_well("a.gltf", *SIZE, "--report", "r.json")
        self.assertNotIn("texture", result.stdout + result.stderr)
        with h5py.File(self.folder / "a.dgm", "r") as file:
            inside = file["charts/0/texture"][...]
        (self.folder / "beside.png").write_bytes(picture)
        write_gltf(self.folder / "b.gltf", meshes.sheet(4), "beside.png")
        self.bake_well("b.gltf", *SIZE)
        with h5py.File(self.folder / "b.dgm", "r") as file:
            beside = file["charts/0/texture"][...]
        self.assertGreater(np.ptp(inside.astype(float), axis=(0, 1)).max(), 0.1)  # two colours, not one
        np.testing.assert_array_equal(inside, beside)

    def test_names_are_stable_and_leftovers_are_told(self):
        folder = self.folder / "in"
        folder.mkdir()
        meshes.write_obj(folder / "y.obj", meshes.sheet(4))
        self.bake_well("in", "-o", "out", *SIZE)
        write_ply(folder / "y.ply", meshes.sheet(5))
        result = self.bake_well("in", "-o", "out", *SIZE)
        self.assertIn("y.dgm: up to date", result.stdout)
        self.assertEqual(self.names(self.folder / "out"), ["y.dgm", "y.ply.dgm"])
        alone = self.bake_well("in/y.ply", "-o", "out", *SIZE)
        self.assertIn("y.ply.dgm: up to date", alone.stdout)
        # Its mesh goes; a map of another making and a file that is none lie beside it.
        (folder / "y.ply").unlink()
        (self.folder / "out" / "notes.dgm").write_text("not a map")
        (self.folder / "out" / "sub").mkdir()
        (self.folder / "out" / "y.dgm").rename(self.folder / "out" / "y.obj.dgm")
        result = self.bake_well("in", "-o", "out", *SIZE, "--report", "r.json")
        self.assertIn("left over: out/y.obj.dgm: its mesh y.obj becomes out/y.dgm now\n"
                      "left over: out/y.ply.dgm: its mesh y.ply is gone\n--prune removes them\n", result.stdout)
        self.assertEqual([(f["path"], f["removed"]) for f in self.report()["left_over"]],
                         [("out/y.obj.dgm", False), ("out/y.ply.dgm", False)])
        before = self.names(self.folder / "out")
        self.assertIn("left over: out/y.ply.dgm", self.bake_well("in", "-o", "out", "--prune", "--dry-run").stdout)
        self.assertEqual(self.names(self.folder / "out"), before)
        result = self.bake_well("in", "-o", "out", *SIZE, "--prune", "--report", "r.json")
        self.assertIn("removed: out/y.ply.dgm", result.stdout)
        self.assertEqual(self.names(self.folder / "out"), ["notes.dgm", "sub", "y.dgm"])
        self.assertEqual([f["removed"] for f in self.report()["left_over"]], [True, True])
        self.assertNotIn("left over", self.bake_well("in", "-o", "out", *SIZE).stdout)

    def test_nothing_is_pruned_where_a_mesh_was_not_looked_for(self):
        for name in ("one", "two"):
            (self.folder / name).mkdir()
            meshes.write_obj(self.folder / name / f"{name}.obj", meshes.sheet(4))
        self.bake_well("one", "two", "-o", "out", *SIZE)
        (self.folder / "two").rename(self.folder / "away")
        result = self.bake("one", "two", "-o", "out", *SIZE, "--prune")  # a disk that is not mounted
        self.assertEqual(result.returncode, 2)
        self.assertEqual(self.names(self.folder / "out"), ["one.dgm", "two.dgm"])
        # Nor where the system cannot tell whether it is there: a loop of links here, a share that fails elsewhere.
        (self.folder / "in" / "sub").mkdir(parents=True)
        meshes.write_obj(self.folder / "in" / "sub" / "three.obj", meshes.sheet(4))
        meshes.write_obj(self.folder / "in" / "four.obj", meshes.sheet(4))
        self.bake_well("in", "-o", "maps", *SIZE)
        shutil.rmtree(self.folder / "in" / "sub")
        (self.folder / "in" / "sub").symlink_to("sub")
        self.bake_well("in", "-o", "maps", *SIZE, "--prune")
        self.assertTrue((self.folder / "maps" / "sub" / "three.dgm").exists())
        # One file under a name of the user's own says nothing about others.
        self.assertNotIn("left over", self.bake_well("one/one.obj", "-o", "out/mine.dgm", *SIZE).stdout)
        self.assertNotIn("left over", self.bake_well("one/one.obj", "-o", "out/", *SIZE).stdout)
        self.stumble(support.BAKE, 1, ["--prune looks through the folder"], "one", "--prune")

    def test_streams_are_refused(self):
        meshes.write_obj(self.folder / "a.obj", meshes.sheet(4))
        for option in ("-o", "--report", "-M"):
            self.stumble(support.BAKE, 1, ["cannot go to standard output", "name a file"], "a.obj", option, "-")
        self.assertEqual(self.names(), ["a.obj"])

    def test_reports_say_what_they_are(self):
        meshes.write_obj(self.folder / "a.obj", meshes.sheet(4))
        self.stumble(support.BAKE, 1, ['"out.txt" does not say what to write', ".json or .html"],
                     "a.obj", "--report", "out.txt")
        self.bake_well("a.obj", *SIZE, "--report", "out.txt", "--report-format", "json")
        self.assertEqual(self.report("out.txt")["report_version"], 2)
        html = self.bake_well("a.obj", *SIZE, "--report", "pages/index.html")
        self.assertIn("1 page made", html.stdout)
        self.assertIn("report: 1 of 1 page\n", html.stderr)

    def test_every_option_makes_its_folders(self):
        meshes.write_obj(self.folder / "a.obj", meshes.sheet(4))
        self.bake_well("a.obj", *SIZE, "-o", "x/y/a.dgm", "--report", "r/s/r.json", "-MF", "d/e/a.d")
        self.bake_well("a.obj", *SIZE, "-o", "z/w/")
        self.stumble(support.EXPORT, 0, [], "x/y/a.dgm", "-o", "m/n/a.ply")
        self.stumble(support.VALIDATE, 0, [], "x/y/a.dgm", "--report", "json=v/w/v.json")
        self.stumble(support.VALIDATE, 0, [], "x/y/a.dgm", "--write-baseline", "b/c/known.json")
        for file in ("x/y/a.dgm", "r/s/r.json", "d/e/a.d", "z/w/a.dgm", "m/n/a.ply", "v/w/v.json", "b/c/known.json"):
            self.assertTrue((self.folder / file).is_file(), file)

    def test_a_mesh_is_no_map(self):
        meshes.write_obj(self.folder / "a.obj", meshes.sheet(4))
        (self.folder / "empty").mkdir()
        words = ["DGM1001", "this is a mesh, not a map: bake it first"]
        self.stumble(support.EXPORT, 3, [*words, "next: dgm-bake a.obj -o a.dgm"], "a.obj", "-o", "a.ply")
        self.stumble(support.INFO, 3, [*words, "next: dgm-bake a.obj -o a.dgm"], "a.obj")
        self.stumble(support.VALIDATE, 3, words, "a.obj")
        for program, more in ((support.EXPORT, ["-o", "a.ply"]), (support.INFO, []), (support.VALIDATE, [])):
            self.stumble(program, 2, ["the folder holds no maps"], "empty", *more)

    def test_info_reads_exr(self):
        meshes.write_obj(self.folder / "a.obj", meshes.sheet(4))
        self.bake_well("a.obj", *SIZE, "--format", "dgm,exr")
        told = {name: json.loads(self.stumble(support.INFO, 0, [], name, "--json").stdout)["files"][0]
                for name in ("a.dgm", "a.exr")}
        layers = {name: {layer["name"]: (layer["type"], layer["shape"], layer["bytes"], layer["hash"])
                         for layer in file["charts"][0]["layers"]} for name, file in told.items()}
        self.assertEqual(layers["a.exr"], layers["a.dgm"])
        self.assertIsNone(told["a.exr"]["charts"][0]["layers"][0]["offset"])
        self.assertEqual(told["a.exr"]["report"], told["a.dgm"]["report"])
        self.assertIn("format 1 as EXR" if told["a.dgm"]["format_version"] == 1 else " as EXR",
                      self.stumble(support.INFO, 0, [], "a.exr").stdout)
        self.stumble(support.INFO, 0, [], "a.exr", "a.dgm", "--diff")

    def test_hints_fit_their_causes(self):
        vertices, faces = meshes.sheet(4)
        meshes.write_obj(self.folder / "huge.obj", ([(x * 1e200, y * 1e200, z) for x, y, z in vertices], faces))
        result = self.stumble(support.BAKE, 3, ["DGM3008", "1e-15 to 1e15", "next: scale the mesh"], "huge.obj", *SIZE)
        self.assertNotIn("decimate", result.stderr)
        many = meshes.together(*[meshes.sheet(1)] * 12)
        meshes.write_obj(self.folder / "many.obj", many)
        result = self.stumble(support.BAKE, 3, ["DGM3007", "12 components", "next: ask for a smaller --size"],
                              "many.obj", "--size", "8193", "--memory-limit", "0", "--method", "tutte", "--fit", "sample")
        self.assertNotIn("decimate", result.stderr)
        self.stumble(support.BAKE, 3, ["DGM9004", "8192 MiB are enough for about 2061x2061", "--memory-limit"],
                     "many.obj", "--size", "8193")
        (self.folder / "none.obj").touch()
        self.stumble(support.BAKE, 3, ["next: copy or export it again"], "none.obj")

    def test_notes_of_a_batch_are_one_line(self):
        folder = self.folder / "in"
        folder.mkdir()
        for k in range(5):
            meshes.write_obj(folder / f"m{k}.obj", meshes.sheet(3 + k))
        meshes.write_obj(folder / "ball.obj", meshes.icosphere(1))
        result = self.bake_well("in", "-o", "out", *SIZE, "--progress", "none")
        self.assertEqual(result.stderr, "dgm-bake: notes: open border (fine for cloth, odd for an organ) on 5 of 6 "
                                        "meshes; -v tells which\n")
        verbose = self.bake_well("in", "-o", "out", *SIZE, "--progress", "none", "--force", "-v")
        self.assertEqual(len(re.findall(r"note: open border \(1 loop\)", verbose.stderr)), 5)

    def test_the_index_is_there_while_the_batch_runs(self):
        folder = self.folder / "in"
        folder.mkdir()
        meshes.write_obj(folder / "a.obj", meshes.sheet(3))
        meshes.write_obj(folder / "b.obj", meshes.icosphere(5))
        process = subprocess.Popen([support.BAKE, "in", "-o", "out", "-j1", "--report", "r/index.html", "--size", "65"],
                                   cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        index, seen = self.folder / "r" / "index.html", []
        while process.poll() is None:
            if index.exists():
                text = index.read_text()
                self.assertTrue(text.rstrip().endswith("</html>"), "an index is whole at any time")
                seen.append((re.search(r"still running: (\d) of 2", text), "a.obj" in text, '"refresh"' in text))
            time.sleep(0.02)
        self.assertEqual(process.returncode, 0)
        running = [(int(match[1]), has_a, reloads) for match, has_a, reloads in seen if match]
        self.assertIn((1, True, True), running)
        text = index.read_text()
        self.assertNotIn("still running", text)
        self.assertNotIn('"refresh"', text)
        self.assertIn("assets/a.obj.html", text)


class Packages(support.Folder):
    """scripts/install_packages beside another apt, with programs of ours in their places."""
    SCRIPT = os.environ.get("DGM_INSTALL_PACKAGES", "")

    def fake(self, name, text):
        path = self.folder / "bin" / name
        path.write_text("#!/bin/sh\n" + text)
        path.chmod(0o755)

    def run_script(self, update):
        (self.folder / "bin").mkdir(exist_ok=True)
        self.fake("dpkg-query", "exit 1\n")
        self.fake("id", "echo 0\n")
        self.fake("sleep", "exit 0\n")
        self.fake("apt-get", f'echo "$*" >> log\ncase "$*" in *update*) {update} ;; esac\n')
        return subprocess.run(["sh", self.SCRIPT], cwd=self.folder, capture_output=True, text=True, check=False, timeout=60,
                              env={**os.environ, "PATH": f"{self.folder}/bin:/usr/bin:/bin", "DGM_APT_PATIENCE": "10"})

    def test_it_waits_for_another_apt(self):
        held = 'n=$(wc -l < log); [ "$n" -ge 3 ] || { echo "E: Could not get lock /var/lib/apt/lists/lock"; exit 100; }'
        result = self.run_script(held)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertEqual(result.stdout.count("another apt is at work"), 1)
        log = (self.folder / "log").read_text().splitlines()
        self.assertEqual(["update" in line for line in log], [True, True, True, False])
        self.assertIn("DPkg::Lock::Timeout=10", log[-1])

    def test_it_gives_up_in_the_end(self):
        result = self.run_script('echo "E: Could not get lock"; exit 100')
        self.assertEqual(result.returncode, 100)
        self.assertIn("Could not get lock", result.stdout)
        self.assertFalse(any("install" in line for line in (self.folder / "log").read_text().splitlines()))

    def test_other_failures_are_not_waited_for(self):
        result = self.run_script('echo "E: no network"; exit 100')
        self.assertEqual(result.returncode, 100)
        self.assertEqual(len((self.folder / "log").read_text().splitlines()), 1)


@unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
class Blender(support.Folder):
    """What a real exporter writes, in the units and axes that it can be told to use."""
    SCRIPT = """
import bpy, sys
bpy.ops.wm.read_factory_settings(use_empty=True)
mesh = bpy.data.meshes.new("solid")
mesh.from_pydata([(0,0,0),(3,0,0),(0,2,0),(0,0,1)], [], [(0,2,1),(0,1,3),(0,3,2),(1,2,3)])
thing = bpy.data.objects.new("solid", mesh)
bpy.context.collection.objects.link(thing)
bpy.ops.preferences.addon_enable(module="io_scene_fbx")
out = sys.argv[-1]
bpy.ops.export_scene.fbx(filepath=out + "/cm.fbx")
bpy.ops.export_scene.fbx(filepath=out + "/m.fbx", apply_scale_options="FBX_SCALE_ALL")
bpy.ops.export_scene.fbx(filepath=out + "/z.fbx", axis_forward="Y", axis_up="Z", bake_space_transform=True)
"""

    def test_fbx(self):
        (self.folder / "make.py").write_text(self.SCRIPT)
        subprocess.run(["blender", "-b", "--python", self.folder / "make.py", "--", self.folder], cwd=self.folder, check=True,
                       capture_output=True, timeout=120)
        for name in ("cm", "m", "z"):
            self.bake_well(f"{name}.fbx", "--size", "9", "--report", "r.json")
            chart = json.loads(self.run_program(support.INFO, f"{name}.dgm", "--json").stdout)["files"][0]["charts"][0]
            for value, wanted in zip(chart["bbox"], (0, 0, -2, 3, 1, 0)):
                self.assertAlmostEqual(value, wanted, delta=0.3, msg=name)
            remarks = " ".join(self.report_of("r.json").get("remarks", []))
            self.assertEqual("scaled by 0.01 to metres" in remarks, name != "m", remarks)
            self.assertEqual("turned to y up" in remarks, name == "z", remarks)

    def report_of(self, name):
        return json.loads((self.folder / name).read_text())["assets"][0]["report"]


if __name__ == "__main__":
    unittest.main()
