"""Reference data: what is committed is valid; a digitised curve of any kind is taken up, or refused in one line."""

import json
import re
import shutil
import textwrap
import tomllib

import numpy as np
import pandas as pd
import pytest
from synthetic import write_run

from analysis import load_runs
from analysis.comparison import against_published, run_quantities
from analysis.comparison.claims.verdicts import evaluate_claims, load_claims
from analysis.comparison.findings.members import READINGS
from analysis.files import PUBLISHED, ROOT
from analysis.formats.quantities import CODES
from analysis.reference import check, webplotdigitizer
from analysis.reference.curves import load_references, sidecars
from analysis.reference.reported import reported
from analysis.reference.settlement_laws import settlement_laws
from analysis.reference.settlement_shapes import settlement_shapes
from analysis.report.build import build
from analysis.report.figure import Gallery
from analysis.report.figures.lateral_figures import lateral_figure
from analysis.report.figures.porosity_figures import porosity_figure
from analysis.report.figures.settlement_figures import settlement_figure
from analysis.scenarios.scenario import scenario_names

CYCLES = np.array([1, 2, 5, 10, 20, 50, 100, 200, 500, 1000.0])
SETTLEMENT_MM = 2 + 8 * (1 - np.exp(-CYCLES / 20)) + 0.003 * CYCLES
DEPTH_MM = np.array([33.0, 98, 163, 228, 293])


@pytest.fixture
def folder(tmp_path):
    """A copy of the committed reference data, to drop files into."""
    target = tmp_path / "published"
    shutil.copytree(PUBLISHED, target)
    return target


def fill(
    sidecar, files, x=("-", [0, 1000]), y=("mm", [0, 20]), error=(0.2, "mm"), status="digitised", base=0, **replace
):
    """Answer every "?" of a sidecar, x and y as (unit, range) or (unit, range, scale); `replace` maps further words."""
    text = sidecar.read_text()
    text = text.replace('status  = "pending"', f'status  = "{status}"')
    text = text.replace("files        = []", f"files = {json.dumps(files)}")
    for key, value in (("digitised_by", '"A. Tester"'), ("date", "2026-03-01"), ("method", '"synthetic"')):
        text = re.sub(rf"(?m)^{key} .*$", f"{key} = {value}", text)
    text = re.sub(r"(?m)^error .*$", f'error = {{ value = {error[0]}, unit = "{error[1]}", source = "made up" }}', text)
    text = text.replace('at_sleeper_base = "?"', f"at_sleeper_base = {base}")
    head, x_axis, y_axis = re.split(r"(?=\[axes\.[xy]\])", text)
    blocks = []
    for block, (unit, limits, *scale) in ((x_axis, x), (y_axis, y)):
        block = block.replace('unit     = "?"', f'unit     = "{unit}"')
        scales = "".join(f'\nscale    = "{value}"' for value in scale)
        blocks.append(block.replace('range    = "?"', f"range    = {limits}{scales}"))
    text = head + "".join(blocks)
    for old, new in replace.items():
        assert old in text
        text = text.replace(old, new)
    sidecar.write_text(text)


def single_csv(path, points, separator=", ", decimal="."):
    path.write_text("".join(separator.join(f"{v:.10g}".replace(".", decimal) for v in row) + "\n" for row in points))


def side_by_side_csv(path, datasets):
    """As WebPlotDigitizer's dataExport.js writes it: names and X,Y headers, shorter columns padded by empty cells."""
    lines = [",".join(f"{name}," for name in datasets), ",".join("X,Y" for _ in datasets)]
    for k in range(max(map(len, datasets.values()))):
        lines.append(",".join(",".join(map(repr, map(float, d[k]))) if k < len(d) else "," for d in datasets.values()))
    path.write_text("\n".join(lines) + "\n")


def project_json(path, datasets, x=(0, 1000), y=(0, 20), version=4, axes_type="XYAxes", log_x=False, bar=None):
    """`bar` adds a chart of that name on axes of another kind."""
    corners = [
        {"px": 0, "py": 0, "dx": str(dx), "dy": str(dy), "dz": None}
        for dx, dy in ((x[0], y[0]), (x[1], y[0]), (x[0], y[0]), (x[0], y[1]))
    ]
    series = [
        {
            "name": name,
            "axesName": "XY",
            "metadataKeys": [],
            "autoDetectionData": None,
            "data": [{"x": 1.0, "y": 2.0, "value": list(map(float, p))} for p in points],
        }
        for name, points in datasets.items()
    ]
    if version == 3:
        body = {
            "wpd": {
                "version": [3, 8],
                "axesType": axes_type,
                "axesParameters": {"isLogX": log_x, "isLogY": False},
                "calibration": corners,
                "dataSeries": series,
            }
        }
    else:
        axes = [{"name": "XY", "type": axes_type, "isLogX": log_x, "isLogY": False, "calibrationPoints": corners}]
        if bar:
            axes.append({"name": "Bar", "type": "BarAxes", "calibrationPoints": corners[:2]})
            series.append({"name": bar, "axesName": "Bar", "data": [{"x": 1.0, "y": 2.0, "value": [3.0, 4.0, 5.0]}]})
        body = {"version": [4, 2], "axesColl": axes, "datasetColl": series, "measurementColl": []}
    path.write_text(json.dumps(body))


