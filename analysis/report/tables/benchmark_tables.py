"""Speeds: ours, the baseline's and stock's, over sizes and ranks, and where the time goes."""

from __future__ import annotations

import math

import pandas as pd

from analysis.report.tables.table_html import Shown, Table, frame_table


def speeds_table(table: pd.DataFrame) -> Table | None:
    """benchmark.csv, one row per code and law."""
    columns = ["code", "law", "case"]
    if table.empty:
        return None
    wide = table.set_index(columns)[["steps_per_cpu_s", "ratio"]].unstack("case", sort=False)
    wide.columns = [f"{case}_{name}" for name, case in wide]
    for case in ("over_stock", "ours_verified_step", "ours_paper_step"):
        wide = wide.assign(
            **{name: math.nan for name in (f"{case}_steps_per_cpu_s", f"{case}_ratio") if name not in wide}
        )
    wide["stock_steps_per_cpu_s"] = wide["over_stock_steps_per_cpu_s"] / wide["over_stock_ratio"]
    return frame_table(
        wide.reset_index(),
        "Steps per second of processor time, and ratios",
        [
            "code",
            "law",
            Shown("over_stock_steps_per_cpu_s", "paper's step, steps/s", like="steps_per_cpu_s"),
            Shown("ours_verified_step_steps_per_cpu_s", "study's step, steps/s", like="steps_per_cpu_s"),
            Shown("stock_steps_per_cpu_s", "stock, steps/s", like="steps_per_cpu_s"),
            Shown("ours_paper_step_ratio", "cycles over baseline, paper's step", like="ratio"),
            Shown("ours_verified_step_ratio", "cycles over baseline, study's step", like="ratio"),
            Shown("over_stock_ratio", "steps over stock", like="ratio"),
        ],
    )


def sizes_table(sizes: pd.DataFrame) -> Table | None:
    """benchmark_sizes.csv."""
    return frame_table(
        sizes,
        "Other sizes and ranks, the paper's step",
        ["code", "law", "clumps", "ranks", "steps_per_cpu_s", "steps_per_wall_s"],
    )


def profile_table(profile: pd.DataFrame) -> Table | None:
    """benchmark_profile.csv."""
    return frame_table(profile, "Where the time goes", ["code", "law", "part", Shown("share", digits=2)])
