"""PFC's servo as a filter: amplitude and lag, predicted and measured."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from analysis.comparison.findings import servo
from analysis.report import style
from analysis.report.figure import Figure, Gallery
from analysis.report.labels import KPA, short_name
from analysis.report.style import SOFT

MARKS = {"linear": ("linear", "o"), "hysteretic": ("nonlinear", "s")}


def filter_figure(g: Gallery, table: pd.DataFrame) -> Figure | None:
    """Amplitude ratio and phase lag against angular frequency times time constant: the law, and every run by the
    servo.
    """
    if table.empty:
        return None
    x = np.geomspace(0.01, 30, 200)
    drawn = []
    for name, law, column, constant, label in (
        (
            "amplitude",
            servo.amplitude_ratio,
            "amplitude_ratio",
            "predicted_time_constant_s",
            "amplitude of stress over that asked for",
        ),
        ("lag", servo.lag, "lag_rad", "time_constant_s", "lag of the stress, degrees"),
    ):
        factor = 1.0 if name == "amplitude" else 180 / math.pi
        c = style.canvas(f"servo-{name}", f"{label} against the servo's time constant, law and runs", right=1.2)
        c.axes.plot(x, [factor * law(v) for v in x], color=SOFT, linewidth=1.4)
        c.labels.append((x[-1], factor * law(x[-1]), "first-order filter", SOFT))
        for model, (hue, marker) in MARKS.items():
            part = table[(table["law"] == model) & table[constant].notna() & table[column].notna()]
            if part.empty:
                continue
            at = 2 * math.pi * 20 * part[constant]
            c.axes.plot(at, factor * part[column], marker, color=style.shade(hue), markersize=5, markerfacecolor="none")
            c.labels.append(
                (
                    at.iloc[-1],
                    factor * part[column].iloc[-1],
                    f"{'nonlinear' if model == 'hysteretic' else model} runs",
                    style.shade(hue),
                )
            )
        c.axes.set_xscale("log")
        c.axes.set(
            xlabel=f"2π × 20 Hz × time constant, {'predicted' if name == 'amplitude' else 'from the amplitude'}",
            ylabel=label,
        )
        c.table = table
        drawn.append(c)
    return g.finish(
        "servo-filter",
        "PFC's servo is a first-order filter",
        "Grey: what such a filter passes of a 20 Hz load, and how late. Marks: each run by the servo, measured "
        "over its last "
        "five cycles. Left: at the time constant that is predicted for it from the contact stiffness of other "
        "runs. Right: "
        "at the time constant that its own amplitude gives, so that nothing is fitted but the lag follows.",
        drawn,
        [],
    )


def stress_range_figure(g: Gallery, table: pd.DataFrame) -> Figure | None:
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
        width=6.4,
    )
    for n, row in enumerate(rows.itertuples()):
        hue = MARKS[row.law][0]
        c.axes.plot(
            [KPA * row.stress_min_Pa, KPA * row.stress_max_Pa],
            [n, n],
            color=style.shade(hue),
            linewidth=4,
            solid_capstyle="butt",
        )
    names = [
        f"{short_name('+'.join((r.scenario, *filter(None, [r.variant]))))} {style.CODE_SIGNS[r.code]}"
        for r in rows.itertuples()
    ]
    c.axes.set_yticks(range(len(rows)), names, fontsize=7.5)
    for stress in (50, 460):
        c.axes.axvline(stress, color=SOFT, linewidth=1, linestyle=(0, (3, 2)))
    c.axes.set(xlabel="stress on the sleeper, kPa", xlim=(0, 480), ylim=(-0.8, len(rows) - 0.2))
    c.table = rows
    return g.finish(
        "servo-stress",
        "The stress that PFC's servo applied",
        "Least to largest over the last five cycles of each first packed bed; broken lines: 50 and 460 kPa, which "
        "the paper asks for. ● LIGGGHTS, □ YADE.",
        [c],
        [],
    )
