"""Readers of runs: what is damaged is refused in one line, everything else stays usable."""

import doctest
import json
import os
import random
import shutil

import numpy as np
import pandas as pd
import pytest
from damage import OF_TABLES, OF_TEXTS, damaged
from synthetic import write_run

from analysis import load_runs
from analysis.comparison import run_quantities
from analysis.formats import file_columns
from analysis.formats.errors import InputError
from analysis.normalised import readers
from analysis.normalised.frames import read_table

TABLES = {
    "cycles.csv": file_columns.CYCLES,
    "history.csv": file_columns.HISTORY,
    "microstructure.csv": file_columns.MICROSTRUCTURE,
}
CSV = (*TABLES, "bed_before.csv", "bed_after.csv", "raw/contacts_cycle_000005.csv")
JSON = ("run.json", "scenario.json", "stages.json")
MUTATIONS = 6
"""Of each file of a run."""


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    results = tmp_path_factory.mktemp("original") / "results"
    for code in ("liggghts", "yade"):
        write_run(results, "demo", "linear-mu0.8", code, cycles=6, rng=0 if code == "liggghts" else 1)
    return results


@pytest.fixture
def results(original, tmp_path):
    return shutil.copytree(original, tmp_path / "results")


def cycles_of(results):
    return results / "demo" / "linear-mu0.8" / "liggghts" / "cycles.csv"


def load_one(results, capsys=None):
    return load_runs(results, code="liggghts", quiet=capsys is None)[0]


# ------------------------------------------------------------------ random damage


@pytest.mark.parametrize("name", [*CSV, *JSON])
def test_a_file_that_is_damaged_costs_a_line_and_nothing_else(results, original, name):
    """No traceback, no absurd value, nothing deleted or written, the run beside it as if nothing were wrong.

    `test_fuzz.py` tries many more damages on each reader alone.
    """
    intact = load_runs(original, code="yade", quiet=True)[0]
    path = cycles_of(results).parent / name
    good = path.read_bytes()
    for case in range(MUTATIONS):
        path.write_bytes(damaged(good, random.Random(f"{name} {case}"), OF_TABLES if name in CSV else OF_TEXTS))
        before = sorted((p, p.stat().st_mtime_ns) for p in results.rglob("*"))
        runs = load_runs(results, quiet=True)
        assert len(runs) == 2 or name == "run.json", case
        *_, other = runs
        for run in runs:
            check_usable(run, f"{name} {case}")
        assert all("\n" not in line and line.startswith("demo/") and len(line) < 500 for line in runs.problems), case
        assert other.problems == [] and other.cycles.equals(intact.cycles) and other.history.equals(intact.history)
        assert before == sorted((p, p.stat().st_mtime_ns) for p in results.rglob("*")), case


def check_usable(run, case):
    for name, columns in TABLES.items():
        frame = getattr(run, name.removesuffix(".csv"))
        assert list(frame) == list(columns), case
        assert all(kind.kind in "if" for kind in frame.dtypes), case
    for label in ("before", "after", 5):
        bed = run.bed(label)
        assert bed is None or (np.isfinite(bed.to_numpy(dtype=float)).all() and bed["id"].is_unique), case
    contacts = run.contacts(5)
    assert contacts is None or list(contacts) == list(file_columns.CONTACTS), case
    if run.scenario is not None:
        assert run.scenario["geometry.box_length"] > 0, case
    summary = run_quantities.summary(run, [1, 5])
    assert ((summary["missing"] == "") == summary["value"].notna()).all(), case


# ------------------------------------------------------------------ each kind of damage and what is said


def after(results, name, change):
    path = cycles_of(results).parent / name
    path.write_bytes(change(path.read_bytes()))
    return load_runs(results, code="liggghts", quiet=True)


def one_problem(runs, name):
    (line,) = runs.problems
    assert line.startswith(f"demo/linear-mu0.8/liggghts/{name}: "), line
    return line.partition(": ")[2]


@pytest.mark.parametrize("lost", [2, 25])
def test_a_torn_last_row_does_not_count(results, lost):
    """Even where it looks whole, as 410 clumps cut to 41: without its newline a line is not there."""
    runs = after(results, "cycles.csv", lambda content: content[:-lost])
    assert one_problem(runs, "cycles.csv") == "ends in mid-line: that row does not count"
    assert runs[0].cycles["cycle"].tolist() == [1, 2, 3, 4, 5]


