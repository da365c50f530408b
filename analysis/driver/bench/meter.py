"""Steps per second of processor time of a running engine, between two rows of a file that it appends to."""

from __future__ import annotations

import csv
import os
import time
from dataclasses import dataclass
from pathlib import Path

from analysis.driver.engine import EngineError
from analysis.driver.process import EngineProcess, descendants

POLL_S = 0.005
TICKS_PER_S = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Speed:
    """What was measured: `steps` steps took so much time of all processors together, and on the clock."""

    steps: int
    cpu_s: float
    wall_s: float


def processor_seconds(pid: int) -> float:
    """Processor time that a process and all that it started have used, s."""
    total = 0
    for each in (pid, *descendants(pid)):
        try:
            fields = Path(f"/proc/{each}/stat").read_text().rpartition(")")[2].split()
        except OSError:  # just ended
            continue
        total += int(fields[11]) + int(fields[12])
    return total / TICKS_PER_S


def measure(argv: list[str], log: Path, rows: Path, steps: int, threads: int = 1) -> Speed:
    """Run `argv` until it has made at least `steps` steps after its first row, then end it.

    rows     a CSV file with the column `step`, which the engine appends to while it runs; removed before
    Raises EngineError where the engine ends before that.
    """
    rows.unlink(missing_ok=True)
    engine, first = EngineProcess(argv, log, threads), None
    try:
        while True:
            ended = engine.wait(POLL_S) is not None
            now, spent, step = time.monotonic(), processor_seconds(engine.pid), last_step(rows)
            if step and first is None:
                first = step, spent, now
            elif step and step - first[0] >= steps:
                return Speed(step - first[0], spent - first[1], now - first[2])
            if ended:
                raise EngineError(f"{' '.join(argv)}: ended before step {steps}; read {log}")
    finally:
        engine.kill()


def last_step(rows: Path) -> int:
    """Step of the last complete row; 0 without one."""
    try:
        with open(rows, newline="", encoding="utf-8") as file:
            lines = file.read().rpartition("\n")[0].splitlines()
    except OSError:
        return 0
    found = [row["step"] for row in csv.DictReader(lines)]
    return int(found[-1]) if found else 0
