# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens a page as a user's browser does, without a window or a network."""
import io
import shutil
import subprocess
from pathlib import Path

import numpy
from PIL import Image


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
    """Rows x columns x 3, of 8 bits each."""
    return numpy.asarray(Image.open(io.BytesIO(data)).convert("RGB"))
