"""From single timings to the tables of the repository: medians and ratios."""

from __future__ import annotations

import math
import statistics
from collections import defaultdict
from pathlib import Path

from analysis.files import KEPT_RUNS, write_csv
from analysis.formats import kept_tables, toml_file
from analysis.formats.errors import InputError
from analysis.formats.kept_tables import BENCHMARK, BENCHMARK_SIZES, LAWS, TIMINGS, KeptTable
from analysis.formats.quantities import CODES

TABLE, SIZES, PROFILE = (KEPT_RUNS / f"{name}.csv" for name in ("benchmark", "benchmark_sizes", "benchmark_profile"))
BASELINE = KEPT_RUNS / "benchmark_baseline.toml"


def read_timings(path: Path) -> list[dict]:
    """All timings of a file, numbers as numbers; none without it. InputError where the file is damaged."""
    return rows_of(path, TIMINGS) if path.exists() else []


def rows_of(path: Path, table: KeptTable) -> list[dict]:
    """A kept table, row by row. InputError where it is damaged."""
    columns = kept_tables.read(path, table)
    return [dict(zip(columns, cells, strict=True)) for cells in zip(*columns.values(), strict=True)]


def speeds(timings: list[dict]) -> dict[tuple, tuple[float, float]]:
    """By code, law and who: median steps per processor second, and steps per cycle."""
    found = defaultdict(list)
    for row in timings:
        found[row["code"], row["law"], row["who"]].append(row)
    return {
        key: (statistics.median(r["steps"] / r["cpu_s"] for r in rows), rows[0]["steps_per_cycle"])
        for key, rows in found.items()
    }


def comparison(timings: list[dict], baseline: list[dict]) -> list[tuple]:
    """Rows of benchmark.csv.

    over_stock               ours over stock with the paper's step, in steps
    ours_paper_step          ours over the baseline, in cycles; the baseline's speed on this machine is what it was
    ours_verified_step       beside stock when it was recorded, times stock's speed here
    """
    measured, rows = speeds(timings), []
    recorded = {(row["code"], row["law"]): row["steps_per_cpu_s"] / row["stock_steps_per_cpu_s"] for row in baseline}
    for code, law in dict.fromkeys((row["code"], row["law"]) for row in timings):
        paper, verified, stock = (measured.get((code, law, who)) for who in ("paper", "verified", "stock"))
        if not paper or not stock:
            continue
        cycles = recorded[code, law] * stock[0] / paper[1] if (code, law) in recorded else math.nan
        for case, ours in (("ours_paper_step", paper), ("ours_verified_step", verified)):
            if ours and cycles == cycles:
                rows.append((case, code, law, round(ours[0], 1), round(ours[0] / ours[1] / cycles, 3)))
        rows.append(("over_stock", code, law, round(paper[0], 1), round(paper[0] / stock[0], 3)))
    return rows


def read_baseline() -> list[dict]:
    """Speeds of the commit that ours are compared with, recorded beside stock's: see the file.

    Raises InputError where the file is damaged.
    """
    rows = toml_file.read(BASELINE).get("speed")
    speeds = ("steps_per_cpu_s", "stock_steps_per_cpu_s")
    for row in rows if isinstance(rows, list) and rows else [None]:
        named = isinstance(row, dict) and row.get("code") in CODES and row.get("law") in LAWS
        if not named or not all(isinstance(row.get(k), float) and 0 < row[k] < math.inf for k in speeds):
            allowed = f"tables of code, law, {' and '.join(speeds)}; restore the file"
            raise InputError(BASELINE.name, "speed", row, allowed)
    return rows


def sizes(timings: list[dict]) -> list[tuple]:
    """Rows of benchmark_sizes.csv: medians by number of clumps and of ranks."""
    found = defaultdict(list)
    for row in timings:
        found[row["code"], row["law"], int(row["clumps"]), int(row["ranks"])].append(row)
    return [
        (
            *key,
            round(statistics.median(r["steps"] / r["cpu_s"] for r in rows), 1),
            round(statistics.median(r["steps"] / r["wall_s"] for r in rows), 1),
        )
        for key, rows in sorted(found.items())
    ]


def exponent(rows: list[tuple[float, float]]) -> float:
    """Least-squares slope of log speed over log clumps, of (clumps, speed); nan below two sizes."""
    if len({clumps for clumps, _ in rows}) < 2:
        return math.nan
    x, y = ([math.log(row[n]) for row in rows] for n in (0, 1))
    return statistics.linear_regression(x, y).slope


def write(timings_file: Path, size_timings_file: Path) -> list[tuple]:
    """Renew the tables of the repository from all timings; rows of the comparison."""
    rows = comparison(read_timings(timings_file), read_baseline())
    renew(TABLE, BENCHMARK, rows, key=("code", "law"))
    renew(SIZES, BENCHMARK_SIZES, sizes(read_timings(size_timings_file)), key=BENCHMARK_SIZES.key)
    return rows


def renew(path: Path, table: KeptTable, rows: list[tuple], key: tuple) -> None:
    """Write rows into a table in place of those with the same key; rows of what was not timed now stay.

    Raises InputError, and leaves the table as it is, where it is damaged.
    """
    if not rows:
        return
    places = [table.columns.index(name) for name in key]
    timed = {tuple(row[n] for n in places) for row in rows}
    kept = [tuple(row.values()) for row in rows_of(path, table)] if path.exists() else []
    others = [row for row in kept if tuple(row[n] for n in places) not in timed]
    in_order = sorted((*others, *rows), key=lambda row: [row[n] for n in places])  # stable within a key
    write_csv(path, [table.columns, *in_order])
