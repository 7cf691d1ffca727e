# SPDX-License-Identifier: GPL-3.0-or-later
"""The Debian packages: each holds its own files and no other's, says what it needs, installs, works and goes again.
They are installed into a folder that stands for the root; scripts/packages installs them in a system of their own."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import meshes
import support

BUILD = Path(os.environ.get("DGM_BUILD", "."))
CPACK = os.environ.get("DGM_CPACK", "cpack")
TOOLS = ("dgm-bake", "dgm-validate", "dgm-info", "dgm-export", "dgm-edit", "dgm-bench")


class Packages(support.Folder):
    @classmethod
    def setUpClass(cls):
        cls.packages = Path(tempfile.mkdtemp(prefix="dgm-packages-"))
        cls.addClassCleanup(shutil.rmtree, cls.packages, ignore_errors=True)
        made = subprocess.run([CPACK, "--config", BUILD / "CPackConfig.cmake", "-B", cls.packages,
                               "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=gzip"],
                              capture_output=True, text=True, timeout=600, check=False)
        if made.returncode != 0:
            raise AssertionError(made.stdout + made.stderr)
        cls.files = {p.name.split("_")[0]: p for p in cls.packages.glob("*.deb")}

    def contents(self, package):
        listing = subprocess.run(["dpkg-deb", "--fsys-tarfile", self.files[package]], capture_output=True, check=True)
        names = subprocess.run(["tar", "-t"], input=listing.stdout, capture_output=True, check=True).stdout.decode()
        return sorted(n.removeprefix("./") for n in names.splitlines() if not n.endswith("/"))

    def field(self, package, name):
        return subprocess.run(["dpkg-deb", "--field", self.files[package], name], capture_output=True, text=True,
                              check=True).stdout.strip()

    def dpkg(self, root, *arguments):
        return subprocess.run(["dpkg", f"--root={root}", "--force-depends", "--force-not-root", "--force-script-chrootless",
                               f"--log={root}/dpkg.log", *map(str, arguments)], capture_output=True, text=True,
                              timeout=120, check=False)

    def test_three_packages_each_with_its_own_files(self):
        self.assertEqual(sorted(self.files), ["dgm-tools", "libdgm-dev", "libdgm0"])
        runtime, development, tools = (self.contents(p) for p in ("libdgm0", "libdgm-dev", "dgm-tools"))
        libraries = ("libdgm.so.0", "libdgm_cloth.so.0", "libdgm_physics.so.0")
        self.assertEqual([n for n in runtime if "/doc/" not in n and not Path(n).name.startswith(libraries)], [])
        self.assertTrue(any(n.endswith("libdgm.so.0") for n in runtime))
        for name in ("usr/include/dgm/dgm.h", "usr/include/dgm/state.h"):
            self.assertIn(name, development)
        for end in ("libdgm.so", "dgm.pc", "dgmConfig.cmake", ".a"):
            self.assertTrue(any(n.endswith(end) for n in development), end)
        for tool in TOOLS:
            self.assertIn(f"usr/bin/{tool}", tools)
            self.assertIn(f"usr/share/man/man1/{tool}.1", [n.removesuffix(".gz") for n in tools])
        self.assertFalse(set(runtime) & set(development) or set(runtime) & set(tools) or set(development) & set(tools))
        for package in self.files:
            self.assertIn(f"usr/share/doc/{package}/copyright", self.contents(package))

    def test_they_say_what_they_need(self):
        self.assertRegex(self.field("libdgm0", "Depends"), r"^libc6 \(>= [\d.]+\)")
        for library in ("hdf5", "embree", "assimp", "cgal", "openexr"):
            self.assertNotIn(library, self.field("libdgm0", "Depends").lower())
        for library in ("libhdf5", "libembree", "libassimp", "libopenexr"):
            self.assertIn(library, self.field("dgm-tools", "Depends"))
        version = self.field("libdgm0", "Version")
        self.assertEqual(self.field("libdgm-dev", "Depends"), f"libdgm0 (= {version})")

    def test_installed_they_work_and_removed_they_leave_nothing(self):
        root = self.folder / "root"
        admin = root / "var/lib/dpkg"
        for folder in ("info", "updates", "triggers"):
            (admin / folder).mkdir(parents=True)
        for file in ("status", "available"):
            (admin / file).touch()
        before = {n for n in self.names(root) if not n.startswith("var/")}
        installed = self.dpkg(root, "--install", *self.files.values())
        self.assertEqual(installed.returncode, 0, installed.stdout + installed.stderr)
        meshes.write_obj(self.folder / "ball.obj", meshes.icosphere())
        baked = self.run_program(root / "usr/bin/dgm-bake", "ball.obj", "-o", "map.dgm", "--size", "33x33")
        self.assertEqual(baked.returncode, 0, baked.stdout + baked.stderr)
        checked = self.run_program(root / "usr/bin/dgm-validate", "map.dgm")
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)
        removed = self.dpkg(root, "--purge", *self.files)
        self.assertEqual(removed.returncode, 0, removed.stdout + removed.stderr)
        after = {n for n in self.names(root) if not n.startswith("var/") and n != "dpkg.log"}
        self.assertEqual(after - before, set())


if __name__ == "__main__":
    if not all(shutil.which(program) for program in ("dpkg", "dpkg-deb", "dpkg-shlibdeps", "tar")):
        print("no Debian packages are made here (dpkg-dev)")
        sys.exit(77)
    unittest.main()
