"""The figure of an impact file: results against the first swept key, or forces over time where nothing is swept."""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib.style
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from analysis.files import ROOT
from analysis.verification.impact_file import KEYS, ImpactFile
from analysis.verification.impact_results import column_of

LOOK = ROOT / "analysis" / "report" / "report.mplstyle"
COLOURS = ("#006dbd", "#ab2500", "#009876", "#8a2f87", "#a47e00", "#5b5f66")
MARKS = {"liggghts": {"marker": "o", "linestyle": "none"}, "yade": {"marker": "x", "linestyle": "none"}}
LINES = {"liggghts": "-", "yade": (0, (5, 2))}
LEGEND_WIDTH = 1.9  # inches
DRAWN = ("restitution", "tangential_restitution", "rebound_angle_degrees", "impulse_ratio")
SUFFIXES = {"_m_s": "m/s", "_rad_s": "rad/s", "_degrees": "degrees", "_N": "N", "_Pa": "Pa", "_m": "m", "_s": "s"}


def draw(path: Path, file: ImpactFile, rows: list[dict], series: dict[tuple[str, str], np.ndarray]) -> None:
    """Write the figure to `path` (PNG) and beside it as SVG.

    rows     of the result, one per impact and code
    series   (curve, code) -> time, overlap, normal and shear force (4, n), where nothing is swept
    """
    with matplotlib.style.context(LOOK, after_reset=True):
        names = file.figure or DRAWN if file.swept else ("overlap_m", "normal_force_N")
        figure = Figure(figsize=(4.2 * len(names) + LEGEND_WIDTH, 3.4), layout="constrained", facecolor="white")
        FigureCanvasAgg(figure)
        for axes, name in zip(np.atleast_1d(figure.subplots(1, len(names))), names, strict=True):
            if file.swept:
                _against_swept(axes, file, rows, name)
            else:
                _over_time(axes, series, name)
            axes.set_ylabel(label(name))
        figure.legend(*axes.get_legend_handles_labels(), loc="outside right center")  # never on a curve
        figure.suptitle(file.title, fontsize=10)
        path.parent.mkdir(parents=True, exist_ok=True)
        for ending in ("png", "svg"):
            figure.savefig(path.with_suffix(f".{ending}"), dpi=150, facecolor="white")


def label(column: str) -> str:
    """`spin_1_y_rad_s` -> spin 1 y, rad/s."""
    for suffix, unit in SUFFIXES.items():
        if column.endswith(suffix):
            return f"{column.removesuffix(suffix).replace('_', ' ')}, {unit}"
    return column.replace("_", " ")


def _over_time(axes, series: dict, name: str) -> None:
    curves = list(dict.fromkeys(curve for curve, _ in series))
    for (curve, code), (time, overlap, force, _) in series.items():
        axes.plot(
            time,
            overlap if name == "overlap_m" else force,
            color=COLOURS[curves.index(curve) % len(COLOURS)],
            linestyle=LINES[code],
            label=" ".join(filter(None, (curve, code))),
        )
    axes.set_xlabel("time, s")
    axes.set_ylim(bottom=0)


def _against_swept(axes, file: ImpactFile, rows: list[dict], name: str) -> None:
    key = file.swept[0]
    for n, curve in enumerate(dict.fromkeys(impact.curve for impact in file.impacts)):
        at, which = _numbers([dict(i.swept)[key] for i in file.impacts if i.curve == curve])
        for code in dict.fromkeys(row["code"] for row in rows):
            own = [row for row in rows if (row["code"], row["curve"]) == (code, curve)]
            if (theory := f"expected_{name}") in own[0] and code == rows[0]["code"]:
                axes.plot(at, [row[theory] for row in own], color=COLOURS[n % len(COLOURS)], linewidth=0.9,
                          label=" ".join(filter(None, (curve, "by the law"))))  # fmt: skip
            axes.plot(at, [row[name] for row in own], color=COLOURS[n % len(COLOURS)],
                      label=" ".join(filter(None, (curve, code))), **MARKS[code])  # fmt: skip
    axes.set_xlabel(label(column_of(key + which, KEYS[key].unit)))


def _numbers(values: list) -> tuple[list[float], str]:
    """The swept values, of vectors the component that changes most; and its name."""
    if not isinstance(values[0], tuple):
        return values, ""
    spread = np.ptp(np.array(values), axis=0)
    k = int(np.argmax(spread))
    return [value[k] for value in values], "_" + "xyz"[k]


def unknown_columns(file: ImpactFile, row: dict) -> list[str]:
    """Columns that the file wants drawn and the result does not have."""
    return [name for name in file.figure if not isinstance(row.get(name), float) or math.isinf(row[name])]
