# SPDX-License-Identifier: GPL-3.0-or-later
"""What programs do beside their workers: bounds, signals, outputs and reports, whatever files and names are made of."""
import json
import os
import resource
import shutil
import signal
import subprocess
import time
import unittest

import meshes
import support

SIZE = ["--size", "9", "--method", "stretch", "--fit", "sample"]
LEFT = ".dgm-"  # how the names of unfinished outputs begin


class Parents(support.Folder):
    def ball(self, name="ball.obj", head=""):
        path = self.folder / name
        meshes.write_obj(path, meshes.icosphere(1))
        if head:
            path.write_text(head + path.read_text())
        return path

    def code(self, result, exit_code, code):
        self.assertEqual(result.returncode, exit_code, result.stdout + result.stderr)
        self.assertRegex(result.stderr + result.stdout, f"DGM{code}(: | error)")
        self.assertNotIn("DGM9001", result.stderr)

    def sparse(self, name, size):
        path = self.folder / name
        path.unlink(missing_ok=True)
        with open(path, "wb") as file:
            file.truncate(size)
        return path

    def nothing_left(self):
        self.assertEqual([n for n in self.names() if LEFT in n], [])


class Bounds(Parents):
    def test_sizes_are_looked_at_before_bytes(self):
        self.ball()
        self.bake_well("ball.obj", *SIZE)
        self.sparse("ball.obj", 1 << 40)
        for more in ([], ["--force"]):
            begun = time.monotonic()
            self.code(self.bake("ball.obj", *SIZE, *more), 3, 3007)
            self.assertLess(time.monotonic() - begun, 20)
        self.nothing_left()

    def many_textures(self):
        """Up to date, but to find that out takes reading 60 GiB of nothing."""
        names = [f"skin{k}.png" for k in range(16)]
        (self.folder / "m.mtl").write_text("".join(f"newmtl m{n}\nmap_Kd {n}\n" for n in names))
        self.ball(head="mtllib m.mtl\n")
        for name in names:
            (self.folder / name).write_bytes(b"no picture")
        self.bake_well("ball.obj", *SIZE)
        for name in names:
            self.sparse(name, (4 << 30) - 1)

    def test_the_check_is_in_the_assets_time(self):
        self.many_textures()
        begun = time.monotonic()
        self.code(self.bake("ball.obj", *SIZE, "--time-limit", "1"), 3, 9003)
        self.assertLess(time.monotonic() - begun, 20)

    def test_signals_are_heard_while_outputs_are_checked(self):
        self.many_textures()
        for number in (signal.SIGTERM, signal.SIGINT):
            process = subprocess.Popen([support.BAKE, "ball.obj", *SIZE], cwd=self.folder, stdout=subprocess.DEVNULL,
                                       stderr=subprocess.DEVNULL)
            time.sleep(0.5)
            begun = time.monotonic()
            process.send_signal(number)
            self.assertEqual(process.wait(timeout=60), 130)
            self.assertLess(time.monotonic() - begun, 5)
            self.assertTrue(self.workers_gone())

    def test_libraries_are_read_once_and_in_linear_time(self):
        library = "".join(f"newmtl m{k}\nmap_Kd no{k}.png\n" for k in range(20_000))
        (self.folder / "a.mtl").write_text(library)
        begun = time.monotonic()
        for name, head in (("words", "mtllib " + "./a.mtl a.mtl " * 1500 + "\n"),
                           ("turns", "mtllib q\\\n" * 60_000 + "\n")):
            mesh = self.ball(f"{name}.obj", head)
            self.bake_well(mesh, *SIZE, "-q", "--time-limit", "60")
            shutil.copy(self.folder / f"{name}.dgm", self.folder / "again.dgm")
            self.bake_well(mesh, *SIZE, "-q", "--time-limit", "60")
        self.assertLess(time.monotonic() - begun, 120)

    def test_what_is_no_file_is_refused_before_it_is_opened(self):
        self.ball()
        self.bake_well("ball.obj", *SIZE)
        os.mkfifo(self.folder / "pipe.obj")
        os.mkfifo(self.folder / "pipe.dgm")
        for program, arguments in ((support.BAKE, ["pipe.obj"]), (support.VALIDATE, ["pipe.dgm"]),
                                   (support.VALIDATE, ["ball.dgm", "--source", "pipe.obj"]),
                                   (support.VALIDATE, ["ball.dgm", "--source", "/dev/zero"]),
                                   (support.VALIDATE, ["ball.dgm", "--baseline", "pipe.obj"]),
                                   (support.INFO, ["pipe.dgm"]), (support.BAKE, ["--merge-reports", "pipe.obj"])):
            with self.subTest(arguments=arguments):
                result = subprocess.run([program, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=60)
                self.assertEqual(result.returncode, 2, result.stdout + result.stderr)

    def test_deep_scenes_are_refused_with_a_place(self):
        for text, place in (("a" + ".a" * 100_000 + "=1\n", ":1:"), ("x = 1\ny = " + "[" * 100_000, ":2:"),
                            ("[" + "a." * 100_000 + "a]\n", ":1:"), ("x=" + "{a=" * 50_000, ":1:")):
            (self.folder / "scene.toml").write_text(text)
            for program in (support.BAKE, support.INFO):
                result = self.run_program(program, "scene.toml")
                self.code(result, 3, 6004)
                self.assertIn("scene.toml" + place, result.stderr)

    def test_few_descriptors_are_trouble_that_may_pass(self):
        self.ball()
        result = subprocess.run(["sh", "-c", 'ulimit -n 6; exec "$0" "$@"', support.BAKE, "ball.obj", *SIZE],
                                cwd=self.folder, capture_output=True, text=True, timeout=60)
        self.code(result, 75, 5007)

    @unittest.skipIf(support.SANITIZED, "the address sanitizer needs unlimited address space")
    def test_little_memory_is_no_internal_error(self):
        self.ball()
        for limit in (100_000, 150_000, 200_000, 300_000):
            result = subprocess.run(["sh", "-c", f'ulimit -v {limit}; exec "$0" "$@"', support.BAKE, "ball.obj", *SIZE,
                                     "--force"], cwd=self.folder, capture_output=True, text=True, timeout=60)
            self.assertIn(result.returncode, (0, 3, 75, 127), f"{limit}: {result.stderr}")  # 127: of the loader

    def test_an_unreadable_texture_is_left_out_as_a_missing_one(self):
        (self.folder / "m.mtl").write_text("newmtl m\nmap_Kd skin.png\n")
        self.ball(head="mtllib m.mtl\nusemtl m\n")
        (self.folder / "skin.png").symlink_to("/proc/self/mem")
        result = self.bake("ball.obj", *SIZE, "-v")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("skin.png", result.stdout + result.stderr)


class Outputs(Parents):
    def test_reports_never_replace_what_is_no_file(self):
        self.ball()
        os.mkfifo(self.folder / "pipe")
        reader = os.open(self.folder / "pipe", os.O_RDONLY | os.O_NONBLOCK)
        self.addCleanup(os.close, reader)
        self.bake_well("ball.obj", *SIZE, "--report", "pipe")
        self.assertEqual(json.loads(os.read(reader, 1 << 20))["summary"]["baked"], 1)
        self.assertTrue((self.folder / "pipe").is_fifo())
        self.bake_well("ball.obj", *SIZE, "--report", "/dev/null")
        self.assertFalse(os.path.isfile("/dev/null"))
        self.code(self.bake("ball.obj", *SIZE, "--report", "/dev/full"), 75, 5006)
        self.assertFalse(os.path.isfile("/dev/full"))
        result = self.bake_well("ball.obj", *SIZE, "-q", "--report", "/dev/stdout")
        self.assertEqual(json.loads(result.stdout)["summary"]["up_to_date"], 1)

    def test_links_stay_and_their_targets_are_replaced(self):
        self.ball()
        (self.folder / "deep").mkdir()
        (self.folder / "deep" / "report.json").write_text("old")
        (self.folder / "link.json").symlink_to("deep/report.json")
        self.bake_well("ball.obj", *SIZE, "--report", "link.json")
        self.assertTrue((self.folder / "link.json").is_symlink())
        self.assertEqual(json.loads((self.folder / "deep" / "report.json").read_text())["exit_code"], 0)
        self.nothing_left()

    def test_no_output_is_an_input(self):
        (self.folder / "m.mtl").write_text("newmtl m\nmap_Kd skin.png\n")
        self.ball(head="mtllib m.mtl\nusemtl m\n")
        (self.folder / "skin.png").write_bytes(b"a texture")
        self.bake_well("ball.obj", *SIZE, "--report", "r.json")
        (self.folder / "hard").hardlink_to(self.folder / "ball.obj")
        (self.folder / "soft").symlink_to("ball.dgm")
        before = {name: (self.folder / name).read_bytes() for name in self.names()}
        for program, arguments in (
                (support.BAKE, ["ball.obj", *SIZE, "--report", "ball.obj"]),
                (support.BAKE, ["ball.obj", *SIZE, "--report", "hard"]),
                (support.BAKE, ["ball.obj", *SIZE, "--depfile", "./ball.obj"]),
                (support.BAKE, ["ball.obj", *SIZE, "--report", "skin.png"]),
                (support.VALIDATE, ["ball.dgm", "--report", "json=ball.dgm"]),
                (support.VALIDATE, ["ball.dgm", "--report", "json=soft"]),
                (support.VALIDATE, ["ball.dgm", "--write-baseline", "ball.dgm"]),
                (support.VALIDATE, ["ball.dgm", "--source", "ball.obj", "--report", "junit=ball.obj"]),
                (support.EXPORT, ["ball.dgm", "-o", "ball.dgm"])):
            with self.subTest(arguments=arguments):
                self.code(self.run_program(program, *arguments), 1, 6001)
                self.assertEqual({name: (self.folder / name).read_bytes() for name in self.names()}, before)

    def test_a_full_disk_leaves_the_last_good_report(self):
        self.ball()
        self.bake_well("ball.obj", *SIZE)
        good = self.run_program(support.VALIDATE, "ball.dgm", "--report", "json=v.json")
        self.assertEqual(good.returncode, 0)
        before = (self.folder / "v.json").read_bytes()
        limit = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
        result = subprocess.run(
            [support.VALIDATE, "ball.dgm", "--report", "json=v.json"], cwd=self.folder, capture_output=True, text=True,
            timeout=60, preexec_fn=lambda: (signal.signal(signal.SIGXFSZ, signal.SIG_IGN),
                                            resource.setrlimit(resource.RLIMIT_FSIZE, (10, limit))))
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertEqual((self.folder / "v.json").read_bytes(), before)
        self.nothing_left()

    def test_a_full_stdout_is_an_error(self):
        self.ball()
        self.bake_well("ball.obj", *SIZE)
        for program, arguments in ((support.INFO, ["ball.dgm"]), (support.INFO, ["ball.dgm", "--json"]),
                                   (support.INFO, ["--diff", "ball.dgm", "ball.dgm"]), (support.INFO, ["--help"]),
                                   (support.VALIDATE, ["ball.dgm"]), (support.EXPORT, ["ball.dgm", "-o", "b.ply"]),
                                   (support.BAKE, ["ball.obj", *SIZE])):
            with self.subTest(program=program, arguments=arguments), open("/dev/full", "wb") as full:
                result = subprocess.run([program, *arguments], cwd=self.folder, stdout=full, stderr=subprocess.PIPE,
                                        timeout=60)
                self.assertEqual(result.returncode, 2, result.stderr)

    def test_temporaries_of_killed_bakes_are_collected(self):
        meshes.write_obj(self.folder / "big.obj", meshes.icosphere(5))
        process = subprocess.Popen([support.BAKE, "big.obj", "-o", "out/", "--size", "257"], cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 60
        while not any(LEFT in n for n in self.names()) and time.monotonic() < deadline:
            time.sleep(0.01)
        process.kill()
        process.wait()
        self.assertTrue(self.workers_gone())
        left = [n for n in self.names() if LEFT in n]
        self.assertTrue(left)
        self.ball()
        self.bake_well("ball.obj", "-o", "out/", *SIZE)
        self.nothing_left()

    def test_links_are_never_followed_while_an_output_is_written(self):
        self.ball()
        out = self.folder / "out"
        out.mkdir(mode=0o777)
        process = subprocess.Popen([support.BAKE, "ball.obj", "-o", "out/", "--size", "129", "--fit", "best"],
                                   cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 60
        while process.poll() is None and time.monotonic() < deadline:
            for entry in out.iterdir():
                if LEFT in entry.name:
                    self.assertEqual(entry.stat().st_mode & 0o777, 0o700)  # nobody else can plant a link in it
                    deadline = 0
        process.wait(timeout=120)
        self.assertEqual(deadline, 0, "its folder was seen")


class Names(Parents):
    def test_no_name_steers_the_terminal(self):
        evil = "b\x1b]0;t\x07\x9b31m.obj"
        self.ball(evil)
        self.bake_well(evil, *SIZE)
        name = evil.replace(".obj", ".dgm")
        for program, arguments in ((support.INFO, [name]), (support.INFO, [name, "none\x1b.dgm"]),
                                   (support.VALIDATE, [name]), (support.EXPORT, [name, "-o", "e\x1b.ply"]),
                                   (support.EXPORT, ["none\x1b.dgm", "-o", "e.ply"]), (support.BAKE, [evil, *SIZE])):
            with self.subTest(program=program, arguments=arguments):
                result = subprocess.run([program, *arguments], cwd=self.folder, capture_output=True, timeout=60)
                said = (result.stdout + result.stderr).decode("utf-8")
                self.assertEqual([c for c in said if ord(c) < 32 and c != "\n" or 0x7f <= ord(c) < 0xa0], [], said)

    def test_long_names_are_baked_or_refused_at_once(self):
        long = "n" * 250
        self.ball(long + ".obj")
        self.bake_well(long + ".obj", *SIZE)
        self.assertTrue((self.folder / (long + ".dgm")).is_file())
        result = self.bake(long + ".obj", *SIZE, "-o", "n" * 253 + ".dgm")
        self.code(result, 2, 5003)
        self.assertIn("longer", result.stderr)
        self.nothing_left()

    def test_a_backslash_is_refused_at_once_with_a_hint(self):
        self.ball("back\\slash.obj")
        self.ball()
        result = self.bake("back\\slash.obj", "ball.obj", "-o", "out/", *SIZE)
        self.code(result, 5, 6002)
        self.assertIn("rename the mesh", result.stderr)
        self.assertTrue((self.folder / "out" / "ball.dgm").is_file())


class MergedReports(Parents):
    def variants(self, whole):
        yield from (whole[:len(whole) * k // 24] for k in range(24))
        report = json.loads(whole)
        bad = [None, 7, -1, 1 << 70, "x", [], {}, [[]], True]
        for key in report:
            for value in bad:
                yield json.dumps({**report, key: value})
        for key in report["assets"][0]:
            for value in bad:
                yield json.dumps({**report, "assets": [{**report["assets"][0], key: value}]})
        yield json.dumps({**report, "left_over": [{"path": "x", "removed": 1}, {"path": "x", "removed": "y"}]})
        yield whole.replace('"ball.dgm"', '"\xff"')
        yield "[" * 200_000
        yield json.dumps({**report, "deep": 0}).replace('"deep": 0', '"deep": ' + "[" * 100_000 + "]" * 100_000)

    def test_damaged_reports_are_named_and_never_an_internal_error(self):
        self.ball()
        self.bake_well("ball.obj", *SIZE, "--report", "r.json")
        whole = (self.folder / "r.json").read_text()
        for k, text in enumerate(self.variants(whole)):
            (self.folder / "bad.json").write_bytes(text.encode("latin-1", "replace"))
            for report in ("m.json", "m.html") if k % 8 == 0 else ("m.json",):
                result = self.bake("--merge-reports", "bad.json", "--report", report, "-q")
                self.assertGreaterEqual(result.returncode, 0, text[:200])
                self.assertNotIn("DGM9001", result.stderr, text[:200])
                if "DGM" in result.stderr:
                    self.code(result, 3, 5008)
                    self.assertIn("bad.json", result.stderr)


class Validator(Parents):
    @unittest.skipIf(support.SANITIZED, "the address sanitizer needs unlimited address space")
    def test_layers_that_leave_no_room_are_not_read(self):
        self.ball()
        self.bake_well("ball.obj", "--size", "257", "--method", "stretch", "--fit", "sample", "-o", "a.dgm")
        self.bake_well("ball.obj", *SIZE, "-o", "b.dgm")
        size = (self.folder / "a.dgm").stat().st_size
        result = self.run_program(support.VALIDATE, "a.dgm", "b.dgm", "--memory-limit", 3 * size)
        self.code(result, 3, 3007)
        self.assertIn("bytes of memory", result.stdout)
        self.assertIn("b.dgm: ok", result.stdout)

    @unittest.skipIf(support.SANITIZED, "the address sanitizer needs unlimited address space")
    def test_limits_are_a_files_own(self):
        self.ball()
        meshes.write_obj(self.folder / "big.obj", meshes.icosphere(5))
        self.bake_well("big.obj", "--size", "257", "--method", "stretch", "--fit", "sample", "-o", "a.dgm")
        self.bake_well("ball.obj", *SIZE, "-o", "b.dgm")
        memory = (self.folder / "a.dgm").stat().st_size * 41 // 10  # room for the layers, but not for the checks
        for limit, code in ((f"--memory-limit={memory}", 9004), ("--time-limit=0.1", 9003)):
            source = ["--source", "big.obj"] if code == 9003 else []
            result = self.run_program(support.VALIDATE, "a.dgm", "b.dgm", limit, *source, "--report", "json=v.json")
            files = {f["file"]: f for f in json.loads((self.folder / "v.json").read_text())["files"]}
            self.assertEqual(len(files), 2, result.stdout)
            self.assertIn(f"DGM{code}", json.dumps(files["a.dgm"]), limit)
            if code == 9004:
                self.assertNotIn("DGM90", json.dumps(files["b.dgm"]))


if __name__ == "__main__":
    unittest.main()
