"""Readers on damaged files: nothing raises, what is wrong is said in one line, everything else stays usable."""

import codecs
import doctest
import json
import os
import random
import shutil

import numpy as np
import pandas as pd
import pytest
from synthetic import write_run

from analysis import load_runs
from analysis.comparison import quantities
from analysis.formats import file_columns
from analysis.formats.quantities import QUANTITIES
from analysis.normalised import readers
from analysis.normalised.readers import Run, read_table

CASES = 240
TABLES = {
    "cycles.csv": file_columns.CYCLES,
    "history.csv": file_columns.HISTORY,
    "microstructure.csv": file_columns.MICROSTRUCTURE,
}
FILES = (
    *TABLES,
    "run.json",
    "scenario.json",
    "stages.json",
    "bed_before.csv",
    "bed_after.csv",
    "raw/contacts_cycle_000005.csv",
)


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


def truncate(content, generator):
    return content[: generator.randrange(len(content) + 1)]


def flip_bytes(content, generator):
    damaged = bytearray(content)
    for _ in range(generator.choice((1, 3, 30))):
        damaged[generator.randrange(len(damaged))] = generator.randrange(256)
    return bytes(damaged)


def insert_garbage(content, generator):
    at = generator.randrange(len(content) + 1)
    return (
        content[:at]
        + generator.choice((b"\0" * 50, b",,,", b"\n\n\n", b'"', b"1e999", b"\xff\xfe", b"#", "µ".encode("latin-1")))
        + content[at:]
    )


def drop_column(content, generator):
    rows = [line.split(b",") for line in content.split(b"\n")]
    column = generator.randrange(len(rows[0]))
    return b"\n".join(b",".join(row[:column] + row[column + 1 :]) for row in rows)


def drop_header(content, generator):
    return content.partition(b"\n")[2]


def repeat_lines(content, generator):
    lines = content.splitlines(keepends=True)
    at = generator.randrange(len(lines))
    return b"".join(lines[:at] + lines[max(0, at - 3) :])


def shuffle_lines(content, generator):
    head, *rest = content.splitlines(keepends=True)
    generator.shuffle(rest)
    return head + b"".join(rest)


def absurd_value(content, generator):
    lines = [line.split(b",") for line in content.splitlines()]
    row = generator.choice(lines[1:] or lines)
    row[generator.randrange(len(row))] = generator.choice(
        (b"1e300", b"-1e300", b"inf", b"nan", b"-9999", b"abc", b"", b"0x10", b"1_0", b"true")
    )
    return b"\n".join(map(b",".join, lines)) + b"\n"


def other_encoding(content, generator):
    text = content.decode("latin-1")
    return generator.choice(
        (
            text.encode("utf-16"),
            codecs.BOM_UTF8 + content,
            content.replace(b"\n", b"\r\n"),
            text.encode("utf-32"),
            content.replace(b"\n", b"\r"),
        )
    )


def empty(content, generator):
    return generator.choice((b"", b"\n", b"   ", b"null", b"[]", b'{"seed": []}', b"[" * 5000))


def other_types(content, generator):
    try:
        body = json.loads(content)
    except ValueError:
        return content
    for _ in range(3):
        key = generator.choice(sorted(body))
        body[key] = generator.choice((None, [], {}, "x", -1, 1e300, True, {"a": [1]}))
    return json.dumps(body).encode()


DAMAGES = (
    truncate,
    flip_bytes,
    insert_garbage,
    drop_column,
    drop_header,
    repeat_lines,
    shuffle_lines,
    absurd_value,
    other_encoding,
    empty,
    other_types,
)


