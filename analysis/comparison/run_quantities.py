"""What is measured on a run: cycle by cycle, over depth, and as a summary in which nothing is silently missing.

Functions take a `readers.Run` (or anything with its attributes). SI units; nan where the run cannot say.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np
import pandas as pd

from analysis.comparison import settlement_fits
from analysis.formats import file_columns
from analysis.formats.quantities import QUANTITIES, row_of
from analysis.normalised.sleeper_work import sleeper_work
from analysis.scenarios import derived

CYCLES_SHOWN = (1, 10, 100, 1000)
LEAST_LATE_CYCLES = 10
"""A late slope takes at least this many cycles."""

RATE_EDGES = (0, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
"""Cycles between which the rate of settling is taken: a logarithm falls by half or more from each span to the next."""
RATES = ("first_cycle", "last_cycle", "settlement_rate_m", "lateral_rate_m", "crib_heave_rate_m")

OF_CYCLES = (
    "settlement_m",
    "settlement_peak_m",
    *row_of("lateral_{}_m"),
    *row_of("porosity_{}"),
    "tracking_rms_Pa",
    "clumps",
)
OF_BEDS = (
    "bulge_volume_m3",
    "shoulder_displacement_m",
    "crib_heave_m",
    "coordination_number",
    "overlap_mean_m",
    "overlap_max_ratio",
    "rotation_mean_rad",
    "sliding_share",
    "at_limit_share",
)
OF_CONTACTS = (
    "normal_force_mean_N",
    "contact_anisotropy",
    "force_anisotropy",
    "force_chain_share",
    "force_chain_load_share",
)
"""What a summary tells of each table."""
NOT_SUMMED_UP = ("cycle", "settlement_increment_m", "tracking_ratio")
"""Columns of `per_cycle` that a summary leaves out: they are told otherwise."""
SUMMARY = ("quantity", "cycle", "value", "low", "high", "unit", "missing")


def last_cycle(run) -> int:
    """Number of the last finished cycle; 0 without one."""
    return int(run.cycles["cycle"].iloc[-1]) if len(run.cycles) else 0


# ---------------------------------------------------------------------- cycle by cycle


class ValuesOfRun:
    """What a formula may name: the columns of a run's cycles.csv, quantities that follow from them, and parameters."""

    def __init__(self, run):
        self.run, self._follow = run, {}

    def __getitem__(self, name: str):
        """A column (cycles,), worked out when it is first asked for, or the value of a parameter, nan without a
        scenario.
        """
        if name in self.run.cycles:
            return self.run.cycles[name]
        if formula := formula_of(name):
            if name not in self._follow:
                with np.errstate(divide="ignore", invalid="ignore"):
                    self._follow[name] = formula(self)
            return self._follow[name]
        return self.run.scenario[name] if self.run.scenario is not None else math.nan


def formula_of(name: str) -> Callable[[ValuesOfRun], pd.Series] | None:
    """How a quantity follows after each cycle: the formula of its row in the registry, or the function in FUNCTIONS;
    None where it is stored, or no quantity.
    """
    return (QUANTITIES[name].formula or FUNCTIONS.get(name)) if name in QUANTITIES else None


def per_cycle(run) -> pd.DataFrame:
    """What follows for each finished cycle: `cycle`, and by name each quantity that has a formula.

    Loads and work are those of the scenario's width: a narrower box carries less.
    """
    values = ValuesOfRun(run)
    return pd.DataFrame({name: values[name] for name in ("cycle", *filter(formula_of, QUANTITIES))})


def value_after(run, name: str, cycle: int) -> float:
    """Any quantity of a run's tables after `cycle`, in SI units; nan where the run cannot say it."""
    table = run.microstructure if name not in run.cycles and name in run.microstructure else run.cycles
    values = table if name in table else ValuesOfRun(run)
    found = values[name][table["cycle"] == cycle]
    return float(found.iloc[0]) if len(found) else math.nan


def _increment(values: ValuesOfRun) -> pd.Series:
    """What each cycle adds to the settlement; nan after a lost row."""
    cycle, settlement = values["cycle"], values["settlement_m"]
    follows = cycle.diff().fillna(cycle) == 1
    return settlement.diff().fillna(settlement).where(follows)


LEAST_FOLLOWED = 0.9
"""Of the prescribed range of stress: a bed that gets less of it also gets it late, so that its settlement at the end
and in the middle of a cycle is not that at the least and the greatest stress."""


def _stroke(values: ValuesOfRun) -> pd.Series:
    """What springs back in each cycle, m; nan where the stress does not follow its target."""
    applied = values["sleeper_stress_max_Pa"] - values["sleeper_stress_min_Pa"]
    wanted = values["loading.stress_max"] - values["loading.stress_min"]
    stroke = values["settlement_peak_m"] - values["settlement_m"]
    return stroke.mask(applied < LEAST_FOLLOWED * wanted)


def _stiffness(values: ValuesOfRun) -> pd.Series:
    """Range of the load over the stroke, N/m."""
    scenario, stroke = values.run.scenario, values["resilient_stroke_m"]
    area = derived.apparatus(scenario).sleeper_area_m2 if scenario is not None else math.nan
    return area * (values["sleeper_stress_max_Pa"] - values["sleeper_stress_min_Pa"]) / stroke.where(stroke > 0)


