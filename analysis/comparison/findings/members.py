"""What each run is to the study: its scenario, variants, reading of the load, and the bed it began from."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from analysis.comparison.run_quantities import last_cycle
from analysis.comparison.same_bed import ranks
from analysis.normalised.readers import Run

TRUE_LOAD, SERVO = "true load", "servo"
READINGS = (TRUE_LOAD, SERVO)
"""How the paper's "servo" can be read: the load is what is prescribed, or PFC's servo applies what it can."""

SERVO_VARIANT = "servo"
"""The variant of scenarios.toml that lays PFC's servo over a scenario."""

SAME_BED_VARIANT = "same-bed"

IDENTITY = ("run", "profile", "scenario", "variant", "reading", "code", "seed")
"""The first columns of every table with a row per run."""


@dataclass(frozen=True)
class Member:
    """A run with its place in the study.

    scenario   name without variants
    variants   that lie over it, in the order of the alphabet
    """

    run: Run
    scenario: str
    variants: tuple[str, ...]

    @cached_property
    def reading(self) -> str:
        """`true load` or `servo`, by the law that moves the sleeper."""
        if self.run.scenario is not None:
            return SERVO if self.run.scenario["load_control.sleeper_law"] == "pfc" else TRUE_LOAD
        return SERVO if SERVO_VARIANT in self.variants else TRUE_LOAD

    @property
    def own_bed(self) -> bool:
        """True where the run began from a bed that its own code packed; a file given by hand must say so by its
        name.
        """
        bed = str(self.run.info.get("bed", "own"))
        by_itself = bed.startswith(("own", "../../")) or not bed or self.run.code in bed
        return SAME_BED_VARIANT not in self.variants and by_itself

    @property
    def plain(self) -> bool:
        """True for a scenario as it stands, in either reading, from a bed of its own code."""
        return not set(self.variants) - {SERVO_VARIANT} and self.own_bed

    @property
    def others(self) -> tuple[str, ...]:
        """Variants but for the reading of the load."""
        return tuple(v for v in self.variants if v != SERVO_VARIANT)

    @property
    def key(self) -> tuple:
        """Profile, scenario, reading, code: what seeds are averaged over."""
        return self.run.profile, self.scenario, self.reading, self.run.code

    @property
    def of_bed(self) -> tuple:
        """Profile, scenario, code, seed: the same in both readings of one bed."""
        return self.run.profile, self.scenario, self.run.code, self.run.seed

    @property
    def bed(self) -> str:
        """Checksum of the packed bed; empty where it is not known."""
        return str(self.run.stages.get("packing", {}).get("bed_sha256", ""))

    @property
    def identity(self) -> dict:
        """The values of IDENTITY."""
        run, variant = self.run, "+".join(self.variants)
        values = (run.id, run.profile, self.scenario, variant, self.reading, run.code, run.seed)
        return dict(zip(IDENTITY, values, strict=True))


def member(run: Run) -> Member:
    """The place of a run in the study, by its scenario's id: nonlinear-en1.0+servo."""
    return Member(run, run.base_name, run.variants)


def members(runs: Iterable[Run]) -> list[Member]:
    """All runs that have finished a cycle."""
    return [member(run) for run in runs if len(run.cycles)]


def groups(found: Iterable[Member]) -> dict[tuple, list[Member]]:
    """Plain members by `key`: one per seed."""
    grouped: dict[tuple, list[Member]] = {}
    for m in found:
        if m.plain:
            grouped.setdefault(m.key, []).append(m)
    return grouped


def choose(runs: Iterable[Run]) -> tuple[list[Run], list[tuple[Run, str]]]:
    """The longest of runs that are the same, of equals the first; also the others, each with the reason why it is left
    out.
    """
    best: dict[tuple, Run] = {}
    keyed = [(_same(run), run) for run in runs]
    for key, run in keyed:
        if key not in best or last_cycle(run) > last_cycle(best[key]):
            best[key] = run
    chosen = {id(run) for run in best.values()}
    left_out = [
        (run, f"{best[key].id} is the same scenario, code, seed and bed and goes at least as far")
        for key, run in keyed
        if id(run) not in chosen
    ]
    return [run for _, run in keyed if id(run) in chosen], left_out


def _same(run: Run) -> tuple:
    """What a run is the same as: a plain one its scenario, code and seed; others differ in bed, step and ranks, too."""
    if member(run).plain:
        return tuple(run.identity.values())
    step = run.scenario["time.step"] if run.scenario is not None else None
    return (*run.identity.values(), step, ranks(run), run.info.get("bed"))
