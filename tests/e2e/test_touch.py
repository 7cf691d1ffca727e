# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages to touch, in a real browser without a window or a network: mouse, fingers, keys; beside the runtime itself."""
import base64
import json
import os
import random
import re
import subprocess
import tempfile
import time
import unittest
import zlib
from pathlib import Path

import numpy

import browser_pipe
import meshes
import support

REFERENCE = os.environ.get("DGM_TOUCH_REFERENCE", "")
PATHS = Path(os.environ.get("DGM_PATHS", ""))
SCREENSHOTS = Path(os.environ.get("DGM_SCREENSHOTS", "screenshots"))
MIDDLE = (480, 300)  # on the stomach's body, in a page of 1000 x 700
BESIDE = (100, 100)
STAGE = (0, 0, 732, 700)  # left of the panel
MOST_MODULE, MOST_BLANK = 346_000, 250_000
MAP, PAGE = "stomach.dgm", "stomach.html"


def run(*arguments, **more):
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, timeout=600, check=False, **more)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def elements(page):
    """(attributes, text) of each element of data."""
    return re.findall(r'<script type="text/plain" ([^>]*)>([^<]*)</script>', page.read_text(encoding="utf-8"))


def imports(module):
    """True if a WebAssembly module has a section of imports."""
    at = 8
    while at < len(module):
        kind, at = module[at], at + 1
        size = shift = 0
        while True:
            byte, at = module[at], at + 1
            size |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                break
        if kind == 2:
            return True
        at += size
    return False


