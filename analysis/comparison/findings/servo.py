"""PFC's servo as a first-order filter: what it makes of the prescribed load.

The servo moves the sleeper at v = G (F_target - F), G = gain / (K_c dt); the bed answers with dF = K_bed dx. Together
dF/dt = (F_target - F) / tau with tau = K_c dt / (gain K_bed). Of a sinusoid of angular frequency w the amplitude
passes by
1 / sqrt(1 + (w tau)^2), late by the phase atan(w tau). K_c is the sum of the stiffnesses of the sleeper's contacts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pandas as pd

from analysis.comparison.findings.members import SERVO, Member
from analysis.comparison.quantities import last_cycle
from analysis.formats.file_columns import UNLOAD
from analysis.scenarios import derived

LAST_CYCLES = 5
"""The response is measured over the last cycles, when the mean stress has come up."""

SERVO_COLUMNS = (
    "run",
    "profile",
    "scenario",
    "variant",
    "reading",
    "code",
    "seed",
    "law",
    "cycle",
    "gain",
    "gain_step_s",
    "stress_min_Pa",
    "stress_max_Pa",
    "amplitude_ratio",
    "lag_rad",
    "lag_from",
    "bed_stiffness_N_m",
    "time_constant_s",
    "contact_stiffness_N_m",
    "contacts",
    "predicted_time_constant_s",
    "predicted_amplitude_ratio",
    "predicted_lag_rad",
)

ELASTIC_COLUMNS = (
    "run",
    "scenario",
    "reading",
    "code",
    "cycle",
    "stress_before_Pa",
    "settlement_m",
    "elastic_m",
    "permanent_m",
)

UNLOAD_FILE = "unload.csv"
"""What springs back when a copy of a run is slowly unloaded to the least stress (`make unload`): columns UNLOAD."""


def amplitude_ratio(omega_tau: float) -> float:
    """Share of a sinusoid's amplitude that passes the filter."""
    return 1 / math.hypot(1, omega_tau)


def lag(omega_tau: float) -> float:
    """Phase by which it comes late, rad."""
    return math.atan(omega_tau)


def omega_tau_of(ratio: float) -> float:
    """The filter's w tau from the amplitude ratio that it was measured by; nan where nothing is lost."""
    return math.sqrt(1 / ratio**2 - 1) if 0 < ratio < 1 else math.nan


def lag_of_error(rms: float, amplitude: float) -> float:
    """Phase lag of a first-order filter from the rms error of tracking: |1 - H| = sin(lag), rad."""
    share = math.sqrt(2) * rms / amplitude
    return math.asin(share) if 0 <= share <= 1 else math.nan


def response(m: Member) -> dict:
    """Measured over the last cycles of one run: extremes of stress, amplitude ratio, lag, stiffness of the bed.

    The lag is that of the fundamental where history.csv is there, else what the rms tracking error says of such a
    filter.
    """
    s, rows = m.run.scenario, m.run.cycles.tail(LAST_CYCLES)
    low, high = rows["sleeper_stress_min_Pa"].mean(), rows["sleeper_stress_max_Pa"].mean()
    wanted = (s["loading.stress_max"] - s["loading.stress_min"]) / 2
    ratio = (high - low) / 2 / wanted
    stroke = (rows["settlement_peak_m"] - rows["settlement_m"]).mean()
    area = derived.apparatus(s).sleeper_area_m2
    stiffness = area * (high - low) / stroke if stroke > 0 else math.nan
    late, source = fundamental_lag(m), "history.csv"
    if math.isnan(late):
        late, source = lag_of_error(float(rows["tracking_rms_Pa"].mean()), wanted), "tracking error"
    return {
        "cycle": last_cycle(m.run),
        "stress_min_Pa": low,
        "stress_max_Pa": high,
        "amplitude_ratio": ratio,
        "lag_rad": late,
        "lag_from": source,
        "bed_stiffness_N_m": stiffness,
    }


def fundamental_lag(m: Member) -> float:
    """Phase of the stress behind its target at the load's frequency, over the last cycles of history.csv; nan
    without.
    """
    history = m.run.history[["cycle", "sleeper_target_Pa", "sleeper_stress_Pa"]].dropna()
    done = last_cycle(m.run)
    inside = history[(history["cycle"] > max(done - LAST_CYCLES, 0) + 1e-9) & (history["cycle"] <= done + 1e-9)]
    if len(inside) < 16:
        return math.nan
    wave = np.exp(-2j * math.pi * inside["cycle"].to_numpy())
    target, stress = (np.mean(inside[c].to_numpy() * wave) for c in ("sleeper_target_Pa", "sleeper_stress_Pa"))
    return float(np.angle(target / stress)) if abs(target) and abs(stress) else math.nan