def _loop_energy(values: ValuesOfRun) -> pd.Series:
    """Work of the load in each cycle, J."""
    run = values.run
    return values["cycle"].map(sleeper_work(run) or harmonic_energy(run)).astype(float)


def _porosity_spread(values: ValuesOfRun) -> pd.Series:
    """Largest minus smallest porosity; nan where one is unknown."""
    spheres = values.run.cycles[list(row_of("porosity_{}"))]
    return spheres.max(axis=1, skipna=False) - spheres.min(axis=1, skipna=False)


def lateral_mean(cycles: pd.DataFrame) -> pd.Series:
    """Mean displacement of the five plates after each cycle, m; nan where one is unknown."""
    return cycles[list(row_of("lateral_{}_m"))].mean(axis=1, skipna=False)


FUNCTIONS: dict[str, Callable[[ValuesOfRun], pd.Series]] = {
    "settlement_increment_m": _increment,
    "lateral_mean_m": lambda values: lateral_mean(values.run.cycles),
    "resilient_stroke_m": _stroke,
    "secant_stiffness_N_m": _stiffness,
    "loop_energy_J": _loop_energy,
    "porosity_spread": _porosity_spread,
}
"""Quantities that follow after each cycle and whose formula takes more than a line."""


def harmonic_energy(run) -> dict[int, float]:
    """What `sleeper_work` gives, from the first harmonics of a run kept without its history: {cycle: work in J}.

    Exact for a sinusoidal load F_0 + F_1 cos: by parts, its work is F_1 x_1 pi sin(lag of x behind F), and the load at
    the cycle's end times the cycle's permanent settlement.
    """
    if run.scenario is None or (run.folder / "history.csv").exists():
        return {}
    table = run.cycles.merge(run.harmonics, on="cycle")
    area = derived.apparatus(run.scenario).sleeper_area_m2
    behind = np.sin(table["settlement_lag_rad"] - table["stress_lag_rad"])
    loop = np.pi * table["stress_amplitude_Pa"] * table["settlement_amplitude_m"] * behind
    mean = (table["sleeper_stress_min_Pa"] + table["sleeper_stress_max_Pa"]) / 2
    at_end = mean - table["stress_amplitude_Pa"] * np.cos(table["stress_lag_rad"])
    permanent = at_end * table["settlement_m"].diff().fillna(table["settlement_m"])
    return dict(zip(table["cycle"], area * (loop + permanent), strict=True))


# ---------------------------------------------------------------------- over depth


def plate_depths(scenario) -> np.ndarray:
    """Depth of the plates' middles below the sleeper's base before loading, plate 1 (bottom) to 5, m."""
    box = derived.apparatus(scenario)
    return np.array([box.sleeper.low[2] - (plate.low[2] + plate.high[2]) / 2 for plate in box.plates])


def lateral_profile(run, cycles: Sequence[int] = CYCLES_SHOWN) -> pd.DataFrame:
    """Lateral displacement against depth after those of `cycles` that the run has: cycle, plate, depth_m, lateral_m."""
    depth = plate_depths(run.scenario) if run.scenario is not None else np.full(5, math.nan)
    rows = run.cycles[run.cycles["cycle"].isin(cycles)]
    return pd.DataFrame(
        [
            (row["cycle"], k, depth[k - 1], row[f"lateral_{k}_m"])
            for _, row in rows.iterrows()
            for k in file_columns.PLATES
        ],
        columns=["cycle", "plate", "depth_m", "lateral_m"],
    ).astype({"cycle": int, "plate": int})


# ---------------------------------------------------------------------- the late part


def late_slope(
    cycles, values, first: int | None = None, last: int | None = None, level: float = 0.95
) -> tuple[float, float, float]:
    """Slope of `values` per cycle and its confidence interval, over `first` (default: half of the last) to `last`.

    The interval knows that the scatter of a settlement curve accumulates. (nan, nan, nan) with fewer than 10 cycles.
    """
    cycles, values = np.asarray(cycles, dtype=float), np.asarray(values, dtype=float)
    usable = np.isfinite(cycles) & np.isfinite(values)
    cycles, values = cycles[usable], values[usable]
    if len(cycles):
        last = cycles[-1] if last is None else last
        inside = (cycles >= (last / 2 if first is None else first)) & (cycles <= last)
        cycles, values = cycles[inside], values[inside]
    if len(cycles) < LEAST_LATE_CYCLES:
        return math.nan, math.nan, math.nan
    fitted = settlement_fits.fit("line", cycles, values, level=level)
    return fitted.values["b"], *fitted.intervals["b"]


