"""The report: a small site of self-contained pages from whatever runs there are. `python -m analysis report` builds it.

The same runs give the same files. Figures lie in `figures/` beside the pages, each as SVG, PNG and CSV.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

import jinja2

from analysis.arguments import Parser
from analysis.comparison.claims.verdicts import ClaimError
from analysis.comparison.quantities import last_cycle
from analysis.driver import calibrate, provenance
from analysis.files import ROOT, write_aside
from analysis.formats.numbers import plural
from analysis.normalised.readers import Run, Runs, load_runs
from analysis.reference.curves import REFERENCE_FOLDER, load_references
from analysis.report import style
from analysis.report.figure import Gallery
from analysis.report.pages.assumptions import assumptions
from analysis.report.pages.claims import claims_page
from analysis.report.pages.comparison import comparison
from analysis.report.pages.overview import overview
from analysis.report.pages.paper_figures import paper_figures
from analysis.report.pages.runs import runs_page
from analysis.report.pages.verification import verification
from analysis.report.report_data import ReportData, is_variant, known_scenarios, verification_rows
from analysis.scenarios.scenario import ScenarioError

TEMPLATES = Path(__file__).resolve().parent / "templates"
KEPT_RUNS = REFERENCE_FOLDER / "runs"
PAGES = (
    ("index.html", "Overview", "Overview", overview, "hover.js"),
    ("figures.html", "Figures", "The paper's figures", paper_figures, "hover.js"),
    ("comparison.html", "Comparison", "YADE against LIGGGHTS", comparison, "hover.js"),
    ("claims.html", "Claims", "The paper's claims", claims_page, ""),
    ("verification.html", "Verification", "Verification", verification, "hover.js"),
    ("runs.html", "Runs", "Runs and provenance", runs_page, "hover.js"),
    ("assumptions.html", "Assumptions", "Assumptions", assumptions, "filter.js"),
)


def main(argv: list[str]) -> int:
    """Command line of `make compare`."""
    parser = Parser(prog="ballast report", description="Build the report from the runs that exist.")
    parser.add_argument("--results", type=Path, default=Path("results"), help="folder of the runs")
    parser.add_argument(
        "--out", type=Path, default=Path("report"), help="folder of the report; verification.csv is looked for there"
    )
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
    return 0


def build(
    results: Path, out: Path, kept_runs: Path = KEPT_RUNS, reference_folder: Path = REFERENCE_FOLDER
) -> ReportData:
    """Read the runs below `results` and those kept in the repository, and write the site to `out`."""
    out.mkdir(parents=True, exist_ok=True)
    kept = load_runs(kept_runs)
    for run in kept:
        run.id = f"kept/{run.id}"
    found = [*load_runs(results), *kept]
    runs, left_out = choose([run for run in found if not is_variant(run)])
    variants = without_copies(run for run in found if is_variant(run))
    verification, problems = verification_rows(out)
    for line in problems:
        print(f"warning: {line}", file=sys.stderr)
    stamp = version_stamp()
    references = load_references(reference_folder)
    problems += runs.problems
    gallery = Gallery(out / "figures", stamp, runs, references, known_scenarios(), problems)
    data = ReportData(
        runs,
        variants,
        left_out,
        references,
        gallery,
        verification,
        out / "verification",
        problems,
        shown_path(results),
        kept_runs / calibrate.TABLE.name,
    )
    with style.settings():
        write_pages(data, out, stamp)
    for path in (out / "figures").iterdir():
        if path.stem not in {panel.name for figure in gallery.figures for panel in figure.panels}:
            path.unlink()  # of a figure that this report no longer has
    return data


def without_copies(variants: Iterable[Run]) -> Runs:
    """The longest of runs that differ in nothing a comparison asks for, such as a run and its committed copy."""
    best: dict[tuple, Run] = {}
    for run in variants:
        step = run.scenario["time.step"] if run.scenario else None
        key = (*run.identity.values(), run.info.get("bed"), step)
        if key not in best or last_cycle(run) > last_cycle(best[key]):
            best[key] = run
    return Runs(best.values())


def choose(runs: list[Run]) -> tuple[Runs, list[tuple[Run, str]]]:
    """One run for each profile, scenario, code and seed: the longest, of equals the first; and why the others are
    left out.
    """
    best: dict[tuple, Run] = {}
    for run in runs:
        key = tuple(run.identity.values())
        if key not in best or last_cycle(run) > last_cycle(best[key]):
            best[key] = run
    kept = {id(run) for run in best.values()}
    left_out = [
        (
            run,
            f"{best[tuple(run.identity.values())].id} is the same scenario, code and seed and goes at least as far",
        )
        for run in runs
        if id(run) not in kept
    ]
    order = {name: n for n, name in enumerate(known_scenarios())}
    chosen = sorted(
        best.values(),
        key=lambda r: (
            r.profile != "full",
            r.profile,
            order.get(r.scenario_name, len(order)),
            r.scenario_name,
            r.code,
            r.seed,
        ),
    )
    return Runs(chosen), left_out


def version_stamp() -> str:
    """Version of the analysis and commit of the working tree, as it stands under every figure."""
    git = provenance.git_state()
    commit = (
        f", commit {provenance.short_commit(git['git_commit'])}"
        f"{' with uncommitted changes' if git['git_dirty'] else ''}"
        if git["git_commit"]
        else ""
    )
    return f"ballast-analysis {metadata.version('ballast-analysis')}{commit}"


def shown_path(path: Path) -> str:
    """A path as a page may show it: relative to the repository, or its name alone."""
    path = path.resolve()
    return str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else path.name


def write_pages(data: ReportData, out: Path, stamp: str) -> None:
    """Render all pages; styles and scripts are written into each."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=jinja2.select_autoescape(),
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.ChainableUndefined,
    )
    environment.globals["zip"] = zip
    contents = {
        file: content(data) for file, _, _, content, _ in PAGES
    }  # all figures are drawn before the colours are listed
    variables = style.colour_variables()
    css = environment.get_template("style.css").render(
        light_variables="\n".join(f"  {name}: {light};" for name, (light, _) in variables.items()),
        dark_variables="\n".join(f"    {name}: {dark};" for name, (_, dark) in variables.items()),
    )
    links = [{"file": file, "name": name} for file, name, *_ in PAGES]
    for file, name, title, _, script in PAGES:
        text = environment.get_template(file).render(
            page={"file": file, "name": name, "title": title},
            pages=links,
            css=css,
            stamp=stamp,
            script=(TEMPLATES / script).read_text() if script else "",
            **contents[file],
        )
        write_aside(out / file, text + "\n")
