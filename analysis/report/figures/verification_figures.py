"""Figures of the verification: a sketch of each case, one curve over what was expected, errors against tolerances."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.patches import Circle, FancyArrowPatch, Rectangle

from analysis.report import style
from analysis.report.curve_drawing import add_hover
from analysis.report.figure import Gallery
from analysis.report.style import CODE_NAMES, CODE_STYLES, INK, OTHER_STYLE, SOFT, marker_face
from analysis.report.tables.table_html import number
from analysis.verification.case_sketch import Disc, Sketch
from analysis.verification.cases.case import Case

WHERE = re.compile(r",| (?:of (?!contact)|at|with|after|around|between|on|against|stored|while|in|across)\b")
"""What follows names the place or the moment of a comparison."""
UNITS = {
    "kgm2_s": "kg m²/s",
    "kgm_s": "kg m/s",
    "Nm": "N m",
    "m_s": "m/s",
    "rad_s": "rad/s",
    "deg": "°",
    "rad": "rad",
    "Pa": "Pa",
    "m": "m",
    "s": "s",
    "N": "N",
    "J": "J",
}
PREFIXES = ((1e-6, "µ"), (1e-3, "m"), (1.0, ""), (1e3, "k"))
PREFIXED = ("m", "s", "N", "J", "Pa")
LEAST_ERROR = 1e-12
LARGEST_VALUE = 1e30
"""In SI units; beyond it a curve is damaged."""
LEAST_RANGE = 0.02
"""Of an axis over its greatest value: what drifts by less looks level."""
FEW, MOST_HOVERED = 25, 300
"""Points of a curve that are drawn as marks, and that can be read by hovering."""
ARROW = {"arrowstyle": "-|>", "linewidth": 1.6, "mutation_scale": 11}


def kind_of(quantity: str) -> str:
    """What a comparison is of, in few words: `slip_limit_N at 0.36 m/s closing of wall` -> slip limit."""
    return split_unit(WHERE.split(quantity, maxsplit=1)[0])[0]


def split_unit(column: str) -> tuple[str, str]:
    """`normal_force_N` -> (normal force, N)."""
    for suffix, unit in UNITS.items():
        if column.endswith(f"_{suffix}"):
            return column[: -len(suffix) - 1].replace("_", " "), unit
    return column.replace("_", " "), ""


def axis_of(column: str, greatest: float) -> tuple[str, float]:
    """(label with a unit of handy size, factor from SI) for values up to `greatest`."""
    name, unit = split_unit(column)
    if unit not in PREFIXED or not greatest > 0:
        return (f"{name}, {unit}" if unit else name), 1.0
    scale, prefix = next(((s, p) for s, p in reversed(PREFIXES) if greatest >= s), PREFIXES[0])
    return f"{name}, {prefix}{unit}", 1 / scale


def case_curves(folder: Path, case: str) -> dict[str, pd.DataFrame]:
    """Curves of a case by code; a file that cannot be read is left out, its rows are in verification.csv all the
    same.
    """
    found = {}
    for code in CODE_NAMES:
        try:
            table = pd.read_csv(folder / f"{case}_{code}.csv", dtype={"series": str}, encoding="utf-8")
            numbers = table.drop(columns="series").astype(float)
        except (OSError, ValueError, KeyError):
            continue
        good = not (numbers.abs() > LARGEST_VALUE).any(axis=None) and table["series"].notna().all()
        if len(table) and good and numbers.shape[1] >= 2:
            found[code] = table[["series"]].join(numbers)
    return found


def case_figure(gallery: Gallery, folder: Path, name: str, title: str, case: type[Case] | None, rows: pd.DataFrame):
    """Sketch of a case, one curve of it with what was expected, and all its errors against their tolerances.

    case -- None where verification.csv names one that is not known any more: there are errors only
    """
    stem = f"verification-{re.sub('[^a-z0-9-]+', '-', name.lower())}"
    caption, drawn = "", []
    if case:
        drawn.append(_sketch(f"{stem}-sketch", title, case.sketch()))
        if case.account.curve:
            series, column = case.account.curve
            curves = case_curves(folder, name)
            drawn.append(_curve(f"{stem}-curve", curves, series, column))
            caption = f"Curve: {series}; broad grey is expected. {_off(curves, series, column)} "
    caption += "Errors: every comparison (mark) and its tolerance (bar)."
    figure = gallery.finish(stem, title, caption, [*drawn, _errors(f"{stem}-errors", rows)], [])
    if figure:
        codes = [code for code in CODE_NAMES if code in set(rows["code"])]
        figure.key = [{"label": CODE_NAMES[code], "code": code} for code in codes]
    return figure


def _sketch(name: str, title: str, seen: Sketch) -> style.Canvas:
    """What lies where at the start, seen along y; how bodies move, and what holds them."""
    c = style.canvas(name, f"Sketch: {title}, at the start, seen from the side", left=0.1, right=0.1, bottom=0.1)
    size = min(disc.radius for disc in seen.discs if not disc.hollow)
    near = [disc for disc in seen.discs if disc.radius <= 100 * size]
    _draw_discs(c, seen, near)
    xs = [disc.x + side * disc.radius for disc in near for side in (-1.2, 1.2)]
    zs = [disc.z + side * disc.radius for disc in near for side in (-1.2, 1.2)]
    if seen.block:
        half_x, half_z = seen.block
        c.axes.add_patch(
            Rectangle((-half_x, -half_z), 2 * half_x, 2 * half_z, facecolor=style.shade("other", -1), edgecolor=INK)
        )
        xs, zs = [*xs, -1.2 * half_x, 1.2 * half_x], [*zs, -1.2 * half_z, 1.2 * half_z]
    if seen.way:
        x, z = zip(*seen.way, strict=True)
        c.axes.plot(x, z, color=style.shade("nonlinear"), linewidth=1.6)
        xs, zs = [*xs, *x], [*zs, *z]
    for x, z in _draw_motion(c, seen, size):
        xs, zs = [*xs, x], [*zs, z]
    if seen.lid_m is not None:
        c.axes.plot([min(xs), max(xs)], [seen.lid_m] * 2, color=INK, linewidth=3)
    if seen.floor:
        c.axes.axhspan(-0.35 * size, 0, facecolor=style.shade("other", -1), edgecolor=INK, hatch="///", linewidth=0)
        c.axes.axhline(0, color=INK, linewidth=1)
        zs.append(-0.35 * size)
    if seen.weight:
        c.axes.annotate("gravity", (0.9, 0.78), (0.9, 0.97), "axes fraction", arrowprops=ARROW, ha="center", fontsize=9)
    _show_all(c, xs, zs)
    c.axes.set_axis_off()
    c.table = pd.DataFrame([vars(disc) for disc in seen.discs])
    return c


def _draw_discs(canvas: style.Canvas, seen: Sketch, near: list[Disc]) -> None:
    """Spheres: free ones with a dot at their centre, held ones hatched, hollow ones in broken lines."""
    for disc in seen.discs:
        face = "none" if disc.hollow else style.shade("other", -1) if disc.held else style.shade("linear", -1)
        look = {"linestyle": (0, (4, 2))} if disc.hollow else {"hatch": "///"} if disc.held else {}
        patch = Circle((disc.x, disc.z), disc.radius, facecolor=face, edgecolor=INK, linewidth=0.8, **look)
        canvas.axes.add_patch(patch)
    for disc in near:
        if not disc.held and not disc.hollow:
            canvas.axes.plot(disc.x, disc.z, ".", color=INK, markersize=2)


def _draw_motion(canvas: style.Canvas, seen: Sketch, size: float) -> list[tuple[float, float]]:
    """Arrows of velocities and spins, `size` m long or so; the places that the velocities' arrows take."""
    colour, taken = style.shade("nonlinear"), []
    for arrow in seen.arrows:
        start = (arrow.x, arrow.z)
        tip = (arrow.x + 1.9 * size * arrow.along_x, arrow.z + 1.9 * size * arrow.along_z)
        canvas.axes.annotate("", tip, start, arrowprops=ARROW | {"color": colour})
        taken += [tip, (tip[0], arrow.z)]
    for x, z in seen.spins:
        ends = (x - 0.5 * size, z + 0.3 * size), (x + 0.5 * size, z + 0.3 * size)
        canvas.axes.add_patch(FancyArrowPatch(*ends, connectionstyle="arc3,rad=-0.6", **ARROW, color=colour))
    return taken


