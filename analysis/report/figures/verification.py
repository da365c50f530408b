"""Figures of the verification: errors against tolerances, and what the engines gave on top of what was expected."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd

from analysis.report import style
from analysis.report.curves import css
from analysis.report.figure import Figure, Gallery
from analysis.report.style import CODE_NAMES, CODE_STYLES, OTHER_STYLE, PAPER, SOFT

CASE_NAMES = {
    "head-on": "Head-on impact of two spheres",
    "wall-dashpot": "Dashpot at a wall",
    "chung-ooi": "Chung and Ooi (2011), tests 1 to 3",
    "oblique": "Oblique impact on a wall",
    "no-approach": "Contacts without approach speed",
    "path": "Imposed paths: load, slide, reverse, unload, reload",
    "free-rotation": "Free rotation of a clump",
    "clump-bounce": "A clump bounces off a wall",
    "energy": "Energy of columns of clumps",
    "load-control": "Load control on a stack of known stiffness",
    "porosity": "Porosity of the measurement spheres",
}
UNITS = {"m_s": "m/s", "rad_s": "rad/s", "deg": "°", "rad": "rad", "Pa": "Pa", "m": "m", "s": "s", "N": "N", "J": "J"}
PREFIXES = ((1e-6, "µ"), (1e-3, "m"), (1.0, ""), (1e3, "k"))
PREFIXED = ("m", "s", "N", "J", "Pa")
CYCLE = ("linear", "nonlinear", "md1", "md0", "md2", "other")
MOST_LABELS = 7
ALIKE = 8.0
"""Curves whose greatest values are within this ratio share a panel."""
LEAST_ERROR = 1e-12


def case_name(case: str) -> str:
    """A case in words."""
    return CASE_NAMES.get(case, case.replace("-", " ").replace("_", " ").capitalize())


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
            table = pd.read_csv(folder / f"{case}_{code}.csv", dtype={"series": str})
        except (OSError, ValueError):
            continue
        if len(table) and "series" in table and table.shape[1] >= 3:
            found[code] = table
    return found


def case_figure(g: Gallery, folder: Path, case: str, rows: pd.DataFrame) -> Figure | None:
    """Errors of a case against their tolerances, and its curves: one panel per quantity and size."""
    name = f"verification-{re.sub('[^a-z0-9-]+', '-', case.lower())}"
    curves = case_curves(folder, case)
    drawn = [_errors(f"{name}-errors", rows)]
    caption = "Relative error of every comparison against its tolerance (bar)."
    if curves:
        abscissa, *columns = [c for c in next(iter(curves.values())) if c != "series" and not c.endswith("_expected")]
        for column in columns:
            for n, group in enumerate(_groups(curves, column)):
                drawn.append(_panel(f"{name}-{column}" + (f"-{n + 1}" if n else ""), curves, abscissa, column, group))
        caption += " Broad grey: expected; coloured: measured."
    figure = g.finish(name, case_name(case), caption, drawn, [])
    if figure:
        codes = [code for code in CODE_NAMES if code in set(rows["code"]) | set(curves)]
        figure.key = [{"label": CODE_NAMES[code], "code": code} for code in codes]
    return figure


def _errors(name: str, rows: pd.DataFrame) -> style.Canvas:
    """A line per quantity: relative errors as marks on a logarithmic axis, the tolerance as a bar."""
    kinds = rows["quantity"].str.replace(r" of .*", "", regex=True)
    order = list(dict.fromkeys(kinds))
    c = style.canvas(
        name, "Relative errors and tolerances", height=max(2.4, 1.0 + 0.2 * len(order)), left=1.75, right=0.15
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
                    markerfacecolor=PAPER if code == "yade" else colour,
                    markeredgecolor=colour,
                )
    c.axes.set_xscale("log")
    c.axes.set_yticks(range(len(order)), [_short(split_unit(kind)[0]) for kind in order])
    c.axes.set_ylim(len(order) - 0.4, -0.6)
    c.axes.set_xlabel("relative error")
    c.table = rows
    return c


def _short(text: str, room: int = 30) -> str:
    return text if len(text) <= room else text[: room - 1] + "…"


def _groups(curves: dict[str, pd.DataFrame], column: str) -> list[list[str]]:
    """Series whose greatest values are alike, the largest first; at most four groups."""
    peaks: dict[str, float] = {}
    for table in curves.values():
        if column in table:
            values = pd.to_numeric(table[column], errors="coerce").abs()
            for series, peak in values.groupby(table["series"]).max().items():
                peaks[series] = max(peaks.get(series, 0.0), peak) if peak == peak else peaks.get(series, 0.0)
    groups: list[list[str]] = []
    start = 0.0
    for series, peak in sorted(peaks.items(), key=lambda item: -item[1]):
        if not groups or (peak * ALIKE < start and len(groups) < 4):
            groups.append([])
            start = peak
        groups[-1].append(series)
    return groups


def _colour(series: str, n: int) -> str:
    """Series named after a law have that law's hue."""
    family = next((f for f in ("md0", "md1", "md2", "linear") if f in series), None)
    if family is None and re.search(r"en1|hertz|hysteretic|nonlinear", series):
        family = "nonlinear"
    return style.shade(family or CYCLE[n % len(CYCLE)])


