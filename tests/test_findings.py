"""The findings: what runs with known answers say, as tables, before any sentence or figure."""

import cmath
import json
import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from synthetic import LATERAL_PROFILE, LOSS_ANGLE_RAD, STROKE_M, write_run

from analysis.comparison.findings import agreement
from analysis.comparison.findings.find import find
from analysis.comparison.findings.influence import size_of_change
from analysis.comparison.findings.members import SERVO, TRUE_LOAD, choose, member
from analysis.comparison.findings.timestep_spread import timestep_spread_table
from analysis.driver.keep import keep
from analysis.files import KEPT_RUNS
from analysis.formats import file_columns
from analysis.formats.run_record import DIVERGED
from analysis.normalised.readers import load_runs
from analysis.reference.ballast_stiffness import ballast_stiffness
from analysis.reference.curves import load_references
from analysis.report import readme
from analysis.report.answer import answer, engineer, extremes
from analysis.report.labels import time_steps
from analysis.report.report_data import KEY_SCENARIOS, PAPER_SCENARIOS
from analysis.report.sentences import lines
from analysis.scenarios import derived
from analysis.scenarios.scenario import load_scenario

EXPONENTIAL = {"a": 1e-3, "b": 6e-3, "c": 15.0, "d": 2e-6}


def exponential(scale=1.0):
    return "exponential", {name: value * (scale if name in "abd" else 1) for name, value in EXPONENTIAL.items()}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Three LIGGGHTS seeds of 20 cycles, one of 10, and one YADE run that settles 10 % more."""
    results = tmp_path_factory.mktemp("results")
    for seed, scale in ((1, 1.0), (2, 1.02), (3, 0.98)):
        write_run(results, "full", "linear-mu0.8", "liggghts", 20, seed, law=exponential(scale))
    write_run(results, "full", "linear-mu0.8", "liggghts", 10, 4, law=exponential(5.0))
    write_run(results, "full", "linear-mu0.8", "yade", 20, law=exponential(1.1))
    return find(load_runs(results), load_references(), ["linear-mu0.8", "nonlinear-en1.0"])


def row(table, **where):
    """The only row of a table in which the named columns have these values."""
    for name, value in where.items():
        table = table[table[name] == value]
    assert len(table) == 1, table
    return table.iloc[0]


def test_a_mean_says_how_many_beds_reach_the_cycle(found):
    at = {"code": "liggghts", "quantity": "settlement_m"}
    assert row(found.values, cycle=10, **at)["beds"] == 4 and row(found.values, cycle=20, **at)["beds"] == 3
    last = row(found.values, cycle=20, **at)
    a, b, c, d = EXPONENTIAL.values()
    assert last["mean"] == pytest.approx(a + b * -math.expm1(-20 / c) + d * 20, rel=1e-9)
    assert last["low"] == pytest.approx(0.98 * last["mean"]) and last["high"] == pytest.approx(1.02 * last["mean"])


def test_codes_are_compared_at_equal_cycles_with_an_interval_that_the_scatter_gives(found):
    found_row = row(found.agreement, quantity="settlement_m", cycle=20)
    assert found_row["liggghts_beds"] == 3 and found_row["yade_beds"] == 1
    assert found_row["difference_ratio"] == pytest.approx(-0.1 / 1.05, rel=1e-6)
    half = 4.302652729911275 * 0.02 * math.sqrt(1 / 3 + 1)  # Student's t of two degrees of freedom
    assert found_row["high_ratio"] - found_row["difference_ratio"] == pytest.approx(half, rel=1e-6)
    assert found_row["state"] == agreement.AGREES
    assert found.agreement["cycle"].max() == 20


@pytest.mark.parametrize(
    "one, other, scatter, degrees, beds, state",
    [
        (1.0, 1.05, 0.02, 10, (3, 3), agreement.AGREES),
        (1.0, 2.0, 0.05, 10, (3, 3), agreement.DIFFERS),
        (1.0, 1.05, 0.3, 10, (2, 1), agreement.OPEN),
        (1.0, 1.6, math.nan, 0, (1, 1), agreement.OPEN),
        (1e-5, -1e-5, 0.1, 10, (3, 3), agreement.OPEN),
    ],
    ids=["close", "far", "wide", "one bed each", "across zero"],
)
def test_three_states_and_no_ratio_across_zero(one, other, scatter, degrees, beds, state):
    judged = agreement.judge(one, other, scatter, degrees, beds)
    assert judged["state"] == state
    assert math.isnan(judged["difference_ratio"]) == (one * other <= 0)
    if math.isfinite(judged["beds_needed"]):  # with that many beds in each code the interval is narrow enough
        needed = int(judged["beds_needed"])
        again = agreement.judge(1.0, 1.0, scatter, degrees, (needed, needed))
        assert again["state"] == agreement.AGREES
        fewer = agreement.judge(1.0, 1.0, scatter, degrees, (needed - 1, needed - 1))
        assert fewer["state"] == agreement.OPEN


def test_the_interval_covers_the_truth_as_often_as_it_says():
    """95 % of intervals of two equal codes hold zero, with one bed in one of them and scatter pooled over scenarios."""
    generator, inside, trials = np.random.default_rng(5), 0, 1500
    for _ in range(trials):
        values = 1 + 0.1 * generator.standard_normal((5, 3))
        ours, theirs = values[0].mean(), 1 + 0.1 * generator.standard_normal()
        scatter = math.sqrt((values.var(axis=1, ddof=1) / values.mean(axis=1) ** 2).mean())
        judged = agreement.judge(ours, theirs, scatter, 10, (3, 1))
        inside += judged["low_ratio"] <= 0 <= judged["high_ratio"]
    assert inside / trials == pytest.approx(0.95, abs=0.02)  # three standard errors of 1500 trials are 0.017


def test_what_is_equal_by_construction_gets_no_verdict(found):
    assert not {"clumps", "tracking_rms_Pa"} & set(found.agreement["quantity"])


def test_missing_scenarios_cycles_and_seeds_are_pending(found):
    assert row(found.pending, kind="scenario")["scenario"] == "nonlinear-en1.0"
    assert row(found.pending, kind="cycles", code="yade")[["have", "want"]].tolist() == [20, 1000]
    assert row(found.pending, kind="seeds")["code"] == "yade"


def test_settling_is_judged_up_to_each_span(found):
    spans = found.rates[(found.rates["code"] == "yade")]
    assert spans["last_cycle"].tolist() == [1, 2, 5, 10, 20]
    a, b, c, d = (1.1 * EXPONENTIAL[n] if n != "c" else EXPONENTIAL[n] for n in EXPONENTIAL)
    law = lambda n: a + b * -math.expm1(-n / c) + d * n  # noqa: E731
    assert spans["settlement_rate_m"].iloc[-1] == pytest.approx((law(20) - law(10)) / 10, rel=1e-9)
    assert spans["trend"].tolist()[:2] == ["", ""] and spans["trend"].iloc[-1] == "slowing"


def test_cost_and_load_are_told_for_every_run(found):
    cost = found.computing_time.iloc[0]
    assert cost["seconds_per_cycle"] == pytest.approx(cost["steps_per_cycle"] / cost["steps_per_s"])
    assert found.load_tracking["met"].tolist() == ["yes"] * 5
    assert found.coverage["lateral_mean_m"].iloc[0] == pytest.approx(5e-3 * np.mean(LATERAL_PROFILE))


def test_the_same_run_twice_counts_once(tmp_path):
    runs = [load_runs(write_run(tmp_path / where, cycles=n).parents[2])[0] for where, n in (("a", 3), ("b", 5))]
    chosen, left_out = choose(runs)
    assert chosen == [runs[1]] and [run for run, _ in left_out] == [runs[0]]


def test_tables_are_written_as_csv_that_reads_back(found, tmp_path):
    for path in found.write(tmp_path):
        if path.read_text().strip() and path.stem != "columns":
            assert len(pd.read_csv(path)) == len(found.frames()[path.stem])


# ------------------------------------------------------------------ the servo


LOSS_RAD = 0.17


def servo_run(results, contacts, gain=0.8, variant="servo", cycles=6, scenario="nonlinear-en1.0"):
    """A run by the servo with so many contacts, on a bed of constant stiffness and loss angle, solved exactly."""
    folder = write_run(results, "full", scenario, "liggghts", cycles)
    s = load_scenario(scenario, "full", cycles=cycles)
    for key, value in (("load_control.sleeper_law", "pfc"), ("load_control.pfc_gain", gain)):
        s = s.with_values({key: value})
    (folder / "scenario.json").write_text(s.to_json())
    middle, swing, area = 255e3, 205e3, derived.apparatus(s).sleeper_area_m2
    bed = cmath.rect(area * 2 * swing / STROKE_M, LOSS_RAD)
    omega, stiffness = 2 * math.pi * 20, contacts * s["contact.particle_wall.normal_stiffness"]
    # v = i w x = G (F_target - F) and F = K_bed x
    servo_gain = gain / (stiffness * s["time.paper_step"])
    force = -swing * area * servo_gain * bed / (1j * omega + servo_gain * bed)
    settlement = force / bed
    cycles_table = pd.read_csv(folder / "cycles.csv")
    cycles_table["sleeper_stress_min_Pa"] = middle - abs(force) / area
    cycles_table["sleeper_stress_max_Pa"] = middle + abs(force) / area
    cycles_table.to_csv(folder / "cycles.csv", index=False)
    history = pd.read_csv(folder / "history.csv")
    wave = np.exp(2j * np.pi * history["cycle"])
    history["sleeper_target_Pa"] = middle - swing * wave.to_numpy().real
    history["sleeper_stress_Pa"] = middle + (force * wave).to_numpy().real / area
    history["settlement_m"] = 5e-3 + (settlement * wave).to_numpy().real
    history.to_csv(folder / "history.csv", index=False)
    structure = pd.read_csv(folder / "microstructure.csv").assign(sleeper_contacts=contacts)
    structure.to_csv(folder / "microstructure.csv", index=False)
    target = results / "full" / f"{scenario}+{variant}"
    folder.parent.rename(target)
    info = (target / "liggghts" / "run.json").read_text()
    (target / "liggghts" / "run.json").write_text(info.replace(f'"{scenario}"', f'"{scenario}+{variant}"', 1))
    return target / "liggghts"


def test_the_band_takes_in_the_replicates_of_the_time_step_study():
    steps = [("paper", 2e-6, 1, "a", 1.00), ("half", 1e-6, 1, "a", 0.98), ("rounding", 2e-6, 2, "a", 1.05)]
    steps += [("0.8", 3e-6, 1, "a", 2.0), ("seed 2", 1e-6, 1, "b", 3.0)]  # another step, another bed: no replicates
    steps += [("step", 2e-6, 1, "d", 1.00), ("its half", 1e-6, 1, "d", 1.01)]
    names = ["case", "time_step_s", "ranks", "bed", "settlement_m"]
    timestep = pd.DataFrame(steps, columns=names).assign(scenario="linear-mu0.8", cycle=5)
    late = timestep.assign(cycle=20, settlement_m=timestep["settlement_m"] * timestep["ranks"])
    timestep = pd.concat([timestep, late], ignore_index=True)
    pairs = agreement.replicates(timestep).query("cycle == 5")
    assert sorted(zip(pairs["one"], pairs["other"], strict=True)) == [
        ("paper", "half"),
        ("paper", "rounding"),
        ("step", "its half"),
    ]
    assert pairs.set_index("other").at["rounding", "difference_ratio"] == pytest.approx(0.05 / 1.025)
    codes = {"profile": "full", "scenario": "linear-mu0.8", "reading": "true load", "bed": "c", "differs": "code"}
    rows = [{"one": "y", "other": "l", "cycle": n, "difference_ratio": ratio} for n, ratio in ((5, 0.04), (20, 0.08))]
    found = pd.DataFrame([codes | row for row in rows])
    alone, together = (agreement.same_bed_verdicts(found, *more).iloc[0] for more in ((), (timestep,)))
    assert alone["state"] == agreement.OPEN and alone["band_pairs"] == 0
    assert together["state"] == agreement.AGREES and together["band_pairs"] == 3 and together["cycles"] == 5
    assert together["codes_ratio"] == 0.04 and together["band_ratio"] == pytest.approx(0.05 / 1.025)
    assert together["late_cycle"] == 20 and together["codes_late_ratio"] == 0.08
    assert together["band_late_ratio"] == pytest.approx(2 * 1.1 / 3.1), "later cycles are shown, not judged"
    servo = agreement.same_bed_verdicts(found.assign(reading="servo"), timestep).iloc[0]
    assert servo["band_pairs"] == 0, "the study of the time step is made under the true load"
    damped = agreement.same_bed_verdicts(found.assign(differs="code and dashpot"), timestep).iloc[0]
    assert damped["state"] == agreement.OTHER_DASHPOT and damped["codes_ratio"] == 0.04, "told, not judged"
    half = found.assign(bed="e", differs="time.step", difference_ratio=0.5)
    lent = agreement.same_bed_verdicts(pd.concat([found, half]), timestep)
    assert lent["bed"].tolist() == ["c"] and lent["band_pairs"].tolist() == [4], "pairs of another bed count too"
    assert lent["band_ratio"].tolist() == [0.5]


def test_the_spread_by_the_time_step_stands_beside_those_by_beds_and_by_rounding():
    runs = {"paper": 1.0, "verified": 2.0, "0.8": 2.5, "rounding": 2.1, "seed 2": 2.4, "seed 3": 1.7}
    done = [{"scenario": "a", "case": case, "cycle": 20, "settlement_m": m} for case, m in runs.items()]
    early = [row | {"cycle": 10, "settlement_m": 9.0} for row in done]
    other = [{"scenario": "b", "case": "paper", "cycle": 20, "settlement_m": 1.0}]  # not yet by the study's step
    timestep = pd.DataFrame([*done, *early, *other]).assign(state="done")
    pending = pd.DataFrame([{"scenario": "a", "case": "half", "cycle": 20, "settlement_m": 7.0, "state": "pending"}])
    (row,) = timestep_spread_table(pd.concat([timestep, pending], ignore_index=True)).to_dict("records")
    assert row["scenario"] == "a" and row["cycle"] == 20
    assert row["steps_ratio"] == pytest.approx(np.std([1.0, 2.0, 2.5], ddof=1) / 2)
    assert row["beds_ratio"] == pytest.approx(np.std([2.0, 2.4, 1.7], ddof=1) / 2)
    assert row["rounding_ratio"] == pytest.approx(0.1 / math.sqrt(2) / 2)
    assert timestep_spread_table(pd.DataFrame()).empty


def test_what_the_servo_makes_of_the_load_follows_from_counted_contacts_gain_and_bed(tmp_path):
    servo_run(tmp_path, 200)
    servo_run(tmp_path, 90, gain=0.3, variant="servo-gain0.3")
    table = find(load_runs(tmp_path), load_references()).servo
    for line in (row(table, gain=gain) for gain in (0.8, 0.3)):
        # history.csv has nine digits
        assert line["bed_loss_angle_rad"] == pytest.approx(LOSS_RAD, abs=1e-6)
        assert line["predicted_amplitude_ratio"] == pytest.approx(line["amplitude_ratio"], rel=1e-4)
        assert line["predicted_lag_rad"] == pytest.approx(line["lag_rad"], rel=1e-4)
        assert 0.05 < line["amplitude_ratio"] < 0.95, "neither followed nor ignored: the case tells"


def test_the_servo_is_forecast_from_the_stiffness_of_the_bed_under_the_true_load(tmp_path):
    servo_run(tmp_path, 200)
    assert math.isnan(find(load_runs(tmp_path), load_references()).servo["forecast_amplitude_ratio"].iloc[0])
    at_rest = ("line", {"a": 1e-3, "b": 0.0})  # no settlement beside the stroke: the loss angle is exact
    write_run(tmp_path, "full", "nonlinear-en1.0", "liggghts", 6, law=at_rest)
    (line,) = find(load_runs(tmp_path), load_references()).servo.to_dict("records")
    bed = cmath.rect(line["true_load_stiffness_N_m"], LOSS_ANGLE_RAD)
    time_constant = line["contact_stiffness_N_m"] * line["gain_step_s"] / (line["gain"] * bed)
    passed = 1 / (1 + 2j * math.pi * 20 * time_constant)
    # history.csv has nine digits
    assert line["forecast_amplitude_ratio"] == pytest.approx(abs(passed), rel=1e-4)
    assert line["forecast_lag_rad"] == pytest.approx(-cmath.phase(passed), rel=1e-4)
    assert line["forecast_amplitude_ratio"] != pytest.approx(line["predicted_amplitude_ratio"], rel=1e-3)


def test_contacts_that_nobody_counted_predict_nothing(tmp_path):
    folder = servo_run(tmp_path, 200)
    structure = pd.read_csv(folder / "microstructure.csv").assign(sleeper_contacts="")
    structure.to_csv(folder / "microstructure.csv", index=False)
    (line,) = find(load_runs(tmp_path), load_references()).servo.to_dict("records")
    assert math.isnan(line["predicted_amplitude_ratio"]) and line["amplitude_ratio"] > 0


def test_a_kept_run_has_the_harmonics_of_its_history(tmp_path):
    folder = servo_run(tmp_path / "results", 200)
    before = load_runs(tmp_path / "results")[0].harmonics
    keep(folder, tmp_path / "kept" / "full" / "nonlinear-en1.0+servo" / "liggghts")
    (kept,) = load_runs(tmp_path / "kept")
    assert not (kept.folder / "history.csv").exists()
    # written with the digits of all normalised files
    np.testing.assert_allclose(kept.harmonics.to_numpy(), before.to_numpy(), rtol=1e-8, atol=1e-12)


def test_readings_are_told_apart_by_the_law_of_the_sleeper(tmp_path):
    folder = servo_run(tmp_path, 200)
    write_run(tmp_path, "full", "nonlinear-en1.0", "liggghts", 6)
    by_reading = {member(run).reading: member(run) for run in load_runs(tmp_path)}
    assert set(by_reading) == {SERVO, TRUE_LOAD}
    assert by_reading[SERVO].scenario == "nonlinear-en1.0" and by_reading[SERVO].run.folder == folder


def test_settlement_by_the_servo_is_split_where_it_was_measured(tmp_path):
    folder = servo_run(tmp_path, 200)
    assert find(load_runs(tmp_path), load_references()).elastic.empty
    (folder / "unload.csv").write_text(file_columns.header(file_columns.UNLOAD) + "1,178000,0.0053,50000,0.0030\n")
    (first,) = find(load_runs(tmp_path), load_references()).elastic.itertuples()
    assert (first.cycle, first.stress_before_Pa, first.settlement_m) == (1, 178000, 0.0053)
    assert first.elastic_m == pytest.approx(0.0023) and first.permanent_m == pytest.approx(0.0030)
    (folder / "unload.csv").write_text("cycle,settlement_m\n1,2\n")
    damaged = load_runs(tmp_path, quiet=True)
    assert find(damaged, load_references()).elastic.empty
    assert any("unload.csv: line 1: column stress_before_Pa is missing" in line for line in damaged.problems)


# ------------------------------------------------------------------ stock contact models


def test_stock_contacts_are_compared_with_the_same_run_by_the_papers_law(tmp_path):
    for name, law in (("linear-mu0.8", 1e-3), ("linear-mu0.8+stock", 1.2e-3)):
        scenario, _, variant = name.partition("+")
        info = {"scenario": scenario, "variant": variant}
        write_run(tmp_path, "full", name, cycles=3, law=("line", {"a": law, "b": 0}), contacts=False, info=info)
    write_run(tmp_path, "full", "linear-mu0.8+stock", "yade", cycles=3, contacts=False, info=info)
    table = find(load_runs(tmp_path), load_references()).stock
    assert set(table["code"]) == {"liggghts"}, "YADE has no run by the paper's law to compare with"
    settled = table[table["quantity"] == "settlement_m"]
    assert list(settled["cycle"]) == [1, 2, 3]
    assert settled["change_ratio"].to_numpy() == pytest.approx([0.2] * 3, rel=1e-6)  # digits of a normalised file


# ------------------------------------------------------------------ bonds


def test_without_a_bonded_run_nothing_is_said_of_bonds(tmp_path):
    write_run(tmp_path, "full", "linear-mu0.8", "liggghts", 6)
    found = find(load_runs(tmp_path), load_references())
    assert found.bonds.empty and answer(found, KEY_SCENARIOS, "full")["bonded"] == {}


def test_bonds_made_and_broken_are_told_at_shown_cycles_and_the_last(tmp_path):
    folder = write_run(tmp_path, "full", "chen2015", "liggghts", 6)
    rows = "".join(f"{n},{100 - 2 * n},{n},{n}\n" for n in range(7))
    (folder / "bonds.csv").write_text("cycle,bonds,bonds_broken_tension,bonds_broken_shear\n" + rows)
    write_run(tmp_path, "full", "linear-mu0.8", "liggghts", 6)
    table = find(load_runs(tmp_path), load_references()).bonds
    assert list(table["cycle"]) == [0, 1, 2, 5, 6] and set(table["scenario"]) == {"chen2015"}
    assert set(table["bonds_made"]) == {100} and table["broken_share"].tolist() == [0, 0.02, 0.04, 0.1, 0.12]


# ------------------------------------------------------------------ influence


def test_influence_is_measured_by_the_scatter_of_seeds(tmp_path):
    for seed, scale in ((1, 1.0), (2, 1.1), (3, 0.9)):
        write_run(tmp_path, "full", "linear-mu0.8", "liggghts", 20, seed, law=exponential(scale))
    for variant in ("plates-fixed", "half-step"):
        write_run(tmp_path, "full", f"linear-mu0.8+{variant}", "liggghts", 20, law=exponential(1.5))
    table = find(load_runs(tmp_path), load_references()).influence
    settled = row(table, quantity="settlement_m")  # of the plates alone: the time step is set beside rounding
    assert settled["variant"] == "plates-fixed" and settled["cycle"] == 20
    assert settled["change_ratio"] == pytest.approx(0.5) and settled["scatters"] == pytest.approx(5.0)


def test_a_thirtieth_is_a_larger_change_than_three_times():
    changes = pd.Series([1.71, -0.97, 0.06])
    assert changes.sort_values(key=size_of_change).tolist() == [0.06, 1.71, -0.97]


def test_the_answer_names_the_changes_to_least_and_most_settlement_that_exceed_the_scatter():
    columns = ["profile", "quantity", "reading", "scenario", "variant", "change_ratio", "scatters"]
    changes = [("a", -0.9, 9), ("b", 2.0, 20), ("c", 5.0, 1), ("d", -0.1, 3)]
    rows = [("full", "settlement_m", "true load", "linear-mu0.8", *change) for change in changes]
    rows += [("full", "settlement_m", "true load", "nonlinear-en1.0", "a", 0.5, 9)]
    found = SimpleNamespace(influence=pd.DataFrame(rows, columns=columns))
    (ends,) = extremes(found, ("linear-mu0.8", "nonlinear-en1.0"), "full")
    assert (ends["least"]["variant"], ends["most"]["variant"]) == ("a", "b")


def test_the_answer_says_when_and_of_what_a_run_failed(tmp_path):
    run = write_run(tmp_path, "full", "linear-mu0.8", "liggghts", 20)
    body = json.loads((run / "run.json").read_text())
    reason = "sleeper through the floor: 0.33 m down at step 7 of cyclic"
    (run / "run.json").write_text(json.dumps(body | {"state": "failed", "reason": f"{DIVERGED}{reason}"}))
    text = " ".join(lines("answer.txt", **answer(find(load_runs(tmp_path), load_references()), KEY_SCENARIOS, "full")))
    assert "; then it fails (sleeper through the floor: 0.33 m down)" in text


# ------------------------------------------------------------------ the README


def test_the_readme_says_what_the_kept_runs_say():
    """`make keep` of further runs takes a `make readme`."""
    now = readme.README.read_text(encoding="utf-8")
    found = find(load_runs(KEPT_RUNS, quiet=True), load_references(), PAPER_SCENARIOS)
    assert readme.with_results(now, found) == now, "run `make readme`"


def test_a_readme_without_its_marks_is_refused(found):
    with pytest.raises(ValueError, match="README.md: the lines .* are missing"):
        readme.with_results("# A project", found)


def test_claims_are_told_of_full_size_runs_alone(tmp_path):
    for profile in ("demo", "full"):
        write_run(tmp_path, profile, "linear-mu0.8", "liggghts", 6, contacts=False)
    both = find(load_runs(tmp_path), load_references(), PAPER_SCENARIOS)
    assert answer(both, KEY_SCENARIOS, "full")["claims"], "each has a verdict"
    assert not answer(both, KEY_SCENARIOS, "demo")["claims"], "the demo's page does not repeat them"


def test_the_sleeper_is_set_beside_published_ballast(found):
    said = lines("engineer.txt", **engineer(found, ("linear-mu0.8",), "full"))
    soft, stiff = (one.value_N_m for one in (ballast_stiffness()[0], ballast_stiffness()[-1]))
    k = found.values.query("quantity == 'secant_stiffness_N_m' and code == 'liggghts'")
    assert soft < stiff and any("secant stiffness" in line for line in said)
    inside = bool(k["low"].min() >= soft and k["high"].max() <= stiff)
    assert any("within the range of published ballast" in line for line in said) == inside
    assert any("20 to 138 kN/mm" in line for line in said)


def test_time_steps_that_differ_are_told():
    kept = [run for run in load_runs(KEPT_RUNS, quiet=True) if run.base_name == "linear-mu0.8" and not run.variants]
    steps = {derived.time_grid(run.scenario).step_s for run in kept}
    assert bool(time_steps(kept)) == (len(steps) > 1) and time_steps(kept[:1]) == ""
