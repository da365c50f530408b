"""Packing: clumps of random orientation on a lattice lose their overlaps without friction, are compacted by a strong
gravity, and come to rest under their weight with the scenario's friction. Always with the linear law.

    yade/launch.sh -j1 -n -x yade/packing.py RUN_FOLDER        (from the top of the repository)

Reads raw/bed_start.csv; writes raw/bed_packed.csv, raw/contacts_packed.csv, raw/state.csv.
"""

import math

from yade.wrapper import ForceResetter, NewtonIntegrator, Omega, PyRunner

import __main__
import apparatus
from bed import Bed
from contact import ContactLaw
from stage import Stage, main
from state import write_contacts

O = Omega()


def pack(stage: Stage, _checkpoint) -> None:
    """The stage, from the lattice to the bed at rest."""
    s, block = stage.scenario, stage.grid.steps_per_block
    law = ContactLaw(s, stage.model, packing=True)
    apparatus.build(stage.box, law)
    lid = apparatus.close_lid(stage.box, "wall", law.wall_mask)  # while it is crowded beside the sleeper
    stage.bed = Bed(s)
    stage.bed.place(stage.raw("bed_start.csv"), law.shells)
    newton = NewtonIntegrator(damping=s["packing.local_damping"], gravity=(0, 0, 0), label="newton")
    O.engines = [ForceResetter(), *law.engines(), newton]
    stage.start_state_file()

    # 1. overlaps relax: no friction, no gravity, contacts that stiffen; the time step follows the stiffness
    law.set_friction(0.0, 0.0)
    for fraction in s["packing.relax_stiffness"]:
        law.set_stiffness(fraction)
        O.dt = stage.grid.step_s / math.sqrt(fraction)
        stage.advance(s["packing.relax_steps"], block)

    # 2. compaction with the lid off; clumps that left the box are deleted
    O.bodies.erase(lid)
    law.set_friction(s["packing.compaction_friction"], s["packing.compaction_friction"])
    newton.gravity = (0, 0, -s["packing.compaction_gravity"])
    stage.advance_to_rest("packing.compaction_")
    stage.remove_outside()

    # 3. gravity comes down to that of the earth, slowly, so that the bed follows
    high, low = s["packing.compaction_gravity"], s["packing.final_gravity"]
    steps = max(1, round(s["packing.gravity_ramp_time"] / O.dt))
    first = stage.clock.step

    def lower_gravity() -> None:
        newton.gravity = (0, 0, -(high + (low - high) * min(1.0, (stage.clock.step - first) / steps)))

    __main__.lower_gravity = lower_gravity  # where PyRunner looks names up
    O.engines = [*O.engines, PyRunner(command="lower_gravity()", iterPeriod=10)]
    stage.advance(block * math.ceil((steps + 10) / block), block)
    O.engines = O.engines[:-1]

    # 4. final friction and rest; clumps that left the box are deleted
    law.set_friction(s["contact.particle_particle.friction"], s["contact.particle_wall.friction"])
    newton.damping = s["rest.local_damping"]
    stage.advance_to_rest()
    stage.remove_outside()
    write_contacts(stage.bed, stage.raw("contacts_packed.csv"))
    stage.bed.write_bed(stage.raw("bed_packed.csv"))


main("packing", pack)
