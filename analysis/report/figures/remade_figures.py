"""The paper's figures, remade: their names, titles and captions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from analysis.normalised.readers import Run, Runs
from analysis.report.figure import Figure, Gallery, family_of
from analysis.report.figures.bed_figures import KEPT_BED, bed_figure, kept_bed_figure
from analysis.report.figures.lateral_figures import PROFILE_CYCLES, lateral_figure
from analysis.report.figures.load_figures import stress_figure
from analysis.report.figures.porosity_figures import porosity_figure
from analysis.report.figures.settlement_figures import measured_shape_figure, settlement_figure, shape_figure
from analysis.report.labels import KPA, MODE_NAMES, READING_NAMES, READING_SLUGS
from analysis.report.report_data import KEY_SCENARIOS
from analysis.report.sentences import slug
from analysis.scenarios.scenario import load_scenario

OF_CHEN = (
    "Chen et al. (2015) is run here from the parameters of Table 3, with parallel bonds between the particles that "
    "touch at the end of packing (assumed). It is not their published curve, which is pending."
)
AS_ABOVE = "Chen et al.'s model as in the figure before."


def figure5(gallery: Gallery, candidates: Sequence[Run], kept: Path) -> list[Figure | None]:
    """Packed beds, of the runs or the kept one, and the force chains after loading."""
    packed, label = [run for run in candidates if (run.folder / "raw" / "bed_packed.csv").exists()], "packed"
    packed = [run for run in packed if run.scenario and not run.scenario["packing.bed_from"]] or packed
    if not packed:
        packed, label = [run for run in candidates if (run.folder / "bed_before.csv").exists()], "before"
    what = (
        "after packing, before preload" if label == "packed" else "at the end of preload (the packed bed was not kept)"
    )
    drawn = bed_figure(
        gallery,
        packed[:2],
        "figure5",
        label,
        f"Figure 5 remade: the bed {what}",
        "Each code packs its own bed by the paper's procedure from the same lattice and orientations.",
    )
    return [
        drawn
        or kept_bed_figure(
            gallery,
            kept,
            "figure5",
            "Figure 5 remade: the full bed after packing, before preload",
            f"Packed by LIGGGHTS with seed 1 (reference_data/runs/{KEPT_BED}); cut open along the middle of the "
            "sleeper, which is drawn as glass. Two joined spheres are one clump.",
        ),
        bed_figure(
            gallery,
            candidates,
            "force-chains",
            "after",
            "Force chains",
            "Normal forces in a slab along the middle of the sleeper at minimum load; width and colour by force. "
            "Not a figure of the paper.",
            chains=True,
        ),
    ]


def figure6(gallery: Gallery, runs: Sequence[Run]) -> Figure | None:
    """The load as the parameters give it, and what runs measured of it."""
    if not KEY_SCENARIOS:
        return None
    s = load_scenario(KEY_SCENARIOS[0], "full")
    low, high = (KPA * s[f"loading.stress_{end}"] for end in ("min", "max"))
    return stress_figure(
        gallery,
        s,
        runs,
        "figure6",
        "Figure 6 remade: stress on the sleeper",
        f"{(high + low) / 2:g} − {(high - low) / 2:g} cos(2π · {s['loading.frequency']:g} Hz · t) kPa: the target "
        "(broad), and the contact force on the sleeper over its area in the first cycle (first period) and the last "
        "(third period).",
    )


def figure10(gallery: Gallery, runs: Runs, reading: str) -> list[Figure | None]:
    """Settlement and lateral displacement of the linear model."""
    linear, where = of_family(runs, "linear"), READING_NAMES[reading]
    return [
        settlement_figure(
            gallery,
            linear,
            f"figure10-settlement-{READING_SLUGS[reading]}",
            f"Figure 10 remade, {where}: settlement, linear contacts",
            "Friction 0.7, 0.8 and 0.9, between clumps and at walls.",
        ),
        lateral_figure(
            gallery,
            linear,
            f"figure10-lateral-{READING_SLUGS[reading]}",
            f"Figure 10 remade, {where}: lateral displacement, linear contacts",
            "Over depth below the sleeper.",
            cycles=PROFILE_CYCLES,
        ),
    ]


def figure11(gallery: Gallery, runs: Runs, reading: str) -> list[Figure | None]:
    """Settlement of the nonlinear model, a figure per damping mode."""
    return mode_figures(
        gallery,
        runs,
        settlement_figure,
        f"figure11-{READING_SLUGS[reading]}",
        f"Figure 11 remade, {READING_NAMES[reading]}: settlement",
        "eₙ is the nominal restitution; eₙ = 1 is the same law in all modes.",
    )


def figure12(gallery: Gallery, runs: Runs, reading: str) -> list[Figure | None]:
    """Lateral displacement of the nonlinear model, a figure per damping mode."""
    return mode_figures(
        gallery,
        runs,
        lambda *what: lateral_figure(*what, cycles=PROFILE_CYCLES),
        f"figure12-{READING_SLUGS[reading]}",
        f"Figure 12 remade, {READING_NAMES[reading]}: lateral displacement",
        "Over depth below the sleeper.",
    )


def figure13(gallery: Gallery, runs: Runs, reading: str) -> list[Figure | None]:
    """Porosity in the measurement spheres, both models on one scale."""
    return [
        porosity_figure(
            gallery,
            Runs(run for run in runs if run.base_name in KEY_SCENARIOS),
            f"figure13-{READING_SLUGS[reading]}",
            f"Figure 13b, c remade, {READING_NAMES[reading]}: porosity during loading",
            "Of the exact union of spheres over a fixed set of points; standard error about 0.001. Cycle 0 is the "
            "end of preload.",
        )
    ]


def three_models_figures(gallery: Gallery, runs: Runs, reading: str) -> list[Figure | None]:
    """The bonded model beside the paper's two in one reading: settlement and lateral displacement."""
    name, where = slug(reading), READING_NAMES[reading]
    stiff = Runs(run for run in runs if run.base_name != KEY_SCENARIOS[-1])  # the nonlinear model hides both
    return [
        settlement_figure(
            gallery, stiff, f"bonded-linear-{name}", f"Bonded and linear model, {where}: settlement", OF_CHEN
        ),
        settlement_figure(gallery, runs, f"bonded-settlement-{name}", f"Three models, {where}: settlement", AS_ABOVE),
        lateral_figure(
            gallery, runs, f"bonded-lateral-{name}", f"Three models, {where}: lateral displacement", AS_ABOVE
        ),
    ]


