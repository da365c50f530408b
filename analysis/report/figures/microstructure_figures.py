"""What happens inside the bed, from the columns of microstructure.csv."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.formats.quantities import QUANTITIES
from analysis.normalised.readers import Run
from analysis.report import style
from analysis.report.curve_drawing import curve_rows, cycle_axis, draw, last_cycle_of
from analysis.report.figure import Figure, Gallery

SHOWN = (
    "coordination_number",
    "overlap_mean_m",
    "overlap_max_ratio",
    "sliding_share",
    "rotation_mean_rad",
    "crib_heave_m",
    "bulge_volume_m3",
    "kinetic_energy_J",
    "unbalanced_ratio",
)
"""Columns of microstructure.csv, a panel each; label and unit are those of formats/quantities.py."""


def microstructure_figure(gallery: Gallery, runs: Sequence[Run], name: str) -> Figure | None:
    """The columns SHOWN against cycles."""
    curves = [curve for curve in gallery.curves(runs) if len(curve.main.microstructure)]
    drawn = []
    for column in SHOWN:
        quantity = QUANTITIES[column]
        c = style.canvas(f"{name}-{column}", quantity.heading, width=3.7, height=2.6)
        for curve in curves:
            seeds = curve.seeds(column, "microstructure")
            draw(c, curve, curve.column(column, "microstructure"), quantity.factor, seeds=seeds)
        if not c.series:
            continue
        c.axes.set_ylabel(quantity.heading)
        c.hover_unit = quantity.shown_unit
        cycle_axis(c, last_cycle_of(curves), False)
        c.table = curve_rows(curves, ["cycle", column], "microstructure")
        drawn.append(c)
    return gallery.finish(
        name,
        "Inside the bed",
        "Kinetic energy and unbalanced ratio say how far from rest the bed still is at minimum load.",
        drawn,
        runs,
        curves,
    )
