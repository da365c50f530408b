"""PFC's servo as a filter: amplitude and lag, predicted and measured."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from analysis.comparison.findings import servo
from analysis.report import style
from analysis.report.figure import Figure, Gallery
from analysis.report.labels import KPA, short_name
from analysis.report.paper import paper
from analysis.report.style import SOFT, Canvas

MARKS = {"linear": ("linear", "o"), "hysteretic": ("nonlinear", "s")}


def filter_figure(gallery: Gallery, table: pd.DataFrame) -> Figure | None:
    """Amplitude and lag of the stress against angular frequency times time constant: the filter, and every run by the
    servo.
    """
    known = table[table["time_constant_s"].notna() & table["amplitude_ratio"].notna()]
    if known.empty:
        return None
    load, x = paper(), np.geomspace(0.01, 30, 200)
    loss = known["bed_loss_angle_rad"].mean()
    passed = servo.transfer(1.0, x * np.exp(-1j * loss))
    drawn = []
    for name, law, column, factor, label in (
        ("amplitude", np.abs(passed), "amplitude_ratio", 1.0, "amplitude of stress over that asked for"),
        ("lag", -np.angle(passed), "lag_rad", 180 / math.pi, "lag of the stress, degrees"),
    ):
        c = style.canvas(f"servo-{name}", f"{label} against the servo's time constant, filter and runs", right=1.2)
        c.axes.plot(x, factor * law, color=SOFT, linewidth=1.4)
        c.labels.append((x[-1], factor * law[-1], "the filter", SOFT))
        _draw_runs(c, known, load.omega_per_s, column, factor)
        c.axes.set_xscale("log")
        c.axes.set(xlabel=f"2π × {load.frequency_Hz:g} Hz × time constant", ylabel=label)
        c.table = known
        drawn.append(c)
    return gallery.finish(
        "servo-filter",
        "PFC's servo is a first-order filter",
        f"Line: what such a filter passes of a {load.frequency_Hz:g} Hz load, and how late, with the bed's mean "
        f"loss angle of {math.degrees(loss):.0f}°. Marks: each run by the servo over its last five cycles, first "
        "harmonics. Their time constant follows from the gain, the stiffness of the bed and the counted contacts of "
        "the sleeper; nothing is fitted.",
        drawn,
        [],
    )


def _draw_runs(canvas: Canvas, known: pd.DataFrame, omega_per_s: float, column: str, factor: float) -> None:
    """A mark per run, in the hue of its contact law."""
    for model, (hue, marker) in MARKS.items():
        part = known[known["law"] == model]
        part = part.assign(at=omega_per_s * part["time_constant_s"]).sort_values("at")
        if part.empty:
            continue
        colour = style.shade(hue)
        canvas.axes.plot(part["at"], factor * part[column], marker, color=colour, markersize=5, markerfacecolor="none")
        last = part.iloc[-1]
        told = f"{'nonlinear' if model == 'hysteretic' else model} runs"
        canvas.labels.append((last["at"], factor * last[column], told, colour))


def stress_range_figure(gallery: Gallery, table: pd.DataFrame) -> Figure | None:
    """Least and largest stress that the servo applied, per run, beside what was asked for."""
    told = table["variant"].str.fullmatch(r"servo(-gain[\d.]+)?")
    rows = table[told & (table["seed"] == 1) & (table["cycle"] >= servo.LAST_CYCLES)]
    if rows.empty:
        return None
    rows = rows.sort_values(
        ["law", "gain", "scenario", "variant", "code", "seed"], ascending=[True, True, False, False, True, True]
    )
    c = style.canvas(
        "servo-range",
        "Least and largest stress on the sleeper by PFC's servo",
        height=0.9 + 0.2 * len(rows),
        left=2.5,
        right=0.2,
    )
    _draw_ranges(c, rows)
    load = paper()
    for stress in (load.stress_min_Pa, load.stress_max_Pa):
        c.axes.axvline(KPA * stress, color=SOFT, linewidth=1, linestyle=(0, (3, 2)))
    c.axes.set(xlabel="stress on the sleeper, kPa", xlim=(0, 480), ylim=(-0.8, len(rows) - 0.2))
    c.table = rows
    return gallery.finish(
        "servo-stress",
        "The stress that PFC's servo applied",
        "Least to largest over the last five cycles of each first packed bed; broken lines: "
        f"{KPA * load.stress_min_Pa:g} and {KPA * load.stress_max_Pa:g} kPa, which "
        "the paper asks for. ● LIGGGHTS, □ YADE.",
        [c],
        [],
    )


def _draw_ranges(canvas: Canvas, rows: pd.DataFrame) -> None:
    """A bar per run from least to largest stress, with the run's name beside it."""
    names = []
    for n, row in enumerate(rows.itertuples()):
        canvas.axes.plot(
            [KPA * row.stress_min_Pa, KPA * row.stress_max_Pa],
            [n, n],
            color=style.shade(MARKS[row.law][0]),
            linewidth=4,
            solid_capstyle="butt",
        )
        scenario = "+".join((row.scenario, *filter(None, [row.variant])))
        names.append(f"{short_name(scenario)} {style.CODE_SIGNS[row.code]}")
    canvas.axes.set_yticks(range(len(rows)), names, fontsize=style.SMALL)
