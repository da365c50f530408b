"""Benchmark: what is timed, on which bed, and what is made of it."""

import sys

import numpy as np
import pytest

from analysis.driver.bench import bench_beds, profile, stock_deck
from analysis.driver.bench.bench_tables import comparison, exponent, read_timings, renew
from analysis.driver.bench.meter import measure
from analysis.driver.engine import EngineError
from analysis.formats import kept_tables
from analysis.formats.growing_csv import GrowingCsv
from analysis.scenarios import derived
from analysis.scenarios.scenario import load_scenario

SCENARIO = load_scenario("linear-mu0.8", "full")
CLUMP = derived.clump(SCENARIO)
BUSY_THEN_IDLE = """
import sys, time
rows = open(sys.argv[1], "a")
print("step,x", file=rows, flush=True)
for step in range(1, 40):
    until = time.process_time() + 0.02
    while time.process_time() < until:
        pass
    time.sleep(0.02)
    print(f"{step},0", file=rows, flush=True)
"""


def test_a_speed_counts_processor_time_and_not_waiting(tmp_path):
    script, rows = tmp_path / "busy.py", tmp_path / "rows.csv"
    script.write_text(BUSY_THEN_IDLE)
    speed = measure([sys.executable, str(script), str(rows)], tmp_path / "log.txt", rows, 20)
    assert speed.steps >= 20
    assert speed.cpu_s / speed.steps == pytest.approx(0.02, rel=0.3)  # the kernel counts in ticks of 10 ms
    assert speed.wall_s > 1.5 * speed.cpu_s


def test_an_engine_that_ends_early_is_an_error(tmp_path):
    with pytest.raises(EngineError, match="ended before step 5"):
        measure([sys.executable, "-c", "pass"], tmp_path / "log.txt", tmp_path / "rows.csv", 5)


def bed_of_columns():
    """Upright and lying clumps on a grid that fills the box up to below the sleeper, none touching."""
    box, rng = derived.apparatus(SCENARIO), np.random.default_rng(1)
    pitch = 2 * (CLUMP.radius_m + CLUMP.half_distance_m)
    grids = [np.arange(pitch / 2, size, pitch) for size in (box.length_m, box.width_m, 0.3)]
    centres = np.stack(np.meshgrid(*grids, indexing="ij"), axis=-1).reshape(-1, 3)
    turns = rng.normal(size=(len(centres), 4))
    return np.hstack([centres, turns / np.linalg.norm(turns, axis=1)[:, None]])


def wide(width):
    values = {key: parameter.value for key, parameter in SCENARIO.parameters.items()}
    scaled = ("geometry.box_width", "geometry.sleeper_width")
    return values | {key: values[key] * width for key in scaled}


def test_a_wider_bed_is_made_of_mirror_images():
    bed = bed_of_columns()
    doubled = bench_beds.widened(bed, wide(2.0), 2.0)
    assert len(doubled) == 2 * len(bed)
    centres = bench_beds.sphere_centres(doubled, CLUMP.half_distance_m)
    mirrored = centres * [1, -1, 1] + [0, 2 * derived.apparatus(SCENARIO).width_m, 0]

    def sorted_points(points):
        points = np.round(points.reshape(-1, 3), 9)
        return points[np.lexsort(points.T)]

    assert np.allclose(sorted_points(centres), sorted_points(mirrored), atol=1e-8)  # ways of rounding the ninth digit


def test_a_narrow_bed_reaches_into_no_wall():
    narrow = bench_beds.widened(bed_of_columns(), wide(0.33), 0.33)
    width = derived.apparatus(wide(0.33)).width_m
    centres = bench_beds.sphere_centres(narrow, CLUMP.half_distance_m)
    assert 0 < len(narrow) < len(bed_of_columns())
    assert (centres[..., 1] + CLUMP.radius_m).max() <= width + bench_beds.DEEPEST * CLUMP.radius_m


