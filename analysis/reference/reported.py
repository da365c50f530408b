"""What the paper reports of its beds, from talebiahooie2021/reported.toml."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

from analysis.files import PUBLISHED
from analysis.formats import toml_file
from analysis.formats.errors import InputError
from analysis.reference.curves import REPORTED, ReferenceError

LARGEST = 1e6
"""More clumps than any bed of the paper has."""


@dataclass(frozen=True)
class Reported:
    """Numbers that the paper prints, to compare with."""

    clumps: int
    """Of the linear model."""
    clumps_nonlinear: int
    porosity: float
    """Under the sleeper, at the start; the paper says about."""

    @property
    def clumps_lost(self) -> int:
        """Clumps of the packed bed that the nonlinear model lacks."""
        return self.clumps - self.clumps_nonlinear


def reported(folder: Path = PUBLISHED) -> Reported:
    """All of them; raises ReferenceError with one line where the file cannot be used."""
    path = Path(folder) / "talebiahooie2021" / REPORTED
    try:
        table = toml_file.read(path)
    except InputError as error:
        raise ReferenceError(str(error)) from None
    known = {f.name for f in fields(Reported)}
    if set(table) != known:
        wrong = sorted(set(table) ^ known)[0]
        raise ReferenceError(
            f"{path.name}: {wrong} is {'unknown' if wrong in table else 'missing'}; it has {', '.join(sorted(known))}"
        )
    for name, entry in table.items():
        value = entry.get("value") if isinstance(entry, dict) else None
        number = type(value) in (int, float) and 0 < value <= LARGEST
        if not (number and entry.get("unit") == "-" and isinstance(entry.get("source"), str)):
            raise ReferenceError(
                f'{path.name}: {name}: allowed: a value above 0 and up to {LARGEST:g}, unit = "-" and source'
            )
    return Reported(**{name: entry["value"] for name, entry in table.items()})
