"""What the law that holds the plates decides."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from analysis.comparison.findings.members import Member
from analysis.report.figure import Figure, Gallery
from analysis.report.figures.lateral_figures import lateral_figure
from analysis.report.figures.settlement_figures import settlement_figure
from analysis.report.labels import short_name


def plate_figures(gallery: Gallery, found: Iterable[Member], rows: pd.DataFrame) -> list[Figure | None]:
    """Settlement, and displacement of the plates after the first cycle and the one of `rows`, which are those of one
    profile and scenario in `Findings.plate_laws`; `found` are the runs that these come from.
    """
    profile, base, cycle = rows[["profile", "scenario", "cycle"]].iloc[0]
    name, runs = f"plates-{base}-{profile}", [m.run for m in found if m.run.id in set(rows["run"])]
    settlement = settlement_figure(
        gallery,
        runs,
        name,
        f"{short_name(base)}: settlement under three laws of the plates",
        "Plates driven by the difference of force (the default), by PFC's servo, or not moving at all; from the same "
        "packed bed.",
        references=False,
        to_cycle=int(cycle),
    )
    lateral = lateral_figure(
        gallery,
        runs,
        f"{name}-lateral",
        f"{short_name(base)}: plates under three laws",
        "Lateral displacement over depth since the end of preload.",
        cycles=sorted({1, int(cycle)}),
        references=False,
    )
    return [settlement, lateral]
