# SPDX-License-Identifier: GPL-3.0-or-later
"""scripts/slurm/dgm-bake.sbatch on a real Slurm: one machine, a controller, two nodes, no accounting, in a folder that
goes away. Skipped, with the reason, only where Slurm cannot be started."""
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import meshes
import support
from test_batch import timeless

SIZE = ["--size", "33", "--method", "tutte", "--fit", "sample"]
SCRIPT = os.environ.get("DGM_SLURM_SCRIPT", "")
PROGRAMS = ["munged", "slurmctld", "slurmd", "sbatch", "squeue", "sinfo", "scontrol"]
SKIPPED = 77  # what CTest takes for a skipped test

CONFIGURATION = """
ClusterName=dgm
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
# A task that goes back to the queue waits until its credential has expired: two minutes by default, five seconds at
# least.
AuthInfo=socket={folder}/munge/socket,cred_expire=5
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
SchedulerParameters=batch_sched_delay=0,sched_interval=1
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/none
ReturnToService=2
NodeName=one NodeHostname={host} NodeAddr=127.0.0.1 Port={port_one} CPUs=1 RealMemory=1000
NodeName=two NodeHostname={host} NodeAddr=127.0.0.1 Port={port_two} CPUs=1 RealMemory=1000
PartitionName=bake Nodes=one,two Default=YES MaxTime=INFINITE State=UP
"""


class CannotStart(Exception):
    pass


class Cluster:
    """Munge, a controller and two nodes, all below one folder; ended by their process ids."""

    def __init__(self, folder):
        self.folder = folder
        self.environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf")}
        self.pid_files = []

    def run(self, *command, **options):
        return subprocess.run(list(map(str, command)), env=self.environment, capture_output=True, text=True,
                              timeout=60, check=False, **options)

    def daemon(self, pid_file, *command):
        result = self.run(*command)
        self.pid_files.append(self.folder / pid_file)
        if result.returncode != 0:
            raise CannotStart(f"{command[0]} ends with {result.returncode}: {(result.stdout + result.stderr).strip()}")

    def start(self):
        missing = [p for p in PROGRAMS if not shutil.which(p, path=os.environ["PATH"] + ":/usr/sbin:/sbin")]
        if missing:
            raise CannotStart("not installed: " + ", ".join(missing))
        if os.geteuid() != 0:
            raise CannotStart("slurmd needs root")
        self.environment["PATH"] += ":/usr/sbin:/sbin"
        for name in ("munge", "state", "spool-one", "spool-two"):
            (self.folder / name).mkdir()
        munge = self.folder / "munge"
        (munge / "key").write_bytes(os.urandom(1024))
        (munge / "key").chmod(0o400)
        # Two runs on one machine must not meet: the ports follow from the process id.
        port = 20000 + os.getpid() % 10000 * 3
        (self.folder / "slurm.conf").write_text(CONFIGURATION.format(
            host=os.uname().nodename.split(".")[0], folder=self.folder, port=port, port_one=port + 1,
            port_two=port + 2))
        self.daemon("munge/pid", "munged", f"--key-file={munge}/key", f"--socket={munge}/socket",
                    f"--pid-file={munge}/pid", f"--log-file={munge}/log", f"--seed-file={munge}/seed")
        self.daemon("slurmctld.pid", "slurmctld")
        for node in ("one", "two"):
            self.daemon(f"slurmd-{node}.pid", "slurmd", "-N", node)
        for _ in range(60):
            if self.run("sinfo", "-h", "-o", "%T %N").stdout.strip() == "idle one,two":
                return
            time.sleep(0.5)
        raise CannotStart("the nodes do not come up: " + self.run("sinfo").stdout + self.logs())

    def logs(self):
        return "".join(f"\n--- {log.name}\n" + "".join(log.read_text().splitlines(True)[-15:])
                       for log in sorted(self.folder.glob("*.log")))

    def stop(self):
        self.run("scancel", "--user=root", "--clusters=dgm") if (self.folder / "slurmctld.pid").exists() else None
        for pid_file in reversed(self.pid_files):
            if not pid_file.exists():
                continue
            process = int(pid_file.read_text())
            try:
                os.kill(process, signal.SIGTERM)
                for _ in range(100):
                    os.kill(process, 0)
                    time.sleep(0.1)
                os.kill(process, signal.SIGKILL)
            except ProcessLookupError:
                pass