@pytest.mark.parametrize("block", range(8))
def test_random_damage(original, tmp_path, block):
    """Each case damages one or two files of a run in one or two ways; the last of a block is read with an intact run
    beside it."""
    intact = load_runs(original, code="yade", quiet=True)[0]
    results = shutil.copytree(original, tmp_path / "results")
    folder = cycles_of(results).parent
    for case in range(CASES // 8):
        for name in FILES:
            shutil.copy(original / "demo" / "linear-mu0.8" / "liggghts" / name, folder / name)
        generator = random.Random(1000 * block + case)
        damaged = generator.sample(FILES, generator.choice((1, 1, 2)))
        for name in damaged:
            content = (folder / name).read_bytes()
            for damage in generator.sample(DAMAGES, generator.choice((1, 1, 2))):
                content = damage(content, generator) if content else content
            (folder / name).write_bytes(content)
        check_usable(Run(folder, results, quiet=True), f"case {block}/{case}: {damaged}")
    runs = load_runs(results, quiet=True)
    assert len(runs) == 2 and list(runs.cycles)[:4] == ["profile", "scenario", "code", "seed"]
    good = [run for run in runs if run.id.endswith("/yade")][0]
    assert good.problems == [] and good.cycles.equals(intact.cycles) and good.history.equals(intact.history)


def check_usable(run, case):
    for name, columns in TABLES.items():
        frame = getattr(run, name.removesuffix(".csv"))
        assert list(frame) == list(columns), case
        assert all(kind.kind in "if" for kind in frame.dtypes), case
        for column in columns:
            values = frame[column].to_numpy()
            low, high = QUANTITIES[column].low, QUANTITIES[column].high
            assert (np.isnan(values) | ((values >= low) & (values <= high))).all(), (case, column)
        assert (np.diff(frame["cycle"]) > 0).all(), case
    assert isinstance(run.seed, int) and isinstance(run.code, str), case
    for label in ("before", "after", 5):
        bed = run.bed(label)
        assert bed is None or np.isfinite(bed.to_numpy(dtype=float)).all(), case
    contacts = run.contacts(5)
    assert contacts is None or list(contacts) == list(file_columns.CONTACTS), case
    if run.scenario is not None:
        assert run.scenario["geometry.box_length"] > 0, case
    summary = quantities.summary(run, [1, 5])
    assert ((summary["missing"] == "") == summary["value"].notna()).all(), case
    assert all("\n" not in line and line.startswith("demo/") and len(line) < 500 for line in run.problems), (
        case,
        run.problems,
    )


# ------------------------------------------------------------------ each kind of damage and what is said


def damaged(results, name, change):
    path = cycles_of(results).parent / name
    path.write_bytes(change(path.read_bytes()))
    return load_one(results)


def test_torn_last_line(results):
    run = damaged(results, "cycles.csv", lambda content: content[:-25])
    assert run.problems == ["demo/linear-mu0.8/liggghts/cycles.csv: ends in mid-line: the last line is dropped"]
    assert run.cycles["cycle"].tolist() == [1, 2, 3, 4, 5]


def test_number_torn_without_trace(results):
    """410 clumps cut to 41: without its newline a line that looks whole is not believed."""
    run = damaged(results, "cycles.csv", lambda content: content[:-2])
    assert len(run.cycles) == 5 and len(run.problems) == 1


def test_missing_column(results):
    run = damaged(results, "cycles.csv", lambda content: content.replace(b"lateral_3_m", b"lateral"))
    assert run.problems == ["demo/linear-mu0.8/liggghts/cycles.csv: column lateral_3_m missing: nan"]
    assert run.cycles["lateral_3_m"].isna().all() and run.cycles["lateral_4_m"].notna().all()


def test_columns_in_another_order(results, original):
    path = cycles_of(results)
    table = pd.read_csv(path)
    table[list(reversed(file_columns.CYCLES))].to_csv(path, index=False)
    run = load_one(results)
    assert run.problems == [] and run.cycles.equals(load_one(original).cycles)


@pytest.mark.parametrize(
    "content, said", [(b"", "is empty"), (b"a,b\n1,2\n", "has no column cycle: nothing of it is used")]
)
def test_nothing_in_it(results, content, said):
    run = damaged(results, "cycles.csv", lambda _: content)
    assert run.problems == [f"demo/linear-mu0.8/liggghts/cycles.csv: {said}"]
    assert len(run.cycles) == 0 and list(run.cycles) == list(file_columns.CYCLES)
    assert len(run.microstructure) == 7


def test_missing_file(results):
    cycles_of(results).unlink()
    assert load_one(results).problems == ["demo/linear-mu0.8/liggghts/cycles.csv: is missing"]


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
        (b'{"preload": {"settlement_m": 1e300}}', "preload: settlement_m cannot be: not used"),
        (b'{"preload": 3}', "is damaged (is no table of stages); nothing of it is used"),
        (
            b'{"preload": {"settlem',
            "is damaged (Unterminated string starting at: line 1 column 14 (char 13)); nothing of it is used",
        ),
    ],
)
def test_damaged_stages_cost_themselves_alone(results, content, said):
    run = damaged(results, "stages.json", lambda _: content)
    assert run.problems == [f"demo/linear-mu0.8/liggghts/stages.json: {said}"]
    assert not run.stages.get("preload") and len(run.cycles) == 6


