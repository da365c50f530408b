"""Where a run's bed comes from: a bed file of the command's, or the bed that another scenario's run packed."""

from __future__ import annotations

from pathlib import Path

from analysis.driver.settings import RunSettings
from analysis.driver.supervise import RunError
from analysis.files import write_aside
from analysis.formats import bed_file
from analysis.formats.errors import InputError
from analysis.scenarios.scenario import Scenario, ScenarioError

BED_KEYS = ("geometry.", "clump.")  # a packed bed serves any scenario that has the same of these


def take(path: Path, settings: RunSettings) -> int:
    """Copy a packed bed into the run's folder after a look at it, and at the scenario of the run that it comes from.

    Returns its number of clumps. Raises RunError, naming file, line and remedy, for a bed that does not fit.
    """
    from analysis.normalised.beds import check_fits  # here: its libraries take a second to load

    try:
        clumps, text = check_fits(path, settings.scenario), bed_file.text(path)
    except InputError as error:
        raise RunError(f"{path.parent}/{error}") from None
    made_with = path.parent.parent / "scenario.json"
    if made_with.exists():
        try:
            changes = Scenario.read(made_with).changes(settings.scenario)
        except ScenarioError as error:
            raise RunError(f"{made_with.parent}/{error}; or move the bed file elsewhere") from None
        if changes := [line for line in changes if line.startswith(BED_KEYS)]:
            raise RunError(f"{path}: does not fit: {'; '.join(changes)}; take a bed with the same geometry and clump")
    write_aside(settings.folder / "raw" / "bed_packed.csv", text)
    return clumps
