"""Command line of `make bench`.

Everything starts from one bed: the preloaded one of a LIGGGHTS run of each law, which is made where it is missing. What
is compared is timed in turn, several times; each timing is a row of report/benchmark/timings.csv, and a further call
adds to it. Medians of all rows go to reference_data/runs/benchmark.csv.

Speeds count processor time, because machines are shared. They still depend on what shares the caches.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver import options
from analysis.driver.bench import bench_tables, profile
from analysis.driver.bench.bench_beds import Preloaded
from analysis.driver.bench.cases import WHO, TimedCase
from analysis.driver.engine import EngineError
from analysis.driver.engines import CODES, LIGGGHTS
from analysis.driver.run import run
from analysis.driver.settings import RESULTS, RunSettings
from analysis.files import ROOT
from analysis.formats.growing_csv import GrowingCsv
from analysis.formats.kept_tables import BENCHMARK_PROFILE, TIMINGS
from analysis.scenarios import derived
from analysis.scenarios.scenario import load_scenario
from analysis.scenarios.study_list import key_scenarios

CLUMPS = (500, 1500, 4573, 15000)
RANKS = (1, 2)
WORK = ROOT / "report" / "benchmark"
WHAT = ("compare", "sizes", "profile")


def preloaded(name: str, profile: str, results: Path) -> Preloaded:
    """The preloaded bed of a scenario, made where it is missing. SystemExit where it cannot be made."""
    settings = RunSettings(load_scenario(name, profile), LIGGGHTS.name, results=results, until="preload")
    bed = Preloaded(settings.folder)
    if not bed.bed.exists() and run(settings):
        raise SystemExit(1)
    return bed


def add_arguments(parser: Parser) -> None:
    """Arguments of `ballast bench`."""
    parser.add_argument("--profile", default="demo")
    parser.add_argument("--repeats", type=options.whole, default=3, help="timings of each (default 3)")
    parser.add_argument("--codes", nargs="+", choices=CODES, default=list(CODES))
    parser.add_argument("--scenario", nargs="+", default=list(key_scenarios()), help="scenarios, one for each law")
    parser.add_argument("--what", nargs="+", choices=WHAT, default=list(WHAT))
    parser.add_argument("--results", type=options.path, default=RESULTS, help="where preloaded beds may be found")
    parser.add_argument("--work", type=options.path, default=WORK, help="folder of what is timed")


def execute(chosen: argparse.Namespace) -> int:
    """`ballast bench`."""
    work = chosen.work / chosen.profile
    work.mkdir(parents=True, exist_ok=True)
    compare, by_size = work / "timings.csv", work / "sizes.csv"
    try:
        beds = {name: preloaded(name, chosen.profile, chosen.results) for name in chosen.scenario}
        if "compare" in chosen.what:
            repeat(comparison_cases(beds, chosen.codes, work, chosen.profile), chosen.repeats, compare)
        if "sizes" in chosen.what:
            name = chosen.scenario[-1]
            repeat(size_cases(name, beds[name], chosen.codes, work, chosen.profile), chosen.repeats, by_size)
        if "profile" in chosen.what:
            profiled(beds, chosen.codes, work, chosen.profile)
    except EngineError as error:
        print(f"bench: {error}", file=sys.stderr)
        return 1
    rows = (
        bench_tables.write(compare, by_size)
        if chosen.profile == "full"
        else bench_tables.comparison(bench_tables.read_timings(compare), [])
    )
    print(f"{'case':20} {'code':9} {'law':10} {'steps per cpu second':>20} {'ratio':>7}")
    for case, code, law, speed, ratio in rows:
        print(f"{case:20} {code:9} {law:10} {speed:20.1f} {ratio:7.3f}")
    return 0


def profiled(beds: dict[str, Preloaded], codes: list[str], work: Path, size: str) -> None:
    """Where the time of ours goes; on the full bed for the table of the repository too."""
    if not profile.is_there():
        print("bench: no profile: Linux `perf` is missing (Debian package linux-perf)", file=sys.stderr)
        return
    rows = []
    for case in (TimedCase(code, name, "verified", bed, work, size) for code in codes for name, bed in beds.items()):
        case.prepare()
        rows += profile.sample(case)
    for code, law, part, share in rows:
        print(f"{code:9} {law:10} {part:42} {share:6.1%}")
    if size == "full":
        bench_tables.renew(bench_tables.PROFILE, BENCHMARK_PROFILE, rows, key=("code", "law"))


def comparison_cases(beds: dict[str, Preloaded], codes: list[str], work: Path, profile: str) -> list[TimedCase]:
    """All of the comparison, in the order in which they are timed: what a ratio is made of stands side by side."""
    return [
        TimedCase(code, name, who, bed, work, profile) for code in codes for name, bed in beds.items() for who in WHO
    ]


def size_cases(name: str, bed: Preloaded, codes: list[str], work: Path, profile: str) -> list[TimedCase]:
    """Beds of other widths on one rank, and the bed itself on two; of one law, with the paper's step."""
    return [
        TimedCase(code, name, "paper", bed, work, profile, clumps / CLUMPS[2], ranks)
        for code in codes
        for clumps in CLUMPS
        for ranks in (RANKS if clumps == CLUMPS[2] else RANKS[:1])
    ]


def repeat(found: list[TimedCase], repeats: int, file: Path) -> None:
    """Time all cases in turn, `repeats` times, and add a row for each timing."""
    table = GrowingCsv(file, TIMINGS.columns)
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
                f"{speed.steps / speed.cpu_s:.0f} steps per processor second, "
                f"{speed.steps / speed.wall_s:.0f} by the clock",
                flush=True,
            )
