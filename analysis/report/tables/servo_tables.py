"""PFC's servo: what it made of the load, and what of the settlement is elastic."""

from __future__ import annotations

import pandas as pd

from analysis.report.labels import KPA, short_name
from analysis.report.paper import paper
from analysis.report.style import CODE_NAMES
from analysis.report.tables.table_html import Shown, Table, between, frame_table, number


def servo_table(table: pd.DataFrame) -> Table | None:
    """Every run by the servo: what it did, and what the filter says it had to do."""
    return frame_table(
        table,
        "PFC's servo: measured over the last five cycles, and predicted",
        [
            Shown("run", "run", text=name_with_bed, number=False),
            Shown("gain", digits=2),
            Shown("cycle", "cycles"),
            between("stress_min_Pa", "stress_max_Pa", "stress"),
            Shown("bed_stiffness_N_m", digits=2),
            Shown("bed_loss_angle_rad", digits=2),
            "contacts",
            "time_constant_s",
            "amplitude_ratio",
            "predicted_amplitude_ratio",
            "lag_rad",
            "predicted_lag_rad",
            "forecast_amplitude_ratio",
            "forecast_lag_rad",
        ],
    )


def name_with_bed(row) -> str:
    """Scenario with its variants, code and packed bed of a row."""
    identity = "+".join(filter(None, (row.scenario, row.variant)))
    return f"{short_name(identity)}, {CODE_NAMES[row.code]}, bed {row.seed}"


def elastic_table(table: pd.DataFrame) -> Table | None:
    """Settlement by the servo split into what springs back at the least load and what stays."""
    return frame_table(
        table,
        "Settlement by the servo: what springs back when the load falls to "
        f"{number(paper().stress_min_Pa, 3, KPA)} kPa, and what stays",
        [
            "scenario",
            "code",
            Shown("seed", "packed bed"),
            "cycle",
            "stress_before_Pa",
            "settlement_m",
            "elastic_m",
            "permanent_m",
        ],
    )
