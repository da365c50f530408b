"""The report: a small site of self-contained pages from whatever runs there are. `ballast report` builds it.

The same runs give the same files. Figures lie in `figures/` beside the pages, each as SVG, PNG and CSV.
"""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from analysis.arguments import Parser
from analysis.comparison.claims.verdicts import ClaimError
from analysis.comparison.findings.members import choose
from analysis.driver import provenance
from analysis.driver.settings import relative
from analysis.files import KEPT_RUNS, KEPT_VERIFICATION, PUBLISHED, write_aside
from analysis.formats.numbers import plural
from analysis.normalised.readers import Run, Runs, load_runs
from analysis.reference.curves import load_references
from analysis.report import data_archive, style
from analysis.report.demo_outcome import summary
from analysis.report.figure import Gallery
from analysis.report.figures.bed_figures import kept_scene
from analysis.report.figures.further_figures import further_sections
from analysis.report.pages.assumptions_page import assumptions
from analysis.report.pages.benchmark_page import benchmark_page
from analysis.report.pages.claims_page import claims_page
from analysis.report.pages.comparison_page import comparison
from analysis.report.pages.demo_page import demo_page
from analysis.report.pages.figures_page import paper_figures
from analysis.report.pages.influence_page import influence_page
from analysis.report.pages.overview_page import overview
from analysis.report.pages.runs_page import runs_page
from analysis.report.pages.servo_page import servo_page
from analysis.report.pages.timestep_page import timestep_page
from analysis.report.pages.verification_page import verification
from analysis.report.pictures import turnable
from analysis.report.report_data import ReportData, is_variant, known_scenarios, verification_rows
from analysis.report.sentences import TEMPLATES, environment
from analysis.scenarios.scenario import ScenarioError

FIGURES, TABLES = "hover.js", "sort.js"
TURNABLE = "bed-3d.html"


@dataclass(frozen=True)
class Page:
    """A page of the site: its content, a dictionary for the template of the same file, is None where it has nothing."""

    file: str
    name: str
    title: str
    content: Callable[[ReportData], dict | None]
    scripts: tuple[str, ...] = (FIGURES, TABLES)


PAGES = (
    Page("index.html", "Overview", "Overview", overview),
    Page("figures.html", "Figures", "The paper's figures", paper_figures),
    Page("comparison.html", "Codes", "YADE against LIGGGHTS", comparison),
    Page("claims.html", "Claims", "The paper's claims", claims_page),
    Page("servo.html", "The servo", "What PFC's servo makes of the load", servo_page),
    Page("influence.html", "Influence", "What the paper leaves out", influence_page),
    Page("timestep.html", "Time step", "How large the time step may be", timestep_page),
    Page("benchmark.html", "Benchmark", "How fast it is", benchmark_page),
    Page("verification.html", "Verification", "Verification", verification),
    Page("runs.html", "Runs", "Runs and provenance", runs_page),
    Page("assumptions.html", "Assumptions", "Assumptions", assumptions, (FIGURES, TABLES, "filter.js")),
    Page("demo.html", "Demo", "The demo", demo_page),
)


