"""The findings as CSV files: `ballast findings`."""

from __future__ import annotations

import sys
from pathlib import Path

from analysis.arguments import Parser
from analysis.comparison.claims.verdicts import ClaimError
from analysis.comparison.findings.find import Findings, find
from analysis.files import KEPT_RUNS
from analysis.normalised.readers import load_runs
from analysis.reference.curves import load_references
from analysis.report.report_data import PAPER_SCENARIOS
from analysis.scenarios.scenario import ScenarioError


def main(argv: list[str]) -> int:
    """Command line of `make findings`."""
    parser = Parser(prog="ballast findings", description="Write what the runs say as CSV tables.")
    parser.add_argument("--results", type=Path, default=Path("results"), help="folder of the runs")
    parser.add_argument("--out", type=Path, default=Path("report/findings"), help="folder of the tables")
    options = parser.parse_args(argv)
    try:
        found = found_in(options.results)
        for line in found.problems:
            print(f"warning: {line}", file=sys.stderr)
        paths = found.write(options.out)
    except (ScenarioError, ClaimError, ValueError) as error:
        print(f"findings: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"findings: {error.filename or options.out}: {error.strerror}; give another --out", file=sys.stderr)
        return 1
    print(f"findings: {len(paths)} tables in {options.out}")
    return 0


def found_in(results: Path, kept: Path = KEPT_RUNS) -> Findings:
    """Findings of the runs below `results` and of those kept in the repository."""
    return find([*load_runs(results), *load_runs(kept)], load_references(), PAPER_SCENARIOS, kept)
