"""The report: complete, self-contained pages and files from whatever runs there are, and pictures without a display."""

import base64
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import warnings
import xml.etree.ElementTree as xml
import zipfile
from html.parser import HTMLParser
from types import SimpleNamespace

import matplotlib
import numpy as np
import pandas as pd
import pytest
from PIL import Image
from synthetic import write_run

from analysis.comparison.findings.find import find
from analysis.comparison.same_bed import same_bed_pairs, settlements
from analysis.driver import calibrate
from analysis.files import KEPT_RUNS, KEPT_VERIFICATION, ROOT, write_csv
from analysis.formats.quantities import CODES
from analysis.normalised import beds
from analysis.normalised.readers import Run
from analysis.report import build as report
from analysis.report import data_archive, readme, style
from analysis.report.answer import told_cycle
from analysis.report.figures.bed_figures import KEPT_BED
from analysis.report.pictures import render, turnable, view
from analysis.report.pictures.scene import kept_cycles, load_scene, packed_scene
from analysis.report.report_data import is_variant
from analysis.report.tables.table_html import number
from analysis.scenarios import derived
from analysis.scenarios.scenario import load_scenario
from analysis.verification.verify_command import CASES as VERIFIED

PAGES = [page.file for page in report.PAGES]
VOID = {"meta", "link", "br", "wbr", "img", "input", "hr", "line", "rect", "circle", "path", "use", "image", "polygon"}
LOADING = {
    "script": "src",
    "link": "href",
    "img": "src",
    "image": "href",
    "iframe": "src",
    "source": "src",
    "use": "href",
}
CASES = [
    "code,case,quantity,expected,measured,abs_error,rel_error,tolerance,passed,reason",
    "liggghts,impact_linear,restitution,0.8279,0.8280,0.0001,0.00012,0.002,true,",
    'yade,impact_linear,restitution,0.8279,0.80,0.0279,0.0337,0.005,false,"YADE counts it, wrong on purpose"',
]
CURVES = "series,time_s,force_N,force_N_expected\n" + "".join(
    f"slow,{t},{3 * t},{3 * t + 0.01}\nfast,{t},{5 * t},{5 * t}\n" for t in range(12)
)


class PageText(HTMLParser):
    """Links, ids and what a page loads; unbalanced tags are errors."""

    def __init__(self, text):
        super().__init__()
        self.text, self.open, self.ids, self.loads, self.links, self.words = text, [], [], [], [], []
        self.feed(text)
        self.close()
        assert not self.open, f"never closed: {self.open}"

    def handle_starttag(self, tag, attrs, closed=False):
        attrs = dict(attrs)
        self.ids += [attrs["id"]] if "id" in attrs else []
        target = attrs.get(LOADING.get(tag, ""), attrs.get("xlink:href") if tag in LOADING else None)
        self.loads += [target] if target else []
        self.links += [attrs["href"]] if tag == "a" and "href" in attrs else []
        if tag not in VOID and not closed:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs, closed=True)

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-3:]}"
            self.open.pop()

    def handle_data(self, data):
        if not self.open or self.open[-1] not in ("script", "style"):
            self.words.append(data)

    @property
    def says(self) -> str:
        return " ".join(" ".join(self.words).split())


def build(results, out):
    """Build a report from `results` alone, as if `none` in it were kept; any warning is an error. Returns the pages by
    file name.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        report.build(results, out, kept_runs=results / "none")
    return {file: PageText((out / file).read_text(encoding="utf-8")) for file in PAGES if (out / file).exists()}


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A report from runs of both codes, two seeds, an added scenario, and a verification: (results, folder, pages)."""
    root = tmp_path_factory.mktemp("site")
    results, out = root / "results", root / "report"
    for code in ("liggghts", "yade"):
        write_run(results, "demo", "linear-mu0.8", code, cycles=24)
    write_run(results, "demo", "linear-mu0.8", "liggghts", cycles=24, seed=2, rng=3, noise=0.05)
    write_run(
        results,
        "demo",
        "nonlinear-md1-en0.6",
        "yade",
        cycles=4,
        info={
            "deviations": ["a restitution-equivalent law & <other> things"],
            "state": "interrupted",
            "reason": "killed",
        },
    )
    scenarios = root / "scenarios.toml"
    scenarios.write_text(
        (ROOT / "scenarios.toml").read_text()
        + """
[scenario."stiff-plates"]
title = "Plates that do not move"
base = "linear-mu0.8"
load_control.plate_law = { value = "fixed", unit = "-", status = "assumed", source = "a test" }
"""
    )
    write_run(results, "demo", "stiff-plates", "liggghts", cycles=24, scenario_file=scenarios)
    (out / "verification").mkdir(parents=True)
    (out / "verification.csv").write_text("\n".join(CASES) + "\n")
    (out / "verification" / "impact_linear_liggghts.csv").write_text(CURVES)
    return results, out, build(results, out)


