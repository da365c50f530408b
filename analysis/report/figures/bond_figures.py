"""Parallel bonds: how many broke by which cycle, and where."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.patches import Rectangle

from analysis.comparison.findings.bond_counts import bond_counts
from analysis.normalised.readers import Run
from analysis.report import style
from analysis.report.curve_drawing import cycle_axis, draw, last_cycle_of
from analysis.report.figure import Figure, Gallery, run_id
from analysis.report.labels import MM, short_name
from analysis.report.style import CODE_NAMES, SOFT
from analysis.scenarios import derived

WHEN = (
    ("in preload", 0, 0, SOFT, 0.0),
    ("in cycle 1", 1, 1, "md2", 0.0),
    ("in cycles 2 to 10", 2, 10, "nonlinear", -0.6),
    ("later", 11, None, "nonlinear", 1.0),
)
"""When a bond broke: words, first and last cycle, hue, level."""


def bond_figures(gallery: Gallery, runs: Sequence[Run]) -> list[Figure | None]:
    """How many bonds broke by which cycle, and where."""
    made = "Of bonds made at the end of packing; cycle 0 is the end of preload."
    where = "Each dot is a bond, at its place when it broke; all of the bed's depth is seen. Grey: sleeper and plates."
    return [
        bonds_figure(gallery, runs, "bonds", "Bonds broken", made),
        broken_bonds_figure(gallery, runs, "broken-bonds", "Where bonds broke", where),
    ]


def bonds_figure(gallery: Gallery, runs: Sequence[Run], name: str, title: str, caption: str) -> Figure | None:
    """Share of bonds broken so far against cycles; one panel."""
    runs = [run for run in runs if len(run.bonds)]
    curves = gallery.curves(runs)
    if not curves:
        return None
    c = style.canvas(name, title)
    for curve in curves:
        seeds = {run.seed: bond_counts(run).set_index("cycle")["broken_share"] for run in curve.runs}
        mean = pd.DataFrame(seeds).dropna().mean(axis=1)
        draw(c, curve, pd.DataFrame(dict.fromkeys(("value", "low", "high"), mean)), 100.0, seeds=seeds)
    c.axes.set_ylabel("bonds broken so far, % of those made")
    c.axes.set_ylim(0, max(1.0, c.axes.get_ylim()[1]))
    if not any(len(run.bonds_broken) for run in runs):
        c.axes.text(0.5, 0.5, "no bond broke", transform=c.axes.transAxes, ha="center", color=SOFT)
    c.hover_unit = "%"
    cycle_axis(c, last_cycle_of(curves), False)
    c.table = pd.concat([bond_counts(run).assign(run=run.id) for run in runs], ignore_index=True)
    return gallery.finish(name, title, caption, [c], runs, curves)


def broken_bonds_figure(gallery: Gallery, runs: Sequence[Run], name: str, title: str, caption: str) -> Figure | None:
    """Where bonds broke: side view and end view of each run, coloured by when; nothing where none broke."""
    drawn, used = [], []
    for run in runs:
        if len(run.bonds_broken) and run.scenario is not None:
            used.append(run)
            drawn += [_view(run, name, axis) for axis in "xy"]
    return gallery.finish(name, title, caption, drawn, used)


def _view(run: Run, name: str, axis: str) -> style.Canvas:
    """Broken bonds of a run seen along y (`axis` x) or along x (`axis` y), with the outlines of what loads the bed."""
    box, broken = derived.apparatus(run.scenario), run.bonds_broken
    along = {"x": "along the sleeper", "y": "across the sleeper"}[axis]
    heading = f"{short_name(run.scenario_name)}, {CODE_NAMES.get(run.code, run.code)}"
    key = f"{name}-{run.scenario_name}-{run.code}" + (f"-seed{run.seed}" if run.seed != 1 else "")
    c = style.canvas(f"{key}-{axis}", f"{heading}: where bonds broke, {along}", right=1.3)
    span = (box.end_m, box.length_m) if axis == "x" else (0.0, box.width_m)
    _draw_outlines(c, box, axis, span)
    _draw_broken(c, broken, axis)
    top = max(MM * box.sleeper.high[2], MM * broken["z_m"].max())
    c.axes.set(
        xlim=(MM * span[0] - 15, MM * span[1] + (40 if axis == "x" else 15)),
        ylim=(-10, top + 10),
        xlabel=f"{along} {axis}, mm",
        ylabel="height z, mm",
        aspect="equal",
    )
    c.axes.set_title(heading)
    c.axes.grid(False)
    c.table = broken.assign(run=run_id(run))
    return c


def _draw_outlines(canvas: style.Canvas, box: derived.Apparatus, axis: str, span: tuple[float, float]) -> None:
    """The sleeper, the plates where they are seen from the side, and the box over `span` (m)."""
    k = "xy".index(axis)
    for block in (box.sleeper, *(box.plates if axis == "x" else ())):
        low, high = MM * np.array(block.low), MM * np.array(block.high)
        size = high[k] - low[k], high[2] - low[2]
        canvas.axes.add_patch(Rectangle((low[k], low[2]), *size, facecolor=SOFT, alpha=0.3, linewidth=0))
    canvas.axes.add_patch(
        Rectangle((MM * span[0], 0), MM * (span[1] - span[0]), MM * box.height_m, fill=False, edgecolor=SOFT, zorder=1)
    )


def _draw_broken(canvas: style.Canvas, broken: pd.DataFrame, axis: str) -> None:
    """A dot for each broken bond, coloured by when it broke, and a legend with their numbers."""
    for words, first, last, hue, level in WHEN:
        part = broken[broken["cycle"].between(first, last if last is not None else np.inf)]
        if len(part):
            canvas.axes.scatter(
                MM * part[f"{axis}_m"],
                MM * part["z_m"],
                s=5,
                color=hue if hue == SOFT else style.shade(hue, level),
                linewidths=0,
                label=f"{words}: {len(part)}",
                rasterized=True,
            )
    canvas.axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, markerscale=2.5, title="broken")
