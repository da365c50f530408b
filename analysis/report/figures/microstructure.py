"""What happens inside the bed, from the columns of microstructure.csv."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.normalised.readers import Run
from analysis.report import style
from analysis.report.curves import curve_rows, cycle_axis, draw, last_cycle_of
from analysis.report.figure import Figure, Gallery


def microstructure_figure(
    g: Gallery,
    runs: Sequence[Run],
    name: str,
    title: str,
    caption: str,
    quantities: Sequence[tuple[str, str, float, str]],
) -> Figure | None:
    """Columns of microstructure.csv against cycles, one panel each: (column, axis label, factor, unit)."""
    curves = [curve for curve in g.curves(runs) if len(curve.main.microstructure)]
    drawn = []
    for column, label, factor, unit in quantities:
        c = style.canvas(f"{name}-{column}", label, width=3.7, height=2.6)
        for curve in curves:
            seeds = curve.seeds(column, "microstructure")
            draw(c, curve, curve.column(column, "microstructure"), factor, seeds=seeds)
        if not c.series:
            continue
        c.axes.set_ylabel(label)
        c.hover_unit = unit
        cycle_axis(c, last_cycle_of(curves), False)
        c.table = curve_rows(curves, ["cycle", column], "microstructure")
        drawn.append(c)
    return g.finish(name, title, caption, drawn, runs, curves)