def settlement_points(scale=1.0):
    return np.column_stack([CYCLES, scale * SETTLEMENT_MM])


def only(references, **wanted):
    assert references.problems == []
    return references.curve(**wanted)


# ------------------------------------------------------------------ what is committed


def test_the_committed_reference_data_are_valid():
    references = load_references()
    assert references.problems == []
    assert len(references.pending) + references.curves.groupby(["sidecar", "curve"]).ngroups == 70


def test_every_committed_curve_that_is_there_names_who_digitised_it_and_its_error():
    curves = load_references().curves
    assert (curves["error"] > 0).all() and set(curves["status"]) <= {"digitised", "transcribed"}


@pytest.mark.parametrize("source, kind", [("indraratna2013", "experiment"), ("chen2015", "simulation")])
def test_settlement_and_profiles_after_1_100_1000_cycles_are_asked_of_both_sources(source, kind):
    references = load_references()
    known = {
        (r.quantity, r.cycle if r.quantity == "lateral_displacement" else None)
        for table in (references.pending, references.curves)
        for r in table[table["source"] == source].itertuples()
        if r.kind == kind
    }
    assert known == {("settlement", None), *(("lateral_displacement", n) for n in (1, 100, 1000))}


def test_every_scenario_of_the_paper_has_its_curves_asked_for():
    references = load_references()
    for quantity in ("settlement", "lateral_displacement"):
        asked = {
            r.scenario
            for t in (references.pending, references.curves)
            for r in t.itertuples()
            if r.source == "talebiahooie2021" and r.quantity == quantity
        }
        assert len(asked) == 14 and asked <= set(scenario_names())


def test_settlement_laws_are_one_at_the_first_cycle_and_follow_their_formulas():
    laws = {law.id: law for law in settlement_laws()}
    assert set(laws) == {"log-lower", "log-hettler", "power-selig-waters"}
    for law in laws.values():
        assert law.ratio(1) == 1 and law.status == "transcribed" and law.source
        assert law.ratio(50, reference_cycle=100) == pytest.approx(law.ratio(50) / law.ratio(100))
    assert laws["log-hettler"].ratio(np.e**2) == pytest.approx(1.86)
    assert laws["log-lower"].ratio(np.e**2) == pytest.approx(1.4)
    assert laws["power-selig-waters"].ratio(1000) == pytest.approx(3.2359, abs=1e-4)


def test_measured_shapes_are_as_transcribed_and_say_what_they_can_and_cannot_decide():
    found = settlement_shapes()
    shapes = {s.id: s for s in found.shapes}
    assert len(shapes) == 4 and found.status == "transcribed"
    for shape in shapes.values():
        assert np.isfinite(shape.ratio(shape.cycles, reference_cycle=1000)).all(), "a test that ends before 1000 cycles"
    assert shapes["sun-30kPa-230kPa"].ratio([1, 10, 100, 1000]) == pytest.approx([0.084, 0.255, 0.428, 1])
    assert shapes["tennakoon-indraratna-10kPa"].ratio([1, 49, 979]) == pytest.approx([0.29, 0.557, 1])
    assert shapes["sun-10kPa-230kPa"].ratio(1000, reference_cycle=100) == pytest.approx(1 / 0.429)
    assert np.isnan(shapes["tennakoon-indraratna-10kPa"].ratio(1000))  # nothing beyond what was measured
    low, high = found.least_and_largest(1)
    assert (low, high) == pytest.approx((0.059, 0.29)) and "6 to 29 %" in found.decides
    assert "2.1" in found.weakness and "third party" in found.provenance and found.cannot_decide


@pytest.mark.parametrize(
    "old, new, words",
    [
        ("0.29, 0.557, 1.0", "0.29, 0.557, 0.9", "tennakoon-indraratna-10kPa: cycles and ratio are refused"),
        ("[1, 49, 979]", "[1, 49]", "tennakoon-indraratna-10kPa: cycles and ratio are refused"),
        ('source     = "tennakoon2014"', 'source     = "nobody2014"', "source 'nobody2014' is not in reference.bib"),
        ("weakness ", "strength ", "[about] has quantity, status, provenance, weakness"),
    ],
)
def test_a_bad_settlement_shape_is_refused_in_one_line(folder, capsys, old, new, words):
    path = folder / "settlement_shapes" / "shapes.toml"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    assert check.main(["--folder", str(folder)]) == 1
    error = capsys.readouterr().err
    assert words in error and error.count("\n") == 1


