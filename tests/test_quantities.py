"""Quantities and comparisons on synthetic runs with known answers."""

import math

import numpy as np
import pandas as pd
import pytest
from synthetic import DEFAULT_LAW, LATERAL_PROFILE, LOSS_ANGLE_RAD, STROKE_M, settlement, write_run

from analysis import load_runs
from analysis.comparison import against_published, codes, run_quantities
from analysis.comparison.findings import agreement
from analysis.comparison.findings.members import members
from analysis.driver.keep import keep
from analysis.formats.quantities import QUANTITIES
from analysis.normalised.sleeper_work import sleeper_work
from analysis.reference.curves import References
from analysis.scenarios import derived

CYCLES = 120


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Three seeds of LIGGGHTS, two of YADE; YADE settles 10 % more and its plates move 20 % more."""
    folder = tmp_path_factory.mktemp("results")
    law = ("exponential", {k: 1.1 * v if k != "c" else v for k, v in DEFAULT_LAW[1].items()})
    for seed in (1, 2, 3):
        write_run(folder, "demo", "linear-mu0.8", "liggghts", CYCLES, seed, noise=0.01, rng=1, contacts=False)
    for seed in (1, 2):
        write_run(
            folder,
            "demo",
            "linear-mu0.8",
            "yade",
            CYCLES + 20,
            seed,
            noise=0.01,
            rng=2,
            law=law,
            lateral_m=6e-3,
            contacts=False,
        )
    write_run(folder, "demo", "nonlinear-en1.0", "liggghts", 6, contacts=False)
    return folder


@pytest.fixture(scope="module")
def runs(results):
    return load_runs(results)


@pytest.fixture(scope="module")
def run(runs):
    return runs.select(code="liggghts", seed=1, scenario="linear-mu0.8")[0]


@pytest.fixture(scope="module")
def short(runs):
    return runs.select(scenario="nonlinear-en1.0")[0]


def value(table, quantity, cycle=None):
    rows = table[(table["quantity"] == quantity) & ((table["cycle"] == cycle) if cycle is not None else True)]
    assert len(rows) == 1, (quantity, cycle, len(rows))
    return rows.iloc[0]


# ------------------------------------------------------------------ one run


def test_stroke_stiffness_and_loop(run):
    table = run_quantities.per_cycle(run)
    area = derived.apparatus(run.scenario).sleeper_area_m2
    assert list(table["cycle"]) == list(range(1, CYCLES + 1)) and set(table) <= set(QUANTITIES)
    assert table["resilient_stroke_m"].to_numpy() == pytest.approx(STROKE_M)
    assert table["peak_acceleration_m_s2"].to_numpy() == pytest.approx(STROKE_M / 2 * (2 * math.pi * 20) ** 2)
    assert table["secant_stiffness_N_m"].to_numpy() == pytest.approx(area * 410e3 / STROKE_M, rel=0.02)
    # Of a cycle that adds nothing the work is the ellipse: pi x amplitude of the load x that of the lagging
    # displacement.
    loop = math.pi * 205e3 * area * STROKE_M / 2 * math.tan(LOSS_ANGLE_RAD)
    permanent = area * 255e3 * table["settlement_increment_m"]  # the mean load does the rest
    assert table["loop_energy_J"].to_numpy() == pytest.approx(loop + permanent.to_numpy(), rel=0.01)
    assert table["porosity_spread"].iloc[-1] == pytest.approx(0.035)


def test_a_run_without_history_has_the_work_of_its_harmonics(results, tmp_path):
    (whole,) = load_runs(results, scenario="nonlinear-en1.0", quiet=True)
    keep(whole.folder, tmp_path / "full" / "nonlinear-en1.0" / "liggghts")
    (kept,) = load_runs(tmp_path)
    assert not sleeper_work(kept)
    # 1 %: the synthetic settlement between two minima is no pure sinusoid
    assert run_quantities.per_cycle(kept)["loop_energy_J"].to_numpy() == pytest.approx(
        run_quantities.per_cycle(whole)["loop_energy_J"].to_numpy(), rel=0.01
    )


def test_the_stress_on_the_plates_is_kept_with_a_run(results, tmp_path):
    (whole,) = load_runs(results, scenario="nonlinear-en1.0", quiet=True)
    keep(whole.folder, tmp_path / "full" / "nonlinear-en1.0" / "liggghts")
    (kept,) = load_runs(tmp_path)
    pd.testing.assert_frame_equal(kept.plate_stresses, whole.plate_stresses, check_dtype=False, rtol=1e-8)
    plates = [f"plate_{k}_stress_Pa" for k in range(1, 6)]
    rows = whole.history[whole.history["cycle"].between(1, 2, inclusive="right")][plates]
    second = whole.plate_stresses.set_index("cycle").loc[2]
    assert second["plate_4_stress_mean_Pa"] == pytest.approx(rows["plate_4_stress_Pa"].mean())
    assert second["plate_stress_min_Pa"] == rows.to_numpy().min()
    assert second["plate_stress_max_Pa"] == rows.to_numpy().max()


def test_increments_add_up_and_gaps_are_not_bridged(run, results):
    table = run_quantities.per_cycle(run)
    assert table["settlement_increment_m"].sum() == pytest.approx(run.cycles["settlement_m"].iloc[-1])
    gap = load_runs(results, scenario="nonlinear-en1.0", quiet=True)[0]
    gap.cycles = gap.cycles[gap.cycles["cycle"] != 3].reset_index(drop=True)
    assert run_quantities.per_cycle(gap)["settlement_increment_m"].isna().tolist() == [False, False, True, False, False]


def test_loops_need_a_whole_cycle(results):
    run = load_runs(results, scenario="nonlinear-en1.0", quiet=True)[0]
    history = run.history
    run.history = history[(history["cycle"] < 2.1) | (history["cycle"] > 2.6)]
    assert sorted(sleeper_work(run)) == [1, 2, 4, 5, 6]
    run.history = history[history["cycle"] <= 4.5]
    assert sorted(sleeper_work(run)) == [1, 2, 3, 4]
    run.history = history.iloc[::8]
    assert sleeper_work(run) == {}
    run.history = history.iloc[:0]
    assert run_quantities.per_cycle(run)["loop_energy_J"].isna().all()


def test_lateral_profile_against_depth(run):
    table = run_quantities.lateral_profile(run)
    assert table["cycle"].unique().tolist() == [1, 10, 100]
    assert run_quantities.plate_depths(run.scenario) == pytest.approx([0.293, 0.228, 0.163, 0.098, 0.033])
    share = settlement(DEFAULT_LAW, [10])[0] / settlement(DEFAULT_LAW, [CYCLES])[0]
    at_10 = table[table["cycle"] == 10]
    assert at_10["depth_m"].to_numpy() == pytest.approx(run_quantities.plate_depths(run.scenario))
    assert at_10["lateral_m"].to_numpy() == pytest.approx(5e-3 * share * np.array(LATERAL_PROFILE))
    assert len(run_quantities.lateral_profile(run, [7000])) == 0


def test_known_bulge(run):
    """The plates' displacements times their area, in the synthetic run and by the function itself."""
    expected = 5e-3 * sum(LATERAL_PROFILE) * derived.apparatus(run.scenario).plate_area_m2
    assert value(run_quantities.summary(run), "bulge_volume_m3", CYCLES)["value"] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("curve", "trend"),
    [
        (lambda n: 1e-3 * (1 + 0.3 * np.log(n)), "slowing"),
        (lambda n: 1e-3 * n**0.17, "slowing"),
        (lambda n: 1e-4 * n, "steady"),
        (lambda n: 1e-4 * n + 1e-5 * n**2, "growing"),
    ],
)
@pytest.mark.parametrize("cycles", [20, 36, 100])
def test_a_bed_that_shakes_down_is_told_from_one_that_ratchets_and_one_that_fails(curve, trend, cycles):
    class SyntheticRun:
        pass

    bed, n = SyntheticRun(), np.arange(1, cycles + 1)
    bed.cycles = pd.DataFrame(
        {"cycle": n, "settlement_m": curve(n), **{f"lateral_{k}_m": 2e-5 * n for k in range(1, 6)}}
    )
    bed.microstructure = pd.DataFrame({"cycle": [0, *n], "crib_heave_m": [0, *(-1e-5 * n)]})
    rates = run_quantities.settling_rates(bed)
    assert run_quantities.trend_of(rates["settlement_rate_m"]) == trend
    assert rates["last_cycle"].iloc[-1] == cycles and list(rates["first_cycle"][:4]) == [0, 1, 2, 5]
    np.testing.assert_allclose(rates["lateral_rate_m"], 2e-5, rtol=1e-9)
    np.testing.assert_allclose(rates["crib_heave_rate_m"], -1e-5, rtol=1e-9)
    spans = rates["last_cycle"] - rates["first_cycle"]
    assert (spans * rates["settlement_rate_m"]).sum() == pytest.approx(curve(cycles))