def of_family(runs: Sequence[Run], name: str) -> Runs:
    """The runs of one family of scenarios, see `family_of`."""
    return Runs(run for run in runs if family_of(run.scenario) == name)


def mode_figures(
    gallery: Gallery,
    runs: Sequence[Run],
    figure: Callable[..., Figure | None],
    name: str,
    title: str,
    caption: str,
) -> list[Figure | None]:
    """A figure for each damping mode that has a run, with the undamped runs in each; else one of these alone."""
    undamped = of_family(runs, "nonlinear")
    by_mode = {mode: of_family(runs, f"md{mode}") for mode in MODE_NAMES}
    return [
        figure(
            gallery, Runs([*undamped, *damped]), f"{name}-md{mode}", f"{title}, Md {mode} ({MODE_NAMES[mode]})", caption
        )
        for mode, damped in by_mode.items()
        if damped
    ] or [figure(gallery, undamped, f"{name}-en1", f"{title}, nonlinear contacts, eₙ = 1", caption)]


def shape_figures(gallery: Gallery, runs: Sequence[Run], reading: str) -> list[Figure | None]:
    """The shape of settlement beside published laws and triaxial tests."""
    return [
        shape_figure(
            gallery,
            runs,
            f"settlement-shape-{READING_SLUGS[reading]}",
            f"Settlement over that of the first cycle, {READING_NAMES[reading]}",
            "Published laws as shapes (broken grey): their absolute size belongs to other loads and beds. "
            "Coefficients are transcribed from secondary quotation.",
        ),
        measured_shape_figure(
            gallery,
            runs,
            f"measured-shape-{READING_SLUGS[reading]}",
            f"Settlement beside triaxial tests, {READING_NAMES[reading]}",
        ),
    ]
