"""Command line of `make bench`.

Everything starts from one bed: the preloaded one of a LIGGGHTS run of each law, which is made where it is missing. What
is compared is timed in turn, several times; each timing is a row of report/benchmark/timings.csv, and a further call
adds to it. Medians of all rows go to reference_data/runs/benchmark.csv.

Speeds count processor time, because machines are shared. They still depend on what shares the caches.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver import run
from analysis.driver.bench import tables
from analysis.driver.bench.beds import Preloaded
from analysis.driver.bench.cases import Case, cases
from analysis.driver.engines import CODES, EngineError
from analysis.files import ROOT
from analysis.formats.growing_csv import GrowingCsv
from analysis.scenarios import derived
from analysis.scenarios.study import key_scenarios

CLUMPS = (500, 1500, 4573, 15000)
RANKS = (1, 2)


def preloaded(name: str, profile: str, results: Path) -> Preloaded:
    """The preloaded bed of a scenario, made where it is missing. SystemExit where it cannot be made."""
    folder = run.run_folder(results, profile, name, "liggghts", 1)
    if not Preloaded(folder).bed.exists() and run.main(
        [name, "--code", "liggghts", "--profile", profile, "--results", str(results), "--until", "preload"]
    ):
        raise SystemExit(1)
    return Preloaded(folder)


def main(argv: list[str]) -> int:
    """Command line of `make bench`."""
    parser = Parser(prog="python -m analysis bench", description="Steps per second of processor time, side by side.")
    parser.add_argument("--profile", default="demo")
    parser.add_argument("--repeats", type=int, default=3, help="timings of each (default 3)")
    parser.add_argument("--codes", nargs="+", choices=CODES, default=list(CODES))
    parser.add_argument("--scenario", nargs="+", default=list(key_scenarios()), help="scenarios, one for each law")
    parser.add_argument("--what", nargs="+", choices=("compare", "sizes"), default=["compare", "sizes"])
    parser.add_argument("--results", type=Path, default=ROOT / "results", help="where preloaded beds may be found")
    parser.add_argument("--work", type=Path, default=ROOT / "report" / "benchmark", help="folder of what is timed")
    options = parser.parse_args(argv)
    work = options.work.resolve() / options.profile
    work.mkdir(parents=True, exist_ok=True)
    try:
        beds = {name: preloaded(name, options.profile, options.results.resolve()) for name in options.scenario}
        if "compare" in options.what:
            found = cases(options.scenario, options.codes, beds.__getitem__, work, options.profile)
            repeat(found, options.repeats, work / "timings.csv")
        if "sizes" in options.what:
            found = [
                Case(code, name, "paper", beds[name], work, options.profile, clumps / CLUMPS[2], ranks)
                for name in options.scenario[-1:]
                for code in options.codes
                for clumps in CLUMPS
                for ranks in (RANKS if clumps == CLUMPS[2] else RANKS[:1])
            ]
            repeat(found, options.repeats, work / "sizes.csv")
    except EngineError as error:
        print(f"bench: {error}", file=sys.stderr)
        return 1
    if options.profile == "full":
        rows = tables.write(work / "timings.csv", work / "sizes.csv")
    else:
        rows = tables.comparison(tables.read_timings(work / "timings.csv"), [])
    print(f"{'case':20} {'code':9} {'law':10} {'steps per cpu second':>20} {'ratio':>7}")
    for case, code, law, speed, ratio in rows:
        print(f"{case:20} {code:9} {law:10} {speed:20.1f} {ratio:7.3f}")
    return 0


def repeat(found: list[Case], repeats: int, file: Path) -> None:
    """Time all cases in turn, `repeats` times, and add a row for each timing."""
    table = GrowingCsv(file, tables.TIMINGS)
    if not file.exists():
        table.start()
    for case in found:
        case.prepare()
    for _ in range(repeats):
        for case in found:
            speed = case.time()
            cycle = derived.time_grid(case.scenario).steps_per_cycle
            row = (case.code, case.law, case.who, case.clumps, case.ranks, speed.steps, cycle)
            table.append([(*row, speed.cpu_s, speed.wall_s, os.getloadavg()[0])])
            print(
                f"{case.code} {case.law} {case.who}, {case.clumps} clumps, {case.ranks} rank(s): "
                f"{speed.steps / speed.cpu_s:.0f} steps per processor second, {speed.steps / speed.wall_s:.0f} on the clock",
                flush=True,
            )


