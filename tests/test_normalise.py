"""The normaliser on raw output with known answers: values, kills at any moment, resumes, damaged raw files."""

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from synthetic import DEFAULT_LAW, LATERAL_PROFILE, STROKE_M, settlement, write_raw

from analysis import files
from analysis.formats import file_columns
from analysis.formats.growing_csv import CycleTable, RowsByStep
from analysis.normalised import microstructure, porosity
from analysis.normalised.normalise import NormaliseError, Normaliser
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario

CYCLES = 4
FEW_POINTS = 3000  # of the porosity's point set: enough for what is tested here
FILES = ("cycles.csv", "history.csv", "microstructure.csv", "stages.json", "bed_before.csv", "bed_after.csv")


@pytest.fixture(scope="module", autouse=True)
def few_points():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(porosity, "POINTS", FEW_POINTS)
        yield


@pytest.fixture(scope="module")
def engine_output(few_points, tmp_path_factory):
    """A run folder as an engine leaves it, and the normalised files that belong to it."""
    folder = write_raw(tmp_path_factory.mktemp("raw"), cycles=CYCLES)
    done = folder.parent / "done"
    shutil.copytree(folder, done)
    normalise_all(done)
    return folder, done


@pytest.fixture
def run(engine_output, tmp_path):
    return shutil.copytree(engine_output[0], tmp_path / "run")


@pytest.fixture
def expected(engine_output):
    return {name: (engine_output[1] / name).read_bytes() for name in FILES}


def scenario_of(folder):
    return Scenario.from_json((folder / "scenario.json").read_text())


def normalise_all(folder):
    normaliser = Normaliser(folder, scenario_of(folder))
    normaliser.before()
    for n in range(1, CYCLES + 1):
        normaliser.cycle(n)
    normaliser.finish()


def content(folder):
    return {name: (folder / name).read_bytes() for name in FILES if (folder / name).exists()}


# ------------------------------------------------------------------ values


def test_cycles_have_the_known_values(engine_output):
    folder = engine_output[1]
    s, table = scenario_of(folder), pd.read_csv(folder / "cycles.csv")
    assert ",".join(table) == (
        "cycle,time_s,settlement_m,settlement_peak_m,lateral_1_m,lateral_2_m,lateral_3_m,lateral_4_m,lateral_5_m,"
        "porosity_1,porosity_2,porosity_3,sleeper_stress_min_Pa,sleeper_stress_max_Pa,tracking_rms_Pa,clumps"
    )
    n = np.arange(1, CYCLES + 1)
    minimum = settlement(DEFAULT_LAW, n)
    assert list(table["cycle"]) == list(n)
    assert table["time_s"].to_numpy() == pytest.approx(n / s["loading.frequency"])
    assert table["settlement_m"].to_numpy() == pytest.approx(minimum, rel=1e-12)
    # The peak lies half a cycle earlier, where the synthetic settlement is half way between the minima.
    assert table["settlement_peak_m"].to_numpy() == pytest.approx((np.r_[0, minimum[:-1]] + minimum) / 2 + STROKE_M)
    for k in file_columns.PLATES:
        assert table[f"lateral_{k}_m"].to_numpy() == pytest.approx(
            5e-3 * LATERAL_PROFILE[k - 1] * minimum / minimum[-1]
        )
    assert table["sleeper_stress_max_Pa"].to_numpy() == pytest.approx(460e3)
    assert table["sleeper_stress_min_Pa"].to_numpy() == pytest.approx(50e3)
    assert table["tracking_rms_Pa"].to_numpy() == pytest.approx(2000)
    assert (table["clumps"] == len(pd.read_csv(folder / "bed_before.csv"))).all()


def test_history_is_zero_at_the_start_and_whole(engine_output):
    folder = engine_output[1]
    table = pd.read_csv(folder / "history.csv")
    rows = scenario_of(folder)["output.rows_per_cycle"]
    assert list(table) == list(file_columns.HISTORY)
    assert table["cycle"].to_numpy() == pytest.approx(np.arange(CYCLES * rows + 1) / rows)
    assert table.filter(regex="settlement|lateral").iloc[0].abs().max() == 0
    assert table["settlement_m"].iloc[rows] == pytest.approx(settlement(DEFAULT_LAW, [1])[0], rel=1e-8)
    assert table["sleeper_stress_Pa"].to_numpy() == pytest.approx(1.01 * table["sleeper_target_Pa"].to_numpy())
    assert (table["plate_target_Pa"] == 10e3).all() and table["plate_3_stress_Pa"].to_numpy() == pytest.approx(10030)


