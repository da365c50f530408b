"""Checkpoints of the cyclic stage and the checksums that make them trustworthy.

The engine writes checkpoints/cyclic_<cycle>[_block<b>].<suffix>; the driver adds <checkpoint>.json once all output up
to that moment is safe on the disk. A checkpoint without it does not count.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from analysis.files import sync, write_aside
from analysis.formats import json_file
from analysis.formats.errors import InputError
from analysis.scenarios.derived import TimeGrid

KEEP = 2  # besides the one that preload ends with, so that one can be damaged
NAME = re.compile(r"cyclic_(\d{6,})(?:_block(\d+))?\.(?:restart|yade\.gz)")


@dataclass(frozen=True, order=True)
class Checkpoint:
    """State after `cycle` complete cycles and `block` blocks of the next one; block > 0 only after a stop."""

    cycle: int
    block: int
    path: Path

    def step(self, grid: TimeGrid) -> int:
        """Steps of the cyclic stage at this state."""
        return self.cycle * grid.steps_per_cycle + self.block * grid.steps_per_block

    @property
    def sidecar(self) -> Path:
        """The file with the checksum."""
        return self.path.with_name(self.path.name + ".json")

    def is_certified(self) -> bool:
        """True once `certify` was called; says nothing of damage since then."""
        return self.sidecar.exists()

    def is_good(self) -> bool:
        """True where content and checksum agree."""
        try:
            return json_file.read(self.sidecar).get("sha256") == _sha256(self.path)
        except (OSError, InputError):
            return False

    def certify(self, grid: TimeGrid, *outputs: Path) -> None:
        """Write the checksum, after the checkpoint and the output files up to it are on the disk."""
        sync(self.path, *outputs)
        body = {
            "sha256": _sha256(self.path),
            "cycle": self.cycle,
            "block": self.block,
            "step": self.step(grid),
            "bytes": self.path.stat().st_size,
        }
        write_aside(self.sidecar, json.dumps(body))

    def delete(self) -> None:
        """Remove checkpoint and checksum, the checksum first."""
        self.sidecar.unlink(missing_ok=True)
        self.path.unlink(missing_ok=True)

    def __str__(self) -> str:
        return f"cycle {self.cycle}" + (f", block {self.block}" if self.block else "")


def _sha256(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def listed(folder: Path) -> list[Checkpoint]:
    """All checkpoints of a run's folder in the order of time, trustworthy or not."""
    found = []
    for path in folder.glob("cyclic_*"):
        if match := NAME.fullmatch(path.name):
            found.append(Checkpoint(int(match[1]), int(match[2] or 0), path))
    return sorted(found)


def last_good(
    folder: Path,
    before_cycle: int,
    warn: Callable[[str], None],
    has_output: Callable[[Checkpoint], bool] = lambda checkpoint: True,
) -> Checkpoint | None:
    """The latest good checkpoint with fewer than `before_cycle` cycles whose output up to it is there.

    `warn` is told of those after it that are damaged or have lost their output.
    """
    for checkpoint in reversed(listed(folder)):
        if checkpoint.cycle >= before_cycle or not checkpoint.is_certified():
            continue
        if not checkpoint.is_good():
            warn(f"checkpoints/{checkpoint.path.name} is damaged (its checksum differs): the one before it is used")
        elif not has_output(checkpoint):
            warn(f"checkpoints/{checkpoint.path.name} is of no use: the rows in raw/ end before it")
        else:
            return checkpoint
    return None


def forget_after(folder: Path, kept: Checkpoint | None) -> None:
    """Delete every checkpoint later than `kept`, or all."""
    for checkpoint in listed(folder):
        if kept is None or checkpoint > kept:
            checkpoint.delete()


def prune(folder: Path) -> None:
    """Keep cycle 0 and the last scheduled ones; one written on a stop goes as soon as a scheduled one follows."""
    certified = [c for c in listed(folder) if c.is_certified()]
    scheduled = [c for c in certified if not c.block and c.cycle]
    for checkpoint in certified:
        passed = scheduled and checkpoint.block and checkpoint < scheduled[-1]
        if passed or checkpoint in scheduled[:-KEEP]:
            checkpoint.delete()
