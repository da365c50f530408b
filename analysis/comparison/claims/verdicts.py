"""The paper's claims, eleven about its own models and some about Chen et al.'s, each judged per code and reading of the
load by a criterion fixed beforehand in reference_data/claims.toml; and which of them the reading decides.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from analysis.comparison.claims.checks import judge_of
from analysis.comparison.claims.evidence import CODES, FAILS, HOLDS, OPEN, Claim, Evidence, Rules, Verdict
from analysis.comparison.findings.members import READINGS, SERVO, TRUE_LOAD
from analysis.files import CLAIMS_FILE
from analysis.formats import toml_file
from analysis.formats.quantities import QUANTITIES
from analysis.reference.curves import References, load_references


class ClaimError(ValueError):
    """A claims file that cannot be used; the message is one line naming file, key and remedy."""


def load_claims(path: Path = CLAIMS_FILE) -> tuple[list[Claim], Rules]:
    """Read claims.toml and check that every claim is complete, judged by a function, and words all its thresholds."""
    try:
        content = toml_file.read(path)
        rules = Rules(
            content["rules"]["profile"],
            content["rules"]["confidence"],
            {name: entry["value"] for name, entry in content["stated"].items()},
        )
        entries = content["claim"]
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        reason = f"cannot be used ({error}); it has [rules], [stated] and [[claim]]"
        raise ClaimError(f"{Path(path).name}: {reason}") from None
    return [_claim(Path(path).name, entry) for entry in entries], rules


def _claim(file: str, entry: dict) -> Claim:
    where = f"{file}: claim {entry.get('id', '?')}"
    try:
        claim = Claim(**(entry | {"runs": tuple(entry["runs"]), "reference": tuple(entry["reference"])}))
    except (TypeError, KeyError) as error:
        raise ClaimError(f"{where}: {error}; each claim has {', '.join(Claim.__dataclass_fields__)}") from None
    if claim.compares is not None:
        _check_comparison(where, claim)
    elif judge_of(claim) is None:
        raise ClaimError(
            f"{where}: no function of that name in analysis/comparison/claims/checks.py; write one, give compares, or "
            "correct the id"
        )
    for name, value in claim.thresholds.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ClaimError(f"{where}: threshold {name} = {value!r} is refused; give a number")
        if f"{{{name}" not in claim.criterion + claim.quantity:
            raise ClaimError(
                f"{where}: threshold {name} is not worded in criterion or quantity; write {{{name}:g}} into one"
            )
    try:
        worded = {key: entry[key].format(**claim.thresholds) for key in ("criterion", "quantity")}
    except (KeyError, ValueError) as error:
        raise ClaimError(f"{where}: criterion or quantity names {error}; give it in thresholds") from None
    return Claim(**(claim.__dict__ | worded))


def _check_comparison(where: str, claim: Claim) -> None:
    """ClaimError where `compares` or the thresholds are not what checks.compares needs."""
    wanted = {"quantity": QUANTITIES, "more": claim.runs, "less": claim.runs}
    if not isinstance(claim.compares, dict) or set(claim.compares) != set(wanted):
        raise ClaimError(f"{where}: compares = {claim.compares!r} is refused; give {', '.join(wanted)}")
    for key, known in wanted.items():
        if claim.compares[key] not in known:
            shown = "a quantity of docs/glossary.md" if key == "quantity" else f"one of {', '.join(known)}"
            raise ClaimError(f"{where}: compares.{key} = {claim.compares[key]!r} is refused; give {shown}")
    for name in ("cycles", "ratio"):
        if name not in claim.thresholds:
            raise ClaimError(f"{where}: criterion or quantity names '{name}'; give it in thresholds")


def evaluate_claims(runs: Iterable, references: References | None = None, path: Path = CLAIMS_FILE) -> list[Verdict]:
    """Judge all claims for both codes, in both readings of the load, from `runs` (of load_runs) and `references`
    (default: the committed ones).
    """
    claims, rules = load_claims(path)
    references = load_references() if references is None else references
    runs = list(runs)
    return [
        judge(claim, code, reading, runs, references, rules)
        for claim in claims
        for reading in READINGS
        for code in CODES
    ]


def judge(claim: Claim, code: str, reading: str, runs: Iterable, references: References, rules: Rules) -> Verdict:
    """Judge one claim for one code in one reading of the load."""
    evidence = Evidence(runs, references, rules, claim, code, reading)
    return evidence.judge(tuple(judge_of(claim)(evidence, claim.thresholds)))


def to_frame(verdicts: Iterable[Verdict]) -> pd.DataFrame:
    """A row per check, with the claim's verdict and the check's own; margins in SI units."""
    return pd.DataFrame(
        [
            {
                "number": v.claim.number,
                "about": v.claim.about,
                "name": v.claim.name,
                "claim": v.claim.sentence,
                "code": v.code,
                "reading": v.reading,
                "verdict": v.verdict,
                "because": v.because,
                "check": c.what,
                "check_verdict": c.verdict,
                "numbers": c.numbers,
                "margin": c.margin,
                "half_width": c.half_width,
                "unit": c.unit,
                "missing": "; ".join(c.missing),
                "without_curve": c.without_curve,
            }
            for v in verdicts
            for c in v.checks
        ]
    )


BY_SERVO, BY_LOAD, BOTH, NEITHER = "only by the servo", "only under the true load", "in both readings", "in neither"


def compare_readings(verdicts: Iterable[Verdict]) -> pd.DataFrame:
    """What the reading of the load decides: a row per claim and code, for the whole claim (part = "") and each part.

    Columns: number, claim, code, part, true_load, servo (verdicts), outcome. Outcome `only by the servo`: the claim
    follows from the servo's filter alone, since under the load as prescribed it does not hold; `only under the true
    load`, `in both readings`, `in neither`; empty where a reading leaves it undecided.
    """
    found = {(v.claim.number, v.code, v.reading): v for v in verdicts}
    rows = []
    for number, code in dict.fromkeys((number, code) for number, code, _ in found):
        load, servo = found.get((number, code, TRUE_LOAD)), found.get((number, code, SERVO))
        if load is None or servo is None:
            continue
        parts = [("", load.verdict, servo.verdict)]
        if len(load.checks) == len(servo.checks) > 1:
            parts += [(a.what, a.verdict, b.verdict) for a, b in zip(load.checks, servo.checks, strict=True)]
        rows += [
            {
                "number": number,
                "claim": load.claim.sentence,
                "code": code,
                "part": part,
                "true_load": one,
                "servo": other,
                "outcome": _outcome(one, other),
            }
            for part, one, other in parts
        ]
    return pd.DataFrame(rows, columns=["number", "claim", "code", "part", "true_load", "servo", "outcome"])


def _outcome(load: str, servo: str) -> str:
    if OPEN in (load, servo):
        return ""
    return {(HOLDS, HOLDS): BOTH, (HOLDS, FAILS): BY_LOAD, (FAILS, HOLDS): BY_SERVO}.get((load, servo), NEITHER)
