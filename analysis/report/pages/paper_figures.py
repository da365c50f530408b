"""The paper's figures remade, with the tables that belong to them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from analysis.comparison import against_published, settlement_fits
from analysis.comparison.findings.members import READINGS, SERVO, TRUE_LOAD, member
from analysis.comparison.quantities import last_cycle
from analysis.comparison.restitution import restitution_table
from analysis.normalised.readers import Run, Runs
from analysis.report.figure import Figure, Gallery, family_of
from analysis.report.figures.beds import KEPT_BED, bed_figure, kept_bed_figure
from analysis.report.figures.lateral import PROFILE_CYCLES, lateral_figure
from analysis.report.figures.load import stress_figure
from analysis.report.figures.porosity import porosity_figure, sphere_figure
from analysis.report.figures.restitution import restitution_figure
from analysis.report.figures.settlement import measured_shape_figure, settlement_figure, shape_figure
from analysis.report.labels import KPA, MM, MODE_NAMES, READING_NAMES, SOURCE_NAMES, short_name
from analysis.report.pages.bonded import bonded_group
from analysis.report.report_data import (
    CHEN_SCENARIOS,
    KEY_SCENARIOS,
    PAPER_SCENARIOS,
    ReportData,
    key_runs,
    name_of,
)
from analysis.report.style import CODE_NAMES
from analysis.report.tables import Chip, Column, Table, interval, number
from analysis.scenarios.scenario import load_scenario


def paper_figures(data: ReportData) -> dict:
    """Figures 5, 6 and 9 to 13 remade, from full-size runs where there are any, 10 to 13 in both readings of the
    load.
    """
    g = data.gallery
    profile = data.profiles[0] if data.profiles else "full"
    runs = data.of(profile)
    readings = [reading for reading in READINGS if any(member(run).reading == reading for run in runs)]
    by_reading = {reading: Runs(run for run in runs if member(run).reading == reading) for reading in readings}
    groups = [
        bed_group(data, profile),
        load_group(data, profile),
        {"title": "Figure 9: the damping modes", "figures": [restitution_figure(g)], "tables": [restitution_rows()]},
        group("Figure 10: the linear model", by_reading, lambda mine, reading: figure10(g, mine, reading)),
        bonded_group(data, profile),
        group("Figure 11: settlement, nonlinear model", by_reading, lambda mine, reading: figure11(g, mine, reading)),
        group(
            "Figure 12: lateral displacement, nonlinear model",
            by_reading,
            lambda mine, reading: figure12(g, mine, reading),
        ),
        group("Figure 13: porosity", by_reading, lambda mine, reading: figure13(g, mine, reading)),
        {
            "title": "The shape of settlement",
            "missing": WAITS,
            "figures": [
                shape_figure(
                    g,
                    key_runs(data, profile, reading),
                    f"settlement-shape-{SLUGS[reading]}",
                    f"Settlement over that of the first cycle, {READING_NAMES[reading]}",
                    "Published laws as shapes (broken grey): their absolute size belongs to other loads and beds. "
                    "Coefficients are transcribed from secondary quotation.",
                )
                for reading in readings
            ]
            + [
                measured_shape_figure(
                    g,
                    key_runs(data, profile, reading),
                    f"measured-shape-{SLUGS[reading]}",
                    f"Settlement beside triaxial tests, {READING_NAMES[reading]}",
                )
                for reading in readings
            ],
            "folded": [law_table(data, profile)],
        },
        {
            "title": "Reference curves",
            "figures": [],
            "tables": [sources_table(data), reference_scores(data, profile), lateral_scores(data, profile)],
            "missing": "",
        },
        own_group(g, runs),
    ]
    if KEY_SCENARIOS:
        groups[7]["figures"].insert(0, sphere_figure(g, load_scenario(KEY_SCENARIOS[0], "full")))
    for part in groups:
        part["figures"] = [f for f in part["figures"] if f]
        for kind in ("tables", "folded"):
            part[kind] = [t for t in part.get(kind, ()) if t]
    return {
        "profile": profile,
        "runs": len(runs),
        "groups": [part for part in groups if part["figures"] or part["tables"] or part["missing"]],
        "pending": len(data.references.pending),
        "reference_problems": data.references.problems,
    }


WAITS = "It appears as soon as a run of one of its scenarios has finished a cycle."
SLUGS = {TRUE_LOAD: "force", SERVO: "servo"}


def group(title: str, by_reading: dict[str, Runs], figures: Callable[[Runs, str], list]) -> dict:
    """One of the paper's figures in every reading that has runs."""
    drawn = [figure for reading, mine in by_reading.items() for figure in figures(mine, reading)]
    return {"title": title, "missing": WAITS, "figures": drawn}


