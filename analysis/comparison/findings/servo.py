"""PFC's servo as a first-order filter: what it makes of the prescribed load.

The servo moves the sleeper at v = G (F_target - F), G = gain / (K_c dt), where K_c = N k_n is the sum of the
stiffnesses of the sleeper's N contacts. The bed answers with F = K_bed x, K_bed complex at the load's frequency:
friction and dashpots make the force lead the displacement by a loss angle. Together dF/dt = (F_target - F) / tau with
tau = K_c dt / (gain K_bed), and of a sinusoid of angular frequency w the share 1 / (1 + i w tau) passes. The contacts
are counted. With K_bed of the same run this checks the servo; with K_bed of the run under the true load it forecasts.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable

import numpy as np
import pandas as pd

from analysis.comparison.findings.members import IDENTITY, SERVO, TRUE_LOAD, Member
from analysis.comparison.run_quantities import last_cycle
from analysis.scenarios import derived

HARMONICS = (("stress_amplitude_Pa", "stress_lag_rad"), ("settlement_amplitude_m", "settlement_lag_rad"))
LAST_CYCLES = 5
"""The response is measured over the last cycles, when the mean stress has come up."""

SERVO_COLUMNS = (
    *IDENTITY,
    "law",
    "cycle",
    "gain",
    "gain_step_s",
    "stress_min_Pa",
    "stress_max_Pa",
    "amplitude_ratio",
    "lag_rad",
    "bed_stiffness_N_m",
    "bed_loss_angle_rad",
    "contacts",
    "contact_stiffness_N_m",
    "time_constant_s",
    "predicted_amplitude_ratio",
    "predicted_lag_rad",
    "true_load_stiffness_N_m",
    "forecast_amplitude_ratio",
    "forecast_lag_rad",
)

ELASTIC_COLUMNS = (
    "run",
    "scenario",
    "reading",
    "code",
    "seed",
    "cycle",
    "stress_before_Pa",
    "settlement_m",
    "elastic_m",
    "permanent_m",
)


def transfer(omega: float, time_constant: complex) -> complex:
    """What passes the filter: stress over target, both complex amplitudes."""
    return 1 / (1 + 1j * omega * time_constant)


def response(member: Member) -> dict:
    """Measured over the last cycles of one run: extremes of stress; of the first harmonics the share of the target's
    amplitude, the lag behind it, and the bed's dynamic stiffness with its loss angle. nan without harmonics.
    """
    rows, waves = member.run.cycles.tail(LAST_CYCLES), member.run.harmonics.tail(LAST_CYCLES)
    target = waves["target_amplitude_Pa"].to_numpy()
    stress, settlement = (_complex(waves, *names) for names in HARMONICS)
    known = len(waves) > 0
    passed = complex(np.mean(stress / target)) if known else complex(math.nan)
    stiffness = complex(np.mean(stress / settlement)) if known else complex(math.nan)
    return {
        "cycle": last_cycle(member.run),
        "stress_min_Pa": rows["sleeper_stress_min_Pa"].mean(),
        "stress_max_Pa": rows["sleeper_stress_max_Pa"].mean(),
        "amplitude_ratio": abs(passed),
        "lag_rad": -cmath.phase(passed),
        "bed_stiffness_N_m": derived.apparatus(member.run.scenario).sleeper_area_m2 * abs(stiffness),
        "bed_loss_angle_rad": cmath.phase(stiffness),
    }


def _complex(waves: pd.DataFrame, amplitude: str, late: str) -> np.ndarray:
    return waves[amplitude].to_numpy() * np.exp(-1j * waves[late].to_numpy())


def _bed(measured: dict) -> complex:
    """Dynamic stiffness of the bed, N/m."""
    return cmath.rect(measured["bed_stiffness_N_m"], measured["bed_loss_angle_rad"])


def sleeper_contacts(member: Member) -> float:
    """Contacts of the sleeper, as counted last; nan where nobody counted."""
    counted = member.run.microstructure["sleeper_contacts"].iloc[1:].dropna()
    return float(counted.iloc[-1]) if len(counted) else math.nan


def gain_step(scenario) -> float:
    """The time step in the servo's gain, s: what the scenario says, else the run's own."""
    parameters = scenario.parameters
    given = parameters["load_control.pfc_time_step"].value if "load_control.pfc_time_step" in parameters else 0.0
    return given or derived.time_grid(scenario).step_s


def servo_table(found: Iterable[Member]) -> pd.DataFrame:
    """Every run by the servo: what was measured, and what the filter predicts (columns SERVO_COLUMNS).

    contacts, contact_stiffness_N_m   of the sleeper: counted at its least load, and times k_n
    predicted_...                     from these, the measured dynamic stiffness of the bed and the gain
    forecast_...                      the same with the stiffness of the same bed under the true load, not of this run
    """
    found = [m for m in found if m.run.scenario is not None]
    prescribed = {m.of_bed: response(m) for m in found if m.plain and m.reading == TRUE_LOAD}
    rows = []
    for m in found:
        if m.reading != SERVO:
            continue
        s, measured = m.run.scenario, response(m)
        omega, gain, step = 2 * math.pi * s["loading.frequency"], s["load_control.pfc_gain"], gain_step(s)
        contacts = sleeper_contacts(m)
        stiffness = contacts * s["contact.particle_wall.normal_stiffness"]
        time_constant = stiffness * step / (gain * _bed(measured))
        passed = transfer(omega, time_constant)
        true = prescribed.get(m.of_bed) if m.plain else None
        forecast = transfer(omega, stiffness * step / (gain * _bed(true))) if true else complex(math.nan, math.nan)
        rows.append(
            m.identity
            | {"law": s["contact.model"], "gain": gain, "gain_step_s": step}
            | measured
            | {
                "contacts": contacts,
                "contact_stiffness_N_m": stiffness,
                "time_constant_s": abs(time_constant),
                "predicted_amplitude_ratio": abs(passed),
                "predicted_lag_rad": -cmath.phase(passed),
                "true_load_stiffness_N_m": true["bed_stiffness_N_m"] if true else math.nan,
                "forecast_amplitude_ratio": abs(forecast),
                "forecast_lag_rad": -cmath.phase(forecast),
            }
        )
    return pd.DataFrame(rows, columns=SERVO_COLUMNS)


def elastic_table(found: Iterable[Member]) -> pd.DataFrame:
    """Settlement split into what springs back at the least prescribed stress and what stays (columns ELASTIC_COLUMNS).

    Measured, in runs that have unload.csv. It is not estimated elsewhere: rows of a cycle's end and middle lag behind a
    servo's stress, so the stroke does not follow from them.
    """
    rows = []
    for m in found:
        if m.run.scenario is None:
            continue
        for cycle, row in m.run.unloaded.set_index("cycle").iterrows():
            rows.append(
                m.identity
                | {
                    "cycle": int(cycle),
                    "stress_before_Pa": row["stress_before_Pa"],
                    "settlement_m": row["settlement_before_m"],
                    "elastic_m": row["settlement_before_m"] - row["settlement_after_m"],
                    "permanent_m": row["settlement_after_m"],
                }
            )
    return pd.DataFrame(rows, columns=ELASTIC_COLUMNS)
