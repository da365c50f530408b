"""Settlement against cycles, and its shape beside published laws."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.normalised.readers import Run
from analysis.reference.settlement_laws import settlement_laws
from analysis.reference.settlement_shapes import settlement_shapes
from analysis.report import style
from analysis.report.curve_drawing import (
    curve_rows,
    cycle_axis,
    draw,
    draw_references,
    from_zero,
    last_cycle_of,
    pending_mark,
    pending_names,
    reference_csv,
    reference_rows,
    up_to,
    with_start,
)
from analysis.report.figure import Figure, Gallery
from analysis.report.labels import MM
from analysis.report.style import SOFT


def settlement_figure(
    gallery: Gallery,
    runs: Sequence[Run],
    name: str,
    title: str,
    caption: str,
    references: bool = True,
    log_only: bool = False,
    to_cycle: int | None = None,
) -> Figure | None:
    """Settlement at minimum load against cycles, to the end of the runs or `to_cycle`, on a linear and on a logarithmic
    axis.
    """
    curves = gallery.curves(runs)
    if not curves:
        return None
    scenarios = {curve.scenario for curve in curves}
    pending = pending_names(gallery.references, "settlement", scenarios) if references else []
    rows = reference_rows(gallery.references, "settlement", scenarios if references else ())
    rows = rows if references else rows.iloc[:0]
    points = reference_csv(rows, cycle="cycle", settlement_m="value", error_m="error")
    last = last_cycle_of(curves) if to_cycle is None else to_cycle
    drawn = []
    for log in (True,) if log_only else (False, True):
        c = style.canvas(
            f"{name}-{'log' if log else 'linear'}", f"{title}, {'logarithmic' if log else 'linear'} cycle axis"
        )
        for curve in curves:
            table = curve.column("settlement_m").loc[:last]
            seeds = {seed: values.loc[:last] for seed, values in curve.seeds("settlement_m").items()}
            draw(c, curve, table if log else with_start(table), MM, seeds=seeds if log else from_zero(seeds))
        draw_references(c, rows[rows["cycle"] > 0] if log else up_to(rows, last), "cycle", MM)
        c.axes.invert_yaxis()
        c.axes.set_ylabel("settlement at minimum load, mm")
        c.hover_unit = "mm"
        cycle_axis(c, max(last, rows["cycle"].max()) if log and len(rows) else last, log)
        pending_mark(c, pending, rows)
        c.table = pd.concat([curve_rows(curves, ["cycle", "settlement_m", "settlement_peak_m"]), points])
        drawn.append(c)
    return gallery.finish(name, title, caption, drawn, runs, curves, pending)


def shape_figure(gallery: Gallery, runs: Sequence[Run], name: str, title: str, caption: str) -> Figure | None:
    """Settlement over that after the first cycle, with published laws: shapes alone."""
    curves = [curve for curve in gallery.curves(runs) if curve.main.cycles["cycle"].max() >= 2]
    if not curves:
        return None
    c = style.canvas(name, title, right=1.9)
    last, frames = last_cycle_of(curves), []
    for curve in curves:
        table = curve.column("settlement_m")[["value"]]
        first = table["value"].get(1, np.nan)
        if not first > 0:
            continue
        draw(c, curve, pd.DataFrame(dict.fromkeys(("value", "low", "high"), table["value"] / first)), 1.0)
        frames.append(pd.DataFrame({"cycle": table.index, "shape": table["value"] / first, "curve": curve.main.id}))
    cycles = np.geomspace(1, max(last, 2), 60)
    for law in settlement_laws():
        shape = law.ratio(cycles)
        c.axes.plot(cycles, shape, color=SOFT, linewidth=1, linestyle=(0, (3, 1.5)), zorder=1)
        c.labels.append((cycles[-1], shape[-1], law.label, SOFT))
        frames.append(pd.DataFrame({"cycle": cycles, "shape": shape, "curve": law.id}))
    c.axes.set_ylabel("settlement over that after the first cycle")
    cycle_axis(c, last, True)
    c.table = pd.concat(frames, ignore_index=True)
    return gallery.finish(name, title, caption, [c], [curve.main for curve in curves], curves)


def measured_shape_figure(gallery: Gallery, runs: Sequence[Run], name: str, title: str) -> Figure | None:
    """Settlement over that after a late cycle, beside strains measured in triaxial tests: shapes alone."""
    known = settlement_shapes()
    curves = gallery.curves(runs)
    reached = [n for n in (10, 100, 1000) if n <= last_cycle_of(curves)] if curves else []
    if not reached:
        return None
    reference, frames = reached[-1], []
    c = style.canvas(name, title, right=1.9)
    for curve in curves:
        values = curve.main.cycles.set_index("cycle")["settlement_m"]
        if not values.get(reference, 0) > 0:
            continue
        shape = values[values.index <= reference] / values[reference]
        draw(c, curve, pd.DataFrame(dict.fromkeys(("value", "low", "high"), shape)), 1.0)
        frames.append(pd.DataFrame({"cycle": shape.index, "shape": shape, "curve": curve.main.id}))
    for n, measured in enumerate(known.shapes):
        at = np.array([k for k in measured.cycles if k <= reference] or [measured.cycles[0]])
        ratio = measured.ratio(at, reference)
        colour = style.shade("reference")
        c.axes.plot(at, ratio, "osD^"[n % 4], color=colour, markersize=4, linestyle=(0, (1, 1.5)), linewidth=1)
        c.labels.append((at[-1], ratio[-1], measured.label, colour))
        frames.append(pd.DataFrame({"cycle": at, "shape": ratio, "curve": measured.id}))
    c.axes.set_ylim(0, 1.05)
    c.axes.set_ylabel(f"settlement over that after {reference} cycles")
    cycle_axis(c, reference, True)
    c.table = pd.concat(frames, ignore_index=True)
    caption = (
        f"Dotted: triaxial tests of ballast, named by confinement and deviator stress; {known.quantity}, "
        f"{known.status}, "
        "over that after the last measured cycle where a test ended before. Only shapes can be compared."
    )
    return gallery.finish(name, title, caption, [c], [curve.main for curve in curves], curves)