def figure10(g: Gallery, runs: Runs, reading: str) -> list[Figure | None]:
    """Settlement and lateral displacement of the linear model."""
    linear, where = of_family(runs, "linear"), READING_NAMES[reading]
    return [
        settlement_figure(
            g,
            linear,
            f"figure10-settlement-{SLUGS[reading]}",
            f"Figure 10 remade, {where}: settlement, linear contacts",
            "Friction 0.7, 0.8 and 0.9, between clumps and at walls.",
        ),
        lateral_figure(
            g,
            linear,
            f"figure10-lateral-{SLUGS[reading]}",
            f"Figure 10 remade, {where}: lateral displacement, linear contacts",
            "Over depth below the sleeper.",
            cycles=PROFILE_CYCLES,
        ),
    ]


def figure11(g: Gallery, runs: Runs, reading: str) -> list[Figure | None]:
    """Settlement of the nonlinear model, a figure per damping mode."""
    return mode_figures(
        g,
        runs,
        settlement_figure,
        f"figure11-{SLUGS[reading]}",
        f"Figure 11 remade, {READING_NAMES[reading]}: settlement",
        "eₙ is the nominal restitution; eₙ = 1 is the same law in all modes.",
    )


def figure12(g: Gallery, runs: Runs, reading: str) -> list[Figure | None]:
    """Lateral displacement of the nonlinear model, a figure per damping mode."""
    return mode_figures(
        g,
        runs,
        lambda *what: lateral_figure(*what, cycles=PROFILE_CYCLES),
        f"figure12-{SLUGS[reading]}",
        f"Figure 12 remade, {READING_NAMES[reading]}: lateral displacement",
        "Over depth below the sleeper.",
    )


def figure13(g: Gallery, runs: Runs, reading: str) -> list[Figure | None]:
    """Porosity in the measurement spheres, both models on one scale."""
    return [
        porosity_figure(
            g,
            Runs(run for run in runs if run.base_name in KEY_SCENARIOS),
            f"figure13-{SLUGS[reading]}",
            f"Figure 13b, c remade, {READING_NAMES[reading]}: porosity during loading",
            "Of the exact union of spheres over a fixed set of points; standard error about 0.001. Cycle 0 is the "
            "end of "
            "preload.",
        )
    ]


def own_group(g: Gallery, runs: Runs) -> dict:
    """Scenarios that are not the paper's."""
    others = Runs(run for run in runs if run.base_name not in (*PAPER_SCENARIOS, *CHEN_SCENARIOS))
    return {
        "title": "Scenarios that are not the paper's",
        "missing": "",
        "figures": [
            settlement_figure(
                g, others, "own-settlement", "Settlement, further scenarios", "Scenarios added to scenarios.toml."
            ),
            lateral_figure(
                g, others, "own-lateral", "Lateral displacement, further scenarios", "Over depth below the sleeper."
            ),
        ],
    }


def of_family(runs: Sequence[Run], name: str) -> Runs:
    """The runs of one family of scenarios, see `family_of`."""
    return Runs(run for run in runs if family_of(run.scenario) == name)


def mode_figures(
    g: Gallery,
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
        figure(g, Runs([*undamped, *damped]), f"{name}-md{mode}", f"{title}, Md {mode} ({MODE_NAMES[mode]})", caption)
        for mode, damped in by_mode.items()
        if damped
    ] or [figure(g, undamped, f"{name}-en1", f"{title}, nonlinear contacts, eₙ = 1", caption)]


