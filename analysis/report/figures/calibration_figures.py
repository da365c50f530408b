"""The beds that were tried when the packing was calibrated."""

from __future__ import annotations

import pandas as pd

from analysis.reference.reported import reported
from analysis.report import style
from analysis.report.figure import Figure, Gallery
from analysis.report.labels import MM, short_name
from analysis.report.style import INK, PAPER, SOFT, Canvas


def calibration_figure(gallery: Gallery, beds: pd.DataFrame, chosen: tuple[float, float]) -> Figure | None:
    """Clumps against porosity of all beds, and how settlement depends on the clump's aspect at the chosen gap.

    beds     as `Findings.calibration` has them
    chosen   aspect and lattice gap (m) of the scenario file
    """
    return gallery.finish(
        "calibration",
        "Calibration of the packing",
        "Left: clumps and mean porosity of the packed beds, each named by the aspect of its clumps, or by the gap of "
        "its lattice where that is not the chosen one; the filled one was chosen. Right: settlement of beds of the "
        f"chosen gap after {beds['cycles'].max():.0f} cycles. The choice was made for count and porosity, which are no "
        "evidence any more, and for a bed that is not jammed; how far it then settles was not tuned.",
        [_packed(gallery, beds, chosen), _settled(gallery, beds, chosen)],
        [],
    )


def _packed(gallery: Gallery, beds: pd.DataFrame, chosen: tuple[float, float]) -> Canvas:
    c = style.canvas("calibration-packing", "Clumps and porosity of the beds that were tried", right=0.5)
    packed = beds[beds["scenario"] == beds["scenario"].iloc[0]].dropna(subset=["clumps", "porosity_mean"])
    colour, _ = gallery.look(beds["scenario"].iloc[0])
    for bed in packed.itertuples():
        _draw_bed(c, bed, chosen, colour)
    _draw_paper(c)
    c.axes.set(xlabel="clumps after packing (grey: ± 2 % of the paper's)", ylabel="mean porosity of the three spheres")
    c.axes.margins(0.14, 0.1)
    c.table = packed
    return c


def _draw_bed(canvas: Canvas, bed, chosen: tuple[float, float], colour: str) -> None:
    """A mark for a row of the beds, filled where it was chosen, with its aspect or gap."""
    is_chosen = (bed.aspect, bed.lattice_gap_m) == chosen
    canvas.axes.plot(
        bed.clumps,
        bed.porosity_mean,
        "o",
        color=colour,
        markersize=6,
        markeredgewidth=1.3,
        markerfacecolor=colour if is_chosen else PAPER,
    )
    text = f"aspect {bed.aspect:g}" if bed.lattice_gap_m == chosen[1] else f"gap {bed.lattice_gap_m * MM:g} mm"
    canvas.axes.annotate(
        text,
        (bed.clumps, bed.porosity_mean),
        xytext=(-6 if is_chosen else 6, 0),  # the paper's mark stands right of the chosen bed
        textcoords="offset points",
        va="center",
        ha="right" if is_chosen else "left",
        fontsize=style.SMALL,
        color=colour,
    )


def _draw_paper(canvas: Canvas) -> None:
    """The clumps and the porosity that the paper reports."""
    paper = reported()
    canvas.axes.plot(paper.clumps, paper.porosity, "+", color=INK, markersize=13, markeredgewidth=1.6)
    canvas.axes.annotate(
        "paper",
        (paper.clumps, paper.porosity),
        xytext=(-8, 5),
        textcoords="offset points",
        ha="right",
        fontsize=style.SMALL,
        color=INK,
    )
    canvas.axes.axvspan(0.98 * paper.clumps, 1.02 * paper.clumps, color=SOFT, alpha=0.12, linewidth=0)


def _settled(gallery: Gallery, beds: pd.DataFrame, chosen: tuple[float, float]) -> Canvas | None:
    settled = beds[(beds["lattice_gap_m"] == chosen[1]) & (beds["settlement_m"] > 0)]
    settled = settled[settled["cycles"] == beds["cycles"].max()].sort_values("aspect")
    if settled.empty:
        return None
    c = style.canvas("calibration-settlement", "Settlement against the aspect of the clump")
    for scenario, part in settled.groupby("scenario", sort=False):
        colour, _ = gallery.look(scenario)
        c.axes.plot(part["aspect"], MM * part["settlement_m"], "o-", color=colour)
        c.labels.append((part["aspect"].iloc[-1], MM * part["settlement_m"].iloc[-1], short_name(scenario), colour))
    c.axes.axvline(chosen[0], color=SOFT, linewidth=0.9, linestyle=(0, (2, 2)))
    c.axes.set_yscale("log")
    c.axes.set(xlabel="aspect of the clump, length over width", ylabel="settlement, mm (logarithmic)")
    c.table = settled
    return c