# ------------------------------------------------------------------ pages


def test_every_figure_has_its_files(site):
    _, out, pages = site
    names = sorted(set(re.findall(r'href="figures/([^"]+)\.svg"', "".join(p.text for p in pages.values()))))
    assert len(names) > 25
    assert {p.stem for p in (out / "figures").iterdir()} == set(names), (
        "files that no page shows, or figures without files"
    )
    for name in names:
        svg, png, csv = ((out / "figures" / name).with_name(f"{name}.{end}") for end in ("svg", "png", "csv"))
        assert xml.parse(svg).getroot().tag.endswith("svg")
        assert png.read_bytes().startswith(b"\x89PNG") and png.stat().st_size > 5000
        table = pd.read_csv(csv)
        empty_frame = "no run has reached" in svg.read_text(encoding="utf-8")  # of a cycle that the paper shows
        assert (len(table) > 0) != empty_frame, name
        assert not [c for c in table if c.startswith("Unnamed")], name


def test_pages_load_nothing_and_link_to_what_exists(site):
    _, out, pages = site
    for file, page in pages.items():
        assert [t for t in page.loads if not t.startswith(("data:", "#"))] == [], file
        style_text = " ".join(re.findall(r"<style>(.*?)</style>", page.text, re.S))
        assert "@import" not in style_text and not re.findall(r"url\((?!['\"]?(?:data:|#))", style_text)
        for link in page.links:
            target = link.partition("#")[0]
            assert link.startswith("https://doi.org/") or (out / target).exists() or not target, f"{file}: {link}"
        assert len(page.ids) == len(set(page.ids)), f"{file}: an id occurs twice"
        assert (
            '<meta name="viewport"' in page.text
            and "prefers-color-scheme: dark" in page.text
            and "@media print" in page.text
        )
        assert str(ROOT) not in page.text, f"{file}: a path of this machine"


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    """A report of full-size runs in both readings, two beds, and a varied run, whose reason is markup."""
    root = tmp_path_factory.mktemp("full")
    results = root / "results"
    for scenario, law in (("linear-mu0.8", 2e-4), ("nonlinear-en1.0", 2e-3)):
        for variant in ("", "servo"):
            for code, seed in (("liggghts", 1), ("liggghts", 2), ("yade", 1)):
                folder = write_run(
                    results,
                    "full",
                    f"{scenario}+{variant}".rstrip("+"),
                    code,
                    cycles=12,
                    seed=seed,
                    law=("logarithm", {"a": law * (1 + 0.02 * seed), "b": law / 3}),
                    contacts=False,
                    info={"scenario": scenario, "variant": variant},
                )
                for name in ("bed_before.csv", "bed_after.csv", "history.csv"):
                    (folder / name).unlink()  # as in the repository
    write_run(
        results,
        "full",
        "linear-mu0.8+plates-fixed",
        cycles=12,
        law=("line", {"a": 4e-4, "b": 1e-6}),
        contacts=False,
        info={"scenario": "linear-mu0.8", "variant": "plates-fixed", "reason": "<script>alert(1)</script>"},
    )
    bonded = write_run(results, "full", "chen2015", cycles=12, law=("line", {"a": 1e-4, "b": 1e-6}), contacts=False)
    counts = "".join(f"{n},{90 - n},{n},0\n" for n in range(13))
    (bonded / "bonds.csv").write_text("cycle,bonds,bonds_broken_tension,bonds_broken_shear\n" + counts)
    broken = "".join(f"{n},0.4,0.3,0.2,tension\n" for n in range(1, 13))
    (bonded / "bonds_broken.csv").write_text("cycle,x_m,y_m,z_m,mode\n" + broken)
    return results, root / "report", build(results, root / "report")


