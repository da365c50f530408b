"""How large may the time step be: the same bed at several steps, against other packing seeds and rounding.

`make timestep` loads the full bed for 20 cycles in LIGGGHTS at half the paper's step, the paper's, the study's, and
0.6, 0.7 and 0.8 of the critical step that was measured on the preloaded bed, all from one packed bed. At the study's
step it loads two more packing seeds, and the same bed on two ranks, which differ by rounding alone. Runs that exist
already, in results/ or kept in the repository, are not made again, whatever they were made for. The runs take hours;
reference_data/runs/timestep.csv is renewed after each, and what is not done yet is in it as pending.
`ballast timestep --collect` makes no run.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass

import pandas as pd

from analysis import files
from analysis.arguments import Parser
from analysis.driver import options
from analysis.driver.calibrate import load, shortened
from analysis.driver.engines import LIGGGHTS
from analysis.driver.settings import RESULTS, RunSettings, relative
from analysis.driver.supervise import Interrupted, StopRequest
from analysis.formats import kept_tables
from analysis.formats.quantities import row_of
from analysis.normalised import critical_step
from analysis.normalised.readers import TIMESTEP, Run, load_runs
from analysis.normalised.sleeper_work import sleeper_work
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario, load_scenario
from analysis.scenarios.schema import KEYS
from analysis.scenarios.study_list import key_scenarios

SCENARIO_WITH_DASHPOTS = "nonlinear-md1-en0.6"
"""Compared beside the key scenarios, whose contacts lose energy by friction alone."""
SHARES = (0.6, 0.7, 0.8)
SEEDS = (2, 3)
CYCLES = 20
SHOWN = (1, 2, 5, 10, 20)
SAME_STEP = 0.02
"""Relative: steps that differ by less count as one (a cycle has a whole number of them)."""
TABLE = files.KEPT_RUNS / "timestep.csv"


@dataclass(frozen=True)
class Wanted:
    """One run of the comparison."""

    scenario: str
    case: str
    """paper | verified | 0.8 | 0.7 | 0.6 (of the critical step) | half | seed 2 | seed 3 | rounding."""
    step_s: float
    seed: int = 1
    ranks: int = 1

    def is_done_by(self, run: Run) -> bool:
        """True for a run that is this one, however far it got."""
        return (
            run.base_name == self.scenario
            and run.code == LIGGGHTS.name
            and (run.seed, run.info.get("ranks", 1)) == (self.seed, self.ranks)
            and _same(_step(run), self.step_s)
        )


def wanted(name: str, critical_s: float) -> list[Wanted]:
    """All runs of one scenario, the most telling first."""
    own = load_scenario(name, "full")
    paper, verified = own["time.paper_step"], derived.time_grid(own).step_s
    steps = {"paper": paper, "verified": verified}
    steps |= {f"{share:g}": share * critical_s for share in reversed(SHARES) if not _same(share * critical_s, verified)}
    runs = [Wanted(name, case, step) for case, step in (steps | {"half": paper / 2}).items()]
    runs += [Wanted(name, f"seed {seed}", verified, seed) for seed in SEEDS]
    return [*runs, Wanted(name, "rounding", verified, ranks=2)]


def settings_of(want: Wanted, results, cycles: int = CYCLES) -> RunSettings:
    """How to make it: an ordinary run below results/timestep, from the packed bed of its seed."""
    scenario = load_scenario(want.scenario, "full", cycles=cycles).with_values({"time.step": want.step_s})
    bed = RunSettings(scenario, LIGGGHTS.name, seed=want.seed, results=results)
    packed = (bed.of_the_bed().folder if scenario["packing.bed_from"] else bed.folder) / "raw" / "bed_packed.csv"
    return RunSettings(
        scenario,
        LIGGGHTS.name,
        seed=want.seed,
        ranks=want.ranks,
        bed=packed if packed.exists() else None,
        results=results / TIMESTEP / want.case.replace(" ", "-"),
        cycles=cycles,
        lines=True,
    )


def only_time_differs(run: Run) -> bool:
    """True for a full-size run of LIGGGHTS that no variant changes but in its time step."""
    if run.code != LIGGGHTS.name or run.profile != "full" or run.scenario is None or not len(run.cycles):
        return False
    plain = load_scenario(run.base_name, "full")
    read = (key for key in plain.parameters if KEYS[key].matters("preload", "loading"))
    unread = ("time.", "load_control.pfc_") if "pfc" not in derived.wall_laws(plain, "cyclic").values() else ("time.",)
    return all(key.startswith(unread) or _equal(run, plain, key) for key in read)


def _equal(run: Run, plain: Scenario, key: str) -> bool:
    return key in run.scenario.parameters and run.scenario[key] == plain[key]


def _step(run: Run) -> float:
    return derived.time_grid(run.scenario).step_s


def _same(a: float, b: float) -> bool:
    return math.isclose(a, b, rel_tol=SAME_STEP)


def critical_of(runs: Iterable[Run], name: str) -> float:
    """Critical step (s) of a scenario's preloaded bed, from the first run that knows; nan where none does.

    Where stages.json does not have it, it is measured on the raw files. Runs of another scenario count where the laws
    of contact are as stiff: damping is not in it.
    """
    plain = load_scenario(name, "full")
    stiff = [key for key in plain.parameters if "stiffness" in key or key.endswith(("shear_modulus", "contact.model"))]
    for run in sorted(runs, key=lambda run: (run.base_name != name, run.id)):
        if all(_equal(run, plain, key) for key in stiff) and (found := _critical(run)):
            return found
    return math.nan


def _critical(run: Run) -> float | None:
    preload = run.stages.get("preload", {})
    bed, contacts = (run.folder / "raw" / f"{name}_preloaded.csv" for name in ("bed", "contacts"))
    if "critical_step_s" in preload or not (bed.exists() and contacts.exists()):
        return preload.get("critical_step_s")
    return critical_step.measure(bed, contacts, run.scenario, preload)


def rows_of(run: Run | None, want: Wanted, critical_s: float) -> list[dict]:
    """Rows of one run: of the shown cycles that it has, and one that says pending where it ends before the last."""
    step = _step(run) if run else want.step_s
    same = {
        "scenario": want.scenario,
        "case": want.case,
        "time_step_s": step,
        "critical_step_s": critical_s,
        "step_share": step / critical_s,
        "seed": want.seed,
        "ranks": want.ranks,
    }
    if not run:
        return [same | {"cycle": CYCLES, "state": "pending"}]
    same |= {"run": run.id, "bed": bed_of(run)}
    work = sleeper_work(run)
    cycles, energies = run.cycles.set_index("cycle"), run.microstructure.set_index("cycle")
    rows = [
        same
        | {name: cycles.at[n, name] for name in ("settlement_m", *row_of("lateral_{}_m"), *row_of("porosity_{}"))}
        | {"cycle": n, "kinetic_energy_J": energies["kinetic_energy_J"].get(n, math.nan)}
        | {"sleeper_work_J": work.get(n, math.nan), "state": "done"}
        for n in SHOWN
        if n in cycles.index
    ]
    return rows if CYCLES in cycles.index else [*rows, same | {"cycle": CYCLES, "state": "pending"}]


def bed_of(run: Run) -> str:
    """The packed bed that a run began from: the first digits of its checksum."""
    return str(run.stages.get("packing", {}).get("bed_sha256", ""))[:8]


def common_bed(runs: Iterable[Run], wants: Iterable[Wanted]) -> str:
    """The packed bed from which all steps are compared: that of the longest run with the study's step."""
    studied = (best(runs, want, "") for want in wants if want.case == "verified")
    return next((bed_of(run) for run in studied if run), "")


