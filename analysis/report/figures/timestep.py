"""Settlement against the share of the critical time step."""

from __future__ import annotations

import pandas as pd

from analysis.report import style
from analysis.report.figure import Figure, Gallery
from analysis.report.labels import MM, short_name
from analysis.report.style import Canvas

MARKS = ("o", "s", "^", "D", "v")


def timestep_figure(g: Gallery, table: pd.DataFrame) -> Figure | None:
    """Settlement after 5 and 20 cycles against step over critical step: a mark per bed, a colour per scenario."""
    done = table[(table["state"] == "done") & (table["ranks"] == 1)]
    drawn = [canvas for cycle in (5, 20) if (canvas := _at(g, done[done["cycle"] == cycle], cycle))]
    if not drawn:
        return None
    return g.finish(
        "timestep",
        "Settlement against the time step",
        "Marks of one shape are runs from one packed bed, joined by a line; other shapes are other beds. A step "
        "matters where a line is not level by more than shapes differ.",
        drawn,
        [],
    )


def _at(g: Gallery, rows: pd.DataFrame, cycle: int) -> Canvas | None:
    if rows.empty:
        return None
    c = style.canvas(f"timestep-{cycle}", f"Settlement after {cycle} cycles against the time step", right=1.4)
    marks = dict(zip(dict.fromkeys(rows["bed"]), MARKS, strict=False))
    for scenario, of_scenario in rows.groupby("scenario", sort=False):
        colour, _ = g.look(scenario)
        for bed, part in of_scenario.sort_values("step_share").groupby("bed", sort=False):
            settled = MM * part["settlement_m"]
            c.axes.plot(part["step_share"], settled, marks.get(bed, "x"), linestyle="-", color=colour, linewidth=0.9)
        c.labels.append((of_scenario["step_share"].max(), settled.iloc[-1], short_name(scenario), colour))
    c.axes.set_yscale("log")
    c.axes.set(xlabel="time step over the critical one", ylabel=f"settlement after {cycle} cycles, mm (logarithmic)")
    c.table = rows
    return c
