"""The tables that the repository keeps of calibration, time steps, benchmark and verification, and the timings of a
benchmark: their columns, and one strict reader.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from analysis.formats.errors import InputError, reason
from analysis.formats.quantities import CODES, QUANTITIES, row_of
from analysis.formats.table_file import rows_of

LAWS = ("linear", "nonlinear")
LONGEST_TEXT = 2000

NAME = re.compile(r"\w[\w.+ -]*")
"""Names become names of figures and files."""
WORDS = re.compile(r".*")

TEXTS: Mapping[str, re.Pattern | tuple[str, ...]] = {
    "case": NAME,
    "code": CODES,
    "law": LAWS,
    "who": NAME,
    "part": WORDS,
    "scenario": NAME,
    "run": WORDS,
    "bed": WORDS,
    "state": NAME,
    "quantity": WORDS,
    "passed": ("true", "false"),
    "reason": WORDS,
}
"""Columns of words, and what may stand there."""

NUMBERS = {
    "seed": (1, 2**31 - 1),
    "ranks": (1, 10_000),
    "steps": (1, 1e15),
    "steps_per_cycle": (1, 1e15),
    "steps_per_cpu_s": (1e-6, 1e12),
    "steps_per_wall_s": (1e-6, 1e12),
    "cpu_s": (1e-6, 1e9),
    "wall_s": (1e-6, 1e9),
    "load_average": (0, 1e6),
    "ratio": (1e-6, 1e6),
    "share": (0, 1),
    "aspect": (1, 10),
    "lattice_gap_m": (-1, 1),
    "lattice_sites": (0, 1e9),
    "clumps_over_reported": (0, 1e6),
    "preload_settlement_m": (-10, 10),
    "cycles": (0, 1e8),
    "time_step_s": (1e-12, 1),
    "sleeper_work_J": (-1e12, 1e12),
    "expected": (-1e30, 1e30),
    "measured": (-1e30, 1e30),
    "abs_error": (0, 1e30),
    "rel_error": (0, math.inf),
    "tolerance": (0, 1e30),
}
"""Least and largest value of the numbers that are no quantity of a run."""


@dataclass(frozen=True)
class KeptTable:
    """One kind of table.

    columns   names, in the order of the file
    key       the columns by which a row is told from all others; without any, rows may be alike
    empty     columns that may be empty, or `nan`: what a run could not say
    command   what makes the table
    codes     what the column `code` may say
    """

    columns: tuple[str, ...]
    key: tuple[str, ...]
    command: str
    empty: tuple[str, ...] = ()
    codes: tuple[str, ...] = CODES


PACKED = (
    "clumps",
    *row_of("porosity_{}"),
    "porosity_mean",
    "coordination_number",
    "overlap_mean_m",
    "overlap_max_ratio",
    "normal_force_mean_N",
)
LOADED = ("settlement_m", "settlement_peak_m", "lateral_3_m")
CALIBRATION = KeptTable(
    (
        *("scenario", "code", "seed", "aspect", "lattice_gap_m", "lattice_sites", "clumps_over_reported"),
        *(*PACKED, "preload_settlement_m", "cycles", *LOADED, "state"),
    ),
    key=("scenario", "code", "seed", "aspect", "lattice_gap_m"),
    command="make calibrate",
    empty=("clumps_over_reported", *PACKED, "preload_settlement_m", *LOADED),
)
"""A row per bed and contact model."""

REACHED = ("settlement_m", *row_of("lateral_{}_m"), *row_of("porosity_{}"), "kinetic_energy_J", "sleeper_work_J")
TIMESTEP = KeptTable(
    (
        *("scenario", "case", "run", "time_step_s", "critical_step_s", "step_share", "seed", "ranks", "bed", "cycle"),
        *(*REACHED, "state"),
    ),
    key=("scenario", "case", "cycle"),
    command="make timestep",
    empty=("run", "critical_step_s", "step_share", "bed", *REACHED),
)
"""A row per run and shown cycle."""

BENCHMARK = KeptTable(("case", "code", "law", "steps_per_cpu_s", "ratio"), ("case", "code", "law"), "make bench")
BENCHMARK_SIZES = KeptTable(
    ("code", "law", "clumps", "ranks", "steps_per_cpu_s", "steps_per_wall_s"),
    ("code", "law", "clumps", "ranks"),
    "make bench",
    empty=("steps_per_wall_s",),
)
BENCHMARK_PROFILE = KeptTable(("code", "law", "part", "share"), ("code", "law", "part"), "make bench")
TIMINGS = KeptTable(
    ("code", "law", "who", "clumps", "ranks", "steps", "steps_per_cycle", "cpu_s", "wall_s", "load_average"),
    (),
    "make bench",
    empty=("wall_s",),
)
"""A row per timing."""

VERIFICATION = KeptTable(
    ("code", "case", "quantity", "expected", "measured", "abs_error", "rel_error", "tolerance", "passed", "reason"),
    (),
    "make verify",
    empty=("expected", "measured", "abs_error", "rel_error", "tolerance", "reason"),
    codes=(*CODES, "analysis"),
)
"""A row per comparison."""


def read(path: Path, table: KeptTable) -> dict[str, list]:
    """Its columns as lists: words as they stand, whole numbers as int, others as float, empty ones as nan or ``.

    Raises InputError, one line, where the file cannot be read or anything of it is damaged.
    """
    path, remedy = Path(path), f"restore the file, or run {table.command} again"
    try:
        text = path.read_bytes().decode()
        rows = list(csv.reader(io.StringIO(text, newline=""), strict=True))
    except (OSError, ValueError, csv.Error) as error:
        raise InputError(path.name, allowed=f"cannot be read ({reason(error)}); {remedy}") from None
    if not rows or not text.endswith("\n"):
        raise InputError(path.name, allowed=f"is {'torn at its end' if rows else 'empty'}; {remedy}")
    header, *lines = rows
    found: dict[str, list] = {name: [] for name in table.columns}
    seen = set()
    for number, cells in rows_of(path.name, header, lines, table.columns, remedy):
        for name, cell in cells.items():
            found[name].append(_value(path.name, f"line {number}: {name}", cell, table, name, remedy))
        row = tuple(found[name][-1] for name in table.key)
        if row and row in seen:
            raise InputError(path.name, f"line {number}", allowed=f"is there twice; {remedy}")
        seen.add(row)
    if not lines:
        raise InputError(path.name, allowed=f"has no row; {remedy}")
    return found


def _value(file: str, key: str, cell: str, table: KeptTable, name: str, remedy: str) -> str | float:
    if name in TEXTS:
        return _text(file, key, cell, table, name, remedy)
    if name in table.empty and cell in ("", "nan"):
        return math.nan
    low, high = NUMBERS.get(name) or (QUANTITIES[name].low, QUANTITIES[name].high)
    try:
        value = (int(cell) if cell.isdecimal() and len(cell) < 16 else float(cell)) if "_" not in cell else math.nan
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise InputError(file, key, cell, f"a number from {low:g} to {high:g}; {remedy}")
    return value


def _text(file: str, key: str, cell: str, table: KeptTable, name: str, remedy: str) -> str:
    allowed = table.codes if name == "code" else TEXTS[name]
    if isinstance(allowed, tuple):
        good, what = cell in allowed, " or ".join(allowed)
    else:
        good = cell.isprintable() and len(cell) <= LONGEST_TEXT and bool(allowed.fullmatch(cell) if cell else False)
        good, what = good or (not cell and name in table.empty), "a name" if allowed is NAME else "words"
    if not good:
        raise InputError(file, key, cell, f"{what}; {remedy}")
    return cell
