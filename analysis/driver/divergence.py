"""Signs that a simulation has left the physical: the same limits for both codes, checked while it runs."""

from __future__ import annotations

import math
from collections.abc import Iterable

from analysis.formats.growing_csv import Row
from analysis.scenarios import derived

LOAD_REACHED = 0.5
"""Least peak of a cycle's sleeper stress over its target; below it the cycle did not load the bed. Under PFC's servo
that is a result, which the report and `make status` show: the servo cannot follow 20 Hz on a soft bed.
"""


class Diverged(RuntimeError):
    """The run must stop; the message says which limit was passed, with values."""


class Watch:
    """Feed it the rows of raw/state.csv and of the stage's own CSV file, in order; it raises Diverged."""

    def __init__(self, scenario, stage: str, last_step: int | None = None, clumps: int | None = None):
        """`last_step`: step of the last row that was written before a resume; None at the start of a stage.

        `clumps`: how many the bed must keep, as after preload nothing removes any; None while beds are made.
        """
        self.scenario, self.stage, self._last_step, self._clumps = scenario, stage, last_step, clumps
        self._grid = derived.time_grid(scenario)
        self._peaks: list[float] = []

    def state(self, row: Row) -> None:
        """Check one row of raw/state.csv."""
        values = self._numbers(row, "state", ("step", "kinetic_energy_J", "overlap_max_ratio"))  # shares may be unknown
        energy, limit = values["kinetic_energy_J"], self.scenario["limits.kinetic_energy"]
        if energy > limit:
            raise Diverged(
                f"kinetic energy {energy:.3g} J per clump at step {row['step']} of {row['stage']}, "
                f"limit {limit:g} J (limits.kinetic_energy)"
            )
        self._check_clumps(row)
        overlap, limit = values["overlap_max_ratio"], self.scenario["limits.overlap_ratio"]
        if overlap > limit and row["stage"] != "packing":  # packing starts with clumps that were grown into each other
            raise Diverged(
                f"overlap of {overlap:.3g} sphere radii at step {row['step']} of {row['stage']}, "
                f"limit {limit:g} (limits.overlap_ratio)"
            )

    def _check_clumps(self, row: Row) -> None:
        if self._clumps is None:
            return
        left = self._clumps - self._numbers(row, "state", ("clumps",))["clumps"]
        if left:
            raise Diverged(
                f"{left:.0f} of {self._clumps} clumps left the simulated space before step {row['step']} of "
                f"{row['stage']}: what is left is not the bed any more"
            )

    def load(self, row: Row) -> None:
        """Check one row of raw/preload.csv or raw/cyclic.csv."""
        values = self._numbers(row, self.stage, row)
        step, down = int(values["step"]), values["sleeper_displacement_m"]
        base, height = self.scenario["geometry.sleeper_base"], self.scenario["geometry.sleeper_height"]
        if down >= base:
            raise Diverged(f"sleeper through the floor: {down:.3g} m down at step {step} of {self.stage}")
        if down <= -height:
            raise Diverged(f"sleeper thrown out of the bed: {-down:.3g} m up at step {step} of {self.stage}")
        self._check_order(step)
        if self.stage == "cyclic":
            self._check_cycle(step, values["sleeper_stress_mean_Pa"])

    def _numbers(self, row: Row, name: str, columns: Iterable[str]) -> dict[str, float]:
        values = {}
        for column in columns:
            text = row.get(column, "missing")
            try:
                values[column] = float(text)
            except ValueError:
                raise Diverged(f"raw/{name}.csv: {column} is {text!r}, step {row.get('step')}") from None
            if not math.isfinite(values[column]):
                raise Diverged(f"{column} is {text} at step {row.get('step')} of {row.get('stage', self.stage)}")
        return values

    def _check_order(self, step: int) -> None:
        """Rows must follow each other without gap or duplicate, also where a run went on after an interruption."""
        last, self._last_step = self._last_step, step
        first = 0 if self.stage == "cyclic" else step
        expected = first if last is None else last + self._grid.steps_per_row
        if step != expected:
            raise Diverged(f"raw/{self.stage}.csv: row of step {step} where {expected} was due")

    def _check_cycle(self, step: int, stress: float) -> None:
        self._peaks.append(stress)
        if step == 0 or step % self._grid.steps_per_cycle:
            return
        peaks, self._peaks = self._peaks, []
        target = self.scenario["loading.stress_max"]
        if self.scenario["load_control.sleeper_law"] == "pfc":
            return
        if len(peaks) >= self.scenario["output.rows_per_cycle"] and max(peaks) < LOAD_REACHED * target:
            raise Diverged(
                f"load not reached: at most {max(peaks) / 1e3:.0f} kPa on the sleeper in cycle "
                f"{step // self._grid.steps_per_cycle}, target {target / 1e3:.0f} kPa"
            )