def _panel(
    name: str, curves: dict[str, pd.DataFrame], abscissa: str, column: str, group: list[str]
) -> style.Canvas | None:
    """One quantity of a few series in both codes."""
    chosen = {code: t[t["series"].isin(group)] for code, t in curves.items() if column in t}
    chosen = {
        code: t.assign(**{k: pd.to_numeric(t[k], errors="coerce") for k in (abscissa, column)})
        for code, t in chosen.items()
    }
    greatest = [max((t[k].abs().max() for t in chosen.values()), default=0.0) for k in (abscissa, column)]
    (x_label, x_factor), (y_label, y_factor) = axis_of(abscissa, greatest[0]), axis_of(column, greatest[1])
    labelled = 1 < len(group) <= MOST_LABELS
    c = style.canvas(name, f"{y_label} against {x_label}", right=1.25 if labelled else 0.3, height=3.0)
    for code, table in chosen.items():
        look = CODE_STYLES.get(code, OTHER_STYLE)
        for n, series in enumerate(sorted(group)):
            part = table[table["series"] == series]
            x, y = x_factor * part[abscissa].to_numpy(), y_factor * part[column].to_numpy()
            if not np.isfinite(y).any():
                continue
            colour, few = _colour(series, n), len(part) <= 25
            expected = f"{column}_expected" in part
            if expected:
                c.axes.plot(x, y_factor * part[f"{column}_expected"], color=SOFT, linewidth=4, alpha=0.35, zorder=1)
            c.axes.plot(
                x,
                y,
                color=colour,
                linewidth=0 if few and expected else 1.1,
                linestyle=look["linestyle"],
                marker=look["marker"] if few else "",
                markersize=4.2 if code == "liggghts" else 6,
                zorder=3 if code == "liggghts" else 2,
                markerfacecolor=PAPER if code == "yade" else colour,
                markeredgecolor=colour,
            )
            if labelled and series not in {text for _, _, text, _ in c.labels}:
                end = np.flatnonzero(np.isfinite(y))[-1]
                c.labels.append((x[end], y[end], series, colour))
            if few:
                values = [None if v != v else float(f"{v:.6g}") for v in y]
                c.series.append(
                    {
                        "label": f"{series} {CODE_NAMES[code]}",
                        "colour": css(colour),
                        "x": [float(f"{v:.6g}") for v in x],
                        "y": values,
                    }
                )
    if not c.axes.lines:
        return None
    c.leaders = False
    c.axes.set(xlabel=x_label, ylabel=y_label)
    c.hover_x, c.hover_unit = x_label.partition(",")[0], y_label.partition(", ")[2]
    columns = ["series", abscissa, column, f"{column}_expected"]
    c.table = pd.concat(
        [t[[k for k in columns if k in t]].assign(code=code) for code, t in chosen.items()], ignore_index=True
    )
    return c
