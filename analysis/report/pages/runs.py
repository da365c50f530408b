"""Where the numbers come from: every run with its state, versions and command."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.comparison.findings.members import TRUE_LOAD, member
from analysis.comparison.quantities import last_cycle
from analysis.driver import provenance
from analysis.driver.status import load_not_reached
from analysis.formats import file_columns
from analysis.formats.numbers import plural
from analysis.normalised.readers import Run
from analysis.report.figure import run_id
from analysis.report.figures.load import TRACKING_AIM, tracking_figure
from analysis.report.labels import KPA, MM
from analysis.report.report_data import ReportData, name_of, speed, state_of, timing, tracking_percent
from analysis.report.tables import Chip, Column, Table, number

STATE_KIND = {"finished": "good", "running": "calm", "interrupted": "open", "failed": "bad"}


def runs_table(runs: Sequence[Run]) -> Table:
    """One line per run: what, how far, how well."""
    table = Table(
        "All runs. Settlement at minimum load and tracking error (worst cycle, rms; marked above the aim of 1 % on "
        "linear and 2 % on nonlinear beds) are of the cycles reached.",
        [
            Column("run"),
            Column("size"),
            Column("state"),
            Column("cycles", True),
            Column("clumps", True),
            Column("settlement, mm", True),
            Column("plates, mm", True),
            Column("tracking, %", True),
            Column("steps/s", True),
            Column("bed"),
        ],
    )
    for run in runs:
        state, _ = state_of(run)
        goal = run.scenario["loading.cycles"] if run.scenario else None
        last = run.cycles.iloc[-1] if len(run.cycles) else None
        lateral = last[[f"lateral_{k}_m" for k in file_columns.PLATES]] if last is not None else None
        table.rows.append(
            [
                name_of(run),
                run.profile,
                Chip(state, STATE_KIND.get(state, "open")),
                f"{last_cycle(run)}{f' of {goal}' if goal else ''}",
                number(last["clumps"] if last is not None else run.info.get("clumps"), 6),
                number(last["settlement_m"], 3, MM) if last is not None else "–",
                f"{number(lateral.min(), 2, MM)} to {number(lateral.max(), 2, MM)}" if last is not None else "–",
                tracking_cell(run),
                number(speed(run), 3),
                bed_of(run),
            ]
        )
    return table


def tracking_cell(run: Run) -> Chip | str:
    """Worst tracking error, %; marked where it is above the aim."""
    value = tracking_percent(run)
    aim = TRACKING_AIM.get(run.scenario["contact.model"] if run.scenario else "", math.inf)
    return Chip(f"{number(value, 2)} (aim {aim})", "open") if value > aim else number(value, 2)


def runs_page(data: ReportData) -> dict:
    """Every run with where it comes from."""
    summary = Table(
        "Provenance",
        [
            Column("run"),
            Column("parameters"),
            Column("engine"),
            Column("analysis"),
            Column("commit"),
            Column("seed", True),
            Column("bed"),
            Column("state"),
        ],
    )
    entries = []
    for run in (*data.runs, *data.variants):
        versions = run.info.get("versions", {})
        state, reason = state_of(run)
        commit = provenance.short_commit(run.info.get("git_commit") or "–")
        summary.rows.append(
            [
                run.id,
                run_id(run).rpartition("@")[2],
                versions.get("engine", "–"),
                versions.get("analysis", "–"),
                commit + ("+" if run.info.get("git_dirty") else ""),
                str(run.seed),
                bed_of(run),
                Chip(state, STATE_KIND.get(state, "open")),
            ]
        )
        entries.append(run_entry(run, state, reason))
    summary.note = (
        "A commit with + had changes that were not committed. Runs below kept/ are the copies in reference_data/runs; "
        "they have no beds."
    )
    left_out = Table(
        "Runs that are not drawn",
        [Column("run"), Column("why", wide=True)],
        [[run.id, why] for run, why in data.left_out],
    )
    tracking = [
        tracking_figure(
            data.gallery,
            [run for run in data.of(profile) if member(run).reading == TRUE_LOAD],
            f"tracking-all-{profile}",
            f"Load tracking under the true load, {profile} bed",
            "rms error over each cycle, and the extremes of each cycle minus their targets (paler: minimum).",
        )
        for profile in data.profiles
    ]
    return {
        "summary": summary,
        "runs": entries,
        "tables": [left_out],
        "figures": tracking,
        "results": data.results,
        "problems": data.problems,
    }


def bed_of(run: Run) -> str:
    """Where the packed bed came from."""
    bed = str(run.info.get("bed", "–"))
    return f"of {bed.split('/')[2]}" if bed.startswith("../../") else bed


def run_entry(run: Run, state: str, reason: str) -> dict:
    """One run in a few sentences."""
    times, info = timing(run), run.info
    text = [
        f"{info.get('title') or (run.scenario.title if run.scenario else run.scenario_name)}; profile {run.profile}, "
        f"seed {run.seed}."
    ]
    if reason:
        text.append(f"Reason: {reason}.")
    if run.scenario is not None:
        step = f"Time step {number(run.scenario['time.step'], 3, 1e6)} µs"
        choice = run.scenario.parameters.get("time.choice")
        text.append(step + (f", the {choice.value} one." if choice else "."))
        if missed := load_not_reached(run.folder, run.scenario):
            text.append(f"{missed[0].upper()}{missed[1:]}.")
    if run.last_error():
        text.append(f"Last error in its logs: {run.last_error()}.")
    text.append(
        f"{last_cycle(run)} cycles"
        + (f" of {run.scenario['loading.cycles']}" if run.scenario else "")
        + f", stage {info.get('stage', 'unknown')}, "
        f"{plural(int(info.get('ranks') or 1), 'rank')}, {plural(int(info.get('threads') or 1), 'thread')}"
        + (f", {plural(len(info['resumes']), 'resume')}" if info.get("resumes") else "")
        + "."
    )
    speeds = times.get("steps_per_second")
    if isinstance(speeds, dict) and speeds:
        text.append(
            "Steps per second: " + ", ".join(f"{stage} {number(value, 3)}" for stage, value in speeds.items()) + "."
        )
    if times.get("start"):
        text.append(
            f"From {times['start']} to "
            f"{times.get('end') or 'now'}{' on ' + str(times['host']) if times.get('host') else ''}."
        )
    if len(run.cycles):
        text.append(
            f"Tracking error {number(tracking_percent(run), 2)} % rms in the worst cycle; sleeper stress "
            f"{number(run.cycles['sleeper_stress_min_Pa'].min(), 3, KPA)} to "
            f"{number(run.cycles['sleeper_stress_max_Pa'].max(), 3, KPA)} kPa."
        )
        text.extend(plate_sentence(run))
    versions = info.get("versions", {})
    if versions:
        text.append("Versions: " + ", ".join(f"{key} {value}" for key, value in versions.items()) + ".")
    return {
        "anchor": re.sub(r"[^a-z0-9]+", "-", run.id.lower()),
        "name": run.id,
        "state": state,
        "kind": STATE_KIND.get(state, "open"),
        "text": " ".join(text),
        "deviations": [str(d) for d in info.get("deviations", [])],
        "problems": run.problems,
        "command": info.get("command", "command unknown"),
    }


def plate_sentence(run: Run) -> list[str]:
    """Mean stress on each plate over the run, where the history is there."""
    columns = [f"plate_{k}_stress_Pa" for k in file_columns.PLATES]
    means = run.history[columns].mean() if len(run.history) else pd.Series(dtype=float)
    if not len(means) or not np.isfinite(means).any():
        return []
    return ["Mean stress on plates 1 to 5: " + ", ".join(number(v, 3, KPA) for v in means) + " kPa."]
