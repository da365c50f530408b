"""What the driver asks of an engine, and the inputs that every engine reads.

The engines themselves are in `yade` and `liggghts`; nothing else in the driver knows which one it runs.
"""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Protocol

from analysis.files import write_aside
from analysis.formats import bed_file
from analysis.scenarios.lattice import lattice_bed
from analysis.scenarios.scenario import Scenario


class EngineError(RuntimeError):
    """An engine that cannot be used; the message is one line with the remedy."""


class Engine(Protocol):
    """One engine.

    name                name of the code, as on the command line and in folders
    checkpoint_suffix   ending of its checkpoints
    stages              names of the stages that `command` knows: those of a run, and others on a copy of one
    """

    name: str
    checkpoint_suffix: str
    stages: tuple[str, ...]

    def version(self) -> str:
        """Name and version of what is installed, e.g. `yade 2023.02a`. Raises EngineError where it is missing."""

    def refuses(self, folder: Path, ranks: int) -> str | None:
        """Why this engine cannot run in `folder` on so many cores, in one line with the remedy; None where it can."""

    def parallel(self, ranks: int) -> dict[str, int]:
        """MPI `ranks` and `threads` of a run on `ranks` cores."""

    def write_inputs(self, scenario: Scenario, folder: Path, seed: int) -> None:
        """Write all that the engine reads into the run's folder, and make the folders that it writes to."""

    def command(self, stage: str, folder: Path, checkpoint: Path | None = None, ranks: int = 1) -> list[str]:
        """Command line of one stage, to be started in the repository's root."""


def write_common_inputs(scenario: Scenario, folder: Path, seed: int) -> None:
    """What both engines read: scenario.json and raw/bed_start.csv, and the folders of a run."""
    for name in ("raw", "checkpoints", "log"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    write_bed(folder / "raw" / "bed_start.csv", lattice_bed(scenario, seed))
    write_aside(folder / "scenario.json", scenario.to_json())


def write_bed(path: Path, poses) -> None:
    """Write poses (x, y, z, qw, qx, qy, qz) as a common bed file with ids from 1."""
    bed_file.write(path, ((number, *pose) for number, pose in enumerate(poses, start=1)))


def package_version(package: str) -> str | None:
    """Version of an installed Debian package; None where there is none, or no Debian."""
    try:
        found = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", package], capture_output=True, text=True)
    except OSError:
        return None
    return found.stdout.strip() or None
