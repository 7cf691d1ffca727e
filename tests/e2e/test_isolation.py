# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults in a worker stay in it: crash, hang, memory, nonsense. Runs dgm-bake-faulty (faulty_bake.cpp)."""
import os
import signal
import subprocess
import time
import unittest

import support


class Isolation(support.Folder):
    def touch(self, *names):
        for name in names:
            (self.folder / f"{name}.obj").write_text("a mesh that misbehaves\n")
        return [f"{name}.obj" for name in names]

    def run_faulty(self, *arguments):
        return self.bake(*arguments, program=support.FAULTY_BAKE)

    def check_one(self, fault, exit_code, code, words, *arguments):
        """The faulty asset fails with this code, its neighbours are baked, nothing else stays behind."""
        inputs = self.touch("a", fault, "z")
        result = self.run_faulty(*inputs, "-o", "out", *arguments)
        self.assertEqual(result.returncode, exit_code, result.stdout + result.stderr)
        self.assertIn(f"dgm-bake: {fault}.obj: ", result.stderr)
        self.assertIn(f" DGM{code}: ", result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)
        self.assertIn("3 assets: 2 baked, 1 ", result.stdout)
        self.assertEqual(self.names(self.folder / "out"), ["a.dgm", "z.dgm"])
        self.assertTrue(self.workers_gone())
        return result

    def test_segfault(self):
        self.check_one("segfault", 4, 9002, ["cut: ", "signal 11"])

    def test_abort_tells_what_the_library_said(self):
        self.check_one("abort", 4, 9002, ["signal 6", "it said: free(): invalid pointer"])

    def test_processor_time(self):
        self.check_one("processor-time", 3, 9003, ["processor time", "--time-limit"])

    def test_hang(self):
        start = time.monotonic()
        self.check_one("hang", 3, 9003, ["after 1 s", "--time-limit"], "--time-limit", "1")
        self.assertLess(time.monotonic() - start, 20)

    def test_hang_with_everything_closed(self):
        self.check_one("hang-deaf", 3, 9003, ["after 1 s"], "--time-limit", "1")

    @unittest.skipIf(support.SANITIZED, "the address sanitizer needs unlimited address space")
    def test_memory(self):
        self.check_one("memory", 3, 9004, ["512 MiB", "--memory-limit"], "--memory-limit", "512MiB")

    @unittest.skipIf(support.SANITIZED, "the address sanitizer needs unlimited address space")
    def test_memory_that_a_library_turns_into_a_crash(self):
        self.check_one("memory-abort", 3, 9004, ["512 MiB"], "--memory-limit", "512MiB")

    def test_exit_without_a_word(self):
        self.check_one("quit", 4, 9002, ["exit code 0"])
        self.check_one("quit-5", 4, 9002, ["exit code 5"])

    def test_exception_of_a_library(self):
        self.check_one("throw", 4, 9001, ["_M_range_check"])

    def test_endless_line(self):
        self.check_one("babble", 4, 9002, ["not a message"])

    def test_claimed_result_without_a_file(self):
        self.check_one("lie", 2, 5003, ["write: "])

    def test_refusal(self):
        self.check_one("refuse", 3, 3002, ["component 2 has one side only"])

    def test_library_that_prints_on_stdout(self):
        result = self.run_faulty(*self.touch("chatty"), "-o", "out")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(len(result.stdout.splitlines()), 1)
        self.assertRegex(result.stdout, r"^out/chatty\.dgm: [a-z ]+, max \S+ % \(\S+ units\), rms 0\.01 % \(0\.00015 units\), uv 3x3, ")

    def test_old_file_survives_a_crash(self):
        self.touch("segfault")
        (self.folder / "segfault.dgm").write_bytes(b"the good old file")
        self.assertEqual(self.run_faulty("segfault.obj").returncode, 4)
        self.assertEqual((self.folder / "segfault.dgm").read_bytes(), b"the good old file")
        self.assertEqual(self.names(), ["segfault.dgm", "segfault.obj"])

    def test_nothing_baked_leaves_no_folder(self):
        self.touch("segfault")
        self.assertEqual(self.run_faulty("segfault.obj", "-o", "out").returncode, 4)
        self.assertEqual(self.names(), ["segfault.obj"])

    def start_hanging(self):
        inputs = self.touch("a", "hang")
        process = subprocess.Popen([support.FAULTY_BAKE, *inputs, "-o", "out", "-j1"], cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.kill)
        self.assertTrue(process.stdout.readline().startswith("out/a.dgm: "))
        deadline = time.monotonic() + 20
        while len(self.processes()) < 4 and time.monotonic() < deadline:
            time.sleep(0.02)
        self.assertEqual(len(self.processes()), 4)  # the parent, its readers of HDF5 and EXR, and the hanging worker
        return process

    def test_signals_leave_nothing(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(signal=number):
                process = self.start_hanging()
                process.send_signal(number)
                _, errors = process.communicate(timeout=20)
                self.assertEqual(process.returncode, 130)
                self.assertIn("DGM9005", errors)
                self.assertIn("1 baked, 1 interrupted", errors)
                self.assertEqual(self.names(), ["a.obj", "hang.obj", "out", "out/a.dgm"])
                self.assertTrue(self.workers_gone())

    def test_workers_die_with_their_parent(self):
        process = self.start_hanging()
        os.kill(process.pid, signal.SIGKILL)
        process.wait(timeout=20)
        self.assertTrue(self.workers_gone())

    def test_reader_of_the_results_leaves(self):
        inputs = self.touch("a", "b", "c")
        read_end, write_end = os.pipe()
        os.close(read_end)
        with os.fdopen(write_end, "w") as out:
            result = subprocess.run([support.FAULTY_BAKE, *inputs, "-o", "out"], cwd=self.folder, stdout=out,
                                    stderr=subprocess.PIPE, text=True, timeout=60, check=False)
        self.assertEqual(result.returncode, 2)
        self.assertIn("standard output", result.stderr)
        self.assertEqual(self.names(self.folder / "out"), ["a.dgm", "b.dgm", "c.dgm"])

    def test_worker_flag_by_hand(self):
        result = self.run_faulty("--worker")
        self.assertEqual(result.returncode, 1)
        self.assertIn("not for use by hand", result.stderr)


if __name__ == "__main__":
    unittest.main()
