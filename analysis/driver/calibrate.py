"""Calibrate the packing: the full linear bed over a range of lattice gaps and clump aspects.

`make calibrate` packs, preloads and loads each bed for a few cycles and writes calibration.csv: clumps and porosity
beside the paper's, overlaps and contacts of the packed bed, and how far it settles. A bed that is too full is jammed by
the frictionless relaxation already and moves by micrometres. Each bed is an ordinary run below
results/calibration/, so that what is done is not done again. Copy the chosen values into scenarios.toml by hand:
a calibrated value is a decision, not a side effect.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import pandas as pd

from analysis import files
from analysis.driver import record
from analysis.driver.engines import CODES, versions
from analysis.driver.run import Run
from analysis.driver.supervise import Interrupted, RunError, StopRequest
from analysis.normalised.readers import Run as Result
from analysis.scenarios import lattice
from analysis.scenarios.scenario import SCENARIO_FILE, Scenario, load_scenario

REPORTED_CLUMPS, REPORTED_POROSITY = 4583, 0.35     # paper, Section 2 and Table 1
GAPS_M, STEP_M = (0.0133, 0.0150), 1e-4
STAGE_COLUMNS = {
    "packing": ("clumps", "porosity_1", "porosity_2", "porosity_3", "porosity_mean", "coordination_number",
                "overlap_mean_m", "overlap_max_ratio", "normal_force_mean_N"),
    "preload": ("settlement_m",),
}


def distinct_gaps(scenario: Scenario, low_m: float, high_m: float) -> list[float]:
    """Largest gap (m) of each distinct number of lattice sites: the count is a step function of the gap."""
    gaps = {}
    for index in range(round((high_m - low_m) / STEP_M) + 1):
        gap = round(low_m + index * STEP_M, 7)
        gaps[lattice.site_count(scenario.replace("packing.lattice_gap", gap))] = gap
    return sorted(gaps.values())


def load(scenario: Scenario, options: argparse.Namespace, stop: StopRequest) -> Result:
    """Run `scenario`, or what is missing of it, and read it back. Raises RunError where the engine fails."""
    folder = f"calibration/aspect{scenario['clump.aspect']:g}-gap{1e3 * scenario['packing.lattice_gap']:g}mm"
    run = Run(scenario, argparse.Namespace(**vars(options) | {"results": options.results / folder}), stop)
    run.go()
    return Result(run.folder)


def row(scenario: Scenario, result: Result) -> dict[str, float | str]:
    """What a calibration compares, of one run; values that a failed or unfinished run lacks are nan."""
    stages = result.stages
    clumps = stages.get("packing", {}).get("clumps", float("nan"))
    values = {
        "code": result.code,
        "seed": result.seed,
        "aspect": scenario["clump.aspect"],
        "lattice_gap_m": scenario["packing.lattice_gap"],
        "lattice_sites": lattice.site_count(scenario),
        "clumps_over_reported": clumps / (REPORTED_CLUMPS * scenario["geometry.width_scale"]),
    }
    for stage, names in STAGE_COLUMNS.items():
        for name in names:
            values[name if stage == "packing" else f"{stage}_{name}"] = stages.get(stage, {}).get(name, float("nan"))
    last = result.cycles.iloc[-1] if len(result.cycles) else {}
    values["cycles"] = len(result.cycles)
    for name in ("settlement_m", "settlement_peak_m", "lateral_3_m"):
        values[name] = last.get(name, float("nan"))
    return values


def main(argv: list[str] | None = None) -> int:
    """Command line of `make calibrate`."""
    parser = argparse.ArgumentParser(prog="python -m analysis calibrate", description=__doc__.split("\n\n")[0])
    parser.add_argument("--code", choices=CODES, default="liggghts")
    parser.add_argument("--scenario", default="linear-mu0.8")
    parser.add_argument("--profile", default="full")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--gaps", type=float, nargs="*", help="m; default: every distinct one from 13.3 to 15 mm")
    parser.add_argument("--aspects", type=float, nargs="*", help="default: that of the scenario file")
    parser.add_argument("--cycles", type=int, default=3)
    parser.add_argument("--results", type=Path, default=files.ROOT / "results")
    parser.add_argument("--out", type=Path, default=files.ROOT / "report" / "calibration.csv")
    options = parser.parse_args(argv)
    versions(options.code)
    options.results = options.results.resolve()
    options = argparse.Namespace(**vars(options), ranks=1, bed=None, until=None, scenarios=SCENARIO_FILE, progress="lines")

    stop, rows = StopRequest(), []
    base = load_scenario(options.scenario, options.profile, cycles=options.cycles)
    gaps = options.gaps or distinct_gaps(base, *GAPS_M)
    for aspect in options.aspects or [base["clump.aspect"]]:
        for gap in gaps:
            scenario = base.replace("packing.lattice_gap", gap).replace("clump.aspect", aspect)
            try:
                rows.append(row(scenario, load(scenario, options, stop)))
            except Interrupted:
                print("calibrate: stopped; the same command goes on", file=sys.stderr)
                return 128 + stop.signal
            except RunError as error:
                print(error, file=sys.stderr)
                continue
            files.write_csv(options.out, [list(rows[0]), *(list(r.values()) for r in rows)])
            print(pd.DataFrame(rows[-1:]).to_string(index=False), flush=True)
    print(f"written: {record.relative(options.out)}")
    return 0 if rows else 1


if __name__ == "__main__":
    sys.exit(main())
