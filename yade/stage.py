"""What the three stages share: arguments, the clock, blocks of steps, stop requests, errors, checkpoints.

A stage advances in blocks of steps. After each block it appends a row to raw/state.csv and looks for a stop request
(SIGTERM, SIGINT), which ends it with exit code 75.
"""

import faulthandler
import gzip
import json
import os
import signal
import sys
import traceback
import zlib
from pathlib import Path

from yade.wrapper import Omega

from analysis.formats.errors import InputError
from analysis.formats.growing_csv import GrowingCsv, Row
from analysis.formats.run_record import STAGES
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario
from load_control import LoadControl
from state import StateRow, start_state_file, write_state
from temporary import remove_own_folder

O = Omega()
STOPPED = 75
"""Exit code of a stage that ended at a stop request."""
CHECKPOINT_BYTES_PER_CLUMP = 4000
"""More than a checkpoint needs; compressed it takes 1.0 to 1.7 kB per clump."""
SAVE_TIME_LIMIT_S = 600
"""Real time after which YADE is taken to be stuck in writing a checkpoint."""


class StageError(RuntimeError):
    """A stage that cannot go on; the message is the one line that the user reads."""


class Clock:
    """Steps since the start of the stage: YADE's own count, which runs on from stage to stage, less its value then."""

    def __init__(self):
        self.start()

    def start(self, step: int = 0) -> None:
        """The present moment is this step of the stage."""
        self._start = O.iter - step

    @property
    def step(self) -> int:
        """Complete steps of the stage."""
        return O.iter - self._start


class Stage:
    """One stage of one run.

    name -- packing, preload or cyclic
    folder -- of the run, which holds scenario.json and raw/
    scenario, grid, box -- the parameters, the time grid and the apparatus that follow from them
    model -- contact law of the stage: packing always uses the linear one
    clock -- steps since the start of the stage
    bed, control, bonds -- clumps, loads and bonds, where the stage has them
    """

    def __init__(self, name: str, folder: Path):
        self.name, self.folder, self.clock = name, folder, Clock()
        self.bed = self.control = self.bonds = None
        self.scenario = Scenario.from_json((folder / "scenario.json").read_text())
        self.grid = derived.time_grid(self.scenario)
        self.box = derived.apparatus(self.scenario)
        self.model = "linear" if name == "packing" else self.scenario["contact.model"]
        self._stop = False
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, self._request_stop)
        (folder / "raw").mkdir(exist_ok=True)
        (folder / "checkpoints").mkdir(exist_ok=True)
        remove_own_folder()

    def _request_stop(self, *_) -> None:
        self._stop = True

    @property
    def stop_requested(self) -> bool:
        """True once SIGTERM or SIGINT has arrived."""
        return self._stop

    def raw(self, name: str) -> Path:
        """Path of a raw file of the run."""
        return self.folder / "raw" / name

    def advance_block(self, steps: int) -> StateRow:
        """Run one block of `steps` steps, write its rows and return its state."""
        O.run(steps, True)
        if self.control:
            self.control.write_rows()
        row = StateRow.measure(self.bed, self.model, self.gravity)
        if not row.kinetic_energy_J < float("inf"):
            raise StageError(
                f"{self.name}: the kinetic energy is {row.kinetic_energy_J} J after step {self.clock.step}: the "
                "run diverged; a smaller time.step is the usual remedy"
            )
        # The rows of the cyclic stage start with step 0, so the last of them is of the step before the count.
        step, time = self.clock.step, O.time
        if self.name == "cyclic":
            step, time = step - 1, (step - 1) * self.grid.step_s
        write_state(self.raw("state.csv"), row, self.name, step, time)
        return row

    def advance(self, steps: int, block: int) -> StateRow:
        """Run `steps` steps in blocks of `block`; the last one has what is left.

        A stop request ends the program at the end of a block: packing and preload start over.
        """
        left = steps
        while left > 0:
            row = self.advance_block(min(left, block))
            left -= block
            if self._stop:
                print(
                    f"{self.name}: stopped on request after step {self.clock.step}; the stage will start over",
                    flush=True,
                )
                sys.exit(STOPPED)
        return row

    @property
    def gravity(self) -> float:
        """Downward acceleration that acts now, m/s2."""
        return -self.newton.gravity[2]

    @property
    def newton(self):
        """YADE's integrator."""
        return next(engine for engine in O.engines if engine.label == "newton")

    @property
    def collider(self):
        """YADE's collider."""
        return next(engine for engine in O.engines if engine.label == "collider")

    def at_rest(self, row: StateRow, criterion: str = "rest.") -> bool:
        """True where the bed meets both limits, the keys `criterion`unbalanced_ratio and `criterion`kinetic_energy."""
        return (
            row.unbalanced_ratio <= self.scenario[criterion + "unbalanced_ratio"]
            and row.kinetic_energy_J <= self.scenario[criterion + "kinetic_energy"]
        )

    def advance_to_rest(
        self,
        criterion: str = "rest.",
        limit: str = "rest.time_limit",
        loads: LoadControl | None = None,
    ) -> None:
        """Run blocks until the bed is at rest and `loads`, where given, are met.

        criterion -- start of the scenario's keys of the two limits of rest
        limit -- key of the simulated time, s, after which a StageError says what is missing
        """
        start, time_limit = O.time, self.scenario[limit]
        while True:
            row = self.advance(self.grid.steps_per_block, self.grid.steps_per_block)
            if (loads is None or loads.targets_met()) and self.at_rest(row, criterion):
                return
            if O.time - start > time_limit:
                stresses = f"{loads.means()}, " if loads else ""
                raise StageError(
                    f"{self.name}: not at rest after {time_limit:g} s: {stresses}unbalanced ratio "
                    f"{row.unbalanced_ratio:.3g}, kinetic energy {row.kinetic_energy_J:.3g} J per clump "
                    f"({criterion}unbalanced_ratio, {criterion}kinetic_energy, {limit})"
                )

    def remove_outside(self) -> None:
        """Delete the clumps that left the box, and say how many."""
        removed = self.bed.remove_outside(self.box)
        print(f"{self.name}: {removed} clumps left the box and were deleted, {len(self.bed.numbers)} stay", flush=True)

    def keep_rows_up_to(self, name: str, step: int) -> None:
        """Drop rows of a raw file that this stage wrote after `step`, and rows of stages that come after it.

        A resumed run writes those rows again.
        """
        here = STAGES.index(self.name)

        def keep(row: Row) -> bool:
            stage = STAGES.index(row.get("stage", self.name))
            return stage < here or (stage == here and int(row["step"]) <= step)

        GrowingCsv(self.raw(name)).cut(keep)

    def start_state_file(self) -> None:
        """Make raw/state.csv ready: header, and only rows of the stages before this one and of this one up to now."""
        if self.raw("state.csv").exists():
            self.keep_rows_up_to("state.csv", self.clock.step)
        else:
            start_state_file(self.raw("state.csv"))

    def note_python_side(self) -> None:
        """Put into YADE's tags what the Python side must know after a load."""
        O.tags["step"] = str(self.clock.step)
        O.tags["clumps"] = json.dumps(self.bed.numbers)
        O.tags["load_control"] = json.dumps(self.control.memory())
        if self.bonds:
            O.tags["bonds"] = self.bonds.memory()
        O.interactions.serializeSorted = True  # contacts in the order of bodies: a tenth faster after the load

    def write_checkpoint(self, name: str) -> None:
        """Write checkpoints/<name>.yade.gz, aside and then renamed."""
        self.note_python_side()
        folder = self.folder / "checkpoints"
        aside = folder / f"partial_{name}.yade.gz"  # YADE compresses by the ending
        _reserve(aside, CHECKPOINT_BYTES_PER_CLUMP * (len(self.bed.numbers) + 20))
        faulthandler.dump_traceback_later(SAVE_TIME_LIMIT_S, exit=True)
        O.save(str(aside))
        faulthandler.cancel_dump_traceback_later()
        _check_whole(aside)
        os.replace(aside, folder / f"{name}.yade.gz")