def test_the_answers_shown_in_the_guide_are_accepted(folder):
    """The example of README.md, laid over the sidecar it speaks of."""
    guide = (PUBLISHED.parent / "README.md").read_text()
    example = textwrap.dedent(re.search(r"```toml\n(.*?)```", guide, re.DOTALL)[1])
    source = folder / "indraratna2013"
    answered, axes = re.split(r"(?=\[axes\.x\])", example)
    kept = re.sub(
        r"(?m)^(status|files|digitised_by|date|method|error) .*\n",
        "",
        (source / "settlement.toml").read_text().split("[axes.x]")[0],
    )
    (source / "settlement.toml").write_text(answered + kept + axes)
    single_csv(source / "settlement.csv", settlement_points())
    assert len(only(load_references(folder), quantity="settlement")) == len(CYCLES)


def test_make_reference_lists_what_is_pending_and_succeeds(capsys):
    assert check.main([]) == 0
    out = capsys.readouterr().out
    assert re.search(r"indraratna2013/settlement\.toml +1 pending", out)
    assert re.search(r"Curves: \d+ there, \d+ pending", out)


# ------------------------------------------------------------------ dropping curves in


@pytest.mark.parametrize("separator, decimal", [(", ", "."), (",", "."), ("; ", ","), ("\t", ".")])
def test_a_single_csv_is_taken_up_whatever_its_dataset_was_called(folder, separator, decimal):
    source = folder / "indraratna2013"
    single_csv(source / "Default Dataset.csv", settlement_points(), separator, decimal)
    fill(source / "settlement.toml", ["Default Dataset.csv"])
    curve = only(load_references(folder), quantity="settlement", kind="experiment")
    assert curve["value"].to_numpy() == pytest.approx(SETTLEMENT_MM * 1e-3)
    assert curve["cycle"].to_numpy() == pytest.approx(CYCLES)
    assert set(curve["unit"]) == {"m"} and set(curve["error"]) == {2e-4} and set(curve["status"]) == {"digitised"}
    assert set(curve["curve"]) == {"experiment"} and curve["depth_m"].isna().all()


def test_several_single_csv_files_are_named_after_their_datasets(folder):
    source = folder / "talebiahooie2021"
    names = ["linear-mu0.7", "linear-mu0.9"]
    for k, name in enumerate(names):
        single_csv(source / f"{name}.csv", settlement_points(1 + k / 10))
    fill(source / "figure10_settlement.toml", [f"{n}.csv" for n in names])
    references = load_references(folder)
    for k, name in enumerate(names):
        curve = only(references, quantity="settlement", scenario=name)
        assert curve["value"].iloc[-1] == pytest.approx((1 + k / 10) * SETTLEMENT_MM[-1] * 1e-3)
    waiting = references.pending[references.pending["sidecar"] == "talebiahooie2021/figure10_settlement.toml"]
    assert list(waiting["curve"]) == ["linear-mu0.8"]


def test_datasets_side_by_side_become_profiles_over_depth_below_the_sleeper(folder):
    source = folder / "indraratna2013"
    profiles = {
        f"experiment after {n}": np.column_stack([0.01 * (1 + k) * DEPTH_MM, DEPTH_MM])[: 5 - k % 2]
        for k, n in enumerate((1, 100, 1000))
    }
    side_by_side_csv(source / "wpd_datasets.csv", profiles)
    fill(source / "lateral_displacement.toml", ["wpd_datasets.csv"], x=("mm", [0, 10]), y=("mm", [0, 325]))
    references = load_references(folder)
    for k, n in enumerate((1, 100, 1000)):
        curve = only(references, quantity="lateral_displacement", cycle=n)
        depth = DEPTH_MM[: 5 - k % 2] * 1e-3
        assert curve["depth_m"].to_numpy() == pytest.approx(depth)
        assert curve["value"].to_numpy() == pytest.approx(0.01 * (1 + k) * depth)
        assert set(curve["cycle"]) == {n}


@pytest.mark.parametrize("version", [3, 4])
def test_a_project_file_with_several_datasets_is_taken_up_with_percent_as_porosity(folder, version):
    source = folder / "talebiahooie2021"
    cycles = np.array([0.0, 10, 100, 1000])
    datasets = {f"sphere {k}": np.column_stack([cycles, 34 + k + cycles / 1000]) for k in (1, 2, 3)}
    project_json(source / "wpd.json", datasets, y=(30, 40), version=version)
    fill(source / "figure13_porosity_nonlinear.toml", ["wpd.json"], y=("%", [30, 40]), error=(0.1, "%"))
    references = load_references(folder)
    for k in (1, 2, 3):
        curve = only(references, quantity="porosity", scenario="nonlinear-en1.0", sphere=k)
        assert curve["value"].to_numpy() == pytest.approx((34 + k + cycles / 1000) / 100)
        assert set(curve["unit"]) == {"-"} and curve["error"].to_numpy() == pytest.approx(1e-3)