def settling_rates(run) -> pd.DataFrame:
    """How fast a run settles, its plates move out and its cribs heave, m per cycle, in spans of cycles (columns RATES).

    The spans end at RATE_EDGES and at the last cycle, where that leaves at least half of a span.
    """
    cycles, done = run.cycles.set_index("cycle"), last_cycle(run)
    edges = [n for n in RATE_EDGES if n <= done]
    if edges and len(edges) < len(RATE_EDGES) and 2 * (done - edges[-1]) >= RATE_EDGES[len(edges)] - edges[-1]:
        edges.append(done)
    inner = run.microstructure.set_index("cycle")["crib_heave_m"]
    whole = pd.DataFrame(
        {
            "settlement_rate_m": cycles["settlement_m"],
            "lateral_rate_m": lateral_mean(cycles),
            "crib_heave_rate_m": inner[~inner.index.duplicated()],
        }
    ).reindex(edges)
    whole.loc[whole.index == 0] = 0.0  # all three are zero at the end of preload
    rates = whole.diff().div(np.diff(edges, prepend=np.nan), axis=0).iloc[1:]
    return rates.reset_index(drop=True).assign(first_cycle=edges[:-1], last_cycle=edges[1:])[list(RATES)]


def trend_of(rates: Sequence[float]) -> str:
    """Whether settling slows down: "slowing", "steady", "growing", or "" with too few spans to say.

    From the last of the rates (of `settling_rates`) over the one before: below 0.8 it slows down, above 1.25 it grows.
    """
    rates = np.asarray(rates, dtype=float)
    if len(rates) < 3 or not np.isfinite(rates[-2:]).all() or rates[-2] <= 0:
        return ""
    ratio = rates[-1] / rates[-2]
    return "slowing" if ratio < 0.8 else "growing" if ratio > 1.25 else "steady"


# ---------------------------------------------------------------------- summary


def summary(run, cycles: Sequence[int] = CYCLES_SHOWN) -> pd.DataFrame:
    """All quantities of a run, tidy (columns SUMMARY): after each of `cycles` and the last, or with the reason why not.

    low, high   95 % confidence interval where there is one
    unit        of value, low and high
    missing     empty, or why the value is nan
    """
    return pd.concat([after_cycles(run, cycles), fitted(run)], ignore_index=True)


def after_cycles(run, cycles: Sequence[int] = CYCLES_SHOWN) -> pd.DataFrame:
    """The part of `summary` that is measured after single cycles."""
    rows: list[tuple] = []
    done = int(run.cycles["cycle"].max()) if len(run.cycles) else 0
    wanted = [*(n for n in cycles if n != done), *([done] if done else [])]
    follow = per_cycle(run)
    for table, at, names, source in (
        (run.cycles, wanted, OF_CYCLES, "cycles.csv"),
        (follow, wanted, [name for name in follow if name not in NOT_SUMMED_UP], "history.csv"),
        (run.microstructure, [0, *wanted], OF_BEDS, "microstructure.csv"),
        (run.microstructure, [0, *wanted], OF_CONTACTS, "microstructure.csv (contacts of that cycle)"),
    ):
        _add_at(rows, table, at, done, names, source)
    return pd.DataFrame(rows, columns=SUMMARY)


def fitted(run) -> pd.DataFrame:
    """The part of `summary` that is fitted to the whole curve: late slope, parameters of the exponential law."""
    done = int(run.cycles["cycle"].max()) if len(run.cycles) else 0
    slope = late_slope(run.cycles["cycle"], run.cycles["settlement_m"])
    short = "" if slope[0] == slope[0] else f"the later half of {done} cycles has fewer than {LEAST_LATE_CYCLES}"
    rows = [("late_slope_m", done, *slope, "m per cycle", short)]
    choice = settlement_fits.choose(run.cycles["cycle"], run.cycles["settlement_m"])
    law = choice.fits.get("exponential")
    for name, unit in (("a", "m"), ("b", "m"), ("c", "cycles"), ("d", "m per cycle")):
        values = (law.values[name], *law.intervals[name]) if law else (math.nan,) * 3
        rows.append((f"exponential_{name}", done, *values, unit, "" if law else choice.reason))
    return pd.DataFrame(rows, columns=SUMMARY)


def _add_at(
    rows: list, table: pd.DataFrame, wanted: Sequence[int], done: int, names: Iterable[str], source: str
) -> None:
    by_cycle = table.set_index("cycle")
    for name in names:
        for n in wanted:
            value = float(by_cycle.at[n, name]) if n in by_cycle.index else math.nan
            if value == value:
                why = ""
            elif n > done:
                why = f"the run has {done} cycles"
            else:
                why = f"not in {source}"
            rows.append((name, n, value, math.nan, math.nan, QUANTITIES[name].unit, why))


def has_processor_time(run) -> bool:
    """Whether a run recorded the processor time of its cyclic loading."""
    return all((run.info.get(key) or {}).get("cyclic", 0) > 0 for key in ("cpu_s", "cpu_steps"))


def steps_per_second(run) -> float:
    """Steps of cyclic loading per second of processor time, of wall time in runs that did not record the other; nan
    where neither is known.
    """
    if has_processor_time(run):
        return run.info["cpu_steps"]["cyclic"] / run.info["cpu_s"]["cyclic"]
    speed = (run.info.get("steps_per_second") or {}).get("cyclic")
    return float(speed) if isinstance(speed, (int, float)) and speed > 0 else math.nan
