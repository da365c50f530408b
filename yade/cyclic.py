"""Cyclic loading, from a checkpoint to the last cycle.

    yade -j1 -n -x yade/cyclic.py RUN_FOLDER CHECKPOINT        (from the top of the repository)

Appends to raw/cyclic.csv, writes a bed file at the end of each cycle and checkpoints now and then.
"""

import json
import sys
from pathlib import Path

from yade.wrapper import Omega

ROOT = Path(sys.argv[0]).resolve().parent.parent  # __file__ would be YADE's own program
sys.path += [str(ROOT), str(ROOT / "yade")]

import stage  # noqa: E402
from bed import Bed  # noqa: E402
from bond import Bonds  # noqa: E402
from contact import SAME_REACH  # noqa: E402
from load_control import LoadControl  # noqa: E402
from state import write_contacts  # noqa: E402

O = Omega()


def restore(run: stage.Stage) -> None:
    """Make the Python side anew, around a simulation that YADE has just loaded."""
    run.collider.targetInterv = SAME_REACH  # for checkpoints that older versions wrote
    s = run.scenario
    run.step = int(O.tags["step"])
    run.bed = Bed(s, json.loads(O.tags["clumps"]))
    run.control = LoadControl(s, run.name, run.box, run.raw("cyclic.csv"), json.loads(O.tags["load_control"]))
    run.control.cycle()
    run.bonds = Bonds(s, O.tags["bonds"]) if "bonds" in O.tags.keys() else None  # noqa: SIM118 (tags are no dict)


def load(run: stage.Stage, checkpoint: Path) -> None:
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


def cyclic(run: stage.Stage, checkpoint: Path | None) -> None:
    """Load cycle by cycle; every cycle is a few blocks, after each of which the run can be stopped.

    Every cycle begins from a loaded state, so that it does not matter whether the run was stopped before it. A stop
    drops the blocks of the cycle that is not complete.
    """
    s, grid = run.scenario, run.grid
    if checkpoint is None:
        raise stage.StageError("cyclic: give the checkpoint to start from, at first checkpoints/cyclic_000000.yade.gz")
    load(run, checkpoint)
    run.newton.damping = s["loading.local_damping"]
    if run.step == 0:
        run.control.start_file()
    else:
        run.keep_rows_up_to("cyclic.csv", run.step)
    run.start_state_file()

    blocks, cycles, keep = s["output.blocks_per_cycle"], s["loading.cycles"], s["output.keep_beds"]
    done = run.step // grid.steps_per_block
    saved = done // blocks  # the last complete cycle that has a checkpoint
    for block in range(done + 1, cycles * blocks + 1):
        if run.stop_requested:
            stop(run, (block - 1) // blocks, saved)
        # Step 0 is a row of its own, so the first block has one step more; every block ends with the row closing it.
        run.advance(block * grid.steps_per_block + 1 - run.control.n)
        cycle, part = divmod(block, blocks)
        if part == 0:
            if cycle in keep or cycle == cycles:
                write_contacts(run.bed, run.raw(f"contacts_cycle_{cycle:06d}.csv"))
                if run.bonds:
                    run.bonds.write(run.bed, run.raw(f"bonds_cycle_{cycle:06d}.csv"))
            run.bed.write(run.raw(f"bed_cycle_{cycle:06d}.csv"))
            begin_again(run)
            if cycle % s["output.checkpoint_cycles"] == 0 or cycle == cycles:
                run.save(f"cyclic_{cycle:06d}")
                saved = cycle


def stop(run: stage.Stage, cycle: int, saved: int) -> None:
    """End the program; the run goes on from the end of `cycle`, whose checkpoint is written unless it is `saved`."""
    if cycle > saved:
        O.loadTmp(quiet=True)
        restore(run)
        run.save(f"cyclic_{cycle:06d}")
    print(f"cyclic: stopped on request; goes on from the end of cycle {cycle}", flush=True)
    sys.exit(stage.STOPPED)


stage.main("cyclic", cyclic)