def _show_all(canvas: style.Canvas, xs: list[float], zs: list[float]) -> None:
    """Limits of the axes around these places, at true scale."""
    axes, box = canvas.axes, canvas.axes.get_window_extent()
    scale = max(np.ptp(xs) / box.width, np.ptp(zs) / box.height) / 2
    for values, pixels, limit in ((xs, box.width, axes.set_xlim), (zs, box.height, axes.set_ylim)):
        middle = (min(values) + max(values)) / 2
        limit(middle - scale * pixels, middle + scale * pixels)


def _off(curves: dict[str, pd.DataFrame], series: str, column: str) -> str:
    """How far nine in ten points of each code's curve are from what was expected, in words: the others lie at jumps,
    where a step earlier or later is all there is.
    """
    found = []
    for code, table in curves.items():
        part = table[table["series"] == series]
        expected = part[f"{column}_expected"]
        error = (part[column] - expected).abs().quantile(0.9) / expected.abs().max()
        found.append(f"{number(error, 2, 100)} % in {CODE_NAMES[code]}")
    return f"Nine in ten points are off by less than {', '.join(found)}, of the greatest value." if found else ""


def _errors(name: str, rows: pd.DataFrame) -> style.Canvas:
    """A line per quantity: relative errors as marks on a logarithmic axis, the tolerance as a bar."""
    kinds = rows["quantity"].map(kind_of)
    order = list(dict.fromkeys(kinds))
    c = style.canvas(
        name, "Relative errors and tolerances", height=max(3.0, 1.0 + 0.2 * len(order)), left=1.75, right=0.15
    )
    for n, kind in enumerate(order):
        part = rows[kinds == kind]
        for tolerance in sorted(set(part["tolerance"].dropna())):
            c.axes.plot([max(tolerance, LEAST_ERROR)] * 2, [n - 0.36, n + 0.36], color=SOFT, linewidth=2)
        for code, mine in part.groupby("code", sort=True):
            look = CODE_STYLES.get(code, OTHER_STYLE)
            for good, some in mine.groupby("passed"):
                colour = style.shade("md1" if good else "nonlinear")
                shift = {"liggghts": -0.14, "yade": 0.14}.get(code, 0)
                c.axes.plot(
                    np.clip(some["rel_error"].fillna(1), LEAST_ERROR, None),
                    np.full(len(some), n + shift),
                    linestyle="",
                    marker=look["marker"],
                    markersize=3.2,
                    markeredgewidth=0.8,
                    markerfacecolor=marker_face(code, colour),
                    markeredgecolor=colour,
                )
    c.axes.set_xscale("log")
    c.axes.set_yticks(range(len(order)), order)
    c.axes.set_ylim(len(order) - 0.4, -0.6)
    c.axes.set_xlabel("relative error")
    c.table = rows
    return c


