"""Measured settlement as shapes over cycles, from settlement_shapes/shapes.toml."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.files import PUBLISHED
from analysis.formats import toml_file
from analysis.reference.curves import ReferenceError, citation_keys, require_texts


@dataclass(frozen=True)
class SettlementShape:
    """A measured curve as a shape: `ratios`, strain over that after the last cycle, at `cycles`."""

    id: str
    label: str
    source: str
    condition: str
    cycles: tuple[float, ...]
    ratios: tuple[float, ...]

    def ratio(self, cycles, reference_cycle: float | None = None) -> np.ndarray:
        """Strain after `cycles` over that after `reference_cycle`, at most the last measured one (default); nan outside
        the measured cycles.

        Between the points on a line over the logarithm of the cycles.
        """
        last = self.cycles[-1] if reference_cycle is None else min(reference_cycle, self.cycles[-1])

        def shape(n):
            return np.interp(np.log(np.asarray(n, dtype=float)), np.log(self.cycles), self.ratios, np.nan, np.nan)

        return shape(cycles) / shape(last)


@dataclass(frozen=True)
class SettlementShapes:
    """All shapes, and what is known of them: where they come from, their weakness, what they can and cannot decide."""

    shapes: tuple[SettlementShape, ...]
    quantity: str
    status: str
    provenance: str
    weakness: str
    decides: str
    cannot_decide: str

    def least_and_largest(self, cycle: float) -> tuple[float, float]:
        """The range of the ratios after `cycle` over all shapes that reach it."""
        values = [float(value) for s in self.shapes if np.isfinite(value := s.ratio(cycle))]
        return min(values), max(values)


def settlement_shapes(folder: Path = PUBLISHED) -> SettlementShapes:
    """The shapes of settlement_shapes/shapes.toml, checked; raises ReferenceError with one line."""
    path = Path(folder) / "settlement_shapes" / "shapes.toml"
    try:
        content = toml_file.read(path)
        shapes = tuple(
            SettlementShape(
                entry["id"],
                entry["label"],
                entry["source"],
                entry["condition"],
                tuple(map(float, entry["cycles"])),
                tuple(map(float, entry["ratio"])),
            )
            for entry in content["shape"]
        )
        found = SettlementShapes(shapes, **content["about"])
        for shape in shapes:
            require_texts(shape.id, shape.label, shape.source, shape.condition)
        require_texts(*content["about"].values())
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise ReferenceError(
            f"{path.name}: cannot be used ({error}); [about] has quantity, status, provenance, weakness, decides and "
            "cannot_decide, each [[shape]] id, label, source, condition, cycles and ratio"
        ) from None
    known = citation_keys(path.with_name("reference.bib"))
    for shape in shapes:
        cycles, ratios = np.array(shape.cycles), np.array(shape.ratios)
        usable = len(cycles) == len(ratios) >= 2 and cycles[0] >= 1 and (np.diff(cycles) > 0).all()
        if not usable or not (np.diff(ratios) > 0).all() or ratios[0] <= 0 or ratios[-1] != 1:
            raise ReferenceError(
                f"{path.name}: {shape.id}: cycles and ratio are refused; allowed: as many cycles, rising from 1 or "
                "more, as ratios, rising from above 0 to 1"
            )
        if shape.source not in known:
            raise ReferenceError(f"{path.name}: {shape.id}: source {shape.source!r} is not in reference.bib; add it")
    return found
