"""Preload: the packed bed comes to rest under the scenario's own contact law, then sleeper and plates are loaded until
stresses and rest are met. Clumps are damped locally, sleeper and plates never.

    yade/launch.sh -j1 -n -x yade/preload.py RUN_FOLDER        (from the top of the repository)

Reads raw/bed_packed.csv; writes raw/bed_preloaded.csv, raw/contacts_preloaded.csv, raw/bonds_preloaded.csv,
raw/preload.csv, raw/state.csv and checkpoints/cyclic_000000.yade.gz.
"""

from yade.wrapper import ForceResetter, NewtonIntegrator, Omega

import apparatus
from bed import Bed
from bond import Bonds
from contact import ContactLaw
from load_control import LoadControl
from stage import Stage, main
from state import write_contacts

O = Omega()


def preload(stage: Stage, _checkpoint) -> None:
    """The stage, from the packed bed to the first checkpoint."""
    s = stage.scenario
    law = ContactLaw(s, stage.model)
    apparatus.build(stage.box, law)
    stage.bed = Bed(s)
    stage.bed.place(stage.raw("bed_packed.csv"), law.shells)
    if law.bonded:
        stage.bonds = Bonds(s)
    stage.control = LoadControl(s, stage.name, stage.clock, stage.box, stage.raw("preload.csv"))
    O.dt = stage.grid.step_s
    O.engines = [
        ForceResetter(),
        *law.engines(),
        stage.control.engine(),
        NewtonIntegrator(damping=s["rest.local_damping"], gravity=(0, 0, -s["packing.final_gravity"]), label="newton"),
    ]
    if stage.bonds:
        stage.bonds.make()  # needs the contact loop's functors
        print(f"preload: {stage.bonds.made} bonds between clumps that touch", flush=True)
    stage.start_state_file()
    stage.control.start_file()

    # 1. rest under gravity, sleeper and plates held; clumps that left the box are deleted
    stage.advance_to_rest()
    stage.remove_outside()

    # 2. loads rise linearly and stay
    stage.control.ramp()
    stage.advance_to_rest(limit="preload.time_limit", loads=stage.control)
    write_contacts(stage.bed, stage.raw("contacts_preloaded.csv"))
    if stage.bonds:
        stage.bonds.write_bonds(stage.bed, stage.raw("bonds_preloaded.csv"))
    stage.bed.write_bed(stage.raw("bed_preloaded.csv"))

    # 3. the start of cyclic loading
    stage.clock.start()
    stage.write_checkpoint("cyclic_000000")


main("preload", preload)