def test_microstructure_has_the_known_motion(engine_output):
    folder = engine_output[1]
    s, table = scenario_of(folder), pd.read_csv(folder / "microstructure.csv")
    before, lateral = pd.read_csv(folder / "bed_before.csv"), pd.read_csv(folder / "cycles.csv").filter(like="lateral")
    assert list(table["cycle"]) == list(range(CYCLES + 1))
    area = derived.apparatus(s).plate_area_m2
    assert table["bulge_volume_m3"].to_numpy() == pytest.approx(np.r_[0, lateral.sum(axis=1) * area], rel=1e-8)
    last = table.iloc[-1]
    assert last["downward_mean_m"] == pytest.approx(
        settlement(DEFAULT_LAW, [CYCLES])[0] * before["z_m"].mean() / 0.475, rel=1e-6
    )
    near = before["x_m"][before["x_m"] > 0.8 - 2 * 0.0185]
    assert last["shoulder_displacement_m"] == pytest.approx(5e-3 * near.mean() / 0.8, rel=1e-6)
    assert last["rotation_max_rad"] == 0 and last["sliding_share"] == pytest.approx(0.1)
    assert table["porosity_error"].max() <= 0.5 / math.sqrt(FEW_POINTS)
    assert table["normal_force_mean_N"].notna().tolist() == [
        True,
        True,
        False,
        False,
        True,
    ]  # cycles whose contacts are kept


def test_stages_hold_the_packed_and_the_preloaded_bed(engine_output):
    folder = engine_output[1]
    stages = json.loads((folder / "stages.json").read_text())
    structure = pd.read_csv(folder / "microstructure.csv").iloc[0]
    preload = pd.read_csv(folder / "raw" / "preload.csv").iloc[-1]
    assert stages["preload"]["settlement_m"] == preload["sleeper_displacement_m"]
    assert stages["preload"]["lateral_3_m"] == preload["plate_3_displacement_m"]
    for name in ("porosity_3", "coordination_number", "overlap_mean_m", "normal_force_mean_N"):
        assert stages["preload"][name] == pytest.approx(structure[name], rel=1e-8)
    assert stages["preload"]["clumps"] == len(pd.read_csv(folder / "bed_before.csv"))


def test_porosity_is_the_same_in_both_tables(engine_output):
    folder = engine_output[1]
    cycles, structure = pd.read_csv(folder / "cycles.csv"), pd.read_csv(folder / "microstructure.csv")
    for k in file_columns.SPHERES:
        other = structure[f"porosity_{k}"][1:].to_numpy()
        assert cycles[f"porosity_{k}"].to_numpy() == pytest.approx(other, rel=1e-8, nan_ok=True)
    assert cycles["porosity_3"].notna().all()  # the only sphere that fits into the demo bed


def test_beds_are_kept_as_asked(engine_output):
    kept = sorted(path.name for path in (engine_output[1] / "raw").glob("bed_cycle_*"))
    assert kept == ["bed_cycle_000001.csv", f"bed_cycle_{CYCLES:06d}.csv"]
    assert (engine_output[1] / "bed_after.csv").read_bytes() == (engine_output[1] / "raw" / kept[-1]).read_bytes()


# ------------------------------------------------------------------ repeated, killed, resumed


def test_repeated_is_identical(run, expected):
    normalise_all(run)
    assert content(run) == expected


class Killed(BaseException):
    pass


