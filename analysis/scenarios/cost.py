"""What a run would cost: clumps, steps, memory and disk, estimated before anything of it is made.

A slip of the pen (a step of 1e-9 s, balls of a millimetre) is refused before an engine has filled the machine with it.
Standard library only.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass

from analysis.scenarios import derived

MOST_CLUMPS = 1_000_000
MOST_STEPS = 1e11
"""Decades of the full bed: the paper's 1000 cycles are 1e7 steps, most of a day in LIGGGHTS."""
MOST_DISK_BYTES = 1e12
BYTES_PER_CLUMP = 20_000
"""Of memory, in either engine; a generous estimate."""
BYTES_PER_ROW = 400
"""Of raw and normalised load tables."""


@dataclass(frozen=True)
class Cost:
    """Estimates: clumps on the lattice, steps of cyclic loading, memory and disk in bytes."""

    clumps: float
    steps: float
    memory_bytes: float
    disk_bytes: float


def cost(scenario) -> Cost:
    """The cost of a scenario, from its geometry alone: exact to the margins at walls."""
    box, cycles = derived.apparatus(scenario), scenario["loading.cycles"]
    clumps = (
        (box.length_m - box.end_m)
        * box.width_m
        * box.height_m
        / (derived.lattice_spacing(scenario) ** 3 / math.sqrt(2))
    )
    kept = (cycles // scenario["output.checkpoint_cycles"] > 0) + len(scenario["output.keep_beds"]) + 3
    return Cost(
        clumps,
        float(cycles) * derived.time_grid(scenario).steps_per_cycle,
        clumps * BYTES_PER_CLUMP,
        float(cycles) * scenario["output.rows_per_cycle"] * BYTES_PER_ROW + kept * clumps * 1000,
    )


def too_much(scenario) -> Iterator[tuple[str, str]]:
    """(key, what is allowed) for what no run can be meant to cost."""
    found, memory = cost(scenario), _memory_bytes()
    if found.clumps > MOST_CLUMPS:
        yield "packing.lattice_radius", f"a bed of at most {MOST_CLUMPS:,} clumps; this lattice has {found.clumps:.3g}"
    if found.memory_bytes > memory:
        yield (
            "packing.lattice_radius",
            f"a bed that fits into this machine's {memory / 1e9:.3g} GB; {found.clumps:.3g} clumps need about "
            f"{found.memory_bytes / 1e9:.3g} GB",
        )
    if found.steps > MOST_STEPS:
        yield (
            "time.step",
            f"a run of at most {MOST_STEPS:g} steps; {scenario['loading.cycles']} cycles of "
            f"{derived.time_grid(scenario).steps_per_cycle} steps are {found.steps:.3g}",
        )
    if found.disk_bytes > MOST_DISK_BYTES:
        yield (
            "output.rows_per_cycle",
            f"a run that writes at most {MOST_DISK_BYTES / 1e12:g} TB; this one writes {found.disk_bytes / 1e12:.3g}",
        )


def _memory_bytes() -> float:
    """Memory of this machine; infinite where it cannot be asked."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
    except (OSError, ValueError):
        return math.inf
