"""The page that sets both codes next to each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.comparison import codes, quantities, same_bed
from analysis.comparison.findings.agreement import COMPARED
from analysis.comparison.findings.members import SERVO, SERVO_VARIANT, TRUE_LOAD, member
from analysis.formats.numbers import plural
from analysis.report.agreement_tables import agreement_table, same_bed_table
from analysis.report.answer import engineer, only, states
from analysis.report.figures.agreement import scatter_figure
from analysis.report.figures.lateral import PROFILE_CYCLES
from analysis.report.figures.load import loop_figure, stroke_figure
from analysis.report.figures.microstructure import microstructure_figure
from analysis.report.figures.same_bed import same_bed_figure
from analysis.report.labels import MM, READING_NAMES, short_name, time_steps
from analysis.report.paper import paper
from analysis.report.report_data import KEY_SCENARIOS, ReportData, key_runs, name_of
from analysis.report.sentences import lines
from analysis.report.stock_table import stock_table
from analysis.report.style import CODE_NAMES
from analysis.report.tables import Chip, Column, Table, number, shown
from analysis.scenarios.scenario import join_id, split_id


def comparison(data: ReportData) -> dict:
    """Both codes next to each other, on the full bed where it has runs."""
    profile = data.profiles[0] if data.profiles else "full"
    g, found, few = data.gallery, data.findings, key_runs(data, profile)
    agreement = only(found.agreement, profile=profile)
    return {
        "profile": profile,
        "states": states(agreement),
        "scatter": scatter_figure(g, agreement, "agreement-all"),
        "time_steps": time_steps(run for run in few if member(run).reading == TRUE_LOAD),
        "agreement": agreement_table(agreement),
        "every_agreement": agreement_table(agreement, COMPARED, all_cycles=True),
        "lateral": lateral_table(data, profile),
        "same_bed": same_bed_table(only(found.same_bed_verdicts, profile=profile)),
        "same_bed_parts": same_bed_parts(data, profile),
        "stock": stock_table(only(found.stock, profile=profile)),
        "beds": seed_table(data, profile),
        "rates": rates_table(data, profile),
        "strokes": stroke_figure(
            g,
            few,
            f"strokes-{profile}",
            "Stiffness and losses",
            "Resilient stroke: settlement at maximum minus that at the next minimum load. Secant stiffness: range "
            "of the "
            "sleeper's load over that stroke. Work lost: area of the loop of load against settlement, with its "
            "permanent part.",
        ),
        "loops": loop_figure(
            g,
            [run for run in few if run.seed == 1],
            f"loops-{profile}",
            "Stress against settlement",
            "First (paler) and last cycle. The area of a loop is the work lost in the cycle; its extent along the "
            "settlement axis is the resilient stroke.",
        ),
        "micro": microstructure_figure(
            g,
            few,
            f"micro-{profile}",
            "Inside the bed",
            "Kinetic energy and unbalanced ratio say how far from rest the bed still is at minimum load.",
            MICROSTRUCTURE,
        ),
        "engineer": lines("engineer.txt", **engineer(found, KEY_SCENARIOS, profile)),
        "cost": cost_table(only(found.computing_time, profile=profile)),
    }


MICROSTRUCTURE = [
    ("coordination_number", "contacts per clump", 1, ""),
    ("overlap_mean_m", "mean overlap, µm", 1e6, "µm"),
    ("overlap_max_ratio", "largest overlap, % of radius", 100, "%"),
    ("sliding_share", "sliding contacts, %", 100, "%"),
    ("rotation_mean_rad", "mean rotation, degrees", 180 / np.pi, "°"),
    ("crib_heave_m", "heave of the cribs, mm", MM, "mm"),
    ("bulge_volume_m3", "shoulder bulge, cm³", 1e6, "cm³"),
    ("kinetic_energy_J", "kinetic energy, mJ per clump", 1e3, "mJ"),
    ("unbalanced_ratio", "unbalanced ratio", 1, ""),
]


def cost_table(rows: pd.DataFrame) -> Table | None:
    """Cost of cyclic loading by scenario, reading and code, of the fastest run: other work can only slow one."""
    rows = rows[rows["variant"].isin(["", "servo"])]
    if rows.empty:
        return None
    table = Table(
        "Computing time of cyclic loading on one core, of the fastest run",
        [
            Column("scenario"),
            Column("load"),
            Column("code"),
            Column("time step, µs", True),
            Column("steps per cycle", True),
            Column("steps per second", True),
            Column("seconds per cycle", True),
            Column("hours for 1000 cycles", True),
        ],
    )
    names = ["step_s", "steps_per_cycle", "steps_per_s", "seconds_per_cycle", "hours_per_1000_cycles"]
    best = rows.sort_values("seconds_per_cycle").groupby(["scenario", "reading", "code", "step_s"], sort=True)
    for r in best[names[1:]].first().reset_index().itertuples():
        table.rows.append(
            [
                short_name(r.scenario),
                READING_NAMES[r.reading],
                CODE_NAMES[r.code],
                number(r.step_s, 3, 1e6),
                number(r.steps_per_cycle, 5),
                number(r.steps_per_s, 3),
                number(r.seconds_per_cycle, 3),
                number(r.hours_per_1000_cycles, 3),
            ]
        )
    table.note = "Timed on shared machines while other work ran, which can only slow a run: good to tens of percent."
    return table


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
    said = paper().reported
    table.note = (
        f"The paper reports {said.clumps} clumps ({said.clumps_nonlinear} in its nonlinear model) and a porosity of "
        f"about {said.porosity} under the sleeper. Scenarios whose bed another scenario packed show that bed."
    )
    return table


TREND_KIND = {"slowing": "good", "steady": "open", "growing": "bad"}


def rates_table(data: ReportData, profile: str) -> Table | None:
    """How fast scenarios settle, span by span of cycles, and how fast plates and cribs go with it in the last span; the
    trend also at the last span that every code has, so that codes are compared at equal cycles.
    """
    rates = only(data.findings.rates, profile=profile, seed=1)
    plain = {m.run.id for m in data.findings.members if m.plain}
    rates = rates[rates["run"].isin(plain)]
    ends = [b for b in quantities.RATE_EDGES[1:] if b in set(rates["last_cycle"])]
    if len(ends) < 3:
        return None
    starts = dict(zip(quantities.RATE_EDGES[1:], quantities.RATE_EDGES, strict=False))
    shared = rates.groupby(["scenario", "reading", "run"])["last_cycle"].max().groupby(["scenario", "reading"]).min()
    table = Table(
        "Settlement at minimum load per cycle, µm, in spans of cycles; first packed bed of each code",
        [
            Column("scenario"),
            Column("load"),
            Column("code"),
            *(Column(f"{starts[b]} to {b}", True) for b in ends),
            Column("plates", True),
            Column("heave of cribs", True),
            Column("trend"),
            Column("at equal cycles"),
        ],
    )
    for (scenario, reading, code), spans in rates.groupby(["scenario", "reading", "code"], sort=False):
        by_end, last = spans.set_index("last_cycle"), spans.iloc[-1]
        common = shared[scenario, reading]
        equal = by_end["trend"].get(common, "")
        table.rows.append(
            [
                short_name(scenario),
                READING_NAMES[reading],
                CODE_NAMES.get(code, code),
                *(number(by_end["settlement_rate_m"].get(b, np.nan), 3, 1e6) for b in ends),
                *(number(last[f"{what}_rate_m"], 3, 1e6) for what in ("lateral", "crib_heave")),
                Chip(f"{last['trend']} to {last['last_cycle']:.0f}", TREND_KIND[last["trend"]])
                if last["trend"]
                else Chip("too short", "calm"),
                f"{equal or 'too short'} to {common:.0f}",
            ]
        )
    table.note = (
        "Plates (mean of five, outward) and heave of the cribs: in the last span. The trend compares a span with "
        "the one before: below 0.8 of its rate is slowing (a logarithm has 0.4 to "
        "0.5), above 1.25 growing. At equal cycles: the trend up to the last span that every code of the scenario has."
    )
    return table


def same_bed_groups(data: ReportData, profile: str) -> dict[tuple[str, str], list[same_bed.Pair]]:
    """Pairs of runs from one bed, by the scenario and reading they stand for and the checksum of the bed."""
    runs = [run for run in (*data.of(profile), *data.variants) if run.profile == profile]
    groups: dict[tuple[str, str], list[same_bed.Pair]] = {}
    for pair in same_bed.same_bed_pairs(runs):
        reading = (SERVO_VARIANT,) if member(pair.one).reading == SERVO else ()
        key = (join_id(pair.one.base_name, reading), pair.one.stages["packing"]["bed_sha256"])
        groups.setdefault(key, []).append(pair)
    return groups


def same_bed_parts(data: ReportData, profile: str) -> list[dict]:
    """Figures and tables of runs from one bed that differ in one thing alone; the key scenarios only."""
    return [
        {
            "name": short_name(basis),
            "table": pairs_table(found, short_name(basis)),
            "figure": same_bed_figure(data.gallery, found, f"same-bed-{profile}-{bed[:6]}-{basis}", short_name(basis)),
        }
        for (basis, bed), found in same_bed_groups(data, profile).items()
        if split_id(basis)[0] in KEY_SCENARIOS
    ]


def pair_names(pair: same_bed.Pair) -> tuple[str, str]:
    """What tells the two runs of a pair apart: their codes, time steps or ranks."""
    what = {
        "code": lambda run: "",
        "time.step": lambda run: f" {shown(1e6 * run.scenario['time.step'])} µs",
        "ranks": lambda run: f" {plural(same_bed.ranks(run), 'rank')}",
    }[pair.differs]
    return tuple(CODE_NAMES.get(run.code, run.code) + what(run) for run in (pair.one, pair.other))


def pairs_table(found: Sequence[same_bed.Pair], title: str) -> Table:
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