def test_wrong_encodings(results, original):
    expected = load_one(original).cycles
    run = damaged(results, "cycles.csv", lambda content: content.decode().encode("utf-16"))
    assert run.problems[0].endswith("is UTF-16, not UTF-8") and run.cycles.equals(expected)
    shutil.copy(cycles_of(original), cycles_of(results))
    run = damaged(results, "cycles.csv", lambda content: content.replace(b"clumps", "clumps °".encode("latin-1")))
    assert run.problems[0].endswith("is not UTF-8: read as Latin-1") and run.cycles["settlement_m"].equals(
        expected["settlement_m"]
    )


def test_absurd_and_unreadable_values(results):
    frame = pd.read_csv(cycles_of(results), dtype=str)
    frame.loc[1, "settlement_m"], frame.loc[3, "porosity_2"], frame.loc[4, "time_s"] = "1e300", "1.7", "soon"
    frame.to_csv(cycles_of(results), index=False)
    run = load_one(results)
    assert [line.partition(": ")[2] for line in run.problems] == [
        "1 value of time_s no number: nan, the first in line 6",
        "1 value of settlement_m outside -10 to 10: nan, the first is 1e+300 in line 3",
        "1 value of porosity_2 outside 0 to 1: nan, the first is 1.7 in line 5",
    ]
    assert run.cycles.isna().sum().sum() == 3 and len(run.cycles) == 6


def test_cycles_that_do_not_rise(results):
    lines = cycles_of(results).read_text().splitlines(keepends=True)
    cycles_of(results).write_text("".join(lines[:4] + lines[2:]))
    run = load_one(results)
    assert run.cycles["cycle"].tolist() == [1, 2, 3, 4, 5, 6]
    assert len(run.problems) == 1 and "2 rows whose cycle does not rise dropped" in run.problems[0]


def test_lines_of_another_width(results):
    run = damaged(results, "cycles.csv", lambda content: content.replace(b"\n3,", b"\n3,1,2,"))
    assert run.cycles["cycle"].tolist() == [1, 2, 4, 5, 6]
    assert "1 line with another number of values dropped, the first is line 4" in run.problems[0]


def test_damaged_scenario_is_replaced(results):
    run = damaged(results, "scenario.json", lambda content: content.replace(b'"value": 0.8,', b'"value": -0.8,', 1))
    assert "scenario.json: is damaged (geometry.box_length" in run.problems[0]
    assert run.scenario["geometry.box_length"] == 0.8 and run.scenario.hash == run.info["scenario_hash"]


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
    """Committed runs have no scenario.json: the scenario file of today, checked by the hash."""
    folder = cycles_of(results).parent
    (folder / "scenario.json").unlink()
    run = load_one(results)
    assert run.problems == [] and run.scenario.hash == run.info["scenario_hash"]
    info = json.loads((folder / "run.json").read_text()) | {"scenario_hash": "0123456789ab"}
    (folder / "run.json").write_text(json.dumps(info))
    run = load_one(results)
    assert run.scenario is not None and "0123456789ab is not that of today's scenario file" in run.problems[0]


def test_run_without_run_json(results):
    (cycles_of(results).parent / "run.json").unlink()
    run = load_one(results)
    assert run.identity == {"profile": "demo", "scenario": "linear-mu0.8", "code": "liggghts", "seed": 1}
    assert len(run.problems) == 1 and len(run.cycles) == 6


def test_wrong_types_in_run_json(results):
    run = damaged(
        results,
        "run.json",
        lambda content: content.replace(b'"seed": 1', b'"seed": "one"').replace(b'"ranks": 1', b'"ranks": true'),
    )
    assert run.problems == ["demo/linear-mu0.8/liggghts/run.json: seed, ranks of the wrong type: not used"]
    assert run.seed == 1 and "ranks" not in run.info and run.info["state"] == "finished"


def test_problems_are_printed_once(results, capsys):
    cycles_of(results).write_bytes(b"")
    run = load_one(results, capsys)
    _ = run.cycles, run.cycles, run.scenario
    assert capsys.readouterr().err == "warning: demo/linear-mu0.8/liggghts/cycles.csv: is empty\n"


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


def test_large_clean_table_reads_the_same_both_ways(original):
    """The quick way for undamaged files and the careful way give the same values."""
    path = cycles_of(original)
    quick, none = read_table(path, file_columns.CYCLES)
    damaged_copy = path.with_name("copy.csv")
    damaged_copy.write_bytes(path.read_bytes() + b"7,torn")
    careful, one = read_table(damaged_copy, file_columns.CYCLES)
    damaged_copy.unlink()
    assert none == [] and len(one) == 1 and quick.equals(careful)


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
