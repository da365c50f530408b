"""Preload: the packed bed comes to rest under the scenario's own contact law, then sleeper and plates are loaded until
stresses and rest are met. Clumps are damped locally, sleeper and plates never.

    yade/launch.sh -j1 -n -x yade/preload.py RUN_FOLDER        (from the top of the repository)

Reads raw/bed_packed.csv; writes raw/bed_preloaded.csv, raw/contacts_preloaded.csv, raw/bonds_preloaded.csv,
raw/preload.csv, raw/state.csv and checkpoints/cyclic_000000.yade.gz.
"""

from yade.wrapper import ForceResetter, NewtonIntegrator, Omega

import apparatus
import stage
from bed import Bed
from bond import Bonds
from contact import ContactLaw
from load_control import LoadControl
from state import write_contacts

O = Omega()


def preload(run: stage.Stage, _) -> None:
    """The stage, from the packed bed to the first checkpoint."""
    s = run.scenario
    law = ContactLaw(s, run.model)
    apparatus.build(run.box, law)
    run.bed = Bed(s)
    run.bed.place(run.raw("bed_packed.csv"), law.shells)
    if law.bonded:
        run.bonds = Bonds(s)
    run.control = LoadControl(s, run.name, run.clock, run.box, run.raw("preload.csv"))
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

    # 1. rest under gravity, sleeper and plates held; clumps that left the box are deleted
    run.advance_to_rest()
    run.remove_outside()

    # 2. loads rise linearly and stay
    run.control.ramp()
    run.advance_to_rest(limit="preload.time_limit", loads=run.control)
    write_contacts(run.bed, run.raw("contacts_preloaded.csv"))
    if run.bonds:
        run.bonds.write_bonds(run.bed, run.raw("bonds_preloaded.csv"))
    run.bed.write_bed(run.raw("bed_preloaded.csv"))

    # 3. the start of cyclic loading
    run.clock.start()
    run.write_checkpoint("cyclic_000000")


stage.main("preload", preload)
