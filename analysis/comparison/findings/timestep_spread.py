"""What a change of the time step does to settlement, beside packing seeds and rounding."""

from __future__ import annotations

import pandas as pd

COLUMNS = ("scenario", "cycle", "steps_ratio", "beds_ratio", "rounding_ratio")


def timestep_spread_table(timestep: pd.DataFrame) -> pd.DataFrame:
    """By how much settlement after the last cycle varies over time steps, over packed beds and by rounding alone.

    timestep   what `make timestep` kept; scenarios without a run of the study's step are left out

    Columns COLUMNS; the ratios are standard deviations of the settlement over the mean of the study's step: ranges
    would grow with the number of runs.
    """
    if timestep.empty:
        return pd.DataFrame(columns=COLUMNS)
    last = timestep[(timestep["cycle"] == timestep["cycle"].max()) & (timestep["state"] == "done")]
    rows = []
    for scenario, part in last.groupby("scenario", sort=False):
        study, of_seeds = part["case"] == "verified", part["case"].str.startswith("seed")
        if not study.any():
            continue
        varied = {
            "steps": part[~of_seeds & (part["case"] != "rounding")],
            "beds": part[of_seeds | study],
            "rounding": part[study | (part["case"] == "rounding")],
        }
        mean = part.loc[study, "settlement_m"].mean()
        ratios = {f"{name}_ratio": runs["settlement_m"].std(ddof=1) / mean for name, runs in varied.items()}
        rows.append({"scenario": scenario, "cycle": int(part["cycle"].iloc[0])} | ratios)
    return pd.DataFrame(rows, columns=COLUMNS)
