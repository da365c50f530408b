"""The load: how closely it is met, its signal, stiffness and losses within a cycle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.comparison import run_quantities
from analysis.comparison.findings import runs as runs_findings
from analysis.formats.quantities import QUANTITIES
from analysis.normalised.readers import Run
from analysis.report import style
from analysis.report.curve_drawing import curve_rows, cycle_axis, draw, last_cycle_of
from analysis.report.figure import Curve, Figure, Gallery
from analysis.report.labels import KPA, MM, short_name
from analysis.report.paper import paper
from analysis.report.style import CODE_NAMES, SOFT, Canvas
from analysis.scenarios.scenario import Scenario

TRACKING_AIM = {model: 100 * aim for model, aim in runs_findings.TRACKING_AIM.items()}
"""rms tracking error that no cycle should exceed, by contact model, % of the maximum stress."""


def tracking_figure(gallery: Gallery, runs: Sequence[Run], name: str, title: str) -> Figure | None:
    """Tracking error per cycle, and the extremes of the measured stress against their targets."""
    curves = gallery.curves(runs)
    if not curves:
        return None
    caption = "rms error over each cycle, and the extremes of each cycle minus their targets (paler: minimum)."
    return gallery.finish(name, title, caption, [_error(curves, name), _extremes(curves, name)], runs, curves)


def _error(curves: Sequence[Curve], name: str) -> Canvas:
    """rms tracking error of each cycle, beside what is aimed at."""
    error = style.canvas(f"{name}-error", "Load tracking error per cycle, rms in percent of the maximum stress")
    for curve in curves:
        top = curve.setup["loading.stress_max"] if curve.setup else paper().stress_max_Pa
        seeds = curve.seeds("tracking_rms_Pa")
        draw(error, curve, curve.column("tracking_rms_Pa"), 100 / top, seeds=seeds)
    for limit, text in (
        (TRACKING_AIM["linear"], "aim, linear bed"),
        (TRACKING_AIM["hysteretic"], "aim, nonlinear bed"),
    ):
        error.axes.axhline(limit, color=SOFT, linewidth=0.9, linestyle=(0, (2, 2)), zorder=1)
        error.axes.text(
            0.015,
            limit,
            text,
            fontsize=style.SMALL,
            color=SOFT,
            va="bottom",
            ha="left",
            transform=error.axes.get_yaxis_transform(),
        )
    error.axes.set_ylabel("rms error, % of maximum stress")
    error.axes.set_ylim(bottom=0)
    error.hover_unit = "%"
    cycle_axis(error, last_cycle_of(curves), False)
    error.table = curve_rows(curves, ["cycle", "tracking_rms_Pa"])
    return error


def _extremes(curves: Sequence[Curve], name: str) -> Canvas:
    """Largest and least stress of each cycle minus their targets."""
    extremes = style.canvas(f"{name}-extremes", "Largest and smallest sleeper stress per cycle minus their targets")
    for curve in curves:
        if curve.setup is None:
            continue
        for column, target, end in (
            ("sleeper_stress_max_Pa", "loading.stress_max", "max"),
            ("sleeper_stress_min_Pa", "loading.stress_min", "min"),
        ):
            draw(
                extremes,
                curve,
                curve.column(column) - curve.setup[target],
                KPA,
                name=f"{curve.label} {end}",
                label=end == "max",
                alpha=1.0 if end == "max" else 0.55,
            )
    extremes.axes.axhline(0, color=SOFT, linewidth=0.7, zorder=1)
    extremes.axes.set_ylabel("measured minus target stress, kPa")
    extremes.hover_unit = "kPa"
    cycle_axis(extremes, last_cycle_of(curves), False)
    extremes.table = curve_rows(curves, ["cycle", "sleeper_stress_min_Pa", "sleeper_stress_max_Pa"])
    return extremes


def stress_figure(
    gallery: Gallery, scenario: Scenario, runs: Sequence[Run], name: str, title: str, caption: str
) -> Figure:
    """The paper's Figure 6: vertical stress on the sleeper against time as a scenario prescribes it, and over it the
    first and the last cycle that runs measured.
    """
    c = style.canvas(name, "Vertical stress on the sleeper against time: three periods of the target", right=1.2)
    low, high, period = (
        scenario["loading.stress_min"],
        scenario["loading.stress_max"],
        1 / scenario["loading.frequency"],
    )
    time = np.linspace(0, 3 * period, 400)
    target = (high + low) / 2 - (high - low) / 2 * np.cos(2 * np.pi * time / period)
    c.axes.plot(1e3 * time, KPA * target, color=SOFT, linewidth=3.4, alpha=0.35, solid_capstyle="butt")
    c.labels.append((1e3 * time[-1], KPA * target[-1], "target", SOFT))
    c.table = pd.DataFrame({"run": "target", "time_s": time, "cycle": time / period, "sleeper_stress_Pa": target})
    curves = [curve for curve in gallery.curves(runs) if len(curve.main.loops)]
    for curve in curves:
        rows = curve.main.loops
        last = np.floor(rows["cycle"].max() + 1e-9)
        for cycle, at in {1: 0, last: 2 if last > 1 else 0}.items():
            part = rows[rows["cycle"].between(cycle - 1 - 1e-9, cycle + 1e-9)]
            shown = 1e3 * period * (part["cycle"] - cycle + 1 + at)
            c.axes.plot(
                shown,
                KPA * part["sleeper_stress_Pa"],
                color=curve.colour,
                linewidth=1.2,
                linestyle=curve.look["linestyle"],
            )
        end = KPA * part["sleeper_stress_Pa"]
        c.labels.append((shown.iloc[-1], end.iloc[-1], f"{curve.tag}, cycle {last:.0f}", curve.colour))
        c.table = pd.concat([c.table, rows.assign(run=curve.main.id)], ignore_index=True)
    c.axes.set(xlabel="time, ms", ylabel="stress on the sleeper, kPa", ylim=(0, 1.12 * KPA * high))
    return gallery.finish(name, title, caption, [c], [curve.main for curve in curves], curves)


def stroke_figure(gallery: Gallery, runs: Sequence[Run], name: str) -> Figure | None:
    """Resilient stroke, secant stiffness and loop energy per cycle."""
    curves = gallery.curves(runs)
    measured = {curve.label: run_quantities.per_cycle(curve.main).set_index("cycle") for curve in curves}
    drawn = []
    for column in ("resilient_stroke_m", "secant_stiffness_N_m", "loop_energy_J"):
        quantity = QUANTITIES[column]
        c = style.canvas(f"{name}-{column}", quantity.heading, height=2.7)
        for curve in curves:
            values = measured[curve.label][column].dropna()
            draw(c, curve, pd.DataFrame({"value": values, "low": values, "high": values}), quantity.factor)
        if not c.series:
            continue
        c.axes.set_ylabel(quantity.heading)
        c.hover_unit = quantity.shown_unit
        cycle_axis(c, last_cycle_of(curves), False)
        c.table = pd.concat(
            [measured[curve.label][[column]].reset_index().assign(run=curve.main.id) for curve in curves],
            ignore_index=True,
        )
        drawn.append(c)
    return gallery.finish(
        name,
        "Stiffness and losses",
        "Resilient stroke: settlement at maximum minus that at the next minimum load. Secant stiffness: range of the "
        "sleeper's load over that stroke. Work lost: area of the loop of load against settlement, with its permanent "
        "part.",
        drawn,
        [curve.main for curve in curves],
        curves,
    )


def loop_figure(gallery: Gallery, runs: Sequence[Run], name: str) -> Figure | None:
    """Stress on the sleeper against its settlement in the first and the last cycle, one panel per scenario."""
    curves = [curve for curve in gallery.curves(runs) if len(curve.main.loops)]
    scenarios = dict.fromkeys(curve.scenario for curve in curves)
    return gallery.finish(
        name,
        "Stress against settlement",
        "First (paler) and last cycle. The area of a loop is the work lost in the cycle; its extent along the "
        "settlement axis is the resilient stroke.",
        [c for s in scenarios if (c := _loops([curve for curve in curves if curve.scenario == s], f"{name}-{s}"))],
        [curve.main for curve in curves],
        curves,
    )


def _loops(curves: Sequence[Curve], name: str) -> Canvas | None:
    """The first and the last loop of curves of one scenario; None where there is no whole one."""
    title = short_name(curves[0].scenario)
    c, frames = style.canvas(name, f"Stress against settlement, {title}", right=1.2), []
    for curve in curves:
        last = int(np.floor(curve.main.loops["cycle"].max() + 1e-9))
        for cycle in sorted({1, last}):
            part = curve.main.loops
            part = part[(part["cycle"] >= cycle - 1 - 1e-9) & (part["cycle"] <= cycle + 1e-9)]
            if len(part) >= 8:
                _draw_loop(c, curve, part, 0.5 if cycle == 1 and last > 1 else 1, curve is curves[0], cycle)
                frames.append(part[["cycle", "settlement_m", "sleeper_stress_Pa"]].assign(run=curve.main.id))
        if frames:
            end = MM * part["settlement_m"].iloc[-1], KPA * part["sleeper_stress_Pa"].iloc[-1]
            c.labels.append((*end, CODE_NAMES.get(curve.code, curve.code), curve.colour))
    if not frames:
        return None
    c.axes.set(xlabel="settlement, mm", ylabel="stress on the sleeper, kPa")
    c.axes.set_ylim(0, 520)
    c.axes.set_title(title)
    c.table = pd.concat(frames, ignore_index=True)
    return c


def _draw_loop(c: Canvas, curve: Curve, part: pd.DataFrame, alpha: float, named: bool, cycle: int) -> None:
    """One cycle, with its number at its top where it is `named`."""
    x, y = MM * part["settlement_m"], KPA * part["sleeper_stress_Pa"]
    look = {"color": curve.colour, "linestyle": curve.look["linestyle"], "linewidth": 1.3, "alpha": alpha}
    c.axes.plot(x, y, **look)
    if named:
        top = y.idxmax()
        text = {"fontsize": style.SMALL, "color": curve.colour, "ha": "center", "textcoords": "offset points"}
        c.axes.annotate(f"cycle {cycle}", (x[top], y[top]), (0, 4), **text)
