"""Calibrate the lattice gap: pack the full bed over a range of gaps and show clumps and porosity for each.

`make calibrate` packs `linear-mu0.8` with one code and writes report/calibration.csv. Copy the gap whose clump count is
nearest to the paper's 4583 into scenarios.toml by hand: a calibrated value is a decision, not a side effect.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

import pandas as pd

from analysis.driver.engines import CODES, command, versions, write_inputs
from analysis.files import ROOT
from analysis.normalised import beds
from analysis.normalised.microstructure import contact_measures
from analysis.normalised.porosity import MeasurementSpheres
from analysis.scenarios import derived, lattice
from analysis.scenarios.scenario import Scenario, load_scenario

REPORTED_CLUMPS, REPORTED_POROSITY = 4583, 0.35     # paper, Table 1


def distinct_gaps(scenario: Scenario, low_m: float, high_m: float, step_m: float = 1e-4) -> list[float]:
    """Largest gap (m) of each distinct number of lattice sites: the count is a step function of the gap."""
    gaps = {}
    for index in range(round((high_m - low_m) / step_m) + 1):
        gap = round(low_m + index * step_m, 7)
        gaps[lattice.site_count(scenario.replace("packing.lattice_gap", gap))] = gap
    return sorted(gaps.values())


def pack(scenario: Scenario, code: str, run_dir: Path, seed: int) -> Path:
    """Pack one bed in `run_dir`, unless it is packed already, and return its bed file."""
    bed = run_dir / "raw" / "bed_packed.csv"
    if bed.exists():
        return bed
    write_inputs(scenario, run_dir, seed)
    with open(run_dir / "log" / "packing.log", "w") as log:
        done = subprocess.run(command(code, "packing", run_dir), cwd=ROOT, stdout=log, stderr=subprocess.STDOUT)
    if done.returncode or not bed.exists():
        raise SystemExit(f"calibrate: packing failed; read log/packing.log in {run_dir.name}")
    return bed


def bed_statistics(path: Path, scenario: Scenario) -> dict[str, float]:
    """Clumps, porosity of the three spheres and their mean, contacts and overlaps of a packed bed."""
    clump, bed = derived.clump(scenario), beds.read_bed(path)
    centres = beds.sphere_centres(bed, clump.half_distance_m)
    porosities, _ = MeasurementSpheres(scenario).measure(centres)
    return {"clumps": len(bed), **{f"porosity_{n}": value for n, value in enumerate(porosities, start=1)},
            "porosity_mean": sum(porosities) / len(porosities),
            **contact_measures(centres, clump.radius_m, derived.apparatus(scenario))}


def main(argv: list[str] | None = None) -> int:
    """Command line of `make calibrate`."""
    parser = argparse.ArgumentParser(prog="python -m analysis calibrate", description=__doc__.split("\n\n")[0])
    parser.add_argument("--code", choices=CODES, default="liggghts")
    parser.add_argument("--scenario", default="linear-mu0.8")
    parser.add_argument("--profile", default="full")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--gaps", type=float, nargs="*", help="m; default: every distinct one from 13 to 15 mm")
    parser.add_argument("--results", type=Path, default=ROOT / "results")
    parser.add_argument("--out", type=Path, default=ROOT / "report" / "calibration.csv")
    options = parser.parse_args(argv)
    versions(options.code)

    base = load_scenario(options.scenario, options.profile)
    rows = []
    for gap in options.gaps or distinct_gaps(base, 0.013, 0.015):
        scenario = base.replace("packing.lattice_gap", gap)
        name = f"gap{gap * 1e3:.2f}mm-{options.code}-seed{options.seed}"
        run_dir = options.results / "calibration" / options.profile / options.scenario / name
        bed = pack(scenario, options.code, run_dir, options.seed)
        sites = lattice.site_count(scenario)
        statistics = bed_statistics(bed, scenario)
        expected = REPORTED_CLUMPS * scenario["geometry.width_scale"]
        rows.append({"code": options.code, "seed": options.seed, "lattice_gap_m": gap, "lattice_sites": sites,
                     **statistics, "clumps_over_reported": statistics["clumps"] / expected,
                     "porosity_reported": REPORTED_POROSITY})
        print(pd.DataFrame(rows[-1:]).to_string(index=False, header=len(rows) == 1), flush=True)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    pd.DataFrame(rows).to_csv(options.out, index=False)
    print(f"written: report/{options.out.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
