# SPDX-License-Identifier: GPL-3.0-or-later
"""Drives a page in a browser without a window: mouse, fingers, keys, pictures, over pipes of our own."""
import atexit
import base64
import contextlib
import functools
import json
import os
import select
import subprocess
import tempfile
import time
import weakref
from pathlib import Path

import browser

SECONDS = 120


class Browser:
    """A browser that runs. Its pages have nothing of each other: no storage, cookies or caches."""

    def __init__(self, arguments):
        down, up = os.pipe(), os.pipe()  # to the browser, from it

        def hand_over():
            # The browser reads descriptor 3 and writes 4; take copies first, in case ours have those numbers.
            mine = os.dup(down[0]), os.dup(up[1])
            os.dup2(mine[0], 3)
            os.dup2(mine[1], 4)

        self.profile = tempfile.TemporaryDirectory(prefix="dgm-browser-", ignore_cleanup_errors=True)
        command = [browser.browser(), "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
                   "--enable-unsafe-swiftshader", "--hide-scrollbars", "--remote-debugging-pipe",
                   f"--user-data-dir={self.profile.name}", *arguments, "about:blank"]
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL, close_fds=False, preexec_fn=hand_over)
        os.close(down[0])
        os.close(up[1])
        self.to, self.back = down[1], up[0]
        self.number, self.text, self.pages = 0, b"", weakref.WeakValueDictionary()

    def close(self):
        self.process.kill()
        self.process.wait()
        os.close(self.to)
        os.close(self.back)
        self.profile.cleanup()

    def message(self, deadline):
        while b"\0" not in self.text:
            if not select.select([self.back], [], [], max(0, deadline - time.monotonic()))[0]:
                raise AssertionError("the browser says nothing")
            more = os.read(self.back, 1 << 20)
            if not more:
                raise AssertionError("the browser is gone")
            self.text += more
        line, self.text = self.text.split(b"\0", 1)
        return json.loads(line)

    def note_next(self, deadline):
        """Hands what the browser says of itself to the page it is about. Returns an answer, else {}."""
        said = self.message(deadline)
        if "id" in said:
            return said
        if page := self.pages.get(said.get("sessionId")):
            page.note(said)
        return {}

    def call(self, method, session=None, **facts):
        self.number += 1
        message = {"id": self.number, "method": method, "params": facts}
        if session:
            message["sessionId"] = session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        deadline = time.monotonic() + SECONDS
        while (said := self.note_next(deadline)).get("id") != self.number:
            pass
        if "error" in said:
            raise AssertionError(f"{method}: {said['error']}")
        return said["result"]


class Page:
    """A page that is open. `console` has every line, exception and request that was not for the page itself."""

    def __init__(self, of, session):
        self.browser, self.session, self.events, self.console = of, session, [], []
        of.pages[session] = self

    def note(self, said):
        method, facts = said.get("method"), said.get("params", {})
        if method in ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded"):
            self.console.append(json.dumps(facts))
        if method == "Network.requestWillBeSent":
            address = facts["request"]["url"]
            if not address.startswith(("data:", "blob:")) and facts.get("type") != "Document":
                self.console.append("asked for " + address)
        self.events.append(said)

    def call(self, method, **facts):
        return self.browser.call(method, self.session, **facts)

    def wait_event(self, method, seconds=SECONDS):
        deadline = time.monotonic() + seconds
        while not any(event.get("method") == method for event in self.events):
            self.browser.note_next(deadline)

    def run(self, script):
        """The value of an expression, which may be a promise."""
        done = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in done:
            raise AssertionError(json.dumps(done["exceptionDetails"]))
        return done["result"].get("value")

    def wait(self, script, seconds=SECONDS):
        deadline = time.monotonic() + seconds
        while not (value := self.run(script)):
            if time.monotonic() > deadline:
                raise AssertionError(f"never true: {script}; console: {self.console}")
            time.sleep(.05)
        return value

    def open(self, path, fragment="", ready="document.body.dataset.ready"):
        self.events.clear()
        self.call("Page.navigate", url=Path(path).resolve().as_uri() + fragment)
        self.wait_event("Page.loadEventFired")
        self.wait(ready)

    def mouse(self, kind, x, y, button="left", buttons=1, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button if buttons else "none",
                  buttons=buttons if kind != "mouseReleased" else 0, clickCount=1, **more)

    def touch(self, kind, points):
        self.call("Input.dispatchTouchEvent", type=kind,
                  touchPoints=[{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(points)])

    def key(self, key, code=None, up=True, down=True, modifiers=0):
        facts = {"key": key, "code": code or key, "modifiers": modifiers}
        if len(key) == 1:
            facts["text"] = key
        if key == "Tab":
            facts["windowsVirtualKeyCode"] = 9
        if down:
            self.call("Input.dispatchKeyEvent", type="keyDown", **facts)
        if up:
            self.call("Input.dispatchKeyEvent", type="keyUp", **{k: v for k, v in facts.items() if k != "text"})

    def shot(self, picture=None, clip=None):
        """Pixels, rows x columns x 3."""
        more = {"clip": dict(zip(("x", "y", "width", "height"), clip), scale=1)} if clip else {}
        data = base64.b64decode(self.call("Page.captureScreenshot", format="png", optimizeForSpeed=True, **more)["data"])
        if picture:
            Path(picture).parent.mkdir(parents=True, exist_ok=True)
            Path(picture).write_bytes(data)
        return browser.read_png(data)

    def rest(self):
        """Waits until nothing moves, and all triangles are drawn."""
        still = "document.getElementById('view').dataset.resting === 'true' && !dgmPage.waiting && !dgmPage.running"
        self.wait(still)
        # What was drawn last is shown two frames later.
        self.run("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")
        self.wait(still)


@functools.cache
def running(*arguments):
    """One browser for all pages of a test program: to start one takes as long as most tests."""
    out = Browser(arguments)
    atexit.register(out.close)
    return out


@contextlib.contextmanager
def opened(size=(1000, 700), dark=False, phone=False, arguments=(), offline=True):
    """A Page without an address. What it has stored is gone afterwards."""
    of = running(*arguments)
    context = of.call("Target.createBrowserContext")["browserContextId"]
    try:
        target = of.call("Target.createTarget", url="about:blank", width=size[0], height=size[1],
                         browserContextId=context)["targetId"]
        page = Page(of, of.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"])
        for domain in ("Page", "Runtime", "Log", "Network"):
            page.call(domain + ".enable")
        page.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=phone)
        if phone:
            page.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=5)
        page.call("Emulation.setEmulatedMedia", features=[
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        page.call("Network.emulateNetworkConditions", offline=offline, latency=0, downloadThroughput=0 if offline else -1,
                  uploadThroughput=0 if offline else -1)
        yield page
    finally:
        if of.process.poll() is None:
            of.call("Target.disposeBrowserContext", browserContextId=context)
        else:  # the next page gets another
            running.cache_clear()
