"""The page that sets both codes next to each other."""

from __future__ import annotations

from analysis.comparison import codes
from analysis.comparison.findings.members import TRUE_LOAD, member
from analysis.formats.quantities import COMPARED
from analysis.report.answer import engineer, only, states
from analysis.report.figures.agreement_figures import scatter_figure
from analysis.report.figures.lateral_figures import PROFILE_CYCLES
from analysis.report.figures.load_figures import loop_figure, stroke_figure
from analysis.report.figures.microstructure_figures import microstructure_figure
from analysis.report.labels import time_steps
from analysis.report.report_data import KEY_SCENARIOS, ReportData, key_runs
from analysis.report.sections import same_bed_parts
from analysis.report.sentences import lines
from analysis.report.tables import agreement_tables, settling_tables
from analysis.report.tables.stock_tables import stock_table


def comparison(data: ReportData) -> dict:
    """Both codes next to each other, on the full bed where it has runs."""
    profile = data.profiles[0] if data.profiles else "full"
    g, found, few = data.gallery, data.findings, key_runs(data, profile)
    agreed, plain = only(found.agreement, profile=profile), {m.run.id for m in found.members if m.plain}
    rates, beds = only(found.rates, profile=profile, seed=1), only(found.packed_beds, profile=profile)
    rates = rates[rates["run"].isin(plain)]
    return {
        "profile": profile,
        "states": states(agreed),
        "scatter": scatter_figure(g, agreed, "agreement-all"),
        "time_steps": time_steps(run for run in few if member(run).reading == TRUE_LOAD),
        "agreement": agreement_tables.agreement_table(agreed),
        "every_agreement": agreement_tables.agreement_table(agreed, COMPARED, all_cycles=True),
        "lateral": agreement_tables.lateral_table(codes.lateral_agreement(data.of(profile), PROFILE_CYCLES)),
        "same_bed": agreement_tables.same_bed_table(only(found.same_bed_verdicts, profile=profile)),
        "same_bed_parts": same_bed_parts(data, profile),
        "stock": stock_table(only(found.stock, profile=profile)),
        "every_stock": stock_table(only(found.stock, profile=profile), all_rows=True),
        "beds": settling_tables.beds_table(beds[beds["run"].isin(plain)]),
        "rates": settling_tables.rates_table(rates[rates["scenario"].isin(KEY_SCENARIOS)]),
        "every_rate": settling_tables.rates_table(rates),
        "strokes": stroke_figure(g, few, f"strokes-{profile}"),
        "loops": loop_figure(g, [run for run in few if run.seed == 1], f"loops-{profile}"),
        "micro": microstructure_figure(g, few, f"micro-{profile}"),
        "engineer": lines("engineer.txt", **engineer(found, KEY_SCENARIOS, profile)),
        "cost": settling_tables.cost_table(only(found.computing_time, profile=profile)),
    }