def test_a_box_of_triangles_is_closed_and_has_the_size_of_the_block():
    block = derived.Block((0.0, 0.1, 0.2), (0.5, 0.4, 0.9))
    corners = [
        tuple(map(float, line.split()[1:])) for line in stock_deck.box_stl("x", block).splitlines() if "vertex" in line
    ]
    triangles = np.array(corners).reshape(-1, 3, 3)
    area = 0.5 * np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)
    assert len(triangles) == 12
    assert area.sum() == pytest.approx(2 * (0.5 * 0.3 + 0.5 * 0.7 + 0.3 * 0.7), rel=1e-12)
    assert (triangles.min((0, 1)) == block.low).all() and (triangles.max((0, 1)) == block.high).all()


def timing(who, steps, cpu_s, cycle=1000):
    return {"code": "liggghts", "law": "linear", "who": who, "steps": steps, "cpu_s": cpu_s, "steps_per_cycle": cycle}


def test_ratios_are_of_cycles_and_of_medians():
    timings = [timing("paper", 100, cpu) for cpu in (1.0, 0.5, 9.0)]
    timings += [timing("stock", 100, 2.0), timing("verified", 100, 1.0, cycle=500)]
    baseline = [{"code": "liggghts", "law": "linear", "steps_per_cpu_s": 80.0, "stock_steps_per_cpu_s": 100.0}]
    rows = {case: (speed, ratio) for case, _, _, speed, ratio in comparison(timings, baseline)}
    assert rows["over_stock"] == (100.0, 2.0)
    assert rows["ours_paper_step"] == (100.0, 2.5)  # the baseline makes 40 steps where stock makes 50
    assert rows["ours_verified_step"] == (100.0, 5.0)  # half as many steps in a cycle


def test_without_a_baseline_ours_are_compared_with_stock_only():
    rows = comparison([timing("paper", 100, 1.0), timing("stock", 100, 2.0)], [])
    assert [row[0] for row in rows] == ["over_stock"]


def test_the_exponent_of_a_power_law_is_found():
    assert exponent([(n, 5e6 / n) for n in (500, 1500, 4573)]) == pytest.approx(-1, abs=1e-12)


def test_a_timing_without_wall_time_is_read_back(tmp_path):
    """The stock YADE script times itself, in processor time only."""
    table = GrowingCsv(tmp_path / "timings.csv", kept_tables.TIMINGS.columns)
    table.start()
    table.append([("yade", "linear", "stock", 4573, 1, 400, 17216, 6.0, float("nan"), 1.0)])
    (row,) = read_timings(table.path)
    assert row["cpu_s"] == 6.0 and np.isnan(row["wall_s"])


def test_a_table_keeps_the_rows_of_codes_that_were_not_timed_again(tmp_path):
    table = tmp_path / "benchmark.csv"
    renew(table, kept_tables.BENCHMARK, [("over_stock", "yade", "linear", 1.0, 2.0)], key=("code", "law"))
    renew(table, kept_tables.BENCHMARK, [("over_stock", "liggghts", "linear", 3.0, 4.0)], key=("code", "law"))
    renew(table, kept_tables.BENCHMARK, [("over_stock", "liggghts", "linear", 5.0, 6.0)], key=("code", "law"))
    assert table.read_text().splitlines()[1:] == [
        "over_stock,liggghts,linear,5.0,6.0",
        "over_stock,yade,linear,1.0,2.0",
    ]


PERF = """
    60.00%  [.] ballast::PairBallast::add_forces
    20.00%  [.] LAMMPS_NS::FixWall::gap
    10.00%  [.] LAMMPS_NS::FixMultisphereDamped::calc_force
     6.00%  [k] clear_page_rep
     4.00%  [.] 0x0000000000660e9e
"""


def test_samples_of_functions_are_summed_by_part():
    assert profile.shares_of(PERF, "liggghts") == pytest.approx(
        {
            "contacts between particles": 0.6,
            "walls, sleeper and plates": 0.2,
            "motion of clumps": 0.1,
            "other": 0.06,  # the kernel
            profile.UNNAMED: 0.04,
        },
        abs=1e-12,
    )
    with pytest.raises(EngineError, match="no function"):
        profile.shares_of("# nothing", "yade")