def bed_group(data: ReportData, profile: str) -> dict:
    """Figure 5: packed beds, and the force chains after loading."""
    g = data.gallery
    candidates = [run for run in key_runs(data, profile) if run.seed == 1]
    candidates = candidates or list(data.of(profile))[:2]
    packed, label = [run for run in candidates if (run.folder / "raw" / "bed_packed.csv").exists()], "packed"
    packed = [run for run in packed if run.scenario and not run.scenario["packing.bed_from"]] or packed
    if not packed:
        packed, label = [run for run in candidates if (run.folder / "bed_before.csv").exists()], "before"
    what = (
        "after packing, before preload" if label == "packed" else "at the end of preload (the packed bed was not kept)"
    )
    drawn = bed_figure(
        g,
        packed[:2],
        "figure5",
        label,
        f"Figure 5 remade: the bed {what}",
        "Each code packs its own bed by the paper's procedure from the same lattice and orientations.",
    )
    return {
        "title": "Figure 5: the bed",
        "missing": "It needs a run whose beds are on this machine, or a bed in reference_data/runs/beds.",
        "figures": [
            drawn
            or kept_bed_figure(
                g,
                data.kept,
                "figure5",
                "Figure 5 remade: the full bed after packing, before preload",
                f"Packed by LIGGGHTS with seed 1 (reference_data/runs/{KEPT_BED}); cut open along the middle of the "
                "sleeper, which is drawn as glass. Two joined spheres are one clump.",
            ),
            bed_figure(
                g,
                candidates,
                "force-chains",
                "after",
                "Force chains",
                "Normal forces in a slab along the middle of the sleeper at minimum load; width and colour by force. "
                "Not a figure of the paper.",
                chains=True,
            ),
        ],
    }


def load_group(data: ReportData, profile: str) -> dict:
    """Figure 6: the load as the parameters give it, and what runs measured of it."""
    figures = []
    if KEY_SCENARIOS:
        s = load_scenario(KEY_SCENARIOS[0], "full")
        low, high = (KPA * s[f"loading.stress_{end}"] for end in ("min", "max"))
        figures.append(
            stress_figure(
                data.gallery,
                s,
                [run for run in key_runs(data, profile) if run.seed == 1],
                "figure6",
                "Figure 6 remade: stress on the sleeper",
                f"{(high + low) / 2:g} − {(high - low) / 2:g} cos(2π · {s['loading.frequency']:g} Hz · t) kPa: the "
                "target (broad), and the contact force on the sleeper over its area in the first cycle (first period) "
                "and the last (third period).",
            )
        )
    return {"title": "Figure 6: the load", "missing": "", "figures": figures}


def law_table(data: ReportData, profile: str) -> Table | None:
    """Which law describes each settlement curve, and whether it has the exponential start."""
    table = Table(
        "Does settlement start exponentially? S = a + b (1 − exp(−N/c)) + d N against a logarithm, a power law and a "
        "straight line",
        [
            Column("run"),
            Column("cycles", True),
            Column("best law"),
            Column("exponential start"),
            Column("b, mm", True),
            Column("c, cycles", True),
            Column("d, mm per 1000 cycles", True),
            Column("why", wide=True),
        ],
    )
    for run in data.of(profile):
        if run.seed != 1:
            continue
        choice = settlement_fits.choose(run.cycles["cycle"], run.cycles["settlement_m"])
        fit = choice.fits.get("exponential")
        kind = {"yes": "good", "no": "bad"}.get(choice.exponential_start, "open")
        cells = [interval(fit, name, factor) for name, factor in (("b", MM), ("c", 1.0), ("d", 1e6))]
        table.rows.append(
            [
                name_of(run),
                str(last_cycle(run)),
                choice.best or "–",
                Chip(choice.exponential_start, kind),
                *cells,
                choice.reason,
            ]
        )
    table.note = (
        "Chosen by the Bayesian information criterion; brackets: 95 % confidence intervals of the "
        "exponential law, whichever law is best."
    )
    return table if table.rows else None


