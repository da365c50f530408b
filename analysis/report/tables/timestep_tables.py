"""The time step: its share of the critical one, and what runs at several steps came to."""

from __future__ import annotations

import pandas as pd

from analysis.formats.file_columns import PLATES, SPHERES
from analysis.formats.numbers import plural
from analysis.formats.quantities import QUANTITIES
from analysis.report.tables.table_html import Chip, Shown, Table, frame_table, number

CASES = {
    "paper": "the paper's step",
    "verified": "the study's step",
    "half": "half the paper's",
    "rounding": "two ranks",
}


def case_name(case: str) -> str:
    """A case of timestep.csv in words."""
    return CASES.get(case, f"{case} of critical" if case[0].isdigit() else case)


def shares_table(table: pd.DataFrame) -> Table | None:
    """Critical step of each scenario's preloaded bed, and what share of it the steps are that runs take."""
    first = table.groupby(["scenario", "case"], sort=False).first().reset_index().set_index("scenario")
    critical = first.groupby(level=0, sort=False)["critical_step_s"].first().to_frame()
    for case in ("paper", "verified"):
        part = first.loc[first["case"] == case, ["time_step_s", "step_share"]]
        critical = critical.join(part.add_prefix(f"{case}_"))
    return frame_table(
        critical.reset_index(),
        "The critical step, measured on the preloaded bed",
        [
            "scenario",
            "critical_step_s",
            Shown("paper_time_step_s", "the paper's", like="time_step_s"),
            Shown("paper_step_share", "share", like="step_share"),
            Shown("verified_time_step_s", "the study's", like="time_step_s"),
            Shown("verified_step_share", "share", like="step_share"),
        ],
    )


def spread_table(spread: pd.DataFrame) -> Table | None:
    """By how much settlement after the last cycle varies; `spread` is `Findings.timestep_spread`."""
    if spread.empty:
        return None
    return frame_table(
        spread,
        f"By how much settlement after {plural(int(spread['cycle'].max()), 'cycle')} varies",
        ["scenario", *(Shown(f"{name}_ratio", digits=2) for name in ("steps", "beds", "rounding"))],
    )


def last_rows(table: pd.DataFrame) -> pd.DataFrame:
    """Of each run the last cycle that is done, or its first row where none is, and whether something is pending."""
    rows = []
    for (_, _), part in table.groupby(["scenario", "case"], sort=False):
        done = part[part["state"] == "done"]
        pending = (part["state"] == "pending").any()
        rows.append((done if len(done) else part).iloc[-1].to_dict() | {"done": len(done) > 0, "pending": pending})
    return pd.DataFrame(rows)


def runs_table(table: pd.DataFrame) -> Table | None:
    """Every run of the comparison after its last shown cycle."""
    return frame_table(
        last_rows(table),
        "All runs, after 20 cycles or as far as they go",
        [
            "scenario",
            Shown("case", "run", text=lambda row: case_name(row.case), number=False),
            Shown("step_share", digits=2),
            Shown("bed", "bed", text=lambda row: row.bed if row.done else "–", number=False),
            Shown("cycle", "cycle", text=lambda row: str(int(row.cycle)) if row.done else "–"),
            "settlement_m",
            Shown("lateral_1_m", "plates 1 to 5", text=lambda row: in_a_row(row, "lateral_{}_m", PLATES, 2)),
            Shown("porosity_1", "porosity 1 to 3", text=lambda row: in_a_row(row, "porosity_{}", SPHERES, 3)),
            Shown("kinetic_energy_J", digits=2),
            "sleeper_work_J",
            Shown("state", "state", text=state, number=False),
        ],
    )


def in_a_row(row, pattern: str, members: range, digits: int) -> str:
    """The values of all plates or spheres in one cell."""
    if not row.done:
        return "–"
    names = [pattern.format(k) for k in members]
    return " ".join(number(getattr(row, name), digits, QUANTITIES[name].factor) for name in names)


def state(row) -> Chip:
    """Whether a run is done."""
    return Chip("pending", "open") if row.pending else Chip("done", "good")
