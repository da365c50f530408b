"""Lateral displacement of the plates over depth."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import pandas as pd
from matplotlib.ticker import MaxNLocator

from analysis.comparison import run_quantities
from analysis.formats.numbers import plural
from analysis.normalised.readers import Run
from analysis.report import style
from analysis.report.curve_drawing import (
    MARKED_TOP,
    draw_references,
    pending_mark,
    pending_names,
    reference_csv,
    reference_rows,
)
from analysis.report.figure import Curve, Figure, Gallery
from analysis.report.labels import MM
from analysis.report.style import SOFT, Canvas, marker_face

PROFILE_CYCLES = (1, 100, 1000)
"""Cycles after which the paper shows lateral displacement over depth."""


def lateral_figure(
    gallery: Gallery,
    runs: Sequence[Run],
    name: str,
    title: str,
    caption: str,
    cycles: Sequence[int] | None = None,
    references: bool = True,
) -> Figure | None:
    """Lateral displacement of the plates over depth, one panel per number of cycles."""
    curves = gallery.curves(runs)
    if not curves:
        return None
    scenarios = {curve.scenario for curve in curves}
    pending = pending_names(gallery.references, "lateral_displacement", scenarios) if references else []
    drawn = []
    for cycle in cycles or shown_cycles(runs):
        rows = pd.DataFrame()
        if references:
            rows = reference_rows(gallery.references, "lateral_displacement", scenarios, cycle=cycle)
        drawn.append(_panel(curves, f"{name}-{cycle}", title, cycle, rows, pending))
    return gallery.finish(name, title, caption, drawn, runs, curves, pending)


def _panel(
    curves: Sequence[Curve], name: str, title: str, cycle: int, rows: pd.DataFrame, pending: Sequence[str]
) -> Canvas:
    """The profiles after one number of cycles, and the reference curves `rows`."""
    when = f"after {plural(cycle, 'cycle')}"
    c = style.canvas(name, f"{title} {when}", width=3.7, height=3.2, top=MARKED_TOP if pending else 0.32)
    c.leaders = False
    frames = [frame for curve in curves if (frame := _draw_profile(c, curve, cycle)) is not None]
    if not frames:
        text = f"no run has reached\ncycle {cycle} yet"
        c.axes.text(0.5, 0.5, text, transform=c.axes.transAxes, ha="center", va="center", color=SOFT, fontsize=9)
    if len(rows):
        draw_references(c, rows, "depth_m", MM, across=True, scale=MM)
        frames.append(reference_csv(rows, depth_m="depth_m", lateral_value_m="value", error_m="error", cycle="cycle"))
    c.axes.set_ylim(335, -8)
    c.axes.axvline(0, color=SOFT, linewidth=0.7, zorder=1)
    c.axes.xaxis.set_major_locator(MaxNLocator(4))
    c.axes.set(xlabel="outward displacement of the plates, mm", ylabel="depth below the sleeper, mm")
    c.axes.set_title(when)
    pending_mark(c, pending, rows)
    c.table = pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=["depth_m", "cycle"])
    return c


def _draw_profile(c: Canvas, curve: Curve, cycle: int) -> pd.DataFrame | None:
    """Draw one curve's profile; its rows for the CSV, None where it has not reached the cycle."""
    table = lateral_profile(curve, cycle)
    if table.empty:
        return None
    depth, colour = MM * table.index.to_numpy(), curve.colour
    if (table["high"] > table["low"]).any():
        c.axes.fill_betweenx(depth, MM * table["low"], MM * table["high"], color=colour, alpha=0.18, linewidth=0)
    face = marker_face(curve.code, colour)
    marks = {"markersize": 4.2, "markeredgewidth": 1.0, "markerfacecolor": face}
    c.axes.plot(MM * table["value"], depth, color=colour, **marks, **curve.look)
    c.labels.append((0.0, depth[-1], curve.tag, colour))
    of = {"profile": curve.main.profile, "scenario": curve.scenario, "code": curve.code, "seeds": len(curve.runs)}
    named = table.rename(columns={k: f"lateral_{k}_m" for k in table}).rename_axis("depth_m").reset_index()
    return named.assign(**of, cycle=cycle)


def lateral_profile(curve: Curve, cycle: int) -> pd.DataFrame:
    """Value, low and high of lateral displacement (m) against the depth of the plates' middles below the sleeper base
    (m).
    """
    profiles = {
        run.id: run_quantities.lateral_profile(run, [cycle]).dropna().set_index("depth_m")["lateral_m"]
        for run in curve.runs
    }
    together = pd.DataFrame({name: profile for name, profile in profiles.items() if len(profile)}).sort_index()
    if together.empty:
        return pd.DataFrame(columns=["value", "low", "high"])
    return pd.DataFrame({"value": together.mean(axis=1), "low": together.min(axis=1), "high": together.max(axis=1)})


def shown_cycles(runs: Iterable[Run]) -> list[int]:
    """Cycles to show profiles at: the paper's 1, 100, 1000 where some run has them, and the last that most runs
    share.
    """
    ends = [int(run.cycles["cycle"].max()) for run in runs if len(run.cycles)]
    if not ends:
        return []
    chosen = {n for n in PROFILE_CYCLES if n <= max(ends)}
    if max(chosen) * 2 <= min(ends) or len(chosen) == 1:
        chosen.add(min(ends))
    return sorted(chosen)
