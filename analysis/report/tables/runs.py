"""Every run: how far it got, how well the load was met, and where it comes from."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from analysis.comparison.quantities import last_cycle
from analysis.driver import provenance
from analysis.formats import file_columns
from analysis.normalised.readers import Run
from analysis.report.figure import run_id
from analysis.report.figures.load import TRACKING_AIM
from analysis.report.labels import MM
from analysis.report.report_data import bed_of, name_of, speed, state_of, tracking_percent
from analysis.report.tables.base import Chip, Column, Table, number

STATE_KIND = {"finished": "good", "running": "calm", "interrupted": "open", "failed": "bad"}


def runs_table(runs: Sequence[Run]) -> Table:
    """One line per run: what, how far, how well."""
    caption = (
        "All runs. Settlement at minimum load and tracking error (worst cycle, rms; marked above the aim of "
        f"{TRACKING_AIM['linear']:g} % on linear and {TRACKING_AIM['hysteretic']:g} % on nonlinear beds) are of the "
        "cycles reached."
    )
    words, numbers = ("run", "size", "state"), ("cycles", "clumps", "settlement, mm", "plates, mm", "tracking, %")
    columns = [*map(Column, words), *(Column(name, True) for name in (*numbers, "steps/s")), Column("bed")]
    return Table(caption, columns, [run_cells(run) for run in runs])


def run_cells(run: Run) -> list[str | Chip]:
    """The cells of `runs_table`."""
    goal = run.scenario["loading.cycles"] if run.scenario else None
    reached = f"{last_cycle(run)}{f' of {goal}' if goal else ''}"
    head = [name_of(run), run.profile, state_chip(run), reached]
    tail = [tracking_cell(run), number(speed(run), 3), bed_of(run)]
    if not len(run.cycles):
        return [*head, number(run.info.get("clumps"), 6), "–", "–", *tail]
    last = run.cycles.iloc[-1]
    lateral = last[[f"lateral_{k}_m" for k in file_columns.PLATES]]
    plates = f"{number(lateral.min(), 2, MM)} to {number(lateral.max(), 2, MM)}"
    return [*head, number(last["clumps"], 6), number(last["settlement_m"], 3, MM), plates, *tail]


def state_chip(run: Run) -> Chip:
    """Finished, running, interrupted or failed."""
    state, _ = state_of(run)
    return Chip(state, STATE_KIND.get(state, "open"))


def tracking_cell(run: Run) -> Chip | str:
    """Worst tracking error, %; marked where it is above the aim."""
    value = tracking_percent(run)
    aim = TRACKING_AIM.get(run.scenario["contact.model"] if run.scenario else "", math.inf)
    return Chip(f"{number(value, 2)} (aim {aim})", "open") if value > aim else number(value, 2)


def provenance_table(runs: Iterable[Run]) -> Table:
    """Where each run comes from."""
    words = ("run", "parameters", "engine", "analysis", "commit")
    table = Table("Provenance", [*map(Column, words), Column("seed", True), Column("bed"), Column("state")])
    for run in runs:
        versions = run.info.get("versions", {})
        commit = provenance.short_commit(run.info.get("git_commit") or "–")
        commit += "+" if run.info.get("git_dirty") else ""
        made = [versions.get("engine", "–"), versions.get("analysis", "–"), commit]
        hashed = run_id(run).rpartition("@")[2]
        table.rows.append([run.id, hashed, *made, str(run.seed), bed_of(run), state_chip(run)])
    return table


def left_out_table(left_out: Iterable[tuple[Run, str]]) -> Table:
    """Runs that are there and not drawn."""
    columns = [Column("run"), Column("why", wide=True)]
    return Table("Runs that are not drawn", columns, [[run.id, why] for run, why in left_out])
