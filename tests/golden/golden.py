# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking the samples at 129 x 129 and picking from the report what golden.json keeps."""
import hashlib
import json
import platform
import subprocess
import tempfile
from pathlib import Path

FILE = Path(__file__).resolve().parent / "golden.json"
HASHES = Path(__file__).resolve().parent / "hashes.json"
HASH_SIZE = "33x33"
SIZE = "129x129"
# method: samples. `auto` bakes all of them in one batch; the others keep an eye on one closed and one open mesh.
CASES = {
    "auto": ["stomach/stomach.obj", "stomach/stomach.3ds", "liver/liver.obj", "cushion/cushion.obj",
             "cushion/cover.obj", "sheet/sheet.obj", "chair/seat.obj", "chair/back.obj", "chair/chair.obj"],
    "stretch": ["stomach/stomach.obj", "cushion/cover.obj"],
    "sphere": ["stomach/stomach.obj", "liver/liver.obj"],
    "mvc": ["stomach/stomach.obj", "cushion/cover.obj"],
    "authalic": ["stomach/stomach.obj", "cushion/cover.obj"],
    "conformal": ["stomach/stomach.obj", "cushion/cover.obj"],
    "tutte": ["stomach/stomach.obj", "cushion/cover.obj"],
    "lscm": ["stomach/stomach.obj", "cushion/cover.obj"],
    "arap": ["stomach/stomach.obj", "cushion/cover.obj"],
    "slim": ["stomach/stomach.obj", "cushion/cover.obj"],
    "uv": ["cushion/cushion.obj", "cushion/cover.obj"],
}
TOPOLOGY = ("components", "boundary_loops", "genus", "manifold", "oriented")


def chart_values(chart):
    """The numbers of one chart that are compared."""
    error, distortion = chart["error"], chart["map"]
    return {
        "method": chart["method"], "domain": chart["domain"], "size": f"{chart['rows']}x{chart['cols']}",
        "psnr": round(error["psnr"], 3), "max_percent": round(error["hausdorff_percent"], 5),
        "stretch_l2": round(distortion["stretch_l2"], 5), "stretch_linf": round(distortion["stretch_linf"], 4),
        "flips": distortion["flips"], "degenerate": distortion["degenerate"], "seam_gap": chart["seam_gap"],
        "source_topology": {key: chart["source_topology"][key] for key in TOPOLOGY},
        "map_topology": {key: chart["map_topology"][key] for key in TOPOLOGY},
    }


def measure(bake, samples, method):
    """Bakes the samples of one method. {name: [chart values], or the code it was refused with}

    Raises RuntimeError with the messages if anything else happens.
    """
    with tempfile.TemporaryDirectory(prefix="dgm-golden-") as folder:
        report = Path(folder) / "report.json"
        meshes = [Path(samples) / name for name in CASES[method]]
        result = subprocess.run([bake, *meshes, "-o", f"{folder}/", "--size", SIZE, "--method", method, "-q",
                                 "--report", report], capture_output=True, text=True, check=False)
        if result.returncode not in (0, 3):
            raise RuntimeError(f"{method}: exit code {result.returncode}\n{result.stdout}{result.stderr}")
        assets = json.loads(report.read_text(encoding="utf-8"))["assets"]
    root = Path(samples).resolve()
    return {Path(asset["source"]).resolve().relative_to(root).as_posix():
            asset["error"]["code"] if "error" in asset else [chart_values(chart) for chart in asset["report"]["charts"]]
            for asset in assets}


def this_platform():
    """What the bytes of a bake may depend on: the compiler, with its standard library. The processor's instructions and
    the C library decide none (tests/exact)."""
    gcc = subprocess.run(["c++", "-dumpfullversion"], capture_output=True, text=True, check=False).stdout.strip()
    return f"{platform.machine()} c++ {gcc}"


def hashes(bake, samples):
    """{sample: SHA-256 of its .dgm at HASH_SIZE}"""
    with tempfile.TemporaryDirectory(prefix="dgm-hashes-") as folder:
        out = {}
        for name in CASES["auto"]:
            file = Path(folder) / "x.dgm"
            subprocess.run([bake, Path(samples) / name, "-o", file, "--size", HASH_SIZE, "-q"], check=True)
            out[name] = hashlib.sha256(file.read_bytes()).hexdigest()
    return out
