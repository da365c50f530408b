"""The figures of the first page: the test as a sketch, and both models in both readings of the load."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd
from matplotlib.patches import Circle, Polygon, Rectangle

from analysis.comparison.findings.members import READINGS, SERVO, Member
from analysis.report import style
from analysis.report.curve_drawing import curve_rows, cycle_axis, draw, last_cycle_of
from analysis.report.figure import Figure, Gallery
from analysis.report.labels import KPA, MM, READING_NAMES, short_name, time_steps
from analysis.report.style import CODE_NAMES, CODE_SIGNS, INK, SOFT, Canvas
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario


def sketch_figure(gallery: Gallery, scenario: Scenario) -> Figure:
    """The test as a side view, drawn from the parameters: box, sleeper, load, plates and measurement spheres."""
    box = derived.apparatus(scenario)
    low, high = (box.sleeper_area_m2 * scenario[f"loading.stress_{end}"] / 1e3 for end in ("min", "max"))
    frequency = scenario["loading.frequency"]
    c = style.canvas(
        "sketch",
        f"Side view of the test: a sleeper on ballast in a box of {MM * box.length_m:g} by {MM * box.width_m:g} mm, "
        f"loaded "
        f"by {low:.3g} to {high:.3g} kN at {frequency:g} Hz, five movable plates on the right",
        width=5.2,
        height=3.7,
        left=0.05,
        right=0.05,
        bottom=0.05,
        top=0.05,
    )
    ax = c.axes
    _ballast(ax, scenario, box)
    ax.plot([0, 0, box.length_m, box.length_m], [box.height_m, 0, 0, 0], color=INK, linewidth=2)
    ax.plot([box.length_m] * 2, [box.plates[-1].high[2], box.height_m], color=INK, linewidth=2)
    _spheres(ax, box)
    top = box.sleeper.high
    _sleeper(ax, box)
    _load(ax, top, low, high, frequency)
    _plates(ax, box, scenario)
    ax.text(0.0, -0.018, "1 to 3: porosity is measured here", fontsize=10.6, color=style.shade("linear"), va="top")
    ax.set(xlim=(-0.03, box.length_m + 0.13), ylim=(-0.06, top[2] + 0.2), aspect="equal")
    ax.set_axis_off()
    c.table = _corners(box)
    return gallery.finish(
        "test",
        "The test",
        f"View along the track. Into the page the box is {MM * box.width_m:g} mm, with "
        f"{MM * (box.width_m - scenario['geometry.sleeper_width']) / 2:g} mm "
        f"of ballast (the cribs) before and behind the sleeper, not drawn. {low:.3g} to {high:.3g} kN are "
        f"{KPA * scenario['loading.stress_min']:g} to {KPA * scenario['loading.stress_max']:g} kPa under the sleeper.",
        [c],
        [],
    )


def _spheres(ax, box) -> None:
    """The measurement spheres, numbered."""
    for k, (x, _, z) in enumerate(box.measurement_centres_m):
        ax.add_patch(
            Circle((x, z), box.measurement_radius_m, fill=False, edgecolor=style.shade("linear"), linewidth=1.2)
        )
        ax.text(x, z, str(k + 1), ha="center", va="center", fontsize=10.6, color=style.shade("linear"), weight="bold")


def _sleeper(ax, box) -> None:
    """The sleeper with its name."""
    bottom, top = box.sleeper.low, box.sleeper.high
    ax.add_patch(
        Rectangle(
            (0, bottom[2]),
            top[0],
            top[2] - bottom[2],
            facecolor=style.shade("soft"),
            alpha=0.35,
            edgecolor=INK,
            linewidth=1,
        )
    )
    ax.text(top[0] / 2, (bottom[2] + top[2]) / 2, "sleeper, moves vertically", ha="center", va="center", fontsize=10.6)


def _plates(ax, box, scenario: Scenario) -> None:
    """The plates with the stress that presses them inward."""
    for number, plate in enumerate(box.plates, start=1):
        middle = (plate.low[2] + plate.high[2]) / 2
        ax.add_patch(Rectangle((box.length_m + 0.003, plate.low[2]), 0.02, plate.high[2] - plate.low[2], color=SOFT))
        ax.annotate(
            "",
            (box.length_m + 0.026, middle),
            (box.length_m + 0.075, middle),
            arrowprops={"arrowstyle": "->", "color": INK, "linewidth": 1},
        )
        ax.text(box.length_m + 0.082, middle, str(number), va="center", fontsize=10.6)
    ax.text(
        box.length_m + 0.012,
        -0.018,
        f"plates, {KPA * scenario['preload.plate_stress']:g} kPa each",
        fontsize=10.6,
        ha="center",
        va="top",
    )


def _corners(box) -> pd.DataFrame:
    """Corners of sleeper and plates, m."""
    return pd.DataFrame(
        [
            {
                "part": name,
                **{
                    f"{axis}_{end}_m": v[n]
                    for end, v in (("low", b.low), ("high", b.high))
                    for n, axis in enumerate("xyz")
                },
            }
            for name, b in (("sleeper", box.sleeper), *((f"plate {k}", p) for k, p in enumerate(box.plates, 1)))
        ]
    )


def _ballast(ax, scenario: Scenario, box) -> None:
    """Clumps as the eye sees them: two circles each, of the clump's size, at random where ballast lies."""
    clump, generator = derived.clump(scenario), np.random.default_rng(4)
    reach = clump.radius_m
    xs = np.arange(reach, box.length_m, 2.1 * reach)
    for row, z in enumerate(np.arange(reach, box.sleeper.low[2], 1.8 * reach)):
        for x in xs + (row % 2) * reach:
            angle = generator.uniform(0, np.pi)
            if x > box.length_m - reach:
                continue
            for side in (-0.6, 0.6):
                away = side * clump.half_distance_m
                at = x + away * np.cos(angle), z + away * np.sin(angle)
                ax.add_patch(Circle(at, 0.8 * reach, facecolor=style.shade("soft"), alpha=0.25, edgecolor="none"))


