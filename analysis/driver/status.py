"""`make status`: every run, how far it is, how fast, how well it tracks its load, and what became of it."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver import options
from analysis.driver.folder import cycles_done, run_folder
from analysis.driver.locks import is_held
from analysis.driver.progress import duration
from analysis.driver.record import stored_record
from analysis.driver.settings import RESULTS
from analysis.formats import file_columns, run_record, table_file
from analysis.formats.errors import InputError, one_line
from analysis.formats.run_record import RunRecord
from analysis.scenarios import derived, study_list
from analysis.scenarios.scenario import Scenario

COLUMNS = (
    "profile",
    "scenario",
    "code",
    "seed",
    "stage",
    "cycle",
    "steps/s",
    "time left",
    "tracking %",
    "clumps",
    "state",
    "reason",
)
RIGHT = {"done", "running", "failed", "cycles", "seed", "cycle", "steps/s", "time left", "tracking %", "clumps"}
PEAK_REACHED = 0.95
"""Least peak of the sleeper's stress over its target that counts as reached."""


def runs(results: Path) -> list[Path]:
    """Folders of all runs under `results`."""
    return sorted(path.parent for path in results.glob(f"*/*/*/{run_record.FILE}"))


def state_of(folder: Path, state: str, reason: str = "") -> tuple[str, str]:
    """State and reason of run.json; a run that says `running` but belongs to no living process was interrupted."""
    if state != "running":
        return state, reason
    alive = any(is_held(folder / name) for name in ("run.lock", "packing.lock"))
    return ("running", "") if alive else ("interrupted", "killed; the same command goes on")


def row(folder: Path) -> dict[str, str]:
    """One line of the table, by column; of a run that cannot be read, what its folder says and the reason."""
    try:
        return _row(folder)
    except (InputError, OSError) as error:
        names = dict(zip(COLUMNS, folder.parts[-3:], strict=False))
        return dict.fromkeys(COLUMNS, "") | names | {"state": "damaged", "reason": one_line(error)}


def _row(folder: Path) -> dict[str, str]:
    body = RunRecord.read(folder)
    state, reason = state_of(folder, body.state, body.reason)
    scenario = Scenario.read(folder / "scenario.json")
    reason = "; ".join(filter(None, (reason, load_not_reached(folder, scenario))))
    total, done, stage = scenario["loading.cycles"], cycles_done(folder), body.stage
    speed = body.timing.steps_per_second.get(stage)
    left = ""
    if state == "running" and stage == "cyclic" and speed:
        left = duration((total * derived.time_grid(scenario).steps_per_cycle - body.steps.get(stage, 0)) / speed)
    return {
        "profile": body.profile,
        "scenario": scenario.id,
        "code": body.code,
        "seed": str(body.seed),
        "stage": stage,
        "cycle": f"{done}/{total}",
        "steps/s": f"{speed:.0f}" if speed else "",
        "time left": left,
        "tracking %": _tracking(folder, scenario),
        "clumps": str(body.clumps or ""),
        "state": state,
        "reason": reason,
    }


def _tracking(folder: Path, scenario: Scenario) -> str:
    """Tracking error of the worst cycle so far, rms in per cent of the largest stress, as in the report."""
    errors = _cycles(folder).get("tracking_rms_Pa")
    return f"{100 * max(errors) / scenario['loading.stress_max']:.2f}" if errors else ""


def _cycles(folder: Path) -> dict[str, list[float]]:
    """The columns of cycles.csv; {} without the file."""
    path = folder / "cycles.csv"
    return table_file.read(path, file_columns.CYCLES) if path.exists() else {}


def load_not_reached(folder: Path, scenario: Scenario) -> str:
    """What the load swung between in the last cycle, where its peak stayed below PEAK_REACHED of the target; else ''.

    A result under PFC's servo, which is too slow for a soft bed; under the true load a sign that something is wrong.
    """
    table = _cycles(folder)
    if not table.get("cycle"):
        return ""
    low, high = (table[f"sleeper_stress_{end}_Pa"][-1] for end in ("min", "max"))
    least, most = scenario["loading.stress_min"], scenario["loading.stress_max"]
    if high >= PEAK_REACHED * most:
        return ""
    return (
        f"load not reached: {low / 1e3:.0f} to {high / 1e3:.0f} instead of {least / 1e3:.0f} to {most / 1e3:.0f} kPa "
        f"in cycle {table['cycle'][-1]:.0f}"
    )


def table(rows: list[dict[str, str]], columns: Sequence[str] = COLUMNS) -> str:
    """Rows as text, columns aligned."""
    widths = {column: max(len(column), *(len(r[column]) for r in rows)) for column in columns}

    def line(cells: dict[str, str]) -> str:
        return "  ".join(cells[c].rjust(w) if c in RIGHT else cells[c].ljust(w) for c, w in widths.items()).rstrip()

    return "\n".join([line({column: column for column in columns}), *map(line, rows)])


def study_table(results: Path) -> str:
    """How much of the study's list (`make study`) is done, a line for each part."""
    parts: dict[str, dict] = {}
    for row in study_list.rows():
        folder = run_folder(results, study_list.profile(), row.scenario, row.code, row.seed)
        part = parts.setdefault(row.part, dict.fromkeys(("runs", "done", "failed", "running", "cycles", "asked"), 0))
        try:
            body, done = stored_record(folder), min(cycles_done(folder), row.cycles)
        except InputError:  # the table above says what is wrong with it
            body, done = None, 0
        state = state_of(folder, body.state)[0] if body else ""
        part["runs"] += 1
        part["cycles"] += done
        part["asked"] += row.cycles
        if done == row.cycles:
            part["done"] += 1
        elif state in ("failed", "running"):
            part[state] += 1
    lines = [
        {
            "study": title,
            "done": f"{part['done']}/{part['runs']}",
            "running": str(part["running"] or ""),
            "failed": str(part["failed"] or ""),
            "cycles": f"{part['cycles']}/{part['asked']}",
        }
        for title, part in parts.items()
    ]
    return table(lines, ("study", "done", "running", "failed", "cycles"))


def add_arguments(parser: Parser) -> None:
    """Arguments of `ballast status`."""
    parser.add_argument("--results", type=options.path, default=RESULTS, help="folder of all results")


def execute(chosen: argparse.Namespace) -> int:
    """`ballast status`."""
    rows = [row(folder) for folder in runs(chosen.results)]
    print(table(rows) if rows else f"no runs in {chosen.results} yet; `make demo` makes the first ones")
    if any(row["profile"] == study_list.profile() for row in rows):
        print("\n" + study_table(chosen.results))
    return 0
