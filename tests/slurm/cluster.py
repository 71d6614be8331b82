"""A Slurm of this one machine: munged, slurmctld and slurmd, for the tests and for trying out.

`python -m tests.slurm.cluster` keeps it up until Ctrl-C. It needs root and Debian's packages
slurm-wlm and munge. Slurm reads its configuration from the default path, since the environment
is not passed on to jobs: a configuration that is already there belongs to a real cluster and is
left alone.
"""

import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

CONFIGURATION = Path("/etc/slurm/slurm.conf")
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "sinfo")
START_S = 30.0

# select/cons_tres: two jobs of one CPU share the node. proctrack/linuxproc and task/none:
# nothing that containers refuse, as cgroups do. MinJobAge: squeue still tells how a job ended.
# config_overrides: the node has what is said here, whatever the machine has.
MARK = "# of tests/slurm/cluster.py, process "
SLURM_CONF = (
    MARK
    + """{pid}, removed when it ends
ClusterName=one_machine
SlurmctldHost={host}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
SlurmctldPort={controller_port}
SlurmdPort={node_port}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
SlurmdParameters=config_overrides
SchedulerParameters=defer_batch,sched_min_interval=500000
MinJobAge=3600
ReturnToService=2
NodeName={host} NodeAddr=localhost CPUs={cpus} RealMemory={memory_mb} State=UNKNOWN
PartitionName=main Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""
)


class CannotStartError(Exception):
    """Slurm cannot be started here; the message says why."""


@contextmanager
def running(cpus: int = 2, memory_mb: int = 8000) -> Iterator[Path]:
    """Slurm with one node of `cpus` CPUs, as long as the context lasts; the folder of its logs.

    Raises:
        CannotStartError: not root, a program is missing, this machine has a Slurm already, or a
            daemon did not come up within `START_S`.
    """
    if os.geteuid() != 0:
        raise CannotStartError("its daemons need root")
    missing = [name for name in PROGRAMS if not _program(name)]
    if missing:
        raise CannotStartError(
            f"{', '.join(missing)} not installed (apt-get install slurm-wlm munge)"
        )
    if CONFIGURATION.exists() and not _left_behind(CONFIGURATION.read_text()):
        raise CannotStartError(f"{CONFIGURATION} is there already: not ours to replace")
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="slurm_")))
        os.chmod(folder, 0o755)
        for name in ("state", "spool"):
            (folder / name).mkdir()
        stack.callback(CONFIGURATION.unlink, missing_ok=True)
        CONFIGURATION.parent.mkdir(parents=True, exist_ok=True)
        CONFIGURATION.write_text(
            SLURM_CONF.format(
                pid=os.getpid(),
                host=socket.gethostname().split(".")[0],
                folder=folder,
                cpus=cpus,
                memory_mb=memory_mb,
                controller_port=_free_port(),
                node_port=_free_port(),
            )
        )
        _start_munge(folder, stack)
        for name in ("slurmctld", "slurmd"):
            stack.enter_context(_daemon(name, [_program(name), "-D"], folder))
        _wait(lambda: "idle" in _output("sinfo", "--noheader", "--format=%T"), "slurmd", folder)
        stack.callback(_output, "scancel", "--user=root")
        yield folder


def _left_behind(configuration: str) -> bool:
    """Whether a process wrote it that was killed since."""
    if not configuration.startswith(MARK):
        return False
    return not Path(f"/proc/{configuration.removeprefix(MARK).split(',')[0]}").exists()


def _start_munge(folder: Path, stack: ExitStack) -> None:
    """The service that signs Slurm's messages, with a key and socket of its own."""
    key = folder / "munge.key"
    key.write_bytes(os.urandom(128))
    key.chmod(0o400)
    socket_path = folder / "munge.socket"
    arguments = [_program("munged"), "--foreground", "--force", f"--key-file={key}"]
    arguments += [f"--socket={socket_path}", f"--pid-file={folder}/munge.pid"]
    arguments += [f"--seed-file={folder}/munge.seed", f"--log-file={folder}/munge.log"]
    stack.enter_context(_daemon("munged", arguments, folder))
    _wait(socket_path.exists, "munged", folder)


@contextmanager
def _daemon(name: str, arguments: list[str], folder: Path) -> Iterator[None]:
    with open(folder / f"{name}.out", "w") as log:
        process = subprocess.Popen(
            arguments, stdout=log, stderr=subprocess.STDOUT, start_new_session=True
        )
    try:
        yield
    finally:
        process.terminate()
        try:
            process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _wait(ready, daemon: str, folder: Path) -> None:
    start = time.monotonic()
    while not ready():
        if time.monotonic() - start > START_S:
            said = (folder / f"{daemon}.out").read_text()[-1500:]
            raise CannotStartError(f"{daemon} is not up after {START_S:.0f} s: {said}")
        time.sleep(0.2)


def _program(name: str) -> str | None:
    return shutil.which(name, path=f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin")


def _output(*arguments: str) -> str:
    return subprocess.run(arguments, capture_output=True, text=True).stdout


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("", 0))
        return probe.getsockname()[1]


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with running() as logs:
            print(f"Slurm is up, its logs in {logs}; Ctrl-C ends it", flush=True)
            signal.pause()
    except KeyboardInterrupt:
        print("Slurm has ended")
    except CannotStartError as error:
        raise SystemExit(f"Slurm cannot start here: {error}") from None
