"""All findings of a set of runs: `find(runs, references)`; no HTML, no millimetres, no sentence."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path

import pandas as pd

from analysis.comparison.claims import verdicts as judged
from analysis.comparison.findings import (
    agreement,
    bond_counts,
    influence,
    laws,
    plate_laws,
    runs,
    servo,
    stock_models,
    timestep_spread,
)
from analysis.comparison.findings.columns import describe
from analysis.comparison.findings.members import Member, choose, groups, members
from analysis.files import KEPT_RUNS
from analysis.formats import kept_tables
from analysis.formats.errors import InputError
from analysis.normalised.readers import Run
from analysis.reference.curves import References
from analysis.scenarios.scenario import load_scenario
from analysis.scenarios.study_list import key_scenarios


@dataclass(frozen=True)
class Findings:
    """Tidy frames, SI units in every column's name; `members` are the runs that they come from.

    coverage         every run and how far it got
    values           quantities after shown cycles: mean, least and largest over the beds that reach the cycle
    scatter          between beds, pooled over the scenarios of a contact model and reading
    agreement        LIGGGHTS against YADE, each from its own beds, at equal cycles, with a state
    same_bed         pairs of runs from one bed that differ in code, time step or rounding alone
    same_bed_verdicts   whether the codes differ by no more than time step and rounding do
    rates            settlement per cycle in spans of cycles, with the trend up to each
    settlement_laws  which law describes each settlement curve
    packed_beds      after packing and after preload
    load_tracking    how the prescribed load was met
    servo            PFC's servo: measured and predicted response
    elastic          settlement split into what springs back and what stays
    bonds            parallel bonds made and broken
    influence        one thing changed at a time
    plate_laws       what the law that holds the plates decides
    stock            each code's own contact models against the paper's laws
    calibration      beds that `make calibrate` tried
    timestep, benchmark, benchmark_sizes, benchmark_profile
                     what `make timestep` and `make bench` kept, as they wrote it
    timestep_spread  by how much settlement varies over time steps, packed beds and rounding
    verdicts         the paper's claims, part by part
    readings         which of them the reading of the load decides
    computing_time   cost of a cycle
    pending          what is missing: a row per thing

    `problems` has a line for each kept table that cannot be read; its finding has no rows.
    """

    members: tuple[Member, ...]
    problems: tuple[str, ...]
    coverage: pd.DataFrame
    values: pd.DataFrame
    scatter: pd.DataFrame
    agreement: pd.DataFrame
    same_bed: pd.DataFrame
    same_bed_verdicts: pd.DataFrame
    rates: pd.DataFrame
    settlement_laws: pd.DataFrame
    packed_beds: pd.DataFrame
    load_tracking: pd.DataFrame
    servo: pd.DataFrame
    elastic: pd.DataFrame
    bonds: pd.DataFrame
    influence: pd.DataFrame
    plate_laws: pd.DataFrame
    stock: pd.DataFrame
    calibration: pd.DataFrame
    timestep: pd.DataFrame
    benchmark: pd.DataFrame
    benchmark_sizes: pd.DataFrame
    benchmark_profile: pd.DataFrame
    timestep_spread: pd.DataFrame
    verdicts: pd.DataFrame
    readings: pd.DataFrame
    computing_time: pd.DataFrame
    pending: pd.DataFrame

    def frames(self) -> dict[str, pd.DataFrame]:
        """Every table by its name."""
        return {f.name: getattr(self, f.name) for f in fields(self) if f.name not in ("members", "problems")}

    def write(self, folder: Path) -> list[Path]:
        """Write each table as a CSV file into `folder`, and columns.csv, which says what they hold; returns the
        paths.
        """
        folder.mkdir(parents=True, exist_ok=True)
        paths = []
        for name, frame in self.frames().items():
            paths.append(folder / f"{name}.csv")
            frame.to_csv(paths[-1], index=False, float_format="%.9g", lineterminator="\n")
        paths.append(folder / "columns.csv")
        describe(self.frames().values()).to_csv(paths[-1], index=False, lineterminator="\n")
        return paths


def find(
    found: Iterable[Run], references: References, paper_scenarios: Iterable[str] = (), folder: Path = KEPT_RUNS
) -> Findings:
    """Everything that the runs say.

    paper_scenarios   names that count as missing where they have no full-size run
    folder            where calibration.csv, timestep.csv and benchmark.csv are kept
    """
    chosen, _ = choose(found)
    listed = members(chosen)
    values = agreement.seed_values(listed)
    scatter = agreement.scatter_table(values)
    pairs = agreement.same_bed_table(listed)
    verdicts = judged.evaluate_claims([m.run for m in listed if m.plain], references)
    kept, problems = _kept_tables(folder)
    return Findings(
        members=tuple(listed),
        problems=tuple(problems),
        coverage=runs.coverage_table(listed),
        values=agreement.band_table(values),
        scatter=scatter,
        agreement=agreement.agreement_table(values, scatter),
        same_bed=pairs,
        same_bed_verdicts=agreement.same_bed_verdicts(pairs, kept["timestep"]),
        rates=runs.rates_table(listed),
        settlement_laws=laws.laws_table(listed),
        packed_beds=runs.packed_beds_table(listed),
        load_tracking=runs.load_table(listed),
        servo=servo.servo_table(listed),
        elastic=servo.elastic_table(listed),
        bonds=bond_counts.bonds_table(listed),
        influence=influence.influence_table(listed, scatter),
        plate_laws=plate_laws.plate_laws_table(listed),
        stock=stock_models.stock_table(listed, scatter),
        **kept,
        timestep_spread=timestep_spread.timestep_spread_table(kept["timestep"]),
        verdicts=judged.to_frame(verdicts),
        readings=judged.compare_readings(verdicts),
        computing_time=runs.computing_time_table(listed),
        pending=_pending(listed, references, paper_scenarios),
    )


KEPT_TABLES = {
    "calibration": kept_tables.CALIBRATION,
    "timestep": kept_tables.TIMESTEP,
    "benchmark": kept_tables.BENCHMARK,
    "benchmark_sizes": kept_tables.BENCHMARK_SIZES,
    "benchmark_profile": kept_tables.BENCHMARK_PROFILE,
}


def _kept_tables(folder: Path) -> tuple[dict[str, pd.DataFrame], list[str]]:
    """The tables kept in the repository, no rows where one is missing or damaged, and a line per damaged one."""
    frames, problems = dict.fromkeys(KEPT_TABLES, pd.DataFrame()), []
    for name, table in KEPT_TABLES.items():
        path = folder / f"{name}.csv"
        if not path.exists() and not path.is_symlink():
            continue
        try:
            frames[name] = pd.DataFrame(kept_tables.read(path, table))
        except InputError as error:
            problems.append(str(error))
    return frames, problems


def _pending(listed: list[Member], references: References, paper_scenarios: Iterable[str]) -> pd.DataFrame:
    """What is missing: kind (scenario, cycles, seeds, reference), scenario, reading, code, have, want."""
    rows = []
    full = {key[1:]: found for key, found in groups(listed).items() if key[0] == "full"}
    cycles = load_scenario(key_scenarios()[0], "full")["loading.cycles"] if full else 0
    there = {scenario for scenario, *_ in full}
    for name in paper_scenarios:
        if name not in there:
            rows.append({"kind": "scenario", "scenario": name, "have": 0, "want": 1})
    for (scenario, reading, code), found in full.items():
        where = {"scenario": scenario, "reading": reading, "code": code}
        longest = max(int(m.run.cycles["cycle"].iloc[-1]) for m in found)
        if longest < cycles:
            rows.append({"kind": "cycles", **where, "have": longest, "want": cycles})
        if len(found) < 3:
            rows.append({"kind": "seeds", **where, "have": len(found), "want": 3})
    for (source, kind), part in references.pending.groupby(["source", "kind"], sort=True):
        rows.append({"kind": "reference", "scenario": f"{source} ({kind})", "have": 0, "want": len(part)})
    return pd.DataFrame(rows, columns=["kind", "scenario", "reading", "code", "have", "want"])
