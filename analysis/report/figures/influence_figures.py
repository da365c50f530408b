"""What one thing changed at a time does, as ranked bars with the scatter between beds as yardstick."""

from __future__ import annotations

import pandas as pd
from matplotlib.ticker import MaxNLocator

from analysis.comparison.findings.influence import LEAST_INFLUENCE
from analysis.comparison.findings.members import SERVO
from analysis.formats.numbers import signed
from analysis.report import style
from analysis.report.figure import Figure, Gallery
from analysis.report.labels import READING_NAMES, READING_SLUGS, short_name, variant_name
from analysis.report.style import SOFT, Canvas

LARGEST = 2.0
"""Bars end here; the number says the rest."""

TITLE_START = -0.66
"""Of the axes' width: where their title starts, above the names of the bars."""

ROOM = 0.36
"""Beside the longest bar, of all bars' width: for its number."""


def limits(changes: pd.Series, scatter: float) -> tuple[float, float]:
    """Ends of the axis in percent: all bars with their numbers, and the band of `scatter`."""
    shown = changes.clip(upper=LARGEST)
    low, high = min(shown.min(), -scatter, 0.0), max(shown.max(), scatter, 0.0)
    room = ROOM * (high - low)
    return 100 * (low - (room if (shown < 0).any() else 0.1 * room)), 100 * (high + room)


def influence_figure(gallery: Gallery, table: pd.DataFrame, quantity: str, what: str) -> Figure | None:
    """Change of a quantity by each variant, a panel per scenario and reading, the largest on top."""
    rows = table[(table["quantity"] == quantity) & table["change_ratio"].notna()]
    drawn = [
        _panel(gallery, part.sort_values("change_ratio", key=abs), quantity, what)
        for _, part in rows.groupby(["scenario", "reading"], sort=False)
    ]
    return gallery.finish(
        f"influence-{quantity.removesuffix('_m').replace('_', '-')}",
        f"What changes {what}",
        "One thing changed at a time, from the same packed bed where the change allows it. Grey band: twice the "
        "standard deviation between packed beds of one recipe, pooled over scenarios; a bar inside it is no influence "
        f"that these runs can show. Bars end at {100 * LARGEST:.0f} %; the number says the rest.",
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
        f"{variant_name(part['variant'].iloc[-1])} {100 * part['change_ratio'].iloc[-1]:+.0f} %",
        height=1.08 + 0.24 * len(part),
        left=1.5,
        right=0.4,
        top=0.5,
    )
    scatter = part["scatter_ratio"].dropna()
    if len(scatter):
        band = 100 * LEAST_INFLUENCE * scatter.iloc[0]
        c.axes.axvspan(-band, band, color=SOFT, alpha=0.25, linewidth=0)
    hue = style.shade("servo") if reading == SERVO else gallery.look(scenario)[0]
    for n, change_ratio in enumerate(part["change_ratio"]):
        _draw_bar(c, n, change_ratio, hue)
    c.axes.set_yticks(range(len(part)), [variant_name(v) for v in part["variant"]])
    c.axes.axvline(0, color=SOFT, linewidth=0.8)
    c.axes.set_xlim(*limits(part["change_ratio"], LEAST_INFLUENCE * scatter.max() if len(scatter) else 0.0))
    c.axes.xaxis.set_major_locator(MaxNLocator(4))
    c.axes.set_xlabel(f"change of {what}, %", x=0.0, ha="left")
    c.axes.set_title(
        f"{short_name(scenario)}, {READING_NAMES[reading]}\nunchanged: {signed(1e3 * base, '.3g')} mm after "
        f"{part['cycle'].max()} cycles",
        x=TITLE_START,
        ha="left",
    )
    c.table = part
    return c


def _draw_bar(canvas: Canvas, place: int, change_ratio: float, colour: str) -> None:
    """A change as a bar with its number at the end."""
    change = max(-1.0, min(change_ratio, LARGEST))
    canvas.axes.barh(place, 100 * change, color=colour, height=0.62)
    canvas.axes.annotate(
        signed(100 * change_ratio, "+.0f") + " %",
        (100 * change, place),
        (3 if change >= 0 else -3, 0),
        textcoords="offset points",
        va="center",
        ha="left" if change >= 0 else "right",
        fontsize=style.SMALL,
    )
