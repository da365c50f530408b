"""The list of the study: which runs are made, in which order, from [study] of the scenario file.

A part is scenarios x variants x codes x seeds in the order of its lists, all runs of one scenario after each other.
Needs only the standard library.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from analysis.formats.quantities import CODES
from analysis.scenarios.scenario import (
    SCENARIO_FILE,
    ScenarioError,
    join_id,
    load_scenario,
    read_file,
    scenario_names,
    split_variants,
)

PART_KEYS = {"title": str, "scenarios": list, "variants": list, "codes": list, "seeds": list, "cycles": int}
PAPER = "paper"
"""Stands for all scenarios of the paper in the list of a part."""


@dataclass(frozen=True)
class StudyRow:
    """One run of the list, and how many cycles this row asks of it."""

    part: str
    scenario: str
    """Id, with variants."""
    code: str
    seed: int
    cycles: int
    bed: str
    """The run whose packed bed it starts from, as scenario/code; `own` packs."""

    @property
    def run(self) -> tuple[str, str, int]:
        """Which run it is: rows with the same run ask for more cycles of it."""
        return self.scenario, self.code, self.seed

    @property
    def name(self) -> str:
        """A word that tells the row apart from all others, for make."""
        return f"{self.scenario}/{self.code}-seed{self.seed}-{self.cycles}cycles"


def key_scenarios(path: Path = SCENARIO_FILE) -> tuple[str, str]:
    """The linear and the nonlinear scenario that the paper's discussion rests on."""
    table, known = read_file(path)["study"], scenario_names(path)
    names = []
    for key in ("key_linear", "key_nonlinear"):
        if table.get(key) not in known:
            raise ScenarioError(f"{Path(path).name}: study.{key} = {table.get(key)!r} is refused; allowed: a scenario")
        names.append(table[key])
    return names[0], names[1]


def profile(path: Path = SCENARIO_FILE) -> str:
    """The profile of the study's runs."""
    return read_file(path)["study"].get("profile", "full")


def rows(path: Path = SCENARIO_FILE) -> list[StudyRow]:
    """All rows in the order in which they are run; one that an earlier row asks for as well is left out.

    Raises ScenarioError where a part names what the file does not have.
    """
    parts = read_file(path)["study"].get("part", [])
    found: dict[tuple, StudyRow] = {}
    for number, part in enumerate(parts, start=1):
        _check_part(path, f"study.part {number}", part)
        for name in _scenarios(path, part["scenarios"]):
            for variant in part.get("variants", [""]):
                for code in part.get("codes", ["liggghts"]):
                    for seed in part.get("seeds", [1]):
                        row = _row(path, part, join_id(name, split_variants(variant)), code, seed)
                        found.setdefault((*row.run, row.cycles), row)
    return list(found.values())


def final_rows(path: Path = SCENARIO_FILE) -> list[StudyRow]:
    """One row for each run, the one that asks for most cycles of it; for schedulers that start rows in any order."""
    longest: dict[tuple, StudyRow] = {}
    for row in rows(path):
        if row.run not in longest or row.cycles > longest[row.run].cycles:
            longest[row.run] = row
    return list(longest.values())


def _scenarios(path: Path, names: list[str]) -> list[str]:
    """Names, each once, with `paper` replaced by those of the group."""
    lists = [scenario_names(path, PAPER) if name == PAPER else [name] for name in names]
    return list(dict.fromkeys(name for names in lists for name in names))


def _row(path: Path, part: dict, identity: str, code: str, seed: int) -> StudyRow:
    scenario = load_scenario(identity, profile(path), path)
    bed = scenario["packing.bed_from"]
    bed = f"{bed}/{scenario['packing.bed_code'] or code}" if bed else "own"
    return StudyRow(part["title"], scenario.id, code, seed, part["cycles"], bed)


def _check_part(path: Path, where: str, part) -> None:
    def refuse(key: str, value, allowed: str) -> ScenarioError:
        return ScenarioError(f"{Path(path).name}: {where}: {key} = {value!r} is refused; allowed: {allowed}")

    if not isinstance(part, dict):
        raise refuse("[[study.part]]", part, "a table")
    for key, value in part.items():
        if not isinstance(value, PART_KEYS.get(key, ())) or isinstance(value, bool):
            kinds = {str: "a text", list: "a list", int: "a whole number"}
            raise refuse(
                key, value, f"{kinds[PART_KEYS[key]]}" if key in PART_KEYS else "one of " + ", ".join(PART_KEYS)
            )
    for key in ("title", "scenarios", "cycles"):
        if key not in part:
            raise refuse(key, None, "to be given")
    if part["cycles"] < 1:
        raise refuse("cycles", part["cycles"], "> 0")
    for code in part.get("codes", []):
        if code not in CODES:
            raise refuse("codes", code, "yade, liggghts")
    for seed in part.get("seeds", []):
        if not isinstance(seed, int) or isinstance(seed, bool) or seed < 1:
            raise refuse("seeds", seed, "whole numbers above 0")
    for name in part["scenarios"]:
        if name != PAPER and name not in scenario_names(path):
            raise refuse("scenarios", name, "scenarios of the file, without variants, or paper")
    for variant in part.get("variants", []):
        if not isinstance(variant, str):
            raise refuse("variants", variant, "texts such as servo or servo+same-bed, empty for none")
