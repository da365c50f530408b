"""A run's folder: where it is, and how far the run in it got."""

from __future__ import annotations

from pathlib import Path

from analysis.formats.errors import InputError
from analysis.formats.file_columns import CYCLES
from analysis.scenarios.scenario import Scenario, ScenarioError

STAGES = ("packing", "preload", "cyclic")
NORMALISED = ("bed_before.csv", "stages.json", "cycles.csv", "microstructure.csv", "history.csv", "bed_after.csv")


def run_folder(results: Path, profile: str, scenario: str, code: str, seed: int) -> Path:
    """Folder of a run of a scenario, given by its id (variants included); the default seed 1 is not in its name."""
    return results / profile / scenario / (code if seed == 1 else f"{code}-seed{seed}")


def cycles_done(folder: Path) -> int:
    """Number of complete cycles in a run's cycles.csv: rows 1, 2, 3 ... that are whole.

    A row without its newline was torn by a kill and does not count. Raises InputError for anything else that is not a
    table of cycles.
    """
    try:
        content = (folder / "cycles.csv").read_bytes()
    except FileNotFoundError:
        return 0
    remedy = "restore the file, or delete the run with `make distclean-run`"
    header, *lines = content.split(b"\n")[:-1] or [b""]
    if not lines and not content.endswith(b"\n"):
        return 0  # killed before the header was out
    if header.decode("utf-8", "replace") != ",".join(CYCLES):
        raise InputError(folder / "cycles.csv", "line 1", allowed=f"is not the header of a table of cycles; {remedy}")
    for number, line in enumerate(lines, start=1):
        cells = line.split(b",")
        if len(cells) != len(CYCLES) or cells[0] != str(number).encode():
            raise InputError(
                folder / "cycles.csv", f"line {number + 1}", allowed=f"is not the row of cycle {number}; {remedy}"
            )
    return len(lines)


def cycles_asked(folder: Path) -> int:
    """Number of cycles that a run was last asked for; 0 without a run."""
    try:
        return Scenario.from_json((folder / "scenario.json").read_text())["loading.cycles"]
    except (OSError, ScenarioError):
        return 0
