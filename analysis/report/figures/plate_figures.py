"""What the law that holds the plates decides."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.normalised.readers import Run
from analysis.report.figure import Figure, Gallery
from analysis.report.figures.lateral_figures import lateral_figure
from analysis.report.figures.settlement_figures import settlement_figure
from analysis.report.labels import short_name


def plate_figures(gallery: Gallery, runs: Sequence[Run], base: str, profile: str, cycle: int) -> list[Figure | None]:
    """Settlement, and displacement of the plates after the first cycle and `cycle`, of runs under several laws."""
    name = f"plates-{base}-{profile}"
    settlement = settlement_figure(
        gallery,
        runs,
        name,
        f"{short_name(base)}: settlement under three laws of the plates",
        "Plates driven by the difference of force (the default), by PFC's servo, or not moving at all; from the same "
        "packed bed.",
        references=False,
    )
    lateral = lateral_figure(
        gallery,
        runs,
        f"{name}-lateral",
        f"{short_name(base)}: plates under three laws",
        "Lateral displacement over depth since the end of preload.",
        cycles=sorted({1, cycle}),
        references=False,
    )
    return [settlement, lateral]
