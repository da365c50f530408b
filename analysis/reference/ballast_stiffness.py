"""Published stiffness of ballast under half a sleeper, from ballast_stiffness/stiffness.toml."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from analysis.files import PUBLISHED
from analysis.formats import toml_file
from analysis.reference.curves import ReferenceError, citation_keys, require_texts


@dataclass(frozen=True)
class BallastStiffness:
    """One published value, N/m, and where it stands."""

    id: str
    value_N_m: float
    source: str
    status: str
    note: str


def ballast_stiffness(folder: Path = PUBLISHED) -> list[BallastStiffness]:
    """All values, softest first; raises ReferenceError with one line where the file cannot be used."""
    path = Path(folder) / "ballast_stiffness" / "stiffness.toml"
    try:
        found = [BallastStiffness(**entry) for entry in toml_file.read(path)["stiffness"]]
        for one in found:
            require_texts(one.id, one.source, one.status, one.note)
    except (KeyError, TypeError, ValueError) as error:
        raise ReferenceError(
            f"{path.name}: cannot be used ({error}); each [[stiffness]] has id, value_N_m, source, status and note"
        ) from None
    known = citation_keys(path.with_name("reference.bib"))
    for one in found:
        if not (isinstance(one.value_N_m, float) and math.isfinite(one.value_N_m) and one.value_N_m > 0):
            raise ReferenceError(f"{path.name}: {one.id}: value_N_m = {one.value_N_m!r}; allowed: above 0")
        if one.source not in known:
            raise ReferenceError(f"{path.name}: {one.id}: source {one.source!r} is not in reference.bib; add it")
    return sorted(found, key=lambda one: one.value_N_m)
