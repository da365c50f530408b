"""`make unload`: how much of a run's settlement springs back when its load is taken slowly to the least stress.

A copy of the run's last state is unloaded; the run itself stays as it is. Each call adds the row of the cycle that the
run has reached: run 1 cycle, unload, run on to 10, unload, and so on.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver import options
from analysis.driver.checkpoints import listed
from analysis.driver.engines import ENGINES
from analysis.driver.process import EngineProcess
from analysis.files import write_aside, write_csv
from analysis.formats import table_file
from analysis.formats.file_columns import RAW_LOADING, UNLOAD
from analysis.normalised.readers import UNLOADED
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario

STAGE = "unload"
RAMP_TIME_S, REST_TIME_S = 0.2, 0.1
"""Four periods of the load, so that the servo follows, and two more for the bed to come to rest."""
MEAN_OF = 16
"""Rows at the end whose mean counts."""


class UnloadError(ValueError):
    """A run that cannot be unloaded; the message is one line with the remedy."""


def unload(folder: Path, code: str, seed: int) -> dict[str, float]:
    """Unload a copy of the last state of the run in `folder`; return a row of columns UNLOAD.

    Raises UnloadError for a run without a checkpoint at the end of a cycle, or whose engine failed.
    """
    if STAGE not in ENGINES[code].stages:
        able = " or ".join(f"CODE={name}" for name, engine in ENGINES.items() if STAGE in engine.stages)
        raise UnloadError(f"{folder}: {code} has no stage that unloads; give {able}")
    if not (folder / "scenario.json").exists():
        raise UnloadError(f"{folder}: there is no run; run the scenario first")
    scenario = Scenario.from_json((folder / "scenario.json").read_text())
    grid = derived.time_grid(scenario)
    whole = [c for c in listed(folder / "checkpoints") if c.cycle and not c.block and c.is_good()]
    if not whole:
        raise UnloadError(f"{folder}/checkpoints: hold no end of a cycle; run the scenario to a whole cycle first")
    last = whole[-1]
    with tempfile.TemporaryDirectory(prefix="unload-") as name:
        copy = Path(name)
        ENGINES[code].write_inputs(scenario, copy, seed)
        times = {"unload_ramp_time": RAMP_TIME_S, "unload_rest_time": REST_TIME_S}
        lines = [f"variable {key} index {value!r}" for key, value in times.items()]
        write_aside(copy / "parameters.in", "\n".join([(copy / "parameters.in").read_text(), *lines, ""]))
        process = EngineProcess(ENGINES[code].command(STAGE, copy, last.path.resolve()), copy / "log" / "unload.log")
        if process.wait(3600) != 0:
            process.kill()
            errors = [line for line in process.last_output().splitlines() if "ERROR" in line]
            raise UnloadError(f"{folder}: unloading failed: {errors[0] if errors else 'no end after an hour'}")
        rows = _loading_rows(copy / "raw" / "unload.csv")
    loading = _loading_rows(folder / "raw" / "cyclic.csv", last.step(grid))
    before, zero = loading[-1], loading[0]["sleeper_displacement_m"]
    return {
        "cycle": last.cycle,
        "stress_before_Pa": before["sleeper_stress_mean_Pa"],
        "settlement_before_m": before["sleeper_displacement_m"] - zero,
        "stress_after_Pa": _mean(rows[-MEAN_OF:], "sleeper_stress_mean_Pa"),
        "settlement_after_m": _mean(rows[-MEAN_OF:], "sleeper_displacement_m") - zero,
    }


def add_row(path: Path, row: dict[str, float]) -> None:
    """Put a row of columns UNLOAD into a table, in place of one of the same cycle; InputError where it is damaged."""
    rows = {old["cycle"]: old for old in _rows(path, UNLOAD, False)} if path.exists() else {}
    rows[row["cycle"]] = row
    write_csv(path, [UNLOAD, *([int(n), *(rows[n][key] for key in UNLOAD[1:])] for n in sorted(rows))])


def _rows(path: Path, columns: tuple[str, ...], whole: bool | None) -> list[dict[str, float]]:
    table = table_file.read(path, columns, whole)
    return [dict(zip(columns, values, strict=True)) for values in zip(*table.values(), strict=True)]


def _mean(rows: list[dict[str, float]], column: str) -> float:
    return sum(row[column] for row in rows) / len(rows)


def _loading_rows(path: Path, until: int | None = None) -> list[dict[str, float]]:
    found = [row for row in _rows(path, RAW_LOADING, None) if until is None or row["step"] <= until]
    if not found:
        raise UnloadError(f"{path}: holds no rows of loads; run the scenario again")
    return found


def add_arguments(parser: Parser) -> None:
    """Arguments of `ballast unload`."""
    options.add_identity(parser)


def execute(chosen: argparse.Namespace) -> int:
    """`ballast unload`."""
    folder = options.folder(chosen)
    try:
        if (folder / UNLOADED).exists():
            table_file.read(folder / UNLOADED, UNLOAD, False)  # before the work of an hour
        row = unload(folder, chosen.code, chosen.seed)
        add_row(folder / UNLOADED, row)
    except (ValueError, OSError) as error:
        print(f"unload: {error}", file=sys.stderr)
        return 1
    deep, back = row["settlement_before_m"], row["settlement_before_m"] - row["settlement_after_m"]
    print(
        f"{folder}: after cycle {row['cycle']} {deep * 1e3:.3f} mm at {row['stress_before_Pa'] / 1e3:.0f} kPa, "
        f"of which {back * 1e3:.3f} mm spring back at {row['stress_after_Pa'] / 1e3:.0f} kPa"
    )
    return 0
