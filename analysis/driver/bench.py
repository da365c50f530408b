"""`make bench`: steps per second of both codes in cyclic loading, on the same machine, one after the other.

Never a test: a number that depends on what else the machine does cannot fail. Run it on a quiet machine.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver import options
from analysis.driver.engines import CODES
from analysis.driver.rawfiles import last_rows
from analysis.driver.record import stored_record
from analysis.driver.run import run
from analysis.driver.settings import RESULTS, RunSettings
from analysis.files import ROOT, write_csv
from analysis.scenarios.scenario import load_scenario
from analysis.scenarios.study import key_scenarios

SCENARIOS = key_scenarios()
PRELOADED = (
    "scenario.json",
    "run.json",
    "raw/bed_*ed.csv",
    "raw/preload.csv",
    "raw/state.csv",
    "checkpoints/cyclic_000000*",
)
COLUMNS = (
    "profile",
    "scenario",
    "code",
    "version",
    "ranks",
    "clumps",
    "contacts",
    "steps",
    "wall_s",
    "steps_per_second",
    "ratio_to_yade",
    "hours_per_1000_cycles",
    "cpu",
    "load_average",
)


def measure(
    profile: str, name: str, code: str, cycles: int, ranks: int, results: Path, work: Path
) -> dict[str, str | int | float]:
    """Load a preloaded bed for some cycles. The bed comes from `results`, where it is made if it is not there yet."""
    bed = RunSettings(load_scenario(name, profile), code, ranks=ranks, results=results, until="preload")
    timed = RunSettings(load_scenario(name, profile, cycles=cycles), code, ranks=ranks, results=work, cycles=cycles)
    source, folder = bed.folder, timed.folder
    if not (source / "raw" / "bed_preloaded.csv").exists() and run(bed):
        raise SystemExit(1)
    for pattern in PRELOADED:
        for path in source.glob(pattern):
            target = folder / path.relative_to(source)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, target)
    load = os.getloadavg()[0]
    if run(timed):
        raise SystemExit(1)
    body, last = stored_record(folder), last_rows(folder / "raw" / "state.csv")["cyclic"]
    steps, speed = body.steps["cyclic"], body.timing.steps_per_second["cyclic"]
    return {
        "profile": profile,
        "scenario": name,
        "code": code,
        "version": body.versions["engine"],
        "ranks": ranks,
        "clumps": body.clumps,
        "contacts": int(float(last["contacts"])),
        "steps": steps,
        "wall_s": body.timing.wall_s["cyclic"],
        "steps_per_second": speed,
        "ratio_to_yade": None,
        "hours_per_1000_cycles": round(1000 * steps / cycles / speed / 3600, 2),
        "cpu": cpu(),
        "load_average": f"{load:.1f}",
    }


def cpu() -> str:
    """Model name of the processor."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), "unknown")


def add_arguments(parser: Parser) -> None:
    """Arguments of `ballast bench`."""
    parser.add_argument("--profile", default="demo")
    parser.add_argument("--cycles", type=options.whole, default=1, help="cycles to time (default 1)")
    parser.add_argument("--ranks", type=options.whole, default=1)
    parser.add_argument("--results", type=options.path, default=RESULTS, help="where preloaded beds may be found")
    parser.add_argument("--out", type=options.path, default=ROOT / "report" / "benchmark.csv")


def execute(chosen: argparse.Namespace) -> int:
    """`ballast bench`."""
    rows = []
    with tempfile.TemporaryDirectory(prefix="bench") as work:
        for name in SCENARIOS:
            pair = [
                measure(chosen.profile, name, code, chosen.cycles, chosen.ranks, chosen.results, Path(work))
                for code in CODES
            ]
            for row in pair:
                row["ratio_to_yade"] = round(row["steps_per_second"] / pair[CODES.index("yade")]["steps_per_second"], 2)
            rows += pair
    write_csv(chosen.out, [COLUMNS, *([row[name] for name in COLUMNS] for row in rows)])
    print(f"{'scenario':16} {'code':9} {'clumps':>6} {'contacts':>8} {'steps/s':>8} {'ratio':>6} {'h/1000 cycles':>14}")
    for row in rows:
        print(
            "{scenario:16} {code:9} {clumps:6} {contacts:8} {steps_per_second:8.0f} {ratio_to_yade:6.2f} "
            "{hours_per_1000_cycles:14.1f}".format(**row)
        )
    print(f"{cpu()}; load average {rows[0]['load_average']} at the start; written to {chosen.out}")
    return 0