def test_a_short_reading_does_not_shorten_what_is_told_of_a_long_one():
    def told(**last_cycles):
        rows = [
            {"reading": reading, "cycle": cycle, "beds": 1}
            for reading, last in last_cycles.items()
            for cycle in (1, 20, 100)
            if cycle <= last
        ]
        same = {"profile": "full", "scenario": "a", "code": "liggghts", "quantity": "settlement_m"}
        values = pd.DataFrame(rows).assign(**same)
        return told_cycle(SimpleNamespace(values=values), "full", "a", "liggghts")

    assert told(force=100, servo=20) == 100
    assert told(force=20, servo=1) == 1, "where none is long, both are told after the same cycle"
    assert told(force=100, servo=100) == 100


def test_overview_opens_with_the_test_and_the_answer_and_folds_what_is_pending(full):
    page = full[2]["index.html"]
    says = page.says
    found = [
        says.index(words)
        for words in (
            "The test.",
            "The linear model (linear μ 0.8: contacts of constant stiffness) settles 0.36 mm",
            "Pending:",
        )
    ]
    assert found == sorted(found)
    for words in (
        "over 2 packed beds) in 10 cycles",
        "Loaded by PFC's servo (default gain)",
        "The bonded model of Chen et al., run here from the paper's Table 3, settles",
        "12 of its 90 bonds broke",
        "With own beds they agree within 25 % (porosities 5 %) in",
        "end before the paper's 1000 cycles",
        "reference curves of",
    ):
        assert words in says, words
    assert "<details><summary>Pending" in page.text and "settlement-full-linear-mu0.8" in page.text
    assert {"servo.html", "claims.html", "comparison.html", "influence.html", "runs.html"} <= set(page.links)


def test_everything_can_be_downloaded_at_once(site):
    _, out, pages = site
    assert data_archive.NAME in pages["index.html"].links
    with zipfile.ZipFile(out / data_archive.NAME) as archive:
        names = set(archive.namelist())
        assert {"README.txt", "CITATION.cff", "LICENSE.md", "findings/columns.csv"} <= names
        assert {f"figures/{p.name}" for p in (out / "figures").glob("*.csv")} <= names
        columns = archive.read("findings/columns.csv").decode()
    assert columns.startswith("column,unit,meaning\n")


def test_demo_has_a_page_of_its_own_and_says_that_it_answers_nothing(site):
    pages = site[2]
    assert "no full-size run yet" in pages["index.html"].says and "demo.html" in pages["index.html"].links
    assert "answer none of the paper's questions" in pages["demo.html"].says
    assert "servo.html" not in pages, "a page with nothing on it is left out"


def test_what_a_file_says_is_never_markup(full):
    for file, page in full[2].items():
        assert "<script>alert" not in page.text, file
    assert "<script>alert(1)</script>" in full[2]["runs.html"].says


def test_every_figure_of_the_paper_is_drawn_in_both_readings(full):
    for reading in ("force", "servo"):
        for name in ("figure10-settlement", "figure10-lateral", "figure13"):
            assert f"{name}-{reading}" in full[2]["figures.html"].ids, (name, reading)
        for name in ("figure11", "figure12"):
            assert f"{name}-{reading}-en1" in full[2]["figures.html"].ids
        assert (full[1] / "figures" / f"figure10-lateral-{reading}-1000.svg").exists(), "an empty frame, but a frame"


def test_the_bonded_model_stands_beside_the_papers_two_and_its_bonds_are_counted_and_placed(full):
    page = full[2]["figures.html"]
    for name in ("bonded-settlement-true-load", "bonded-lateral-true-load", "bonds", "broken-bonds"):
        assert name in page.ids, name
    assert "It is not their published curve, which is pending" in page.says
    assert "12 90 12 0 13.3" in page.says, "cycle, made, broken in tension, in shear, %"
    places = pd.read_csv(full[1] / "figures" / "broken-bonds-chen2015-liggghts-x.csv")
    assert len(places) == 12 and set(places["mode"]) == {"tension"}
    claims = full[2]["claims.html"]
    assert "claim-12" in claims.ids and "Judged from our own run of that model" in claims.says


def test_servo_and_influence_have_their_pages(full):
    servo, influence = full[2]["servo.html"], full[2]["influence.html"]
    assert "low-pass filter" in servo.says and "nonlinear eₙ 1, PFC servo, YADE, bed 1" in servo.says
    assert "plates fixed linear μ 0.8 true load settlement at minimum load, mm 12" in influence.says