@pytest.mark.parametrize("cycles", [0, 1, 2])
def test_a_run_of_a_cycle_or_none_has_no_trend(results, cycles):
    (run,) = load_runs(results, scenario="nonlinear-en1.0")
    run.cycles = run.cycles.iloc[:cycles]
    rates = run_quantities.settling_rates(run)
    assert run_quantities.trend_of(rates["settlement_rate_m"]) == "" and len(rates) == cycles


def test_late_slope_and_its_interval(run):
    n, held = np.arange(1, 1001), 0
    for seed in range(20):
        curve = settlement(DEFAULT_LAW, n) + 1e-5 * np.random.default_rng(seed).standard_normal(1000)
        slope, low, high = run_quantities.late_slope(n, curve)
        assert low < slope < high and high - low < 2e-7
        held += low <= 2e-6 <= high
    assert held >= 15  # 0.95 each: fewer would happen once in 3000 times
    assert run_quantities.late_slope(n, curve, first=1, last=20)[0] > 1e-4
    assert all(map(math.isnan, run_quantities.late_slope(n[:12], curve[:12])))
    assert all(map(math.isnan, run_quantities.late_slope([], [])))


def test_summary_says_everything_or_why_not(run, short):
    table = run_quantities.summary(run)
    assert list(table) == list(run_quantities.SUMMARY)
    assert ((table["missing"] == "") == table["value"].notna()).all()
    assert value(table, "settlement_m", 1000)["missing"] == f"the run has {CYCLES} cycles"
    assert value(table, "settlement_m", 10)["value"] == pytest.approx(settlement(DEFAULT_LAW, [10])[0], rel=0.05)
    for name in ("a", "b", "c", "d"):
        row = value(table, f"exponential_{name}")
        assert row["low"] <= DEFAULT_LAW[1][name] <= row["high"]
    brief = run_quantities.summary(short)
    assert "too few" in value(brief, "exponential_c")["missing"]
    assert value(brief, "late_slope_m")["missing"] == "the later half of 6 cycles has fewer than 10"
    assert value(brief, "settlement_m", 6)["missing"] == ""


