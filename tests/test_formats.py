"""Formats: every column is a known quantity, both engines write the columns declared, files are read strictly."""

import ast
import errno
import gzip
import json
import os
import re

import pytest

from analysis.files import KEPT_RUNS, ROOT
from analysis.formats import bed_file, file_columns, json_file, numbers, quantities, table_file, toml_file
from analysis.formats.errors import InputError
from analysis.formats.growing_csv import GrowingCsv, append_text
from analysis.formats.run_record import RunRecord

FORMATS = {name: value for name, value in vars(file_columns).items() if name.isupper() and isinstance(value, tuple)}
FORMATS.pop("CODES")


# ------------------------------------------------------------------ quantities and columns


@pytest.mark.parametrize("name", FORMATS)
def test_every_column_is_a_quantity_of_the_registry(name):
    columns = [c for c in FORMATS[name] if c != "stage"]
    assert len(set(columns)) == len(columns) and set(columns) <= set(quantities.QUANTITIES)


def test_a_quantitys_name_ends_in_its_unit():
    endings = {"m": "_m", "Pa": "_Pa", "Pa2": "_Pa2", "s": "_s", "rad": "_rad", "N": "_N", "J": "_J", "m3": "_m3"}
    endings |= {"m/s2": "_m_s2", "N/m": "_N_m"}
    for q in quantities.QUANTITIES.values():
        if not q.name.startswith("exponential_"):
            assert q.name.endswith(endings.get(q.unit, "")), q.name
            longest = max((e for e in endings.values() if q.name.endswith(e)), key=len, default="")
            assert q.unit == "m per cycle" or longest == endings.get(q.unit, ""), q.name
        assert q.low < q.high and q.label and q.meaning and q.heading.endswith(q.shown_unit), q.name


def test_headings_and_factors_follow_from_the_unit():
    q = quantities.QUANTITIES["lateral_3_m"]
    assert (q.heading, q.factor, q.accepts(0.004), q.accepts(11)) == (
        "lateral displacement of plate 3, mm",
        1e3,
        True,
        False,
    )
    assert quantities.QUANTITIES["overlap_mean_m"].heading == "mean overlap, µm"
    assert quantities.QUANTITIES["porosity_2"].heading == "porosity, sphere 2 (middle)"
    assert not q.accepts(float("nan")) and quantities.QUANTITIES["sliding_share"].accepts(float("nan"))


def cpp_headers():
    """The literal headers in the host's sources, with its row of plates written out."""
    text = "".join(path.read_text() for path in sorted((ROOT / "liggghts" / "src").glob("*.cpp")))
    joined = re.sub(r'"\s*\n?\s*"', "", text)  # adjacent literals are one
    literals = re.findall(r'"((?:stage|step|id|clump_1|,plate_%\w+_\w+),[\w,%]+)(?:\\n)?"', joined)
    loading = [x for x in literals if x.startswith("step,")]
    plates = [x for x in literals if x.startswith(",plate_")]
    others = [x for x in literals if not x.startswith(("step,", ",plate_"))]
    rows = "".join(re.sub(r"%\w?u", str(k), plates[0]) for k in file_columns.PLATES)
    return {*others, *(x + rows for x in loading)}


def test_liggghts_writes_the_columns_declared():
    wanted = FORMATS.keys() - {
        "CYCLES",
        "HARMONICS",
        "HISTORY",
        "LOOPS",
        "MICROSTRUCTURE",
        "PLATE_STRESSES",
        "BOND_COUNTS",
        "BONDS_BROKEN",
        "UNLOAD",
    }
    assert cpp_headers() == {",".join(FORMATS[name]) for name in wanted}


def test_yade_writes_no_header_of_its_own():
    """YADE's scripts take their headers from the formats: no literal of them names two columns of one file."""
    for path in (ROOT / "yade").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and "\n" not in node.value.strip():
                names = [c for c in node.value.split(",") if c in quantities.QUANTITIES]
                assert len(names) < 2, (path.name, node.value)


