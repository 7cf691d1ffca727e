#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes the samples with a built tree and writes tests/golden/golden.json and hashes.json anew. Read the difference before
committing.

    scripts/update_golden.py [--hashes] [BUILD]     --hashes: hashes.json only; BUILD: the build folder [build/release]
"""
import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "tests/golden"))
import golden  # noqa: E402  (found through the line above)


def main(arguments):
    hashes_only = "--hashes" in arguments
    arguments = [a for a in arguments if a != "--hashes"]
    if len(arguments) > 1 or any(a.startswith("-") for a in arguments):
        print(__doc__, file=sys.stderr)
        return 1
    build = Path(arguments[0]) if arguments else ROOT / "build/release"
    bake, samples = build / "cli/bake/dgm-bake", build / "samples/meshes"
    for needed in (bake, samples):
        if not needed.exists():
            print(f"update_golden: {needed} is not there; build first", file=sys.stderr)
            return 2
    text = json.dumps({"platform": golden.this_platform(), "size": golden.HASH_SIZE,
                       "hashes": golden.hashes(bake, samples)}, indent=1)
    golden.HASHES.write_text(text + "\n", encoding="utf-8")
    print(f"update_golden: {golden.HASHES} written", flush=True)
    if hashes_only:
        return 0
    bakes = {}
    for method in golden.CASES:
        print(f"update_golden: {method} ...", flush=True)
        bakes[method] = golden.measure(bake, samples, method)
    version = subprocess.run([bake, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    text = json.dumps({"origin": f"scripts/update_golden.py with {version}, g++ 12, x86-64, Release; the meshes are "
                                 f"those of samples/generate", "size": golden.SIZE, "bakes": bakes}, indent=1)
    golden.FILE.write_text(text + "\n", encoding="utf-8")
    print(f"update_golden: {golden.FILE} written")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
