"""The tables of a normalised run: their columns, number formats and plausible ranges, and an append-safe file.

Standard library only, so that whatever writes a run folder can use it.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from analysis import files

CODES = ("yade", "liggghts")
PLATES = range(1, 6)
SPHERES = range(1, 4)
EVERYTHING = float("inf")
"""The cycle up to which a table is kept when it is only to be repaired."""

CYCLES = (
    "cycle",
    "time_s",
    "settlement_m",
    "settlement_peak_m",
    *(f"lateral_{k}_m" for k in PLATES),
    *(f"porosity_{k}" for k in SPHERES),
    "sleeper_stress_min_Pa",
    "sleeper_stress_max_Pa",
    "tracking_rms_Pa",
    "clumps",
)

HISTORY = (
    "time_s",
    "cycle",
    "sleeper_target_Pa",
    "sleeper_stress_Pa",
    "settlement_m",
    "plate_target_Pa",
    *(f"plate_{k}_stress_Pa" for k in PLATES),
    *(f"lateral_{k}_m" for k in PLATES),
)

# Contact columns (from normal_force_mean_N on) are empty in cycles whose contacts were not kept.
MICROSTRUCTURE = (
    "cycle",
    *(f"porosity_{k}" for k in SPHERES),
    "porosity_error",
    "coordination_number",
    "neighbours_mean",
    "overlap_mean_m",
    "overlap_max_ratio",
    "rotation_mean_rad",
    "rotation_max_rad",
    "bulge_volume_m3",
    "shoulder_displacement_m",
    "downward_mean_m",
    "downward_under_sleeper_m",
    "crib_heave_m",
    "sliding_share",
    "at_limit_share",
    "kinetic_energy_J",
    "unbalanced_ratio",
    "normal_force_mean_N",
    "contact_anisotropy",
    "force_anisotropy",
    "fabric_xx",
    "fabric_yy",
    "fabric_zz",
    "force_chain_share",
    "force_chain_load_share",
)

BED = ("id", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")

CONTACTS = (
    "clump_1",
    "clump_2",
    "x_m",
    "y_m",
    "z_m",
    "nx",
    "ny",
    "nz",
    "overlap_m",
    "normal_force_N",
    "shear_force_N",
    "sliding",
)

RAW_LOADING = (
    "step",
    "time_s",
    "sleeper_target_Pa",
    "sleeper_stress_Pa",
    "sleeper_stress_mean_Pa",
    "sleeper_error_ms_Pa2",
    "sleeper_displacement_m",
    *(f"plate_{k}_{what}" for k in PLATES for what in ("stress_Pa", "stress_mean_Pa", "displacement_m")),
)

RAW_STATE = (
    "stage",
    "step",
    "time_s",
    "kinetic_energy_J",
    "unbalanced_ratio",
    "overlap_max_ratio",
    "overlap_mean_m",
    "contacts",
    "clumps",
    "at_limit_share",
    "sliding_share",
)

# Values outside are not physics but damage: the readers replace them by nan and say so. Wide on purpose.
_RANGES_BY_UNIT = {
    "_m": (-10.0, 10.0),
    "_m3": (-10.0, 10.0),
    "_Pa": (-1e9, 1e9),
    "_s": (0.0, 1e7),
    "_rad": (0.0, 3.2),
    "_N": (-1e8, 1e8),
    "_J": (0.0, 1e9),
    "_Pa2": (0.0, 1e18),
    "_share": (0.0, 1.0),
}
_RANGES_BY_NAME = {
    "cycle": (0.0, 1e8),
    "clumps": (0.0, 1e9),
    "step": (0.0, 1e15),
    "coordination_number": (0.0, 1e3),
    "neighbours_mean": (0.0, 1e3),
    "overlap_max_ratio": (0.0, 2.0),
    "unbalanced_ratio": (0.0, 1e12),
}


def plausible_range(column: str) -> tuple[float, float]:
    """Lowest and highest value of `column` that can be physics, in its own unit."""
    if column in _RANGES_BY_NAME:
        return _RANGES_BY_NAME[column]
    if column.startswith("porosity"):
        return 0.0, 1.0
    endings = [e for e in _RANGES_BY_UNIT if column.endswith(e)]
    return _RANGES_BY_UNIT[max(endings, key=len)] if endings else (-1e12, 1e12)


def cell(value) -> str:
    """A number as the tables hold it: the shortest text that reads back as the same double; nan is an empty cell."""
    if value != value:
        return ""
    return (
        str(int(value))
        if isinstance(value, int) or float(value).is_integer() and abs(value) < 1e15
        else repr(float(value))
    )


def short_cell(value) -> str:
    """A number with nine digits, for tables that are large and only looked at."""
    return "" if value != value else f"{value:.9g}"


class CycleTable:
    """A CSV file that grows by the rows of one cycle and survives being killed at any moment.

    A line without its newline was torn by a kill; it and every row after the last wanted cycle are cut off by `rewind`.
    Rows of cycle n are those whose column `cycle` is above n - 1 and at most n.
    """

    def __init__(self, path: Path, columns: Sequence[str], format_cell=cell):
        self.path, self.columns, self.format_cell = Path(path), tuple(columns), format_cell
        self._at = self.columns.index("cycle")

    @property
    def header(self) -> str:
        """The first line of the file."""
        return ",".join(self.columns) + "\n"

    def rewind(self, cycle: float) -> None:
        """Keep the header and the rows up to `cycle`; make the file where it is missing or its header is damaged."""
        try:
            content = self.path.read_bytes()
        except FileNotFoundError:
            content = b""
        if not content.startswith(self.header.encode()):
            files.write_aside(self.path, self.header)
            return
        end = len(content) if content.endswith(b"\n") else content.rfind(b"\n") + 1
        while end > len(self.header):
            start = content.rfind(b"\n", 0, end - 1) + 1
            if self._is_row_until(content[start:end], cycle):
                break
            end = start
        if end < len(content):
            with open(self.path, "r+b") as file:
                file.truncate(end)

    def _is_row_until(self, line: bytes, cycle: float) -> bool:
        cells = line.rstrip(b"\n").split(b",")
        try:
            return len(cells) == len(self.columns) and float(cells[self._at]) <= cycle
        except ValueError:
            return False

    def last_cycle(self) -> int | None:
        """Cycle of the last row of a file that `rewind` has been through; None without rows."""
        last = self.path.read_bytes()[-4096:].splitlines()[-1]
        return None if last == self.header.rstrip().encode() else int(float(last.split(b",")[self._at]))

    def append(self, rows: Iterable[Sequence[float]]) -> None:
        """Add rows (values in the order of the columns) in one write, and see them to the disk."""
        text = "".join(",".join(map(self.format_cell, row)) + "\n" for row in rows)
        with open(self.path, "ab", buffering=0) as file:
            file.write(text.encode())
            os.fsync(file.fileno())