def main(argv: list[str]) -> int:
    """Command line of `make compare`."""
    parser = Parser(prog="ballast report", description="Build the report from the runs that exist.")
    parser.add_argument("--results", type=Path, default=Path("results"), help="folder of the runs")
    parser.add_argument(
        "--out", type=Path, default=Path("report"), help="folder of the report; verification.csv is looked for there"
    )
    parser.add_argument("--demo", action="store_true", help="say at the end what the demo's runs came to")
    options = parser.parse_args(argv)
    began = time.monotonic()
    try:
        data = build(options.results, options.out)
    except (ScenarioError, ClaimError) as error:
        print(f"report: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"report: {error.filename or options.out}: {error.strerror}; give another --out", file=sys.stderr)
        return 1
    print(
        f"report: {options.out / 'index.html'} ({plural(len(data.runs), 'run')}, "
        f"{plural(len(data.gallery.figures), 'figure')}, "
        f"{time.monotonic() - began:.0f} s)"
    )
    if options.demo:
        print("\n".join(summary(data.findings, str(options.out / "index.html"))))
    return 0


def build(results: Path, out: Path, kept_runs: Path = KEPT_RUNS, reference_folder: Path = PUBLISHED) -> ReportData:
    """Read the runs below `results` and those kept in the repository, and write the site to `out`."""
    out.mkdir(parents=True, exist_ok=True)
    kept = load_runs(kept_runs)
    for run in kept:
        run.id = f"kept/{run.id}"
    chosen, left_out = choose([*load_runs(results), *kept])
    chosen = Runs(sorted(chosen, key=_order()))
    verified = out if (out / "verification.csv").exists() else kept_runs.with_name(KEPT_VERIFICATION.name)
    verification, problems = verification_rows(verified)
    for line in problems:
        print(f"warning: {line}", file=sys.stderr)
    stamp = version_stamp()
    references = load_references(reference_folder)
    problems += chosen.problems
    gallery = Gallery(out / "figures", stamp, chosen, references, known_scenarios(), problems)
    data = ReportData(
        Runs(run for run in chosen if not is_variant(run)),
        Runs(run for run in chosen if is_variant(run)),
        left_out,
        references,
        gallery,
        verification,
        verified / "verification",
        problems,
        relative(results),
        kept_runs,
    )
    with style.settings():
        write_turnable(data, out)
        write_pages(data, out, stamp)
    data.findings.write(out / "findings")
    for path in (out / "figures").iterdir():
        if path.stem not in {panel.name for figure in gallery.figures for panel in figure.panels}:
            path.unlink()  # of a figure that this report no longer has
    data_archive.write(out)
    return data


def write_turnable(data: ReportData, out: Path) -> None:
    """The bed that can be turned, where k3d is installed and the bed is kept; an older one is removed."""
    path = out / TURNABLE
    path.unlink(missing_ok=True)
    scene = kept_scene(data.gallery, data.kept) if turnable.available() else None
    if scene:
        turnable.write_html(path, [scene], "The packed bed")
        data.turnable = TURNABLE


def _order() -> Callable[[Run], tuple]:
    """Full size first, then in the order of the scenario file, readings of one scenario beside each other."""
    order = {name: n for n, name in enumerate(known_scenarios())}

    def key(run: Run) -> tuple:
        place = order.get(run.base_name, len(order))
        return run.profile != "full", run.profile, place, run.scenario_name, run.code, run.seed

    return key


def version_stamp() -> str:
    """Version of the analysis and commit of the working tree, as it stands under every figure."""
    git = provenance.git_state()
    day = provenance.commit_date(git["git_commit"])
    commit = (
        f", commit {provenance.short_commit(git['git_commit'])}{f' of {day}' if day else ''}"
        f"{' with uncommitted changes' if git['git_dirty'] else ''}"
    )
    return f"ballast-analysis {metadata.version('ballast-analysis')}{commit}"


def write_pages(data: ReportData, out: Path, stamp: str) -> None:
    """Render all pages that have something to say; styles and scripts are written into each."""
    templates = environment()
    contents = {page: page.content(data) for page in PAGES}  # all figures are drawn before the colours are listed
    further = {page: further_sections(page.file, data) for page in PAGES}
    shown = [page for page in PAGES if contents[page] is not None]
    variables = style.colour_variables()
    css = templates.get_template("style.css").render(
        light_variables="\n".join(f"  {name}: {light};" for name, (light, _) in variables.items()),
        dark_variables="\n".join(f"    {name}: {dark};" for name, (_, dark) in variables.items()),
    )
    for page in shown:
        text = templates.get_template(page.file).render(
            page=page,
            pages=shown,
            css=css,
            stamp=stamp,
            scripts=[(TEMPLATES / name).read_text() for name in page.scripts],
            further=further[page],
            **contents[page],
        )
        write_aside(out / page.file, numbered(with_contents(text)) + "\n")
    for page in PAGES:
        if page not in shown:
            (out / page.file).unlink(missing_ok=True)


def numbered(text: str) -> str:
    """The page with the number of each table in its id and in the link to it."""
    parts = text.split("table-@")
    return parts[0] + "".join(f"table-{1 + n // 2}{part}" for n, part in enumerate(parts[1:]))


def with_contents(text: str) -> str:
    """The page with a list of its sections where it asks for one."""
    sections = re.findall(r'<h2 id="([^"]+)"(?: class="numbered")?>(.*?) <a ', text)
    entries = "".join(f'<li><a href="#{name}">{title}</a></li>' for name, title in sections)
    listed = f'<nav class="toc" aria-label="On this page"><ul>{entries}</ul></nav>' if len(sections) > 2 else ""
    return text.replace("<!-- contents -->", listed)
