"""How large the time step may be: runs from one bed at several, beside packing seeds and rounding."""

from __future__ import annotations

import pandas as pd

from analysis.report.figures.timestep import timestep_figure
from analysis.report.labels import MM, short_name
from analysis.report.report_data import ReportData
from analysis.report.tables import Chip, Column, Table, number

CASES = {
    "paper": "the paper's step",
    "verified": "the study's step",
    "half": "half the paper's",
    "rounding": "two ranks",
}


def timestep_page(data: ReportData) -> dict | None:
    """What `make timestep` found; None without its table."""
    table = data.findings.timestep
    if table.empty:
        return None
    done = table[(table["state"] == "done") & (table["cycle"] == table["cycle"].max())]
    return {
        "shares": shares_table(table),
        "done": len(done),
        "wanted": len(table[["scenario", "case"]].drop_duplicates()),
        "figure_": timestep_figure(data.gallery, table),
        "table_": runs_table(table),
    }


def case_name(case: str) -> str:
    """A case of timestep.csv in words."""
    return CASES.get(case, f"{case} of critical" if case[0].isdigit() else case)


def shares_table(table: pd.DataFrame) -> Table:
    """Critical step of each scenario's preloaded bed, and what share of it the steps are that runs take."""
    made = Table(
        "The critical step, measured on the preloaded bed",
        [
            Column("scenario"),
            Column("critical step, µs", True),
            Column("the paper's, µs", True),
            Column("share", True),
            Column("the study's, µs", True),
            Column("share", True),
        ],
    )
    for scenario, rows in table.groupby("scenario", sort=False):
        cells = [short_name(scenario), number(rows["critical_step_s"].iloc[0], 3, 1e6)]
        for case in ("paper", "verified"):
            found = rows[rows["case"] == case]
            cells += [number(found[name].iloc[0], 3, f) if len(found) else "–" for name, f in STEP]
        made.rows.append(cells)
    return made


STEP = (("time_step_s", 1e6), ("step_share", 1))


def runs_table(table: pd.DataFrame) -> Table:
    """Every run of the comparison after its last shown cycle."""
    made = Table(
        "All runs, after 20 cycles or as far as they go",
        [
            Column("scenario"),
            Column("run"),
            Column("step over critical", True),
            Column("bed"),
            Column("cycle", True),
            Column("settlement, mm", True),
            Column("plates 1 to 5, mm", True),
            Column("porosity 1 to 3", True),
            Column("kinetic energy, µJ per clump", True),
            Column("work of the sleeper, J per cycle", True),
            Column("state"),
        ],
    )
    for (scenario, case), rows in table.groupby(["scenario", "case"], sort=False):
        there = rows[rows["state"] == "done"]
        pending = (rows["state"] == "pending").any()
        last = (there if len(there) else rows).iloc[-1]
        plates = " ".join(number(last[f"lateral_{k}_m"], 2, MM) for k in range(1, 6)) if len(there) else "–"
        porosity = " ".join(number(last[f"porosity_{k}"], 3) for k in range(1, 4)) if len(there) else "–"
        made.rows.append(
            [
                short_name(scenario),
                case_name(case),
                number(last["step_share"], 2),
                last["bed"] if len(there) else "–",
                str(int(last["cycle"])) if len(there) else "–",
                number(last["settlement_m"], 3, MM),
                plates,
                porosity,
                number(last["kinetic_energy_J"], 2, 1e6),
                number(last["sleeper_work_J"], 3),
                Chip("pending", "open") if pending else Chip("done", "good"),
            ]
        )
    made.note = (
        "Bed: first digits of the packed bed's checksum; only runs of one bed differ in the step alone. Kinetic "
        "energy: at the end of the cycle, at the least load. Work: stress on the sleeper times its way, over the "
        "cycle; runs kept in the repository do not have the rows for it."
    )
    return made
