# SPDX-License-Identifier: GPL-3.0-or-later
"""Node's packages that tests need: by NODE_PATH, where node looks, or from npm, which puts them into the build folder."""
import os
import shutil
import subprocess

# All of them, since npm takes away what it is not asked for.
VERSIONS = ("gltf-validator@2.0.0-dev.3.10", "three@0.160.0", "typescript@5.9.3")


def found(names):
    script = "".join(f"require.resolve('{name}');" for name in names)
    return subprocess.run(["node", "-e", script], capture_output=True, timeout=60, check=False).returncode == 0


def missing(*names):
    """The reason why node does not have them, or None."""
    if shutil.which("node") is None:
        return "there is no node"
    if found(names):
        return None
    folder = os.environ.get("DGM_NODE_FOLDER")
    if not folder or shutil.which("npm") is None:
        return f"node does not find {' and '.join(names)}, and there is no npm to fetch them; set NODE_PATH"
    os.environ["NODE_PATH"] = os.path.join(folder, "node_modules")
    if found(names):
        return None
    try:
        fetched = subprocess.run(["npm", "install", "--no-audit", "--no-fund", "--prefix", folder, *VERSIONS],
                                 capture_output=True, text=True, timeout=120, check=False)
    except subprocess.TimeoutExpired:
        return "npm does not answer"
    if found(names):
        return None
    return f"npm could not fetch {VERSIONS}: {fetched.stderr.strip()[-300:]}"
