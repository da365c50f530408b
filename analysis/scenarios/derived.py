"""Quantities that follow from the scenario: clump, bond, apparatus, time grid.

Standard library only (numpy for bonds), because YADE's Python reads it too. Everything is in SI units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from analysis import bond_law


@dataclass(frozen=True)
class Clump:
    """Two equal overlapping spheres, rigid; mass, volume and inertia are those of their union."""

    radius_m: float
    half_distance_m: float
    """Distance of each sphere's centre from the clump's centre, along its axis (local z)."""
    volume_m3: float
    mass_kg: float
    inertia_axial_kgm2: float
    inertia_transverse_kgm2: float


def clump(scenario) -> Clump:
    """The clump of a scenario: volume of a ball of radius clump.ball_radius, length over width = clump.aspect.

    Half of the union is the sphere slice -r <= t <= c about its own centre (c the half distance; t points to the
    clump's centre, which lies at t = c), whose disc at t has area pi (r^2 - t^2); moments of that polynomial are exact.
    """
    q = scenario["clump.aspect"] - 1.0  # half distance over radius
    volume = 4.0 / 3.0 * math.pi * scenario["clump.ball_radius"] ** 3
    unit_volume = 2 * math.pi * _moment(q, 0, 1)  # two half-unions of unit radius
    r = (volume / unit_volume) ** (1 / 3)
    density = scenario["clump.density"]
    axial = 2 * density * r**5 * math.pi / 2 * _moment(q, 0, 2)
    along = 2 * density * r**5 * math.pi * (_moment(q, 2, 1) - 2 * q * _moment(q, 1, 1) + q * q * _moment(q, 0, 1))
    return Clump(r, q * r, volume, density * volume, axial, axial / 2 + along)


def _moment(q: float, power: int, discs: int) -> float:
    """Integral of t^power (1 - t^2)^discs over -1 <= t <= q."""
    terms = {1: ((0, 1.0), (2, -1.0)), 2: ((0, 1.0), (2, -2.0), (4, 1.0))}[discs]
    return sum(f * (q ** (power + n + 1) - (-1.0) ** (power + n + 1)) / (power + n + 1) for n, f in terms)


@dataclass(frozen=True)
class Block:
    """An axis-parallel box given by two corners."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]


@dataclass(frozen=True)
class Apparatus:
    """Walls and moving parts at the start. Floor z = 0, end wall and side walls y = 0, y = width are planes.

    The end wall is at x = end_m: 0, or where the box is cut.
    """

    end_m: float
    length_m: float
    """Of the whole box: the faces of the plates are at x = length_m."""
    width_m: float
    height_m: float
    sleeper: Block
    plates: tuple[Block, ...]
    fixed_wall: Block
    sleeper_area_m2: float
    plate_area_m2: float
    measurement_centres_m: tuple[tuple[float, float, float], ...]
    measurement_radius_m: float
    measurement_fits: tuple[bool, ...]
    """Which of the measurement spheres lie inside the box; in the others nothing is measured."""
    ballast_volume_m3: float
    end_friction_share: float
    """Friction of the end wall over that of the side walls: 0 where it is a cut, in place of the ballast beyond."""


def apparatus(scenario) -> Apparatus:
    """The apparatus of a scenario, narrowed in y by geometry.width_scale and begun in x at geometry.cut_x."""
    scale = scenario["geometry.width_scale"]
    length, width, height = (
        scenario["geometry.box_length"],
        scenario["geometry.box_width"] * scale,
        scenario["geometry.box_height"],
    )
    base, sleeper_width = scenario["geometry.sleeper_base"], scenario["geometry.sleeper_width"] * scale
    left, cut = (width - sleeper_width) / 2, scenario["geometry.cut_x"]
    outer = length + scenario["geometry.plate_thickness"]
    pitch = scenario["geometry.plate_height"] + scenario["geometry.plate_gap"]
    plates = tuple(
        Block((length, 0.0, k * pitch), (outer, width, k * pitch + scenario["geometry.plate_height"]))
        for k in range(scenario["geometry.plate_count"])
    )
    centres = tuple((x, width / 2, scenario["geometry.measurement_z"]) for x in scenario["geometry.measurement_x"])
    radius = scenario["geometry.measurement_radius"]
    return Apparatus(
        cut,
        length,
        width,
        height,
        Block(
            (cut, left, base),
            (scenario["geometry.sleeper_length"], left + sleeper_width, base + scenario["geometry.sleeper_height"]),
        ),
        plates,
        Block((length, 0.0, scenario["geometry.plate_count"] * pitch), (outer, width, 2 * height)),
        (scenario["geometry.sleeper_length"] - cut) * sleeper_width,
        scenario["geometry.plate_height"] * width,
        centres,
        radius,
        tuple(cut - 1e-9 <= x - radius and x + radius <= length + 1e-9 and 2 * radius <= width for x, _, _ in centres),
        (length - cut) * (width * height - sleeper_width * (height - base)),
        1.0 if cut == 0 else 0.0,
    )


def share_of_box(scenario) -> float:
    """Share of the paper's box that the scenario simulates."""
    length = scenario["geometry.box_length"]
    return scenario["geometry.width_scale"] * (length - scenario["geometry.cut_x"]) / length


def simulated_space(scenario) -> Block:
    """The space outside of which a clump is lost, in both codes, with room above the box and behind the plates. It is
    open on these two sides, and grows there with the clumps that fly.
    """
    box = apparatus(scenario)
    high = (box.length_m + 0.2, box.width_m + 0.05, 2 * box.height_m + 0.05)
    low = (box.end_m - 0.05, -0.05, -0.05)
    return Block(*(tuple(round(value, 10) for value in corner) for corner in (low, high)))


@dataclass(frozen=True)
class TimeGrid:
    """The time step, adjusted (by less than 1 % in the paper's scenarios) so that rows and blocks are whole steps."""

    step_s: float
    steps_per_cycle: int
    steps_per_row: int
    steps_per_block: int


def time_grid(scenario) -> TimeGrid:
    """A cycle is the multiple of output.rows_per_cycle steps nearest to 1 / (frequency x time.step)."""
    period, rows = 1.0 / scenario["loading.frequency"], scenario["output.rows_per_cycle"]
    per_row = max(1, round(period / scenario["time.step"] / rows))
    cycle = per_row * rows
    return TimeGrid(period / cycle, cycle, per_row, cycle // scenario["output.blocks_per_cycle"])


def load_control(scenario) -> dict[str, float]:
    """Masses (kg) and drags (N s/m) of sleeper and plates, scaled like the areas they press on."""
    length = scenario["geometry.sleeper_length"]
    share = {"sleeper": (length - scenario["geometry.cut_x"]) / length, "plate": 1.0}
    return {
        f"{kind}_{key}": scenario[f"load_control.{kind}_{key}"] * scenario["geometry.width_scale"] * share[kind]
        for kind in share
        for key in ("mass", "drag")
    }


def wall_laws(scenario, stage: str) -> dict[str, str]:
    """The laws that move sleeper and plates in `stage`: force | pfc | fixed."""
    laws = {kind: scenario[f"load_control.{kind}_law"] for kind in ("sleeper", "plate")}
    if stage == "preload" and scenario["preload.law"] == "force":
        laws = {kind: "force" if law == "pfc" else law for kind, law in laws.items()}
    return laws


def pfc_time_step(scenario) -> float:
    """The time step in the gain of PFC's servo, s: load_control.pfc_time_step, or where that is 0 the run's own."""
    return scenario["load_control.pfc_time_step"] or time_grid(scenario).step_s


def bond(scenario, radius_1_m: float = 0.0, radius_2_m: float = 0.0) -> bond_law.Bond | None:
    """The parallel bond between two spheres, by default the clump's; None where the scenario has no bonds."""
    if scenario["contact.bond.model"] == "none":
        return None
    from analysis import bond_law  # here: without bonds the loader needs the standard library only

    own = clump(scenario).radius_m
    return bond_law.bond(
        bond_law.bond_radius(scenario["contact.bond.radius_multiplier"], radius_1_m or own, radius_2_m or own),
        *(
            scenario[f"contact.bond.{key}"]
            for key in ("normal_stiffness", "shear_stiffness", "normal_strength", "shear_strength", "reading")
        ),
    )


def lattice_spacing(scenario) -> float:
    """Centre distance of the hexagonal lattice, m."""
    return (
        2 * scenario["packing.lattice_radius"] + scenario["packing.lattice_gap"] * scenario["packing.lattice_gap_share"]
    )


def critical_time_step(scenario) -> float:
    """2 sqrt(m / k) of one clump on the stiffest linear contact, s: no step above it can be stable."""
    k, between = scenario["contact.particle_wall.normal_stiffness"], 0.0
    if scenario["contact.model"] == "linear":
        between = scenario["contact.particle_particle.normal_stiffness"]
    cement = bond(scenario)
    if cement:
        between += cement.normal_stiffness * cement.area
    k = max(k, between)
    return 2 * math.sqrt(clump(scenario).mass_kg / k)
