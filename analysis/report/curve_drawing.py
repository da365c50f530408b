"""What many figures share: curves with bands and hover values, cycle axes, reference curves, tables behind them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.ticker import MaxNLocator, NullFormatter

from analysis.reference.curves import References
from analysis.report import style
from analysis.report.figure import Curve
from analysis.report.labels import PUBLICATION_NAMES, reference_name
from analysis.report.style import SOFT, Canvas, marker_face

NEAR_END = 0.8
"""A mean that reaches this share of its longest bed's cycles carries the curve's name."""

TITLE_ROOM = 19
"""Points above the axes that a title takes."""

MARKED_TOP = 0.46
"""Margin in inches above axes that have a title and the mark of pending curves above it."""


def thin(cycles: np.ndarray, most: int = 140) -> np.ndarray:
    """Positions of at most about `most` cycles, dense at the start and even later on: enough for a line and for
    hovering.
    """
    count = len(cycles)
    if count <= most:
        return np.arange(count)
    early = np.unique(np.geomspace(1, count, most // 2).astype(int)) - 1
    late = np.linspace(0, count - 1, most // 2).astype(int)
    return np.unique(np.concatenate([early, late]))


def draw(
    canvas: Canvas,
    curve: Curve,
    table: pd.DataFrame,
    factor: float,
    label: bool = True,
    hover: bool = True,
    colour: str | None = None,
    name: str | None = None,
    tag: str | None = None,
    seeds: Mapping[int, pd.Series] | None = None,
    **look,
) -> None:
    """One curve (index = abscissa; value, low, high in SI) with its band, markers, end label and hover values.

    seeds   values of each packing seed: drawn thin to their own ends, while `table`, their mean, ends where one does
    """
    seeds = {seed: values for seed, values in (seeds or {}).items() if len(values)}
    if table.empty and not seeds:
        return
    colour, several = colour or curve.colour, len(seeds) > 1
    kept = thin(table.index.to_numpy(float))
    x, y = table.index.to_numpy(float)[kept], factor * table["value"].to_numpy()[kept]
    if (table["high"] > table["low"]).any():
        low, high = (factor * table[end].to_numpy()[kept] for end in ("low", "high"))
        canvas.axes.fill_between(x, low, high, color=colour, alpha=0.15, linewidth=0)
    ends = [(x[-1], y[-1])] if len(x) else []
    if several:
        ends += _draw_seeds(canvas, seeds, factor, colour, curve.look["linestyle"])
    if len(x):
        canvas.axes.plot(x, y, color=colour, **_look_of_mean(curve, x, colour, several) | look)
    if label:
        longest = max(ends, key=lambda end: end[0])
        place = ends[0] if ends[0][0] >= NEAR_END * longest[0] else longest
        canvas.labels.append((*place, tag or curve.tag, colour))
    if hover:
        add_hover(canvas, name or curve.label, colour, x, y)


def _draw_seeds(
    canvas: Canvas, seeds: Mapping[int, pd.Series], factor: float, colour: str, linestyle
) -> list[tuple[float, float]]:
    """A thin line for each packing seed; their ends."""
    ends = []
    for values in seeds.values():
        at = thin(values.index.to_numpy(float))
        x, y = values.index.to_numpy(float)[at], factor * values.to_numpy()[at]
        canvas.axes.plot(x, y, color=colour, linewidth=0.7, linestyle=linestyle, zorder=1.8)
        ends.append((x[-1], y[-1]))
    return ends


def _look_of_mean(curve: Curve, x: np.ndarray, colour: str, several: bool) -> dict:
    """Line and markers of a curve over `x`; bold where it is the mean of several seeds, which are drawn thin."""
    return curve.look | {
        "markersize": 3.8,
        "markevery": _marks(x),
        "markeredgewidth": 1.0,
        "linewidth": 2.0 if several else 1.5 if len(x) < 30 else 1.2,
        "markerfacecolor": marker_face(curve.code, colour),
    }


def add_hover(canvas: Canvas, label: str, colour: str, x: np.ndarray, y: np.ndarray, digits: int = 5) -> None:
    """Values of a curve that a reader sees by hovering, as numbers of `digits` digits; nothing where y is nan."""
    values = [None if v != v else float(f"{v:.{digits}g}") for v in y]
    canvas.series.append({"label": label, "colour": css(colour), "x": [float(f"{v:.6g}") for v in x], "y": values})


def css(colour: str) -> str:
    """A colour of a light page as the CSS variable that also has its dark twin."""
    return next((f"var({name})" for name, (light, _) in style.colour_variables().items() if light == colour), colour)


def _marks(x: np.ndarray) -> list[int]:
    if len(x) <= 12:
        return list(range(len(x)))
    wanted = np.unique(np.round(np.geomspace(max(x[0], 1), x[-1], 7)))
    return sorted({int(np.argmin(np.abs(x - w))) for w in wanted})


def from_zero(seeds: Mapping[int, pd.Series]) -> dict[int, pd.Series]:
    """Curves of seeds with their zero at the end of preload."""
    return {seed: pd.concat([pd.Series({0: 0.0}), values]) for seed, values in seeds.items()}


def with_start(table: pd.DataFrame) -> pd.DataFrame:
    """The curve with its zero at the end of preload."""
    start = pd.DataFrame({"value": [0.0], "low": [0.0], "high": [0.0]}, index=[0])
    return pd.concat([start, table])


def cycle_axis(canvas: Canvas, last: float, log: bool) -> None:
    canvas.axes.set_xlabel("load cycle" + (" (logarithmic)" if log else ""))
    canvas.hover_x = "cycle"
    if log:
        canvas.axes.set_xscale("log")
        canvas.axes.set_xlim(0.9, max(last, 2) * 1.12)
        steps = (1, 2, 5) if last <= 200 else (1,)
        ticks = [k * 10**n for n in range(7) for k in steps if k * 10**n <= max(last, 2) * 1.12]
        canvas.axes.set_xticks(ticks, [f"{v:g}" for v in ticks])
        canvas.axes.xaxis.set_minor_formatter(NullFormatter())
    else:
        canvas.axes.set_xlim(-0.015 * last, last * 1.015)
        canvas.axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))


def curve_rows(curves: Sequence[Curve], columns: Sequence[str], table: str = "cycles") -> pd.DataFrame:
    """The CSV behind a figure: the runs' own columns below each other."""
    frames = [
        getattr(run, table).assign(run=run.id, **run.identity)[["run", "profile", "scenario", "code", "seed", *columns]]
        for curve in curves
        for run in curve.runs
    ]
    return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=["run", *columns])


