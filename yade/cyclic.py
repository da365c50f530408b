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


def load(run: stage.Stage, checkpoint: Path) -> None:
    """Take the simulation from a checkpoint: bodies, contacts and engines; the Python around them is made anew."""
    try:
        O.load(str(checkpoint))
    except RuntimeError:
        raise stage.StageError(f"cyclic: {checkpoint.name} cannot be read; start from an earlier checkpoint") from None
    run.collider.targetInterv = SAME_REACH  # for checkpoints that older versions wrote
    s = run.scenario
    run.step = int(O.tags["step"])
    run.bed = Bed(s, json.loads(O.tags["clumps"]))
    run.control = LoadControl(s, run.name, run.box, run.raw("cyclic.csv"), json.loads(O.tags["load_control"]))
    run.control.cycle()
    run.bonds = Bonds(s, O.tags["bonds"]) if "bonds" in O.tags.keys() else None  # noqa: SIM118 (tags are no dict)


def save(run: stage.Stage, name: str) -> None:
    """Write a checkpoint and go on from it: a run that was not interrupted takes the same path as a resumed one."""
    load(run, run.save(name))


def cyclic(run: stage.Stage, checkpoint: Path | None) -> None:
    """Load cycle by cycle; every cycle is a few blocks, after each of which the run can be stopped."""
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
    for block in range(done + 1, cycles * blocks + 1):
        # Step 0 is a row of its own, so the first block has one step more; every block ends with the row closing it.
        run.advance(block * grid.steps_per_block + 1 - run.control.n)
        cycle, part = divmod(block, blocks)
        if part == 0:
            if cycle in keep or cycle == cycles:
                write_contacts(run.bed, run.raw(f"contacts_cycle_{cycle:06d}.csv"))
                if run.bonds:
                    run.bonds.write(run.bed, run.raw(f"bonds_cycle_{cycle:06d}.csv"))
            run.bed.write(run.raw(f"bed_cycle_{cycle:06d}.csv"))
            if cycle % s["output.checkpoint_cycles"] == 0 or cycle == cycles:
                save(run, f"cyclic_{cycle:06d}")
                continue
        if run.stop_requested:
            name = f"cyclic_{cycle:06d}_block{part}"
            run.save(name)
            print(f"cyclic: stopped on request after cycle {cycle}, block {part}", flush=True)
            sys.exit(stage.STOPPED)


stage.main("cyclic", cyclic)
