"""From raw engine output to the normalised files of a run, cycle by cycle while the engine runs.

The driver alone calls this. Everything written is a function of the raw files only, so that a repeated or resumed run
gives the same files bit for bit. A kill at any moment is harmless: cycles.csv is written last in a cycle and says what
is done; `rewind` cuts the other tables back to it.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from analysis import files
from analysis.formats import file_columns, numbers
from analysis.formats.growing_csv import CycleTable, Row, RowsByStep
from analysis.normalised import beds, bonds, microstructure, porosity, stages
from analysis.scenarios import derived

PLATE_PLACES = tuple(f"plate_{k}_displacement_m" for k in file_columns.PLATES)


class NormaliseError(ValueError):
    """Raw output that is missing or unusable; the message is one line naming file and remedy."""


class Normaliser:
    """Writes the normalised files of one run folder.

    `loading` and `state` are the rows of raw/cyclic.csv and raw/state.csv that it has read so far.

    normaliser = Normaliser(run_dir, scenario)
    normaliser.before()                 # when preload has ended
    normaliser.rewind(n)                # when cyclic loading starts from the checkpoint after n cycles (also n = 0)
    if normaliser.ready(n):             # the engine has written all that belongs to cycle n
        row = normaliser.cycle(n)       # in turn, n = 1, 2, ...; the new row of cycles.csv as a dict
    normaliser.finish()                 # when the engine has ended, for whatever reason
    """

    def __init__(self, run_dir, scenario):
        self.folder, self.scenario = Path(run_dir), scenario
        self._raw = self.folder / "raw"
        self._grid, self._box = derived.time_grid(scenario), derived.apparatus(scenario)
        self._clump = derived.clump(scenario)
        self._cycles = CycleTable(self.folder / "cycles.csv", file_columns.CYCLES)
        self._history = CycleTable(self.folder / "history.csv", file_columns.HISTORY, numbers.short)
        self._microstructure = CycleTable(
            self.folder / "microstructure.csv", file_columns.MICROSTRUCTURE, numbers.short
        )
        self.loading = RowsByStep(self._raw / "cyclic.csv", file_columns.RAW_LOADING)
        self.state = RowsByStep(self._raw / "state.csv", file_columns.RAW_STATE, stage="cyclic")
        self._spheres = self._first_bed = self._done = None

    # ------------------------------------------------------------------ what the driver calls

    def before(self) -> None:
        """Write bed_before.csv, stages.json, row 0 of microstructure.csv; start the tables anew if the bed changed."""
        self._begin(math.inf)

    def ready(self, number: int) -> bool:
        """True when the engine has written everything that belongs to cycle `number`."""
        step = number * self._grid.steps_per_cycle
        return (
            self._bed(number).exists()
            and (not self._keeps(number) or self._contacts(number).exists())
            and step in self._update(self.loading)
            and step in self._update(self.state)
        )

    def cycle(self, number: int) -> dict[str, float]:
        """Add cycle `number` to history.csv, microstructure.csv and cycles.csv; return the row of the latter.

        A cycle that was done before is done again, and later ones are dropped. Deletes the bed of the cycle before,
        unless kept.
        """
        if self._done is None or number <= self._done:
            self._begin(number - 1)
        if number != self._done + 1:
            raise NormaliseError(
                f"cycles.csv: cycle {number} cannot follow cycle {self._done}; call rewind({number - 1}) first"
            )
        rows, zero = self._rows(number), self._numbers(self._row(0))
        places = [rows[-1][name] for name in PLATE_PLACES]
        lateral = [rows[-1][name] - zero[name] for name in PLATE_PLACES]
        bed = self._read(beds.read_bed, self._bed(number))
        structure = self._microstructure_row(
            number, bed, rows[-1]["sleeper_displacement_m"], places, lateral, self._state_row(number)
        )
        row = self._cycle_row(number, rows, zero, lateral, structure) | {"clumps": len(bed)}

        self._append_history([number])
        self._microstructure.append([structure])
        self._cycles.append([[row[name] for name in file_columns.CYCLES]])
        self._done = number
        self.loading.drop_until(number * self._grid.steps_per_cycle, but=0)
        self.state.drop_until(number * self._grid.steps_per_cycle)
        if number > 1 and not self._keeps(number - 1):
            self._bed(number - 1).unlink(missing_ok=True)
        return row

    def rewind(self, last: int) -> None:
        """Go back to the end of cycle `last`: drop later rows, beds, contacts, bonds; the engine will write them again.

        Rows of raw/cyclic.csv and raw/state.csv may stay or be cut: a step that is there twice counts as last written.
        """
        self._begin(last)
        for path in (path for kind in ("bed", "contacts", "bonds") for path in self._raw.glob(f"{kind}_cycle_*.csv")):
            number = path.stem.rpartition("_")[2]
            later = number.isdigit() and int(number) > last
            spent = (
                number.isdigit()
                and path.name.startswith("bed")
                and int(number) < self._done
                and not self._keeps(int(number))
            )
            if later or spent:
                path.unlink()

    def finish(self) -> None:
        """Write bed_after.csv, the bed after the last cycle done, if there is one; repair what a kill tore."""
        if not (self._raw / "bed_preloaded.csv").exists():
            return
        if self._done is None:
            self._begin(math.inf)
        if self._done > 0 and self._bed(self._done).exists():
            files.write_aside(self.folder / "bed_after.csv", self._bed(self._done).read_text())
        bonds.write(self.folder, self.scenario, self._done)

    def _begin(self, n: float) -> None:
        """Make the tables end with cycle `n`, or with the last cycle done where that comes first."""
        self.loading.forget()
        self.state.forget()
        source, target = self._raw / "bed_preloaded.csv", self.folder / "bed_before.csv"
        self._first_bed = self._read(beds.read_bed, source)
        text = source.read_text()
        same = target.exists() and target.read_text() == text
        self._cycles.rewind(n if same else -1)
        self._done = self._cycles.last_cycle() or 0
        self._microstructure.rewind(self._done if same else -1)
        self._history.rewind(self._done if same else -1)
        if not same:
            files.write_aside(target, text)
        without_stages = not same or not (self.folder / stages.FILE).exists()
        without_start = self._microstructure.last_cycle() is None
        if without_stages or without_start:
            sleeper_down, plates_out = self._preloaded_places()
        if without_stages:
            moved = {
                "settlement_m": sleeper_down,
                **{f"lateral_{k}_m": v for k, v in zip(file_columns.PLATES, plates_out, strict=True)},
            }
            stages.write_stages(self.folder, self.scenario, moved, self._measurement_spheres())
        if without_start:
            self._microstructure.append(
                [self._microstructure_row(0, self._first_bed, sleeper_down, plates_out, [0.0] * 5, {})]
            )
        if self._done == 0 or self._history.last_cycle() != self._done:
            self._history.rewind(-1)
            self._append_history(range(1, self._done + 1))

    # ------------------------------------------------------------------ raw files

    def _bed(self, n: int) -> Path:
        return self._raw / f"bed_cycle_{n:06d}.csv"

    def _contacts(self, n: int) -> Path:
        return self._raw / ("contacts_preloaded.csv" if n == 0 else f"contacts_cycle_{n:06d}.csv")

    def _keeps(self, n: int) -> bool:
        return n in self.scenario["output.keep_beds"] or n == self.scenario["loading.cycles"]

    def _read(self, reader, path: Path):
        try:
            return reader(path)
        except ValueError as error:
            raise NormaliseError(f"raw/{error}") from None

    @staticmethod
    def _update(growing: RowsByStep) -> dict[int, Row]:
        try:
            return growing.update()
        except ValueError as error:
            raise NormaliseError(f"raw/{error}") from None

    def _row(self, step: int) -> Row:
        rows = self.loading.rows if step in self.loading.rows else self._update(self.loading)
        if step not in rows:
            raise NormaliseError(
                f"raw/cyclic.csv: the row of step {step} is missing; go back to the checkpoint before it"
            )
        return rows[step]

    def _numbers(self, row: Row) -> dict[str, float]:
        try:
            numbers = {name: float(cell) for name, cell in row.items()}
        except ValueError:
            numbers = {}
        if not numbers or not all(map(math.isfinite, numbers.values())):
            raise NormaliseError(
                f"raw/cyclic.csv: a value of step {row['step']} is no number; "
                "the engine diverged or the file is damaged"
            )
        return numbers

    def _rows(self, n: int) -> list[dict[str, float]]:
        """The rows of cycle `n`, from the first after its beginning to its end at minimum load."""
        end, spacing = n * self._grid.steps_per_cycle, self._grid.steps_per_row
        self._row(end)
        return [
            self._numbers(self._row(step))
            for step in range(end - self._grid.steps_per_cycle + spacing, end + 1, spacing)
        ]

    def _state_row(self, n: int) -> dict[str, float]:
        step = n * self._grid.steps_per_cycle
        row = self._update(self.state).get(step)
        if row is None:
            raise NormaliseError(
                f"raw/state.csv: the row of step {step} of stage cyclic is missing; go back to the checkpoint before it"
            )
        try:
            return {name: float(row[name] or "nan") for name in file_columns.RAW_STATE[1:]}
        except ValueError as error:
            raise NormaliseError(f"raw/state.csv: step {step} of stage cyclic: {error}") from None

    def _preloaded_places(self) -> tuple[float, list[float]]:
        """Where sleeper (down, m) and plates (out, m) stand at the end of preload, since its start."""
        rows = self._update(RowsByStep(self._raw / "preload.csv", file_columns.RAW_LOADING))
        if not rows:
            raise NormaliseError("raw/preload.csv: has no rows; run the preload stage again")
        last = self._numbers(rows[max(rows)])
        return last["sleeper_displacement_m"], [last[name] for name in PLATE_PLACES]

    # ------------------------------------------------------------------ rows of the normalised tables

    def _cycle_row(self, number: int, rows, zero, lateral, structure) -> dict[str, float]:
        """A row of cycles.csv but for its clumps, from the raw rows of the cycle and the one before loading (`zero`),
        the plates' ways (m) and the row of microstructure.csv.
        """
        start, mean_stress = zero["sleeper_displacement_m"], [row["sleeper_stress_mean_Pa"] for row in rows]
        return {
            "cycle": number,
            "time_s": rows[-1]["time_s"],
            "settlement_m": rows[-1]["sleeper_displacement_m"] - start,
            "settlement_peak_m": rows[len(rows) // 2 - 1]["sleeper_displacement_m"] - start,
            **{f"lateral_{k}_m": value for k, value in zip(file_columns.PLATES, lateral, strict=True)},
            **{f"porosity_{k}": value for k, value in zip(file_columns.SPHERES, structure[1:4], strict=True)},
            "sleeper_stress_min_Pa": min(mean_stress),
            "sleeper_stress_max_Pa": max(mean_stress),
            "tracking_rms_Pa": math.sqrt(sum(row["sleeper_error_ms_Pa2"] for row in rows) / len(rows)),
        }

    def _append_history(self, cycles) -> None:
        zero = self._numbers(self._row(0)) if cycles else {}
        self._history.append(
            [self._history_row(raw, zero) for n in cycles for raw in ([zero] if n == 1 else []) + self._rows(n)]
        )

    def _history_row(self, raw: dict[str, float], zero: dict[str, float]) -> list[float]:
        return [
            raw["time_s"],
            raw["step"] / self._grid.steps_per_cycle,
            raw["sleeper_target_Pa"],
            raw["sleeper_stress_Pa"],
            raw["sleeper_displacement_m"] - zero["sleeper_displacement_m"],
            self.scenario["preload.plate_stress"],
            *(raw[f"plate_{k}_stress_Pa"] for k in file_columns.PLATES),
            *(raw[name] - zero[name] for name in PLATE_PLACES),
        ]

    def _measurement_spheres(self) -> porosity.MeasurementSpheres:
        if self._spheres is None:
            self._spheres = porosity.MeasurementSpheres(self.scenario)
        return self._spheres

    def _microstructure_row(self, n, bed, sleeper_down, plates_out, lateral, state) -> list[float]:
        centres = beds.sphere_centres(bed, self._clump.half_distance_m)
        porosities, error = self._measurement_spheres().measure(centres, sleeper_down, plates_out)
        values = {
            "cycle": n,
            **{f"porosity_{k}": v for k, v in zip(file_columns.SPHERES, porosities, strict=True)},
            "porosity_error": error,
            "bulge_volume_m3": microstructure.bulge_volume(lateral, self._box),
            **microstructure.contact_measures(centres, self._clump.radius_m, self._box, sleeper_down, plates_out),
            "sleeper_contacts": microstructure.sleeper_contacts(centres, self._clump.radius_m, self._box, sleeper_down),
            **microstructure.motion_measures(self._first_bed, bed, self._box, self.scenario["clump.ball_radius"]),
            **{
                name: state[name]
                for name in ("sliding_share", "at_limit_share", "kinetic_energy_J", "unbalanced_ratio")
                if name in state
            },
        }
        if self._contacts(n).exists():
            contacts = self._read(microstructure.read_contacts, self._contacts(n))
            values.update(microstructure.force_measures(contacts))
            if not values.get("sliding_share", np.nan) >= 0:
                values["sliding_share"] = microstructure.sliding_share(contacts)
        return [values.get(name, np.nan) for name in file_columns.MICROSTRUCTURE]
