"""Porosity in the measurement spheres, and where they are."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd
from matplotlib.patches import Circle, Rectangle

from analysis.formats import file_columns
from analysis.formats.quantities import SPHERE_NAMES
from analysis.normalised.readers import Run
from analysis.report import style
from analysis.report.curve_drawing import (
    MARKED_TOP,
    curve_rows,
    cycle_axis,
    draw,
    draw_references,
    last_cycle_of,
    pending_mark,
    pending_names,
    reference_csv,
    up_to,
)
from analysis.report.figure import Curve, Figure, Gallery
from analysis.report.labels import MM, of_any_bed, short_name
from analysis.report.style import CODE_NAMES, CODE_SIGNS, SOFT, Canvas
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario


def porosity_figure(
    gallery: Gallery, runs: Sequence[Run], name: str, title: str, caption: str, references: bool = True
) -> Figure | None:
    """Porosity of the three measurement spheres against cycles, one panel per scenario, whatever bed it began from."""
    curves = gallery.curves(runs)
    pending = pending_names(gallery.references, "porosity", {c.scenario for c in curves}) if references else []
    drawn = []
    for scenario in dict.fromkeys(of_any_bed(curve.scenario) for curve in curves):
        members = [curve for curve in curves if of_any_bed(curve.scenario) == scenario]
        rows = gallery.references.curve("porosity", scenario=scenario)
        c = _panel(f"{name}-{scenario}", scenario, members, rows if references else rows.iloc[:0], pending)
        drawn.append(c)
    limits = [c.axes.get_ylim() for c in drawn]
    for c in drawn:  # one scale, so that the models' ranges can be compared
        c.axes.set_ylim(min(low for low, _ in limits), max(high for _, high in limits))
    return gallery.finish(name, title, caption, drawn, runs, curves, pending)


def _panel(name: str, scenario: str, members: Sequence[Curve], rows: pd.DataFrame, pending: Sequence[str]) -> Canvas:
    """The curves of one scenario over its reference points `rows`; `pending` are references that are not there."""
    top = MARKED_TOP if pending else 0.32
    c = style.canvas(name, f"Porosity in the three spheres, {short_name(scenario)}", height=2.68 + top, top=top)
    for curve in members:
        _draw_spheres(c, curve, members[0].family, CODE_SIGNS.get(curve.code, "◆") if len(members) > 1 else "")
    draw_references(c, up_to(rows, last_cycle_of(members)), "cycle", 1.0)
    c.axes.set_ylabel("porosity")
    cycle_axis(c, last_cycle_of(members), False)
    c.axes.set_title(short_name(scenario))
    pending_mark(c, pending, rows)
    columns = ["cycle", *(f"porosity_{k}" for k in file_columns.SPHERES), "porosity_error"]
    points = [
        reference_csv(part, **{"cycle": "cycle", f"porosity_{sphere:.0f}": "value", "porosity_error": "error"})
        for sphere, part in rows.groupby("sphere")
    ]
    c.table = pd.concat([curve_rows(members, columns, "microstructure"), *points])
    return c


def _draw_spheres(canvas: Canvas, curve: Curve, family: str, sign: str) -> None:
    """A curve for each sphere, from microstructure.csv or, in runs without it, from cycles.csv."""
    for k, sphere in enumerate(SPHERE_NAMES, start=1):
        for source in ("microstructure", "cycles"):
            table = curve.column(f"porosity_{k}", source)
            if len(table):
                break
        draw(
            canvas,
            curve,
            table,
            1.0,
            colour=style.shade(family, k - 2.0),
            name=f"{k} {sphere} {CODE_NAMES.get(curve.code, curve.code)}",
            tag=f"{k} {sphere} {sign}".rstrip(),
            seeds=curve.seeds(f"porosity_{k}", source),
        )


def sphere_figure(gallery: Gallery, setup: Scenario) -> Figure:
    """The paper's Figure 13a: where the measurement spheres are."""
    box = derived.apparatus(setup)
    c = style.canvas(
        "figure13a-spheres",
        "Measurement spheres under the sleeper, side view",
        width=4.1,
        height=2.7,
        left=0.62,
        right=0.2,
    )
    _draw_apparatus(c, box)
    for k, (x, _, z) in enumerate(box.measurement_centres_m):
        colour = style.shade("linear", k - 1.0)
        c.axes.add_patch(
            Circle((MM * x, MM * z), MM * box.measurement_radius_m, facecolor=colour, alpha=0.25, edgecolor=colour)
        )
        c.axes.text(MM * x, MM * z, f"{k + 1}\n{SPHERE_NAMES[k]}", ha="center", va="center", fontsize=8.5, color=colour)
    c.axes.set(
        xlim=(-20, 880), ylim=(-12, 495), xlabel="along the sleeper x, mm", ylabel="height z, mm", aspect="equal"
    )
    c.axes.grid(False)
    c.table = pd.DataFrame(
        [
            {"sphere": k + 1, "x_m": x, "y_m": y, "z_m": z, "radius_m": box.measurement_radius_m}
            for k, (x, y, z) in enumerate(box.measurement_centres_m)
        ]
    )
    return gallery.finish(
        "figure13a",
        "Figure 13a remade: the measurement spheres",
        f"Radius {MM * box.measurement_radius_m:g} mm (reported); the centres follow from the "
        "apparatus (derived). 1 lies under the rail seat, 3 at the shoulder, behind the movable plates 1 to 5.",
        [c],
        [],
    )


def _draw_apparatus(c: Canvas, box: derived.Apparatus) -> None:
    """Box, sleeper and plates, from the side."""
    c.axes.add_patch(Rectangle((0, 0), MM * box.length_m, MM * box.height_m, fill=False, edgecolor=SOFT, linewidth=1))
    low, high = box.sleeper.low, box.sleeper.high
    c.axes.add_patch(
        Rectangle((0, MM * low[2]), MM * high[0], MM * (high[2] - low[2]), facecolor=SOFT, alpha=0.35, linewidth=0)
    )
    c.axes.text(MM * high[0] / 2, MM * (low[2] + high[2]) / 2, "sleeper", ha="center", va="center", fontsize=8.5)
    for number, plate in enumerate(box.plates, start=1):
        c.axes.add_patch(
            Rectangle(
                (MM * plate.low[0], MM * plate.low[2]),
                24,
                MM * (plate.high[2] - plate.low[2]),
                facecolor=SOFT,
                linewidth=0,
            )
        )
        c.axes.text(
            MM * plate.low[0] + 34,
            MM * (plate.low[2] + plate.high[2]) / 2,
            str(number),
            va="center",
            fontsize=style.SMALL,
        )