class Slurm(support.Folder):
    def setUp(self):
        super().setUp()
        source = self.folder / "in"
        (source / "sub").mkdir(parents=True)
        for k in range(6):
            meshes.write_obj(source / "sub" / f"real-{k}.obj", meshes.sheet(6 + k))
        meshes.write_obj(source / "real-ball.obj", meshes.icosphere(2))
        meshes.write_obj(source / "real-bad.obj", meshes.line())
        meshes.write_obj(source / "killed-once.obj", meshes.torus(12, 8))
        self.local = self.bake("in", "-o", "local", *SIZE, "--report", "local.json")
        self.assertEqual(self.local.returncode, 3)
        shutil.move(self.folder / "local", self.folder / "expected")

    def contents(self, folder):
        return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*.dgm"))}

    def test_an_array_gives_what_one_machine_gives(self):
        cluster = CLUSTER
        submitted = cluster.run("sbatch", "--parsable", "--array=1-4", f"--output={self.folder}/task-%a.out",
                                f"--export=ALL,DGM_BAKE={support.FAULTY_BAKE},DGM_KILLED_MARK={self.folder}/mark", SCRIPT, "in", "-o", "local", *SIZE,
                                cwd=self.folder)
        self.assertEqual(submitted.returncode, 0, submitted.stderr)
        job = submitted.stdout.strip()
        deadline = time.monotonic() + 300
        while cluster.run("squeue", "-h", "-j", job).stdout.strip():
            self.assertLess(time.monotonic(), deadline, cluster.run("squeue").stdout + cluster.logs())
            time.sleep(0.5)
        said = {path.name: path.read_text() for path in sorted(self.folder.glob("task-*.out"))}
        self.assertEqual(len(said), 4)
        again = [text for text in said.values() if "back to the queue" in text]
        self.assertEqual(len(again), 1, said)  # the transient failure; the refused mesh is not tried again
        self.assertIn("DGM9006", again[0])
        self.assertEqual(again[0].count("back to the queue (1 of 3)"), 1)
        self.assertIn("DGM3001", "".join(said.values()))

        self.assertEqual(self.contents(self.folder / "local"), self.contents(self.folder / "expected"))
        self.assertEqual(len(self.contents(self.folder / "local")), 8)
        leftovers = [n for n in self.names(self.folder / "local") if ".dgm-" in n]
        self.assertEqual(leftovers, [])
        reports = sorted((self.folder / "local" / "reports").glob("*.json"))
        self.assertEqual([r.name for r in reports], [f"part-{k}-of-4.json" for k in (1, 2, 3, 4)])
        merged = self.bake("--merge-reports", *reports, "-o", "all.json")
        self.assertEqual(merged.returncode, 3, merged.stderr)
        all_report = timeless(json.loads((self.folder / "all.json").read_text()))
        local_report = timeless(json.loads((self.folder / "local.json").read_text()))
        for report in (all_report, local_report):  # baked in the first try of the second, it is up to date
            for asset in report["assets"]:
                asset["outcome"] = asset["outcome"].replace("up to date", "baked")
        self.assertEqual(all_report["assets"], local_report["assets"])
        self.assertEqual(all_report["exit_code"], 3)

    def test_a_wrong_array_is_refused(self):
        job = CLUSTER.run("sbatch", "--parsable", "--wait", "--array=2-3", f"--output={self.folder}/wrong-%a.out",
                          f"--export=ALL,DGM_BAKE={support.BAKE}", SCRIPT, "in", "-o", "out", cwd=self.folder)
        self.assertNotEqual(job.returncode, 0)
        self.assertIn("--array=1-2", (self.folder / "wrong-2.out").read_text())
        self.assertFalse((self.folder / "out").exists())


if __name__ == "__main__":
    ROOT = Path(tempfile.mkdtemp(prefix="dgm-slurm-")).resolve()
    ROOT.chmod(0o755)
    CLUSTER = Cluster(ROOT)
    try:
        try:
            CLUSTER.start()
        except CannotStart as reason:
            print(f"SKIPPED: Slurm cannot be started here: {reason}", flush=True)
            sys.exit(SKIPPED)
        unittest.main()
    finally:
        CLUSTER.stop()
        shutil.rmtree(ROOT, ignore_errors=True)