def test_an_axis_of_heights_and_one_of_negative_settlements_are_turned_round(folder):
    source = folder / "chen2015"
    single_csv(source / "simulation after 1.csv", np.column_stack([[1.0, 2, 3, 4, 5], 325 - DEPTH_MM]))
    fill(
        source / "lateral_displacement.toml",
        ["simulation after 1.csv"],
        x=("mm", [0, 10]),
        y=("mm", [0, 325]),
        base=325,
        **{"reversed = false": "reversed = true"},
    )
    single_csv(source / "s.csv", np.column_stack([CYCLES, -SETTLEMENT_MM / 10]))
    fill(
        source / "settlement.toml",
        ["s.csv"],
        y=("cm", [0, -2]),
        error=(0.02, "cm"),
        **{"reversed = false": "reversed = true"},
    )
    references = load_references(folder)
    profile = only(references, quantity="lateral_displacement", source="chen2015")
    assert profile["depth_m"].to_numpy() == pytest.approx(DEPTH_MM * 1e-3)
    assert only(references, quantity="settlement")["value"].to_numpy() == pytest.approx(SETTLEMENT_MM * 1e-3)


def test_metres_and_millimetres_are_told_apart_by_the_declared_unit_only(folder):
    source = folder / "indraratna2013"
    single_csv(source / "s.csv", settlement_points(1e-3))
    fill(source / "settlement.toml", ["s.csv"], y=("m", [0, 0.02]), error=(2e-4, "m"))
    curve = only(load_references(folder), quantity="settlement")
    assert curve["value"].to_numpy() == pytest.approx(SETTLEMENT_MM * 1e-3)


def test_seconds_on_the_axis_become_cycles_of_the_load(folder):
    source = folder / "indraratna2013"
    single_csv(source / "s.csv", np.column_stack([CYCLES / 20, SETTLEMENT_MM]))
    fill(source / "settlement.toml", ["s.csv"], x=("s", [0, 50]))
    assert only(load_references(folder), quantity="settlement")["cycle"].to_numpy() == pytest.approx(CYCLES)


def test_numbers_from_a_table_are_listed_as_transcribed(folder, capsys):
    source = folder / "indraratna2013"
    single_csv(source / "s.csv", settlement_points())
    fill(source / "settlement.toml", ["s.csv"], status="transcribed")
    assert check.main(["--folder", str(folder)]) == 0
    assert re.search(r"indraratna2013/settlement\.toml +1 transcribed", capsys.readouterr().out)


def drop_everything(folder):
    """Made-up curves for every sidecar, in all formats; settlements end at 13 mm, profiles grow with cycles."""
    for sidecar in sidecars(folder):
        names = [(c["dataset"], c.get("cycle", 0)) for c in tomllib.loads(sidecar.read_text())["curves"]]
        stem, share = sidecar.stem, np.array([0.0, 10, 100, 1000]) / 1000
        if "porosity" in stem:
            points = {
                name: np.column_stack([1000 * share, 0.34 + (k + share) / 100]) for k, (name, _) in enumerate(names)
            }
            project_json(sidecar.parent / f"{stem}.json", points, y=(0.3, 0.4), version=3)
            fill(sidecar, [f"{stem}.json"], y=("-", [0.3, 0.4]), error=(0.001, "-"))
        elif "lateral" in stem:
            points = {
                name: np.column_stack([(1 + np.log10(cycle)) * np.array([1.0, 2, 3, 2, 1]), DEPTH_MM])
                for name, cycle in names
            }
            side_by_side_csv(sidecar.parent / f"{stem}.csv", points)
            fill(sidecar, [f"{stem}.csv"], x=("mm", [0, 20]), y=("mm", [0, 325]))
        elif len(names) == 1:
            single_csv(sidecar.parent / f"{stem}.csv", settlement_points())
            fill(sidecar, [f"{stem}.csv"])
        else:
            project_json(sidecar.parent / f"{stem}.json", {name: settlement_points() for name, _ in names})
            fill(sidecar, [f"{stem}.json"])


