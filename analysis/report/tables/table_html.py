"""Words, numbers and tables of the report: what pages are made of, and nothing about HTML but the coloured word."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from analysis.comparison.findings.columns import label_of_column
from analysis.formats.numbers import readable as number
from analysis.report.labels import READING_NAMES, short_name, variant_name
from analysis.report.style import CODE_NAMES


@dataclass(frozen=True)
class Column:
    """Heading of a table's column; numbers stand to the right, `wide` ones hold sentences."""

    title: str
    number: bool = False
    wide: bool = False


@dataclass
class Table:
    """Rows of texts under their columns."""

    caption: str
    columns: list[Column]
    rows: list[list] = field(default_factory=list)
    note: str = ""


@dataclass(frozen=True)
class Chip:
    """A word in a coloured box: kind is good, bad, open or calm."""

    text: str
    kind: str


@dataclass(frozen=True)
class Link:
    """A word that leads somewhere."""

    text: str
    href: str


def shown(value) -> str:
    """A parameter's value for people."""
    if isinstance(value, list):
        return ", ".join(shown(v) for v in value)
    if isinstance(value, float):
        return number(value, 6)
    return str(value) if value != "" else "–"


def heading_of(name: str) -> str:
    """Label of a quantity or of a finding's column, with the unit that it is shown in."""
    label, unit, _ = label_of_column(name)
    return f"{label}, {unit}" if unit else label


def unbroken(name: str) -> str:
    """A name that may break after a comma, nowhere else."""
    return name.replace(" ", "\N{NO-BREAK SPACE}").replace(",\N{NO-BREAK SPACE}", ", ")


WORDS: dict[str, Callable[[Any], str]] = {
    "scenario": lambda name: unbroken(short_name(name)),
    "variant": variant_name,
    "reading": lambda reading: unbroken(READING_NAMES[reading]),
    "code": lambda code: CODE_NAMES.get(code, code),
    "quantity": lambda name: heading_of(name),
    **dict.fromkeys(("run", "bed", "law", "part"), str),
}
"""Columns that hold words, and how they are shown."""

COUNTS = ("cycle", "cycles", "beds", "clumps", "ranks", "points", "band_pairs", "seed")
COUNTS += ("bonds_made", "bonds_broken_tension", "bonds_broken_shear")
"""Columns that hold whole numbers, shown with all digits."""


def run_of(row) -> str:
    """Scenario with its variants, code and seed of a row, in words."""
    name = short_name("+".join(filter(None, (row.scenario, getattr(row, "variant", "")))))
    return f"{name}, {CODE_NAMES.get(row.code, row.code)}{f', seed {row.seed}' if row.seed != 1 else ''}"


@dataclass(frozen=True)
class Shown:
    """A column of a frame in a table. Heading, unit and factor are those of the registries, see `label_of_column`.

    name     column of the frame
    label    in place of the registry's, without the unit
    digits   significant digits of a number
    like     registered name whose label and unit the column has
    in_unit  column that names the quantity, whose unit the row's number has
    bare     the caption says the unit
    text     makes the cell from the row
    """

    name: str
    label: str = ""
    digits: int = 3
    like: str = ""
    in_unit: str = ""
    bare: bool = False
    text: Callable[[Any], str | Chip | Link] | None = None
    number: bool = True
    wide: bool = False

    @property
    def column(self) -> Column:
        """The heading."""
        label, unit, _ = label_of_column(self.like or self.name)
        if self.bare or self.in_unit or not self.number or self.name in (*COUNTS, *WORDS):
            unit = ""
        heading = ", ".join(filter(None, (self.label or label, unit)))
        return Column(heading, self.number and self.name not in WORDS, self.wide)

    def cell(self, row) -> str | Chip | Link:
        """What stands in the row of a frame, a named tuple."""
        if self.text:
            return self.text(row)
        value = getattr(row, self.name)
        if self.name in WORDS:
            return WORDS[self.name](value)
        if not self.number:
            return str(value) if value == value and value != "" else "–"
        if self.name in COUNTS:
            return str(int(value)) if value == value else "–"
        known = getattr(row, self.in_unit) if self.in_unit else self.like or self.name
        return number(value, self.digits, label_of_column(known)[2])


def between(low: str, high: str, label: str, digits: int = 3, word: str = " to ") -> Shown:
    """A column that tells a range: the values of two columns of the frame, of one unit, in a cell."""
    factor = label_of_column(low)[2]

    def text(row) -> str:
        ends = getattr(row, low), getattr(row, high)
        return word.join(number(end, digits, factor) for end in ends) if all(map(math.isfinite, ends)) else "–"

    return Shown(low, label, text=text)


def frame_table(frame: pd.DataFrame, caption: str, columns: Sequence[str | Shown], note: str = "") -> Table | None:
    """A table with a row per row of the frame; None where it has none.

    A bare name is shown as the registries have it.
    """
    if frame.empty:
        return None
    shown_ = [Shown(one) if isinstance(one, str) else one for one in columns]
    rows = [[one.cell(row) for one in shown_] for row in frame.itertuples()]
    return Table(caption, [one.column for one in shown_], rows, note)
