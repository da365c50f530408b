"""The benchmark: ours against the commit before it was made fast, and against stock."""

from __future__ import annotations

import pandas as pd

from analysis.report.figures.benchmark import sizes_figure
from analysis.report.report_data import ReportData
from analysis.report.style import CODE_NAMES
from analysis.report.tables import Column, Table, number

CASES = {
    "ours_paper_step": "ours, the paper's step",
    "ours_verified_step": "ours, the study's step",
    "over_stock": "ours over stock, the paper's step",
}


def benchmark_page(data: ReportData) -> dict | None:
    """What `make bench PROFILE=full` measured; None without its table."""
    table, sizes = data.findings.benchmark, data.findings.benchmark_sizes
    if table.empty:
        return None
    return {
        "speeds": speeds_table(table),
        "sizes": sizes_table(sizes) if len(sizes) else None,
        "figure_": sizes_figure(data.gallery, sizes),
        "profile": profile_table(data.findings.benchmark_profile) if len(data.findings.benchmark_profile) else None,
    }


def speeds_table(table: pd.DataFrame) -> Table:
    """benchmark.csv, one row per code and law."""
    made = Table(
        "Steps per second of processor time, and ratios",
        [
            Column("code"),
            Column("law"),
            Column("paper's step, steps/s", True),
            Column("study's step, steps/s", True),
            Column("stock, steps/s", True),
            Column("cycles over baseline, paper's step", True),
            Column("cycles over baseline, study's step", True),
            Column("steps over stock", True),
        ],
    )
    for (code, law), rows in table.groupby(["code", "law"], sort=False):
        of = rows.set_index("case")

        def cell(case: str, name: str, of=of) -> str:
            return number(of.at[case, name], 3) if case in of.index else "–"

        stock = of.loc["over_stock"] if "over_stock" in of.index else None
        made.rows.append(
            [
                CODE_NAMES[code],
                law,
                cell("over_stock", "steps_per_cpu_s"),
                cell("ours_verified_step", "steps_per_cpu_s"),
                number(stock["steps_per_cpu_s"] / stock["ratio"], 3) if stock is not None else "–",
                cell("ours_paper_step", "ratio"),
                cell("ours_verified_step", "ratio"),
                cell("over_stock", "ratio"),
            ]
        )
    made.note = (
        "Baseline: commit 5f44678 with the paper's step. Its speed was recorded beside the stock deck's or script's on "
        "one machine, which carries it to others. Processor time counts, because machines are shared; what shares the "
        "caches still slows everything."
    )
    return made


def sizes_table(sizes: pd.DataFrame) -> Table:
    """benchmark_sizes.csv."""
    made = Table(
        "Other sizes and ranks, the paper's step",
        [
            Column("code"),
            Column("law"),
            Column("clumps", True),
            Column("ranks or threads", True),
            Column("steps per second of processor time", True),
            Column("by the clock", True),
        ],
    )
    for r in sizes.itertuples():
        speeds = number(r.steps_per_cpu_s, 3), number(r.steps_per_wall_s, 3)
        made.rows.append([CODE_NAMES[r.code], r.law, str(int(r.clumps)), str(int(r.ranks)), *speeds])
    return made


def profile_table(profile: pd.DataFrame) -> Table:
    """benchmark_profile.csv."""
    made = Table("Where the time goes", [Column("code"), Column("law"), Column("part"), Column("share, %", True)])
    for r in profile.itertuples():
        made.rows.append([CODE_NAMES[r.code], r.law, r.part, number(r.share, 2, 100)])
    made.note = "Sampled with Linux perf on the full bed in cyclic loading."
    return made
