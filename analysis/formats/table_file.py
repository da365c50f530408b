"""Normalised tables, read strictly: a damaged one is refused in a line that names file, line and column.

The last line counts only with its newline: without it, it was torn by a kill and is not there.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from analysis.formats.errors import InputError, reason
from analysis.formats.quantities import QUANTITIES

REMEDY = "restore the file, or move the run away and run it again"


def read(path: Path, columns: Sequence[str], whole: bool | None = True) -> dict[str, list[float]]:
    """The columns of a table as lists of floats, nan where a cell is empty that may be; further columns are ignored.

    whole   column `cycle` holds whole numbers, each one more than the one before; False: rising ones; None: there is
            no such column
    Raises InputError for a file that cannot be read, lacks a column, or has a line or a value that cannot be.
    """
    path = Path(path)
    header, lines = _lines(path)
    table: dict[str, list[float]] = {name: [] for name in columns}
    for number, row in rows_of(path.name, header, (line.split(",") for line in lines), columns, REMEDY):
        for name, cell in row.items():
            table[name].append(_value(path, number, name, cell))
    if whole is not None:
        _check_order(path, table["cycle"], whole)
    return table


def rows_of(
    file: str, header: Sequence[str], lines: Iterable[Sequence[str]], columns: Sequence[str], remedy: str
) -> Iterator[tuple[int, dict[str, str]]]:
    """Each line's number in the file and its cells by column; `lines` are those below the header, in cells.

    Raises InputError where a column is missing or there twice, or where a line has not as many cells as the header.
    """
    for name in columns:
        if header.count(name) != 1:
            what = f"column {name} is {'there twice' if name in header else 'missing'}"
            raise InputError(file, "line 1:", allowed=f"{what}; {remedy}")
    places = {name: header.index(name) for name in columns}
    for number, cells in enumerate(lines, start=2):
        if len(cells) != len(header):
            what = f"has {len(cells)} values instead of {len(header)}"
            raise InputError(file, f"line {number}", allowed=f"{what}; {remedy}")
        yield number, {name: cells[place] for name, place in places.items()}


def is_torn(path: Path) -> bool:
    """True where the last line has no newline, so that it does not count; InputError where it cannot be read."""
    try:
        with open(path, "rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - 1))
            return size > 0 and file.read(1) != b"\n"
    except OSError as error:
        raise InputError(Path(path).name, allowed=f"cannot be read ({reason(error)}); {REMEDY}") from None


def last_cycle(path: Path, columns: Sequence[str]) -> int:
    """Complete cycles of a table, 0 without the file; InputError where its rows are damaged or out of order."""
    try:
        cycles = read(path, columns)["cycle"]
    except InputError:
        if not Path(path).exists():
            return 0
        raise
    return int(cycles[-1]) if cycles else 0


def _lines(path: Path) -> tuple[list[str], list[str]]:
    """Header and complete lines."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(path.name, allowed=f"cannot be read ({reason(error)}); {REMEDY}") from None
    try:
        text = content.decode("ascii")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(path.name, f"line {line}", allowed=f"holds bytes that are no text; {REMEDY}") from None
    *lines, _ = text.split("\n")
    if not lines:
        raise InputError(path.name, allowed=f"is empty; {REMEDY}")
    return lines[0].split(","), lines[1:]


def _value(path: Path, number: int, name: str, cell: str) -> float:
    quantity = QUANTITIES[name]
    if not cell and quantity.empty:
        return float("nan")
    try:
        value = float(cell) if "_" not in cell else None
    except ValueError:
        value = None
    if value is None or not quantity.accepts(value):
        raise InputError(
            path.name, f"line {number}: {name}", cell, f"a number from {quantity.low:g} to {quantity.high:g}; {REMEDY}"
        )
    return value


def _check_order(path: Path, cycles: list[float], whole: bool) -> None:
    for k, cycle in enumerate(cycles):
        before = cycles[k - 1] if k else None
        wrong = before is not None and cycle <= before
        if whole:
            wrong = cycle % 1 != 0 or (cycle != before + 1 if before is not None else cycle not in (0, 1))
        if wrong:
            after = "at the start" if before is None else f"after cycle {before:g}"
            raise InputError(path.name, f"line {k + 2}", allowed=f"is cycle {cycle:g} {after}; {REMEDY}")