def test_curves_of_every_kind_are_listed_drawn_and_scored(folder, tmp_path, capsys):
    drop_everything(folder)
    references = load_references(folder)
    assert references.problems == [] and references.pending.empty
    assert references.curves.groupby(["sidecar", "curve"]).ngroups == 70
    assert check.main(["--folder", str(folder)]) == 0
    assert "Curves: 70 there, 0 pending" in capsys.readouterr().out

    write_run(tmp_path / "results", "demo", "linear-mu0.8", cycles=5, contacts=False)
    runs = load_runs(tmp_path / "results", quiet=True)
    gallery = Gallery(tmp_path / "figures", "test", runs, references, scenario_names())
    for draw in (settlement_figure, lateral_figure, porosity_figure):
        drawn = draw(gallery, runs, draw.__name__, "title", "caption")
        assert drawn.pending == []
        text = "".join((tmp_path / "figures" / f"{panel.name}.svg").read_text() for panel in drawn.panels)
        if draw is not porosity_figure:
            assert "experiment" in text and "Chen 2015" in text
        assert "paper " in text and "pending" not in text
        # the CSV behind a panel holds the reference's points, too (the profiles after cycle 1)
        points = pd.read_csv(tmp_path / "figures" / f"{drawn.panels[0].name}.csv")
        assert points["run"].astype(str).str.startswith("reference ").any()
        if draw is settlement_figure:  # a short run is not squashed by a reference of 1000 cycles
            assert drawn.panels[0].hover["x"][1] < 6 and 1000 in drawn.panels[1].hover["series"][-1]["x"]
            assert abs(drawn.panels[0].hover["y"][0]) < 7

    profiles = against_published.lateral_reference_table(runs, references)
    assert set(profiles["cycle"]) == {1} and {"experiment after 1"} <= set(profiles["curve"])
    first = profiles[profiles["curve"] == "experiment after 1"].iloc[0]
    depth = run_quantities.plate_depths(runs[0].scenario)
    theirs = np.interp(depth, DEPTH_MM * 1e-3, np.array([1.0, 2, 3, 2, 1]) * 1e-3)
    ours = runs[0].cycles.loc[0, [f"lateral_{k}_m" for k in range(1, 6)]].to_numpy(dtype=float)
    inside = (depth >= DEPTH_MM[0] * 1e-3) & (depth <= DEPTH_MM[-1] * 1e-3)
    assert first["rms_m"] == pytest.approx(np.sqrt(np.mean((ours - theirs)[inside] ** 2)))

    scored = against_published.reference_table(runs, references)
    assert set(scored["curve"]) == {"experiment", "simulation", "linear-mu0.8"}
    ours = np.interp([1, 2, 5], runs[0].cycles["cycle"], runs[0].cycles["settlement_m"])
    assert scored["shift_m"].to_numpy() == pytest.approx((ours - SETTLEMENT_MM[:3] * 1e-3).mean())

    build(tmp_path / "results", tmp_path / "report", tmp_path / "none", folder)
    page = (tmp_path / "report" / "figures.html").read_text()
    assert "Where the reference curves come from" in page and page.count("A. Tester, 2026-03-01") == len(
        sidecars(folder)
    )
    assert "Lateral displacement against the reference profiles" in page
    first_page = (tmp_path / "report" / "index.html").read_text()
    assert "reference curves of" not in first_page  # none is pending

    judged = [v for v in evaluate_claims(runs, references) if v.claim.reference]
    claims, _ = load_claims()
    places = len(CODES) * len(READINGS)
    assert len(judged) == places * sum(bool(claim.reference) for claim in claims) > 0
    assert not any("(pending)" in m for v in judged for m in v.missing)


def test_one_bad_sidecar_does_not_hide_the_others(folder, capsys):
    for source in ("indraratna2013", "chen2015"):
        single_csv(folder / source / "s.csv", settlement_points())
        fill(folder / source / "settlement.toml", ["s.csv"])
    (folder / "chen2015" / "settlement.toml").write_text("status = ")
    references = load_references(folder)
    assert set(references.curves["source"]) == {"indraratna2013"}
    (problem,) = references.problems
    assert problem.startswith("chen2015/settlement.toml: is not valid TOML")
    assert check.main(["--folder", str(folder)]) == 1
    assert "ERROR: chen2015/settlement.toml" in capsys.readouterr().err


# ------------------------------------------------------------------ WebPlotDigitizer as people use it


def test_points_in_the_order_of_clicking_are_sorted_on_reading(folder):
    shuffled = np.random.default_rng(1).permutation(settlement_points())
    single_csv(folder / "indraratna2013" / "s.csv", shuffled)
    fill(folder / "indraratna2013" / "settlement.toml", ["s.csv"])
    rows = only(load_references(folder), quantity="settlement")
    assert rows["cycle"].to_numpy() == pytest.approx(CYCLES)
    assert rows["value"].to_numpy() == pytest.approx(1e-3 * SETTLEMENT_MM)


@pytest.mark.parametrize("version", [3, 4])
def test_a_logarithmic_axis_is_read_by_the_project_or_by_the_sidecar(folder, version):
    cycles = np.array([1, 3, 10, 2e3, 5e4, 5e5])
    points = np.column_stack([cycles, np.linspace(2, 18, 6)])
    source = folder / "indraratna2013"
    project_json(source / "wpd.json", {"experiment": points}, x=(1, 5e5), version=version, log_x=True)
    fill(source / "settlement.toml", ["wpd.json"], x=("-", [1, 500000]))
    single_csv(folder / "chen2015" / "s.csv", points[:3])  # on a linear axis to 500 000 they would span nothing
    fill(folder / "chen2015" / "settlement.toml", ["s.csv"], x=("-", [1, 500000], "log"))
    references = load_references(folder)
    assert only(references, quantity="settlement", source="indraratna2013")["cycle"].to_numpy() == pytest.approx(cycles)
    assert len(only(references, quantity="settlement", source="chen2015")) == 3