def last_cycle_of(curves: Sequence[Curve]) -> float:
    return max((run.cycles["cycle"].max() for curve in curves for run in curve.runs), default=1)


def draw_references(
    canvas: Canvas, rows: pd.DataFrame, coordinate: str, factor: float, across: bool = False, scale: float = 1.0
) -> None:
    """Reference curves: the experiment bold with its error band, simulations thin; named at their ends.

    across   the value is on the x axis (profiles over depth); `scale` multiplies the coordinate
    """
    for (kind, source, curve), part in rows.groupby(["kind", "source", "curve"], sort=True):
        part = part.sort_values(coordinate)
        at, value = scale * part[coordinate].to_numpy(float), factor * part["value"].to_numpy(float)
        error = factor * part["error"].fillna(0).to_numpy(float)
        experiment = kind == "experiment"
        colour = style.shade("reference") if experiment else SOFT
        look = {
            "color": colour,
            "linewidth": 2.4 if experiment else 1.3,
            "linestyle": "-" if experiment else (0, (4, 1.5, 1, 1.5)),
            "zorder": 1.9,
        }
        name = reference_name(kind, source, curve)
        if across:
            canvas.axes.plot(value, at, **look)
            canvas.axes.fill_betweenx(at, value - error, value + error, color=colour, alpha=0.15, linewidth=0)
            canvas.labels.append((value[-1], at[-1], name, colour))
        else:
            canvas.axes.plot(at, value, **look)
            canvas.axes.fill_between(at, value - error, value + error, color=colour, alpha=0.15, linewidth=0)
            canvas.labels.append((at[-1], value[-1], name, colour))
            add_hover(canvas, name, colour, at, value)


def pending_names(references: References, quantity: str, scenarios: Iterable[str] = ()) -> list[str]:
    """Reference curves of a quantity that are not digitised yet: those of no scenario, and of the given scenarios."""
    rows = references.pending
    rows = rows[(rows["quantity"] == quantity) & (rows["scenario"].isin(["", *scenarios]))]
    return [
        f"{PUBLICATION_NAMES.get(source, source)} ({len(part)} curve{'s' if len(part) > 1 else ''})"
        for (source, kind), part in rows.groupby(["source", "kind"], sort=True)
    ]


def pending_mark(canvas: Canvas, pending: Sequence[str], drawn: pd.DataFrame | None = None) -> None:
    """Say above the axes, and above a title that stands there, that reference curves are missing; `drawn` are rows of
    those that are there.
    """
    if pending:
        titled = bool(canvas.axes.get_title("left"))
        canvas.axes.annotate(
            ("reference" if drawn is None or not len(drawn) else "some reference") + " curves pending",
            (0 if titled else 1, 1),
            (0, TITLE_ROOM if titled else 2),
            textcoords="offset points",
            xycoords="axes fraction",
            fontsize=style.SMALL,
            color=SOFT,
            ha="left" if titled else "right",
            va="bottom",
            style="italic",
            annotation_clip=False,
        )


def up_to(rows: pd.DataFrame, last: float) -> pd.DataFrame:
    """Reference curves against cycles as far as the runs go, so that they do not set the scale: cut at cycle `last`."""
    cut = []
    for _, part in rows.groupby(["kind", "source", "curve"], sort=False):
        part = part.sort_values("cycle")
        inside = part[part["cycle"] <= last]
        if len(inside) and len(inside) < len(part):
            end = inside.iloc[[-1]].assign(cycle=last, value=np.interp(last, part["cycle"], part["value"]))
            inside = pd.concat([inside, end], ignore_index=True)
        cut.append(inside)
    return pd.concat(cut, ignore_index=True) if cut else rows


def reference_csv(rows: pd.DataFrame, **columns: str) -> pd.DataFrame:
    """Reference points as further rows of the CSV behind a figure; `columns` maps its columns to those of `rows`."""
    table = pd.DataFrame({name: rows[column] for name, column in columns.items()})
    return table.assign(run="reference " + rows["source"] + ": " + rows["curve"], scenario=rows["scenario"])


def reference_rows(references: References, quantity: str, scenarios: Iterable[str], **wanted) -> pd.DataFrame:
    rows = references.curve(quantity, **wanted)
    return rows[rows["scenario"].isin(["", *scenarios])]
