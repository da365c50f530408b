"""Calibrate the packing: the full bed over lattice gaps at the chosen clump aspect, and over aspects at the chosen gap.

`make calibrate` packs, preloads and loads each bed for a few cycles, those of the chosen gap also with the nonlinear
law, and writes reference_data/runs/calibration.csv, which the report shows: clumps and porosity beside the paper's,
overlaps and contacts of the packed bed, and how far it settles. A bed that is too full is jammed by the frictionless
relaxation already and moves by micrometres. Each bed is an ordinary run below results/calibration/, so that what is
done is not done again. Copy the chosen values into scenarios.toml by hand: a calibrated value is a decision, not a side
effect.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import pandas as pd

from analysis import files
from analysis.arguments import Parser
from analysis.driver import options
from analysis.driver.engines import CODES, ENGINES
from analysis.driver.record import stored_record
from analysis.driver.run import Execution
from analysis.driver.settings import RESULTS, RunSettings, relative
from analysis.driver.supervise import Interrupted, RunError, StopRequest
from analysis.formats import kept_tables
from analysis.normalised import stages
from analysis.normalised.porosity import MeasurementSpheres
from analysis.normalised.readers import CALIBRATION
from analysis.normalised.readers import Run as Result
from analysis.reference.reported import reported
from analysis.scenarios import derived, lattice
from analysis.scenarios.scenario import Scenario, load_scenario
from analysis.scenarios.study_list import key_scenarios

GAPS_M, STEP_M = (0.0133, 0.0150), 1e-4
ASPECTS = (1.5, 1.7, 1.8, 1.875)
TABLE = files.KEPT_RUNS / "calibration.csv"
STAGE_COLUMNS = {"packing": kept_tables.PACKED, "preload": ("settlement_m",)}


def distinct_gaps(scenario: Scenario, low_m: float, high_m: float) -> list[float]:
    """Largest gap (m) of each distinct number of lattice sites: the count is a step function of the gap."""
    gaps = {}
    for index in range(round((high_m - low_m) / STEP_M) + 1):
        gap = round(low_m + index * STEP_M, 7)
        gaps[lattice.site_count(scenario.with_values({"packing.lattice_gap": gap}))] = gap
    return sorted(gaps.values())


def choices(scenario: Scenario, gaps_m: Sequence[float], aspects: Sequence[float]) -> list[tuple[float, float]]:
    """Pairs of clump aspect and lattice gap (m): each gap with the scenario's aspect, each aspect with its gap."""
    aspect, gap = scenario["clump.aspect"], scenario["packing.lattice_gap"]
    return sorted({*((aspect, g) for g in gaps_m), *((a, gap) for a in aspects)})


def load(settings: RunSettings, stop: StopRequest) -> Result:
    """Do a run, or what is missing of it, and read it back, also where it failed: its state says so.

    A bed that failed before is not tried again: on one core it would fail again. What it was packed to is known all the
    same.
    """
    run, before = Execution(settings, stop), stored_record(settings.folder)
    if before and before.state == "failed":
        print(f"calibrate: failed before ({before.reason}); to try it again, delete {run.folder}", file=sys.stderr)
    else:
        try:
            run.go()
        except RunError as error:
            print(error, file=sys.stderr)
    if run.bed_file.exists() and not (run.folder / stages.FILE).exists():
        stages.write_stages(run.folder, settings.scenario, {}, MeasurementSpheres(settings.scenario))
    return Result(run.folder)


def shortened(value):
    """A float with six digits, which is more than any bed repeats; other values as they are."""
    return float(f"{value:.6g}") if isinstance(value, float) else value


def row(scenario: Scenario, result: Result) -> dict[str, float | str]:
    """What a calibration compares, of one run; values that a failed or unfinished run lacks are nan."""
    found = result.stages
    clumps = found.get("packing", {}).get("clumps", float("nan"))
    values = {
        "scenario": result.scenario_name,
        "code": result.code,
        "seed": result.seed,
        "aspect": scenario["clump.aspect"],
        "lattice_gap_m": scenario["packing.lattice_gap"],
        "lattice_sites": lattice.site_count(scenario),
        "clumps_over_reported": clumps / (reported().clumps * derived.share_of_box(scenario)),
    }
    for stage, names in STAGE_COLUMNS.items():
        for name in names:
            values[name if stage == "packing" else f"{stage}_{name}"] = found.get(stage, {}).get(name, float("nan"))
    last = result.cycles.iloc[-1] if len(result.cycles) else {}
    values["cycles"] = len(result.cycles)
    for name in ("settlement_m", "settlement_peak_m", "lateral_3_m"):
        values[name] = last.get(name, float("nan"))
    values["state"] = result.info.get("state", "unknown")
    return values


def add_arguments(parser: Parser) -> None:
    """Arguments of `ballast calibrate`."""
    parser.add_argument("--code", choices=CODES, default="liggghts")
    parser.add_argument(
        "--scenario",
        nargs="+",
        default=list(key_scenarios()),
        metavar="NAME",
        help="the first is run at each gap and aspect, the others at each aspect",
    )
    parser.add_argument("--profile", default="full")
    parser.add_argument("--seed", type=options.whole, default=1)
    parser.add_argument(
        "--gaps", type=float, nargs="*", help="m; default: one for each number of sites from 13.3 to 15 mm"
    )
    parser.add_argument("--aspects", type=float, nargs="*", default=ASPECTS)
    parser.add_argument("--cycles", type=options.whole, default=5)
    parser.add_argument("--results", type=options.path, default=RESULTS)
    parser.add_argument("--out", type=options.path, default=TABLE, help="written when all beds are done")


def execute(chosen: argparse.Namespace) -> int:
    """`ballast calibrate`."""
    ENGINES[chosen.code].version()
    stop, rows = StopRequest(), []
    bases = [load_scenario(name, chosen.profile, cycles=chosen.cycles) for name in chosen.scenario]
    gaps = distinct_gaps(bases[0], *GAPS_M) if chosen.gaps is None else chosen.gaps
    for aspect, gap in choices(bases[0], gaps, chosen.aspects):
        for base in bases if gap == bases[0]["packing.lattice_gap"] else bases[:1]:
            scenario = base.with_values({"packing.lattice_gap": gap, "clump.aspect": aspect})
            try:
                folder = f"aspect{scenario['clump.aspect']:g}-gap{1e3 * scenario['packing.lattice_gap']:g}mm"
                settings = RunSettings(
                    scenario,
                    chosen.code,
                    seed=chosen.seed,
                    results=chosen.results / CALIBRATION / folder,
                    cycles=chosen.cycles,
                    lines=True,
                )
                rows.append(row(scenario, load(settings, stop)))
            except Interrupted:
                print("calibrate: stopped; the same command goes on", file=sys.stderr)
                return 128 + stop.signal
            print(pd.DataFrame(rows[-1:]).to_string(index=False), flush=True)
    table = pd.DataFrame(rows, columns=kept_tables.CALIBRATION.columns)
    files.write_csv(chosen.out, [list(table.columns), *table.map(shortened).to_numpy().tolist()])
    print(f"written: {relative(chosen.out)}")
    return 0 if (table["state"] == "finished").all() else 1