def gain_step(scenario) -> float:
    """The time step in the servo's gain, s: what the scenario says, else the run's own."""
    parameters = scenario.parameters
    given = parameters["load_control.pfc_time_step"].value if "load_control.pfc_time_step" in parameters else 0.0
    return given or derived.time_grid(scenario).step_s


def servo_table(found: Iterable[Member]) -> pd.DataFrame:
    """Every run by the servo: what was measured, and what the filter predicts (columns SERVO_COLUMNS).

    time_constant_s         from the measured amplitude ratio
    contact_stiffness_N_m   that this takes: gain K_bed tau / dt
    contacts                its number of wall contacts
    predicted_...           with the contacts per load of the same scenario's run at the default gain, so that nothing
    is
                            fitted but one number per scenario; nan for that run itself
    """
    rows = []
    for m in found:
        if m.reading != SERVO or m.run.scenario is None:
            continue
        s, measured = m.run.scenario, response(m)
        omega = 2 * math.pi * s["loading.frequency"]
        gain, step = s["load_control.pfc_gain"], gain_step(s)
        tau = omega_tau_of(measured["amplitude_ratio"]) / omega
        stiffness = gain * measured["bed_stiffness_N_m"] * tau / step
        rows.append(
            m.identity
            | {"law": s["contact.model"], "gain": gain, "gain_step_s": step}
            | measured
            | {
                "time_constant_s": tau,
                "contact_stiffness_N_m": stiffness,
                "contacts": stiffness / s["contact.particle_wall.normal_stiffness"],
                "omega": omega,
            }
        )
    table = pd.DataFrame(rows)
    return _predicted(table)[list(SERVO_COLUMNS)] if len(table) else pd.DataFrame(columns=SERVO_COLUMNS)


def _predicted(table: pd.DataFrame) -> pd.DataFrame:
    """Predictions from the contact stiffness of the law's plain run: the same sleeper on a bed of the same recipe."""
    table = table.assign(
        predicted_time_constant_s=math.nan, predicted_amplitude_ratio=math.nan, predicted_lag_rad=math.nan
    )
    plain = table[table["variant"] == SERVO]
    for n, row in table.iterrows():
        basis = plain[(plain["law"] == row["law"]) & (plain["profile"] == row["profile"])]
        same = basis[basis["scenario"] == row["scenario"]]
        basis = (same if len(same) else basis).drop(index=n, errors="ignore")
        basis = basis[np.isfinite(basis["contact_stiffness_N_m"])]
        if basis.empty or not row["bed_stiffness_N_m"] > 0:
            continue
        tau = basis["contact_stiffness_N_m"].mean() * row["gain_step_s"] / (row["gain"] * row["bed_stiffness_N_m"])
        table.loc[n, "predicted_time_constant_s"] = tau
        table.loc[n, "predicted_amplitude_ratio"] = amplitude_ratio(row["omega"] * tau)
        table.loc[n, "predicted_lag_rad"] = lag(row["omega"] * tau)
    return table


def elastic_table(found: Iterable[Member]) -> pd.DataFrame:
    """Settlement split into what springs back at the least prescribed stress and what stays (columns ELASTIC_COLUMNS).

    Measured, in runs that have unload.csv. It is not estimated elsewhere: rows of a cycle's end and middle lag behind a
    servo's stress, so the stroke does not follow from them.
    """
    rows = []
    for m in found:
        if m.run.scenario is None:
            continue
        for cycle, row in read_unload(m).iterrows():
            rows.append(
                {
                    "run": m.run.id,
                    "scenario": m.scenario,
                    "reading": m.reading,
                    "code": m.run.code,
                    "cycle": int(cycle),
                    "stress_before_Pa": row["stress_before_Pa"],
                    "settlement_m": row["settlement_before_m"],
                    "elastic_m": row["settlement_before_m"] - row["settlement_after_m"],
                    "permanent_m": row["settlement_after_m"],
                }
            )
    return pd.DataFrame(rows, columns=ELASTIC_COLUMNS)


def read_unload(m: Member) -> pd.DataFrame:
    """unload.csv of a run by cycle; no rows without one. Raises ValueError naming the file where a column is
    missing.
    """
    path = m.run.folder / UNLOAD_FILE
    if not path.exists():
        return pd.DataFrame(columns=UNLOAD[1:])
    table = pd.read_csv(path)
    missing = [name for name in UNLOAD if name not in table]
    if missing:
        raise ValueError(f"{m.run.id}/{UNLOAD_FILE}: column {missing[0]} is missing; it has {','.join(UNLOAD)}")
    return table.set_index("cycle")
