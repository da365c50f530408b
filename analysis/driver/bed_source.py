"""Where a run's bed comes from: a bed file of the command's, or the bed that another scenario's run packed."""

from __future__ import annotations

from pathlib import Path

from analysis.driver.settings import RunSettings
from analysis.driver.supervise import RunError
from analysis.files import write_aside
from analysis.formats import bed_file
from analysis.formats.errors import InputError
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario

BED_KEYS = ("geometry.", "clump.")  # a packed bed serves any scenario that has the same of these


def take(path: Path, settings: RunSettings) -> int:
    """Copy a packed bed into the run's folder after a look at it, and at the scenario of the run that it comes from.

    Returns its number of clumps. Raises RunError, naming file, line and remedy, for a bed that does not fit.
    """
    try:
        poses = bed_file.read(path)
    except InputError as error:
        raise RunError(f"{path.parent}/{error}") from None
    box = derived.apparatus(settings.scenario)
    size = (box.length_m, box.width_m, box.height_m)
    for pose in poses:
        if not all(0 <= value <= top for value, top in zip(pose.row[1:4], size, strict=True)):
            raise RunError(
                f"{path}: line {pose.line} lies outside the box of {size[0]:g} x {size[1]:g} x {size[2]:g} m; "
                "take a bed of the same profile and geometry"
            )
    made_with = path.parent.parent / "scenario.json"
    if made_with.exists():
        try:
            changes = Scenario.from_json(made_with.read_text()).changes(settings.scenario)
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
            raise RunError(f"{made_with}: cannot be read; restore it, or move the bed file elsewhere") from None
        if changes := [line for line in changes if line.startswith(BED_KEYS)]:
            raise RunError(f"{path}: does not fit: {'; '.join(changes)}; take a bed with the same geometry and clump")
    write_aside(settings.folder / "raw" / "bed_packed.csv", bed_file.text(path))
    return len(poses)
