"""The page that sets both codes next to each other."""

from __future__ import annotations

from analysis.comparison import codes, same_bed
from analysis.comparison.findings.members import SERVO, SERVO_VARIANT, TRUE_LOAD, member
from analysis.formats.quantities import COMPARED
from analysis.report.answer import engineer, only, states
from analysis.report.figures.agreement import scatter_figure
from analysis.report.figures.lateral import PROFILE_CYCLES
from analysis.report.figures.load import loop_figure, stroke_figure
from analysis.report.figures.microstructure import microstructure_figure
from analysis.report.figures.same_bed import same_bed_figure
from analysis.report.labels import short_name, time_steps
from analysis.report.report_data import KEY_SCENARIOS, ReportData, key_runs
from analysis.report.sentences import lines
from analysis.report.tables import agreement, settling
from analysis.report.tables.stock import stock_table
from analysis.scenarios.scenario import join_id, split_id


def comparison(data: ReportData) -> dict:
    """Both codes next to each other, on the full bed where it has runs."""
    profile = data.profiles[0] if data.profiles else "full"
    g, found, few = data.gallery, data.findings, key_runs(data, profile)
    agreed, plain = only(found.agreement, profile=profile), {m.run.id for m in found.members if m.plain}
    rates = only(found.rates, profile=profile, seed=1)
    rates = rates[rates["run"].isin(plain)]
    return {
        "profile": profile,
        "states": states(agreed),
        "scatter": scatter_figure(g, agreed, "agreement-all"),
        "time_steps": time_steps(run for run in few if member(run).reading == TRUE_LOAD),
        "agreement": agreement.agreement_table(agreed),
        "every_agreement": agreement.agreement_table(agreed, COMPARED, all_cycles=True),
        "lateral": agreement.lateral_table(codes.lateral_agreement(data.of(profile), PROFILE_CYCLES)),
        "same_bed": agreement.same_bed_table(only(found.same_bed_verdicts, profile=profile)),
        "same_bed_parts": same_bed_parts(data, profile),
        "stock": stock_table(only(found.stock, profile=profile)),
        "beds": settling.beds_table(run for run in data.runs if run.profile == profile),
        "rates": settling.rates_table(rates[rates["scenario"].isin(KEY_SCENARIOS)]),
        "every_rate": settling.rates_table(rates),
        "strokes": stroke_figure(g, few, f"strokes-{profile}"),
        "loops": loop_figure(g, [run for run in few if run.seed == 1], f"loops-{profile}"),
        "micro": microstructure_figure(g, few, f"micro-{profile}"),
        "engineer": lines("engineer.txt", **engineer(found, KEY_SCENARIOS, profile)),
        "cost": settling.cost_table(only(found.computing_time, profile=profile)),
    }


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
            "table": agreement.pairs_table(found, short_name(basis)),
            "figure": same_bed_figure(data.gallery, found, f"same-bed-{profile}-{bed[:6]}-{basis}", short_name(basis)),
        }
        for (basis, bed), found in same_bed_groups(data, profile).items()
        if split_id(basis)[0] in KEY_SCENARIOS
    ]
