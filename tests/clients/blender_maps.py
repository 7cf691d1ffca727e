# SPDX-License-Identifier: GPL-3.0-or-later
"""Inside Blender: opens EXR files and lists their passes; displaces a grid by a position map.

    blender -b --factory-startup --python blender_maps.py -- JOB.json RESULT.json

JOB: {"list": [FILE...], "displace": [{"map": FILE, "vertices": [[x, y, z], ...]}]}. RESULT: {"passes": {FILE: [[layer,
pass, channels], ...]}, "displaced": {FILE: largest distance}}. A file is written to RESULT before Blender is let at it,
so that a crash shows which one it was.
"""
import json
import sys

import bpy
import mathutils


def passes_of(path):
    """A multi-layer file's passes, as the compositor offers them; a plain picture is one called "Image"."""
    image = bpy.data.images.load(path)
    tree = bpy.context.scene.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("CompositorNodeImage")
    node.image = image
    found = []
    if not node.has_layers:
        found = [["", out.name, out.type] for out in node.outputs if out.enabled]
    else:
        # The layers' names are known to the property alone, which tells them when it is set to a wrong one.
        try:
            node.layer = "\0"
        except TypeError as error:
            names = str(error).split("(", 1)[1].rsplit(")", 1)[0]
        for layer in [name.strip().strip("'\"") for name in names.split(", ")]:
            node.layer = layer
            found += [[layer, out.name, out.type] for out in node.outputs if out.enabled]
    bpy.data.images.remove(image)
    return found


def displaced(path, vertices):
    """The largest distance of a displaced grid's vertices from those given, in the order of the map's pixels."""
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    pixels = list(image.pixels)
    mesh = bpy.data.meshes.new("grid")
    mesh.from_pydata([(0, 0, 0)] * (width * height), [], [])
    for y in range(height):
        for x in range(width):
            first = ((height - 1 - y) * width + x) * 4  # Blender's rows go up
            mesh.vertices[y * width + x].co = pixels[first:first + 3]
    return max((v.co - mathutils.Vector(to)).length for v, to in zip(mesh.vertices, vertices, strict=True))


def main():
    job, result = sys.argv[sys.argv.index("--") + 1:]
    with open(job, encoding="utf-8") as file:
        work = json.load(file)
    bpy.context.scene.use_nodes = True
    out = {"passes": {}, "displaced": {}, "at": ""}

    def save():
        with open(result, "w", encoding="utf-8") as file:
            json.dump(out, file)

    for path in work["list"]:
        out["at"] = path
        save()
        out["passes"][path] = passes_of(path)
    for entry in work["displace"]:
        out["at"] = entry["map"]
        save()
        out["displaced"][entry["map"]] = displaced(entry["map"], entry["vertices"])
    out["at"] = ""
    save()


main()