def _curve(name: str, curves: dict[str, pd.DataFrame], series: str, column: str) -> style.Canvas | None:
    """One quantity of one series in both codes, over what was expected."""
    chosen = {code: t[t["series"] == series] for code, t in curves.items() if column in t}
    chosen = {code: part for code, part in chosen.items() if len(part)}
    if not chosen:
        return None
    abscissa = next(iter(chosen.values())).columns[1]
    greatest = [max(part[k].abs().max() for part in chosen.values()) for k in (abscissa, column)]
    (x_label, x_factor), (y_label, y_factor) = axis_of(abscissa, greatest[0]), axis_of(column, greatest[1])
    c = style.canvas(name, f"{y_label} against {x_label}, {series}", left=0.75, right=0.2)
    for code, part in chosen.items():
        x, y = x_factor * part[abscissa].to_numpy(), y_factor * part[column].to_numpy()
        if f"{column}_expected" in part:
            expected = y_factor * part[f"{column}_expected"]
            c.axes.plot(x, expected, color=SOFT, linewidth=5, alpha=0.35, zorder=1, solid_capstyle="round")
        _draw_found(c, code, x, y, _colour(series))
    low, high = c.axes.get_ylim()
    room = max(0.0, LEAST_RANGE * max(abs(low), abs(high)) - (high - low)) / 2
    c.axes.set_ylim(low - room, high + room)
    c.axes.set(xlabel=x_label, ylabel=y_label)
    c.hover_x, c.hover_unit = x_label.partition(",")[0], y_label.partition(", ")[2]
    columns = ["series", abscissa, column, f"{column}_expected"]
    c.table = pd.concat(
        [part[[k for k in columns if k in part]].assign(code=code) for code, part in chosen.items()], ignore_index=True
    )
    return c


def _draw_found(canvas: style.Canvas, code: str, x: np.ndarray, y: np.ndarray, colour: str) -> None:
    """What a code found: a line, or marks where points are few; hover values where they are not too many."""
    look, few = CODE_STYLES.get(code, OTHER_STYLE), len(x) <= FEW
    canvas.axes.plot(
        x,
        y,
        color=colour,
        linewidth=0 if few else 1.2,
        linestyle=look["linestyle"],
        marker=look["marker"] if few else "",
        markersize=4.2 if code == "liggghts" else 6,
        zorder=3 if code == "liggghts" else 2,
        markerfacecolor=marker_face(code, colour),
        markeredgecolor=colour,
    )
    if len(x) <= MOST_HOVERED:
        add_hover(canvas, CODE_NAMES[code], colour, x, y, digits=6)


def _colour(series: str) -> str:
    """Series named after a law have that law's hue."""
    family = next((f for f in ("md0", "md1", "md2", "linear") if f in series), None)
    return style.shade(family or ("nonlinear" if re.search(r"hertz|hysteretic|damped|glass", series) else "linear"))