def test_summary_of_a_damaged_run(results):
    run = load_runs(results, scenario="nonlinear-en1.0", quiet=True)[0]
    run.microstructure, run.history = run.microstructure.iloc[:0], run.history.iloc[:0]
    run.cycles = run.cycles.assign(porosity_2=np.nan)
    table = run_quantities.summary(run)
    assert value(table, "porosity_2", 6)["missing"] == "not in cycles.csv"
    assert value(table, "loop_energy_J", 6)["missing"] == "not in history.csv"
    assert value(table, "coordination_number", 6)["missing"] == "not in microstructure.csv"
    run.cycles = run.cycles.iloc[:0]
    assert (run_quantities.summary(run)["missing"] != "").all()


def test_nothing_needs_the_scenario(results):
    run = load_runs(results, scenario="nonlinear-en1.0", quiet=True)[0]
    run.scenario = None
    assert run_quantities.per_cycle(run)["secant_stiffness_N_m"].isna().all()
    assert run_quantities.lateral_profile(run)["depth_m"].isna().all()
    assert len(run_quantities.summary(run))


# ------------------------------------------------------------------ code against code


def agreed(runs):
    """(values of each run, code against code) as the findings have them."""
    values = agreement.seed_values(members(runs))
    return values, agreement.agreement_table(values, agreement.scatter_table(values))


def test_agreement_returns_the_known_differences(runs):
    values, table = agreed(runs)
    assert set(table["scenario"]) == {"linear-mu0.8"}  # the other one has run in one code only
    assert sorted(table["cycle"].unique()) == [1, 2, 5, 10, 20, 50, 100]  # none beyond what all runs have
    row = value(table, "settlement_m", 100)
    assert (row["yade_beds"], row["liggghts_beds"]) == (2, 3)
    assert row["liggghts_mean"] / row["yade_mean"] == pytest.approx(1 / 1.1, rel=0.03) and row["difference"] < 0
    bands = agreement.band_table(values)
    band = value(bands[bands["code"] == "yade"], "settlement_m", 100)
    assert band["low"] <= band["mean"] == row["yade_mean"] <= band["high"]
    row = value(table, "lateral_mean_m", 100)
    # YADE's run is longer: its full 6 mm come after 140 cycles, those of LIGGGHTS after 120.
    at_end = settlement(DEFAULT_LAW, [CYCLES])[0] / settlement(DEFAULT_LAW, [CYCLES + 20])[0]
    assert row["liggghts_mean"] / row["yade_mean"] == pytest.approx(5 / (6 * at_end), rel=1e-6)
    assert not row["low_ratio"] <= 0 <= row["high_ratio"]
    assert value(table, "porosity_1", 100)["unit"] == "-"


def test_agreement_of_single_runs_has_no_scatter(runs):
    _, table = agreed(runs.select(seed=1))
    assert (table["yade_beds"] == 1).all() and table["low_ratio"].isna().all()
    assert (table["state"] == agreement.OPEN).all()