@pytest.fixture
def kill_at(monkeypatch):
    """Make the k-th change of a file stop half way, as a kill would."""
    append, aside, unlink = CycleTable.append, files.write_aside, type(Path()).unlink

    def arm(k):
        left = [k]

        def count_down():
            left[0] -= 1
            return left[0] == 0

        def killed_append(self, rows):
            rows = list(rows)
            if count_down():
                append(self, rows[: len(rows) // 2] if len(rows) > 1 else rows)
                size = self.path.stat().st_size
                with open(self.path, "r+b") as file:
                    file.truncate(size - 9)
                raise Killed
            append(self, rows)

        def killed_aside(path, text):
            if count_down():
                path.with_name(path.name + ".partial").write_text(text[: len(text) // 2])
                raise Killed
            aside(path, text)

        def killed_unlink(self, missing_ok=False):
            if count_down():
                raise Killed
            unlink(self, missing_ok=missing_ok)

        monkeypatch.setattr(CycleTable, "append", killed_append)
        monkeypatch.setattr(files, "write_aside", killed_aside)
        monkeypatch.setattr(type(Path()), "unlink", killed_unlink)
        return left

    yield arm


@pytest.mark.parametrize("back_to", [0, 1])
@pytest.mark.parametrize("k", range(1, 21))
def test_killed_anywhere_and_resumed_is_identical(run, expected, engine_output, kill_at, monkeypatch, k, back_to):
    left = kill_at(k)
    with pytest.raises(Killed):
        normalise_all(run)
    monkeypatch.undo()
    monkeypatch.setattr(porosity, "POINTS", FEW_POINTS)
    assert left[0] == 0
    normaliser = Normaliser(run, scenario_of(run))
    normaliser.rewind(back_to)
    done = pd.read_csv(run / "cycles.csv")["cycle"].max() if back_to else 0
    restore_beds(run, engine_output)
    for n in range(1 if done != done else int(done) + 1, CYCLES + 1):
        normaliser.cycle(n)
    normaliser.finish()
    assert content(run) == expected


def restore_beds(run, engine_output):
    """The engine goes on from its checkpoint and writes the beds of later cycles again."""
    for path in (engine_output[0] / "raw").glob("*_cycle_*.csv"):
        shutil.copy(path, run / "raw" / path.name)


@pytest.mark.parametrize("back_to", [0, 1, 2])
def test_rewound_and_done_again_is_identical(run, expected, engine_output, back_to):
    first = Normaliser(run, scenario_of(run))
    first.before()
    for n in (1, 2, 3):
        first.cycle(n)
    first.rewind(back_to)
    assert not list((run / "raw").glob("bed_cycle_00000[34].csv"))
    assert pd.read_csv(run / "cycles.csv")["cycle"].max() == back_to or back_to == 0
    restore_beds(run, engine_output)
    for n in range(back_to + 1, CYCLES + 1):
        first.cycle(n)
    first.finish()
    assert content(run) == expected


def test_history_that_was_deleted_is_rebuilt(run, expected, engine_output):
    first = Normaliser(run, scenario_of(run))
    first.before()
    for n in (1, 2):
        first.cycle(n)
    (run / "history.csv").unlink()
    second = Normaliser(run, scenario_of(run))
    second.rewind(2)
    restore_beds(run, engine_output)
    for n in (3, 4):
        second.cycle(n)
    second.finish()
    assert content(run) == expected


def test_steps_written_twice_count_as_last_written(run, expected):
    """An engine that resumed writes steps again; the first version of them is stale."""
    path = run / "raw" / "cyclic.csv"
    lines = path.read_text().splitlines(keepends=True)
    stale = [
        ",".join([line.split(",")[0], *["0.5"] * (len(file_columns.RAW_LOADING) - 1)]) + "\n" for line in lines[100:140]
    ]
    path.write_text("".join(lines[:100] + stale + ["123,torn"] + ["\n"] + lines[100:]))
    normalise_all(run)
    assert content(run) == expected


def test_another_preload_starts_the_tables_anew(run):
    normaliser = Normaliser(run, scenario_of(run))
    normaliser.before()
    normaliser.cycle(1)
    path = run / "raw" / "bed_preloaded.csv"
    *lines, last = path.read_text().splitlines(keepends=True)
    number, x, rest = last.split(",", 2)
    path.write_text("".join(lines) + f"{number},{float(x) + 1e-6!r},{rest}")
    normaliser.before()
    assert (run / "cycles.csv").read_text().count("\n") == 1
    assert pd.read_csv(run / "microstructure.csv")["cycle"].tolist() == [0]


def test_ready_only_when_everything_is_there(run):
    normaliser = Normaliser(run, scenario_of(run))
    normaliser.before()
    assert normaliser.ready(1) and normaliser.ready(CYCLES) and not normaliser.ready(CYCLES + 1)
    for name in ("contacts_cycle_000001.csv", "cyclic.csv", "state.csv", "bed_cycle_000001.csv"):
        path, aside = run / "raw" / name, run / "aside"
        path.rename(aside)
        fresh = Normaliser(run, scenario_of(run))
        assert not fresh.ready(1)
        aside.rename(path)
        assert fresh.ready(1)


def test_growing_file_is_read_in_pieces(tmp_path):
    path = tmp_path / "x.csv"
    table = RowsByStep(path, ("step", "v"))
    assert table.update() == {}
    text = "v,step\n1,0\n2,10\n3,20\n"
    for k in range(len(text) + 1):
        path.write_text(text[:k])
        table.update()
    assert table.rows == {n: {"step": str(n), "v": v} for n, v in ((0, "1"), (10, "2"), (20, "3"))}
    table.drop_until(10, but=0)
    assert sorted(table.rows) == [0, 20]
    path.write_text("step,v\n0,9\n")
    assert table.update() == {0: {"step": "0", "v": "9"}}  # the file was replaced by a shorter one


# ------------------------------------------------------------------ damage gives one clear line


@pytest.mark.parametrize(
    "name, old, new, said",
    [
        ("cyclic.csv", "sleeper_error_ms_Pa2", "error", "raw/cyclic.csv: column sleeper_error_ms_Pa2"),
        ("state.csv", "sliding_share", "slide", "raw/state.csv: column sliding_share"),
        ("bed_preloaded.csv", "qw", "q0", "raw/bed_preloaded.csv: line 1 is not id,x_m"),
        ("bed_cycle_000001.csv", "0.0185", "nan", "raw/bed_cycle_000001.csv"),
        ("cyclic.csv", "10009.999999999998", "nan", "no number"),
        ("contacts_cycle_000001.csv", "overlap_m", "gap", "raw/contacts_cycle_000001.csv: line 1: column overlap_m"),
    ],
)
def test_damaged_raw_output(run, name, old, new, said):
    path = run / "raw" / name
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(NormaliseError, match=said) as caught:
        normalise_all(run)
    assert "\n" not in str(caught.value)


def test_missing_rows_and_wrong_order(run):
    normaliser = Normaliser(run, scenario_of(run))
    normaliser.before()
    with pytest.raises(NormaliseError, match="cannot follow"):
        normaliser.cycle(2)
    path = run / "raw" / "cyclic.csv"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:50]))
    end = derived.time_grid(scenario_of(run)).steps_per_cycle
    with pytest.raises(NormaliseError, match=f"row of step {end} is missing"):
        Normaliser(run, scenario_of(run)).cycle(1)


def test_finish_before_anything_happened(tmp_path, run):
    empty = tmp_path / "empty"
    (empty / "raw").mkdir(parents=True)
    Normaliser(empty, scenario_of(run)).finish()
    assert [path.name for path in empty.iterdir()] == ["raw"]


# ------------------------------------------------------------------ microstructure against closed forms


def test_rotation_angle_is_the_same_for_q_and_minus_q():
    generator = np.random.default_rng(5)
    angle = np.r_[0, 1e-9, 1e-4, generator.uniform(0, math.pi, 40), math.pi]
    axis = generator.standard_normal((len(angle), 3))
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    turn = np.column_stack([np.cos(angle / 2), np.sin(angle / 2)[:, None] * axis])
    first = generator.standard_normal((len(angle), 4))
    first /= np.linalg.norm(first, axis=1)[:, None]
    w, v = (
        turn[:, :1] * first[:, :1] - np.sum(turn[:, 1:] * first[:, 1:], axis=1)[:, None],
        turn[:, :1] * first[:, 1:] + first[:, :1] * turn[:, 1:] + np.cross(turn[:, 1:], first[:, 1:]),
    )
    for sign in (1, -1):
        frames = [
            pd.DataFrame(np.column_stack([np.arange(len(q)), np.zeros((len(q), 3)), q]), columns=file_columns.BED)
            for q in (first, sign * np.column_stack([w, v]))
        ]
        assert microstructure.rotation_angles(*frames) == pytest.approx(angle, abs=1e-12, rel=1e-7)


def test_clumps_are_matched_by_id(run):
    box = derived.apparatus(scenario_of(run))
    before = pd.read_csv(run / "raw" / "bed_preloaded.csv")
    after = before.assign(z_m=before["z_m"] - 1e-3).drop(index=[3, 8]).sample(frac=1, random_state=1)
    measures = microstructure.motion_measures(before, after, box, 0.0185)
    assert measures["downward_mean_m"] == pytest.approx(1e-3)
    assert measures["rotation_max_rad"] == pytest.approx(0, abs=1e-12)


def test_contacts_of_a_cubic_lattice():
    """Clumps of two touching-distance spheres on a lattice: every contact counted once, walls included."""
    s = scenario_from_values()
    box, radius = derived.apparatus(s), 0.02
    spacing = 2 * radius - 1e-5
    n = (6, 4, 4)
    grid = np.stack(np.meshgrid(*[np.arange(k) * spacing for k in n], indexing="ij"), axis=-1).reshape(-1, 3)
    centres = grid + [radius - 1e-6, 0.2, radius - 2e-6]  # touches x = 0 and the floor, nothing else
    order = np.lexsort((grid[:, 0] // (2 * spacing - 1e-9), grid[:, 2], grid[:, 1]))
    centres = centres[order]  # neighbours along x pair up into clumps
    clumps = len(centres) // 2
    inside = clumps
    contacts = (n[0] - 1) * n[1] * n[2] + n[0] * (n[1] - 1) * n[2] + n[0] * n[1] * (n[2] - 1) - inside
    walls = n[1] * n[2] + n[0] * n[1]
    measures = microstructure.contact_measures(centres, radius, box)
    assert measures["coordination_number"] == pytest.approx((2 * contacts + walls) / clumps)
    assert measures["overlap_mean_m"] == pytest.approx(1e-5)
    assert measures["overlap_max_ratio"] == pytest.approx(1e-5 / radius)
    # Two clumps side by side touch with both spheres: one neighbour, two contacts.
    pairs = (n[0] // 2 - 1) * n[1] * n[2] + n[0] // 2 * ((n[1] - 1) * n[2] + n[1] * (n[2] - 1))
    assert measures["neighbours_mean"] == pytest.approx(2 * pairs / clumps)


def scenario_from_values():
    from analysis.scenarios.scenario import load_scenario

    return load_scenario("linear-mu0.8")


@pytest.mark.parametrize(
    "place, sleeper_down, plates_out, touching",
    [
        ((0.4, 0.3, 0.30), 0.0, [0.0] * 5, 0),
        ((0.4, 0.3, 0.30), 0.006, [0.0] * 5, 1),
        ((0.4, 0.1, 0.34), 0.006, [0.0] * 5, 0),
        ((0.779, 0.3, 0.03), 0.0, [0.0] * 5, 0),
        ((0.779, 0.3, 0.03), 0.0, [-0.002, 0, 0, 0, 0], 1),
        ((0.785, 0.3, 0.0645), 0.0, [0.0] * 5, 2),
        ((0.785, 0.3, 0.0645), 0.0, [0.0, 0.01, 0, 0, 0], 1),
        ((0.785, 0.02, 0.4), 0.0, [0.0] * 5, 1),
        ((0.785, 0.585, 0.4), 0.0, [0.0] * 5, 2),
        ((0.01, 0.01, 0.01), 0.0, [0.0] * 5, 3),
    ],
)
def test_wall_contacts_follow_sleeper_and_plates(place, sleeper_down, plates_out, touching):
    box = derived.apparatus(scenario_from_values())
    overlaps = microstructure.wall_overlaps(np.array([place]), 0.02, box, sleeper_down, plates_out)
    assert len(overlaps) == touching


def test_fabric_returns_the_anisotropy_it_was_made_with():
    generator = np.random.default_rng(11)
    normals = generator.standard_normal((400_000, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    assert microstructure.anisotropy(microstructure.fabric(normals)) < 0.03
    a = 0.6  # E(n) = (1 + a_ij n_i n_j) / (4 pi), a = diag(-a/2, -a/2, a)
    density = 1 + a * (normals[:, 2] ** 2 - 0.5 * (normals[:, 0] ** 2 + normals[:, 1] ** 2))
    kept = normals[generator.uniform(0, 1 + a, len(normals)) < density]
    expected = math.sqrt(1.5 * (a * a + a * a / 2))
    assert microstructure.anisotropy(microstructure.fabric(kept)) == pytest.approx(expected, abs=0.03)
    assert microstructure.anisotropy(microstructure.fabric(normals, density)) == pytest.approx(expected, abs=0.03)


def test_force_measures_of_a_small_table():
    contacts = pd.DataFrame(
        [
            [1, 2, 0, 0, 0, 0, 0, 1, 1e-6, 30.0, 1.0, 1],
            [1, 3, 0, 0, 0, 1, 0, 0, 1e-6, 10.0, 1.0, 0],
            [2, 0, 0, 0, 0, 0, 0, -1, 1e-6, 500.0, 1.0, 1],
        ],
        columns=file_columns.CONTACTS,
    )
    measures = microstructure.force_measures(contacts)
    assert measures["normal_force_mean_N"] == 20 and measures["fabric_zz"] == 0.5 and measures["fabric_yy"] == 0
    assert measures["force_chain_share"] == 0.5 and measures["force_chain_load_share"] == 0.75
    assert measures["force_anisotropy"] > measures["contact_anisotropy"] > 0
    assert microstructure.sliding_share(contacts) == pytest.approx(2 / 3)
    assert microstructure.force_measures(contacts[contacts["clump_2"] == 0]) == {}