def test_tables_of_the_findings_lie_beside_the_pages(full):
    agreement = pd.read_csv(full[1] / "findings" / "agreement.csv")
    assert set(agreement["reading"]) == {"true load", "servo"}
    described = pd.read_csv(full[1] / "findings" / "columns.csv").set_index("column")
    for path in (full[1] / "findings").glob("*.csv"):
        if path.stem != "columns" and path.read_text().strip():
            assert set(pd.read_csv(path)) <= set(described.index), path.stem


def test_pages_have_numbered_sections_and_one_heading_of_the_first_order(full):
    for file, page in full[2].items():
        levels = [int(n) for n in re.findall(r"<h([1-6])[ >]", page.text)]
        assert levels[0] == 1 and levels.count(1) == 1, file
        assert all(b - a <= 1 for a, b in zip(levels, levels[1:], strict=False)), file
        for target in re.findall(r'<nav class="toc".*?</nav>', page.text, re.S):
            assert {link[1:] for link in re.findall(r'href="(#[^"]+)"', target)} <= {f"{i}" for i in page.ids}


def test_scenario_that_a_user_added_is_drawn(site):
    _, out, pages = site
    assert "Plates that do not move" in pages["runs.html"].says
    assert (out / "figures" / "own-settlement-linear.svg").exists()
    assert (
        "load_control.plate_law" in pages["assumptions.html"].says
    )  # the only run pair that differs in one assumption


def test_claims_are_all_there_with_a_verdict_for_each_code(site):
    page = site[2]["claims.html"]
    for n in range(1, 12):
        assert f"claim-{n}" in page.ids, n
    cards = re.findall(r'<div class="verdicts">(.*?)</div>', page.text)
    verdicts = re.findall(r'<span class="chip \w+">([^<]+)</span>', "".join(cards))
    assert len(cards) >= 11 and all("LIGGGHTS" in card or "both codes" in card for card in cards)
    assert set(verdicts) <= {"holds", "does not hold", "not decidable yet", "not decidable"}


def test_verification_shows_failures(site):
    page = site[2]["verification.html"]
    assert "LIGGGHTS, the paper's law: 1 of 1 comparisons pass" in page.says
    assert "YADE, its own law: 0 of 1 comparisons pass" in page.says and "YADE counts it, wrong on purpose" in page.says
    assert "verification-impact-linear-errors" in page.text


def test_the_verification_page_tells_of_each_case_what_must_come_out_and_shows_one_curve():
    """From the cases: the account, a sketch of the probe that is run, and a curve that the kept result has."""
    kept = KEPT_VERIFICATION / "verification"
    for case in VERIFIED:
        account = case.account
        assert all((account.happens, account.formula, account.source, account.tolerance)), case.name
        seen = case.sketch()
        assert seen.discs and (seen.arrows or seen.way or seen.weight or case.name == "porosity"), case.name
        assert bool(account.curve) == (kept / f"{case.name}_liggghts.csv").exists(), case.name
        for code in ("liggghts", "yade") if account.curve else ():
            series, column = account.curve
            curve = pd.read_csv(kept / f"{case.name}_{code}.csv")
            assert len(curve[curve["series"] == series].dropna(subset=[column, f"{column}_expected"])) > 5, case.name


def test_runs_page_tells_state_deviations_and_command(site):
    page = site[2]["runs.html"]
    for words in (
        "interrupted",
        "killed",
        "a restitution-equivalent law & <other> things",
        "make run SCENARIO=linear-mu0.8 CODE=yade",
    ):
        assert words in page.says, words


def test_every_parameter_is_listed_with_its_status(site):
    page = site[2]["assumptions.html"]
    text = page.text.replace("<wbr>", "")
    for key, parameter in load_scenario("linear-mu0.8").parameters.items():
        assert re.search(rf'<tr data-status="\w+"><th scope="row"><code>{re.escape(key)}</code>', text), key
        assert parameter.source.split(";")[0][:30] in page.says


def test_hovering_shows_the_runs_own_numbers(site):
    results, _, pages = site
    panel = pages["demo.html"].text.partition('href="figures/settlement-demo-linear-mu0.8.svg"')[0]
    hover = json.loads(re.findall(r'<script type="application/json">(.*?)</script>', panel, re.S)[-1])
    assert hover["unit"] == "mm"
    curves = {s["label"]: s for s in hover["series"]}
    cycles = pd.read_csv(results / "demo" / "linear-mu0.8" / "yade" / "cycles.csv").set_index("cycle")
    shown = dict(zip(curves["true load, YADE"]["x"], curves["true load, YADE"]["y"], strict=True))
    assert shown[24] == pytest.approx(1e3 * cycles["settlement_m"][24], rel=1e-4)


