"""The bed of a run at one moment: clumps, sleeper and plates where they stand, contacts where they were kept."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from analysis.formats import file_columns
from analysis.formats.errors import InputError
from analysis.normalised import beds
from analysis.normalised.frames import read_table
from analysis.normalised.microstructure import read_contacts
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario


class ViewError(ValueError):
    """A run that cannot be drawn; the message is one line with the remedy."""


class NoBed(ViewError):
    """A run without the bed that was asked for: not packed yet, or kept without beds."""


@dataclass(frozen=True)
class Scene:
    """A bed with sleeper and plates where they stand; `moved_m` (n, 3) is each clump's displacement, nan where
    unknown.
    """

    scenario: Scenario
    title: str
    bed: pd.DataFrame
    moved_m: np.ndarray | None
    sleeper: derived.Block
    plates: tuple[derived.Block, ...]
    contacts: pd.DataFrame | None

    @property
    def box(self) -> derived.Apparatus:
        return derived.apparatus(self.scenario)


def load_scene(folder: Path, label: str | int = "after") -> Scene:
    """The bed of a run folder: `packed`, `before` (end of preload), `after` (the last one there is) or that of a cycle.

    Raises NoBed where there is none, ViewError where it is damaged.
    """
    folder = Path(folder)
    cycle, path = _bed_file(folder, label)
    if not path.exists():
        raise NoBed(
            f"{path.name}: is not there; run it at least that far, or again where the run was kept without beds"
        )
    try:
        scenario = Scenario.read(folder / "scenario.json")
        bed = beds.read_bed(path)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ViewError(f"{' '.join(str(error).split())}; the bed is not drawn") from None
    down, out = _places(folder, cycle)
    box = derived.apparatus(scenario)
    title = {None: "after packing", 0: "after preload", 1: "after 1 cycle"}.get(cycle, f"after {cycle} cycles")
    contacts = {None: "packed", 0: "preloaded"}.get(cycle, f"cycle_{cycle or 0:06d}")
    return Scene(
        scenario,
        title,
        bed,
        _displacement(folder / "bed_before.csv", bed) if cycle else None,
        _shifted(box.sleeper, (0, 0, -down)),
        tuple(_shifted(plate, (shift, 0, 0)) for plate, shift in zip(box.plates, out, strict=True)),
        _contacts(folder / "raw" / f"contacts_{contacts}.csv"),
    )


def packed_scene(path: Path, scenario: Scenario) -> Scene:
    """The bed of a file given by itself, sleeper and plates where they stand after packing. Raises NoBed without it,
    ViewError where it is damaged.
    """
    if not path.exists():
        raise NoBed(f"{path.name}: is not there")
    try:
        bed = beds.read_bed(path)
    except (OSError, ValueError) as error:
        raise ViewError(f"{' '.join(str(error).split())}; the bed is not drawn") from None
    box = derived.apparatus(scenario)
    return Scene(scenario, "after packing", bed, None, box.sleeper, tuple(box.plates), None)


def _bed_file(folder: Path, label: str | int) -> tuple[int | None, Path]:
    """Cycle (None: packed, 0: end of preload) and file of a bed."""
    if label == "packed":
        return None, folder / "raw" / "bed_packed.csv"
    if label == "before":
        return 0, folder / "bed_before.csv"
    if label == "after":
        done = _cycles(folder)
        last = int(done.index[-1]) if len(done) else 0
        kept = [cycle for cycle in _kept(folder, "bed") if cycle <= last]
        if not kept or not last:
            return last, folder / "bed_after.csv"
        label = kept[-1]
    return int(label), folder / "raw" / f"bed_cycle_{int(label):06d}.csv"


def last_with_contacts(folder: Path) -> int | None:
    """The last cycle whose bed and contacts are both there."""
    return max(set(kept_cycles(folder)) & set(_kept(folder, "contacts")), default=None)


def kept_cycles(folder: Path) -> list[int]:
    """The finished cycles whose beds are there, in order."""
    done = set(_cycles(folder).index)
    return [cycle for cycle in _kept(folder, "bed") if cycle in done]


def _kept(folder: Path, what: str) -> list[int]:
    found = (path.stem.rpartition("_")[2] for path in (folder / "raw").glob(f"{what}_cycle_*.csv"))
    return sorted(int(number) for number in found if number.isdigit())


def _shifted(block: derived.Block, by) -> derived.Block:
    return derived.Block(
        tuple(a + b for a, b in zip(block.low, by, strict=True)),
        tuple(a + b for a, b in zip(block.high, by, strict=True)),
    )


def _cycles(folder: Path) -> pd.DataFrame:
    """Displacements of sleeper and plates (m) by cycle; no rows where there are none."""
    columns = ["settlement_m", *(f"lateral_{k}_m" for k in file_columns.PLATES)]
    try:
        return read_table(folder / "cycles.csv", file_columns.CYCLES).set_index("cycle")[columns]
    except InputError:
        return pd.DataFrame(columns=columns)


def _places(folder: Path, cycle: int | None) -> tuple[float, list[float]]:
    """How far the sleeper is down and each plate out since packing, m; what is not known counts as 0."""
    if cycle is None:
        return 0.0, [0.0] * len(file_columns.PLATES)
    columns = ["sleeper_displacement_m", *(f"plate_{k}_displacement_m" for k in file_columns.PLATES)]
    moved = np.zeros(len(columns))
    # Committed runs have no raw files: their preload displacement is not drawn.
    with contextlib.suppress(OSError, ValueError, IndexError):
        moved = moved + pd.read_csv(folder / "raw" / "cyclic.csv", usecols=columns, nrows=1)[columns].to_numpy(float)[0]
    done = _cycles(folder)
    if cycle in done.index:
        moved = moved + np.nan_to_num(done.loc[cycle].to_numpy(float))
    return float(moved[0]), [float(v) for v in moved[1:]]


def _displacement(before: Path, bed: pd.DataFrame) -> np.ndarray | None:
    try:
        start = beds.read_bed(before).set_index("id")[["x_m", "y_m", "z_m"]]
    except ValueError:
        return None
    return beds.positions(bed) - start.reindex(bed["id"]).to_numpy(float)


def _contacts(path: Path) -> pd.DataFrame | None:
    try:
        return read_contacts(path)
    except InputError:
        return None


def chain_lines(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Force chains: lines (n, 2, 3) between clump centres, or from a centre to the wall, and their normal forces, N."""
    if scene.contacts is None or scene.contacts.empty:
        return np.zeros((0, 2, 3)), np.zeros(0)
    places = pd.DataFrame(beds.positions(scene.bed), index=scene.bed["id"])
    contacts = scene.contacts
    start = places.reindex(contacts["clump_1"]).to_numpy()
    end = places.reindex(contacts["clump_2"]).to_numpy(copy=True)
    wall = contacts["clump_2"].to_numpy() == 0
    end[wall] = contacts[["x_m", "y_m", "z_m"]].to_numpy()[wall]
    lines, force = np.stack([start, end], axis=1), contacts["normal_force_N"].to_numpy()
    known = np.isfinite(lines).all((1, 2)) & np.isfinite(force)
    return lines[known], force[known]
