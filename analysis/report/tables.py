"""Words, numbers and tables of the report: what pages are made of, and nothing about HTML but the coloured word."""

from __future__ import annotations

from dataclasses import dataclass, field

from analysis.formats.numbers import readable as number
from analysis.formats.quantities import QUANTITIES, SHOWN_UNITS


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


def interval(fit, name: str, factor: float) -> str:
    """A fitted parameter with its confidence interval."""
    if fit is None:
        return "–"
    low, high = fit.intervals[name]
    return f"{number(fit.values[name], 3, factor)} ({number(low, 3, factor)} to {number(high, 3, factor)})"


def quantity_name(name: str, unit: str) -> tuple[str, float, str]:
    """(label with the unit it is shown in, factor from SI, that unit)."""
    quantity = QUANTITIES.get(name)
    if quantity:
        return quantity.heading, quantity.factor, quantity.shown_unit
    shown, factor = SHOWN_UNITS.get(unit, (unit, 1.0))
    label = name.replace("_", " ")
    return (f"{label}, {shown}" if shown else label), factor, shown
