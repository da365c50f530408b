"""The paper's eleven claims, each judged per code by a criterion fixed beforehand in reference_data/claims.toml."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from analysis.comparison.claims.checks import CHECKS
from analysis.comparison.claims.evidence import CODES, Claim, Evidence, Rules, Verdict
from analysis.reference.curves import REFERENCE_FOLDER, References, load_references


class ClaimError(ValueError):
    """A claims file that cannot be used; the message is one line naming file, key and remedy."""


def load_claims(path: Path = REFERENCE_FOLDER / "claims.toml") -> tuple[list[Claim], Rules]:
    """Read claims.toml and check that every claim is complete, judged by a function, and words all its thresholds."""
    try:
        content = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        rules = Rules(
            content["rules"]["profile"],
            content["rules"]["confidence"],
            {name: entry["value"] for name, entry in content["stated"].items()},
        )
        entries = content["claim"]
    except (OSError, tomllib.TOMLDecodeError, KeyError, TypeError) as error:
        reason = f"cannot be used ({error}); it has [rules], [stated] and [[claim]]"
        raise ClaimError(f"{Path(path).name}: {reason}") from None
    return [_claim(Path(path).name, entry) for entry in entries], rules


def _claim(file: str, entry: dict) -> Claim:
    where = f"{file}: claim {entry.get('id', '?')}"
    try:
        claim = Claim(**(entry | {"runs": tuple(entry["runs"]), "reference": tuple(entry["reference"])}))
    except (TypeError, KeyError) as error:
        raise ClaimError(f"{where}: {error}; each claim has {', '.join(Claim.__dataclass_fields__)}") from None
    if claim.id not in CHECKS:
        raise ClaimError(
            f"{where}: no function of that name in analysis/comparison/claims/checks.py; write one or correct the id"
        )
    for name in claim.thresholds:
        if f"{{{name}" not in claim.criterion + claim.quantity:
            raise ClaimError(
                f"{where}: threshold {name} is not worded in criterion or quantity; write {{{name}:g}} into one"
            )
    try:
        worded = {key: entry[key].format(**claim.thresholds) for key in ("criterion", "quantity")}
    except (KeyError, ValueError) as error:
        raise ClaimError(f"{where}: criterion or quantity names {error}; give it in thresholds") from None
    return Claim(**(claim.__dict__ | worded))


def evaluate_claims(
    runs: Iterable, references: References | None = None, path: Path = REFERENCE_FOLDER / "claims.toml"
) -> list[Verdict]:
    """Judge all claims for both codes from `runs` (of load_runs) and `references` (default: the committed ones)."""
    claims, rules = load_claims(path)
    references = load_references() if references is None else references
    runs = list(runs)
    return [judge(claim, code, runs, references, rules) for claim in claims for code in CODES]


def judge(claim: Claim, code: str, runs: Iterable, references: References, rules: Rules) -> Verdict:
    """Judge one claim for one code."""
    evidence = Evidence([r for r in runs if r.code == code], references, rules, claim)
    return evidence.judge(code, tuple(CHECKS[claim.id](evidence, claim.thresholds)))


def to_frame(verdicts: Iterable[Verdict]) -> pd.DataFrame:
    """A row per check, with the claim's verdict and the check's own; margins in SI units."""
    return pd.DataFrame(
        [
            {
                "number": v.claim.number,
                "claim": v.claim.sentence,
                "code": v.code,
                "verdict": v.verdict,
                "check": c.what,
                "check_verdict": c.verdict,
                "numbers": c.numbers,
                "margin": c.margin,
                "half_width": c.half_width,
                "unit": c.unit,
                "missing": "; ".join(c.missing),
            }
            for v in verdicts
            for c in v.checks
        ]
    )
