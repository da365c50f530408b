"""Settlement against the share of the critical time step."""

from __future__ import annotations

import pandas as pd

from analysis.report import style
from analysis.report.curve_drawing import css
from analysis.report.figure import Figure, Gallery
from analysis.report.labels import MM, short_name
from analysis.report.style import Canvas

MARKS = ("o", "s", "^", "D", "v")
CYCLES = (5, 20)
LARGEST_SHARE = 0.9
"""Of the critical step: no run is loaded beyond 0.85 of it."""


def timestep_figure(gallery: Gallery, table: pd.DataFrame) -> Figure | None:
    """Settlement against step over critical step: a panel per scenario and cycle, a mark per bed."""
    done = table[(table["state"] == "done") & (table["ranks"] == 1)].dropna(subset=["settlement_m", "step_share"])
    drawn = [
        _panel(gallery, rows, scenario, cycle)
        for scenario, of_scenario in done.groupby("scenario", sort=False)
        for cycle in CYCLES
        if len(rows := of_scenario[of_scenario["cycle"] == cycle]) > 1
    ]
    if not drawn:
        return None
    return gallery.finish(
        "timestep",
        "Settlement against the time step",
        "Each panel has its own scale, from zero. Marks of one shape are runs from one packed bed, joined by a line; "
        "other shapes are other beds. A step matters where a line is not level by more than the beds differ.",
        drawn,
        [],
        layout="two",
    )


def _panel(gallery: Gallery, rows: pd.DataFrame, scenario: str, cycle: int) -> Canvas:
    name = short_name(scenario)
    c = style.canvas(
        f"timestep-{scenario}-{cycle}", f"Settlement after {cycle} cycles against the time step, {name}", right=1.0
    )
    colour, _ = gallery.look(scenario)
    beds = dict.fromkeys(rows["bed"])
    for (n, bed), mark in zip(enumerate(beds, 1), MARKS * len(beds), strict=False):
        part = rows[rows["bed"] == bed].sort_values("step_share")
        shares, settled = part["step_share"].to_numpy(), MM * part["settlement_m"].to_numpy()
        c.axes.plot(shares, settled, mark, linestyle="-", color=colour, linewidth=0.9)
        c.labels.append((shares[-1], settled[-1], f"bed {n}", colour))
        c.series.append({"label": f"bed {n}", "colour": css(colour), "x": list(shares), "y": list(settled)})
    c.axes.set_title(f"{name}, {cycle} cycles")
    c.axes.set_xlim(0, LARGEST_SHARE)
    c.axes.set_ylim(0, 1.15 * MM * rows["settlement_m"].max())
    c.axes.set(xlabel="time step over the critical one", ylabel="settlement, mm")
    c.hover_x, c.hover_unit = "step over critical", "mm"
    c.table = rows
    return c
