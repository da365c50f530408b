"""What one thing changed at a time does, as ranked bars with the scatter between beds as yardstick."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter, LogLocator, MultipleLocator, NullLocator

from analysis.comparison.findings.influence import LEAST_INFLUENCE, size_of_change
from analysis.comparison.findings.members import SERVO
from analysis.formats.numbers import readable, signed
from analysis.report import style
from analysis.report.figure import Figure, Gallery
from analysis.report.labels import READING_NAMES, READING_SLUGS, short_name, variant_name
from analysis.report.style import SOFT, Canvas

TITLE_START = -0.66
"""Of the axes' width: where their title starts, above the names of the bars."""

ROOM = 0.42
"""Beside the longest bar, of all bars' width: for its number."""

TICKS = {400.0: (1,), 40.0: (1, 3), 6.0: (1, 2, 5)}
"""Of each decade, for axes whose ends are at least this far apart, the widest first."""

STEPS = (0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0)
"""Between the ticks of nearer ends: the first that gives at most MOST_TICKS; each has a tick at 1."""

MOST_TICKS = 5

LEAST_SHARE = 0.2
"""The grey band is drawn down to this share of the unchanged value, where it would reach zero or below."""


def band(scatter: float) -> tuple[float, float]:
    """Changed over unchanged that is no influence, with the standard deviation between beds as a share."""
    half = LEAST_INFLUENCE * scatter
    return max(1 - half, LEAST_SHARE), 1 + half


def limits(ratios: pd.Series, scatter: float) -> tuple[float, float]:
    """Ends of the logarithmic axis: all bars with their numbers, and the band of `scatter`."""
    low, high = np.log([min(ratios.min(), band(scatter)[0]), max(ratios.max(), band(scatter)[1])])
    room = ROOM * (high - low)
    low, high = np.exp([low - (room if (ratios < 1).any() else 0.1 * room), high + room])
    return float(low), float(high)


def influence_figure(gallery: Gallery, table: pd.DataFrame, quantity: str, what: str) -> Figure | None:
    """Change of a quantity by each variant, a panel per scenario and reading, the largest on top."""
    rows = table[(table["quantity"] == quantity) & table["change_ratio"].notna()]
    drawn = [
        _panel(gallery, part.sort_values("change_ratio", key=size_of_change), quantity, what)
        for _, part in rows.groupby(["scenario", "reading"], sort=False)
    ]
    return gallery.finish(
        f"influence-{quantity.removesuffix('_m').replace('_', '-')}",
        f"What changes {what}",
        "One thing changed at a time, from the same packed bed where the change allows it. Grey band: twice the "
        "standard deviation between packed beds of one recipe, pooled over scenarios; a bar inside it is no influence "
        "that these runs can show. The axis is logarithmic: a third is as large a change as three times.",
        drawn,
        [],
        layout="two",
    )


def _panel(gallery: Gallery, part: pd.DataFrame, quantity: str, what: str) -> Canvas:
    """The bars of one scenario in one reading; `part` is sorted by the size of the change."""
    scenario, reading, base = part[["scenario", "reading", "base"]].iloc[0]
    c = style.canvas(
        f"influence-{quantity}-{scenario}-{READING_SLUGS[reading]}",
        f"Change of {what} in {short_name(scenario)}, {READING_NAMES[reading]}; largest: "
        f"{variant_name(part['variant'].iloc[-1])}, {readable(1 + part['change_ratio'].iloc[-1])} times",
        height=1.08 + 0.24 * len(part),
        left=1.5,
        right=0.4,
        top=0.5,
    )
    ratios = 1 + part["change_ratio"]
    scatter = float(part["scatter_ratio"].fillna(0.0).max())
    if scatter:
        c.axes.axvspan(*band(scatter), color=SOFT, alpha=0.25, linewidth=0)
    hue = style.shade("servo") if reading == SERVO else gallery.look(scenario)[0]
    for n, ratio in enumerate(ratios):
        _draw_bar(c, n, ratio, hue)
    c.axes.set_yticks(range(len(part)), [variant_name(v) for v in part["variant"]])
    c.axes.axvline(1, color=SOFT, linewidth=0.8)
    c.axes.set_xscale("log")
    c.axes.set_xlim(*limits(ratios, scatter))
    _set_ticks(c.axes.xaxis)
    c.axes.set_xlabel("changed over unchanged", x=0.0, ha="left")
    c.axes.set_title(
        f"{short_name(scenario)}, {READING_NAMES[reading]}\nunchanged: {signed(1e3 * base, '.3g')} mm after "
        f"{part['cycle'].max()} cycles",
        x=TITLE_START,
        ha="left",
    )
    c.table = part
    return c


def _set_ticks(axis: Axis) -> None:
    """Few ticks of a logarithmic axis as plain numbers, over decades as well as over a few percent."""
    low, high = axis.get_view_interval()
    places = next((subs for width, subs in TICKS.items() if high / low >= width), None)
    step = next((step for step in STEPS if high - low <= MOST_TICKS * step), STEPS[-1])
    axis.set_major_locator(LogLocator(subs=places) if places else MultipleLocator(step))
    axis.set_major_formatter(FuncFormatter(lambda ratio, _: readable(ratio)))
    axis.set_minor_locator(NullLocator())


def _draw_bar(canvas: Canvas, place: int, ratio: float, colour: str) -> None:
    """A ratio as a bar from one, with its number at the end."""
    canvas.axes.barh(place, ratio - 1, left=1, color=colour, height=0.62)
    canvas.axes.annotate(
        f"× {ratio:.2f}" if ratio > 0.1 else f"× {readable(ratio, 2)}",
        (ratio, place),
        (3 if ratio >= 1 else -3, 0),
        textcoords="offset points",
        va="center",
        ha="left" if ratio >= 1 else "right",
        fontsize=style.SMALL,
    )