# ------------------------------------------------------------------ growing files


@pytest.fixture
def growing(tmp_path):
    table = GrowingCsv(tmp_path / "cyclic.csv", ("step", "time_s"))
    table.start()
    return table


def test_rows_are_read_once_and_only_when_complete(growing):
    growing.append([(1, 0.5), (2, float("nan"))])
    assert growing.new_rows() == [{"step": "1", "time_s": "0.5"}, {"step": "2", "time_s": ""}]
    append_text(growing.path, "3,0.")
    assert growing.new_rows() == []
    append_text(growing.path, "7\n")
    assert growing.new_rows() == [{"step": "3", "time_s": "0.7"}]


def test_cut_keeps_what_is_wanted_and_drops_what_is_torn(growing):
    growing.append([(1, 0.5), (2, 1.0), (3, 1.5)])
    append_text(growing.path, "\0\0\n4,2")
    growing.cut(lambda row: int(row["step"]) != 2)
    assert growing.path.read_text() == "step,time_s\n1,0.5\n3,1.5\n"


@pytest.mark.parametrize("room", [0, 1, 7, 9])
def test_a_full_disk_leaves_whole_rows_only(growing, monkeypatch, room):
    """A disk that takes `room` bytes of a row and then no more: `write` is short first, and raises after."""
    growing.append([(1, 0.5)])
    before = growing.path.read_bytes()

    class Full:
        def __init__(self, file):
            self.file, self.left = file, room

        def __getattr__(self, name):
            return getattr(self.file, name)

        def __enter__(self):
            return self

        def __exit__(self, *_):
            self.file.close()

        def write(self, data):
            if not self.left:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            taken, self.left = data[: self.left], self.left - len(data[: self.left])
            return self.file.write(taken)

    monkeypatch.setattr(
        "builtins.open", lambda *a, real=open, **k: Full(real(*a, **k)) if a[1] == "ab" else real(*a, **k)
    )
    with pytest.raises(OSError):
        growing.append([(2, 1.0), (3, 1.5)])
    monkeypatch.undo()
    assert growing.path.read_bytes() == before
    growing.append([(2, 1.0)])
    assert growing.path.read_bytes() == before + b"2,1\n"


# ------------------------------------------------------------------ tables


HEADER = ",".join(file_columns.CYCLES)
ROW = ",0.05,0.001,0.002,0,0,0,0,0,0.4,0.4,0.4,50000,460000,2,380\n"


def table(tmp_path, content):
    path = tmp_path / "cycles.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def test_a_row_counts_when_it_is_complete_and_in_order(tmp_path):
    path = table(tmp_path, f"{HEADER}\n1{ROW}2{ROW}3{ROW}"[:-1])  # the last without its newline
    assert table_file.last_cycle(path, file_columns.CYCLES) == 2 and table_file.is_torn(path)
    assert table_file.last_cycle(tmp_path / "nothing.csv", file_columns.CYCLES) == 0


