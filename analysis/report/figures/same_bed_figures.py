"""Runs from one packed bed: what the other code changes beside what a smaller time step, or rounding alone, changes."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from analysis.comparison.same_bed import CODE, CODE_AND_DASHPOT, JUDGED_CYCLES, SHARED_CYCLES, Pair, ranks, settlements
from analysis.normalised.readers import Run
from analysis.report import style
from analysis.report.figure import Figure, Gallery
from analysis.report.labels import MM
from analysis.report.style import CODE_NAMES, CODE_STYLES, OTHER_STYLE, Canvas, marker_face

DIFFERENCES = {  # name, hue, marker
    CODE: ("the other code", "nonlinear", "s"),
    CODE_AND_DASHPOT: ("the other code and dashpot", "nonlinear", "s"),
    "time.step": ("half the time step", "md1", "D"),
    "ranks": ("rounding alone", "other", "o"),
}


def same_bed_figure(gallery: Gallery, found: Sequence[Pair], name: str, title: str) -> Figure | None:
    """Settlement of all runs of `found` (pairs from one bed), and the differences within each pair."""
    runs = list({run.id: run for pair in found for run in (pair.one, pair.other)}.values())
    return gallery.finish(
        name,
        f"One bed, {title}: two codes, two time steps, rounding",
        f"Left: settlement since the end of preload in the first {SHARED_CYCLES[-1]} cycles. Right: difference of the "
        "two runs of a pair over their mean, settlement in preload first. The codes agree as closely as can be asked "
        "where the line of the other code lies no higher than that of the smaller time step; rounding alone (another "
        "number of ranks) is the floor.",
        [_settlement(gallery, runs, name), _differences(gallery, found, name)],
        runs,
    )


def _settlement(gallery: Gallery, runs: Sequence[Run], name: str) -> Canvas:
    c = style.canvas(f"{name}-settlement", "Settlement of runs from one bed")
    longest = max(run.scenario["time.step"] for run in runs)
    frames = []
    for run in runs:
        colour, _ = gallery.look(runs[0].scenario_name)
        look, label = CODE_STYLES.get(run.code, OTHER_STYLE), CODE_NAMES.get(run.code, run.code)
        if run.scenario["time.step"] < longest:
            look, label = OTHER_STYLE, f"{label} {1e6 * run.scenario['time.step']:g} µs"
        if ranks(run) > 1:
            look, label = OTHER_STYLE | {"marker": "^"}, f"{label} {ranks(run)} ranks"
        rows = run.cycles[run.cycles["cycle"] <= SHARED_CYCLES[-1]]
        x, y = [0, *rows["cycle"]], [0.0, *(MM * rows["settlement_m"])]
        c.axes.plot(x, y, color=colour, markersize=4.5, markerfacecolor=marker_face(run.code, colour), **look)
        c.labels.append((x[-1], y[-1], label, colour))
        frames.append(rows[["cycle", "settlement_m"]].assign(run=run.id))
    c.axes.invert_yaxis()
    c.axes.set(xlabel="load cycle", ylabel="settlement at minimum load, mm")
    c.table = pd.concat(frames, ignore_index=True)
    return c


def _differences(gallery: Gallery, found: Sequence[Pair], name: str) -> Canvas:
    c = style.canvas(f"{name}-differences", "Difference of settlement within each pair")
    frames = []
    for pair in found:
        (label, hue, marker), table = DIFFERENCES[pair.differs], settlements(pair)
        colour = style.shade(hue)
        y = 100 * table["difference_ratio"].abs()
        c.axes.plot(table["cycle"], y, marker=marker, markersize=5, color=colour)
        if len(table):
            c.labels.append((table["cycle"].iloc[-1], y.iloc[-1], label, colour))
        frames.append(table.assign(differs=pair.differs, one=pair.one.id, other=pair.other.id))
    c.axes.set_ylim(bottom=0)
    last = max(table["cycle"].max() for table in frames)
    shown = [1, 5, 10, 20] if last > JUDGED_CYCLES else list(range(1, JUDGED_CYCLES + 1))
    c.axes.set_xticks([0, *shown], ["preload", *map(str, shown)])
    c.axes.set(xlabel="load cycle", ylabel="difference of settlement, %")
    c.table = pd.concat(frames, ignore_index=True)
    return c
