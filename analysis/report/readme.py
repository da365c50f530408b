"""The README's made parts, from the kept runs: results, from their findings, hours, from the benchmark, and the figure
of the settlement.
"""

from __future__ import annotations

import math
import shutil
import sys
import tempfile
from pathlib import Path

import pandas as pd

from analysis.arguments import Parser
from analysis.comparison.claims.verdicts import ClaimError
from analysis.comparison.findings.find import Findings, find
from analysis.files import KEPT_RUNS, ROOT, write_aside
from analysis.formats import markdown
from analysis.formats.numbers import readable
from analysis.normalised.readers import Runs, load_runs
from analysis.reference.curves import References, load_references
from analysis.report.answer import answer
from analysis.report.figure import Gallery
from analysis.report.figures.overview_figures import full_settlement_figure
from analysis.report.labels import SERVO_VARIANT, short_name
from analysis.report.report_data import KEY_SCENARIOS, PAPER_SCENARIOS, known_scenarios
from analysis.report.sentences import lines
from analysis.report.style import CODE_NAMES
from analysis.scenarios import derived
from analysis.scenarios.scenario import ScenarioError, join_id, load_scenario

README = ROOT / "README.md"
COMMAND = "make readme"


def main(argv: list[str]) -> int:
    """Command line of `make readme`."""
    parser = Parser(prog="ballast readme", description="Write the README's results and hours, from the kept runs.")
    parser.add_argument("--check", action="store_true", help="say whether it is up to date, and change nothing")
    options = parser.parse_args(argv)
    try:
        runs, references = load_runs(KEPT_RUNS), load_references()
        found = find(runs, references, PAPER_SCENARIOS)
        if found.problems:
            raise ValueError(found.problems[0])
        now = README.read_text(encoding="utf-8")
        wanted = with_results(now, found)
    except (ScenarioError, ClaimError, ValueError) as error:
        print(f"readme: {error}", file=sys.stderr)
        return 1
    if options.check:
        print("readme: up to date" if now == wanted else "readme: the kept runs say more; run `make readme`")
        return 0 if now == wanted else 1
    write_aside(README, wanted)
    pictures = draw_settlement(found, runs, references, KEPT_RUNS)
    print(f"readme: {README.name} written, {', '.join(path.name for path in pictures)} drawn")
    return 0


def draw_settlement(found: Findings, runs: Runs, references: References, folder: Path) -> list[Path]:
    """Draw the overview's figure of the settlement, a picture per model, into `folder`; their paths."""
    made = []
    with tempfile.TemporaryDirectory() as aside:
        gallery = Gallery(Path(aside), f"drawn by {COMMAND} from the kept runs", runs, references, known_scenarios())
        if full_settlement_figure(gallery, found.members, KEY_SCENARIOS) is None:
            return []
        for drawn in sorted(Path(aside).glob("settlement-full-*.png")):
            made.append(folder / drawn.name.replace("-full", ""))
            shutil.copyfile(drawn, made[-1])
    return made


def with_results(text: str, found: Findings) -> str:
    """The README with its made sections renewed. Raises ValueError where the marks of a section are missing."""
    sentences = lines("answer.txt", **answer(found, KEY_SCENARIOS, "full"))
    sections = {"results": "\n".join(f"* {line}" for line in sentences), "hours": hours_table(found.benchmark)}
    for name, body in sections.items():
        text = markdown.replaced(text, name, COMMAND, body, README.name)
    return text


def speeds(benchmark: pd.DataFrame) -> dict[tuple[str, str], float]:
    """(code, linear | nonlinear) -> steps per second of processor time on the full bed."""
    rows = benchmark.itertuples()
    return {(row.code, row.law): float(row.steps_per_cpu_s) for row in rows if row.case == "ours_paper_step"}


def hours_table(benchmark: pd.DataFrame) -> str:
    """Table: hours of one core for 1000 cycles of the full bed, by reading of the load, contact law and code.

    benchmark   `Findings.benchmark`
    """
    measured, rows = speeds(benchmark), []
    for law, scenario in zip(("linear", "nonlinear"), KEY_SCENARIOS, strict=True):
        for variants in ((), (SERVO_VARIANT,)):
            name = join_id(scenario, variants)
            steps = derived.time_grid(load_scenario(name, "full")).steps_per_cycle
            speed = [measured.get((code, law), math.nan) for code in CODE_NAMES]
            rows.append([short_name(name), f"{steps}", *(readable(1000 * steps / each / 3600, 2) for each in speed)])
    return markdown.table(["scenario", "steps per cycle", *(f"{name}, hours" for name in CODE_NAMES.values())], rows)
