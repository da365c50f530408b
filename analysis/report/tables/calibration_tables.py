"""Beds that `make calibrate` tried, and what the law that holds the plates decides."""

from __future__ import annotations

import functools

import pandas as pd

from analysis.formats.numbers import plural
from analysis.report.labels import KPA, MM, short_name
from analysis.report.paper import paper
from analysis.report.style import CODE_NAMES
from analysis.report.tables.table_html import Shown, Table, between, frame_table, number, run_of, shown

BED = ["aspect", "lattice_gap_m"]
"""What tells one bed from another."""


def calibration_table(beds: pd.DataFrame, chosen: tuple[float, float]) -> Table | None:
    """One row per bed, with how far it settles under each contact model; `chosen` are the aspect and the gap (m) of the
    scenario file.
    """
    cycles, models, said = int(beds["cycles"].max()), list(dict.fromkeys(beds["scenario"])), paper().reported
    wide = beds.drop_duplicates(BED).sort_values(BED)
    settled = []
    for n, model in enumerate(models):
        loaded = beds[beds["scenario"] == model].drop_duplicates(BED).set_index(BED)
        loaded = loaded[["preload_settlement_m", "settlement_m", "cycles", "state"]].add_suffix(f"_{n}")
        wide = wide.join(loaded, on=BED)
        settled += [
            Shown(f"preload_settlement_m_{n}", f"preload, {short_name(model)}", like="preload_settlement_m"),
            Shown(
                f"settlement_m_{n}",
                f"{plural(cycles, 'cycle')}, {short_name(model)}",
                like="settlement_m",
                text=functools.partial(settlement, n, cycles),
            ),
        ]
    return frame_table(
        wide,
        f"Beds tried in {' and '.join(CODE_NAMES.get(code, code) for code in sorted(set(beds['code'])))}; the paper's "
        f"has {said.clumps} clumps at porosity {said.porosity}",
        [
            Shown("aspect", "aspect and gap", text=functools.partial(bed_name, chosen), number=False),
            "clumps",
            Shown("clumps_over_reported", digits=4),
            "porosity_mean",
            "coordination_number",
            *settled,
        ],
        f"From make calibrate, seed {', '.join(map(str, sorted(set(beds['seed']))))}. Settlement in preload, and "
        "after it.",
    )


def bed_name(chosen: tuple[float, float], row) -> str:
    """Aspect and gap of a bed, and whether the scenario file has it."""
    mark = " (chosen)" if (row.aspect, row.lattice_gap_m) == chosen else ""
    return f"{shown(row.aspect)}, {shown(row.lattice_gap_m * MM)} mm{mark}"


def settlement(model: int, cycles: int, row) -> str:
    """Settlement of one bed under the contact model of that number, or why it has none after that many cycles."""
    done = getattr(row, f"cycles_{model}")
    if done < cycles:
        return f"{getattr(row, f'state_{model}')} after {plural(int(done), 'cycle')}"
    return Shown(f"settlement_m_{model}", like="settlement_m").cell(row)


def plate_table(laws: pd.DataFrame) -> Table | None:
    """Runs under different laws of the plates after the same cycle, and the stress that the plates had up to it.

    laws   rows of `Findings.plate_laws` for one scenario and profile
    """
    if laws.empty:
        return None
    return frame_table(
        laws,
        f"Laws of the plates, {short_name(laws['scenario'].iloc[0])}, after "
        f"{plural(int(laws['cycle'].iloc[0]), 'cycle')}; the paper prescribes "
        f"{number(paper().plate_stress_Pa, 3, KPA)} kPa",
        [
            Shown("run", "run", text=run_of, number=False),
            "settlement_m",
            between("plate_moved_low_m", "plate_moved_high_m", "plates moved", digits=2),
            between("plate_mean_low_Pa", "plate_mean_high_Pa", "mean stress of each plate"),
            between("plate_low_Pa", "plate_high_Pa", "lowest and highest stress", digits=2, word=", "),
            Shown("settlement_rate_m", "settling in the last span", text=rate_and_span),
        ],
    )


def rate_and_span(row) -> str:
    """Settlement per cycle, and the cycles over which it is taken."""
    if row.settlement_rate_m != row.settlement_rate_m:
        return "–"
    span = f"(cycles {row.first_cycle:.0f} to {row.last_cycle:.0f})"
    return f"{Shown('settlement_rate_m').cell(row)} {span}"
