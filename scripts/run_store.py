# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared code of the scripts that bake whole folders: results kept from run to run, the meshes of folders, table rows."""
import hashlib
import json
import os
import sys
import threading
import time
from pathlib import Path

MESHES = {".obj", ".3ds", ".ply", ".off", ".stl"}


def sha(path):
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16]


def meshes_of(folders, only=""):
    """{"folder/mesh.obj": path} of every mesh below the folders whose path holds `only`, in the order of the names."""
    return {f"{folder.resolve().name}/{path.relative_to(folder).as_posix()}": path for folder in folders
            for path in sorted(folder.rglob("*")) if path.suffix.lower() in MESHES and only in str(path)}


class Results:
    """Measured results, by key; written at most every ten seconds and at the end, never half."""

    def __init__(self, path):
        self.path, self.lock, self.written, self.bakes = path, threading.Lock(), time.monotonic(), {}
        if path.exists():
            try:
                self.bakes = json.loads(path.read_text(encoding="utf-8"))["bakes"]
            except (ValueError, KeyError, TypeError):
                print(f"{path.name} is not readable, starting anew", file=sys.stderr)

    def put(self, key, value):
        with self.lock:
            self.bakes[key] = value
            if time.monotonic() - self.written > 10:
                self.save()

    def save(self, keep=None):
        if keep is not None:
            self.bakes = {k: v for k, v in self.bakes.items() if k in keep}
        aside = self.path.with_suffix(".json.part")
        aside.write_text(json.dumps({"bakes": self.bakes}, indent=0, sort_keys=True) + "\n", encoding="utf-8")
        os.replace(aside, self.path)
        self.written = time.monotonic()


def row(*cells):
    return "| " + " | ".join(str(c) for c in cells) + " |"


def header(*cells):
    return [row(*cells), "|" + "---|" * len(cells)]