def test_columns_in_another_order_and_further_ones(results, original):
    path = cycles_of(results)
    table = pd.read_csv(path)
    table[list(reversed(file_columns.CYCLES))].assign(colour=1).to_csv(path, index=False)
    run = load_one(results)
    assert run.problems == [] and run.cycles.equals(load_one(original).cycles)


@pytest.mark.parametrize(
    "change, said",
    [
        (lambda c: b"", "is empty"),
        (lambda c: b"a,b\n1,2\n", "line 1: column cycle is missing"),
        (lambda c: c.replace(b"lateral_3_m", b"lateral"), "line 1: column lateral_3_m is missing"),
        (lambda c: c.replace(b"\n3,", b"\n3,1,2,"), "line 4 has 18 values instead of 16"),
        (lambda c: c.replace(b"\n3,", b"\n2,"), "line 4 is cycle 2 after cycle 2"),
        (lambda c: c.decode().encode("utf-16"), "line 1 holds bytes that are no text"),
        (lambda c: c.replace(b"\n3,", b"\n3,1e300,").replace(b",1e300,0.15,", b",1e300,"), 'line 4: time_s = "1e300"'),
    ],
)
def test_a_damaged_table_is_refused_whole(results, change, said):
    runs = after(results, "cycles.csv", change)
    what = one_problem(runs, "cycles.csv")
    assert what.startswith(said) and what.endswith("nothing of it is used")
    assert len(runs[0].cycles) == 0 and list(runs[0].cycles) == list(file_columns.CYCLES)
    assert len(runs[0].microstructure) == 7 and runs[0].stages["preload"]


def test_missing_file(results):
    cycles_of(results).unlink()
    assert "cycles.csv: cannot be read (No such file or directory)" in load_one(results).problems[0]


def test_run_that_is_still_packing_is_no_problem(results):
    folder = cycles_of(results).parent
    for name in ("cycles.csv", "microstructure.csv", "history.csv"):
        (folder / name).unlink()
    info = json.loads((folder / "run.json").read_text()) | {"state": "running", "stage": "packing"}
    (folder / "run.json").write_text(json.dumps(info))
    run = load_one(results)
    assert run.problems == [] and len(run.cycles) == len(run.history) == 0


@pytest.mark.parametrize(
    "content, said",
    [
        (b'{"preload": {"settlement_m": 1e300}}', "preload.settlement_m = 1e+300 is refused"),
        (b'{"preload": {"colour": 1}}', "preload.colour = 1 is refused; allowed: a known quantity"),
        (b'{"preload": 3}', "preload = 3 is refused"),
        (b'{"preload": {"settlem', "is damaged (Unterminated string"),
    ],
)
def test_damaged_stages_cost_themselves_alone(results, content, said):
    runs = after(results, "stages.json", lambda _: content)
    assert one_problem(runs, "stages.json").startswith(said)
    assert runs[0].stages == {} and len(runs[0].cycles) == 6


def test_a_damaged_scenario_is_not_replaced_by_another(results):
    runs = after(results, "scenario.json", lambda content: content.replace(b'"value": 0.8,', b'"value": -0.8,', 1))
    assert one_problem(runs, "scenario.json").startswith("geometry.box_length.value = -0.8 is refused")
    assert runs[0].scenario is None and len(runs[0].cycles) == 6


def test_run_that_is_older_than_a_parameter(results, original):
    path = cycles_of(results).parent / "scenario.json"
    body = json.loads(path.read_text())
    del body["parameters"]["limits.overlap_ratio"]
    body["parameters"]["clump.aspect"]["value"] = 1.5  # what the run had stays
    path.write_text(json.dumps(body))
    run = load_one(results)
    assert run.scenario["limits.overlap_ratio"] == load_one(original).scenario["limits.overlap_ratio"]
    assert run.scenario["clump.aspect"] == 1.5
    assert [line.partition(": ")[2] for line in run.problems] == [
        "is older than limits.overlap_ratio: taken from today's scenario file"
    ]


def test_scenario_of_a_committed_run(results):
    """Without scenario.json: the scenario file of today, checked by the hash."""
    folder = cycles_of(results).parent
    (folder / "scenario.json").unlink()
    run = load_one(results)
    assert run.problems == [] and run.scenario.hash == run.info["scenario_hash"]
    info = json.loads((folder / "run.json").read_text()) | {"scenario_hash": "0123456789ab"}
    (folder / "run.json").write_text(json.dumps(info))
    run = load_one(results)
    assert run.scenario is not None and "0123456789ab is not that of today's scenario file" in run.problems[0]