def test_no_runs_at_all(tmp_path):
    pages = build(tmp_path / "results", tmp_path / "report")
    assert "There is no run below" in pages["index.html"].says and "make demo" in pages["index.html"].says
    assert (tmp_path / "report" / "figures" / "figure9-restitution.svg").exists()


def test_broken_runs_cost_one_line_each_and_hide_nothing(tmp_path, capsys):
    _, torn, mad = (
        write_run(tmp_path, "demo", "linear-mu0.8", code, cycles=6, seed=seed)
        for code, seed in (("yade", 1), ("liggghts", 1), ("liggghts", 2))
    )
    text = (torn / "cycles.csv").read_text()
    (torn / "cycles.csv").write_text(text[:-40])
    (torn / "bed_after.csv").write_text("id,x_m\n1,2\n")
    (mad / "run.json").write_bytes(b"\xff\xfe{")
    (mad / "history.csv").write_text("")
    pages = build(tmp_path, tmp_path / "report")
    lines = capsys.readouterr().err.splitlines()
    assert all(line.startswith("warning: demo/") for line in lines), lines
    assert len(lines) == len(set(lines)) and {line.split(":")[1].strip() for line in lines} >= {
        "demo/linear-mu0.8/liggghts/cycles.csv",
        "demo/linear-mu0.8/liggghts/bed_after.csv",
        "demo/linear-mu0.8/liggghts-seed2/run.json",
    }
    assert "ends in mid-line" in pages["runs.html"].says
    assert "linear μ 0.8, YADE" in pages["demo.html"].says


def test_same_runs_give_the_same_files_without_a_word(tmp_path, capsys):
    write_run(tmp_path / "results", "demo", "nonlinear-en1.0", "liggghts", cycles=3)
    contents = []
    for out in ("one", "two"):
        build(tmp_path / "results", tmp_path / out)
        contents.append({p.relative_to(tmp_path / out): p.read_bytes() for p in sorted((tmp_path / out).rglob("*.*"))})
    assert capsys.readouterr().err == ""
    assert contents[0].keys() == contents[1].keys()
    assert [name for name, content in contents[0].items() if content != contents[1][name]] == []


@pytest.mark.parametrize(
    ("name", "pairs"),
    [
        ("linear-mu0.8", ["code"]),
        ("linear-mu0.8+stock", []),
        ("nonlinear-en1.0", ["code"]),
        ("nonlinear-md1-en0.6", ["code and dashpot"]),
    ],
)
def test_two_codes_that_each_take_their_own_contact_law_differ_in_more_than_the_code(name, pairs, tmp_path):
    for code in CODES:
        write_run(tmp_path, "demo", name, code, cycles=3)
    assert [pair.differs for pair in same_bed_pairs(report.load_runs(tmp_path))] == pairs


def test_runs_from_one_bed_stand_side_by_side_by_code_time_step_and_ranks(tmp_path):
    given = {"bed": "results/x/bed_packed.csv"}
    folders = [
        write_run(tmp_path, "demo", "linear-mu0.8", "liggghts", cycles=3),
        write_run(tmp_path / "same", "demo", "linear-mu0.8", "yade", cycles=3, info=given),
        write_run(tmp_path / "half", "demo", "linear-mu0.8", "liggghts", cycles=3, info=given),
        write_run(tmp_path / "ranks", "demo", "linear-mu0.8+same-bed", "liggghts", cycles=3, info={"ranks": 2}),
    ]
    law = load_scenario("linear-mu0.8", "demo", cycles=3)
    (folders[2] / "scenario.json").write_text(law.with_values({"time.step": law["time.step"] / 2}).to_json())
    for down, folder in enumerate(folders, start=1):
        stages = json.loads((folder / "stages.json").read_text())
        stages["preload"]["settlement_m"] = down * 1e-3
        (folder / "stages.json").write_text(json.dumps(stages))
    runs = report.load_runs(tmp_path)
    assert [run.id for run in runs if not is_variant(run)] == ["demo/linear-mu0.8/liggghts"]
    found = same_bed_pairs(runs)
    assert [(pair.differs, pair.other.id) for pair in found] == [
        ("code", "same/demo/linear-mu0.8/yade"),
        ("time.step", "half/demo/linear-mu0.8/liggghts"),
        ("ranks", "ranks/demo/linear-mu0.8+same-bed/liggghts"),
    ]
    table = settlements(found[0])
    assert table["cycle"].tolist() == [0, 1, 2, 3]
    assert table.loc[0, ["one_m", "other_m", "difference_m"]].tolist() == [1e-3, 2e-3, 1e-3]
    assert table.loc[0, "difference_ratio"] == pytest.approx(1 / 1.5)
    pages = build(tmp_path, tmp_path / "report")
    says = pages["comparison.html"].says
    assert re.search(r"linear μ 0.8 true load \w+ 3 67 120 2 too few pairs", says)
    assert "LIGGGHTS YADE difference, % LIGGGHTS 4.8 µs LIGGGHTS 2.4 µs difference, %" in says
    assert "in preload 1 2 67 1 3 100" in says and "after 3 cycles" in says