def best(runs: Iterable[Run], want: Wanted, bed: str) -> Run | None:
    """The longest run that is the wanted one; with the first seed it began from `bed`, if that is known."""
    fitting = [run for run in runs if want.is_done_by(run) and (want.seed != 1 or bed in ("", bed_of(run)))]
    return max(fitting, key=lambda run: (min(len(run.cycles), CYCLES), run.info.get("scenario_hash", "")), default=None)


def collect(results) -> tuple[pd.DataFrame, list[Wanted]]:
    """The table from all runs that exist, and what is still to be made."""
    folders = [results, files.KEPT_RUNS, *sorted((results / TIMESTEP).glob("*"))]
    runs = [run for folder in folders if folder.exists() for run in load_runs(folder) if only_time_differs(run)]
    rows, missing = [], []
    for name in (*reversed(key_scenarios()), SCENARIO_WITH_DASHPOTS):
        critical = critical_of(runs, name)
        wants = wanted(name, critical)
        bed = common_bed(runs, wants)
        for want in wants:
            run = best(runs, want, bed)
            rows += rows_of(run, want, critical)
            if (run is None or len(run.cycles) < CYCLES) and not math.isnan(want.step_s):
                missing.append(want)
    return pd.DataFrame(rows, columns=kept_tables.TIMESTEP.columns), missing


def write(table: pd.DataFrame) -> None:
    """Renew the table of the repository."""
    cells = table.astype(object).where(table.notna(), "").map(shortened)
    files.write_csv(TABLE, [list(table.columns), *cells.to_numpy().tolist()])


def add_arguments(parser: Parser) -> None:
    """Arguments of `ballast timestep`."""
    parser.add_argument("--collect", action="store_true", help="make no run, only the table from what there is")
    parser.add_argument("--scenario", nargs="+", metavar="NAME", help="make runs of these only")
    parser.add_argument("--results", type=options.path, default=RESULTS)


def execute(chosen: argparse.Namespace) -> int:
    """`ballast timestep`."""
    stop = StopRequest()
    table, missing = collect(chosen.results)
    write(table)
    for want in missing if not chosen.collect else ():
        if chosen.scenario and want.scenario not in chosen.scenario:
            continue
        try:
            load(settings_of(want, chosen.results), stop)
        except Interrupted:
            print("timestep: stopped; the same command goes on", file=sys.stderr)
            return 128 + stop.signal
        table, _ = collect(chosen.results)
        write(table)
    pending = table[table["state"] == "pending"]
    print(f"written: {relative(TABLE)}; {len(pending)} of {table.groupby(['scenario', 'case']).ngroups} runs pending")
    return 0
