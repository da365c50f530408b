"""`make status`: every run, how far it is, how fast, how well it tracks its load, and what became of it."""

from __future__ import annotations

import csv
from datetime import UTC, datetime
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver import record
from analysis.driver.locks import is_held
from analysis.driver.progress import duration
from analysis.driver.run import cycles_done
from analysis.files import ROOT
from analysis.scenarios import derived
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
RIGHT = {"seed", "cycle", "steps/s", "time left", "tracking %", "clumps"}
STALE_S = 60.0  # without a lock to ask (some network file systems), a heartbeat older than this means nobody runs it


def runs(results: Path) -> list[Path]:
    """Folders of all runs under `results`."""
    return sorted(path.parent for path in results.glob(f"*/*/*/{record.FILE}"))


def state_of(folder: Path, body: dict) -> tuple[str, str]:
    """State and reason; a run that says `running` but belongs to no living process was interrupted."""
    if body["state"] != "running":
        return body["state"], body["reason"]
    try:
        alive = any(is_held(folder / name) for name in ("run.lock", "packing.lock"))
    except OSError:
        beat = datetime.fromisoformat(body["timing"]["heartbeat"])
        alive = (datetime.now(UTC) - beat).total_seconds() < STALE_S
    return ("running", "") if alive else ("interrupted", "killed; the same command goes on")


def row(folder: Path) -> dict[str, str]:
    """One line of the table, by column."""
    body = record.read(folder)
    if body is None:
        return dict.fromkeys(COLUMNS, "") | {
            "profile": folder.parts[-3],
            "scenario": folder.parts[-2],
            "code": folder.name,
            "reason": "run.json cannot be read",
        }
    state, reason = state_of(folder, body)
    scenario = Scenario.from_json((folder / "scenario.json").read_text())
    total, done, stage = scenario["loading.cycles"], cycles_done(folder), body["stage"]
    speed = body["timing"]["steps_per_second"].get(stage)
    left = ""
    if state == "running" and stage == "cyclic" and speed:
        left = duration((total * derived.time_grid(scenario).steps_per_cycle - body["steps"].get(stage, 0)) / speed)
    return {
        "profile": body["profile"],
        "scenario": body["scenario"],
        "code": body["code"],
        "seed": str(body["seed"]),
        "stage": stage,
        "cycle": f"{done}/{total}",
        "steps/s": f"{speed:.0f}" if speed else "",
        "time left": left,
        "tracking %": _tracking(folder, scenario),
        "clumps": str(body["clumps"] or ""),
        "state": state,
        "reason": reason,
    }


def _tracking(folder: Path, scenario: Scenario) -> str:
    """Tracking error of the worst cycle so far, rms in per cent of the largest stress, as in the report."""
    try:
        with open(folder / "cycles.csv", newline="") as file:
            worst = max((float(row["tracking_rms_Pa"]) for row in csv.DictReader(file)), default=None)
    except FileNotFoundError:
        return ""
    return "" if worst is None else f"{100 * worst / scenario['loading.stress_max']:.2f}"


def table(rows: list[dict[str, str]]) -> str:
    """Rows as text, columns aligned."""
    widths = {column: max(len(column), *(len(r[column]) for r in rows)) for column in COLUMNS}

    def line(cells: dict[str, str]) -> str:
        return "  ".join(cells[c].rjust(w) if c in RIGHT else cells[c].ljust(w) for c, w in widths.items()).rstrip()

    return "\n".join([line({column: column for column in COLUMNS}), *map(line, rows)])


def main(argv: list[str]) -> int:
    """Command line of `make status`."""
    parser = Parser(prog="python -m analysis status", description="List all runs.")
    parser.add_argument("--results", type=Path, default=ROOT / "results", help="folder of all results")
    results = parser.parse_args(argv).results
    rows = [row(folder) for folder in runs(results)]
    print(table(rows) if rows else f"no runs in {results} yet; `make demo` makes the first ones")
    return 0
