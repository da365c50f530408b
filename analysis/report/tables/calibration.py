"""Beds that `make calibrate` tried, and what the law that holds the plates decides."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from analysis.comparison import quantities
from analysis.formats import file_columns
from analysis.formats.numbers import plural
from analysis.formats.quantities import row_of
from analysis.normalised.readers import Run
from analysis.report.labels import KPA, MM, short_name
from analysis.report.paper import paper
from analysis.report.report_data import name_of
from analysis.report.style import CODE_NAMES
from analysis.report.tables.base import Column, Table, heading_of, number, shown


def calibration_table(beds: pd.DataFrame, chosen: tuple[float, float]) -> Table:
    """One row per bed, with how far it settles under each contact model; `chosen` are the aspect and the gap (m) of the
    scenario file.
    """
    cycles, models = int(beds["cycles"].max()), list(dict.fromkeys(beds["scenario"]))
    names, said = sorted(set(beds["code"])), paper().reported
    settled = [f"{what}, {short_name(model)}, mm" for model in models for what in ("preload", plural(cycles, "cycle"))]
    packed = ["clumps", "of the paper's, %", "mean porosity", heading_of("coordination_number")]
    return Table(
        f"Beds tried in {' and '.join(CODE_NAMES.get(code, code) for code in names)}; the paper's has {said.clumps} "
        f"clumps at porosity {said.porosity}",
        [Column("aspect and gap"), *(Column(name, True) for name in (*packed, *settled))],
        [
            bed_cells(bed, (aspect, gap) == chosen) + settled_cells(bed, models, cycles)
            for (aspect, gap), bed in beds.groupby(["aspect", "lattice_gap_m"])
        ],
        f"From make calibrate, seed {', '.join(map(str, sorted(set(beds['seed']))))}. Settlement in preload, and "
        "after it.",
    )


def bed_cells(bed: pd.DataFrame, chosen: bool) -> list[str]:
    """What one bed is, and what packing made of it."""
    first = bed.iloc[0]
    return [
        f"{shown(first['aspect'])}, {shown(first['lattice_gap_m'] * MM)} mm" + (" (chosen)" if chosen else ""),
        number(first["clumps"], 4),
        number(100 * first["clumps_over_reported"], 4),
        number(first["porosity_mean"], 3),
        number(first["coordination_number"], 3),
    ]


def settled_cells(bed: pd.DataFrame, models: Sequence[str], cycles: int) -> list[str]:
    """Settlement of one bed in preload and after it, for each contact model."""
    cells = []
    for model in models:
        loaded = bed[bed["scenario"] == model]
        if loaded.empty:
            cells += ["–", "–"]
            continue
        last = loaded.iloc[0]
        settled = number(last["settlement_m"], 3, MM)
        if last["cycles"] < cycles:
            settled = f"{last['state']} after {plural(last['cycles'], 'cycle')}"
        cells += [number(last["preload_settlement_m"], 3, MM), settled]
    return cells


def plate_table(runs: Sequence[Run], cycle: int) -> Table:
    """Runs under different laws of the plates after the same cycle, and the stress that the plates had up to it."""
    numbers = ("settlement, mm", "plates moved, mm", "mean stress of each plate, kPa", "lowest and highest stress, kPa")
    return Table(
        f"Laws of the plates, after {plural(cycle, 'cycle')}; the paper prescribes "
        f"{number(paper().plate_stress_Pa, 3, KPA)} kPa",
        [Column("run"), *(Column(name, True) for name in (*numbers, "settling in the last span, µm per cycle"))],
        [plate_cells(run, cycle) for run in runs],
    )


def plate_cells(run: Run, cycle: int) -> list[str]:
    """One run under a law of the plates."""
    row = run.cycles.set_index("cycle").loc[cycle]
    moved = row[[f"lateral_{k}_m" for k in file_columns.PLATES]]
    stresses = run.plate_stresses[run.plate_stresses["cycle"] <= cycle]
    means = extremes = "–"
    if len(stresses):
        each = stresses[list(row_of("plate_{}_stress_mean_Pa"))].mean()
        means = f"{number(each.min(), 3, KPA)} to {number(each.max(), 3, KPA)}"
        least, most = stresses["plate_stress_min_Pa"].min(), stresses["plate_stress_max_Pa"].max()
        extremes = f"{number(least, 2, KPA)}, {number(most, 2, KPA)}"
    plates = f"{number(moved.min(), 2, MM)} to {number(moved.max(), 2, MM)}"
    return [name_of(run), number(row["settlement_m"], 3, MM), plates, means, extremes, last_rate(run, cycle)]


def last_rate(run: Run, cycle: int) -> str:
    """Settling in the last span of cycles that ends by `cycle`, µm per cycle."""
    rates = quantities.settling_rates(run)
    rates = rates[rates["last_cycle"] <= cycle]
    if rates.empty:
        return "–"
    last = rates.iloc[-1]
    span = f"cycles {last['first_cycle']:.0f} to {last['last_cycle']:.0f}"
    return f"{number(last['settlement_rate_m'], 3, 1e6)} ({span})"
