"""What each key of the scenario file may hold: type, unit, limits, and the stages that read it.

The unit is part of the key's definition, so a value given in another unit is refused rather than converted.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace

STATUSES = ("reported", "derived", "assumed", "calibrated")
STAGES = ("packing", "preload", "loading", "output", "limit")
"""In the order of a run. `output` is what a run writes, `limit` how far it goes and when it stops: no physics."""
PROFILE_KEYS = (
    "geometry.width_scale",
    "geometry.cut_x",
    "packing.lattice_gap",
    "loading.cycles",
    "output.checkpoint_cycles",
    "output.keep_beds",
)


@dataclass(frozen=True)
class Key:
    """One allowed key: kind is float, int, str or list; limits are inclusive unless `open_minimum` says not."""

    unit: str
    kind: type = float
    minimum: float | None = None
    maximum: float | None = None
    open_minimum: bool = False
    choices: tuple = ()
    item: type = float
    since: str = "packing"
    """The first stage that reads the key; empty: it only takes part in making another key (`time.step`)."""
    until: str = "loading"
    """The last one."""
    neutral: float | int | str | None = None
    """The value that means what the codes did before the key existed: runs that lack the key had this value, and the
    hash of a scenario with it is the hash without the key.
    """
    made: str = ""
    """How the loader makes the value; such a key may not stand in the file."""

    def allowed(self) -> str:
        """Say in words what the key may hold."""
        if self.choices:
            return "one of " + ", ".join(str(choice) or '""' for choice in self.choices)
        name = {
            float: "a number",
            int: "a whole number",
            str: "a text",
            list: f"a list of {'whole ' if self.item is int else ''}numbers",
        }[self.kind]
        limits = []
        if self.minimum is not None:
            limits.append(f"{'>' if self.open_minimum else '>='} {self.minimum:g}")
        if self.maximum is not None:
            limits.append(f"<= {self.maximum:g}")
        return name + (" " + " and ".join(limits) if limits else "") + (f" {self.unit}" if self.unit != "-" else "")

    def accepts(self, value) -> bool:
        """True where `value` has the right type and lies within the limits."""
        if self.kind is list:
            single = Key(self.unit, self.item, self.minimum, self.maximum, self.open_minimum)
            return isinstance(value, list) and len(value) > 0 and all(single.accepts(v) for v in value)
        if isinstance(value, bool):
            return False
        if self.kind is float:
            if not isinstance(value, (int, float)) or not abs(value) <= sys.float_info.max:
                return False
        elif not isinstance(value, self.kind):
            return False
        if self.choices:
            return value in self.choices
        if self.minimum is not None and (value < self.minimum or (self.open_minimum and value == self.minimum)):
            return False
        return self.maximum is None or value <= self.maximum

    def matters(self, first: str, last: str) -> bool:
        """True where a stage from `first` to `last` reads the key."""
        if not self.since:
            return False
        since, until, low, high = map(STAGES.index, (self.since, self.until, first, last))
        return since <= high and until >= low


def _positive(unit: str, maximum: float, kind: type = float) -> Key:
    """Up to `maximum`; not below a ten-thousand-millionth of it, or 1: what is smaller is a slip of the pen."""
    return Key(unit, kind, 1 if kind is int else maximum * 1e-10, maximum)


def _between(unit: str, minimum: float, maximum: float, kind: type = float) -> Key:
    return Key(unit, kind, minimum, maximum)


def _from_zero(unit: str, maximum: float, kind: type = float) -> Key:
    return Key(unit, kind, 0, maximum)


def _read_by(since: str, until: str, keys: dict[str, Key]) -> dict[str, Key]:
    return {name: replace(key, since=since, until=until) for name, key in keys.items()}


def _neutral(value, key: Key) -> Key:
    return replace(key, neutral=value)


KEYS: dict[str, Key] = {
    "geometry.box_length": _between("m", 1e-3, 10),
    "geometry.box_width": _between("m", 1e-3, 10),
    "geometry.box_height": _between("m", 1e-3, 10),
    "geometry.width_scale": _between("-", 0.01, 1),
    "geometry.cut_x": _neutral(0.0, _from_zero("m", 10)),
    "geometry.sleeper_length": _between("m", 1e-3, 10),
    "geometry.sleeper_width": _between("m", 1e-3, 10),
    "geometry.sleeper_height": _between("m", 1e-3, 10),
    "geometry.sleeper_base": _between("m", 1e-3, 10),
    "geometry.plate_count": Key("-", int, 5, 5),
    "geometry.plate_height": _between("m", 1e-3, 10),
    "geometry.plate_gap": _from_zero("m", 0.01),
    "geometry.plate_thickness": _between("m", 1e-4, 1),
    "geometry.measurement_radius": _between("m", 1e-3, 10),
    "geometry.measurement_x": Key("m", list, 0, 10),
    "geometry.measurement_z": _between("m", 1e-3, 10),
    "clump.ball_radius": _between("m", 1e-3, 1),
    "clump.aspect": Key("-", float, 1, 2, open_minimum=True),
    "clump.density": _between("kg/m3", 1, 25000),
    **_read_by(
        "packing",
        "packing",
        {
            "packing.bed_from": Key("-", str),
            "packing.bed_code": Key("-", str, choices=("", "yade", "liggghts")),
            "packing.lattice_radius": _between("m", 1e-3, 1),
            "packing.growth": Key("-", float, 1, 5),
            "packing.lattice_gap": _from_zero("m", 1),
            "packing.lattice_gap_share": _neutral(1.0, _positive("-", 10)),
            "packing.lattice_vacancies": _neutral(0.0, _from_zero("-", 0.5)),
            "packing.relax_stiffness": Key("-", list, 1e-6, 1),
            "packing.relax_steps": _positive("step", 10_000_000, int),
            "packing.local_damping": _from_zero("-", 0.95),
            "packing.compaction_gravity": _between("m/s2", 1e-6, 1e4),
            "packing.compaction_friction": _from_zero("-", 5),
            "packing.compaction_unbalanced_ratio": _positive("-", 1),
            "packing.compaction_kinetic_energy": _between("J", 1e-15, 1e6),
            "packing.gravity_ramp_time": _between("s", 1e-6, 10),
        },
    ),
    "packing.final_gravity": _between("m/s2", 1e-6, 1e4),
    **_read_by(
        "packing",
        "preload",
        {
            "rest.local_damping": _from_zero("-", 0.95),
            "rest.unbalanced_ratio": _positive("-", 1),
            "rest.kinetic_energy": _between("J", 1e-15, 1e6),
        },
    ),
    **_read_by(
        "preload",
        "loading",
        {
            "preload.law": _neutral("loading", Key("-", str, choices=("loading", "force"))),
            "preload.sleeper_stress": _between("Pa", 1, 1e9),
            "preload.plate_stress": _between("Pa", 1, 1e9),
            "preload.ramp_time": _between("s", 1e-6, 10),
            "preload.stress_tolerance": _positive("-", 0.5),
            "preload.averaging_time": _between("s", 1e-6, 1),
        },
    ),
    **_read_by(
        "loading",
        "loading",
        {
            "loading.stress_min": _between("Pa", 1, 1e9),
            "loading.stress_max": _between("Pa", 1, 1e9),
            "loading.local_damping": _neutral(0.0, _from_zero("-", 0.95)),
        },
    ),
    "loading.frequency": _between("Hz", 1e-3, 1000),  # makes the time grid, of packing too
    **_read_by("limit", "limit", {"loading.cycles": _positive("-", 10_000_000, int)}),
    **_read_by(
        "preload",
        "loading",
        {
            "load_control.sleeper_law": Key("-", str, choices=("force", "pfc")),
            "load_control.plate_law": Key("-", str, choices=("force", "pfc", "fixed")),
            "load_control.sleeper_mass": _between("kg", 1e-6, 1e6),
            "load_control.sleeper_drag": _from_zero("N s/m", 1e12),
            "load_control.plate_mass": _between("kg", 1e-6, 1e6),
            "load_control.plate_drag": _from_zero("N s/m", 1e12),
            "load_control.pfc_gain": _positive("-", 2),
            "load_control.pfc_time_step": _neutral(0.0, _from_zero("s", 1e-3)),
            "load_control.pfc_velocity_limit": _between("m/s", 1e-9, 1e4),
            "load_control.pfc_update_interval": _positive("step", 10_000_000, int),
            "load_control.pfc_contact_floor": Key("-", int, 1, 1_000_000),
            "contact.model": Key("-", str, choices=("linear", "hysteretic")),
            "contact.origin": _neutral("paper", Key("-", str, choices=("paper", "engine"))),
            "contact.dashpot_limit": _neutral(1.0, _positive("-", 1)),
        },
    ),
    "contact.dashpot_mass_share": _neutral(1.0, _positive("-", 1)),
    "contact.particle_particle.normal_stiffness": _between("N/m", 1, 1e13),
    "contact.particle_particle.shear_stiffness": _from_zero("N/m", 1e13),
    "contact.particle_particle.damping_ratio": _from_zero("-", 0.99),
    "contact.particle_particle.friction": _from_zero("-", 5),
    **_read_by(  # packing has linear contacts always
        "preload",
        "loading",
        {
            "contact.particle_particle.shear_modulus": _between("Pa", 1, 1e13),
            "contact.particle_particle.poisson_ratio": _from_zero("-", 0.49),
            "contact.particle_particle.restitution": _from_zero("-", 1),
            "contact.particle_particle.damping_mode": Key("-", int, choices=(0, 1, 2)),
        },
    ),
    "contact.particle_wall.normal_stiffness": _between("N/m", 1, 1e13),
    "contact.particle_wall.shear_stiffness": _from_zero("N/m", 1e13),
    "contact.particle_wall.damping_ratio": _from_zero("-", 0.99),
    "contact.particle_wall.friction": _from_zero("-", 5),
    "contact.side_friction_share": _neutral(1.0, _from_zero("-", 1)),
    **_read_by(
        "preload",
        "loading",
        {  # a scenario without bonds has the neutral values of all of them
            "contact.bond.model": _neutral("none", Key("-", str, choices=("none", "parallel"))),
            "contact.bond.reading": _neutral("per_area", Key("-", str, choices=("per_area", "total"))),
            "contact.bond.radius_multiplier": _neutral(1.0, _positive("-", 1)),
            "contact.bond.normal_stiffness": _neutral(4e9, _between("Pa/m or N/m", 1e-3, 1e16)),
            "contact.bond.shear_stiffness": _neutral(5e6, _between("Pa/m or N/m", 1e-3, 1e16)),
            "contact.bond.normal_strength": _neutral(3e7, _between("Pa or N", 1e-3, 1e16)),
            "contact.bond.shear_strength": _neutral(3e7, _between("Pa or N", 1e-3, 1e16)),
        },
    ),
    **_read_by(
        "",
        "",
        {
            "time.choice": Key("-", str, choices=("paper", "verified")),
            "time.paper_step": _between("s", 1e-9, 1e-3),
            "time.verified_step": _between("s", 1e-9, 1e-3),
            "time.factor": _between("-", 1e-3, 10),
        },
    ),
    "time.step": replace(
        _between("s", 1e-9, 1e-3), made="time.paper_step or time.verified_step, as time.choice says, times time.factor"
    ),
    "output.rows_per_cycle": Key("-", int, 40, 1_000_000),  # these two make the time grid
    "output.blocks_per_cycle": _positive("-", 10_000, int),
    **_read_by(
        "output",
        "output",
        {
            "output.checkpoint_cycles": _positive("-", 10_000_000, int),
            "output.keep_beds": Key("-", list, 1, 10_000_000, item=int),
        },
    ),
    **_read_by(
        "limit",
        "limit",
        {
            "rest.time_limit": _between("s", 1e-6, 100),
            "preload.time_limit": _between("s", 1e-6, 100),
            "limits.overlap_ratio": _positive("-", 1),
            "limits.kinetic_energy": _between("J", 1e-15, 1e6),
        },
    ),
}
FILE_KEYS = tuple(name for name, key in KEYS.items() if not key.made)
"""Keys that the scenario file holds; the loader makes the others."""
