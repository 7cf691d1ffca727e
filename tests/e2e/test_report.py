# SPDX-License-Identifier: GPL-3.0-or-later
"""The HTML report as its reader meets it: in a browser, from disk."""
import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import browser_pipe
import meshes
import numpy
import support
from browser import browser, read_png, run_browser

SIZE = ["--size", "33", "--method", "stretch", "--fit", "sample"]
SCREENSHOTS = os.environ.get("DGM_SCREENSHOTS", "")
# The software renderer: the same pictures on every machine.
WEBGL = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
FRAME = "document.getElementById('touch')."
EVIL = "b<img src=x onerror=alert(1)>&\"'.obj"
TIMES = re.compile(r"<!-- of this run: times -->.*?<!-- end of this run -->", re.S)


def complaints(console):
    """The messages of the page itself: taking the picture stalls the software renderer, which remarks on it."""
    return [line for line in console if "GPU stall due to ReadPixels" not in line]


class Report(support.Folder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.holder = tempfile.TemporaryDirectory(prefix="dgm-report-")
        cls.addClassCleanup(cls.holder.cleanup)

    def bake_three(self, *more, program=None):
        (self.folder / "in" / "deep").mkdir(parents=True, exist_ok=True)
        meshes.write_obj(self.folder / "in" / "ball.obj", meshes.icosphere(3))
        meshes.write_obj(self.folder / "in" / "deep" / EVIL, meshes.sheet(16))
        meshes.write_obj(self.folder / "in" / "band.obj", meshes.line())
        result = self.bake("in", "-o", "out/", *SIZE, "--report", "out/index.html", *more, program=program)
        self.assertEqual(result.returncode, 3, result.stderr)
        return result

    def three(self):
        """As bake_three(), baked once for all tests that only look at it."""
        kept = Path(Report.holder.name)
        if not (kept / "out").exists():
            self.bake_three()
            for name in ("in", "out"):
                shutil.copytree(self.folder / name, kept / name)
        else:
            shutil.copytree(kept, self.folder, dirs_exist_ok=True)

    def pages(self):
        return sorted((self.folder / "out" / "assets").iterdir())

    def picture(self, page, name, *arguments, fragment="", size=(1240, 1100)):
        path = self.folder / f"{name}.png"
        _, console = run_browser(page, f"--screenshot={path}", f"--window-size={size[0]},{size[1]}", *WEBGL, *arguments,
                                 fragment=fragment)
        self.assertEqual(complaints(console), [])
        if SCREENSHOTS:
            os.makedirs(SCREENSHOTS, exist_ok=True)
            shutil.copy(path, Path(SCREENSHOTS) / f"{name}.png")
        return path

    def pixels(self, *arguments, **more):
        return read_png(self.picture(*arguments, **more).read_bytes()).astype(int)

    def dom(self, page, *arguments):
        dom, console = run_browser(page, "--dump-dom", *WEBGL, *arguments)
        self.assertEqual(complaints(console), [])
        return dom

    def test_index_and_pages_in_a_browser(self):
        self.three()
        index = self.folder / "out" / "index.html"
        dom = self.dom(index)
        self.assertIn("<h3>band.obj: refused</h3>", dom)
        self.assertIn("<b>DGM3001</b>", dom)
        self.assertLess(dom.index("band.obj: refused"), dom.index("<table class=\"assets\""))
        report = json.loads(re.search(r'id="report" class="run">([^<]*)<', dom).group(1))
        self.assertEqual(report["summary"]["baked"], 2)
        self.assertEqual(len(self.pages()), 2)
        for link in re.findall(r'<a href="([^"]+)"', dom):
            self.assertTrue((index.parent / link).is_file(), link)
        self.assertEqual(len(re.findall(r'src="data:image/jpeg', dom)), 4)
        for thumbnail in re.findall(r'src="(data:image/jpeg[^"]+)', dom):
            self.assertLess(len(thumbnail), 15_000)
        for page in self.pages():
            self.assertLess(page.stat().st_size, 2 << 20)
            page_dom = self.dom(page)
            self.assertRegex(page_dom, r'<iframe id="touch" title="[^"]+" srcdoc="')
            self.assertRegex(page_dom, r"dgm-bake '?in/.* -o '?out/.* --size 33x33 --method stretch --fit sample")
            for heading in ("Touch it", "Error and distortion in the map", "Layers", "Measures", "Charts", "Repaired",
                            "Bake it again", "Times"):
                self.assertIn(f"<h2>{heading}</h2>", page_dom)
            links = re.findall(r'(?:src|href)="([^"]+)"', page_dom)
            self.assertEqual([u for u in links if not u.startswith("data:")], ["../index.html"])
            for block in re.findall(r'<script type="application/json" id="[^"]+">([^<]*)<', page_dom):
                json.loads(block)

    def test_pictures_are_not_blank(self):
        self.three()
        index = self.folder / "out" / "index.html"
        dark = "--blink-settings=preferredColorScheme=0"
        light_corner, dark_corner = (self.pixels(index, f"index-{name}", *more, size=(800, 300))[3, 3].max()
                                     for name, more in (("light", []), ("dark", [dark])))
        self.assertEqual(light_corner, 255)
        self.assertLess(dark_corner, 48)
        ball = next(p for p in self.pages() if p.name.startswith("ball"))
        self.picture(ball, "page-whole", size=(1240, 3600))

    def opened(self, page, fragment="", **more):
        """The page, scrolled to its frame, and where in it the source and the map are drawn."""
        out = self.enterContext(browser_pipe.opened(size=(1240, 760), **more))
        out.open(page, fragment, ready=FRAME + "contentDocument && " + FRAME + "contentDocument.body.dataset.ready")
        self.addCleanup(lambda: self.assertEqual(out.console, []))
        out.run("document.getElementById('viewer').scrollIntoView()")
        return out

    def test_frame_shows_the_map_beside_its_source(self):
        self.three()
        ball = next(p for p in self.pages() if p.name.startswith("ball"))
        page = self.opened(ball)
        inside = FRAME + "contentWindow."
        self.assertEqual(page.run(inside + "document.getElementById('look').value"), "distance to the source")
        # Every sample of the map is there, and numbers for each; of the source every vertex.
        self.assertEqual(page.run(f"[{inside}dgmPage.bodies[0].count, {inside}dgmPage.bodies[0].values('distance to the source').length]"),
                         [33 * 33, 33 * 33])
        self.assertEqual(page.run(inside + "dgmPage.beside.source.part.count"), 3 * 20 * 4 ** 3)
        box = page.run(f"(() => {{ const b = document.getElementById('touch').getBoundingClientRect(), v = {inside}dgmPage.canvas.getBoundingClientRect();"
                       "return [b.left + v.left, b.top + v.top, v.width, v.height]; })()")
        scrolled = page.run("scrollY")  # pictures are cut out of the page, the pointer moves in the window
        source, drawn = ((box[0] + shift * box[2], *box[1:]) for shift in (-1, 0))
        pictures = {}
        for look in ("clay", "area distortion, log2"):
            page.run(f"{inside}document.getElementById('look').value = {json.dumps(look)}; {inside}dgmPage.wake()")
            page.wait(inside + "dgmPage.canvas.dataset.resting === 'true' && !" + inside + "dgmPage.waiting")
            pictures[look] = [self.still(page, (side[0], side[1] + scrolled, *side[2:])) for side in (source, drawn)]
        for side in pictures["clay"]:
            self.assertGreater(len(numpy.unique(side.reshape(-1, 3), axis=0)), 60)  # lit shapes on both sides
        # Areas differ on a ball's map: it is blue here and red there. The source has none, and stays as it is.
        left, right = pictures["area distortion, log2"]
        numpy.testing.assert_array_equal(left, pictures["clay"][0])
        self.assertGreater((right[..., 0] - right[..., 2] > 30).sum(), 200)
        self.assertGreater((right[..., 2] - right[..., 0] > 30).sum(), 200)
        # It is the map that is touched, at the place under the pointer.
        at = (drawn[0] + drawn[2] / 2, drawn[1] + drawn[3] / 2)
        page.mouse("mouseMoved", *at, buttons=0)
        page.mouse("mousePressed", *at)
        page.wait(inside + "dgmPage.hand.felt.force > 0")
        self.assertEqual(page.run(inside + "dgmPage.bodies[0].torn()"), 0)
        # A press goes deeper while it is held, and the flanks of its dent are lit otherwise; of the source nothing moves
        # meanwhile.
        deadline = time.monotonic() + browser_pipe.SECONDS
        changed = 0
        while changed <= 200 and time.monotonic() < deadline:
            pressed = page.shot(clip=(drawn[0], drawn[1] + scrolled, *drawn[2:])).astype(int)
            changed = int((numpy.abs(pressed - right).max(axis=2) > 8).sum())
        self.assertGreater(changed, 200)
        numpy.testing.assert_array_equal(page.shot(clip=(source[0], source[1] + scrolled, *source[2:])).astype(int), left)
        page.mouse("mouseReleased", *at)

    @staticmethod
    def still(page, clip):
        """A picture once two in a row are the same: a busy machine shows what was drawn some frames late."""
        before = None
        deadline = time.monotonic() + browser_pipe.SECONDS
        while time.monotonic() < deadline:
            page.run("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")
            now = page.shot(clip=clip).astype(int)
            if before is not None and numpy.array_equal(before, now):
                return now
            before = now
        raise AssertionError("the picture never rests")

    def test_frame_on_a_phone(self):
        self.three()
        page = self.enterContext(browser_pipe.opened(size=(390, 800), phone=True, dark=True))
        page.open(self.pages()[0], "#look=clay", ready=FRAME + "contentDocument && " + FRAME + "contentDocument.body.dataset.ready")
        self.assertLessEqual(page.run("document.documentElement.scrollWidth"), 390)
        self.assertEqual(page.run(FRAME + "contentDocument.getElementById('look').value"), "clay")
        # A finger that has not tapped the surface scrolls the page around it.
        self.assertEqual(page.run(f"getComputedStyle({FRAME}contentDocument.getElementById('view')).touchAction"), "pan-y")
        self.assertEqual(page.console, [])

    def test_without_webgl(self):
        self.three()
        page = self.opened(self.pages()[0], arguments=("--disable-3d-apis",))
        self.assertEqual(page.run(FRAME + "contentDocument.body.dataset.ready"), "still")
        self.assertIn("no WebGL 2", page.run(FRAME + "contentDocument.getElementById('message').textContent"))
        self.assertLess(page.run("document.getElementById('touch').clientHeight"), 100)
        self.assertIn("data:image/jpeg", page.run("document.querySelector('img.wide').src"))

    def test_names_stay_text(self):
        self.three()
        evil = [p for p in self.pages() if not p.name.startswith("ball")]
        self.assertEqual(len(evil), 1)
        self.assertRegex(evil[0].name, r"^[A-Za-z0-9._-]+$")
        for page in (self.folder / "out" / "index.html", evil[0]):
            text = page.read_text(encoding="utf-8")
            self.assertNotIn("<img src=x", text)
            self.assertNotIn("<img src=x", self.dom(page))
            self.assertIn("b&lt;img src=x", text)

    def test_pages_are_kept_while_they_hold(self):
        self.bake_three()
        before = {p: (p.read_bytes(), p.stat().st_mtime_ns) for p in self.pages()}
        result = self.bake_three()
        self.assertIn("0 pages made, 2 kept, 0 failed", result.stdout)
        for page, (_, written) in before.items():
            self.assertEqual(page.stat().st_mtime_ns, written)
        self.bake_three("--force")  # made again: the same but for the times
        for page, (text, written) in before.items():
            self.assertGreater(page.stat().st_mtime_ns, written)
            self.assertEqual(TIMES.sub("", page.read_text(encoding="utf-8")), TIMES.sub("", text.decode()))
            self.assertNotEqual(TIMES.sub("", text.decode()), text.decode())
        self.pages()[0].unlink()
        self.assertIn("1 page made, 1 kept, 0 failed", self.bake_three().stdout)
        first = self.pages()[0]
        first.write_text(first.read_text(encoding="utf-8").replace('name="dgm-page" content="', 'name="dgm-page" content="0'),
                         encoding="utf-8")
        self.assertIn("1 page made, 1 kept, 0 failed", self.bake_three().stdout)
        self.assertEqual([n for n in self.names() if ".dgm-" in n], [])

    def test_a_page_that_fails_fails_no_asset(self):
        (self.folder / "small.obj").write_text("this is no mesh\n")  # the faulty program bakes it all the same
        meshes.write_obj(self.folder / "real-ball.obj", meshes.icosphere(2))
        result = self.bake("small.obj", "real-ball.obj", "-o", "out/", *SIZE, "--report", "out/index.html",
                           program=support.FAULTY_BAKE)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("1 page made, 0 kept, 1 failed", result.stdout)
        text = (self.folder / "out" / "index.html").read_text(encoding="utf-8")
        self.assertIn("no page: DGM", text)
        self.assertEqual([p.name for p in self.pages()], ["real-ball.obj.html"])
        self.assertEqual([n for n in self.names() if ".dgm-" in n], [])

    def test_shards_become_one_index(self):
        """Parts bake without pages; the merge makes them, once, and takes indices as well as JSON."""
        self.bake_three()
        whole = (self.folder / "out" / "index.html").read_text(encoding="utf-8")
        names = [p.name for p in self.pages()]
        shutil.rmtree(self.folder / "out")
        for k in (1, 2):
            self.bake("in", "-o", "out/", *SIZE, "--shard", f"{k}/2", "--report", f"part{k}.json")
        merged = self.bake("--merge-reports", "part1.json", "part2.json", "-o", "out/index.html")
        self.assertEqual(merged.returncode, 3, merged.stderr)  # the band, as in the whole batch
        self.assertIn("2 pages made, 0 kept, 0 failed", merged.stdout)
        self.assertEqual([p.name for p in self.pages()], names)
        seen = lambda text: re.findall(r'<a href="(assets/[^"]+)">|<h3>(.*?)</h3>', text)
        self.assertEqual(seen((self.folder / "out" / "index.html").read_text(encoding="utf-8")), seen(whole))
        self.assertEqual(len(seen(whole)), 3)
        again = self.bake("--merge-reports", "out/index.html", "part1.json", "-o", "out/index.html")
        self.assertEqual(again.returncode, 3, again.stderr)
        self.assertIn("0 pages made, 2 kept, 0 failed", again.stdout)
        # The pages say how to bake each mesh again, which the merge knows from the parts.
        self.assertIn("dgm-bake in/ball.obj -o out/ball.dgm", (self.folder / "out/assets/ball.obj.html").read_text("utf-8"))
        # Where the maps are not, the index says so and stands.
        shutil.rmtree(self.folder / "out")
        bare = self.bake("--merge-reports", "part1.json", "part2.json", "-o", "index.html")
        self.assertEqual(bare.returncode, 3, bare.stderr)
        self.assertIn("0 pages made, 0 kept, 2 failed", bare.stdout)
        self.assertIn("no page: ", (self.folder / "index.html").read_text(encoding="utf-8"))

    def test_ctrl_c_while_pages_are_made(self):
        for k in range(8):
            meshes.write_obj(self.folder / f"m{k}.obj", meshes.sheet(12 + k))
        arguments = [*(f"m{k}.obj" for k in range(8)), "-o", "out/", *SIZE, "-j2"]
        self.bake_well(*arguments)
        process = subprocess.Popen([support.BAKE, *arguments, "--report", "out/index.html"], cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while "report: 1 of 8" not in process.stderr.readline():
            self.assertIsNone(process.poll())
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=30), 130)
        process.stderr.close()
        self.assertTrue(self.workers_gone())
        self.assertEqual([n for n in self.names() if ".dgm-" in n], [])
        self.assertIn("the report was interrupted", (self.folder / "out" / "index.html").read_text(encoding="utf-8"))

    def test_sorting_and_filtering(self):
        self.three()
        index = self.folder / "out" / "index.html"
        text = index.read_text(encoding="utf-8")

        def names_after(script):
            page = self.folder / "out" / "scripted.html"
            page.write_text(text.replace("</body>", f"<script>{script}</script></body>"), encoding="utf-8")
            return re.findall(r'<tr class="\w+" data-text="([^"]+)"( hidden="")?', self.dom(page))

        click = 'document.querySelectorAll("th button")[0].click();'
        self.assertEqual([n[:4] for n, _ in names_after(click)], ["ball", "deep"])
        self.assertEqual([n[:4] for n, _ in names_after(click + click)], ["deep", "ball"])
        search = 'const f = document.getElementById("filter"); f.value = "DEEP onerror"; f.dispatchEvent(new Event("input"));'
        hidden = {n[:4]: bool(h) for n, h in names_after(search)}
        self.assertEqual(hidden, {"ball": True, "deep": False})

    def test_two_hundred_assets_open_at_once(self):
        self.three()
        index = self.folder / "out" / "index.html"
        text = index.read_text(encoding="utf-8")
        row = re.search(r"<tr class=\"\w+\" data-text.*?</tr>\n", text, re.S).group(0)
        many = self.folder / "out" / "many.html"
        many.write_text(text.replace(row, "".join(row.replace("<td", f"<td id=\"c{k}\"", 1) for k in range(200))),
                        encoding="utf-8")
        self.assertGreater(many.stat().st_size, 200 * 2 * 2000)
        measure = ("addEventListener('load', () => { document.body.offsetHeight;"
                   "document.body.dataset.opened = performance.now(); });")
        many.write_text(many.read_text(encoding="utf-8").replace("</body>", f"<script>{measure}</script></body>"),
                        encoding="utf-8")
        milliseconds = []
        for _ in range(3):  # without virtual time, and without the browser's own start
            done = subprocess.run([browser(), "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom", many.as_uri()],
                                  capture_output=True, text=True, errors="replace", timeout=300, check=True)
            self.assertEqual(len(re.findall(r"<tr class=", done.stdout)), 201)
            milliseconds.append(float(re.search(r'data-opened="([\d.]+)"', done.stdout).group(1)))
        print("index of 200 assets opened in", milliseconds, "ms")
        self.assertLess(min(milliseconds), 2000, milliseconds)

    def test_options(self):
        meshes.write_obj(self.folder / "a.obj", meshes.sheet(8))
        self.bake_well("a.obj", *SIZE, "--report", "r.txt", "--report-format", "html")
        self.assertTrue((self.folder / "r.txt").read_text(encoding="utf-8").startswith("<!doctype html>"))
        self.bake_well("a.obj", *SIZE, "--report", "r.html", "--report-format", "json")
        self.assertEqual(json.loads((self.folder / "r.html").read_text(encoding="utf-8"))["summary"]["assets"], 1)
        self.assertEqual(self.bake("a.obj", "--report", "r.html", "--report-format", "pdf").returncode, 1)
        self.assertEqual(self.bake("a.obj", "--report-format", "html").returncode, 1)


if __name__ == "__main__":
    unittest.main()