def _reserve(path: Path, size: int) -> None:
    """StageError unless `size` bytes can be written to `path`: YADE tries for ever where a disk is full."""
    try:
        with open(path, "wb") as file:
            os.posix_fallocate(file.fileno(), 0, size)
    except OSError as error:
        path.unlink(missing_ok=True)
        raise StageError(
            f"checkpoints/{path.name}: {error.strerror}; free at least {size / 1e6:.1f} MB and run again"
        ) from None


def _check_whole(path: Path) -> None:
    """StageError unless a compressed file can be read to its end."""
    try:
        with gzip.open(path) as file:
            while file.read(1 << 22):
                pass
    except (OSError, EOFError, zlib.error):
        raise StageError(
            f"checkpoints/{path.name}: could not be written whole; free some space and run again"
        ) from None


def main(name: str, procedure) -> None:
    """Run `procedure(stage, checkpoint or None)`; errors become one line and exit code 1."""
    try:
        if len(sys.argv) < 2:
            raise StageError(f"{name}: give the run folder, as in yade/launch.sh -j1 -n -x yade/{name}.py RUN_FOLDER")
        folder = Path(sys.argv[1])
        if not (folder / "scenario.json").exists():
            raise StageError(f"{name}: {folder.name}/scenario.json is missing; `make run` writes it")
        procedure(Stage(name, folder), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
    except (StageError, InputError) as error:
        print(f"ERROR: {error}", flush=True)
        sys.exit(1)
    except OSError as error:
        print(
            f"ERROR: {name}: {Path(error.filename or '').name}: {error.strerror}; the run folder must be complete "
            "and have space",
            flush=True,
        )
        sys.exit(1)
    except Exception as error:  # one line for the driver, the trace for whoever reads the log
        traceback.print_exc()
        print(f"ERROR: {name}: {type(error).__name__}: {error}", flush=True)
        sys.exit(1)
