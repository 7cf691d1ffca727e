# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens a page as a user's browser does, without a window or a network."""
import shutil
import struct
import subprocess
import zlib
from pathlib import Path

import numpy


def browser():
    """scripts/install_packages tests installs one: that there is none is a failure, not a reason to look away."""
    for name in ("chromium-headless-shell", "chromium"):
        if found := shutil.which(name):
            return found
    raise AssertionError("no chromium: run scripts/install_packages tests")


def run_browser(page, *arguments, fragment=""):
    """stdout, and the lines that the page wrote to the console."""
    done = subprocess.run([browser(), "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                           "--virtual-time-budget=5000", "--enable-logging=stderr", *arguments,
                           Path(page).resolve().as_uri() + fragment],
                          capture_output=True, text=True, errors="replace", timeout=300, check=True)
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def screenshot(page, picture, fragment="", size=(1200, 1600)):
    """Pixels, rows x columns x 3, and the console's lines; the picture is left for people."""
    _, console = run_browser(page, f"--screenshot={picture}", f"--window-size={size[0]},{size[1]}", fragment=fragment)
    return read_png(Path(picture).read_bytes()), console


def read_png(data):
    """8-bit RGB or RGBA, not interlaced, as the browser writes them."""
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, bits, colour, _, _, interlaced = struct.unpack(">IIBBBBB", body)
            assert bits == 8 and colour in (2, 6) and not interlaced
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    channels = 3 if colour == 2 else 4
    rows = numpy.frombuffer(zlib.decompress(packed), numpy.uint8).reshape(height, 1 + channels * width)
    out = numpy.zeros((height, width, channels), numpy.uint8)
    above = numpy.zeros((width, channels), numpy.int64)
    for y in range(height):
        method, line = rows[y, 0], rows[y, 1:].reshape(width, channels).astype(numpy.int64)
        if method == 2:
            line = (line + above) % 256
        elif method == 1:
            line = numpy.cumsum(line, axis=0) % 256
        elif method in (3, 4):
            left = upper_left = numpy.zeros(channels, numpy.int64)
            for x in range(width):
                up = above[x]
                if method == 3:
                    guess = (left + up) // 2
                else:
                    a, b, c = abs(up - upper_left), abs(left - upper_left), abs(left + up - 2 * upper_left)
                    guess = numpy.where((a <= b) & (a <= c), left, numpy.where(b <= c, up, upper_left))
                left, upper_left = (line[x] + guess) % 256, up
                line[x] = left
        out[y], above = line, line
    return out[:, :, :3]
