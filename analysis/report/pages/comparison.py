"""The page that sets both codes next to each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.comparison import codes, quantities, same_bed
from analysis.comparison.quantities import last_cycle
from analysis.formats.numbers import plural
from analysis.formats.quantities import GRAVITY_M_S2 as GRAVITY
from analysis.report.figures.lateral import PROFILE_CYCLES
from analysis.report.figures.load import loop_figure, stroke_figure
from analysis.report.figures.microstructure import microstructure_figure
from analysis.report.figures.same_bed import same_bed_figure
from analysis.report.labels import MM, basis_of, short_name
from analysis.report.report_data import (
    PROFILE_TEXT,
    ReportData,
    code_of,
    name_of,
    overview_runs,
)
from analysis.report.style import CODE_NAMES
from analysis.report.tables import Chip, Column, Table, number, quantity_name, shown

AGREEMENT_BRIEF = ("settlement_m", "lateral_mean_m", "resilient_stroke_m", "porosity_2", "coordination_number")
AGREEMENT_SHOWN = (
    "settlement_m",
    "settlement_peak_m",
    "lateral_mean_m",
    "resilient_stroke_m",
    "peak_acceleration_m_s2",
    "secant_stiffness_N_m",
    "porosity_1",
    "porosity_2",
    "porosity_3",
    "coordination_number",
    "late_slope_m",
    "tracking_worst_Pa",
    "clumps",
)


def agreement_table(data: ReportData, profile: str, shown: Sequence[str] = AGREEMENT_SHOWN) -> Table | None:
    """The codes next to each other after the last cycle that all runs of a scenario share."""
    rows = data.agreement(profile)
    rows = rows[rows["quantity"].isin(shown)]
    if rows.empty:
        return None
    rows = rows[rows.groupby("scenario")["cycle"].transform("max") == rows["cycle"]]
    table = Table(
        "Agreement between the codes after the last cycle that all runs of a scenario have finished",
        [
            Column("scenario"),
            Column("quantity"),
            Column("cycle", True),
            Column("LIGGGHTS", True),
            Column("YADE", True),
            Column("difference", True),
            Column("ratio", True),
            Column("seeds", True),
            Column("verdict"),
        ],
    )
    for r in rows.itertuples():
        label, factor, _ = quantity_name(r.quantity, r.unit)
        verdict = {True: Chip("within seeds", "good"), False: Chip("beyond seeds", "bad")}.get(
            r.within_scatter, Chip("one seed each", "calm")
        )
        table.rows.append(
            [
                short_name(r.scenario),
                label,
                str(int(r.cycle)),
                number(r.liggghts_mean, 4, factor),
                number(r.yade_mean, 4, factor),
                number(r.difference if abs(r.difference) > 1e-9 * abs(r.yade_mean) else 0.0, 2, factor),
                number(r.ratio, 3),
                f"{int(r.liggghts_seeds)}, {int(r.yade_seeds)}",
                verdict,
            ]
        )
    table.note = (
        "Means over seeds; difference and ratio are LIGGGHTS against YADE. Within seeds: zero is within the 95 % "
        "confidence interval of the difference (Student's t, from the scatter between packing seeds; wide where seeds "
        "are few). With one seed in each code that scatter is unknown and a difference proves nothing. The nonlinear "
        "bed is soft: at the paper's shear modulus the Hertz contacts yield so much that the stroke is millimetres."
    )
    return table


def comparison(data: ReportData) -> dict:
    """Both codes next to each other."""
    sections = []
    for profile in data.profiles:
        g = data.gallery
        title, _ = PROFILE_TEXT.get(profile, (f"Profile {profile}", ""))
        few = overview_runs(data, profile)[0]
        parts = [
            {
                "heading": "After the same cycle",
                "table": agreement_table(data, profile),
                "missing": "It needs a run of the same scenario in both codes.",
            },
            {"heading": "Lateral displacement of the plates", "table": lateral_table(data, profile)},
            *same_bed_parts(data, profile),
            {"heading": "Packed beds and seeds", "table": seed_table(data, profile)},
            {
                "heading": "Does it shake down?",
                "text": "A bed that shakes down settles ever more slowly; one that ratchets settles by as much in each "
                "cycle; one that fails settles faster and faster, while its cribs heave and its plates give way.",
                "table": rates_table(data, profile),
            },
            {
                "heading": "Response within a cycle",
                "figure": stroke_figure(
                    g,
                    few,
                    f"strokes-{profile}",
                    "Stiffness and losses",
                    "Resilient stroke: settlement at maximum minus that at the next minimum load. Secant stiffness: "
                    "range of the "
                    "sleeper's load over that stroke. Work lost: area of the loop of load against settlement, with "
                    "its permanent part.",
                ),
            },
            {
                "figure": loop_figure(
                    g,
                    [run for run in few if run.seed == 1],
                    f"loops-{profile}",
                    "Stress against settlement",
                    "First (paler) and last cycle. The area of a loop is the work lost in the cycle; its extent along "
                    "the settlement axis is the resilient stroke.",
                )
            },
            {
                "heading": "Inside the bed",
                "figure": microstructure_figure(
                    g,
                    few,
                    f"micro-{profile}",
                    "Inside the bed",
                    "Contacts per clump, mean and largest overlap, share of sliding contacts, mean rotation since the "
                    "end of preload, heave of the cribs, shoulder bulge, and how far from rest the bed still is at "
                    "minimum load: kinetic energy per clump and net over contact force.",
                    [
                        ("coordination_number", "contacts per clump", 1, ""),
                        ("overlap_mean_m", "mean overlap, µm", 1e6, "µm"),
                        ("overlap_max_ratio", "largest overlap, % of radius", 100, "%"),
                        ("sliding_share", "sliding contacts, %", 100, "%"),
                        ("rotation_mean_rad", "mean rotation, degrees", 180 / np.pi, "°"),
                        ("crib_heave_m", "heave of the cribs, mm", MM, "mm"),
                        ("bulge_volume_m3", "shoulder bulge, cm³", 1e6, "cm³"),
                        ("kinetic_energy_J", "kinetic energy, mJ per clump", 1e3, "mJ"),
                        ("unbalanced_ratio", "unbalanced ratio", 1, ""),
                    ],
                ),
            },
            *quantity_parts(data, profile),
        ]
        sections.append(
            {
                "title": title,
                "text": "",
                "parts": [part for part in parts if part.get("table") or part.get("figure") or part.get("missing")],
            }
        )
    return {"sections": sections}


def lateral_table(data: ReportData, profile: str) -> Table | None:
    """How alike the lateral profiles of both codes are."""
    rows = codes.lateral_agreement(data.of(profile), PROFILE_CYCLES)
    table = Table(
        "Profiles over the five plates, LIGGGHTS against YADE",
        [
            Column("scenario"),
            Column("cycle", True),
            Column("rms difference, mm", True),
            Column("ratio of means", True),
            Column("correlation", True),
        ],
    )
    table.rows = [
        [short_name(r.scenario), str(r.cycle), number(r.rms_m, 3, MM), number(r.ratio, 3), number(r.correlation, 3)]
        for r in rows.itertuples()
    ]
    return table if table.rows else None


PREPARED = (  # heading, stage, name, factor to the unit of the heading
    ("clumps", "packing", "clumps", 1),
    ("mean porosity, packed", "packing", "porosity_mean", 1),
    ("contacts per clump, packed", "packing", "coordination_number", 1),
    ("mean overlap, packed, µm", "packing", "overlap_mean_m", 1e6),
    ("largest overlap, packed, % of radius", "packing", "overlap_max_ratio", 100),
    ("porosity 1, preloaded", "preload", "porosity_1", 1),
    ("porosity 2, preloaded", "preload", "porosity_2", 1),
    ("porosity 3, preloaded", "preload", "porosity_3", 1),
    ("contacts per clump, preloaded", "preload", "coordination_number", 1),
    ("preload settlement, mm", "preload", "settlement_m", MM),
)


def seed_table(data: ReportData, profile: str) -> Table | None:
    """Packed and preloaded beds of all runs, and their spread where a code has several seeds."""
    runs = [run for run in data.runs if run.profile == profile and run.stages]
    if not runs:
        return None
    table = Table("Packed and preloaded beds", [Column("run"), *(Column(heading, True) for heading, *_ in PREPARED)])
    groups: dict[tuple, list[list[float]]] = {}
    for run in runs:
        values = [factor * run.stages.get(stage, {}).get(name, np.nan) for _, stage, name, factor in PREPARED]
        table.rows.append([name_of(run), *(number(value, 4) for value in values)])
        groups.setdefault((run.scenario_name, run.code), []).append(values)
    for (scenario, code), values in groups.items():
        if len(values) > 1:
            mean, spread = np.mean(values, axis=0), np.std(values, axis=0, ddof=1)
            table.rows.append(
                [
                    f"{short_name(scenario)}, {CODE_NAMES.get(code, code)}: mean ± standard deviation of "
                    f"{len(values)} seeds",
                    *(f"{number(m, 4)} ± {number(d, 2)}" for m, d in zip(mean, spread, strict=True)),
                ]
            )
    table.note = (
        "The paper reports 4583 clumps (4429 in its nonlinear model) and a porosity of about 0.35 under the sleeper. "
        "Scenarios whose bed another scenario packed show that bed."
    )
    return table


TREND_KIND = {"slowing": "good", "steady": "open", "growing": "bad"}


def rates_table(data: ReportData, profile: str) -> Table | None:
    """How fast each run settles, span by span of cycles, and how fast plates and cribs go with it in the last span."""
    runs = [run for run in (*data.of(profile), *data.variants) if run.profile == profile and len(run.cycles)]
    found = {run.id: quantities.settling_rates(run) for run in runs}
    ends = [b for b in quantities.RATE_EDGES if any(b in set(rates["last_cycle"]) for rates in found.values())]
    if len(ends) < 3:
        return None
    starts = quantities.RATE_EDGES
    table = Table(
        "Settlement at minimum load per cycle, µm, in spans of cycles",
        [
            Column("run"),
            *(Column(f"{starts[starts.index(b) - 1]} to {b}", True) for b in ends),
            Column("last span", True),
            Column("settling", True),
            Column("plates", True),
            Column("heave of cribs", True),
            Column("peak acceleration, g", True),
            Column("trend"),
        ],
    )
    for run in runs:
        rates, trend = found[run.id], quantities.settling_trend(run)
        if rates.empty:
            continue
        by_end, last = rates.set_index("last_cycle")["settlement_rate_m"], rates.iloc[-1]
        table.rows.append(
            [
                name_of(run),
                *(number(by_end.get(b, np.nan), 3, 1e6) for b in ends),
                f"{last['first_cycle']:.0f} to {last['last_cycle']:.0f}",
                *(number(last[f"{what}_rate_m"], 3, 1e6) for what in ("settlement", "lateral", "crib_heave")),
                number(quantities.per_cycle(run)["peak_acceleration_m_s2"].iloc[-1], 2, 1 / GRAVITY),
                Chip(trend or "too short", TREND_KIND.get(trend, "calm")),
            ]
        )
    table.note = (
        "Plates: mean of the five, outward. Heave: mean of the clumps that began beside the sleeper. The trend "
        "compares the last span with the one before: below 0.8 of its rate is slowing (a logarithm has 0.4 to 0.5), "
        "above 1.25 growing. Peak acceleration: half the resilient stroke times (2π f)², in the last cycle; above 1 g "
        "the cribs are thrown."
    )
    return table


def same_bed_groups(data: ReportData, profile: str) -> dict[tuple[str, str], list[same_bed.Pair]]:
    """Pairs of runs from one bed, by the scenario they stand for and the checksum of the bed."""
    runs = [run for run in (*data.of(profile), *data.variants) if run.profile == profile]
    groups: dict[tuple[str, str], list[same_bed.Pair]] = {}
    for pair in same_bed.same_bed_pairs(runs):
        key = (basis_of(pair.one.scenario_name), pair.one.stages["packing"]["bed_sha256"])
        groups.setdefault(key, []).append(pair)
    return groups


def same_bed_parts(data: ReportData, profile: str) -> list[dict]:
    """Runs from one bed that differ in one thing alone (code, time step, ranks), side by side: one part per bed and
    contact model.
    """
    parts = [
        {
            "table": same_bed_table(found, short_name(basis)),
            "figure": same_bed_figure(data.gallery, found, f"same-bed-{profile}-{bed[:6]}-{basis}", short_name(basis)),
        }
        for (basis, bed), found in same_bed_groups(data, profile).items()
    ]
    missing = {
        "missing": "It needs a scenario in LIGGGHTS, plain and with VARIANT=half-step, and in YADE with "
        "VARIANT=same-bed (and in LIGGGHTS with NP=2 for the rounding), or any runs of one scenario from one bed "
        "(BED=…)."
    }
    parts = parts or [missing]
    parts[0] |= {
        "heading": "The same bed: two codes, two time steps, and rounding alone",
        "text": "Both codes, or one code with two time steps or two numbers of ranks, from the very same packed bed. "
        "What the codes differ by is to be read against what a smaller time step changes, and that against what "
        "another order of sums alone changes: a packed bed is chaotic, and no two runs can agree more closely.",
    }
    return parts


def pair_names(pair: same_bed.Pair) -> tuple[str, str]:
    """What tells the two runs of a pair apart: their codes, time steps or ranks."""
    what = {
        "code": lambda run: "",
        "time.step": lambda run: f" {shown(1e6 * run.scenario['time.step'])} µs",
        "ranks": lambda run: f" {plural(same_bed.ranks(run), 'rank')}",
    }[pair.differs]
    return tuple(CODE_NAMES.get(run.code, run.code) + what(run) for run in (pair.one, pair.other))


def same_bed_table(found: Sequence[same_bed.Pair], title: str) -> Table:
    """Settlement of pairs from one bed, a row per cycle, the pairs beside each other."""
    table = Table(f"Settlement from the same bed, mm: {title}", [Column("settlement")])
    by_cycle: dict[int, dict[int, list[str]]] = {}
    for n, pair in enumerate(found):
        table.columns += [*(Column(name, True) for name in pair_names(pair)), Column("difference, %", True)]
        for row in same_bed.settlements(pair).itertuples():
            by_cycle.setdefault(row.cycle, {})[n] = [
                number(row.one_m, 3, MM),
                number(row.other_m, 3, MM),
                number(row.difference_ratio, 2, 100),
            ]
    for cycle, cells in sorted(by_cycle.items()):
        name = f"after {plural(cycle, 'cycle')}" if cycle else "in preload"
        table.rows.append([name, *(text for n in range(len(found)) for text in cells.get(n, ["–"] * 3))])
    table.note = "Runs: " + "; ".join(f"{pair.one.id} and {pair.other.id}" for pair in found) + "."
    return table


def quantity_parts(data: ReportData, profile: str) -> list[dict]:
    """Every quantity of every run after its last cycle, or the reason why it is missing: one table per scenario."""
    parts, runs = [], data.of(profile)
    for scenario in dict.fromkeys(run.scenario_name for run in runs):
        members = [run for run in runs if run.scenario_name == scenario]
        found = {run.id: last_values(quantities.summary(run)) for run in members}
        table = Table(
            f"All quantities after the last cycle of each run, {short_name(scenario)}",
            [
                Column("quantity"),
                *(Column(f"{code_of(run)}, cycle {last_cycle(run)}", True) for run in members),
            ],
        )
        reasons: dict[str, list[str]] = {}
        for name in dict.fromkeys(name for values in found.values() for name in values.index):
            cells, unit = [], next(values.at[name, "unit"] for values in found.values() if name in values.index)
            label, factor, _ = quantity_name(name, unit)
            for run in members:
                r = found[run.id].loc[name] if name in found[run.id].index else None
                cells.append("–" if r is None else number(r["value"], 4, factor))
                if r is not None and r["missing"]:
                    reasons.setdefault(
                        f"{r['missing']} ({code_of(run)})",
                        [],
                    ).append(label)
            table.rows.append([label, *cells])
        table.note = "".join(f"Missing because {why}: {'; '.join(labels)}. " for why, labels in reasons.items())
        parts.append({"heading": f"All quantities: {short_name(scenario)}", "table": table, "fold": True})
    return parts


def last_values(summary: pd.DataFrame) -> pd.DataFrame:
    """The rows of a run's last cycle, by quantity."""
    rows = summary.sort_values("cycle", kind="stable")
    there = rows[rows["missing"] == ""]
    last = there["cycle"].max() if len(there) else 0
    return rows[rows["cycle"] == last].drop_duplicates("quantity", keep="last").set_index("quantity")
