"""The columns of the common files, once. Both engines write them; a test holds their headers to these."""

from __future__ import annotations

from analysis.formats.quantities import CODES, PLATES, SPHERES, row_of

__all__ = [
    "BED",
    "BONDS",
    "BONDS_BROKEN",
    "BOND_COUNTS",
    "CODES",
    "CONTACTS",
    "CYCLES",
    "HARMONICS",
    "HISTORY",
    "MICROSTRUCTURE",
    "PLATES",
    "PLATE_STRESSES",
    "RAW_LOADING",
    "RAW_STATE",
    "SPHERES",
    "UNLOAD",
]
__all__ += ["header"]

CYCLES = (
    "cycle",
    "time_s",
    "settlement_m",
    "settlement_peak_m",
    *row_of("lateral_{}_m"),
    *row_of("porosity_{}"),
    "sleeper_stress_min_Pa",
    "sleeper_stress_max_Pa",
    "tracking_rms_Pa",
    "clumps",
)
"""cycles.csv: a row per cycle."""

HISTORY = (
    "time_s",
    "cycle",
    "sleeper_target_Pa",
    "sleeper_stress_Pa",
    "settlement_m",
    "plate_target_Pa",
    *row_of("plate_{}_stress_Pa"),
    *row_of("lateral_{}_m"),
)
"""history.csv: output.rows_per_cycle rows per cycle; `cycle` is fractional."""

MICROSTRUCTURE = (
    "cycle",
    *row_of("porosity_{}"),
    "porosity_error",
    "coordination_number",
    "neighbours_mean",
    "overlap_mean_m",
    "overlap_max_ratio",
    "rotation_mean_rad",
    "rotation_max_rad",
    "bulge_volume_m3",
    "shoulder_displacement_m",
    "downward_mean_m",
    "downward_under_sleeper_m",
    "crib_heave_m",
    "sleeper_contacts",
    "sliding_share",
    "at_limit_share",
    "kinetic_energy_J",
    "unbalanced_ratio",
    "normal_force_mean_N",
    "contact_anisotropy",
    "force_anisotropy",
    "fabric_xx",
    "fabric_yy",
    "fabric_zz",
    "force_chain_share",
    "force_chain_load_share",
)
"""microstructure.csv: row 0 before loading, then a row per cycle. Columns from normal_force_mean_N on are empty in
cycles whose contacts were not kept."""

HARMONICS = (
    "cycle",
    "target_amplitude_Pa",
    "stress_amplitude_Pa",
    "stress_lag_rad",
    "settlement_amplitude_m",
    "settlement_lag_rad",
)
"""harmonics.csv, of kept runs: a row per cycle, the first harmonics of history.csv, which is too large to be kept."""

PLATE_STRESSES = ("cycle", *row_of("plate_{}_stress_mean_Pa"), "plate_stress_min_Pa", "plate_stress_max_Pa")
"""plates.csv, of kept runs: a row per cycle, what the rows of history.csv say of the stress on the plates."""

LOOPS = ("time_s", "cycle", "sleeper_target_Pa", "sleeper_stress_Pa", "settlement_m")
"""loops.csv, of kept runs: the rows of history.csv of the first and the last whole cycle."""

BED = ("id", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")
"""raw/bed_*.csv, bed_before.csv, bed_after.csv: a row per clump, its centre and the unit quaternion that turns its
frame, z along the clump, into space."""

CONTACTS = (
    "clump_1",
    "clump_2",
    "x_m",
    "y_m",
    "z_m",
    "nx",
    "ny",
    "nz",
    "overlap_m",
    "normal_force_N",
    "shear_force_N",
    "sliding",
)
"""raw/contacts_*.csv: a row per contact of two spheres; a wall is clump 0 and always second."""

BONDS = ("clump_1", "clump_2", "x_m", "y_m", "z_m", "broken", "step", "mode", "tensile_stress_Pa", "shear_stress_Pa")
"""raw/bonds_*.csv: a row per bond, where it is, or broke; `mode` is empty while a bond holds, `step` counts from when
bonds were made."""

BOND_COUNTS = ("cycle", "bonds", "bonds_broken_tension", "bonds_broken_shear")
"""bonds.csv, of runs with bonds: a row per cycle, row 0 before loading; bonds that hold, and broken ones so far."""

BONDS_BROKEN = ("cycle", "x_m", "y_m", "z_m", "mode")
"""bonds_broken.csv, of runs with bonds: a row per broken bond, the cycle in which it broke (0: preload) and where."""

RAW_LOADING = (
    "step",
    "time_s",
    "sleeper_target_Pa",
    "sleeper_stress_Pa",
    "sleeper_stress_mean_Pa",
    "sleeper_error_ms_Pa2",
    "sleeper_displacement_m",
    *(f"plate_{k}_{what}" for k in PLATES for what in ("stress_Pa", "stress_mean_Pa", "displacement_m")),
)
"""raw/preload.csv and raw/cyclic.csv: output.rows_per_cycle rows per cycle."""

UNLOAD = ("cycle", "stress_before_Pa", "settlement_before_m", "stress_after_Pa", "settlement_after_m")
"""unload.csv: a row per cycle after which a copy of the run was unloaded slowly to the least stress."""

RAW_STATE = (
    "stage",
    "step",
    "time_s",
    "kinetic_energy_J",
    "unbalanced_ratio",
    "overlap_max_ratio",
    "overlap_mean_m",
    "contacts",
    "clumps",
    "at_limit_share",
    "sliding_share",
)
"""raw/state.csv: a row per block of steps, of all stages."""


def header(columns: tuple[str, ...]) -> str:
    """The first line of a file, newline included."""
    return ",".join(columns) + "\n"
