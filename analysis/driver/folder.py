"""A run's folder: where it is, and how far the run in it got."""

from __future__ import annotations

from pathlib import Path

from analysis.formats import table_file
from analysis.formats.errors import InputError
from analysis.formats.file_columns import CYCLES
from analysis.scenarios.scenario import Scenario

STAGES = ("packing", "preload", "cyclic")
NORMALISED = (
    "bed_before.csv",
    "stages.json",
    "cycles.csv",
    "microstructure.csv",
    "history.csv",
    "bed_after.csv",
    "bonds.csv",
    "bonds_broken.csv",
)


def run_folder(results: Path, profile: str, scenario: str, code: str, seed: int) -> Path:
    """Folder of a run of a scenario, given by its id (variants included); the default seed 1 is not in its name."""
    return results / profile / scenario / (code if seed == 1 else f"{code}-seed{seed}")


def cycles_done(folder: Path) -> int:
    """Number of complete cycles in a run's cycles.csv; InputError where it is damaged.

    A row without its newline was torn by a kill and does not count.
    """
    try:
        return table_file.last_cycle(folder / "cycles.csv", CYCLES)
    except InputError as error:
        raise InputError(folder / error.file, error.key, error.value, error.allowed) from None


def cycles_asked(folder: Path) -> int:
    """Number of cycles that a run was last asked for; 0 without a run. ScenarioError where scenario.json is damaged."""
    path = folder / "scenario.json"
    return Scenario.read(path)["loading.cycles"] if path.exists() else 0
