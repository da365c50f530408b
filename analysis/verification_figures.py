"""A figure for each verification case: what the engines gave, on top of what was expected."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd

from . import style
from .figures import CODE_NAMES, Figure, Gallery, css
from .style import CODE_STYLES, OTHER_STYLE, PAPER, SOFT

SERIES_COLOURS = ("linear", "nonlinear", "md1", "md0", "md2", "other")
UNITS = {
    "m": "m",
    "N": "N",
    "s": "s",
    "J": "J",
    "Pa": "Pa",
    "rad": "rad",
    "deg": "°",
    "degrees": "°",
    "m_s": "m/s",
    "rad_s": "rad/s",
    "ratio": "",
}
MOST_LABELS = 7


def heading(column: str) -> str:
    """`normal_force_N` as an axis has it: normal force, N."""
    for suffix in sorted(UNITS, key=len, reverse=True):
        if column.endswith(f"_{suffix}") and suffix != "ratio":
            return column[: -len(suffix) - 1].replace("_", " ") + f", {UNITS[suffix]}"
    return column.replace("_", " ")


def case_curves(folder: Path, case: str) -> dict[str, pd.DataFrame]:
    """Curves of a case by code; a file that cannot be read is left out, its rows are in verification.csv all the
    same.
    """
    found = {}
    for path in sorted(folder.glob(f"{case}_*.csv")):
        code = path.stem[len(case) + 1 :]
        if code not in CODE_NAMES:
            continue
        try:
            table = pd.read_csv(path, dtype={"series": str})
        except (OSError, ValueError):
            continue
        if len(table) and "series" in table and table.shape[1] >= 3:
            found[code] = table
    return found


def case_figure(g: Gallery, folder: Path, case: str) -> Figure | None:
    """One panel per quantity of a case: expected as broad lines, measured as the code's marks."""
    curves = case_curves(folder, case)
    if not curves:
        return None
    first = next(iter(curves.values()))
    abscissa, *names = [c for c in first.columns if c != "series" and not c.endswith("_expected")]
    drawn = [_panel(f"verification-{case}-{name}", curves, abscissa, name) for name in names]
    figure = g.finish(
        f"verification-{re.sub('[^a-z0-9-]+', '-', case.lower())}",
        case.replace("_", " ").capitalize(),
        "Broad grey: expected. Coloured: measured, one colour per series.",
        drawn,
        [],
    )
    if figure:
        figure.key = [{"label": CODE_NAMES[code], "code": code} for code in sorted(curves)]
    return figure


def _panel(name: str, curves: dict[str, pd.DataFrame], abscissa: str, column: str) -> style.Canvas | None:
    c = style.canvas(name, f"{heading(column)} against {heading(abscissa)}", right=1.3, height=3.0)
    series_names = list(dict.fromkeys(s for table in curves.values() for s in table["series"]))
    colours = {
        s: style.shade(SERIES_COLOURS[n % len(SERIES_COLOURS)], 0.0 if n < len(SERIES_COLOURS) else 0.8)
        for n, s in enumerate(series_names)
    }
    frames = []
    for code, table in curves.items():
        if column not in table:
            continue
        look = CODE_STYLES.get(code, OTHER_STYLE)
        for series, part in table.groupby("series", sort=False):
            x, y = pd.to_numeric(part[abscissa], errors="coerce"), pd.to_numeric(part[column], errors="coerce")
            if not np.isfinite(y).any():
                continue
            expected = part.get(f"{column}_expected")
            if expected is not None:
                c.axes.plot(x, expected, color=SOFT, linewidth=4, alpha=0.35, zorder=1, solid_capstyle="butt")
            few = len(part) <= 25
            c.axes.plot(
                x,
                y,
                color=colours[series],
                linewidth=0 if few and expected is not None else 1.2,
                linestyle=look["linestyle"],
                marker=look["marker"] if few else "",
                markersize=4.2 if code == "liggghts" else 6,
                zorder=3 if code == "liggghts" else 2,
                markerfacecolor=PAPER if code == "yade" else colours[series],
                markeredgecolor=colours[series],
            )
            if (
                len(series_names) <= MOST_LABELS
                and series not in {text for _, _, text, _ in c.labels}
                and len(series_names) > 1
            ):
                end = np.flatnonzero(np.isfinite(y.to_numpy()))[-1]
                c.labels.append((x.iloc[end], y.iloc[end], series, colours[series]))
            c.series.append(
                {
                    "label": f"{series} {CODE_NAMES[code]}",
                    "colour": css(colours[series]),
                    "x": [float(f"{v:.6g}") for v in x],
                    "y": [None if v != v else float(f"{v:.6g}") for v in y],
                }
            )
        frames.append(part_of(table, abscissa, column).assign(code=code))
    if not frames:
        return None
    if sum(len(s["x"]) for s in c.series) > 1200:
        c.series = []  # too fine for reading values off a page; the CSV has them all
    c.axes.set(xlabel=heading(abscissa), ylabel=heading(column))
    c.axes.ticklabel_format(axis="both", style="sci", scilimits=(-3, 4), useMathText=False)
    c.hover_x = heading(abscissa)
    c.table = pd.concat(frames, ignore_index=True)
    return c


def part_of(table: pd.DataFrame, abscissa: str, column: str) -> pd.DataFrame:
    """The columns behind one panel."""
    return table[[name for name in ("series", abscissa, column, f"{column}_expected") if name in table]]