def test_one_project_serves_several_sidecars_each_takes_what_it_names(folder):
    source = folder / "indraratna2013"
    profile = np.column_stack([np.linspace(10, 150, 5), DEPTH_MM])
    body = {"experiment": settlement_points(), "experiment after 100": profile}
    project_json(source / "wpd.json", body, y=(0, 325))
    fill(source / "settlement.toml", ["wpd.json"], y=("mm", [0, 325]))
    fill(source / "lateral_displacement.toml", ["wpd.json"], x=("mm", [0, 1000]), y=("mm", [0, 325]), base=0)
    references = load_references(folder)
    assert references.problems == []
    assert set(references.curves["curve"]) == set(body)


def test_what_no_sidecar_names_is_complained_of_and_the_rest_is_taken(folder):
    source = folder / "indraratna2013"
    project_json(
        source / "wpd.json", {"experiment": settlement_points(), "scratch": settlement_points()}, bar="columns"
    )
    fill(source / "settlement.toml", ["wpd.json"])
    references = load_references(folder)
    (problem,) = references.problems
    assert "dataset 'scratch' is not a curve of settlement.toml" in problem and "likewise 'columns'" in problem
    assert set(references.curves["curve"]) == {"experiment"}


def test_datasets_named_like_numbers_and_names_over_both_columns_are_read(tmp_path):
    path = tmp_path / "all.csv"
    path.write_text("0.6,0.6,inf,\nX,Y,x,y\n1,2,3,4\n5,6,,\n")
    found = {d.name: d.points.tolist() for d in webplotdigitizer.read(path)}
    assert found == {"0.6": [[1, 2], [5, 6]], "inf": [[3, 4]]}


def test_a_file_without_any_of_the_sidecars_curves_is_not_overlooked(folder):
    source = folder / "indraratna2013"
    profile = np.column_stack([np.linspace(10, 150, 5), DEPTH_MM])
    project_json(source / "wpd.json", {"experiment after 100": profile, "experiment after 1": profile}, y=(0, 325))
    fill(source / "settlement.toml", ["wpd.json"])
    fill(source / "lateral_displacement.toml", ["wpd.json"], x=("mm", [0, 1000]), y=("mm", [0, 325]), base=0)
    (problem,) = load_references(folder).problems
    assert problem.startswith("indraratna2013/settlement.toml: none of its curves is in wpd.json; rename the dataset")


# ------------------------------------------------------------------ what is refused


def _points(change):
    def make(source):
        single_csv(source / "s.csv", change(settlement_points()))
        return {}

    return make