def test_agreement_within_the_scatter_of_equal_codes(tmp_path):
    for code in ("yade", "liggghts"):
        for seed in (1, 2, 3, 4):
            write_run(tmp_path, "demo", "linear-mu0.8", code, 10, seed, noise=0.02, rng=10 + len(code), contacts=False)
    _, table = agreed(load_runs(tmp_path, quiet=True))
    settled = table[table["quantity"] == "settlement_m"]
    assert len(settled) == 4 and ((settled["low_ratio"] <= 0) & (settled["high_ratio"] >= 0)).all()


def test_agreement_of_nothing():
    assert [len(table) for table in agreed([])] == [0, 0]
    assert len(codes.lateral_agreement([])) == 0 and codes.last_common_cycle([]) == 0


def test_lateral_shapes(runs):
    table = codes.lateral_agreement(runs)
    assert table["cycle"].tolist() == [1, 10, 100, CYCLES]
    assert table["correlation"].to_numpy() == pytest.approx(1)  # the same profile in both codes
    last = table.iloc[-1]
    scale = 6 * settlement(DEFAULT_LAW, [CYCLES])[0] / settlement(DEFAULT_LAW, [CYCLES + 20])[0] - 5
    assert last["rms_m"] == pytest.approx(1e-3 * scale * np.sqrt(np.mean(np.square(LATERAL_PROFILE))), rel=1e-6)


def test_seed_bands(runs):
    bands = agreement.band_table(agreement.seed_values(members(runs)))
    at = bands[(bands["code"] == "liggghts") & (bands["scenario"] == "linear-mu0.8") & (bands["cycle"] == 50)]
    row = value(at, "settlement_m", 50)
    one = runs.cycles[(runs.cycles["code"] == "liggghts") & (runs.cycles["cycle"] == 50)]["settlement_m"]
    assert row["beds"] == 3
    assert [row["low"], row["mean"], row["high"]] == pytest.approx([one.min(), one.mean(), one.max()])


# ------------------------------------------------------------------ run against reference


def test_reference_that_is_shifted():
    """A constant shift, as the paper claims: nothing is left of the difference once it is removed."""
    n = np.arange(1, 1001)
    ours, at = settlement(DEFAULT_LAW, n), np.array([1, 5, 20, 100, 300, 600, 1000])
    result = against_published.against_reference(n, ours, at, ours[at - 1] - 2e-3, 1e-3)
    assert result.points == 7 and result.shift_m == pytest.approx(2e-3) and result.rms_m == pytest.approx(2e-3)
    assert result.rms_shifted_m == pytest.approx(0, abs=1e-12)
    assert result.late_slope_ratio == pytest.approx(1) and result.first_cycle_ratio == pytest.approx(
        ours[0] / (ours[0] - 2e-3)
    )
    assert (result.within_error, result.within_error_shifted) == (0, 1)


def test_reference_of_another_slope_and_order():
    n = np.arange(1, 1001)
    at = np.array([1000, 1, 400, 200, 800, 600])
    result = against_published.against_reference(n, 2e-3 + 4e-6 * n, at, 2e-3 + 2e-6 * at)
    assert result.late_slope_ratio == pytest.approx(2) and math.isnan(result.within_error)
    assert result.shift_m == pytest.approx(np.mean(2e-6 * at))
    assert result.rms_shifted_m == pytest.approx(np.std(2e-6 * at))


def test_reference_beyond_the_run_does_not_count():
    n, at = np.arange(1, 51), np.array([10, 20, 40, 50, 100, 1000])
    result = against_published.against_reference(n, 1e-5 * n, at, 1e-5 * at)
    assert result.points == 4 and result.rms_m == pytest.approx(0, abs=1e-15) and math.isnan(result.first_cycle_ratio)
    assert against_published.against_reference(n, 1e-5 * n, [500, 600, 700], [1, 1, 1]) is None
    assert against_published.against_reference([], [], at, at) is None


def test_reference_table_pairs_scenarios(runs):
    rows = []
    for source, curve, scenario in (
        ("experiment", "test", math.nan),
        ("paper", "linear", "linear-mu0.8"),
        ("paper", "nonlinear", "nonlinear-en1.0"),
    ):
        for n in (1, 3, 5, 6):
            rows.append(
                {
                    "source": source,
                    "curve": curve,
                    "scenario": scenario,
                    "quantity": "settlement",
                    "cycle": n,
                    "value": 1e-3 * n,
                    "error": 1e-4,
                }
            )
    table = against_published.reference_table(runs, References(pd.DataFrame(rows), pd.DataFrame()))
    counts = table.groupby(["source", "curve"]).size().to_dict()
    assert counts == {("experiment", "test"): 6, ("paper", "linear"): 5, ("paper", "nonlinear"): 1}
    assert table["rms_m"].notna().all()
    pending = pd.DataFrame(columns=["source", "curve", "scenario", "quantity", "cycle", "value", "error"])
    assert len(against_published.reference_table(runs, References(pending, pd.DataFrame()))) == 0