@pytest.mark.parametrize(
    "content, said",
    [
        ("", "cycles.csv: is empty"),
        ("\ufeff" + HEADER + "\n1" + ROW, "cycles.csv: line 1 holds bytes that are no text"),
        (f"{HEADER}\n1{ROW}".replace(",", ";"), "cycles.csv: line 1: column cycle is missing"),
        (HEADER.replace("clumps", "clump") + "\n", "cycles.csv: line 1: column clumps is missing"),
        (f"{HEADER}\n1{ROW}garbage\n2{ROW}", "cycles.csv: line 3 has 1 values instead of 16"),
        (f"{HEADER}\n1{ROW}2{ROW}".replace(",50000,", ",,", 1), 'cycles.csv: line 2: sleeper_stress_min_Pa = "" is'),
        (f"{HEADER}\n1{ROW}2{ROW}".replace("460000", "soon", 1), 'cycles.csv: line 2: sleeper_stress_max_Pa = "soon"'),
        (f"{HEADER}\n1{ROW}2{ROW}".replace("0.001", "1e300", 1), 'cycles.csv: line 2: settlement_m = "1e300"'),
        (f"{HEADER}\n1{ROW}2{ROW}".replace("380", "1_0", 1), 'cycles.csv: line 2: clumps = "1_0"'),
        (f"{HEADER}\n1{ROW}2{ROW}2{ROW}", "cycles.csv: line 4 is cycle 2 after cycle 2"),
        (f"{HEADER}\n1{ROW}3{ROW}", "cycles.csv: line 3 is cycle 3 after cycle 1"),
        (f"{HEADER}\n4{ROW}", "cycles.csv: line 2 is cycle 4 at the start"),
        (f"{HEADER}\n1{ROW}2.5{ROW}", "cycles.csv: line 3 is cycle 2.5 after cycle 1"),
    ],
)
def test_a_damaged_table_is_refused_in_one_line(tmp_path, content, said):
    with pytest.raises(InputError) as caught:
        table_file.last_cycle(table(tmp_path, content), file_columns.CYCLES)
    assert (
        str(caught.value).startswith(said) and "\n" not in str(caught.value) and "restore the file" in str(caught.value)
    )


# ------------------------------------------------------------------ beds


BED = ",".join(file_columns.BED)


def bed(tmp_path, *rows):
    path = tmp_path / "bed.csv"
    path.write_text("\n".join([BED, *rows]) + "\n")
    return path


def test_a_bed_reads_back_as_it_was_written_plain_or_packed(tmp_path):
    rows = [(2, 0.1, 1 / 3, 0.3, 1.0, 0.0, 0.0, 0.0), (1, 0.2, 0.1, 1e-300, 0.6, 0.0, 0.8, 0.0)]
    bed_file.write(tmp_path / "bed.csv", rows)
    assert [pose.row for pose in bed_file.read(tmp_path / "bed.csv")] == rows
    with gzip.open(tmp_path / "bed.csv.gz", "wb") as packed:
        packed.write((tmp_path / "bed.csv").read_bytes())
    assert bed_file.read(tmp_path / "bed.csv.gz") == bed_file.read(tmp_path / "bed.csv")


@pytest.mark.parametrize(
    "row, said",
    [
        ("1,0.1,0.1,0.1,1,0,0,0", "line 3 gives clump 1 again, as line 2 does"),
        ("1.5,0.1,0.1,0.1,1,0,0,0", "line 3 is no clump"),
        ("nan,0.1,0.1,0.1,1,0,0,0", "line 3 is no clump"),
        ("-2,0.1,0.1,0.1,1,0,0,0", "line 3 is no clump"),
        ("0,0.1,0.1,0.1,1,0,0,0", "line 3 is no clump"),
        ("99999999999,0.1,0.1,0.1,1,0,0,0", "line 3 is no clump"),
        ("9" * 5000 + ",0.1,0.1,0.1,1,0,0,0", "line 3 is no clump"),
        ("2,0.1,0.1,0.1,1,0,0", "line 3 is no clump"),
        ("2,0.1,nan,0.1,1,0,0,0", "line 3: y_m = NaN is refused"),
        ("2,0.1,1e300,0.1,1,0,0,0", "line 3: y_m = 1e+300 is refused"),
        ("2,0.1,0.1,0.1,1,0,0,0.01", "line 3 has a quaternion of length 1.00005; it must be 1 within 1e-06"),
        ("2,0.1,0.1,0.1,nan,0,0,0", "line 3 has a quaternion of length nan"),
    ],
)
def test_a_row_that_is_no_clump_is_refused_with_its_line(tmp_path, row, said):
    with pytest.raises(InputError) as caught:
        bed_file.read(bed(tmp_path, "1,0.1,0.1,0.1,1,0,0,0", row))
    assert str(caught.value).startswith("bed.csv: " + said) and len(str(caught.value)) < 200


