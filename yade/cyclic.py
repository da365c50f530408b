"""Cyclic loading, from a checkpoint: sigma(t) = mean - amplitude cos(2 pi f t) on the sleeper, constant stress on the
plates. Each cycle is a number of blocks, after each of which the run may be stopped.

    yade/launch.sh -j1 -n -x yade/cyclic.py RUN_FOLDER CHECKPOINT        (from the top of the repository)

Reads CHECKPOINT; appends to raw/cyclic.csv and raw/state.csv; writes raw/bed_cycle_*.csv, raw/contacts_cycle_*.csv,
raw/bonds_cycle_*.csv, checkpoints/cyclic_*.yade.gz. Exit status 75: stopped on request.
"""

import json
import sys
from pathlib import Path

from yade.wrapper import Omega

from bed import Bed
from bond import Bonds
from contact import SAME_REACH
from load_control import LoadControl
from stage import STOPPED, Stage, StageError, main
from state import write_contacts

O = Omega()


def cyclic(stage: Stage, checkpoint: Path | None) -> None:
    """The stage, from a checkpoint to the last cycle."""
    # 1. the bed, its loads and the laws that move sleeper and plates
    if checkpoint is None:
        raise StageError("cyclic: give the checkpoint to start from, at first checkpoints/cyclic_000000.yade.gz")
    read_checkpoint(stage, checkpoint)
    stage.newton.damping = stage.scenario["loading.local_damping"]
    if stage.clock.step == 0:
        stage.control.start_file()
    else:
        stage.keep_rows_up_to("cyclic.csv", stage.clock.step)
    stage.start_state_file()

    # 2. cycles from where the checkpoint stands, and what is due at the end of each
    advance_cycles(stage)


def advance_cycles(stage: Stage) -> None:
    """Load cycle by cycle, block by block.

    Every cycle begins from a loaded state, so that it does not matter whether the run was stopped before it. A stop
    drops the blocks of the cycle that is not complete.
    """
    s, steps_per_block = stage.scenario, stage.grid.steps_per_block
    blocks, cycles = s["output.blocks_per_cycle"], s["loading.cycles"]
    done = stage.clock.step // steps_per_block
    saved = done // blocks  # the last complete cycle that has a checkpoint
    for block in range(done + 1, cycles * blocks + 1):
        if stage.stop_requested:
            stop(stage, (block - 1) // blocks, saved)
        # Step 0 is a row of its own, so the first block has one step more; every block ends with the row closing it.
        stage.advance_block(block * steps_per_block + 1 - stage.clock.step)
        cycle, part = divmod(block, blocks)
        if part == 0:
            after_cycle(stage, cycle)
            begin_again(stage)
            if cycle % s["output.checkpoint_cycles"] == 0 or cycle == cycles:
                stage.write_checkpoint(f"cyclic_{cycle:06d}")
                saved = cycle


def after_cycle(stage: Stage, cycle: int) -> None:
    """Write what is due at the end of a cycle."""
    if cycle in stage.scenario["output.keep_beds"] or cycle == stage.scenario["loading.cycles"]:
        write_contacts(stage.bed, stage.raw(f"contacts_cycle_{cycle:06d}.csv"))
        if stage.bonds:
            stage.bonds.write_bonds(stage.bed, stage.raw(f"bonds_cycle_{cycle:06d}.csv"))
    stage.bed.write_bed(stage.raw(f"bed_cycle_{cycle:06d}.csv"))


def stop(stage: Stage, cycle: int, saved: int) -> None:
    """End the program; the run goes on from the end of `cycle`, whose checkpoint is written unless it is `saved`."""
    if cycle > saved:
        O.loadTmp(quiet=True)
        restore(stage)
        stage.write_checkpoint(f"cyclic_{cycle:06d}")
    print(f"cyclic: stopped on request; goes on from the end of cycle {cycle}", flush=True)
    sys.exit(STOPPED)


def read_checkpoint(stage: Stage, checkpoint: Path) -> None:
    """Take the simulation from a checkpoint: bodies, contacts and engines."""
    try:
        O.load(str(checkpoint))
    except RuntimeError:
        raise StageError(f"cyclic: {checkpoint.name} cannot be read; start from an earlier checkpoint") from None
    restore(stage)


def begin_again(stage: Stage) -> None:
    """Save the simulation in memory and go on from there, as a run does that starts from this moment's checkpoint."""
    stage.note_python_side()
    O.saveTmp(quiet=True)
    O.loadTmp(quiet=True)
    restore(stage)


def restore(stage: Stage) -> None:
    """Make the Python side anew, around a simulation that YADE has just loaded."""
    stage.collider.targetInterv = SAME_REACH  # for checkpoints that older versions wrote
    s = stage.scenario
    stage.clock.start(int(O.tags["step"]))
    stage.bed = Bed(s, json.loads(O.tags["clumps"]))
    memory = json.loads(O.tags["load_control"])
    stage.control = LoadControl(s, stage.name, stage.clock, stage.box, stage.raw("cyclic.csv"), memory)
    stage.control.cycle()
    stage.bonds = Bonds(s, O.tags["bonds"]) if "bonds" in O.tags.keys() else None  # noqa: SIM118 (tags are no dict)


main("cyclic", cyclic)
