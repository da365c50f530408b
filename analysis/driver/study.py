"""`make study`: the list of [study] in the scenario file, made by make's own job queue.

    ballast study --list          # the list
    ballast study --make          # the list as rules for make: make -j2 study
    ballast study --row NAME      # one row: goes on with it, answers at once when it is done

A run that diverged is a result: it is not tried again.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver import options
from analysis.driver.folder import cycles_done, run_folder
from analysis.driver.record import stored_record
from analysis.driver.run import run
from analysis.driver.settings import RESULTS, RunSettings
from analysis.driver.status import table
from analysis.formats.errors import InputError
from analysis.formats.run_record import DIVERGED
from analysis.scenarios import study_list
from analysis.scenarios.scenario import SCENARIO_FILE, ScenarioError, load_scenario

COLUMNS = ("part", "scenario", "code", "seed", "cycles", "bed", "done")


def settled(folder: Path, cycles: int) -> str:
    """Why there is nothing left to do in the run's folder for a row of that many cycles; empty where there is."""
    done, body = cycles_done(folder), stored_record(folder)
    if done >= cycles:
        return f"done: {done} cycles in {folder}"
    if body and body.state == "failed" and body.reason.startswith(DIVERGED):
        return f"ended after {done} of {cycles} cycles, which is a result: {body.reason}; {folder}"
    return ""


def listing(rows: list[study_list.StudyRow], folder_of) -> str:
    """The rows as a table."""
    lines = []
    for row in rows:
        cells = {name: str(getattr(row, name)) for name in COLUMNS[:-1]}
        try:
            done = str(min(row.cycles, cycles_done(folder_of(row))) or "")
        except InputError:  # `make status` says what is wrong with it
            done = "damaged"
        lines.append(cells | {"done": done})
    return table(lines, COLUMNS)


def makefile(rows: list[study_list.StudyRow], command: str) -> str:
    """Rules for make: a target per row, in order; a row that asks for more cycles of a run waits for the one before."""
    waits, before = [], {}
    for row in rows:
        if row.run in before:
            waits.append(f"{row.name}: {before[row.run]}")
        before[row.run] = row.name
    names = " ".join(row.name for row in rows)
    return "\n".join(
        [
            f"rows := {names}",
            ".PHONY: study $(rows)",
            "study: $(rows)",
            "$(rows):",
            "\t@" + command.replace("$", "$$") + " --row $@",
            *waits,
            "",
        ]
    )


def add_arguments(parser: Parser) -> None:
    """Arguments of `ballast study`."""
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--list", action="store_true", help="print the list (default)")
    what.add_argument("--make", action="store_true", help="print the list as rules for make")
    what.add_argument("--row", metavar="NAME", help="make one row of the list")
    what.add_argument("--array", type=int, metavar="N", help="make the Nth run (from 0), for the arrays of a scheduler")
    what.add_argument("--count", action="store_true", help="how many runs --array knows")
    parser.add_argument("--profile", help="instead of the study's")
    parser.add_argument("--ranks", type=options.whole, default=1)
    parser.add_argument("--results", type=options.path, default=RESULTS, help="folder of all results")
    parser.add_argument("--scenarios", type=options.path, default=SCENARIO_FILE, help="another scenario file")


def execute(chosen: argparse.Namespace) -> int:
    """`ballast study`; exit code of --row as that of `run`."""
    try:
        rows = study_list.rows(chosen.scenarios)
        profile = chosen.profile or study_list.profile(chosen.scenarios)
    except ScenarioError as error:
        print(error, file=sys.stderr)
        return 1

    def folder_of(row: study_list.StudyRow) -> Path:
        return run_folder(chosen.results, profile, row.scenario, row.code, row.seed)

    if chosen.make:
        print(makefile(rows, _own_command(chosen)), end="")
    elif chosen.count:
        print(len(study_list.final_rows(chosen.scenarios)))
    elif chosen.row is None and chosen.array is None:
        print(listing(rows, folder_of))
    else:
        row = _chosen_row(chosen, rows)
        if row is None:
            print("study: no such row; `ballast study --list` prints them", file=sys.stderr)
            return 2
        if text := settled(folder_of(row), row.cycles):
            print(f"{row.scenario} {row.code} {profile}{f' seed {row.seed}' if row.seed != 1 else ''} | {text}")
        else:
            return _run_row(chosen, row, profile)
    return 0


def _own_command(chosen: argparse.Namespace) -> str:
    """The command by which make calls this program for a row."""
    flags = ["--ranks", str(chosen.ranks), "--results", str(chosen.results), "--scenarios", str(chosen.scenarios)]
    flags += ["--profile", chosen.profile] if chosen.profile else []
    return shlex.join([sys.executable, "-m", "analysis", "study", *flags])


def _chosen_row(chosen: argparse.Namespace, rows: list[study_list.StudyRow]) -> study_list.StudyRow | None:
    """The row of --row or --array; None where there is none."""
    if chosen.array is None:
        found = [row for row in rows if row.name == chosen.row]
    else:
        found = study_list.final_rows(chosen.scenarios)[chosen.array : chosen.array + 1] if chosen.array >= 0 else []
    return found[0] if found else None


def _run_row(chosen: argparse.Namespace, row: study_list.StudyRow, profile: str) -> int:
    """Make the run of a row or go on with it; exit code of `run`."""
    return run(
        RunSettings(
            load_scenario(row.scenario, profile, chosen.scenarios, row.cycles),
            row.code,
            seed=row.seed,
            ranks=chosen.ranks,
            results=chosen.results,
            scenarios=chosen.scenarios,
            cycles=row.cycles,
            lines=True,
        )
    )
