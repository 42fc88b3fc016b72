"""A Slurm of one host for the tests: Debian's daemons, as root, on the loopback, their files in one folder.

No accounting, no cgroups: jobs are ended by the clock, and by their memory, which is sampled each second.
"""

import os
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

DAEMONS = ("munged", "slurmctld", "slurmd")
CLIENTS = ("sbatch", "scancel", "scontrol", "sinfo", "squeue", "srun")
INSTALL = "apt-get install --no-install-recommends slurmctld slurmd slurm-client munge"
START_S = 60

CONFIGURATION = """\
ClusterName=mammosim
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SrunPortRange={ports[2]}-{ports[3]}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=1
JobAcctGatherParams=OverMemoryKill
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerParameters=sched_min_interval=100000
OverTimeLimit=0
KillWait=5
MinJobAge=600
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory={memory_mb} State=UNKNOWN
PartitionName=main Nodes={host} Default=YES MaxTime=INFINITE State=UP
PartitionName=long Nodes={host} MaxTime=INFINITE State=UP
"""


def lacking() -> str:
    """Why no Slurm can be started here, '' where one can."""
    if os.geteuid() != 0:
        return "slurmd runs the jobs of others, as root only"
    missing = [name for name in (*DAEMONS, *CLIENTS) if shutil.which(name, path=PATH) is None]
    return f"no {', '.join(missing)}: {INSTALL}" if missing else ""


PATH = f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin"


@dataclass(frozen=True)
class OneHost:
    """A running Slurm: environment of its commands."""

    environment: Mapping[str, str]

    def says(self, *command: str) -> str:
        """What one of its commands prints."""
        ended = subprocess.run(command, env=self.environment, text=True, capture_output=True, check=True)
        return ended.stdout

    def jobs(self, *, since: int = 0) -> list["Job"]:
        """Jobs with larger numbers, in the order of submission; Slurm forgets what ended 10 min ago."""
        rows = self.says("squeue", "--states=all", "--sort=i", "--noheader", "--format=%i|%T|%k|%P|%m")
        cells = [row.split("|") for row in rows.splitlines()]
        return [
            Job(int(number), state, comment, partition, megabytes(memory))
            for number, state, comment, partition, memory in cells
            if int(number) > since
        ]


@dataclass(frozen=True)
class Job:
    """What Slurm knows of a job."""

    number: int
    state: str
    comment: str
    partition: str
    memory_mb: int


def megabytes(text: str) -> int:
    """'1500M' or '3G' in MB."""
    return round(float(text[:-1]) * {"M": 1, "G": 1024}[text[-1]])


@contextmanager
def one_host_slurm(folder: Path, *, cpus: int, memory_mb: int) -> Iterator[OneHost]:
    """Start munged, slurmctld and slurmd, and end them, and what is left of their jobs, by their ids."""
    host = os.uname().nodename
    ports = free_ports()
    for name in ("state", "spool", "bin"):
        (folder / name).mkdir(parents=True)
    values = {"host": host, "folder": folder, "ports": ports, "cpus": cpus, "memory_mb": memory_mb}
    configuration = folder / "slurm.conf"
    configuration.write_text(CONFIGURATION.format(**values))
    environment = os.environ | {"SLURM_CONF": str(configuration), "PATH": f"{folder / 'bin'}:{PATH}"}
    environment |= {"LC_ALL": "C.UTF-8"}
    write_srun(folder / "bin/srun", configuration)
    with ExitStack() as stack:
        for name, arguments in daemons(folder).items():
            stack.enter_context(daemon(name, arguments, folder / f"{name}.log", environment))
        running = OneHost(environment)
        stack.callback(cancel_all, running)
        wait_for(
            "the node to be idle", lambda: " idle" in running.says("sinfo", "--noheader", "--format= %T")
        )
        yield running


def free_ports() -> list[int]:
    """Two ports that nobody listens on, and a range above for the answers of jobs."""
    with ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(2)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        taken = [each.getsockname()[1] for each in sockets]
    return [*taken, 61000, 61200]


def daemons(folder: Path) -> dict[str, list[str]]:
    """The arguments of each daemon, in the order of their start."""
    (folder / "munge.key").touch(mode=0o400)
    (folder / "munge.key").write_bytes(os.urandom(1024))
    socket_, key, pid, seed = (f"{folder}/munge.{what}" for what in ("socket", "key", "pid", "seed"))
    files = [f"--socket={socket_}", f"--key-file={key}", f"--pid-file={pid}", f"--seed-file={seed}"]
    return {"munged": ["--foreground", "--force", *files], "slurmctld": ["-D", "-i"], "slurmd": ["-D"]}


def write_srun(path: Path, configuration: Path) -> None:
    """A srun that finds its configuration: within a job, Snakemake takes SLURM_CONF from its environment."""
    path.write_text(f'#!/bin/sh\nSLURM_CONF="{configuration}" exec {shutil.which("srun")} "$@"\n')
    path.chmod(0o755)


@contextmanager
def daemon(name: str, arguments: list[str], log: Path, environment: Mapping[str, str]) -> Iterator[None]:
    """One process, ended by its id."""
    with log.open("w") as out:
        program = shutil.which(name, path=PATH)
        process = subprocess.Popen([str(program), *arguments], env=environment, stdout=out, stderr=out)
        try:
            if name == "munged":
                wait_for("munged", lambda: (log.parent / "munge.socket").exists())
            yield
        finally:
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(timeout=20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def cancel_all(running: OneHost) -> None:
    """Cancel what has not ended, and wait for it: the daemons end after their jobs."""
    subprocess.run(["scancel", "--me"], env=running.environment, check=False)
    wait_for("the jobs to end", lambda: not running.says("squeue", "--noheader").strip())


def wait_for(what: str, there) -> None:
    """Ask until it is there. Raises TimeoutError."""
    end = time.monotonic() + START_S
    while time.monotonic() < end:
        try:
            if there():
                return
        except subprocess.CalledProcessError:
            pass  # slurmctld does not answer yet
        time.sleep(0.5)
    raise TimeoutError(f"waited {START_S} s for {what}")
