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
    s = stage.scenario
    law = ContactLaw(s, stage.model, packing=True)
    apparatus.build(stage.box, law)
    lid = apparatus.close_lid(stage.box, "wall", law.wall_mask)  # while it is crowded beside the sleeper
    stage.bed = Bed(s)
    stage.bed.place(stage.raw("bed_start.csv"), law.shells)
    newton = NewtonIntegrator(damping=s["packing.local_damping"], gravity=(0, 0, 0), label="newton")
    O.engines = [ForceResetter(), *law.engines(), newton]
    stage.start_state_file()

    relax(stage, law)
    O.bodies.erase(lid)
    compact(stage, law, newton)
    lower_gravity(stage, newton)
    come_to_rest(stage, law, newton)
    write_contacts(stage.bed, stage.raw("contacts_packed.csv"))
    stage.bed.write_bed(stage.raw("bed_packed.csv"))


def relax(stage: Stage, law: ContactLaw) -> None:
    """Overlaps relax: no friction, no gravity, contacts that stiffen; the time step follows the stiffness."""
    law.set_friction(0.0, 0.0)
    for fraction in stage.scenario["packing.relax_stiffness"]:
        law.set_stiffness(fraction)
        O.dt = stage.grid.step_s / math.sqrt(fraction)
        stage.advance(stage.scenario["packing.relax_steps"], stage.grid.steps_per_block)


def compact(stage: Stage, law: ContactLaw, newton: NewtonIntegrator) -> None:
    """Compaction by a strong gravity; clumps that left the box are deleted."""
    friction = stage.scenario["packing.compaction_friction"]
    law.set_friction(friction, friction)
    newton.gravity = (0, 0, -stage.scenario["packing.compaction_gravity"])
    stage.advance_to_rest("packing.compaction_")
    stage.remove_outside()


def lower_gravity(stage: Stage, newton: NewtonIntegrator) -> None:
    """Gravity comes down to that of the earth, slowly, so that the bed follows."""
    s, block = stage.scenario, stage.grid.steps_per_block
    high, low = s["packing.compaction_gravity"], s["packing.final_gravity"]
    steps = max(1, round(s["packing.gravity_ramp_time"] / O.dt))
    first = stage.clock.step

    def set_gravity() -> None:
        newton.gravity = (0, 0, -(high + (low - high) * min(1.0, (stage.clock.step - first) / steps)))

    __main__.set_gravity = set_gravity  # where PyRunner looks names up
    O.engines = [*O.engines, PyRunner(command="set_gravity()", iterPeriod=10)]
    stage.advance(block * math.ceil((steps + 10) / block), block)
    O.engines = O.engines[:-1]


def come_to_rest(stage: Stage, law: ContactLaw, newton: NewtonIntegrator) -> None:
    """Final friction and rest; clumps that left the box are deleted."""
    s = stage.scenario
    law.set_friction(s["contact.particle_particle.friction"], s["contact.particle_wall.friction"])
    newton.damping = s["rest.local_damping"]
    stage.advance_to_rest()
    stage.remove_outside()


main("packing", pack)
