"""What is measured: a row for each quantity, from which columns, headings, axis labels, checks and the glossary follow.

A quantity's name is its column name in every file and ends in its SI unit. A name with `{}` stands for a row of plates
(1, the lowest, to 5) or of measurement spheres (1 to 3): `lateral_{}_m` for `lateral_1_m` to `lateral_5_m`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

CODES = ("yade", "liggghts")
PLATES = range(1, 6)
SPHERES = range(1, 4)
SPHERE_NAMES = ("rail seat", "middle", "shoulder")
GRAVITY_M_S2 = 9.80665

SHOWN_UNITS = {
    "m": ("mm", 1e3),
    "m per cycle": ("mm per 1000 cycles", 1e6),
    "Pa": ("kPa", 1e-3),
    "Pa2": ("kPa²", 1e-6),
    "m/s2": ("g", 1 / GRAVITY_M_S2),
    "N/m": ("kN/mm", 1e-6),
    "m3": ("cm³", 1e6),
    "rad": ("°", 180 / math.pi),
    "J": ("J", 1.0),
    "N": ("N", 1.0),
    "s": ("s", 1.0),
    "cycles": ("cycles", 1.0),
    "-": ("", 1.0),
}
"""How a unit is shown to people: its name, and the factor from SI."""


@dataclass(frozen=True)
class Quantity:
    """One quantity.

    name      column name, SI unit at the end
    unit      SI unit, a key of SHOWN_UNITS
    label     as a heading or an axis calls it, without its unit
    low, high the range, in SI, outside of which a value is damage and no physics; wide on purpose
    meaning   what it is, for the glossary: definition, sign, reference
    shown     unit and factor for people where they are not those of SHOWN_UNITS
    empty     True where a cell may be empty: the run cannot say it in every row
    compared  True where the codes are compared by it; left out is what is equal by construction (number of clumps,
              load), what a run is held to (tracking error) and what another quantity says
    formula   of a quantity that follows after each cycle from others: a function of the columns of cycles.csv, of
              quantities that follow, too, and of the scenario's parameters, each by its name. A quantity is stored in
              a file, has a formula, or a function in comparison/run_quantities.py
    """

    name: str
    unit: str
    label: str
    low: float
    high: float
    meaning: str
    shown: tuple[str, float] | None = None
    empty: bool = False
    compared: bool = False
    formula: Callable[[Mapping[str, Any]], Any] | None = None

    @property
    def shown_unit(self) -> str:
        """The unit for people; empty for a pure number."""
        return (self.shown or SHOWN_UNITS[self.unit])[0]

    @property
    def factor(self) -> float:
        """Shown value over SI value."""
        return (self.shown or SHOWN_UNITS[self.unit])[1]

    @property
    def heading(self) -> str:
        """Label with the shown unit, for tables and axes: `settlement at minimum load, mm`."""
        return f"{self.label}, {self.shown_unit}" if self.shown_unit else self.label

    def accepts(self, value: float) -> bool:
        """True where `value` (SI) is physics; nan only where a cell may be empty."""
        return self.low <= value <= self.high or (self.empty and value != value)


_ROWS = (
    # ------------------------------------------------------------------ cycles.csv and history.csv
    Quantity("cycle", "cycles", "cycle", 0, 1e8, "number of complete load cycles; fractional within a cycle"),
    Quantity("time_s", "s", "time", 0, 1e7, "simulated time since the start of cyclic loading"),
    Quantity(
        "settlement_m",
        "m",
        "settlement at minimum load",
        -10,
        10,
        "downward displacement of the sleeper since the end of preload; in cycles.csv at the minimum load that ends a "
        "cycle",
        compared=True,
    ),
    Quantity(
        "settlement_peak_m",
        "m",
        "settlement at maximum load",
        -10,
        10,
        "the same at the maximum load of the cycle",
        compared=True,
    ),
    Quantity(
        "lateral_{}_m",
        "m",
        "lateral displacement of plate {}",
        -10,
        10,
        "outward displacement of a side plate since the end of preload; plate 1 is the lowest",
    ),
    Quantity(
        "porosity_{}",
        "-",
        "porosity, sphere {} ({name})",
        0,
        1,
        "share of a measurement sphere's volume that no clump fills; sleeper and plates are left out of the volume; "
        "empty where the sphere does not fit into the box",
        empty=True,
        compared=True,
    ),
    Quantity("bonds", "-", "bonds that hold", 0, 1e8, "number of parallel bonds between clumps that hold"),
    Quantity("bonds_broken_tension", "-", "bonds broken in tension", 0, 1e8, "since they were made"),
    Quantity("bonds_broken_shear", "-", "bonds broken in shear", 0, 1e8, "since they were made"),
    Quantity("stress_before_Pa", "Pa", "stress before unloading", -1e9, 1e9, "on the sleeper, at the end of the cycle"),
    Quantity("settlement_before_m", "m", "settlement before unloading", -10, 10, "at the end of the cycle"),
    Quantity(
        "stress_after_Pa", "Pa", "stress after unloading", -1e9, 1e9, "on the sleeper, slowly brought to its least"
    ),
    Quantity(
        "settlement_after_m",
        "m",
        "settlement after unloading",
        -10,
        10,
        "what stays when the load is slowly at its least",
    ),
    Quantity(
        "sleeper_stress_min_Pa", "Pa", "least stress on the sleeper", -1e9, 1e9, "smallest row mean within the cycle"
    ),
    Quantity(
        "sleeper_stress_max_Pa",
        "Pa",
        "largest stress on the sleeper",
        -1e9,
        1e9,
        "largest row mean within the cycle",
    ),
    Quantity(
        "tracking_rms_Pa",
        "Pa",
        "tracking error, rms",
        0,
        1e9,
        "root mean square, over all steps of a cycle, of the sleeper's stress minus its target",
    ),
    Quantity("clumps", "-", "clumps", 0, 1e9, "number of clumps in the simulation"),
    Quantity(
        "sleeper_target_Pa", "Pa", "target stress of the sleeper", -1e9, 1e9, "the load signal over the base area"
    ),
    Quantity(
        "sleeper_stress_Pa", "Pa", "stress on the sleeper", -1e9, 1e9, "contact force on the sleeper over its base area"
    ),
    Quantity("plate_target_Pa", "Pa", "target stress of the plates", -1e9, 1e9, "the confining stress of preload"),
    Quantity(
        "plate_{}_stress_Pa", "Pa", "stress on plate {}", -1e9, 1e9, "contact force on a plate over its area, inward"
    ),
    # ------------------------------------------------------------------ microstructure.csv and stages.json
    Quantity(
        "porosity_error",
        "-",
        "standard error of porosity",
        0,
        1,
        "of the sampled volume; the largest of the spheres; empty where none fits into the box",
        empty=True,
    ),
    Quantity("porosity_mean", "-", "porosity, mean of spheres", 0, 1, "mean over the three measurement spheres"),
    Quantity(
        "critical_step_s",
        "s",
        "critical time step",
        0,
        1,
        "2 over the largest frequency of the preloaded bed, its contacts as stiff as under the largest stress",
        ("µs", 1e6),
    ),
    Quantity("step_share", "-", "share of the critical step", 0, 100, "time step of the run over the critical one"),
    Quantity(
        "coordination_number",
        "-",
        "contacts per clump",
        0,
        1e3,
        "contacts of a clump with others and with walls, sphere by sphere: (2 N_pp + N_pw) / N",
        compared=True,
    ),
    Quantity(
        "neighbours_mean", "-", "neighbours per clump", 0, 1e3, "other clumps that a clump touches, however often"
    ),
    Quantity(
        "overlap_mean_m", "m", "mean overlap", 0, 10, "mean over contacts between clumps", ("µm", 1e6), compared=True
    ),
    Quantity(
        "overlap_max_ratio",
        "-",
        "largest overlap",
        0,
        2,
        "largest overlap of all contacts, walls included, over the radius of a clump's spheres",
        ("% of radius", 100.0),
        compared=True,
    ),
    Quantity(
        "rotation_mean_rad",
        "rad",
        "mean rotation",
        0,
        3.2,
        "mean over clumps of the angle of the rotation since before loading, 0 to pi",
        compared=True,
    ),
    Quantity("rotation_max_rad", "rad", "largest rotation", 0, 3.2, "the largest of these angles"),
    Quantity(
        "bulge_volume_m3",
        "m3",
        "shoulder bulge",
        -10,
        10,
        "volume swept by the plates: sum of lateral displacement x plate area",
        compared=True,
    ),
    Quantity(
        "shoulder_displacement_m",
        "m",
        "outward displacement of the shoulder",
        -10,
        10,
        "mean outward displacement of clumps that began within two ball radii of the plates: the bulge as the bed "
        "itself shows it, also where the plates are fixed or have lost touch",
        empty=True,
        compared=True,
    ),
    Quantity("downward_mean_m", "m", "mean downward displacement", -10, 10, "of all clumps", empty=True),
    Quantity(
        "downward_under_sleeper_m",
        "m",
        "downward displacement under the sleeper",
        -10,
        10,
        "mean over the clumps that began under the sleeper",
        empty=True,
    ),
    Quantity(
        "crib_heave_m",
        "m",
        "heave of the cribs",
        -10,
        10,
        "mean upward displacement of the clumps that began beside the sleeper, above its base",
        empty=True,
        compared=True,
    ),
    Quantity(
        "sleeper_contacts",
        "-",
        "contacts of the sleeper",
        0,
        1e9,
        "spheres that touch it, at its least load",
        empty=True,
    ),
    Quantity(
        "sliding_share",
        "-",
        "share of sliding contacts",
        0,
        1,
        "contacts at the friction limit, of all",
        ("%", 100.0),
        True,
        compared=True,
    ),
    Quantity(
        "at_limit_share",
        "-",
        "share of contacts at the damping limit",
        0,
        1,
        "contacts whose hysteretic dashpot is held at critical damping; empty where the law has no such limit",
        ("%", 100.0),
        empty=True,
        compared=True,
    ),
    Quantity(
        "kinetic_energy_J", "J", "kinetic energy per clump", 0, 1e9, "mean, translation and rotation", ("mJ", 1e3), True
    ),
    Quantity(
        "unbalanced_ratio",
        "-",
        "unbalanced ratio",
        0,
        1e12,
        "mean net force on a clump over the mean contact force",
        empty=True,
    ),
    Quantity("normal_force_mean_N", "N", "mean normal force", -1e8, 1e8, "over contacts between clumps", empty=True),
    Quantity(
        "contact_anisotropy",
        "-",
        "anisotropy of contacts",
        0,
        10,
        "sqrt(3/2 a:a) with a = 15/2 (<n n> - I/3) over contacts between clumps (Ouadfel and Rothenburg 2001); 0 where "
        "normals are isotropic",
        empty=True,
    ),
    Quantity(
        "force_anisotropy",
        "-",
        "anisotropy of forces",
        0,
        10,
        "the same with normals weighted by the normal force",
        empty=True,
    ),
    *(
        Quantity(f"fabric_{axis}", "-", f"fabric {axis}", 0, 1, "diagonal of <n n>, trace 1", empty=True)
        for axis in ("xx", "yy", "zz")
    ),
    Quantity(
        "force_chain_share",
        "-",
        "contacts in force chains",
        0,
        1,
        "share of contacts between clumps that carry more than the mean normal force (the strong network of Radjai et "
        "al. 1998)",
        empty=True,
    ),
    Quantity(
        "force_chain_load_share",
        "-",
        "load carried by force chains",
        0,
        1,
        "their share of the sum of normal forces",
        empty=True,
    ),
    # ------------------------------------------------------------------ first harmonics
    Quantity("target_amplitude_Pa", "Pa", "amplitude of the target", 0, 1e9, "first harmonic of a cycle"),
    Quantity("stress_amplitude_Pa", "Pa", "amplitude of the stress", 0, 1e9, "first harmonic of a cycle"),
    Quantity("stress_lag_rad", "rad", "lag of the stress", 0, 6.2832, "of its first harmonic behind the target's"),
    Quantity("settlement_amplitude_m", "m", "amplitude of settlement", 0, 10, "first harmonic of a cycle"),
    Quantity("settlement_lag_rad", "rad", "lag of settlement", 0, 6.2832, "of its first harmonic behind the target's"),
    # ------------------------------------------------------------------ raw files of the engines
    Quantity("step", "-", "step", 0, 1e15, "steps since the start of the stage"),
    Quantity(
        "sleeper_stress_mean_Pa", "Pa", "mean stress on the sleeper", -1e9, 1e9, "over the steps since the row before"
    ),
    Quantity(
        "sleeper_error_ms_Pa2",
        "Pa2",
        "tracking error, mean square",
        0,
        1e18,
        "mean over the steps since the row before of (stress - target) squared",
    ),
    Quantity(
        "sleeper_displacement_m", "m", "displacement of the sleeper", -10, 10, "downward since the start of preload"
    ),
    Quantity(
        "plate_{}_stress_mean_Pa", "Pa", "mean stress on plate {}", -1e9, 1e9, "over the steps since the row before"
    ),
    Quantity("plate_stress_min_Pa", "Pa", "least stress on a plate", -1e9, 1e9, "of all plates, within the cycle"),
    Quantity("plate_stress_max_Pa", "Pa", "greatest stress on a plate", -1e9, 1e9, "of all plates, within the cycle"),
    Quantity("plate_{}_displacement_m", "m", "displacement of plate {}", -10, 10, "outward since the start of preload"),
    Quantity("contacts", "-", "contacts", 0, 1e9, "real contacts of spheres with each other and with walls"),
    # ------------------------------------------------------------------ bed and contact files
    Quantity("id", "-", "clump", 1, 2**31 - 1, "number of a clump, the same through all stages"),
    *(Quantity(f"{axis}_m", "m", axis, -100, 100, "position in space") for axis in "xyz"),
    *(Quantity(f"q{part}", "-", f"q{part}", -1.000001, 1.000001, "unit quaternion, body to space") for part in "wxyz"),
    *(Quantity(f"clump_{k}", "-", f"clump {k}", 0, 2**31 - 1, "number of a clump; 0 is a wall") for k in (1, 2)),
    *(Quantity(f"n{axis}", "-", f"n{axis}", -1.000001, 1.000001, "unit normal, clump 1 to clump 2") for axis in "xyz"),
    Quantity("overlap_m", "m", "overlap", -1, 10, "of two spheres, or of a sphere and a wall"),
    Quantity("normal_force_N", "N", "normal force", -1e8, 1e8, "repulsive positive, dashpot included"),
    Quantity("shear_force_N", "N", "shear force", 0, 1e8, "magnitude"),
    Quantity("broken", "-", "broken", 0, 1, "1 for a bond that is broken"),
    Quantity("mode", "-", "mode of breakage", 0, 9, "how a bond broke: bond_law.TENSION or SHEAR", empty=True),
    Quantity("tensile_stress_Pa", "Pa", "tensile stress of a bond", -1e12, 1e12, "greatest, 0 once broken"),
    Quantity("shear_stress_Pa", "Pa", "shear stress of a bond", -1e12, 1e12, "greatest, 0 once broken"),
    Quantity("sliding", "-", "sliding", 0, 1, "1 where the shear force is at its limit"),
    # ------------------------------------------------------------------ what comparison derives from these
    Quantity("settlement_increment_m", "m", "settlement of the cycle", -10, 10, "what a cycle adds", empty=True),
    Quantity(
        "lateral_mean_m", "m", "lateral displacement, mean of plates", -10, 10, "mean of the five plates", compared=True
    ),
    Quantity(
        "resilient_stroke_m",
        "m",
        "resilient stroke",
        -10,
        10,
        "settlement at maximum load minus that at the minimum load after it: what springs back; empty where less "
        "of the load reaches the bed, late (PFC's servo on a soft bed)",
        empty=True,
        compared=True,
    ),
    Quantity(
        "peak_acceleration_m_s2",
        "m/s2",
        "peak acceleration of the stroke",
        0,
        1e6,
        "half the resilient stroke x (2 pi f)²: above gravity the bed throws what lies loose on it",
        empty=True,
        formula=lambda run: run["resilient_stroke_m"] / 2 * (2 * math.pi * run["loading.frequency"]) ** 2,
    ),
    Quantity(
        "secant_stiffness_N_m",
        "N/m",
        "secant stiffness",
        0,
        1e15,
        "range of the sleeper's load over the resilient stroke",
        empty=True,
        compared=True,
    ),
    Quantity(
        "loop_energy_J",
        "J",
        "work lost in the cycle",
        -1e9,
        1e9,
        "work of the load in a cycle: area of the loop of load against settlement",
        empty=True,
        compared=True,
    ),
    Quantity("porosity_spread", "-", "range of the three porosities", 0, 1, "largest minus smallest", empty=True),
    Quantity(
        "tracking_ratio",
        "-",
        "tracking error",
        0,
        1e6,
        "rms tracking error over the largest target stress",
        empty=True,
        formula=lambda run: run["tracking_rms_Pa"] / run["loading.stress_max"],
    ),
    Quantity("tracking_worst_Pa", "Pa", "tracking error, worst cycle", 0, 1e9, "largest rms tracking error of a cycle"),
    Quantity(
        "late_slope_m",
        "m per cycle",
        "late slope of settlement",
        -1,
        1,
        "slope of settlement over the last cycles",
        empty=True,
    ),
    *(
        Quantity(f"exponential_{k}", unit, f"exponential law: {k}", -1e9, 1e9, "fitted constant", empty=True)
        for k, unit in (("a", "m"), ("b", "m"), ("c", "cycles"), ("d", "m per cycle"))
    ),
)


def _members(row: Quantity) -> Iterable[Quantity]:
    """A row with `{}` for each plate or sphere, any other by itself."""
    if "{}" not in row.name:
        yield row
        return
    for k in SPHERES if row.name.startswith("porosity") else PLATES:
        label = row.label.replace("{}", str(k)).replace("{name}", SPHERE_NAMES[(k - 1) % len(SPHERE_NAMES)])
        yield replace(row, name=row.name.replace("{}", str(k)), label=label)


QUANTITIES: dict[str, Quantity] = {member.name: member for row in _ROWS for member in _members(row)}
"""Every quantity by its column name."""


COMPARED = tuple(name for name, quantity in QUANTITIES.items() if quantity.compared)
"""What the codes are compared by."""


def row_of(pattern: str) -> tuple[str, ...]:
    """The column names of a row of plates or spheres: row_of("lateral_{}_m")."""
    return tuple(q.name for q in QUANTITIES.values() if re.fullmatch(pattern.replace("{}", r"\d"), q.name))


def glossary() -> tuple[Quantity, ...]:
    """Every quantity in the order of the files, a row of plates or spheres once, with `{}` in its name and label."""
    return _ROWS