def test_command_prints_one_line_for_a_scenario_file_that_cannot_be_used(tmp_path, monkeypatch, capsys):
    def refuse(*_):
        raise report.ScenarioError("scenarios.toml: base.x is refused; allowed: y")

    monkeypatch.setattr(report, "build", refuse)
    assert report.main(["--results", str(tmp_path), "--out", str(tmp_path / "r")]) == 1
    assert capsys.readouterr().err == "report: scenarios.toml: base.x is refused; allowed: y\n"


def test_a_notebooks_matplotlib_does_not_reach_the_report(tmp_path):
    (tmp_path / "matplotlibrc").write_text("axes.facecolor: yellow\nfont.size: 30\n")
    own = {"MPLBACKEND": "module://matplotlib_inline.backend_inline", "MPLCONFIGDIR": str(tmp_path)}
    command = [sys.executable, "-m", "analysis", "report", "--help"]
    done = subprocess.run(command, env=os.environ | own, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0 and done.stderr == ""
    with matplotlib.rc_context({"axes.facecolor": "yellow", "font.size": 30}), style.settings():
        assert matplotlib.rcParams["axes.facecolor"] == "none" and matplotlib.rcParams["font.size"] == 9


# ------------------------------------------------------------------ words and colours


@pytest.mark.parametrize(
    "value, digits, factor, text",
    [
        (0.0012345, 3, 1e3, "1.23"),
        (4583, 3, 1, "4583"),
        (-0.5, 2, 1, "−0.5"),
        (float("nan"), 3, 1, "–"),
        (None, 3, 1, "–"),
        ("x", 3, 1, "–"),
        (2.652e-5, 4, 1, "2.652·10⁻⁵"),
        (1e8, 3, 1, "1·10⁸"),
        (123456, 2, 1, "123456"),
        (0, 3, 1, "0"),
    ],
)
def test_numbers_for_people(value, digits, factor, text):
    assert number(value, digits, factor) == text


def _seen(colour, defect):
    """CIE Lab of a colour as seen with full protanopia, deuteranopia or tritanopia (Machado, Oliveira and Fernandes
    2009).
    """
    matrix = {
        "none": np.eye(3),
        "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
        "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
        "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    }[defect]
    srgb = np.array([int(colour[n : n + 2], 16) for n in (1, 3, 5)]) / 255
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    linear = np.clip(np.array(matrix) @ linear, 0, 1)
    xyz = (
        np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
        @ linear
        / [0.9505, 1, 1.089]
    )
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("defect", ["none", "protan", "deutan", "tritan"])
@pytest.mark.parametrize("page", [0, 1], ids=["light", "dark"])
def test_hues_of_the_families_stay_apart(defect, page):
    for drawn_together in (("linear", "nonlinear", "md0", "md1", "md2"), ("linear", "nonlinear", "bonded")):
        hues = [style.PALETTE[name][page] for name in drawn_together]
        for n, one in enumerate(hues):
            for other in hues[:n]:
                assert np.linalg.norm(_seen(one, defect) - _seen(other, defect)) > 15, (one, other)


def test_names_of_curves_can_be_read():
    for family in style.PALETTE:
        for level in (-1.0, -0.5, 0.0, 1.0):
            colour = style.shade(family, level)
            named = style.text_colour(colour)
            assert style.contrast(named, style.PAPER) >= 4.5 or named == style.shade(family, 1.0), (family, level)
    assert style.contrast("#000000", "#ffffff") == pytest.approx(21) and style.contrast("#777777", "#777777") == 1


def test_labels_are_moved_apart_in_their_order_and_inside():
    placed = style._apart(np.array([0.0, 1.0, 1.5, 90.0]), 10, -5, 105)
    assert np.diff(placed).min() >= 9.99 and placed.min() >= -5 and abs(placed[3] - 90) < 1
    assert np.ptp(style._apart(np.zeros(50), 10, 0, 100)) <= 100  # more than there is room for


# ------------------------------------------------------------------ pictures

VIEW = render.camera(np.array([[-1.0, -1, -1], [1, 1, 1]]))


def test_nearer_sphere_hides_the_farther_one():
    centres = np.array([[0.0, 0.5, 0], [0, -0.5, 0]])  # the camera looks along +y
    image = render.render(centres, 0.3, np.array([[1.0, 0, 0], [0, 1, 0]]), np.array([1, 2]), VIEW, width=120)
    rows, columns, _ = image.shape
    red, green, _, alpha = image[rows // 2, columns // 2]
    assert alpha == 255 and green > 60 and green > 5 * red
    assert image[2, 2, 3] == 0
    covered = (image[..., 3] > 127).sum() * (2.02 / 120) ** 2  # margin_m is 0.01 at each side
    assert covered == pytest.approx(np.pi * 0.3**2, rel=0.02)


def test_glass_is_seen_before_a_sphere_and_not_behind_it():
    sphere, colour = np.array([[0.0, 0, 0]]), np.array([[1.0, 1, 1]])
    bare = render.render(sphere, 0.3, colour, np.array([1]), VIEW, width=120)
    for near, changed in ((-0.9, True), (0.8, False)):
        glass = render.box_faces((-0.6, near, -0.6), (0.6, near + 0.1, 0.6), VIEW, (0, 0, 1), 0.5)
        image = render.render(sphere, 0.3, colour, np.array([1]), VIEW, 120, glass)
        assert (image[60, 60, 0] < bare[60, 60, 0] - 20) == changed
        assert image[30, 60, 3] > 100  # beside the sphere it is seen either way


@pytest.mark.parametrize("azimuth, elevation", [(0, 0), (-28, 20), (90, 0), (35, 60)])
def test_camera_axes_are_orthonormal_and_up_is_up(azimuth, elevation):
    eye = render.camera(np.eye(3), azimuth, elevation)
    axes = np.stack([eye.right, eye.up, eye.towards])
    assert np.allclose(axes @ axes.T, np.eye(3)) and eye.up[2] >= 0
    assert eye.towards[2] == pytest.approx(np.sin(np.radians(elevation)))


def test_beds_tried_in_calibration_are_shown_with_the_chosen_one_marked(tmp_path):
    chosen = load_scenario("linear-mu0.8", "full")
    rows = []
    for name in ("linear-mu0.8", "nonlinear-en1.0"):
        for aspect in (chosen["clump.aspect"], 2.0):
            folder = write_run(tmp_path / f"beds{aspect}", "full", name, "liggghts", cycles=3)
            rows.append(calibrate.row(chosen.with_values({"clump.aspect": aspect}), Run(folder)))
    results, out = tmp_path / "results", tmp_path / "report"
    write_csv(results / "none" / "calibration.csv", [list(rows[0]), *(list(r.values()) for r in rows)])
    pages = build(results, out)
    says = pages["assumptions.html"].says
    assert says.count("(chosen)") == 1 and f"{chosen['clump.aspect']:g}, 14.1 mm (chosen)" in says
    assert "How the bed was calibrated" in says
    drawn = pd.read_csv(out / "figures" / "calibration-settlement.csv")
    assert drawn["settlement_m"].tolist() == pytest.approx([row["settlement_m"] for row in rows], rel=1e-8)  # 9 digits


def test_damaged_tables_of_studies_cost_their_sections_and_one_line_each(tmp_path, capsys):
    kept, out = tmp_path / "none", tmp_path / "report"
    names = ("calibration", "timestep", "benchmark", "benchmark_sizes", "benchmark_profile")
    for path in (*(kept / f"{name}.csv" for name in names), out / "verification.csv"):
        path.parent.mkdir(exist_ok=True)
        path.write_text("case,code\n<b>,2\n")
    pages = build(tmp_path, out)
    assert "How the bed was calibrated" not in pages["assumptions.html"].says
    assert not {"timestep.html", "benchmark.html"} & set(pages)
    said = capsys.readouterr().err.splitlines()
    for path in (*(f"{name}.csv" for name in names), "verification.csv"):
        (line,) = [line for line in said if line.startswith(f"warning: {path}: line 1: column ")]
        assert "or run make" in line
        assert line.removeprefix("warning: ") in pages["runs.html"].says


def test_the_readme_is_not_made_from_damaged_tables(tmp_path, monkeypatch, capsys):
    (tmp_path / "benchmark.csv").write_text("case,code\n")
    monkeypatch.setattr(readme, "KEPT_RUNS", tmp_path)
    monkeypatch.setattr(readme, "find", lambda *some: find(*some, tmp_path))
    assert readme.main(["--check"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("readme: benchmark.csv: line 1: column ")


def test_scene_puts_sleeper_and_plates_where_they_stand(tmp_path):
    folder = write_run(tmp_path, "demo", "linear-mu0.8", "yade", cycles=3)
    before, after = (load_scene(folder, label) for label in ("before", "after"))
    last = pd.read_csv(folder / "cycles.csv").iloc[-1]
    assert before.sleeper.low[2] - after.sleeper.low[2] == pytest.approx(last["settlement_m"])
    assert after.plates[2].low[0] - before.plates[2].low[0] == pytest.approx(last["lateral_3_m"])
    moved = beds.positions(after.bed) - beds.positions(before.bed)
    assert np.allclose(after.moved_m, moved) and before.moved_m is None


def test_view_writes_pictures_and_files_for_paraview(tmp_path, capsys):
    folder = write_run(tmp_path, "demo", "linear-mu0.8", "liggghts", cycles=2, seed=3)
    shutil.copyfile(folder / "bed_after.csv", folder / "raw" / "bed_cycle_000002.csv")
    assert view.main(["linear-mu0.8", "--code", "liggghts", "--seed", "3", "--results", str(tmp_path)]) == 0
    written = capsys.readouterr().out.split()
    assert {name.rpartition("/")[2] for name in written} >= {
        "bed_after.png",
        "section_after.png",
        "force_chains_after.png",
        "bed.webp",
        "spheres_after.vtp",
        "walls_after.vtp",
        "force_chains_after.vtp",
    }
    moving = Image.open(folder / "view" / "bed.webp")
    assert kept_cycles(folder) == [2] and moving.n_frames == 2, "one at the end of preload, one for each kept cycle"
    root = xml.parse(folder / "view" / "spheres_after.vtp").getroot()
    arrays = {a.get("Name"): a for a in root.iter("DataArray")}
    content = base64.b64decode(arrays["Points"].text)
    assert struct.unpack("<Q", content[:8])[0] == len(content) - 8
    scene = load_scene(folder, "after")
    expected = beds.sphere_centres(scene.bed, derived.clump(scene.scenario).half_distance_m)
    assert np.array_equal(np.frombuffer(content[8:], "<f8").reshape(-1, 3), expected)
    assert int(root.find("PolyData/Piece").get("NumberOfPoints")) == len(expected)


def test_a_bed_that_can_be_turned_loads_nothing(tmp_path):
    pytest.importorskip("k3d", reason="k3d, the optional dependency `view`, is not installed")
    scene = packed_scene(KEPT_RUNS / KEPT_BED, load_scenario("linear-mu0.8", "full"))
    path = turnable.write_html(tmp_path / "bed.html", [scene], "a bed")
    first = path.read_bytes()
    assert not re.findall(rb"<(?:script|link)[^>]*(?:src|href)=", first)
    assert turnable.write_html(path, [scene], "a bed").read_bytes() == first


def test_spheres_of_a_clump_are_drawn_as_one_body():
    axis = np.array([[0.0, 0.8, 0.0]])  # up to the joint, in radii
    at_joint, near = render._joined(np.array([[0.0, 0.8, 0.6]]), axis)
    assert near == pytest.approx([1]) and np.allclose(at_joint, [[0, 0, 1]]), "as of a rod through both"
    far, near = render._joined(np.array([[0.0, -0.8, 0.6]]), axis)
    assert near == pytest.approx([0]) and np.allclose(far, [[0, -0.8, 0.6]]), "its own on the side away"
    alone, _ = render._joined(np.array([[0.0, 0.8, 0.6]]), np.zeros((1, 3)))
    assert np.allclose(alone, [[0, 0.8, 0.6]])


def test_view_of_a_run_that_is_not_there(tmp_path, capsys):
    assert view.main(["linear-mu0.8", "--code", "yade", "--results", str(tmp_path)]) == 1
    error = capsys.readouterr().err
    assert error.startswith("view: ") and error.count("\n") == 1
