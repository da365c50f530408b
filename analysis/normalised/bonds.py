"""The parallel bonds of a run: how many hold after each cycle, and when and where the others broke.

An engine keeps broken bonds in its list, with the step in which they broke; its last list therefore tells the whole
story. Steps count from when the bonds were made, at the start of preload. Cycle 0 is preload.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pandas as pd

from analysis import files
from analysis.bond_law import SHEAR, TENSION
from analysis.formats import file_columns, table_file
from analysis.formats.errors import InputError, one_line
from analysis.formats.growing_csv import GrowingCsv
from analysis.scenarios import derived

COUNTS, BROKEN = "bonds.csv", "bonds_broken.csv"


def write(folder: Path, scenario, done: int) -> None:
    """Write bonds.csv and bonds_broken.csv of a run after `done` cycles; nothing where it has no bonds.

    InputError naming the raw file that is damaged.
    """
    raw = Path(folder) / "raw"
    lists = [raw / "bonds_preloaded.csv", *(raw / f"bonds_cycle_{n:06d}.csv" for n in range(1, done + 1))]
    present = [path for path in lists if path.exists()]
    if derived.bond(scenario) is None or not present:
        return
    rows = read_list(present[-1])
    preload = max(
        (int(row["step"]) for row in GrowingCsv(raw / "state.csv").new_rows() if row["stage"] == "preload"), default=0
    )
    per_cycle = derived.time_grid(scenario).steps_per_cycle
    broken = []
    for row in rows:
        if row["broken"] == "1":
            cycle = max(0, math.ceil((int(row["step"]) - preload) / per_cycle))
            broken.append((cycle, row["x_m"], row["y_m"], row["z_m"], row["mode"]))
    broken.sort(key=lambda row: row[0])
    _write(folder / BROKEN, file_columns.BONDS_BROKEN, broken)
    counts = []
    for cycle in range(done + 1):
        modes = [row[-1] for row in broken if row[0] <= cycle]
        counts.append((cycle, len(rows) - len(modes), modes.count(TENSION), modes.count(SHEAR)))
    _write(folder / COUNTS, file_columns.BOND_COUNTS, counts)


def read_broken(path: Path) -> pd.DataFrame:
    """bonds_broken.csv, see `file_columns.BONDS_BROKEN`; InputError where it is damaged."""
    try:
        frame = pd.read_csv(path, dtype={"mode": str}, encoding="ascii")
    except (OSError, ValueError, pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        raise InputError(path.name, allowed=f"{one_line(error)}; restore it from raw/") from None
    if tuple(frame) != file_columns.BONDS_BROKEN:
        raise InputError(path.name, "line 1:", allowed=f"expected {','.join(file_columns.BONDS_BROKEN)}")
    numbers = frame.drop(columns="mode").apply(pd.to_numeric, errors="coerce")
    good = np.isfinite(numbers.to_numpy(dtype=float)).all(axis=1) & frame["mode"].isin((TENSION, SHEAR)).to_numpy()
    if not good.all():
        line = int(np.argmin(good)) + 2
        raise InputError(path.name, f"line {line}:", allowed="expected a cycle, a place and tension or shear")
    return numbers.assign(mode=frame["mode"]).astype({"cycle": "int64"})


def read_list(path: Path) -> list[dict[str, str]]:
    """The bonds that an engine listed, cells as they stand there, see `file_columns.BONDS`.

    InputError where the list is damaged.
    """
    try:
        table_file.read(path, [name for name in file_columns.BONDS if name not in ("step", "mode")], None)
        with open(path, newline="", encoding="ascii") as file:
            reader = csv.DictReader(file.read().rpartition("\n")[0].split("\n"))
            rows = list(reader)
        if tuple(reader.fieldnames or ()) != file_columns.BONDS:
            raise InputError(path.name, "line 1:", allowed=f"expected {','.join(file_columns.BONDS)}")
        for number, row in enumerate(rows, start=2):
            holds = (row["broken"], row["step"], row["mode"]) == ("0", "-1", "")
            broke = row["broken"] == "1" and row["step"].isdecimal() and row["mode"] in (TENSION, SHEAR)
            if not (holds or broke) or len(row["step"]) > 15:
                raise InputError(
                    path.name, f"line {number}:", allowed="expected 0,-1, for a bond that holds, else 1, a step and how"
                )
    except InputError as error:
        raise InputError(f"raw/{error}") from None
    return rows


def _write(path: Path, columns: tuple[str, ...], rows) -> None:
    text = file_columns.header(columns) + "".join(",".join(map(str, row)) + "\n" for row in rows)
    files.write_aside(path, text)
