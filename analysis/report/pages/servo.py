"""PFC's servo explained: a first-order filter, predicted and measured, and what it leaves of the settlement."""

from __future__ import annotations

import math

import pandas as pd

from analysis.report.figures.servo import filter_figure, stress_range_figure
from analysis.report.labels import KPA, MM, READING_NAMES, short_name
from analysis.report.paper import paper
from analysis.report.report_data import KEY_SCENARIOS, ReportData
from analysis.report.style import CODE_NAMES
from analysis.report.tables import Column, Table, number


def servo_page(data: ReportData) -> dict | None:
    """What the servo makes of the load; None without a run by it."""
    table = data.findings.servo
    if table.empty:
        return None
    key = table[(table["scenario"] == (KEY_SCENARIOS or ("",))[-1]) & (table["variant"] == "servo")]
    return {
        "key": key.iloc[0].to_dict() if len(key) else {},
        "filter": filter_figure(data.gallery, table),
        "range": stress_range_figure(data.gallery, table),
        "runs": servo_table(table),
        "elastic": elastic_table(data.findings.elastic),
    }


def servo_table(table: pd.DataFrame) -> Table:
    """Every run by the servo: what it did, and what the filter says it had to do."""
    made = Table(
        "PFC's servo: measured over the last five cycles, and predicted",
        [
            Column("run"),
            Column("gain", True),
            Column("cycles", True),
            Column("stress, kPa", True),
            Column("bed, kN/mm", True),
            Column("loss angle, °", True),
            Column("contacts", True),
            Column("time constant, ms", True),
            Column("amplitude, %", True),
            Column("predicted, %", True),
            Column("lag, °", True),
            Column("predicted, °", True),
        ],
    )
    degrees = 180 / math.pi
    for r in table.itertuples():
        identity = "+".join(filter(None, (r.scenario, r.variant)))
        made.rows.append(
            [
                f"{short_name(identity)}, {CODE_NAMES[r.code]}, bed {r.seed}",
                number(r.gain, 2),
                str(r.cycle),
                f"{number(r.stress_min_Pa, 3, KPA)} to {number(r.stress_max_Pa, 3, KPA)}",
                number(r.bed_stiffness_N_m, 2, 1e-6),
                number(r.bed_loss_angle_rad, 2, degrees),
                number(r.contacts, 3),
                number(r.time_constant_s, 3, 1e3),
                number(r.amplitude_ratio, 3, 100),
                number(r.predicted_amplitude_ratio, 3, 100),
                number(r.lag_rad, 3, degrees),
                number(r.predicted_lag_rad, 3, degrees),
            ]
        )
    made.note = (
        "Stress: least and largest. Bed: dynamic stiffness and loss angle, from the first harmonics of stress and "
        "settlement. Contacts: spheres that touch the sleeper at its least load, counted. Time constant and "
        "predictions follow from these and from the gain; nothing is fitted. On the linear bed more spheres touch at "
        "the greatest load than at the least, so that it is followed a little less well than predicted."
    )
    return made


def elastic_table(table: pd.DataFrame) -> Table | None:
    """Settlement by the servo split into what springs back at the least load and what stays."""
    if table.empty:
        return None
    least = number(paper().stress_min_Pa, 3, KPA)
    made = Table(
        f"Settlement by the servo: what springs back when the load falls to {least} kPa, and what stays",
        [
            Column("run"),
            Column("load"),
            Column("cycle", True),
            Column("stress, kPa", True),
            Column("settlement, mm", True),
            Column("elastic, mm", True),
            Column("permanent, mm", True),
        ],
    )
    for r in table.itertuples():
        made.rows.append(
            [
                f"{short_name(r.scenario)}, {CODE_NAMES.get(r.code, r.code)}",
                READING_NAMES[r.reading],
                str(r.cycle),
                number(r.stress_before_Pa, 3, KPA),
                number(r.settlement_m, 3, MM),
                number(r.elastic_m, 3, MM),
                number(r.permanent_m, 3, MM),
            ]
        )
    made.note = (
        "Measured with `make unload`: a copy of the run was unloaded slowly from the stress at the end of the cycle to "
        f"{least} kPa, with local damping. Elastic is what came back, permanent what stayed."
    )
    return made