def reference_scores(data: ReportData, profile: str) -> Table | None:
    """Settlement of runs against the reference curves that are there."""
    rows = against_published.reference_table(data.of(profile), data.references)
    table = Table(
        "Settlement against the reference curves",
        [
            Column("run"),
            Column("reference"),
            Column("points", True),
            Column("rms, mm", True),
            Column("shift, mm", True),
            Column("rms after the shift, mm", True),
            Column("late slope, ratio", True),
            Column("first cycle, ratio", True),
            Column("within its error, %", True),
            Column("after the shift, %", True),
        ],
    )
    for r in rows.itertuples():
        table.rows.append(
            [
                f"{r.profile}, {short_name(r.scenario)}, "
                f"{CODE_NAMES.get(r.code, r.code)}{f', seed {r.seed}' if r.seed != 1 else ''}",
                f"{SOURCE_NAMES.get(r.source, r.source)}: {r.curve}",
                str(r.points),
                number(r.rms_m, 3, MM),
                number(r.shift_m, 3, MM),
                number(r.rms_shifted_m, 3, MM),
                number(r.late_slope_ratio, 3),
                number(r.first_cycle_ratio, 3),
                number(r.within_error, 3, 100),
                number(r.within_error_shifted, 3, 100),
            ]
        )
    table.note = (
        "Over the cycles that both have, at the points of the reference. Shift: run minus reference, mean; "
        "removed, it leaves the difference in shape."
    )
    return table if table.rows else None


def lateral_scores(data: ReportData, profile: str) -> Table | None:
    """Lateral displacement of runs against the reference profiles that are there."""
    rows = against_published.lateral_reference_table(data.of(profile), data.references)
    table = Table(
        "Lateral displacement against the reference profiles",
        [
            Column("run"),
            Column("reference"),
            Column("cycle", True),
            Column("rms, mm", True),
            Column("rms over the reference's mean", True),
            Column("ratio of means", True),
        ],
    )
    for r in rows.itertuples():
        table.rows.append(
            [
                f"{short_name(r.scenario)}, {CODE_NAMES.get(r.code, r.code)}"
                + (f", seed {r.seed}" if r.seed != 1 else ""),
                f"{SOURCE_NAMES.get(r.source, r.source)}: {r.curve}",
                str(r.cycle),
                number(r.rms_m, 3, MM),
                number(r.relative, 3),
                number(r.ratio, 3),
            ]
        )
    table.note = "At the depths of the five plates that the reference covers."
    return table if table.rows else None


def sources_table(data: ReportData) -> Table | None:
    """Where each reference curve comes from: who digitised it, how, with what error; or that it is pending."""
    table = Table(
        "Where the reference curves come from",
        [
            Column("file"),
            Column("status"),
            Column("curves", True),
            Column("points", True),
            Column("error"),
            Column("digitised by"),
            Column("how", wide=True),
            Column("licence", wide=True),
        ],
    )
    for r in data.references.sources.itertuples():
        table.rows.append(
            [
                r.sidecar,
                Chip(r.status, "open" if r.status == "pending" else "good"),
                f"{r.digitised} of {r.curves}",
                str(r.points or "–"),
                r.error or "–",
                f"{r.digitised_by}, {r.date}" if r.digitised_by else "–",
                r.method or "–",
                r.licence,
            ]
        )
    table.note = (
        "The sidecars in reference_data/published say more; each page of the report takes these points and no others."
    )
    return table if table.rows else None


def restitution_rows() -> Table:
    """Nominal against effective restitution at the paper's values of e_n."""
    table = restitution_table().set_index(["damping_mode", "nominal_restitution"])
    values = table["effective_restitution"].unstack()
    return Table(
        "What comes out of a free impact at the paper's nominal restitutions",
        [Column("damping mode"), *(Column(f"eₙ = {e:g}", True) for e in values)],
        [
            [f"Md {mode}, {MODE_NAMES[mode]}", *("–" if math.isnan(v) else f"{v:.4f}" for v in row)]
            for mode, row in zip(values.index, values.to_numpy(), strict=True)
        ],
    )
