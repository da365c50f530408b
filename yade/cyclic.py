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

import stage
from bed import Bed
from bond import Bonds
from contact import SAME_REACH
from load_control import LoadControl
from state import write_contacts

O = Omega()


def cyclic(run: stage.Stage, checkpoint: Path | None) -> None:
    """The stage, from a checkpoint to the last cycle."""
    # 1. the bed, its loads and the laws that move sleeper and plates
    if checkpoint is None:
        raise stage.StageError("cyclic: give the checkpoint to start from, at first checkpoints/cyclic_000000.yade.gz")
    read_checkpoint(run, checkpoint)
    run.newton.damping = run.scenario["loading.local_damping"]
    if run.clock.step == 0:
        run.control.start_file()
    else:
        run.keep_rows_up_to("cyclic.csv", run.clock.step)
    run.start_state_file()

    # 2. cycles from where the checkpoint stands, and what is due at the end of each
    advance_cycles(run)


def advance_cycles(run: stage.Stage) -> None:
    """Load cycle by cycle, block by block.

    Every cycle begins from a loaded state, so that it does not matter whether the run was stopped before it. A stop
    drops the blocks of the cycle that is not complete.
    """
    s, steps_per_block = run.scenario, run.grid.steps_per_block
    blocks, cycles = s["output.blocks_per_cycle"], s["loading.cycles"]
    done = run.clock.step // steps_per_block
    saved = done // blocks  # the last complete cycle that has a checkpoint
    for block in range(done + 1, cycles * blocks + 1):
        if run.stop_requested:
            stop(run, (block - 1) // blocks, saved)
        # Step 0 is a row of its own, so the first block has one step more; every block ends with the row closing it.
        run.advance_block(block * steps_per_block + 1 - run.clock.step)
        cycle, part = divmod(block, blocks)
        if part == 0:
            after_cycle(run, cycle)
            begin_again(run)
            if cycle % s["output.checkpoint_cycles"] == 0 or cycle == cycles:
                run.write_checkpoint(f"cyclic_{cycle:06d}")
                saved = cycle


def after_cycle(run: stage.Stage, cycle: int) -> None:
    """Write what is due at the end of a cycle."""
    if cycle in run.scenario["output.keep_beds"] or cycle == run.scenario["loading.cycles"]:
        write_contacts(run.bed, run.raw(f"contacts_cycle_{cycle:06d}.csv"))
        if run.bonds:
            run.bonds.write_bonds(run.bed, run.raw(f"bonds_cycle_{cycle:06d}.csv"))
    run.bed.write_bed(run.raw(f"bed_cycle_{cycle:06d}.csv"))


def stop(run: stage.Stage, cycle: int, saved: int) -> None:
    """End the program; the run goes on from the end of `cycle`, whose checkpoint is written unless it is `saved`."""
    if cycle > saved:
        O.loadTmp(quiet=True)
        restore(run)
        run.write_checkpoint(f"cyclic_{cycle:06d}")
    print(f"cyclic: stopped on request; goes on from the end of cycle {cycle}", flush=True)
    sys.exit(stage.STOPPED)


def read_checkpoint(run: stage.Stage, checkpoint: Path) -> None:
    """Take the simulation from a checkpoint: bodies, contacts and engines."""
    try:
        O.load(str(checkpoint))
    except RuntimeError:
        raise stage.StageError(f"cyclic: {checkpoint.name} cannot be read; start from an earlier checkpoint") from None
    restore(run)


def begin_again(run: stage.Stage) -> None:
    """Save the simulation in memory and go on from there, as a run does that starts from this moment's checkpoint."""
    run.note_python_side()
    O.saveTmp(quiet=True)
    O.loadTmp(quiet=True)
    restore(run)


def restore(run: stage.Stage) -> None:
    """Make the Python side anew, around a simulation that YADE has just loaded."""
    run.collider.targetInterv = SAME_REACH  # for checkpoints that older versions wrote
    s = run.scenario
    run.clock.start(int(O.tags["step"]))
    run.bed = Bed(s, json.loads(O.tags["clumps"]))
    memory = json.loads(O.tags["load_control"])
    run.control = LoadControl(s, run.name, run.clock, run.box, run.raw("cyclic.csv"), memory)
    run.control.cycle()
    run.bonds = Bonds(s, O.tags["bonds"]) if "bonds" in O.tags.keys() else None  # noqa: SIM118 (tags are no dict)


stage.main("cyclic", cyclic)
