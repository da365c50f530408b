"""Starts the driver as a user would, with the real engines or with the fake one."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from analysis.driver import checkpoints

ROOT = Path(__file__).resolve().parent.parent
FAKE = (sys.executable, str(ROOT / "tests" / "fake_driver.py"))
REAL = (sys.executable, "-m", "analysis", "run")
NORMALISED = ("cycles.csv", "history.csv", "microstructure.csv", "stages.json", "bed_before.csv", "bed_after.csv")


def start(driver: tuple[str, ...], *arguments, **options) -> subprocess.Popen:
    """Start the driver; its output is kept in pipes as text."""
    # Also where the tests run under `nohup`, which would be inherited.
    options.setdefault("preexec_fn", lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))
    return subprocess.Popen(
        [*driver, *map(str, arguments)], cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options
    )


def drive(driver: tuple[str, ...], *arguments, limit_s: float | None = 500, **options) -> subprocess.CompletedProcess:
    """Run the driver to its end, at most so many seconds."""
    process = start(driver, *arguments, **options)
    try:
        out, err = process.communicate(timeout=limit_s)
    except subprocess.TimeoutExpired:
        process.kill()  # its engine dies with it
        raise
    return subprocess.CompletedProcess(process.args, process.returncode, out, err)


def wait_until(condition: Callable[[], bool], complaint: str, seconds: float = 300) -> None:
    """Wait until `condition` holds, and fail with `complaint` if it does not."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, complaint
        time.sleep(0.01)


def wait_for(path: Path, process: subprocess.Popen, seconds: float = 300) -> None:
    """Wait until a file appears while `process` runs."""
    wait_until(lambda: path.exists() or process.poll() is not None, f"{path.name} did not appear", seconds)
    assert path.exists(), process.communicate()


def kill_until_done(driver: tuple[str, ...], arguments: list, folder: Path, moments: random.Random) -> int:
    """Start a run again and again, kill the driver (SIGKILL) some time after new output; return the number of kills.

    The first kill comes at once, the others at random, later and later, so that a run on any machine gets to its end.
    """
    state, longest_s = folder / "raw" / "state.csv", 0.3

    def size() -> int:
        return state.stat().st_size if state.exists() else 0

    for kills in range(30):
        before = size()
        process = start(driver, *arguments)
        end = time.monotonic() + 120
        while process.poll() is None and size() <= before:
            assert time.monotonic() < end, "the engine writes nothing"
            time.sleep(0.01)
        try:
            _, err = process.communicate(timeout=moments.uniform(0.0, longest_s) if kills else 0.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            wait_until(lambda: not engines_of(folder), "the engine lives on", seconds=60)
            longest_s *= 1.5
        else:
            assert process.returncode == 0, err
            return kills
    raise AssertionError("not finished after 30 kills")


def run_folder(results: Path, scenario: str, code: str, profile: str = "demo") -> Path:
    """Folder of a run with the default seed."""
    return results / profile / scenario / code


def results_of(folder: Path) -> dict[str, bytes]:
    """The normalised files, and run.json without what may differ between equal runs of the same code."""
    free = ("timing", "resumes", "parts", "repeatable", "command", "git_commit", "git_dirty")
    return {name: (folder / name).read_bytes() for name in NORMALISED} | {
        key: value for key, value in read_record(folder).items() if key not in free
    }


def read_record(folder: Path) -> dict:
    """Content of run.json."""
    return json.loads((folder / "run.json").read_text())


def steps(path: Path, stage: str = "cyclic") -> list[int]:
    """The column `step` of a raw file, of one stage."""
    header, *lines = path.read_text().splitlines()
    rows = [dict(zip(header.split(","), line.split(","), strict=True)) for line in lines]
    return [int(row["step"]) for row in rows if row.get("stage", stage) == stage]


def damage(path: Path) -> None:
    """Flip one byte in the middle of a file."""
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(content)


def latest(folder: Path) -> checkpoints.Checkpoint:
    """The latest checkpoint with a checksum."""
    return [c for c in checkpoints.listed(folder / "checkpoints") if c.is_certified()][-1]


def engines_of(folder: Path) -> list[int]:
    """Processes that have the run's folder on their command line and are not the driver."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = entry.read_bytes().split(b"\0")
        except OSError:
            continue
        if any(word.endswith(os.fsencode(folder)) for word in words):
            found.append(int(entry.parent.name))
    return found


def copy_run(source: Path, target: Path) -> Path:
    """Copy a run's folder, e.g. to damage it."""
    return shutil.copytree(source, target)