def _load(ax, top, low: float, high: float, frequency: float) -> None:
    """The arrow of the load, and a few of its cycles beside it."""
    middle, colour = top[0] / 2, style.shade("nonlinear")
    tip = [(middle - 0.028, top[2] + 0.04), (middle + 0.028, top[2] + 0.04), (middle, top[2] + 0.004)]
    ax.add_patch(Polygon(tip, color=colour))
    ax.plot([middle] * 2, [top[2] + 0.035, top[2] + 0.1], color=colour, linewidth=3)
    t = np.linspace(0, 3, 200)
    ax.plot(middle + 0.06 + 0.08 * t, top[2] + 0.06 - 0.035 * np.cos(2 * np.pi * t), color=colour, linewidth=1.4)
    words = f"{low:.3g} to {high:.3g} kN"
    ax.text(middle - 0.04, top[2] + 0.075, words, ha="right", va="center", fontsize=10.6, weight="bold")
    ax.text(middle + 0.06, top[2] + 0.125, f"{frequency:g} Hz", ha="left", va="center", fontsize=10.6)


def both_readings_figure(
    gallery: Gallery, members: Sequence[Member], scenarios: Iterable[str], name: str, title: str, caption: str
) -> Figure | None:
    """Settlement of `scenarios` against cycles, an axis of its own for each, both readings and both codes in it."""
    drawn, used = [], []
    for scenario in scenarios:
        found = [m for m in members if m.scenario == scenario]
        if not found:
            continue
        c = style.canvas(f"{name}-{scenario}", _alt(found, scenario))
        curves_here = []
        for reading in READINGS:
            for curve in gallery.curves(m.run for m in found if m.reading == reading):
                colour = style.shade("servo") if reading == SERVO else curve.colour
                beds = f", mean of {len(curve.runs)} beds" if len(curve.runs) > 1 else ""
                draw(
                    c,
                    curve,
                    curve.column("settlement_m"),
                    MM,
                    colour=colour,
                    name=f"{READING_NAMES[reading]}, {CODE_NAMES.get(curve.code, curve.code)}{beds}",
                    tag=f"{READING_NAMES[reading]} {CODE_SIGNS.get(curve.code, '◆')}",
                    seeds=curve.seeds("settlement_m"),
                )
                curves_here.append(curve)
        _finish_panel(c, curves_here, short_name(scenario))
        drawn.append(c)
        used += curves_here
    runs = [run for curve in used for run in curve.runs]
    steps = " Runs differ in their time step (page Time step)." if time_steps(runs) else ""
    return gallery.finish(name, title, caption + steps, drawn, runs, used)


def full_settlement_figure(gallery: Gallery, members: Sequence[Member], scenarios: Iterable[str]) -> Figure | None:
    """Settlement on the full bed, of those of `members` that are plain runs of it."""
    return both_readings_figure(
        gallery,
        [m for m in members if m.run.profile == "full" and m.plain],
        scenarios,
        "settlement-full",
        "Settlement of the sleeper on the full bed",
        "At the end of a cycle, where the target of the load is least; by PFC's servo the stress lags behind it and "
        "is then greater. Zero at the end of preload; cycles on a logarithmic axis, each model on a scale of its own. "
        "Each code packs its own beds. Thin lines are single packed beds, the thick line is their mean as far as all "
        "of them reach.",
    )


def demo_settlement_figure(gallery: Gallery, members: Sequence[Member]) -> Figure | None:
    """Settlement on the demo bed."""
    return both_readings_figure(
        gallery,
        members,
        dict.fromkeys(m.scenario for m in members),
        "settlement-demo",
        "Settlement of the sleeper on the demo bed",
        "At the end of a cycle, where the target of the load is least; zero at the end of preload.",
    )


def _finish_panel(canvas: Canvas, curves: list, title: str) -> None:
    canvas.axes.set_ylim(bottom=0)
    canvas.axes.invert_yaxis()
    canvas.axes.set_ylabel("settlement at minimum load, mm")
    canvas.axes.set_title(title)
    canvas.hover_unit = "mm"
    cycle_axis(canvas, last_cycle_of(curves), True)
    canvas.table = curve_rows(curves, ["cycle", "settlement_m", "settlement_peak_m"])


def _alt(found: Sequence[Member], scenario: str) -> str:
    """What the panel says, for those who do not see it."""
    parts = []
    for reading in READINGS:
        runs = [m.run for m in found if m.reading == reading]
        if runs:
            longest = max(runs, key=lambda run: run.cycles["cycle"].iloc[-1])
            last = longest.cycles.iloc[-1]
            parts.append(
                f"{READING_NAMES[reading]} {MM * last['settlement_m']:.3g} mm after {last['cycle']:.0f} cycles"
            )
    return f"Settlement of {short_name(scenario)}: {', '.join(parts)}"
