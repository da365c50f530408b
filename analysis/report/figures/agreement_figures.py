"""LIGGGHTS against YADE over all quantities, as validation guides show it."""

from __future__ import annotations

import numpy as np
import pandas as pd

from analysis.comparison.findings.agreement import AGREES_WITHIN
from analysis.formats.quantities import COMPARED
from analysis.report import style
from analysis.report.figure import Figure, Gallery
from analysis.report.style import SOFT, Canvas

GROUPS = {  # name, marker: quantities
    ("settle- ment", "o"): ("settlement_m", "settlement_peak_m"),
    ("plates", "s"): ("lateral_mean_m", "shoulder_displacement_m", "bulge_volume_m3"),
    ("stiff- ness", "D"): ("resilient_stroke_m", "secant_stiffness_N_m", "loop_energy_J"),
    ("porosity, contacts", "^"): ("porosity_1", "porosity_2", "porosity_3", "coordination_number", "overlap_mean_m"),
}


def groups() -> dict[tuple[str, str], tuple[str, ...]]:
    """GROUPS, and a group of the compared quantities that are in none of them."""
    named = {name for quantities in GROUPS.values() for name in quantities}
    return GROUPS | {("within the bed", "v"): tuple(name for name in COMPARED if name not in named)}


def scatter_figure(gallery: Gallery, agreement: pd.DataFrame, name: str) -> Figure | None:
    """Each compared quantity of both codes over YADE's mean of it in the scenario: ratio LIGGGHTS over YADE by size."""
    rows = agreement[(agreement["yade_mean"] > 0) & (agreement["liggghts_mean"] > 0)]
    if rows.empty:
        return None
    c = style.canvas(
        name,
        f"LIGGGHTS over YADE for every compared quantity, scenario and cycle, with 95 % intervals: {_counted(rows)}",
        height=3.2,
        right=0.15,
    )
    at = 0
    ticks, labels = [], []
    for (label, marker), quantities in groups().items():
        part = rows[rows["quantity"].isin(quantities)].sort_values(["quantity", "scenario", "reading", "cycle"])
        if part.empty:
            continue
        x = at + np.arange(len(part))
        linear = part["scenario"].map(lambda scenario: gallery.look(scenario)[1] == "linear")
        for hue, chosen in (("linear", linear), ("nonlinear", ~linear)):
            if chosen.any():
                _draw_ratios(c, x[chosen.to_numpy()], part[chosen], marker, style.shade(hue))
        ticks.append(x.mean())
        labels.append(label.replace(" ", "\n", 1))
        at = x[-1] + 4
    c.axes.axhline(1, color=SOFT, linewidth=1)
    c.axes.axhspan(_ratio_of(-AGREES_WITHIN), _ratio_of(AGREES_WITHIN), color=SOFT, alpha=0.18, linewidth=0)
    _label_axes(c, ticks, labels)
    c.table = rows
    return gallery.finish(
        name,
        "Both codes over all quantities",
        "Each mark is one quantity after one cycle of one scenario, in one reading of the load, each code from "
        "beds of its own; bars are 95 % intervals. Grey: "
        f"the difference of {100 * AGREES_WITHIN:g} % within which two codes are said to agree.",
        [c],
        [],
    )


def _draw_ratios(canvas: Canvas, x: np.ndarray, part: pd.DataFrame, marker: str, colour: str) -> None:
    """A mark for each row of `part` at `x`, with its interval."""
    low, high = (_ratio_of(part[f"{end}_ratio"].clip(-1.8, 1.8)) for end in ("low", "high"))
    canvas.axes.vlines(x, low, high, color=colour, linewidth=0.8, alpha=0.6)
    ratio = part["liggghts_mean"] / part["yade_mean"]
    canvas.axes.plot(x, ratio, marker, color=colour, markersize=4, linestyle="none")


def _label_axes(canvas: Canvas, ticks: list[float], labels: list[str]) -> None:
    """Ratios upward, groups of quantities along; the hues are explained above the axes, where no mark is."""
    axes = canvas.axes
    axes.set_yscale("log")
    axes.set_ylim(0.25, 4)
    axes.set_yticks([0.25, 0.5, 0.8, 1, 1.25, 2, 4], ["0.25", "0.5", "0.8", "1", "1.25", "2", "4"])
    axes.minorticks_off()
    axes.set_xticks(ticks, labels)
    axes.set_ylabel("LIGGGHTS over YADE")
    for hue, right in (("linear", 0.6), ("nonlinear", 1.0)):
        look = {"color": style.text_colour(style.shade(hue)), "fontsize": style.SMALL, "ha": "right", "va": "bottom"}
        axes.text(right, 1.03, f"{hue} model", transform=axes.transAxes, **look)


def _counted(rows: pd.DataFrame) -> str:
    """How many of the marks lie where."""
    size = rows["difference_ratio"].abs()
    return f"{int((size <= AGREES_WITHIN).sum())} of {int(size.notna().sum())} lie within {100 * AGREES_WITHIN:g} %"


def _ratio_of(difference):
    """Ratio of two values from their difference over their mean."""
    return (2 + difference) / (2 - difference)