@pytest.mark.parametrize(
    "change, said",
    [
        (None, "is missing; copy the whole folder of the run"),
        (lambda c: c.replace(b'"seed": 1', b'"seed": "one"'), 'seed = "one" is refused; allowed: a whole number'),
        (lambda c: c[:50], "is damaged (Unterminated string"),
    ],
)
def test_a_run_whose_record_cannot_be_read_is_left_out(results, change, said):
    if change is None:
        (cycles_of(results).parent / "run.json").unlink()
    runs = load_runs(results, quiet=True) if change is None else after(results, "run.json", change)
    what = one_problem(runs, "run.json")
    assert what.startswith(said) and what.endswith("the run is left out")
    assert [run.code for run in load_runs(results, quiet=True)] == ["yade"]


def test_problems_are_printed_once(results, capsys):
    cycles_of(results).write_bytes(b"")
    run = load_one(results, capsys)
    _ = run.cycles, run.cycles, run.scenario
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("warning: demo/linear-mu0.8/liggghts/cycles.csv: is empty")


def test_last_error_of_a_crashed_log(results):
    run = load_one(results)
    assert run.last_error() is None
    (run.folder / "log" / "preload.log").write_bytes(b"ok\nERROR: preload: not at rest after 1 s\n")
    (run.folder / "log" / "cyclic.log").write_bytes(b"Step \xff\xfe 12\nERROR: cyclic: broke \xb0\nStep 17 0.1")
    assert run.last_error().startswith("ERROR: cyclic: broke")


# ------------------------------------------------------------------ finding and selecting runs


def test_seeds_filters_and_tidy_frames(tmp_path):
    for code, seed in (("yade", 1), ("liggghts", 1), ("liggghts", 7)):
        write_run(tmp_path, "demo", "nonlinear-en1.0", code, cycles=3, seed=seed, contacts=False)
    runs = load_runs(tmp_path, quiet=True)
    assert [run.id for run in runs] == [
        f"demo/nonlinear-en1.0/{name}" for name in ("liggghts", "liggghts-seed7", "yade")
    ]
    assert [run.seed for run in runs] == [1, 7, 1]
    assert len(load_runs(tmp_path, code="liggghts")) == 2 and len(load_runs(tmp_path, profile="full")) == 0
    assert len(runs.select(code="liggghts", seed=7)) == 1
    for name, columns in TABLES.items():
        frame = getattr(runs, name.removesuffix(".csv"))
        assert list(frame) == ["profile", "scenario", "code", "seed", *columns]
        assert frame.groupby(["code", "seed"]).ngroups == 3
    assert list(load_runs(tmp_path / "nothing").cycles) == ["profile", "scenario", "code", "seed", *file_columns.CYCLES]


def test_a_large_clean_table_reads_the_same_both_ways(original, tmp_path):
    """The quick way for undamaged files and the careful way give the same values."""
    path = cycles_of(original)
    torn = tmp_path / "cycles.csv"
    torn.write_bytes(path.read_bytes() + b"7,torn")
    assert read_table(torn, file_columns.CYCLES).equals(read_table(path, file_columns.CYCLES))
    torn.write_bytes(path.read_bytes() + b"7,torn\n")
    with pytest.raises(InputError, match="line 8 has 2 values"):
        read_table(torn, file_columns.CYCLES)


def test_the_library_example(tmp_path, monkeypatch):
    """The example in the docstring of load_runs, executed."""
    for code, law in (("liggghts", {}), ("yade", {"law": ("logarithm", {"a": 2e-3, "b": 1.2e-3})})):
        write_run(tmp_path / "results", "demo", "linear-mu0.8", code, cycles=20, **law)
    monkeypatch.chdir(tmp_path)
    tests = [t for t in doctest.DocTestFinder().find(readers.load_runs, "load_runs", globs={}) if t.examples]
    assert len(tests) == 1
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    said = []
    assert runner.run(tests[0], out=said.append).failed == 0, "".join(said)


def test_importing_analysis_needs_no_pandas():
    """YADE's Python imports analysis.scenarios and has no pandas."""
    import subprocess
    import sys

    code = (
        "import sys; sys.modules['pandas'] = sys.modules['scipy'] = None\n"
        "import analysis, analysis.scenarios.scenario, analysis.formats.file_columns\n"
        "try: analysis.load_runs\nexcept ImportError: print('late')\n"
        "try: analysis.nothing\nexcept AttributeError as e: print(e)"
    )
    result = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        cwd=os.path.dirname(os.path.dirname(os.path.abspath(__file__))),
    )
    assert result.stdout.splitlines() == ["late", "module 'analysis' has no attribute 'nothing'"], result.stderr