# ------------------------------------------------------------------ json, toml, run.json


@pytest.mark.parametrize(
    "content", [b"[" * 100_000, b"{", b"[]", b'{"a": NaN}', b'{"a": 1e400}', b"\xff", b'{"a": ' + b"1" * 5000 + b"}"]
)
def test_damaged_json_is_one_line(tmp_path, content):
    (tmp_path / "a.json").write_bytes(content)
    with pytest.raises(InputError) as caught:
        json_file.read(tmp_path / "a.json")
    assert re.fullmatch(r"a\.json: is damaged \(.{1,300}\); restore the file or move it away", str(caught.value))


@pytest.mark.parametrize(
    "content",
    [
        "a = " + "[" * 5000 + "]" * 5000,
        ".".join("a" * 5000) + " = 1",
        "a = " + "1" * 5000,
        '"' + "x" * 5000 + '" = 1',
        "a = 1\na = 2",
        "\xff",
        "a = {" + "b = {" * 30 + "}" * 31,
    ],
)
def test_damaged_toml_is_one_line(tmp_path, content):
    (tmp_path / "a.toml").write_bytes(content.encode("latin-1"))
    with pytest.raises(InputError) as caught:
        toml_file.read(tmp_path / "a.toml")
    assert str(caught.value).startswith("a.toml: ") and "\n" not in str(caught.value) and len(str(caught.value)) < 400


def test_a_folder_or_a_dangling_link_is_one_line(tmp_path):
    (tmp_path / "a.toml").mkdir()
    (tmp_path / "b.toml").symlink_to(tmp_path / "nothing")
    for name in "ab":
        with pytest.raises(InputError, match=f"{name}.toml: cannot be read"):
            toml_file.read(tmp_path / f"{name}.toml")


KEPT = sorted(KEPT_RUNS.rglob("run.json"))


@pytest.mark.parametrize("path", KEPT, ids=lambda p: str(p.parent.relative_to(KEPT_RUNS)))
def test_kept_records_read_and_write_back_unchanged(path, tmp_path):
    RunRecord.read(path.parent).write(tmp_path)
    kept = json.loads(path.read_text())
    known = {key: value for key, value in kept.items() if value not in ("", []) or key not in ("variant", "parts")}
    assert json.loads((tmp_path / "run.json").read_text()) == known


@pytest.mark.parametrize(
    "changes, said",
    [
        ({"seed": "one"}, 'run.json: seed = "one" is refused; allowed: a whole number'),
        ({"seed": True}, "run.json: seed = true is refused"),
        ({"state": "<b>"}, 'run.json: state = "<b>" is refused; allowed: one of running'),
        ({"steps": {"packing": "x"}}, "run.json: steps"),
        ({"timing": []}, "run.json: timing = [] is refused"),
        ({"code": "pfc"}, 'run.json: code = "pfc" is refused'),
    ],
)
def test_a_record_of_another_type_is_refused(changes, said):
    body = json.loads(KEPT[0].read_text()) | changes
    with pytest.raises(InputError) as caught:
        RunRecord.from_dict(body)
    assert str(caught.value).startswith(said)


def test_a_record_of_another_version_names_the_key():
    body = json.loads(KEPT[0].read_text())
    RunRecord.from_dict(body | {"colour": "blue"})  # what a newer version added is kept
    del body["resumes"]
    with pytest.raises(InputError, match="run.json: resumes is missing: damaged, or of another version"):
        RunRecord.from_dict(body)


def test_numbers_for_files_and_for_people():
    assert [numbers.exact(v) for v in (1.0, 0.1, 1e22, float("nan"), 3)] == ["1", "0.1", "1e+22", "", "3"]
    assert numbers.short(1 / 3) == "0.333333333"
    assert [numbers.readable(v) for v in (1.23456, -1e-7, 12345, None, float("inf"))] == [
        "1.23",
        "−1·10⁻⁷",
        "12345",
        "–",
        "–",
    ]
