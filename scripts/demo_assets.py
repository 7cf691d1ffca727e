# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes the samples at 257 x 257, validates and draws them, replays the paper's figures on them, and prints what came
out. Called by scripts/demo.

    demo_assets.py BUILD OUT
"""
import json
import subprocess
import sys
from pathlib import Path

SAMPLES = ("stomach/stomach.obj", "stomach/stomach.3ds", "liver/liver.obj", "cushion/cushion.obj", "cushion/cover.obj",
           "sheet/sheet.obj", "chair/seat.obj", "chair/back.obj", "chair/chair.obj")
SIZE = "257x257"
# Maps that only the figures need: name, mesh, options.
DRESSED = (("stomach_denim", "stomach/stomach_denim.obj", "--texture-size", "1024x1024"),
           ("stomach_satin", "stomach/stomach_satin.obj", "--texture-size", "1024x1024"),
           ("cushion_129", "cushion/cushion.obj", "--size", "129x129", "--texture-size", "513x513"),
           ("liver_65", "liver/liver.obj", "--size", "65x65", "--unit", "cm", "--material", "tissue"),
           ("stomach_65", "stomach/stomach.obj", "--size", "65x65", "--unit", "cm", "--material", "tissue"),
           ("sheet_65", "sheet/sheet.obj", "--size", "65x65", "--domain", "square", "--unit", "cm"),
           ("skirt", "skirt/skirt.obj", "--size", "33x129", "--fit", "sample", "--unit", "cm", "--texture-size", "1024x1024"),
           ("cover_129", "cushion/cover.obj", "--size", "129x129", "--texture-size", "513x513"))
# Picture, program, map, recorded path, further maps.
FIGURES = (("fig11_stomach", "press_and_pull", "stomach", "stomach_press_and_pull"),
           ("fig11_liver", "press_and_pull", "liver", "liver_press_and_pull"),
           ("physics_liver", "poke_and_let_go", "liver_65", "liver_poke_and_let_go"),
           ("physics_swing", "swing_organ", "stomach_65", "stomach_swung"),
           ("physics_table", "lay_on_table", "stomach_65", "stomach_on_table"),
           ("fig12_plane", "set_on_plane", "stomach", "table"),
           ("fig13_14_cloth", "swap_cloth", "stomach_denim", "body_in_cloth", "stomach_denim", "stomach_satin"),
           ("fig15_16_sheet", "pinch_sheet", "sheet", "sheet_pinch"),
           ("fig17_seat", "sit_on_cushion", "seat", "ball_on_seat"),
           ("fig17_cover", "sit_on_cushion", "cushion_129", "ball_on_cushion", "cover_129"))
# Sheets that fall: picture, sheet, body, further arguments.
DRAPES = (("cloth_cushion", "sheet_65", "cushion_129"), ("cloth_seat", "sheet_65", "seat", "40"))
PATHS = Path(__file__).resolve().parent.parent / "samples/paths"
# Pages to touch: name and maps; the first one is shown first.
PAGES = (("organs", "stomach", "liver"), ("fabrics", "stomach", "stomach_denim", "stomach_satin"),
         ("cushion_and_cover", "cushion_129", "cover_129"), ("sheet", "sheet"), ("chair", "chair", "seat", "back"))
COLUMNS = ("asset", "method", "grid", "PSNR dB", "max error %", "seam gap", "flips", "time s", "bytes", "valid")


def say(text):
    print(text, flush=True)


def run(program, *arguments):
    """Runs a tool with its messages on our terminal; its exit code."""
    return subprocess.run([program, *map(str, arguments)], stdin=subprocess.DEVNULL, check=False).returncode


def up_axis(mesh):
    """The samples are z-up; the importer turns 3DS, which is z-up by definition, to y-up."""
    return "y" if mesh.suffix == ".3ds" else "z"


def joined(values):
    """"a" for a, a; "a + b" for a, b: the charts of one asset."""
    return " + ".join(dict.fromkeys(values))


def row(asset, valid):
    """One line of the table."""
    name = "/".join(Path(asset["source"]).parts[-2:])
    if "error" in asset:
        return (name, "refused: " + asset["error"]["code"]) + ("-",) * (len(COLUMNS) - 2)
    report, charts = asset["report"], asset["report"]["charts"]
    return (name, joined(c["method"] for c in charts), joined(f"{c['rows']}x{c['cols']}" for c in charts),
            f"{report['error']['psnr']:.1f}", f"{report['error']['hausdorff_percent']:.4f}",
            f"{max(c['seam_gap'] for c in charts):g}", str(sum(c["map"]["flips"] for c in charts)),
            f"{asset['seconds']:.1f}", str(sum(f["bytes"] for f in asset["files"])), "yes" if valid else "NO")


def print_table(rows):
    """Columns as wide as they need to be; numbers to the right."""
    rows = [COLUMNS, *rows]
    widths = [max(len(r[k]) for r in rows) for k in range(len(COLUMNS))]
    for r in rows:
        say("  ".join(cell.ljust(w) if k < 3 else cell.rjust(w) for k, (cell, w) in enumerate(zip(r, widths))).rstrip())


def map_of(name, out):
    """A map of the demo; those that only figures need are in a folder of their own."""
    own = out / "figures" / f"{name}.dgm"
    return own if own.exists() else out / f"{name}.dgm"


def write_pages(export, out):
    """Writes PAGES into OUT/touch; the first exit code that is not 0."""
    (out / "touch").mkdir(exist_ok=True)
    worst = 0
    for name, *maps in PAGES:
        # Recorded strokes of these maps: the page plays them.
        strokes = [("--path", path) for m in maps for path in sorted(PATHS.glob(f"{m}_*.txt"))]
        cover = ["--cover"] if name == "cushion_and_cover" else []
        code = run(export, *(map_of(m, out) for m in maps), *cover, *(word for pair in strokes for word in pair), "--up", "z",
                   "-o", out / "touch" / f"{name}.html")
        worst = worst or code
    return worst


def replay_figures(build, bake, out):
    """Draws FIGURES into OUT/figures; the first exit code that is not 0."""
    folder = out / "figures"
    folder.mkdir(exist_ok=True)
    worst = 0
    for name, mesh, *options in DRESSED:
        code = run(bake, "-q", build / "samples/meshes" / mesh, "-o", folder / f"{name}.dgm", *options)
        worst = worst or code

    for picture, program, name, path, *more in FIGURES:
        code = run(build / "samples" / program, map_of(name, out), PATHS / f"{path}.txt", folder / f"{picture}.png",
                   *(map_of(m, out) for m in more))
        worst = worst or code
    for picture, sheet, body, *more in DRAPES:
        code = run(build / "samples/drape_cloth", map_of(sheet, out), map_of(body, out), folder / f"{picture}.png", *more)
        worst = worst or code
    code = run(build / "samples/walk_in_skirt", map_of("skirt", out), folder / "cloth_skirt.png")
    return worst or code


def main(build, out):
    tools = {name: build / "cli" / name / f"dgm-{name}" for name in ("bake", "validate", "export")}
    out.mkdir(parents=True, exist_ok=True)
    meshes = [build / "samples/meshes" / name for name in SAMPLES]
    report = out / "report.json"

    say(f"demo: 3/7 bake {len(meshes)} samples at {SIZE}")
    report.unlink(missing_ok=True)
    worst = run(tools["bake"], *meshes, "-o", f"{out}/", "--size", SIZE, "--report", report)
    if not report.exists():
        return worst or 4
    assets = json.loads(report.read_text(encoding="utf-8"))["assets"]

    say("demo: 4/7 validate each against its source")
    valid, pictures = {}, []
    baked = [(Path(a["source"]), Path(a["files"][0]["path"])) for a in assets if a["files"]]
    for mesh, file in baked:
        code = run(tools["validate"], file, "--source", mesh)
        valid[str(mesh)] = code == 0
        worst = worst or code

    say("demo: 5/7 draw")
    for mesh, file in baked:
        compared, layers = file.with_suffix(".png"), file.with_suffix(".layers.png")
        beside = ("-o", compared, "--source", mesh, "--size", "1600x440")
        for options in (beside, ("-o", layers, "--sheet")):
            code = run(tools["export"], file, *options, "--up", up_axis(mesh))
            worst = worst or code
        pictures += [compared, layers]

    say("demo: 6/7 replay the paper's figures from recorded tool paths")
    worst = worst or replay_figures(build, tools["bake"], out)

    say("demo: 7/7 write pages to touch")
    worst = worst or write_pages(tools["export"], out)

    say("")
    print_table([row(asset, valid.get(asset["source"], False)) for asset in assets])
    say(f"\nmaps and pictures: {out}")
    say("  NAME.png         source | reconstruction | grid and seam | error")
    say("  NAME.layers.png  every layer of every chart")
    say("  figures/         what the programs in samples/ do with them")
    say("  touch/           pages: open one in a browser, and press")
    say(f"  report.json      all that was measured\nnext: {tools['bake']} --help")
    return worst


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()))
