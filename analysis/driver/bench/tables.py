"""From single timings to the tables of the repository: medians and ratios."""

from __future__ import annotations

import csv
import math
import statistics
from collections import defaultdict
from pathlib import Path

from analysis.files import KEPT_RUNS, write_csv
from analysis.formats import toml_file

TABLE, SIZES, PROFILE = (KEPT_RUNS / f"{name}.csv" for name in ("benchmark", "benchmark_sizes", "benchmark_profile"))
BASELINE = KEPT_RUNS / "benchmark_baseline.toml"
TIMINGS = ("code", "law", "who", "clumps", "ranks", "steps", "steps_per_cycle", "cpu_s", "wall_s", "load_average")
COLUMNS = ("case", "code", "law", "steps_per_cpu_s", "ratio")
SIZE_COLUMNS = ("code", "law", "clumps", "ranks", "steps_per_cpu_s", "steps_per_wall_s")


def read_timings(path: Path) -> list[dict]:
    """All timings of a file, numbers as numbers; none without it."""
    if not path.exists():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return [{k: v if k in TIMINGS[:3] else float(v or "nan") for k, v in row.items()} for row in rows]


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
    """Speeds of the commit that ours are compared with, recorded beside stock's: see the file."""
    return toml_file.read(BASELINE)["speed"]


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
    renew(TABLE, COLUMNS, rows, key=("code", "law"))
    renew(SIZES, SIZE_COLUMNS, sizes(read_timings(size_timings_file)), key=("code", "law", "clumps", "ranks"))
    return rows


def renew(table: Path, columns: tuple, rows: list[tuple], key: tuple) -> None:
    """Write rows into a table in place of those with the same key; rows of what was not timed now stay."""
    if not rows:
        return
    places = [columns.index(name) for name in key]
    timed = {tuple(str(row[n]) for n in places) for row in rows}
    kept = []
    if table.exists():
        with open(table, newline="", encoding="utf-8") as file:
            kept = [tuple(row[name] for name in columns) for row in csv.DictReader(file)]
    others = [row for row in kept if tuple(row[n] for n in places) not in timed]
    in_order = sorted((*others, *rows), key=lambda row: [_number(row[n]) for n in places])  # stable within a key
    write_csv(table, [columns, *in_order])


def _number(cell) -> tuple:
    """Sorts names before numbers, and numbers by size."""
    try:
        return (1, float(cell))
    except ValueError:
        return (0, cell)