class Touch(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory(prefix="dgm-touch-")
        cls.addClassCleanup(cls.holder.cleanup)
        cls.folder = Path(cls.holder.name)
        source = Path(support.SAMPLES) / "stomach" / "stomach.obj"
        run(support.BAKE, source, "--size", "65", "--precision", "u16", "-o", cls.folder / MAP, "-q", "--progress", "none")
        run(support.EXPORT, cls.folder / MAP, "--up", "z", "-o", cls.folder / PAGE)

    def page(self, fragment="", name=PAGE, **more):
        page = self.enterContext(browser_pipe.opened(**more))
        page.open(self.folder / name, fragment)
        self.addCleanup(lambda: self.assertEqual(page.console, []))
        return page

    def hold(self, page, at, seconds=.8):
        page.mouse("mouseMoved", *at, buttons=0)
        page.mouse("mousePressed", *at)
        page.wait("dgmPage.hand.strokes.length === 1 && dgmPage.hand.strokes[0].holding")  # a tick has run
        time.sleep(seconds)

    def let_go(self, page, at):
        page.mouse("mouseReleased", *at)
        page.mouse("mouseMoved", *BESIDE, buttons=0)
        page.rest()

    def places(self, page, first=""):
        """x, y, z of all samples, as bits, after `first`, before another frame lets them spring back."""
        text = page.run(f"(() => {{ {first}; return" + """ (() => { const out = dgmPage.bodies[0].copy().map((a) => new Uint8Array(a.buffer));
            return out.map((b) => btoa(Array.from(b, (c) => String.fromCharCode(c)).join(""))); })(); })()""")
        return numpy.array([numpy.frombuffer(base64.b64decode(t), numpy.float32) for t in text])

    def test_is_one_small_file(self):
        data = elements(self.folder / PAGE)
        module = next(zlib.decompress(base64.b64decode(text)) for names, text in data if 'id="module"' in names)
        self.assertLessEqual(len(module), MOST_MODULE)
        self.assertFalse(imports(module))
        carried = sum(len(text) for names, text in data if 'id="module"' not in names)
        self.assertLessEqual((self.folder / PAGE).stat().st_size - carried, MOST_BLANK)
        self.assertIn("MIT licence", (self.folder / PAGE).read_text(encoding="utf-8"))
        run(support.EXPORT, self.folder / MAP, "--up", "z", "-o", self.folder / "again" / PAGE)
        self.assertEqual((self.folder / "again" / PAGE).read_bytes(), (self.folder / PAGE).read_bytes())

    def test_blank_page_takes_what_is_dropped(self):
        run(support.EXPORT, "--blank", "-o", self.folder / "blank.html")
        self.assertLessEqual((self.folder / "blank.html").stat().st_size, MOST_BLANK)
        page = self.page(name="blank.html")
        self.assertEqual(page.run("dgmPage.bodies.length"), 0)
        for key in ("Tab", "ArrowLeft", " "):
            page.key(key)
        page.mouse("mousePressed", *MIDDLE)
        page.mouse("mouseReleased", *MIDDLE)
        page.run(f"""(async () => {{ const bytes = Uint8Array.from(atob({json.dumps(base64.b64encode((self.folder / MAP).read_bytes()).decode())}), (c) => c.charCodeAt(0));
            await dgmPage.drop.take([new File([bytes], 'good.dgm')]); }})()""")
        page.rest()
        self.assertEqual(page.run("[dgmPage.bodies.length, document.getElementById('message').hidden, document.getElementById('drop').hidden]"),
                         [1, True, True])
        for wrong in (("--blank", self.folder / MAP, "-o", "x.html"), ("--blank", "-o", "x.glb"), ("--blank",)):
            done = subprocess.run([support.EXPORT, *map(str, wrong)], capture_output=True, text=True, check=False, cwd=self.folder)
            self.assertEqual((done.returncode, "DGM6001" in done.stderr), (1, True))

    def test_names_cannot_become_markup(self):
        odd = self.folder / "a\"><b>&'.dgm"
        odd.write_bytes((self.folder / MAP).read_bytes())
        run(support.EXPORT, odd, self.folder / MAP, "-o", self.folder / "odd.html")
        page = self.page(name="odd.html")
        self.assertEqual(page.run("[...document.getElementById('map').options].map((o) => o.text)"), ["a\"><b>&'", "stomach"])
        page.run("(() => { const map = document.getElementById('map'); map.value = '1'; map.dispatchEvent(new Event('change')); })()")
        page.wait("dgmPage.number === 1")

    def test_press_moves_the_picture_near_the_finger_and_release_gives_it_back(self):
        page = self.page("#size=60")
        page.run("dgmPage.soft = false")  # all triangles and pixels while it moves, too
        page.rest()
        rest, bits = page.shot(clip=STAGE), self.places(page)
        self.assertGreater(int(numpy.ptp(rest.astype(int))), 100)
        self.hold(page, MIDDLE)
        page.shot(SCREENSHOTS / "touch_light.png")
        pressed = page.shot(clip=STAGE)
        self.assertEqual(page.run("dgmPage.bodies[0].torn()"), 0)
        self.assertGreater(page.run("dgmPage.hand.felt.force"), 0)
        self.assertRegex(page.run("document.getElementById('force').textContent"), r"^[\d.]+ % of the limit, jumps up to [\d.e-]+ % a tick\n\d+ ticks of ")
        where = numpy.argwhere(numpy.abs(rest.astype(int) - pressed).max(axis=2) > 24)
        far = numpy.hypot(where[:, 1] - MIDDLE[0], where[:, 0] - MIDDLE[1])
        self.assertGreater(len(far), 200)
        self.assertLess(float(far.max()), 200)
        self.let_go(page, MIDDLE)
        numpy.testing.assert_array_equal(self.places(page), bits)
        numpy.testing.assert_array_equal(page.shot(clip=STAGE), rest)
        self.assertEqual(page.run("dgmPage.bodies[0].torn()"), 0)

    def test_nothing_is_uploaded_at_rest(self):
        page = self.page()
        page.rest()
        before = page.run("dgmPage.painter.uploaded")
        # Nor is the surface drawn while the pointer only goes over it.
        frames = page.run("dgmPage.frames")
        for k in range(5):
            page.mouse("mouseMoved", MIDDLE[0] + k, MIDDLE[1], buttons=0)
        page.wait("document.getElementById('readout').textContent && !dgmPage.waiting")
        self.assertEqual(page.run("dgmPage.frames"), frames)
        page.run("dgmPage.camera.turn(.3, 0); dgmPage.wake()")
        page.wait("!dgmPage.waiting")
        self.assertEqual(page.run("dgmPage.painter.uploaded"), before)
        self.hold(page, MIDDLE, 0)
        page.wait(f"dgmPage.painter.uploaded > {before}")
        self.let_go(page, MIDDLE)

    def test_picks_what_the_runtime_picks(self):
        draw, rays = random.Random(5), []
        for _ in range(1500):
            o = [draw.uniform(-30, 30) for _ in range(3)]
            d = [draw.uniform(-8, 8) - x for x in o]
            rays.append([float(numpy.float32(x)) for x in o + d])
        native = run(REFERENCE, self.folder / MAP, "picks", input="\n".join(" ".join(map(repr, r)) for r in rays)).splitlines()
        page = self.page()
        seen = page.run(f"""{json.dumps(rays)}.map((r) => dgmPage.bodies[0].pickLocal(r.slice(0, 3), r.slice(3)))
            .map((hit) => hit && [...hit.corners, ...hit.weights, hit.distance])""")
        self.assertGreaterEqual(sum(hit is not None for hit in seen), 200)
        for line, hit in zip(native, seen):
            if line == "none":
                self.assertIsNone(hit)
                continue
            wanted = [float(w) for w in line.split()]
            self.assertEqual(wanted[:3], hit[:3])
            self.assertEqual([numpy.float32(w) for w in wanted[3:]], [numpy.float32(h) for h in hit[3:]])

    def replayed_alike(self, page, path, settings="dgmPage.recorder.settings"):
        """Runs a path here and natively: positions, of which every bit is the same."""
        run(REFERENCE, self.folder / MAP, "replay", path, self.folder / "shape.bin")
        native = numpy.fromfile(self.folder / "shape.bin", numpy.float32).reshape(3, -1)
        page.run("dgmPage.hand.reset()")
        places = self.places(page, f"""dgmPage.recorder.load({json.dumps(path.read_text(encoding="utf-8"))});
            dgmPage.recorder.replay(dgmPage.bodies[0], dgmPage.recorder.knots, {settings})""")
        numpy.testing.assert_array_equal(places.view(numpy.uint32), native.view(numpy.uint32), path.name)
        return places

    def test_replays_every_sample_path_to_the_bit(self):
        page = self.page()
        rest = self.places(page)
        moved = {}
        for path in sorted(PATHS.glob("*.txt")):
            ends = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
            for lines in range(2, len(ends) + 1):  # up to each of its lines, since the last one lets go
                part = self.folder / path.name
                part.write_text("\n".join(ends[:lines]) + "\n", encoding="utf-8")
                places = self.replayed_alike(page, part, "{ mode: 0, d_max: 5, f_max: 3, step: Math.fround(Math.fround(4.5) / 45), grasp: 0, relax: 0 }")
                moved[path.stem] = max(moved.get(path.stem, 0), float(numpy.abs(places - rest).max()))
        self.assertIn("stomach_two_fingers", moved)
        for name in ("stomach_press_and_pull", "stomach_two_fingers", "body_in_cloth"):
            self.assertGreater(moved[name], 1, name)

    def test_strokes_that_stay_are_taken_back_one_by_one(self):
        page = self.page()
        page.rest()
        rest = self.places(page)
        page.run("document.getElementById('lasting').checked = true")
        shapes = []
        for at in (MIDDLE, (430, 470)):
            self.hold(page, at, .4)
            self.let_go(page, at)
            shapes.append(self.places(page))
        self.assertTrue((shapes[0] != rest).any() and (shapes[1] != shapes[0]).any())
        page.run("document.getElementById('undo').click()")
        numpy.testing.assert_array_equal(self.places(page), shapes[0])
        page.run("document.getElementById('undo').click()")
        numpy.testing.assert_array_equal(self.places(page), rest)
        self.assertTrue(page.run("document.getElementById('undo').disabled"))

    def test_pulls_after_the_pointer_and_records_it(self):
        page = self.page("#tool=pull&size=60")
        self.hold(page, (345, 170), .1)
        for k in range(8):
            page.mouse("mouseMoved", 345 - 12 * k, 170 - 6 * k)
        page.wait("dgmPage.hand.strokes[0].moved && Math.hypot(...dgmPage.hand.strokes[0].moved) > dgmPage.size() / 2")
        page.shot(SCREENSHOTS / "touch_pull.png")
        self.let_go(page, (261, 128))
        text = page.run("dgmPage.recorder.text()")
        self.assertRegex(text, r"(?m)^\d+\.\d{3} \S+ \S+ \S+ grasp$")
        self.assertTrue(text.rstrip().endswith("away"))
        place = " ".join(re.search(r"(?m)^\d+\.\d{3} (\S+ \S+ \S+) grasp$", text)[1].split())
        # Nine ticks of a millisecond end a rounding error after 0.009 s.
        for played in (text, f"0.000 {place} grasp\n0.009 {place} grasp\n"):
            page.run(f"dgmPage.recorder.load({json.dumps(played)}); dgmPage.recorder.play()")
            page.wait("!dgmPage.recorder.playing")
        page.rest()

    def test_push_on_a_thin_limb_stays_on_its_side(self):
        page = self.page("#size=58&depth=60")
        self.hold(page, (362, 190))
        self.assertGreater(page.run("dgmPage.hand.felt.force"), 0)
        depth = page.run("(() => { const s = dgmPage.hand.strokes[0]; return s.moved.reduce((t, m, c) => t + m * s.normal[c], 0); })()")
        self.assertLess(depth, 0)
        self.let_go(page, (362, 190))

    # Presses, pulls and pokes at each place given, for 50 frames that take no time; says where that does not move the place as far as
    # it was asked, moves seam copies apart, or does not end at rest.
    EVERYWHERE = """((places, reaches) => {
      dgmPage.wake = () => {};
      const [body] = dgmPage.bodies, { hand, diagonal } = dgmPage, plus = (a, b, s) => a.map((x, c) => x + s * b[c]), dot = (a, b) => a.reduce((sum, x, c) => sum + x * b[c], 0);
      const bits = () => body.copy().map((array) => new Uint32Array(array.buffer).reduce((h, x) => Math.imul(h, 31) + x | 0, 0)).join();
      const rest = bits(), wrong = [];
      let tried = 0;
      for (const s of places) {
        const n = body.normalAt(s), hit = body.pickLocal(plus(body.place(s), n, .02 * diagonal), n.map((x) => -x));
        for (const [size, depth] of hit ? reaches : [])
          for (const [kind, invert] of [["push", false], ["push", true], ["poke", false], ["poke", true], ["pull", false]]) {
            const far = depth * size * diagonal, stroke = hand.begin(hit, kind, { size: size * diagonal, depth: far, lasting: false, invert });
            if (kind === "pull") stroke.pull = hit.normal.map((x) => x * far);
            for (let frame = 0; frame < 50; ++frame) hand.advance(1 / 60);
            const c = hit.sample, moved = body.place(c).map((x, k) => x - body.base[k][c]), wanted = (kind === "pull" || stroke.outward ? 1 : -1) * Math.min(far, stroke.most);
            const done = Math.max(...[moved, stroke.moved].map((way) => dot(way, stroke.normal) / wanted));
            ++tried;
            if (!(done > .35 && done < 1.3) || body.torn()) wrong.push([s, kind, invert, size, done]);
            hand.reset();
            if (bits() !== rest) wrong.push([s, kind, invert, size, "not at rest"]);
          }
      }
      return [tried, wrong]; })(%s, %s)"""

    def test_tools_work_at_seams_tips_and_limbs(self):
        page = self.page()
        page.rest()
        # Along the grid's border, which is the seam; the ends along the axes; and at random.
        rest, draw, side = self.places(page), random.Random(3), 65
        at = {*range(0, side, 4), *range((side - 1) * side, side * side, 4), *range(0, side * side, 4 * side), *range(side - 1, side * side, 4 * side)}
        at |= {int(k) for row in rest for k in (row.argmin(), row.argmax())} | {draw.randrange(side * side) for _ in range(40)}
        tried, wrong = page.run(self.EVERYWHERE % (sorted(at), [[.03, 1], [.08, 1.2], [.2, 1.2]]))
        self.assertGreater(tried, 1200)
        self.assertEqual(wrong, [])

    def test_control_turns_a_push_outwards(self):
        page = self.page()
        depth = []
        for modifiers in (0, 2):
            page.mouse("mousePressed", *MIDDLE, modifiers=modifiers)
            page.wait("dgmPage.hand.strokes.length === 1 && dgmPage.hand.strokes[0].holding")
            time.sleep(.5)
            depth.append(page.run("(() => { const s = dgmPage.hand.strokes[0]; return s.moved.reduce((t, m, c) => t + m * s.normal[c], 0); })()"))
            self.let_go(page, MIDDLE)
        self.assertLess(depth[0], 0)
        self.assertGreater(depth[1], 0)

    def test_table_keeps_the_volume(self):
        page = self.page()
        page.run("""document.getElementById('obstacle').value = 'plane'; document.getElementById('height').value = 400;
            document.getElementById('height').dispatchEvent(new Event('input'))""")
        words = page.wait("document.getElementById('volume').textContent")
        kept = re.search(r"kept to (\S+) of (\S+) pressed in", words)
        self.assertLess(float(kept[1]), 1e-6)
        self.assertGreater(float(kept[2]), 0)
        page.shot(SCREENSHOTS / "touch_table.png")
        rest = page.run("dgmPage.bodies[0].torn()")
        self.assertEqual(rest, 0)

    def test_size_and_depth_by_dragging(self):
        page = self.page()
        page.mouse("mouseMoved", *MIDDLE, buttons=0)
        page.wait("dgmPage.keys.hover")
        for key, value in (("f", "dgmPage.size()"), ("F", "dgmPage.panel.depth()")):
            before, other = page.run(value), page.run("document.getElementById('depth').value")
            page.key(key, "KeyF")
            page.mouse("mouseMoved", MIDDLE[0] + 60, MIDDLE[1], buttons=0)
            page.wait(f"{value} > {1.2 * before}")
            if key == "f":
                self.assertEqual(page.run("document.getElementById('depth').value"), other)
                page.shot(SCREENSHOTS / "touch_size.png")
                page.mouse("mousePressed", *MIDDLE)  # ends it, and presses nothing
                page.mouse("mouseReleased", *MIDDLE)
                page.mouse("mouseMoved", *MIDDLE, buttons=0)
                self.assertGreater(page.run(value), 1.2 * before)
                self.assertEqual(page.run("dgmPage.hand.history.length"), 0)
            else:
                page.key("Escape")  # gives back what was
                self.assertEqual(page.run(value), before)
        page.mouse("mouseMoved", *BESIDE, buttons=0)
        page.key("f", "KeyF")
        self.assertEqual(page.run("document.activeElement.id"), "size")

    def test_obstacles_anywhere(self):
        page = self.page()
        page.run("""document.getElementById('obstacle').value = 'ball'; document.getElementById('height').value = 300;
            document.getElementById('height').dispatchEvent(new Event('input'))""")
        page.wait("dgmPage.obstacle && !dgmPage.meetAgain")
        x, y = page.run("dgmPage.camera.project(dgmPage.obstacle.p, dgmPage.aspect())")[:2]
        at = ((x + 1) / 2 * STAGE[2], (1 - y) / 2 * STAGE[3])
        before = page.run("dgmPage.obstacle.p")
        page.mouse("mouseMoved", *at, buttons=0)
        page.mouse("mousePressed", *at)
        page.mouse("mouseMoved", at[0] + 80, at[1] + 40)
        page.mouse("mouseReleased", at[0] + 80, at[1] + 40)
        self.assertEqual(page.run("dgmPage.hand.strokes.length"), 0)
        after = page.run("dgmPage.camera.project(dgmPage.obstacle.p, dgmPage.aspect())")
        # It went with the pointer: by less than a sixth of its way off, as it is held nearer to the eye than its middle is.
        way = numpy.array([(after[0] - x) / 2 * STAGE[2], (y - after[1]) / 2 * STAGE[3]])
        self.assertLess(float(numpy.abs(way - [80, 40]).max()), 14)
        self.assertGreater(float(numpy.linalg.norm(numpy.subtract(page.run("dgmPage.obstacle.p"), before))), 1)
        words = page.wait("document.getElementById('volume').textContent")
        self.assertRegex(words, "samples moved|too deep|^$")
        page.run("""document.getElementById('obstacle').value = 'plane'; document.getElementById('lean').value = 300;
            document.getElementById('lean').dispatchEvent(new Event('input'))""")
        page.wait("!dgmPage.meetAgain")
        normal = page.run("dgmPage.obstacle.q")
        self.assertAlmostEqual(sum(c * c for c in normal), 1)
        self.assertAlmostEqual(normal[0], numpy.sin(.3 * numpy.pi / 2))
        kept = re.search(r"kept to (\S+) of", page.wait("document.getElementById('volume').textContent"))
        self.assertLess(float(kept[1]), 1e-6)
        page.shot(SCREENSHOTS / "touch_lean.png")
        self.assertEqual(page.run("dgmPage.bodies[0].torn()"), 0)

    def test_a_press_beside_an_obstacle_ends_when_it_is_let_go(self):
        page = self.page("#size=60")
        page.run("""document.getElementById('obstacle').value = 'plane'; document.getElementById('height').value = 200; dgmPage.setObstacle()""")
        page.wait("!dgmPage.meetAgain")
        page.rest()
        before = self.places(page)
        self.hold(page, MIDDLE, .4)
        self.assertGreater(float(numpy.abs(self.places(page) - before).max()), .1)
        self.let_go(page, MIDDLE)
        numpy.testing.assert_array_equal(self.places(page), before)

    def test_an_obstacle_that_goes_through_is_refused(self):
        page = self.page()
        rest = self.places(page)
        # A bar through the whole body, which would burst beside it; a table that swallows it; and a bar that only presses.
        for kind, height, lean, across, deep in (("capsule", 500, 0, 0, True), ("plane", 500, -1000, -500, True), ("capsule", 300, 0, 0, False)):
            page.run(f"""for (const [id, value] of [["obstacle", "{kind}"], ["height", {height}], ["lean", {lean}], ["across", {across}]]) document.getElementById(id).value = value;
                dgmPage.setObstacle()""")
            page.wait("!dgmPage.meetAgain")
            page.rest()
            words, places = page.run("document.getElementById('volume').textContent"), self.places(page)
            self.assertEqual(words == "too deep: it goes through", deep, words)
            self.assertEqual((places == rest).all(), deep)
            self.assertLess(float(numpy.linalg.norm(places - rest, axis=0).max()), .3 * page.run("dgmPage.diagonal"))

    def test_gamepads_shake_with_the_force(self):
        page = self.page()
        page.run("""window.felt = []; navigator.getGamepads = () => [null, { vibrationActuator: { playEffect: (kind, how) => {
            felt.push(how.weakMagnitude); return Promise.resolve(); } } }]; 1""")
        self.hold(page, MIDDLE, .2)
        page.wait("felt.length > 2")
        self.let_go(page, MIDDLE)
        felt = page.run("felt")
        self.assertGreater(len(felt), 1)
        self.assertGreater(max(felt), 0)
        self.assertLessEqual(max(felt), 1)
        self.assertEqual(page.run("(async () => { const n = felt.length; await new Promise((d) => setTimeout(d, 200)); return felt.length - n; })()"), 0)

    def test_free_domains_several_charts_smallest_and_large_grids(self):
        meshes.write_obj(self.folder / "sheet.obj", meshes.sheet(24))
        ball, faces = meshes.icosphere(2)
        two = [*ball, *((x + 3, y, z) for x, y, z in ball)], [*faces, *(tuple(v + len(ball) for v in f) for f in faces)]
        meshes.write_obj(self.folder / "two.obj", two)
        quick = ["--fit", "sample", "-q", "--progress", "none"]
        for name, mesh, *options in (("free", "sheet", "--method", "lscm", "--size", "33"), ("two", "two", "--size", "17"),
                                     ("least", "sheet", "--size", "3", "--method", "tutte"),
                                     ("large", "sheet", "--size", "513", "--method", "tutte")):
            run(support.BAKE, self.folder / f"{mesh}.obj", *options, *quick, "-o", self.folder / f"{name}.dgm")
        names = ("free", "two", "least", "large")
        run(support.EXPORT, *(self.folder / f"{name}.dgm" for name in names), "-o", self.folder / "many.html")
        page = self.page("#size=70", name="many.html")
        for number, name in enumerate(names):
            page.run(f"(async () => {{ await dgmPage.choose({number}); dgmPage.camera.set('.5,.9,1,0,0'); dgmPage.wake(); }})()")
            page.rest()
            charts, samples, free = page.run("[dgmPage.bodies.length, dgmPage.bodies[0].count, dgmPage.bodies[0].chart.free]")
            self.assertEqual((charts, free), (2 if name == "two" else 1, name == "free"))
            self.assertEqual(samples > 33 * 33 if free else samples in (17 * 17, 3 * 3, 513 * 513), True)
            for body in range(charts):
                rest = "dgmPage.bodies[%d].copy().map((a) => a.reduce((h, v, k) => h + v * (k %% 97 + 1), 0))" % body
                bits = page.run(rest)
                # A place of the surface that is seen, near the middle of the chart's own on the screen.
                at = page.run("""(() => { const seen = [];
                    for (let y = -18; y < 18; ++y) for (let x = -18; x < 18; ++x) { const hit = dgmPage.pick([x / 20, y / 20]);
                        if (hit && hit.body === dgmPage.bodies[%d]) seen.push([x / 20, y / 20]); }
                    const mean = [0, 1].map((c) => seen.reduce((sum, p) => sum + p[c], 0) / seen.length);
                    return seen.sort((p, q) => Math.hypot(p[0] - mean[0], p[1] - mean[1]) - Math.hypot(q[0] - mean[0], q[1] - mean[1]))[0]; })()""" % body)
                spot = ((at[0] + 1) / 2 * STAGE[2], (1 - at[1]) / 2 * STAGE[3])
                page.mouse("mouseMoved", *spot, buttons=0)
                page.mouse("mousePressed", *spot)
                page.wait("dgmPage.hand.felt.force > 0")
                self.assertEqual(page.run("dgmPage.hand.strokes[0].body.number"), body)
                self.assertEqual(page.run("dgmPage.bodies.map((body) => body.torn())"), [0] * charts, name)
                page.shot(SCREENSHOTS / f"touch_{name}.png")
                self.let_go(page, spot)
                self.assertEqual(page.run(rest), bits, name)

    # How far each sample moved from rest; of a body by its number.
    MOVED = """((k) => { const body = dgmPage.bodies[k], now = body.copy(); let most = 0;
        for (let s = 0; s < body.count; ++s) most = Math.max(most, Math.hypot(...now.map((a, c) => a[s] - body.rest[c][s])));
        return most; })(%d)"""
    # How deep samples of the cover are inside of the cushion: a ray along the normal comes out of it.
    SUNK = """(() => { const [cushion, cover] = dgmPage.bodies; let most = 0;
        for (let s = 0; s < cover.chart.rows * cover.chart.cols; s += 7) {
          const n = cover.normalAt(s), hit = cushion.pickLocal(minus3(plus3(cover.place(s), cover.origin), cushion.origin), n);
          if (hit && !hit.front) most = Math.max(most, hit.distance);
        }
        return most; })()"""

    def test_a_cushion_is_pressed_through_its_cover(self):
        for name in ("cushion", "cover"):
            run(support.BAKE, Path(support.SAMPLES) / "cushion" / f"{name}.obj", "--size", "65", "--fit", "sample", "-q", "--progress", "none",
                "-o", self.folder / f"{name}.dgm")
        pair = [self.folder / "cushion.dgm", self.folder / "cover.dgm"]
        run(support.EXPORT, *pair, "--cover", "--up", "z", "-o", self.folder / "pair.html")
        for wrong in ((pair[0], "--cover", "-o", "x.html"), (pair[0], "--cover", "-o", "x.glb"), ("--blank", "--cover", "-o", "x.html")):
            done = subprocess.run([support.EXPORT, *map(str, wrong)], capture_output=True, text=True, check=False, cwd=self.folder)
            self.assertEqual((done.returncode, "--cover" in done.stderr), (1, True), done.stderr)
        page = self.page("#size=70&depth=80&view=.5,.7,1,0,0", name="pair.html")
        page.run("window.minus3 = (a, b) => a.map((x, k) => x - b[k]), window.plus3 = (a, b) => a.map((x, k) => x + b[k]), 1")
        page.rest()
        self.assertEqual(page.run("[dgmPage.number, dgmPage.cover, document.getElementById('map').value, document.getElementById('cover').value]"), [0, 1, "0", "1"])
        # At rest the cover lies as it was made: no sample of it is taken for one inside of the cushion.
        page.run("dgmPage.meet(false)")
        self.assertLess(page.run(self.MOVED % 1), .005 * page.run("dgmPage.diagonal"))
        rest = page.shot(clip=STAGE)
        bits = page.run("dgmPage.bodies.map((b) => b.copy().map((a) => a.reduce((h, v, k) => h + v * (k % 97 + 1), 0)))")
        # The cover is what one sees, and takes up the pointer; what it lies on gives way as far.
        self.hold(page, (366, 330), 1)
        self.assertEqual(page.run("dgmPage.hand.strokes[0].body.map.name"), "cover")
        page.shot(SCREENSHOTS / "touch_cover.png")
        depth = page.run("dgmPage.panel.depth()")
        self.assertGreater(page.run(self.MOVED % 0), .5 * depth)
        self.assertLess(page.run(self.SUNK), .02 * page.run("dgmPage.diagonal"))
        self.assertEqual(page.run("dgmPage.bodies.map((b) => b.torn())"), [0, 0])
        self.let_go(page, (366, 330))
        self.assertEqual(page.run(self.MOVED % 0), 0)
        self.assertEqual(page.run("dgmPage.bodies.map((b) => b.copy().map((a) => a.reduce((h, v, k) => h + v * (k % 97 + 1), 0)))"), bits)
        numpy.testing.assert_array_equal(page.shot(clip=STAGE), rest)
        # A pull takes the cover alone.
        page.run("dgmPage.panel.choose('pull')")
        self.hold(page, (366, 330), .1)
        for k in range(6):
            page.mouse("mouseMoved", 366, 330 - 12 * k)
        page.wait(f"{self.MOVED % 1} > 3")
        self.assertLess(page.run(self.MOVED % 0), 1e-6)
        self.let_go(page, (366, 270))
        # A ball presses both, and the cushion keeps its volume.
        page.run("""document.getElementById('obstacle').value = 'ball'; document.getElementById('height').value = 300;
            document.getElementById('height').dispatchEvent(new Event('input'))""")
        page.rest()
        kept = re.search(r"kept to (\S+) of (\S+) pressed in", page.wait("document.getElementById('volume').textContent"))
        self.assertLess(float(kept[1]), 1e-6)
        self.assertGreater(min(page.run(self.MOVED % 0), page.run(self.MOVED % 1)), 1)
        page.shot(SCREENSHOTS / "touch_cover_ball.png")
        self.assertEqual(page.run("dgmPage.bodies.map((b) => b.torn())"), [0, 0])
        # Lasting strokes are taken back on both, to the bit; without the cover there is one body.
        page.run("document.getElementById('obstacle').value = 'none'; dgmPage.setObstacle(); dgmPage.panel.choose('push'); document.getElementById('lasting').checked = true")
        page.rest()
        self.hold(page, (366, 330), .4)
        self.let_go(page, (366, 330))
        self.assertGreater(min(page.run(self.MOVED % 0), page.run(self.MOVED % 1)), .1)
        page.run("document.getElementById('undo').click()")
        page.rest()
        self.assertEqual(page.run("dgmPage.bodies.map((b) => b.copy().map((a) => a.reduce((h, v, k) => h + v * (k % 97 + 1), 0)))"), bits)
        page.run("(() => { const cover = document.getElementById('cover'); cover.value = '-1'; cover.dispatchEvent(new Event('change')); })()")
        page.wait("dgmPage.bodies.length === 1")

    def test_fabrics_are_swapped(self):
        meshes.write_obj(self.folder / "bare.obj", meshes.sheet(8))
        run(support.BAKE, self.folder / "bare.obj", "--size", "17", "--fit", "sample", "-q", "--progress", "none", "-o", self.folder / "bare.dgm")
        source = Path(support.SAMPLES) / "stomach" / "stomach_denim.obj"
        run(support.BAKE, source, "--size", "33", "--fit", "sample", "-q", "--progress", "none", "-o", self.folder / "denim.dgm")
        run(support.EXPORT, *(self.folder / name for name in (MAP, "denim.dgm", "bare.dgm")), "--up", "z", "-o", self.folder / "fabrics.html")
        page = self.page("#size=60", name="fabrics.html")
        page.rest()
        self.assertEqual(page.run("[...document.getElementById('fabric').options].map((o) => o.text)"), ["its own", "stomach", "denim"])
        page.run("document.getElementById('lasting').checked = true")
        self.hold(page, MIDDLE, .4)
        self.let_go(page, MIDDLE)
        own, bits = page.shot(clip=STAGE).astype(int), self.places(page)
        put = "(() => { const f = document.getElementById('fabric'); f.value = '%d'; f.dispatchEvent(new Event('change')); })()"
        page.run(put % 1)
        page.wait("dgmPage.fabric === 1")
        page.rest()
        seen = page.shot(SCREENSHOTS / "touch_fabric.png", clip=STAGE).astype(int)
        # Red as flesh before, blue as denim now; what was pressed stays pressed.
        body = (slice(MIDDLE[1] - 100, MIDDLE[1] + 100), slice(MIDDLE[0] - 40, MIDDLE[0] + 40))
        self.assertGreater(float((own[body][..., 0] - own[body][..., 2]).mean()), 20)
        self.assertLess(float((seen[body][..., 0] - seen[body][..., 2]).mean()), -5)
        numpy.testing.assert_array_equal(self.places(page), bits)
        page.run("document.getElementById('link').click()")
        self.assertIn("&fabric=1", page.run("location.href"))
        page.run(put % -1)
        page.wait("dgmPage.fabric === -1")
        page.rest()
        numpy.testing.assert_array_equal(page.shot(clip=STAGE).astype(int), own)
        # A bare map wears what others have; a map that was dropped without a picture gives none, and says so.
        page.run("dgmPage.choose(2)")
        page.wait("dgmPage.number === 2 && document.getElementById('look').value === 'clay'")
        page.run(put % 0)
        page.wait("dgmPage.fabric === 0 && document.getElementById('look').value === 'texture'")
        page.run(f"""(async () => {{ const bytes = Uint8Array.from(atob({json.dumps(base64.b64encode((self.folder / "bare.dgm").read_bytes()).decode())}), (c) => c.charCodeAt(0));
            await dgmPage.drop.take([new File([bytes], 'none.dgm')]); await dgmPage.choose(0); }})()""")
        page.run(put % 3)
        self.assertIn("none has no picture", page.wait("!document.getElementById('message').hidden && document.getElementById('message').textContent"))
        self.assertEqual(page.run("[dgmPage.fabric, document.getElementById('fabric').value]"), [-1, "-1"])
        page = self.page("#map=0&fabric=1", name="fabrics.html")
        self.assertEqual(page.run("[dgmPage.fabric, document.getElementById('fabric').value]"), [1, "1"])

    def test_a_lost_card_is_made_good(self):
        page = self.page("#size=60")
        page.run("document.getElementById('lasting').checked = true; document.getElementById('obstacle').value = 'ball'; dgmPage.setObstacle()")
        self.hold(page, MIDDLE, .4)
        self.let_go(page, MIDDLE)
        picture, bits = page.shot(clip=STAGE), self.places(page)
        page.run("window.card = dgmPage.painter.gl.getExtension('WEBGL_lose_context'); card.loseContext()")
        page.wait("dgmPage.painter.gl.isContextLost()")
        # Pressed and taken back while nothing can be seen.
        page.mouse("mousePressed", *MIDDLE)
        page.wait("dgmPage.hand.strokes.length === 1 && dgmPage.hand.strokes[0].holding")
        page.mouse("mouseReleased", *MIDDLE)
        page.mouse("mouseMoved", *BESIDE, buttons=0)
        page.run("document.getElementById('undo').click()")
        page.run("card.restoreContext()")
        page.wait("!dgmPage.painter.gl.isContextLost() && dgmPage.bodies[0].picture")
        page.rest()
        numpy.testing.assert_array_equal(self.places(page), bits)
        numpy.testing.assert_array_equal(page.shot(clip=STAGE), picture)

    def test_lists_show_what_a_script_chooses(self):
        (self.folder / "second.dgm").write_bytes((self.folder / MAP).read_bytes())
        run(support.EXPORT, self.folder / MAP, self.folder / "second.dgm", "-o", self.folder / "lists.html")
        page = self.page(name="lists.html")
        page.run("dgmPage.choose(1)")
        self.assertEqual(page.run("document.getElementById('map').value"), "1")
        page.run("dgmPage.choose(0, 1)")
        self.assertEqual(page.run("[document.getElementById('map').value, document.getElementById('cover').value]"), ["0", "1"])

    def test_follows_an_address_that_changes(self):
        (self.folder / "second.dgm").write_bytes((self.folder / MAP).read_bytes())
        run(support.EXPORT, self.folder / MAP, self.folder / "second.dgm", "-o", self.folder / "address.html")
        page = self.page(name="address.html")
        shown = "[dgmPage.number, dgmPage.cover, dgmPage.fabric, Number(document.getElementById('map').value)].join()"
        for address, expected in (("#map=1&size=33", "1,-1,-1,1"), ("#cover=0", "1,0,-1,1"), ("#map=1&fabric=0", "1,-1,0,1"),
                                  ("#tool=pull", "1,-1,0,1"), ("#map=7&fabric=9", "1,-1,-1,1"), ("#map=0&fabric=1", "0,-1,1,0")):
            page.run(f"location.hash = '{address}'")
            page.wait(f"{shown} === '{expected}'")
        self.assertEqual(page.run("document.getElementById('size').value"), "33")
        self.assertTrue(page.run("document.querySelector('input[value=pull]').checked"))

    def test_physics_takes_unit_and_material_of_the_file(self):
        """In metres a body is a hundred times as far across as in centimetres, and no longer said to measure 15 cm."""
        forces = []
        for unit, material in (("cm", "tissue"), ("m", "tissue")):
            run(support.BAKE, Path(support.SAMPLES) / "stomach" / "stomach.obj", "--size", "33", "--unit", unit, "--material",
                material, "-o", self.folder / "unit.dgm", "-q", "--progress", "none", "--force")
            run(support.EXPORT, self.folder / "unit.dgm", "--up", "z", "-o", self.folder / "unit.html")
            page = self.page("#size=55&depth=80", name="unit.html")
            page.rest()
            page.run("(() => { const s = document.getElementById('solver'); s.value = 'physics'; s.dispatchEvent(new Event('change')); })()")
            page.wait("dgmPage.physics.on")
            self.assertTrue(page.run("dgmPage.physics.measured"))
            page.mouse("mouseMoved", *MIDDLE, buttons=0)
            page.mouse("mousePressed", *MIDDLE)
            page.wait("dgmPage.hand.strokes.length === 1 && dgmPage.hand.strokes[0].newtons > .01")
            # A body that is hit swings away from the ball and back: what counts is the largest force of the first second.
            largest, until = 0, time.monotonic() + 1
            while time.monotonic() < until:
                largest = max(largest, page.run("dgmPage.hand.strokes[0].newtons"))
            self.assertRegex(page.run("document.getElementById('force').textContent"), r"^[\d.e+]+ N\njumps")
            forces.append(largest)
        self.assertGreater(forces[1], 10 * forces[0])

    def test_physics_is_a_choice(self):
        page = self.page("#size=55&depth=80")
        page.rest()
        bits, rest = self.places(page), page.shot(clip=STAGE)
        solve = "(() => { const s = document.getElementById('solver'); s.value = '%s'; s.dispatchEvent(new Event('change')); })()"
        page.run(solve % "physics")
        page.wait("dgmPage.physics.on")
        page.mouse("mouseMoved", *MIDDLE, buttons=0)
        page.mouse("mousePressed", *MIDDLE)
        page.wait("dgmPage.hand.strokes.length === 1 && dgmPage.hand.strokes[0].newtons > .1")
        time.sleep(.5)
        words = page.run("[document.getElementById('force').textContent, document.getElementById('volume').textContent]")
        self.assertRegex(words[0], r"^[\d.]+ N, ")
        self.assertLess(float(re.match(r"volume kept to (\S+),", words[1])[1]), 1e-5)
        self.assertGreater(float(numpy.abs(self.places(page) - bits).max()), .1)
        self.assertEqual(page.run("dgmPage.bodies[0].torn()"), 0)
        page.shot(SCREENSHOTS / "touch_physics.png")
        self.let_go(page, MIDDLE)
        # It swings back to rest, and is there to the bit.
        numpy.testing.assert_array_equal(self.places(page), bits)
        numpy.testing.assert_array_equal(page.shot(clip=STAGE), rest)
        # A table lifts the body; touches take over where it is left.
        page.run("""document.getElementById('obstacle').value = 'plane'; document.getElementById('height').value = 400;
            document.getElementById('height').dispatchEvent(new Event('input'))""")
        page.wait("dgmPage.physics.most > 0 && !dgmPage.running")
        self.assertGreater(float(numpy.abs(self.places(page) - bits).max()), .1)
        page.run("document.getElementById('obstacle').value = 'none'; dgmPage.setObstacle(); " + solve % "touch")
        page.rest()
        numpy.testing.assert_array_equal(self.places(page), bits)
        # A free domain is refused, and stays with touches.
        meshes.write_obj(self.folder / "plain.obj", meshes.sheet(24))
        run(support.BAKE, self.folder / "plain.obj", "--method", "lscm", "--size", "33", "--fit", "sample", "-q", "--progress", "none", "-o", self.folder / "plain.dgm")
        run(support.EXPORT, self.folder / "plain.dgm", "-o", self.folder / "plain.html")
        page.open(self.folder / "plain.html")
        page.run(solve % "physics")
        page.wait("document.getElementById('message').dataset.code === 'UNSUPPORTED'")
        self.assertEqual(page.run("[dgmPage.physics.on, document.getElementById('solver').value]"), [False, "touch"])
        # So is one that is chosen while physics is on.
        run(support.EXPORT, self.folder / MAP, self.folder / "plain.dgm", "-o", self.folder / "mixed.html")
        page.open(self.folder / "mixed.html")
        page.run(solve % "physics")
        page.wait("dgmPage.physics.on")
        page.run("dgmPage.choose(1)")
        page.wait("document.getElementById('message').dataset.code === 'UNSUPPORTED'")
        self.assertEqual(page.run("[dgmPage.physics.on, dgmPage.number, document.getElementById('map').value]"), [False, 1, "1"])

    def test_damaged_files_are_refused_by_their_code(self):
        page = self.page()
        good = (self.folder / MAP).read_bytes()
        flipped = bytearray(good)
        flipped[len(good) // 2] ^= 1
        for bytes_, code in ((b"no map at all" * 99, "NOT_DGM"), (good[:len(good) // 2], "TRUNCATED"), (bytes(flipped), "HASH_MISMATCH"), (b"", "TRUNCATED")):
            page.run(f"""(async () => {{ const bytes = Uint8Array.from(atob({json.dumps(base64.b64encode(bytes_).decode())}), (c) => c.charCodeAt(0));
                document.getElementById('message').dataset.code = '';
                await dgmPage.drop.take([new File([bytes], 'x.dgm')]); }})()""")
            self.assertEqual(page.run("document.getElementById('message').dataset.code"), code)
        # The map from before is still there, and a good one is taken.
        self.hold(page, MIDDLE, .2)
        self.let_go(page, MIDDLE)
        page.run(f"""(async () => {{ const bytes = Uint8Array.from(atob({json.dumps(base64.b64encode(good).decode())}), (c) => c.charCodeAt(0));
            await dgmPage.drop.take([new File([bytes], 'good.dgm')]); }})()""")
        self.assertEqual(page.run("[dgmPage.number, document.getElementById('message').hidden]"), [1, True])

    def test_phone_with_two_fingers(self):
        page = self.page(size=(390, 800), phone=True, dark=True)
        self.assertLessEqual(page.run("document.documentElement.scrollWidth"), 390)
        first, second = self.two_places(page)
        page.touch("touchStart", [first])
        page.touch("touchStart", [first, second])
        page.wait("dgmPage.hand.strokes.length === 2 && dgmPage.hand.strokes.every((s) => s.holding)")
        page.shot(SCREENSHOTS / "touch_phone.png")
        page.touch("touchEnd", [])
        page.wait("dgmPage.hand.strokes.length === 0")
        zoom = page.run("dgmPage.camera.zoom")
        page.run("dgmPage.panel.choose('turn')")
        page.touch("touchStart", [(150, 200)])
        page.touch("touchStart", [(150, 200), (240, 200)])
        page.touch("touchMove", [(100, 200), (290, 200)])
        page.touch("touchEnd", [])
        self.assertGreater(page.run("dgmPage.camera.zoom"), 1.5 * zoom)
        page.rest()

    def test_keys_alone(self):
        page = self.page(dark=True)
        page.rest()
        bits = self.places(page)
        page.key("Tab")
        self.assertEqual(page.run("document.activeElement.id"), "view")
        for key in ("ArrowLeft", "ArrowDown", "ArrowDown"):
            page.key(key)
        self.assertRegex(page.run("document.getElementById('said').textContent"), r"^Row \d+, column \d+, at ")
        size = page.run("dgmPage.size()")
        page.key("]")
        self.assertGreater(page.run("dgmPage.size()"), size)
        page.key(" ", "Space", up=False)
        page.wait("dgmPage.hand.strokes.length === 1 && dgmPage.hand.felt.force > 0")
        page.shot(SCREENSHOTS / "touch_dark.png")
        page.key(" ", "Space", down=False)
        page.wait("dgmPage.hand.strokes.length === 0")
        page.key("p", "KeyP")
        page.key("p", "KeyP", up=False)
        page.wait("dgmPage.hand.strokes.length === 1")
        for _ in range(4):
            page.key("ArrowUp")
        page.wait("Math.hypot(...(dgmPage.hand.strokes[0].moved || [0])) > 0")
        page.key("Escape")
        page.wait("dgmPage.hand.strokes.length === 0")
        page.rest()
        numpy.testing.assert_array_equal(self.places(page), bits)

    def test_walks_across_seams(self):
        page = self.page()
        page.key("Tab")
        rows = set()
        for _ in range(200):
            page.key("ArrowRight")
            rows.add(page.run("dgmPage.keys.walker.i"))
        self.assertGreater(len(rows), 1)

    def test_layers_as_colour(self):
        run(support.EXPORT, "--blank", "-o", self.folder / "layers.html")
        page = self.page(name="layers.html")
        page.run(f"""(async () => {{ const bytes = Uint8Array.from(atob({json.dumps(base64.b64encode((self.folder / MAP).read_bytes()).decode())}), (c) => c.charCodeAt(0));
            await dgmPage.drop.take([new File([bytes], 'good.dgm')]); document.getElementById('up').click(); }})()""")
        names = page.run("[...document.getElementById('look').options].map((o) => o.value)")
        self.assertEqual(names, ["texture", "clay", "moved", "normal", "bump: height beyond the grid", "cover radius", "E: row step squared", "F",
                                 "G: column step squared", "stiffness", "area of a sample", "mobility", "diagonals"])
        colours = {}
        for name in ("clay", "area of a sample"):
            page.run(f"document.getElementById('look').value = {json.dumps(name)}; dgmPage.wake()")
            page.rest()
            colours[name] = page.shot(clip=STAGE)[MIDDLE[1] - 150:MIDDLE[1] + 150, MIDDLE[0] - 60:MIDDLE[0] + 60].astype(int)
        # Clay is redder than blue everywhere; an area is a place in viridis, from violet to green here.
        self.assertTrue((colours["clay"][..., 0] >= colours["clay"][..., 2]).all())
        self.assertGreater(float(numpy.std(colours["area of a sample"][..., 1] - colours["area of a sample"][..., 0])), 5)
        self.assertRegex(page.run("document.getElementById('said').textContent"), r"^area of a sample: \S+ \(dark\) to \S+ \(light\)$")

    def test_a_recorded_path_replays_natively_to_the_bit(self):
        page = self.page("#tool=pull&size=60")
        for at, tool, caption in (((345, 170), "pull", "pulled"), (MIDDLE, "push", "")):
            page.run(f"dgmPage.panel.choose('{tool}'); document.getElementById('words').value = '{caption}'")
            self.hold(page, at, .2)
            for k in range(6):
                page.mouse("mouseMoved", at[0] - 8 * k, at[1] - 4 * k)
            time.sleep(.2)
            self.let_go(page, (at[0] - 40, at[1] - 20))
        text = page.run("dgmPage.recorder.text()")
        self.assertRegex(text, r"(?m)^# Recorded by touch\. Size \S+, d_max \S+\.$")
        self.assertRegex(text, r"(?m)^\S+ \S+ \S+ \S+ grasp pulled$")
        # Up to the end of the pull, and all of it.
        lines = text.splitlines()
        grasps = [k for k, line in enumerate(lines) if " grasp" in line]
        for name, part in (("pull.txt", lines[:grasps[-1] + 1]), ("whole.txt", lines)):
            (self.folder / name).write_text("\n".join(part) + "\n")
            page.open(self.folder / PAGE)
            rest = self.places(page)
            places = self.replayed_alike(page, self.folder / name)
            if name == "pull.txt":
                self.assertGreater(float(numpy.abs(places - rest).max()), .1)

    def two_places(self, page):
        """Two places of the surface that are far apart on the screen, in pixels."""
        box = page.run("(() => { const b = document.getElementById('view').getBoundingClientRect(); return [b.width, b.height]; })()")
        spots = page.run("""(() => { const out = []; const n = 24;
            for (let y = 1; y < n; ++y) for (let x = 1; x < n; ++x) { const at = [2 * x / n - 1, 2 * y / n - 1]; if (dgmPage.pick(at)) out.push(at); }
            return out; })()""")
        pixels = [((x + 1) / 2 * box[0], (1 - y) / 2 * box[1]) for x, y in spots]
        return max(pixels, key=lambda p: p[0] - p[1]), min(pixels, key=lambda p: p[0] - p[1])

    def test_two_fingers_are_recorded_and_replay_natively_to_the_bit(self):
        page = self.page("#tool=pull&size=40", size=(390, 800), phone=True)
        first, second = self.two_places(page)
        held = "dgmPage.hand.strokes.length === {0} && dgmPage.hand.strokes.every((s) => s.holding)"
        page.touch("touchStart", [first])
        page.wait(held.format(1))
        page.touch("touchStart", [first, second])
        page.wait(held.format(2))
        for k in range(6):
            page.touch("touchMove", [(first[0] + 6 * k, first[1] - 4 * k), (second[0] - 6 * k, second[1] + 4 * k)])
            time.sleep(.05)
        # The first finger goes, and comes back while the second one stays.
        page.run("dgmPage.keys.up({ pointerId: [...dgmPage.keys.pointers.keys()][0] })")
        page.wait(held.format(1))
        time.sleep(.1)
        page.run(f"dgmPage.keys.down(new PointerEvent('pointerdown', {{ pointerId: 77, clientX: {first[0]}, clientY: {first[1]}, button: 0 }}))")
        page.wait(held.format(2))
        time.sleep(.1)
        page.run("dgmPage.keys.up({ pointerId: 77 })")
        page.touch("touchEnd", [])
        page.wait("dgmPage.hand.strokes.length === 0")
        text = page.run("dgmPage.recorder.text()")
        lines = [line.split() for line in text.splitlines() if not line.startswith("#")]
        kinds = [line[4] for line in lines]
        self.assertEqual((kinds.count("away"), kinds.count("away:2")), (2, 1))
        self.assertGreater(min(kinds.count("grasp"), kinds.count("grasp:2")), 5)
        times = [float(line[0]) for line in lines]
        self.assertEqual(times, sorted(times))
        # While both pull, and all of it.
        for name, part in (("both.txt", range(kinds.index("away") + 2)), ("all.txt", range(len(lines) + 2))):
            (self.folder / name).write_text("\n".join(text.splitlines()[k] for k in part) + "\n")
            page.open(self.folder / PAGE)
            rest = self.places(page)
            places = self.replayed_alike(page, self.folder / name)
            if name == "both.txt":
                moved = numpy.linalg.norm(places - rest, axis=0)
                ends = [numpy.array([float(c) for c in next(l for l in lines if l[4] == kind)[1:4]]) for kind in ("grasp", "grasp:2")]
                offset = numpy.array(page.run("dgmPage.bodies[0].chart.offset")).reshape(3, 1)
                for end in ends:  # both were pulled
                    near = numpy.linalg.norm(rest + offset - end.reshape(3, 1), axis=0).argmin()
                    self.assertGreater(float(moved[near]), .05)
        # The text of a path that was opened is that path.
        self.assertEqual(page.run(f"(() => {{ dgmPage.recorder.load({json.dumps(text)}); return dgmPage.recorder.text(); }})()"), text)

    def test_broken_paths_are_refused_by_name(self):
        page = self.page()
        good = "0 1 2 3 touch\n0.5 1 2 3 grasp:2\n"
        for line, why in (("0.6 1 2 3 grasp:5", "touch:2 and so on"), ("0.6 1 2 3 grasp:", "touch:2 and so on"), ("0.5 1 2 4 grasp:2", "increase"),
                          ("0.4 1 2 4 touch", "go back"), ("0.6 1 2 grasp:2", "SECONDS X Y Z")):
            bad = self.folder / "bad_strokes.txt"
            bad.write_text(good + line + "\n")
            page.run(f"dgmPage.drop.take([new File([{json.dumps(bad.read_text())}], 'bad_strokes.txt')])")
            said = page.wait("!document.getElementById('message').hidden && document.getElementById('message').textContent")
            self.assertIn("Line 3: ", said)
            self.assertIn(why, said)
            page.run("document.getElementById('message').hidden = true")
            done = subprocess.run([support.EXPORT, self.folder / MAP, "--path", bad, "-o", self.folder / "x.html"], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, "bad_strokes.txt:3" in done.stderr), (1, True), done.stderr)

    def test_plays_paths_that_were_put_into_it(self):
        liver = self.folder / "liver_press_and_pull.txt"
        liver.write_bytes((PATHS / liver.name).read_bytes())
        run(support.EXPORT, self.folder / MAP, "--up", "z", "--path", PATHS / "stomach_press_and_pull.txt", "--path", PATHS / "table.txt",
            "-o", self.folder / "paths.html")
        page = self.page(name="paths.html")
        self.assertEqual(page.run("[...document.getElementById('paths').options].map((o) => o.text)"),
                         ["what was recorded here", "stomach press and pull", "table"])
        page.run("(() => { const paths = document.getElementById('paths'); paths.value = '0'; paths.dispatchEvent(new Event('change')); })()")
        page.wait("!document.getElementById('play').disabled")
        page.run("document.getElementById('play').click()")
        for caption in ("at rest", "pressed at the greater curvature"):
            page.wait(f"document.getElementById('caption').textContent === {json.dumps(caption)} && !document.getElementById('caption').hidden")
        page.shot(SCREENSHOTS / "touch_path.png")
        page.run("dgmPage.recorder.stop(); dgmPage.wake()")
        page.rest()
        (self.folder / "bad.txt").write_text("0 1 2 three grasp\n")
        for more, code in ((("--path", self.folder / "bad.txt", "-o", "x.html"), 1), (("--path", liver, "-o", "x.glb"), 1),
                           (("--path", self.folder / "none.txt", "-o", "x.html"), 2)):
            done = subprocess.run([support.EXPORT, self.folder / MAP, *map(str, more)], capture_output=True, text=True, check=False, cwd=self.folder)
            self.assertEqual(done.returncode, code, done.stderr)

    def test_the_map_is_beside_the_surface(self):
        page = self.page()
        page.run("document.getElementById('sheet').click()")
        page.rest()
        left, bottom, side = page.run("dgmPage.sheet.box()")
        draw = random.Random(9)
        for _ in range(20):
            u, v = draw.uniform(.02, .98), draw.uniform(.02, .98)
            at = (left + side * u, 700 - bottom - side * (1 - v))
            hit = page.run(f"""(() => {{ const hit = dgmPage.pick([2 * {at[0]} / dgmPage.canvas.clientWidth - 1, 1 - 2 * {at[1]} / 700]);
                const back = dgmPage.bodies[0].pickLocal(hit.point.map((p, d) => p + .01 * hit.normal[d]), hit.normal.map((n) => -n));
                return [hit.row, hit.column, hit.weights.reduce((a, b) => a + b), dgmPage.sheet.place(hit), back.corners, hit.corners]; }})()""")
            # Rows go down, columns to the right; a ray onto the place finds the same triangle.
            self.assertEqual(hit[:2], [int(v * 64), int(u * 64)])
            self.assertAlmostEqual(hit[2], 1, 6)
            self.assertLess(max(abs(a - b) for a, b in zip(hit[3], at)), 1e-6)
            self.assertEqual(sorted(hit[4]), sorted(hit[5]))
        rest = page.shot(clip=STAGE).astype(int)
        at = (left + side // 2, 700 - bottom - side // 2)
        self.hold(page, at, .5)
        page.shot(SCREENSHOTS / "touch_sheet.png")
        self.assertGreater(page.run("dgmPage.hand.felt.force"), 0)
        self.let_go(page, at)
        numpy.testing.assert_array_equal(page.shot(clip=STAGE).astype(int), rest)

    def test_link_opens_the_same_view(self):
        page = self.page("#view=1.2,-0.4,1.5,0.1,0&tool=poke&size=30&look=clay")
        self.assertEqual(page.run("[dgmPage.camera.text(), dgmPage.panel.tool(), document.getElementById('look').value]"),
                         ["1.2,-0.4,1.5,0.1,0", "poke", "clay"])
        page.run("document.getElementById('link').click()")
        self.assertIn("#view=1.2,-0.4,1.5,0.1,0&tool=poke&size=30", page.run("location.href"))

    def test_still_picture_without_webgl(self):
        page = self.page(arguments=("--disable-3d-apis",))
        self.assertEqual(page.run("document.body.dataset.ready"), "still")
        page.wait("document.getElementById('still').complete && document.getElementById('still').naturalWidth > 100")


if __name__ == "__main__":
    unittest.main()
