"""Every run: how far it got, how well the load was met, and where it comes from."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from analysis.comparison.findings.find import Findings
from analysis.comparison.findings.members import member
from analysis.comparison.findings.runs import TRACKING_AIM
from analysis.driver import provenance
from analysis.normalised.readers import Run
from analysis.report.figure import run_id
from analysis.report.report_data import bed_of, state_of
from analysis.report.tables.table_html import Chip, Shown, Table, frame_table, number, run_of

STATE_KIND = {"finished": "good", "running": "calm", "interrupted": "open", "failed": "bad"}


def runs_table(found: Findings, runs: Iterable[Run]) -> Table | None:
    """How far runs got and how well their load was met."""
    rows = pd.DataFrame([member(run).identity | {"now": state_of(run)[0], "bed_from": bed_of(run)} for run in runs])
    if rows.empty:
        return None
    for more, names in (
        (found.coverage, ["cycles", "cycles_wanted", "clumps", "settlement_m", "lateral_mean_m"]),
        (found.load_tracking, ["tracking_worst_ratio", "aim_ratio", "met"]),
        (found.computing_time, ["steps_per_s"]),
    ):
        rows = rows.merge(more[["run", *names]], on="run", how="left")
    return frame_table(
        rows,
        "All runs. Settlement at minimum load and tracking error (worst cycle, rms; marked above the aim of "
        f"{percent(TRACKING_AIM['linear'])} on linear and {percent(TRACKING_AIM['hysteretic'])} on nonlinear beds) are "
        "of the cycles reached.",
        [
            Shown("run", "run", text=run_of, number=False),
            Shown("profile", "size", number=False),
            Shown("now", "state", text=lambda row: state_chip(row.now), number=False),
            "cycles",
            Shown("cycles_wanted", "of", text=lambda row: number(row.cycles_wanted, 6)),
            "clumps",
            "settlement_m",
            Shown("lateral_mean_m", digits=2),
            Shown("tracking_worst_ratio", text=tracking_cell),
            "steps_per_s",
            Shown("bed_from", "bed", number=False),
        ],
    )


def percent(share: float) -> str:
    """A share in percent."""
    return f"{number(share, 2, 100)} %"


def state_chip(state: str) -> Chip:
    """Finished, running, interrupted or failed."""
    return Chip(state, STATE_KIND.get(state, "open"))


def tracking_cell(row) -> Chip | str:
    """Worst tracking error, %; marked where it is above the aim."""
    value = number(row.tracking_worst_ratio, 2, 100)
    return Chip(f"{value} (aim {percent(row.aim_ratio)})", "open") if row.met == "no" else value


def provenance_table(runs: Iterable[Run]) -> Table | None:
    """Where each run comes from."""
    return frame_table(
        pd.DataFrame([origin(run) for run in runs]),
        "Provenance",
        [
            "run",
            Shown("scenario_hash", number=False),
            Shown("engine", number=False),
            Shown("analysis", number=False),
            Shown("git_commit", number=False),
            "seed",
            "bed",
            Shown("state", "state", text=lambda row: state_chip(row.state), number=False),
        ],
    )


def origin(run: Run) -> dict[str, str | int]:
    """Where one run comes from."""
    versions = run.info.get("versions", {})
    commit = provenance.short_commit(run.info.get("git_commit") or "–")
    return {
        "run": run.id,
        "scenario_hash": run_id(run).rpartition("@")[2],
        "engine": versions.get("engine", ""),
        "analysis": versions.get("analysis", ""),
        "git_commit": commit + ("+" if run.info.get("git_dirty") else ""),
        "seed": run.seed,
        "bed": bed_of(run),
        "state": state_of(run)[0],
    }


def left_out_table(left_out: Iterable[tuple[Run, str]]) -> Table | None:
    """Runs that are there and not drawn."""
    rows = pd.DataFrame([{"run": run.id, "why": why} for run, why in left_out], columns=["run", "why"])
    return frame_table(rows, "Runs that are not drawn", ["run", Shown("why", number=False, wide=True)])
