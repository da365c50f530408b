"""The README's section on results, made from the findings: `python -m analysis readme`."""

from __future__ import annotations

import sys

from analysis.arguments import Parser
from analysis.comparison.claims.verdicts import ClaimError
from analysis.comparison.findings.find import RUNS_FOLDER, Findings, find
from analysis.files import ROOT, write_aside
from analysis.normalised.readers import load_runs
from analysis.reference.curves import load_references
from analysis.report.answer import answer
from analysis.report.report_data import KEY_SCENARIOS, PAPER_SCENARIOS
from analysis.report.sentences import lines
from analysis.scenarios.scenario import ScenarioError

README = ROOT / "README.md"
BEGIN, END = "<!-- results: begin, made by `make readme` -->", "<!-- results: end -->"


def main(argv: list[str]) -> int:
    """Command line of `make readme`."""
    parser = Parser(prog="ballast readme", description="Write the README's results from the kept runs.")
    parser.add_argument("--check", action="store_true", help="say whether it is up to date, and change nothing")
    options = parser.parse_args(argv)
    try:
        found = find(load_runs(RUNS_FOLDER), load_references(), PAPER_SCENARIOS)
        now = README.read_text(encoding="utf-8")
        wanted = with_results(now, found)
    except (ScenarioError, ClaimError, ValueError) as error:
        print(f"readme: {error}", file=sys.stderr)
        return 1
    if options.check:
        print("readme: up to date" if now == wanted else "readme: the kept runs say more; run `make readme`")
        return 0 if now == wanted else 1
    write_aside(README, wanted)
    print(f"readme: {README.name} written")
    return 0


def with_results(text: str, found: Findings) -> str:
    """The README with its results renewed. Raises ValueError where the marks of the section are missing."""
    head, begin, rest = text.partition(BEGIN)
    _, end, tail = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"README.md: the lines {BEGIN} and {END} are missing; put them around the results")
    sentences = lines("answer.txt", **answer(found, KEY_SCENARIOS, "full"))
    return head + begin + "\n\n" + "\n".join(f"* {line}" for line in sentences) + "\n\n" + end + tail
