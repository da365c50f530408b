"""Preload: a packed bed under the scenario's own contact law, brought to rest, then loaded by sleeper and plates.

    yade -j1 -n -x yade/preload.py RUN_FOLDER        (from the top of the repository)

Reads raw/bed_packed.csv, writes raw/preload.csv, raw/bed_preloaded.csv, raw/contacts_preloaded.csv and
checkpoints/cyclic_000000.yade.gz.
"""

import sys
from pathlib import Path

from yade.wrapper import ForceResetter, NewtonIntegrator, Omega

ROOT = Path(sys.argv[0]).resolve().parent.parent  # __file__ would be YADE's own program
sys.path += [str(ROOT), str(ROOT / "yade")]

import apparatus  # noqa: E402
import stage  # noqa: E402
from bed import Bed  # noqa: E402
from bond import Bonds  # noqa: E402
from contact import ContactLaw  # noqa: E402
from load_control import LoadControl  # noqa: E402
from state import write_contacts  # noqa: E402

O = Omega()


def preload(run: stage.Stage, _) -> None:
    """Place the bed, bring it to rest, raise the loads, wait until they are met and the bed is at rest."""
    s = run.scenario
    law = ContactLaw(s, run.model)
    apparatus.build(run.box, "wall", law.wall_mask, law.side_material)
    run.bed = Bed(s)
    run.bed.place(run.raw("bed_packed.csv"), law.shells)
    if law.bonded:
        run.bonds = Bonds(s)
    run.control = LoadControl(s, run.name, run.box, run.raw("preload.csv"))
    O.dt = run.grid.step_s
    O.engines = [
        ForceResetter(),
        *law.engines(),
        run.control.engine(),
        NewtonIntegrator(damping=s["rest.local_damping"], gravity=(0, 0, -s["packing.final_gravity"]), label="newton"),
    ]
    if run.bonds:
        run.bonds.make()  # needs the contact loop's functors
        print(f"preload: {run.bonds.made} bonds between clumps that touch", flush=True)
    run.start_state_file()
    run.control.start_file()

    # The bed finds its rest under this law, sleeper and plates fixed.
    run.advance_to_rest()
    removed = run.bed.remove_outside(run.box)
    print(f"preload: {removed} clumps left the box and were deleted, {len(run.bed.numbers)} stay", flush=True)

    run.control.ramp()
    start, limit = O.time, s["preload.time_limit"]
    while True:
        row = run.advance_or_stop(run.grid.steps_per_block)
        loaded = O.time - start
        ramped = loaded > s["preload.ramp_time"] + s["preload.averaging_time"]
        if ramped and run.control.targets_met() and run.at_rest(row):
            break
        if loaded > limit:
            means = ", ".join(f"{mean / 1e3:.2f}" for mean in run.control.mean_stresses())
            raise stage.StageError(
                stage.not_at_rest(
                    "preload",
                    limit,
                    row,
                    "rest.",
                    "preload.time_limit",
                    f"mean stress on sleeper and plates {means} kPa, ",
                )
            )

    write_contacts(run.bed, run.raw("contacts_preloaded.csv"))
    if run.bonds:
        run.bonds.write(run.bed, run.raw("bonds_preloaded.csv"))
    run.bed.write(run.raw("bed_preloaded.csv"))
    run.control.n = 0  # the cyclic stage counts its own steps
    run.step = 0
    run.save("cyclic_000000")


stage.main("preload", preload)
