"""One engine process: it dies with the driver, is asked to stop once, and can be killed with all that it started."""

from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import signal
import subprocess
from pathlib import Path

from analysis.driver.engine import EngineError
from analysis.files import ROOT

PR_SET_PDEATHSIG = 1
STOPPED = 75  # exit code of an engine that stopped because it was asked to
LOG_TAIL_BYTES = 20_000
_libc = ctypes.CDLL(None)


class EngineProcess:
    """A running engine whose output goes to a log file."""

    def __init__(self, argv: list[str], log: Path, threads: int = 1):
        program = str(ROOT / argv[0]) if "/" in argv[0] else argv[0]
        if not shutil.which(program, path=os.environ.get("PATH", os.defpath)):
            raise EngineError(f"{Path(argv[0]).name}: not installed; run `make setup`")
        log.parent.mkdir(exist_ok=True)
        self.log = log
        environment = os.environ | {"OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": "1", "PYTHONHASHSEED": "0"}
        driver = os.getpid()

        def die_with_driver() -> None:
            _libc.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
            if os.getppid() != driver:
                os._exit(1)

        with open(log, "ab") as output:
            self._log_start = output.tell()
            self._process = subprocess.Popen(
                argv,
                cwd=ROOT,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env=environment,
                process_group=0,
                preexec_fn=die_with_driver,  # noqa: PLW1509 - the driver has one thread
            )
        self._is_launcher = Path(argv[0]).name == "mpirun"

    @property
    def pid(self) -> int:
        """Of the process, or of the launcher of its ranks."""
        return self._process.pid

    def wait(self, seconds: float) -> int | None:
        """Exit code, or None where it still runs after `seconds`."""
        try:
            return self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            return None

    def ask_to_stop(self) -> None:
        """Ask for a checkpoint and an orderly end: the ranks themselves, as mpirun would kill them on a signal."""
        targets = descendants(self._process.pid) if self._is_launcher else [self._process.pid]
        _signal(targets, signal.SIGTERM)

    def kill(self) -> None:
        """End it at once, with everything that it started."""
        _signal([*descendants(self._process.pid), self._process.pid], signal.SIGKILL)
        self._process.wait()

    def last_output(self) -> str:
        """The end of what this process has printed so far."""
        with open(self.log, "rb") as file:
            end = file.seek(0, os.SEEK_END)
            file.seek(max(self._log_start, end - LOG_TAIL_BYTES))
            return file.read().decode(errors="replace")


def descendants(pid: int) -> list[int]:
    """Processes that a process has started, and theirs."""
    children = []
    for entry in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            children += map(int, entry.read_text().split())
        except OSError:  # a thread or process that has just ended
            continue
    return [each for child in children for each in (child, *descendants(child))]


def _signal(pids: list[int], number: int) -> None:
    for pid in pids:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, number)
