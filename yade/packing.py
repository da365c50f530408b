"""Packing: from the lattice of overlapping clumps to a bed at rest.

    yade -j1 -n -x yade/packing.py RUN_FOLDER        (from the top of the repository)

Reads raw/bed_start.csv, writes raw/bed_packed.csv and raw/contacts_packed.csv.
"""

import math
import sys
from pathlib import Path

from yade.wrapper import ForceResetter, NewtonIntegrator, Omega, PyRunner

import __main__

ROOT = Path(sys.argv[0]).resolve().parent.parent  # __file__ would be YADE's own program
sys.path += [str(ROOT), str(ROOT / "yade")]

import apparatus  # noqa: E402
import stage  # noqa: E402
from bed import Bed  # noqa: E402
from contact import ContactLaw  # noqa: E402
from state import write_contacts  # noqa: E402

O = Omega()


def pack(run: stage.Stage, _) -> None:
    """Relax without friction under the lid, compact at high gravity, bring to rest at normal gravity."""
    s = run.scenario
    law = ContactLaw(s, run.model, packing=True)
    apparatus.build(run.box, "wall", law.wall_mask, law.side_material)
    lid = apparatus.close_lid(run.box, "wall", law.wall_mask)
    run.bed = Bed(s)
    run.bed.place(run.raw("bed_start.csv"), law.shells)
    newton = NewtonIntegrator(damping=s["packing.local_damping"], gravity=(0, 0, 0), label="newton")
    O.engines = [ForceResetter(), *law.engines(), newton]
    run.start_state_file()

    # The balls of the lattice have become clumps that overlap: soft contacts first, each with its own time step.
    law.set_friction(0.0, 0.0)
    for fraction in s["packing.relax_stiffness"]:
        law.set_stiffness(fraction)
        O.dt = run.grid.step_s / math.sqrt(fraction)
        left = s["packing.relax_steps"]
        while left > 0:
            run.advance_or_stop(min(left, run.grid.steps_per_block))
            left -= run.grid.steps_per_block

    # Compaction. What the box cannot hold comes out of the cribs.
    O.bodies.erase(lid)
    law.set_friction(s["packing.compaction_friction"], s["packing.compaction_friction"])
    newton.gravity = (0, 0, -s["packing.compaction_gravity"])
    run.advance_to_rest("packing.compaction_")
    removed = run.bed.remove_outside(run.box)
    print(f"packing: {removed} clumps left the box and were deleted, {len(run.bed.numbers)} stay", flush=True)

    # Gravity falls slowly, so that the bed follows.
    high, low = s["packing.compaction_gravity"], s["packing.final_gravity"]
    steps = max(1, round(s["packing.gravity_ramp_time"] / O.dt))
    first = O.iter

    def lower_gravity() -> None:
        newton.gravity = (0, 0, -(high + (low - high) * min(1.0, (O.iter - first) / steps)))

    __main__.lower_gravity = lower_gravity  # where PyRunner looks names up
    O.engines = [*O.engines, PyRunner(command="lower_gravity()", iterPeriod=10)]
    for _ in range(math.ceil((steps + 10) / run.grid.steps_per_block)):
        run.advance_or_stop(run.grid.steps_per_block)
    O.engines = O.engines[:-1]
    law.set_friction(s["contact.particle_particle.friction"], s["contact.particle_wall.friction"])
    newton.damping = s["rest.local_damping"]
    run.advance_to_rest()
    removed = run.bed.remove_outside(run.box)
    print(f"packing: {removed} more clumps deleted, {len(run.bed.numbers)} stay", flush=True)

    write_contacts(run.bed, run.raw("contacts_packed.csv"))
    run.bed.write(run.raw("bed_packed.csv"))


stage.main("packing", pack)
