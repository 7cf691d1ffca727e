# SPDX-License-Identifier: GPL-3.0-or-later
"""The npm package of the runtime: its types, in Node beside the native runtime, and its three.js example in a browser.
Needs node and its packages three and typescript (node_packages.py); is skipped, and says why, without them."""
import base64
import functools
import http.server
import json
import os
import random
import re
import subprocess
import sys
import tarfile
import tempfile
import threading
import time
import unittest
from pathlib import Path

import numpy

import browser_pipe
import node_packages
import support

ROOT = Path(__file__).resolve().parents[2]
REFERENCE = os.environ.get("DGM_TOUCH_REFERENCE", "")
PATHS = Path(os.environ.get("DGM_PATHS", ""))
MOST_BYTES = 160_000

# In Node: what stdin asks for, as JSON.
ASK = """
import { readFileSync } from "node:fs";
import { load, DgmError } from "libdgm";
const folder = process.argv[2], asked = JSON.parse(readFileSync(0, "utf8"));
const dgm = await load(readFileSync(folder + "/node_modules/libdgm/dgm.wasm")), bytes = readFileSync(folder + "/stomach.dgm");
const codes = (calls) => calls.map((call) => { try { call(); return "OK"; } catch (e) { return e instanceof DgmError ? e.code : String(e); } });
const asset = dgm.open(bytes), chart = asset.charts[0], state = asset.state(0), out = {};
out.chart = chart, out.samples = state.sampleCount, out.triangles = [1, 4].map((s) => state.indices(s).length / 3);
out.geometry = asset.layer(0, "geometry").shape, out.none = asset.layer(0, "nothing");
asset.close();  // the state stays
out.picks = asked.rays.map((r) => state.pick(r.slice(0, 3), r.slice(3)))
  .map((hit) => hit && [...hit.corners, ...hit.barycentric, hit.distance]);
const kernel = dgm.kernel({ reach: 45, sigma: 405 }), f = Math.fround, step = f(f(4.5) / 45);
for (let k = 0; k < asked.ticks.length; k += 100) {
  const batch = asked.ticks.slice(k, k + 100);
  // A batch is of one kind; another one begins a new call.
  for (let a = 0; a < batch.length;) {
    let b = a;
    while (b < batch.length && batch[b][0] === batch[a][0]) ++b;
    const positions = batch.slice(a, b).flatMap((t) => t.slice(1).map((p, c) => f(p) - f(chart.offset[c])));
    state.tick(kernel, { dMax: 5, fMax: 3, footprint: "geodesic", step }, [{ kind: batch[a][0] === "away" ? "touch" : batch[a][0], lifted: batch[a][0] === "away", positions }], b - a);
    a = b;
  }
}
out.shape = Buffer.concat(state.positions.map((p) => Buffer.from(p.buffer, p.byteOffset, p.byteLength))).toString("base64");
state.release(), state.updateNormals(), state.changed(), out.nothing = state.changed().length;
const before = state.positions.map((p) => p.slice());
const felt = state.tick(kernel, { dMax: 2, step }, [{ kind: "grasp", positions: [before[0][0], before[1][0], before[2][0], before[0][0] + 1, before[1][0], before[2][0]] }], 2);
out.held = [felt.tools[0].holding, state.copies(felt.tools[0].contact).length > 1, felt.tools[0].forces.length];
const ranges = state.changed(), listed = new Set(), grid = state.rows * state.cols;
for (const { first, columns, rows } of ranges) for (let r = 0; r < rows; ++r) for (let c = 0; c < columns; ++c) listed.add(first + (first < grid ? r * state.cols : 0) + c);
const moved = Array.from(before[0].keys()).filter((s) => state.positions.some((p, k) => p[s] !== before[k][s]));
out.changed = [moved.length, moved.every((s) => listed.has(s)), listed.size];
state.reset(), out.volume = state.volume();
const low = Math.min(...state.positions[2]);
out.contact = state.contact({ kind: "plane", point: [0, 0, low + 0.5], normal: [0, 0, 1] });
state.relax(.1, Infinity), out.active = state.activeSamples;
const again = dgm.open(new Uint8Array(bytes).buffer), other = again.state(0);
out.met = state.contact({ kind: "surface", state: other, point: [14, 0, 0] }).status;
const flipped = Uint8Array.from(bytes);
flipped[bytes.length >> 1] ^= 1;
out.codes = codes([() => dgm.open(new Uint8Array(99)), () => dgm.open(bytes.subarray(0, bytes.length >> 1)), () => dgm.open(flipped),
  () => dgm.open(flipped, { verify: false }).close(), () => again.state(7), () => again.state(0, { maxReach: 5000 }), () => dgm.kernel({ reach: 0, sigma: 1 }),
  () => state.tick(kernel, {}, []), () => state.tick(kernel, { dMax: 1, footprint: "round" }, []), () => state.tick(kernel, { dMax: 1 }, [{ positions: [0, NaN, 0] }]),
  () => state.pick([0, 0, NaN], [1, 0, 0]), () => state.pick([0, 0, 0], [0, 0, 0]), () => asset.charts, () => { other.close(); other.positions; }]);
const start = dgm.bytes;
for (let k = 0; k < 50; ++k) { const a = dgm.open(bytes), s = a.state(0); s.contact({ kind: "sphere", point: [0, 0, 0], radius: 1 }); s.indices(); s.close(), a.close(); }
out.grown = dgm.bytes - start;
console.log(JSON.stringify(out));
"""
TYPED = """
import { load, DgmError, Runtime, Asset, State, Kernel, RayHit, TickReport, ContactReport } from "libdgm";
const dgm: Runtime = await load(), asset: Asset = dgm.open(new ArrayBuffer(8), { verify: false });
const state: State = asset.state(0, { maxReach: 12 }), kernel: Kernel = dgm.kernel({ reach: 12, sigma: 30, end: "printed" });
const hit: RayHit | null = state.pick([0, 0, 0], [0, 0, 1]);
const report: TickReport = state.tick(kernel, { dMax: 1, mode: "plastic" }, [{ kind: "poke", positions: hit!.point }]);
const contact: ContactReport = state.contact({ kind: "capsule", point: [0, 0, 0], end: [1, 0, 0], radius: 1 });
const numbers: number[] = [report.tools[0].force[0], contact.volumeError, state.positions[0][0], asset.charts[0].rows];
export { numbers, DgmError };
"""
WRONG = ("state.tick(kernel, {}, [])", "state.contact({ kind: 'sphere', point: [0, 0, 0] })", "state.tick(kernel, { dMax: 1, mode: 'soft' }, [])")


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