def _file(name, content):
    def make(source):
        (source / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        return {"files": [name]}

    return make


def _fill(**options):
    def make(source):
        single_csv(source / "s.csv", settlement_points())
        return options

    return make


def _project(**options):
    def make(source):
        project_json(source / "wpd.json", {"experiment": settlement_points()}, **options)
        return {"files": ["wpd.json"]}

    return make


def _row(points, k, column, value):
    points[k, column] = value
    return points


# what is wrong: (what is made, words of the line)
BAD = {
    "file missing": (lambda source: {}, ["s.csv", "cannot be read", "put the exported file here"]),
    "file empty": (_file("s.csv", ""), ["s.csv", "holds no points"]),
    "not text": (_file("s.csv", b"\xff\xfe1\x002"), ["s.csv", "not UTF-8"]),
    "three columns": (_file("s.csv", "1,2,3\n2,3,4\n3,4,5\n"), ["s.csv: line 1", "3 values", "Export All Data"]),
    "a word among numbers": (_file("s.csv", "1,2\n2,x\n"), ["s.csv: line 2", "'x' is not a number"]),
    "infinite": (_file("s.csv", "1,2\n2,inf\n"), ["s.csv: line 2", "not finite"]),
    "polar axes": (_file("s.csv", "a,,\nR,Theta,\n1,2,\n"), ["s.csv: line 2", "2D (X-Y) Plot"]),
    "comma in a name": (_file("s.csv", "a,b,,c,\nX,Y,X,Y\n1,2,3,4\n"), ["s.csv", "names without commas"]),
    "nameless dataset": (_file("s.csv", "a,,,\nX,Y,X,Y\n1,2,3,4\n"), ["s.csv", "column 3", "no name"]),
    "misspelt dataset": (
        _file("s.csv", "experment,,b,\nX,Y,X,Y\n1,2,3,4\n"),
        ["s.csv", "'experment' is not a curve of settlement.toml", "perhaps 'experiment'"],
    ),
    "dataset twice": (
        _file("s.csv", "experiment,,experiment,\nX,Y,X,Y\n1,2,3,4\n"),
        ["s.csv", "'experiment' occurs twice"],
    ),
    "not JSON": (_file("s.json", "{"), ["s.json", "not JSON", "save the project again"]),
    "JSON of something else": (_file("s.json", '{"a": 1}'), ["s.json", "not a WebPlotDigitizer project", "wpd.json"]),
    "JSON list": (_file("s.json", "[1, 2]"), ["s.json", "not a WebPlotDigitizer project"]),
    "project on a map": (_project(axes_type="MapAxes"), ["wpd.json", "MapAxes", "2D (X-Y) Plot"]),
    "project without calibration": (
        _file(
            "s.json",
            json.dumps(
                {
                    "axesColl": [{"name": "XY", "type": "XYAxes"}],
                    "datasetColl": [{"name": "a", "axesName": "XY", "data": [{"x": 1, "y": 2}] * 3}],
                }
            ),
        ),
        ["s.json", "without calibrated values", "calibrate the axes"],
    ),
    "project calibrated in other units": (
        _project(y=(0, 5000)),
        ["wpd.json", "calibrated from 0 to 5000", "0 to 20 mm", "axes.y"],
    ),
    "too few points": (_points(lambda p: p[:2]), ["'experiment'", "2 points", "at least 3"]),
    "metres called millimetres": (_fill(y=("m", [0, 20])), ["settlement", "m is outside", "axes.y: unit"]),
    "off the axis": (_points(lambda p: _row(p, 3, 1, 25.0)), ["y = 25", "off the axis, 0 to 20 mm", "axes.y.range"]),
    "beyond the last cycle": (_points(lambda p: _row(p, 9, 0, 1100.0)), ["x = 1100", "off the axis, 0 to 1000"]),
    "cycle twice": (_points(lambda p: _row(p, 4, 0, 10.0)), ["two points at cycle 10", "delete one of them"]),
    "log axis to zero": (_fill(x=("-", [0, 1000], "log")), ["axes.x.range", "cannot be logarithmic"]),
    "log in the sidecar, linear in the project": (
        lambda source: _project()(source) | {"x": ("-", [1, 1000], "log")},
        ["axes.x.scale", "the project has it linear"],
    ),
    "negative settlement": (
        lambda source: _points(lambda p: p * [1, -0.1])(source) | {"y": ("mm", [0, -2])},
        ["settlement is negative", "axes.y.reversed = true"],
    ),
    "empty axis": (_fill(y=("mm", [5, 5])), ["settlement.toml", "axes.y.range = [5, 5] is empty"]),
    "still pending": (_fill(status="pending"), ["settlement.toml", 'status = "pending"', 'status = "digitised"']),
    "open question": (
        _fill(**{'digitised_by = "A. Tester"': 'digitised_by = "?"'}),
        ["digitised_by", '"?" is still open'],
    ),
    "several open questions": (
        _fill(y=("?", [0, 20]), **{'digitised_by = "A. Tester"': 'digitised_by = "?"', "2026-03-01": '"?"'}),
        ["digitised_by", "date", "axes.y.unit", '"?" is still open'],
    ),
    "unit not filled in": (_fill(y=("?", [0, 20])), ["axes.y.unit", '"?" is still open']),
    "range not filled in": (_fill(**{"range    = [0, 20]": 'range    = "?"'}), ["axes.y.range", '"?" is still open']),
    "no error stated": (_fill(error=(0, "mm")), ["error.value = 0 is refused"]),
    "error in another unit": (_fill(error=(1, "%")), ["settlement.toml: error.unit = %", "settlement"]),
    "unknown status": (_fill(status="guessed"), ["status", '"guessed" is refused', "pending, digitised, transcribed"]),
    "unknown unit": (_fill(y=("inch", [0, 20])), ["axes.y.unit", '"inch" is refused', "mm, cm, m"]),
    "cycles in millimetres": (_fill(x=("mm", [0, 1000])), ["axes.x.unit", '"mm" is refused', "- (cycles, shares), s"]),
    "cycles called seconds": (_fill(x=("s", [0, 1000])), ["1000 s are 20000 cycles", 'axes.x.unit = "-"']),
    "millimetres typed as metres": (
        _points(lambda p: p * [1, 1e-3]),
        ["y spans", "next to nothing of its axis, 0 to 20 mm", "axes.y: unit"],
    ),
    "an error as large as the curve": (
        _fill(error=(30, "mm")),
        ["settlement.toml: error.value = 30 mm", "more than half of the axis, 0 to 20 mm"],
    ),
    "an American in a hurry": (
        _fill(**{"digitised_by = ": "digitized_by = "}),
        ["'digitised_by' is a required property", "rename 'digitized_by'"],
    ),
    "a date in words": (_fill(**{"2026-03-01": '"1 March 2026"'}), ["date = ", 'write it as "2026-03-01"']),
    "unknown key": (_fill(**{"kind ": 'remark = "x"\nkind '}), ["the file", "'remark'", "allowed: source"]),
    "no licence": (_fill(**{"licence ": "#licence "}), ["the file", "'licence' is a required property"]),
    "axes that make no curve": (
        _fill(**{'quantity = "cycle"': 'quantity = "porosity"', 'unit     = "-"': 'unit     = "%"'}),
        ["axes", "porosity and settlement make no curve", "settlement with cycle"],
    ),
    "sphere for a settlement": (
        _fill(**{'dataset = "experiment"': 'dataset = "experiment", sphere = 1'}),
        ["'experiment' has sphere", "settlement has none"],
    ),
    "unknown scenario": (
        _fill(**{'dataset = "experiment"': 'dataset = "experiment", scenario = "linear"'}),
        ["scenario 'linear' is unknown", "scenarios.toml"],
    ),
    "curve twice": (
        _fill(**{'  { dataset = "experiment" },': '  { dataset = "experiment" },\n  { dataset = "experiment" },'}),
        ["curves", "'experiment' occurs twice"],
    ),
    "source without citation": (
        _fill(**{'source  = "indraratna2013"': 'source  = "indraratna2012"'}),
        ["source = 'indraratna2012' is not in reference.bib"],
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_curve_is_refused_in_one_line_with_the_remedy(case, folder):
    make, words = BAD[case]
    source = folder / "indraratna2013"
    options = {"files": ["s.csv"]} | make(source)
    fill(source / "settlement.toml", **options)
    references = load_references(folder)
    assert len(references.problems) == 1, references.problems
    message = references.problems[0]
    assert message.startswith("indraratna2013/") and "\n" not in message and len(message) < 400
    for word in words:
        assert word in message
    assert references.curves.empty


def test_a_profile_without_its_cycle_is_refused(folder):
    sidecar = folder / "chen2015" / "lateral_displacement.toml"
    sidecar.write_text(sidecar.read_text().replace(", cycle = 100 ", " "))
    assert "'simulation after 100' needs cycle; add it" in load_references(folder).problems[0]


def test_a_dropped_file_that_no_sidecar_names_is_not_overlooked(folder):
    single_csv(folder / "chen2015" / "settlement.csv", settlement_points())
    (problem,) = load_references(folder).problems
    assert problem.startswith("chen2015/settlement.csv: is named by no sidecar; add it to `files`")


@pytest.mark.parametrize(
    "old, new, words",
    [
        ("coefficient = 0.43", "coefficient = 43", "log-hettler: form = logarithm, coefficient = 43 is refused"),
        ('form        = "power"', 'form        = "root"', "power-selig-waters: form = root"),
        ('= ["hettler1984"]', '= ["hettler"]', "log-hettler: source 'hettler' is not in reference.bib"),
        ("coefficient = 0.43", "", "each [[law]] has id, label"),
    ],
)
def test_a_bad_settlement_law_is_refused_in_one_line(folder, capsys, old, new, words):
    path = folder / "settlement_laws" / "laws.toml"
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    assert check.main(["--folder", str(folder)]) == 1
    error = capsys.readouterr().err
    assert words in error and error.count("\n") == 1


def test_calibration_of_a_project_file_is_read(tmp_path):
    project_json(tmp_path / "wpd.json", {"a": settlement_points()}, x=(0, 1000), y=(20, 0))
    (dataset,) = webplotdigitizer.read(tmp_path / "wpd.json")
    assert dataset.calibration == ((0, 1000), (0, 20))


def test_what_the_paper_reports_is_typed_in_one_file():
    clumps = {str(n) for n in (reported().clumps, reported().clumps_nonlinear, reported().clumps_lost)}
    typed = re.compile(rf"(?<![\d.])(?:{'|'.join(clumps)}|50 (?:to|and) 460|460e3)(?![\d.])")
    files = [path for end in ("py", "txt", "html") for path in (ROOT / "analysis").rglob(f"*.{end}")]
    assert [str(path) for path in files if typed.search(path.read_text())] == []


@pytest.mark.parametrize(
    "old, new, words",
    [
        ("[porosity]", "[voids]", "porosity is missing"),
        ("value  = 4583", "value  = -4583", "clumps: allowed: a value above 0"),
        ("value  = 4583", 'value  = "many"', "clumps: allowed: a value above 0"),
        ("[clumps]", "[clumps", "is not valid TOML"),
    ],
)
def test_damaged_numbers_of_the_paper_are_refused_in_one_line(folder, capsys, old, new, words):
    path = folder / "talebiahooie2021" / "reported.toml"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    assert check.main(["--folder", str(folder)]) == 1
    error = capsys.readouterr().err
    assert error.startswith("ERROR: reported.toml: ") and words in error and error.count("\n") == 1
