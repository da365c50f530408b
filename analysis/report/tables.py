"""Words, numbers and tables of the report: what pages are made of, and nothing about HTML but the coloured word."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from analysis.normalised import tables
from analysis.report.labels import SPHERE_NAMES


@dataclass(frozen=True)
class Column:
    """Heading of a table's column; numbers stand to the right, `wide` ones hold sentences."""

    title: str
    number: bool = False
    wide: bool = False


@dataclass
class Table:
    """Rows of texts under their columns."""

    caption: str
    columns: list[Column]
    rows: list[list] = field(default_factory=list)
    note: str = ""


@dataclass(frozen=True)
class Chip:
    """A word in a coloured box: kind is good, bad, open or calm."""

    text: str
    kind: str

    def __html__(self) -> str:
        return f'<span class="chip {self.kind}">{self.text}</span>'


GRAVITY = 9.80665

QUANTITIES = {
    "settlement_m": "settlement at minimum load",
    "settlement_peak_m": "settlement at maximum load",
    "lateral_mean_m": "lateral displacement, mean of plates",
    "resilient_stroke_m": "resilient stroke",
    "peak_acceleration_m_s2": "peak acceleration of the stroke",
    "secant_stiffness_N_m": "secant stiffness",
    "loop_energy_J": "work lost in the cycle",
    "late_slope_m": "late slope of settlement",
    "tracking_rms_Pa": "tracking error, rms",
    "tracking_worst_Pa": "tracking error, worst cycle",
    "coordination_number": "contacts per clump",
    "overlap_mean_m": "mean overlap",
    "overlap_max_ratio": "largest overlap over radius",
    "rotation_mean_rad": "mean rotation",
    "sliding_share": "share of sliding contacts",
    "at_limit_share": "share of contacts at the damping limit",
    "bulge_volume_m3": "shoulder bulge",
    "shoulder_displacement_m": "outward displacement of the shoulder",
    "crib_heave_m": "heave of the cribs",
    "normal_force_mean_N": "mean normal force",
    "contact_anisotropy": "anisotropy of contacts",
    "force_anisotropy": "anisotropy of forces",
    "force_chain_share": "contacts in force chains",
    "force_chain_load_share": "load carried by force chains",
    "porosity_spread": "range of the three porosities",
    "exponential_a": "exponential law: a",
    "exponential_b": "exponential law: b",
    "exponential_c": "exponential law: c",
    "exponential_d": "exponential law: d",
    **{f"lateral_{k}_m": f"lateral displacement of plate {k}" for k in tables.PLATES},
    **{f"porosity_{k}": f"porosity, sphere {k} ({SPHERE_NAMES[k - 1]})" for k in tables.SPHERES},
}
SHOWN_UNITS = {
    "m": ("mm", 1e3),
    "m per cycle": ("mm per 1000 cycles", 1e6),
    "Pa": ("kPa", 1e-3),
    "m/s2": ("g", 1 / GRAVITY),
    "N/m": ("kN/mm", 1e-6),
    "m3": ("cm³", 1e6),
    "rad": ("°", 180 / np.pi),
    "J": ("J", 1.0),
    "N": ("N", 1.0),
    "cycles": ("cycles", 1.0),
    "-": ("", 1.0),
}


SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value, digits: int = 3, factor: float = 1.0) -> str:
    """A number as tables show it, or a dash where there is none."""
    try:
        value = factor * float(value)
    except (TypeError, ValueError):
        return "–"
    if not np.isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    mantissa, _, power = text.partition("e")
    if power and 0 <= int(power) < 6:
        text = f"{value:.0f}"
    elif power:
        text = f"{mantissa}·10" + str(int(power)).translate(SUPERSCRIPT)
    return text.replace("-", "−")


def plural(count: int, noun: str) -> str:
    """`1 run`, `2 runs`."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def shown(value) -> str:
    """A parameter's value for people."""
    if isinstance(value, list):
        return ", ".join(shown(v) for v in value)
    if isinstance(value, float):
        return number(value, 6)
    return str(value) if value != "" else "–"


def interval(fit, name: str, factor: float) -> str:
    """A fitted parameter with its confidence interval."""
    if fit is None:
        return "–"
    low, high = fit.intervals[name]
    return f"{number(fit.values[name], 3, factor)} ({number(low, 3, factor)} to {number(high, 3, factor)})"


def quantity_name(name: str, unit: str) -> tuple[str, float, str]:
    """(label with the unit it is shown in, factor from SI, that unit)."""
    shown, factor = SHOWN_UNITS.get(unit, (unit, 1.0))
    if name == "overlap_mean_m":
        shown, factor = "µm", 1e6
    label = QUANTITIES.get(name, name.replace("_", " "))
    return (f"{label}, {shown}" if shown else label), factor, shown