class WebPackage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="dgm-web-package-")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = Path(holder.name)
        source = Path(support.SAMPLES) / "stomach" / "stomach.obj"
        cls.run_well(support.BAKE, source, "--size", "65", "--precision", "u16", "-o", cls.folder / "stomach.dgm", "-q", "--progress", "none")
        cls.tgz = cls.make(cls.folder / "made")
        with tarfile.open(cls.tgz) as archive:
            archive.extractall(cls.folder)
        (cls.folder / "node_modules").mkdir()
        (cls.folder / "package").rename(cls.folder / "node_modules" / "libdgm")
        cls.package = cls.folder / "node_modules" / "libdgm"

    @classmethod
    def run_well(cls, *arguments, **more):
        done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, timeout=600, check=False, **more)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    @classmethod
    def make(cls, out):
        cls.run_well(ROOT / "scripts/web-package", out)
        return next(out.glob("libdgm-*.tgz"))

    def test_is_small_and_the_same_every_time(self):
        self.assertLessEqual(self.tgz.stat().st_size, MOST_BYTES)
        self.assertEqual(self.make(self.folder / "again").read_bytes(), self.tgz.read_bytes())
        names = sorted(str(p.relative_to(self.package)) for p in self.package.rglob("*") if p.is_file())
        self.assertEqual(names, ["LICENSE", "README.md", "dgm.wasm", "example/index.html", "example/three.js", "index.d.ts", "index.js", "package.json"])
        facts = json.loads((self.package / "package.json").read_text())
        self.assertEqual((facts["license"], f"libdgm-{facts['version']}.tgz"), ("MIT", self.tgz.name))

    def test_types_are_those_of_the_module(self):
        root = subprocess.run(["node", "-p", "require.resolve('typescript/lib/tsc.js')"], capture_output=True, text=True, check=True).stdout.strip()
        (self.folder / "tsconfig.json").write_text(json.dumps({"compilerOptions": {
            "strict": True, "noEmit": True, "target": "es2022", "module": "nodenext", "moduleResolution": "nodenext",
            "lib": ["es2022", "dom"], "types": []}, "files": ["user.mts"]}))
        for wrong in ("", *WRONG):
            (self.folder / "user.mts").write_text(TYPED + wrong)
            done = subprocess.run(["node", root, "-p", self.folder], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode == 0, not wrong, (wrong, done.stdout))
        # What has a type is there, and what is there has one.
        script = """import * as m from "libdgm";
            console.log(JSON.stringify(Object.fromEntries(["Runtime", "Asset", "State"].map((n) => [n, Object.getOwnPropertyNames(m[n].prototype)]))))"""
        (self.folder / "names.mjs").write_text(script)
        there = json.loads(self.run_well("node", self.folder / "names.mjs"))
        types = (self.package / "index.d.ts").read_text()
        fields = set(re.findall(r"readonly (\w+)", types[types.index("interface ChartInfo"):types.index("interface Layer")]))
        for name, names in there.items():
            body = re.search(rf"export class {name} .*?\n}}", types, re.S)[0]
            typed = set(re.findall(r"^  (?:readonly )?(\w+)[(:]", body, re.M)) - {"constructor", "close"}
            self.assertEqual({n for n in names if not n.startswith("_")} - {"constructor"}, typed - (fields if name == "State" else set()))

    def test_in_node_it_is_the_native_runtime(self):
        draw, rays = random.Random(6), []
        for _ in range(400):
            o = [draw.uniform(-30, 30) for _ in range(3)]
            rays.append([float(numpy.float32(x)) for x in o + [draw.uniform(-8, 8) - x for x in o]])
        native = self.run_well(REFERENCE, self.folder / "stomach.dgm", "picks", input="\n".join(" ".join(map(repr, r)) for r in rays)).splitlines()
        path = PATHS / "stomach_press_and_pull.txt"
        ticks = self.run_well(REFERENCE, self.folder / "stomach.dgm", "ticks", path).splitlines()
        (self.folder / "ask.mjs").write_text(ASK)
        asked = {"rays": rays, "ticks": [[t.split()[0], *map(float, t.split()[1:])] for t in ticks]}
        out = json.loads(self.run_well("node", self.folder / "ask.mjs", self.folder, input=json.dumps(asked)))
        self.assertEqual((out["chart"]["rows"], out["chart"]["cols"], out["chart"]["domain"], out["samples"]), (65, 65, "square", 65 * 65))
        self.assertEqual((out["geometry"], out["none"], out["triangles"][0]), ([65, 65, 3], None, 2 * 64 * 64))
        self.assertLess(out["triangles"][1], 2 * 64 * 64 / 8)
        for line, hit in zip(native, out["picks"], strict=True):
            wanted = None if line == "none" else [float(w) for w in line.split()]
            self.assertEqual(hit and [numpy.float32(h) for h in hit], wanted and [numpy.float32(w) for w in wanted])
        self.run_well(REFERENCE, self.folder / "stomach.dgm", "replay", path, self.folder / "shape.bin")
        self.assertEqual(base64.b64decode(out["shape"]), (self.folder / "shape.bin").read_bytes())
        self.assertEqual((out["nothing"], out["held"]), (0, [True, True, 6]))
        moved, all_listed, listed = out["changed"]
        self.assertTrue(moved > 10 and all_listed and listed < 65 * 65 / 2, out["changed"])
        self.assertGreater(out["volume"], 0)
        self.assertEqual((out["contact"]["status"], out["contact"]["volumeKept"]), ("contact", True))
        self.assertLess(abs(out["contact"]["volumeError"]), 1e-6)
        self.assertEqual((out["active"], out["met"]), (0, "contact"))
        self.assertEqual(out["codes"], ["NOT_DGM", "TRUNCATED", "HASH_MISMATCH", "OK", "BAD_ARGUMENT", "BAD_ARGUMENT", "BAD_ARGUMENT",
                                        "BAD_ARGUMENT", "BAD_ARGUMENT", "BAD_ARGUMENT", "BAD_ARGUMENT", "BAD_ARGUMENT", "BAD_ARGUMENT", "BAD_ARGUMENT"])
        self.assertLess(out["grown"], 4 << 20)  # two of fifty

    def test_three_js_draws_what_is_pressed(self):
        example = self.package / "example"
        (example / "map.dgm").write_bytes((self.folder / "stomach.dgm").read_bytes())
        three = subprocess.run(["node", "-p", "require.resolve('three')"], capture_output=True, text=True, check=True).stdout.strip()
        if not (example / "three").exists():
            (example / "three").symlink_to(Path(three).parents[1])
        self.assertLessEqual(len((example / "three.js").read_text().splitlines()), 40)
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=self.package))
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        page = self.enterContext(browser_pipe.opened(offline=False))
        page.call("Page.navigate", url=f"http://127.0.0.1:{server.server_address[1]}/example/index.html")
        page.wait("document.querySelector('canvas') && document.readyState === 'complete'")
        time.sleep(.5)
        rest = page.shot().astype(int)
        self.assertGreater(int(numpy.ptp(rest)), 100)
        # In the middle of the widest row of the surface; the background is black.
        there = rest.max(axis=2) > 40
        y = int(there.sum(axis=1).argmax())
        spot = int(numpy.median(numpy.flatnonzero(there[y]))), y
        page.mouse("mousePressed", *spot)
        moved = numpy.zeros(0)
        for _ in range(40):
            time.sleep(.2)
            moved = numpy.argwhere(numpy.abs(page.shot().astype(int) - rest).max(axis=2) > 12)
            if len(moved) > 300:
                break
        self.assertGreater(len(moved), 300)
        self.assertLess(float(numpy.hypot(moved[:, 1] - spot[0], moved[:, 0] - spot[1]).max()), 250)
        page.mouse("mouseReleased", *spot)
        for _ in range(100):
            if numpy.array_equal(page.shot().astype(int), rest):
                break
            time.sleep(.2)
        numpy.testing.assert_array_equal(page.shot().astype(int), rest)
        self.assertEqual([line for line in page.console if "asked for http://127.0.0.1" not in line], [])


if __name__ == "__main__":
    reason = node_packages.missing("three", "typescript")
    if reason:
        print("skipped:", reason)
        sys.exit(77)
    unittest.main()
