"""`ballast reference`: checks every file of reference data and lists what is there and what is pending."""

from __future__ import annotations

import sys
from pathlib import Path

from analysis.arguments import Parser
from analysis.files import PUBLISHED
from analysis.reference.curves import ReferenceError, References, load_references
from analysis.reference.reported import reported
from analysis.reference.settlement_laws import settlement_laws
from analysis.reference.settlement_shapes import settlement_shapes
from analysis.scenarios.scenario import ScenarioError


def main(argv: list[str]) -> int:
    """`ballast reference`: check every file, list what is there and what is pending."""
    parser = Parser(prog="ballast reference", description=main.__doc__)
    parser.add_argument("--folder", type=Path, default=PUBLISHED, help="instead of reference_data/published")
    folder = parser.parse_args(argv).folder
    references = load_references(folder)
    print(summary(references))
    problems = list(references.problems)
    try:
        laws = settlement_laws(folder)
        print(f"Settlement laws: {len(laws)} transcribed ({', '.join(law.id for law in laws)})")
        found, beds = settlement_shapes(folder), reported(folder)
        print(f"Settlement shapes: {len(found.shapes)} {found.status} ({', '.join(s.id for s in found.shapes)})")
        print(f"The paper's beds: {beds.clumps} and {beds.clumps_nonlinear} clumps, porosity {beds.porosity}")
    except (ReferenceError, ScenarioError) as error:
        problems.append(str(error))
    for problem in problems:
        print(f"ERROR: {problem}", file=sys.stderr)
    return 1 if problems else 0


def summary(references: References) -> str:
    """A line per sidecar: how many curves are there and which are pending."""
    lines = []
    there, pending = references.curves, references.pending
    for sidecar in sorted({*there["sidecar"], *pending["sidecar"]}):
        curves = there.loc[there["sidecar"] == sidecar]
        waiting = pending.loc[pending["sidecar"] == sidecar, "curve"]
        state = ", ".join(
            [f"{n} {s}" for s, n in curves.groupby("status")["curve"].nunique().items()]
            + ([f"{len(waiting)} pending"] if len(waiting) else [])
        )
        lines.append(f"{sidecar:50} {state}")
        if len(waiting) and len(curves):
            lines += [f"    pending: {name}" for name in waiting]
    count = there.groupby(["sidecar", "curve"]).ngroups if len(there) else 0
    lines.append(f"Curves: {count} there, {len(pending)} pending (reference_data/README.md says how to add them)")
    return "\n".join(lines)
