"""Variants over scenarios, the stages that read a key, and the hash that tells runs apart."""

import re

import pytest

from analysis.driver.liggghts import parameter_deck
from analysis.scenarios import derived
from analysis.scenarios.scenario import (
    SCENARIO_FILE,
    Parameter,
    Scenario,
    ScenarioError,
    label_of,
    load_scenario,
    scenario_names,
    split_id,
    variant_names,
)
from analysis.scenarios.schema import FILE_KEYS, KEYS

LINEAR, NONLINEAR = "linear-mu0.8", "nonlinear-en1.0"
FULL_ONLY = ("gap-13.8mm", "gap-14.4mm")
"""Variants whose lattice is too wide for the demo bed."""


def leaf(value, unit="-"):
    return f'{{ value = {value}, unit = "{unit}", status = "assumed", source = "a test" }}'


def with_value(scenario, key, value):
    known = KEYS[key]
    return Scenario(
        scenario.name,
        scenario.profile,
        scenario.title,
        scenario.parameters | {key: Parameter(value, known.unit, "assumed", "a test")},
    )


# ------------------------------------------------------------------ laid over a scenario


@pytest.mark.parametrize("variant", variant_names())
def test_every_variant_can_be_laid_over_every_scenario(variant):
    changed = []
    for name in scenario_names():
        for profile in ("full",) if variant in FULL_ONLY else ("full", "demo"):
            plain, varied = load_scenario(name, profile), load_scenario(name, profile, variant=variant)
            assert varied.id == f"{name}+{variant}"
            changed.append(varied.hash != plain.hash)
            assert changed[-1] == bool(plain.changes(varied))
            assert varied.label == label_of(varied.id) and varied.label.startswith(plain.label)
    assert all(changed) or (any(changed) and variant == "no-bonds")  # which changes nothing where there are no bonds


def test_a_variant_changes_what_it_lists_and_nothing_else():
    plain, servo = load_scenario(NONLINEAR), load_scenario(NONLINEAR, variant="servo")
    assert plain.changes(servo) == [
        "preload.law: loading -> force",
        "load_control.sleeper_law: force -> pfc",
        "load_control.plate_law: force -> pfc",
        "load_control.pfc_gain: 0.3 -> 0.8",
        "load_control.pfc_velocity_limit: 1.0 -> 1000.0",
        "load_control.pfc_update_interval: 20 -> 1",
        "time.step: 1.05e-05 -> 6.3e-06",
    ]


def test_variants_combine_in_any_order_into_one_name():
    texts = ("servo,same-bed", "same-bed,servo", "same-bed+servo", "servo, same-bed,servo")
    scenarios = [load_scenario(LINEAR, variant=text) for text in texts] + [load_scenario(f"{LINEAR}+servo+same-bed")]
    assert {s.id for s in scenarios} == {f"{LINEAR}+same-bed+servo"}
    assert len({s.hash for s in scenarios}) == 1
    assert scenarios[0]["load_control.sleeper_law"] == "pfc" and scenarios[0]["packing.bed_code"] == "liggghts"
    assert split_id(scenarios[0].id) == (LINEAR, ("same-bed", "servo"))


def test_of_two_variants_that_set_one_key_the_later_of_the_file_wins():
    both = load_scenario(NONLINEAR, variant="plates-fixed,servo")
    assert (both["load_control.sleeper_law"], both["load_control.plate_law"]) == ("pfc", "fixed")


def test_a_variant_starts_from_the_bed_of_its_scenario_unless_it_changes_what_is_packed():
    def bed(identity):
        return load_scenario(identity)["packing.bed_from"]

    assert bed(LINEAR) == "" and bed("linear-mu0.7") == LINEAR  # one packed bed for all
    assert bed(f"{LINEAR}+servo") == bed(f"{LINEAR}+series-stiffness") == bed(f"{NONLINEAR}+paper-step") == LINEAR
    assert bed(f"{LINEAR}+aspect-1.5") == ""
    assert bed(f"{LINEAR}+aspect-1.5+servo") == bed(f"{NONLINEAR}+aspect-1.5+servo") == f"{LINEAR}+aspect-1.5"
    assert bed(f"{LINEAR}+aspect-1.5+gap-13.8mm") == ""


def test_a_variant_survives_the_json_form_of_its_scenario():
    s = load_scenario(NONLINEAR, "demo", variant="servo,same-bed")
    again = Scenario.from_json(s.to_json())
    assert (again.id, again.variants, again.label, again.hash) == (s.id, s.variants, s.label, s.hash)


@pytest.mark.parametrize(
    "name, variant, words",
    [
        (LINEAR, "servos", ["variant 'servos' is unknown, perhaps servo", "known: servo, servo-gain0.3"]),
        (f"{LINEAR}+none", "", ["variant 'none' is unknown"]),
        ("linear-mu0.6+servo", "", ["scenario 'linear-mu0.6' is unknown, perhaps linear-mu0."]),
    ],
)
def test_an_unknown_variant_is_answered_by_the_known_ones(name, variant, words):
    with pytest.raises(ScenarioError) as caught:
        load_scenario(name, variant=variant)
    assert all(word in str(caught.value) for word in words) and "\n" not in str(caught.value)


def test_a_variant_of_ones_own_is_added_by_a_few_lines(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        SCENARIO_FILE.read_text() + f'\n[variant.heavy]\nlabel = "heavy"\nclump.density = {leaf(3000.0, "kg/m3")}\n'
    )
    heavy = load_scenario(NONLINEAR, path=path, variant="heavy,servo")
    assert heavy["clump.density"] == 3000 and heavy.label.endswith(", heavy")
    assert heavy["packing.bed_from"] == f"{LINEAR}+heavy"
    bad = tmp_path / "bad.toml"
    bad.write_text(path.read_text().replace("clump.density = { value = 3000.0", "clump.density = { value = -1.0"))
    with pytest.raises(ScenarioError, match=r"variant\.heavy\.clump\.density\.value = -1.0 is refused"):
        load_scenario(NONLINEAR, path=bad, variant="heavy")


def test_the_variant_in_the_contributing_guide_works(tmp_path):
    guide = SCENARIO_FILE.with_name("CONTRIBUTING.md").read_text().split("### A new variant")[1]
    path = tmp_path / "guide.toml"
    path.write_text(SCENARIO_FILE.read_text() + "\n" + re.search(r"```toml\n(.*?)```", guide, re.DOTALL)[1])
    (added,) = set(variant_names(path)) - set(variant_names())
    varied = load_scenario(LINEAR, "demo", path=path, variant=f"{added},servo")
    assert load_scenario(LINEAR, "demo", variant="servo").changes(varied) and "light clumps" in varied.label


# ------------------------------------------------------------------ the time step


@pytest.mark.parametrize("name, paper, verified", [(LINEAR, 2.9e-6, 4.8e-6), (NONLINEAR, 6.3e-6, 1.05e-5)])
def test_the_choice_of_the_time_step_decides_the_step_and_never_the_gain_of_the_servo(name, paper, verified):
    plain, chosen = load_scenario(name), load_scenario(name, variant="paper-step")
    assert (plain["time.step"], chosen["time.step"]) == (verified, paper)
    assert derived.time_grid(plain).step_s == pytest.approx(verified, rel=0.01)
    assert derived.time_grid(chosen).step_s == pytest.approx(paper, rel=0.01)
    assert derived.pfc_time_step(plain) == derived.pfc_time_step(chosen) == paper
    half = load_scenario(name, variant="half-step,paper-step")
    assert half["time.step"] == paper / 2 and plain.changed_keys(half, "preload") == ["time.step"]


def test_both_readings_are_preloaded_by_force_and_only_walls_that_the_servo_moves_change_their_law():
    def laws(variant):
        s = load_scenario(NONLINEAR, variant=variant)
        return [tuple(derived.wall_laws(s, stage).values()) for stage in ("preload", "cyclic")]

    assert laws("") == [("force", "force")] * 2
    assert laws("servo") == [("force", "force"), ("pfc", "pfc")]
    assert laws("servo,plates-fixed") == [("force", "fixed"), ("pfc", "fixed")]
    assert laws("plates-pfc") == [("force", "pfc")] * 2


@pytest.mark.parametrize("name", [LINEAR, NONLINEAR])
def test_no_servo_gain_step_means_the_step_of_the_run(name):
    s = with_value(load_scenario(name), "load_control.pfc_time_step", 0.0)
    assert derived.pfc_time_step(s) == derived.time_grid(s).step_s


# ------------------------------------------------------------------ stages and hash


def test_every_key_says_from_which_stage_on_it_matters():
    for name in FILE_KEYS:
        key = KEYS[name]
        assert (key.since in ("packing", "preload", "loading", "output", "limit")) or name.startswith("time."), name
        assert not name.startswith("output.keep") or not key.matters("packing", "loading")
    assert KEYS["time.step"].matters("packing", "packing")


@pytest.mark.parametrize(
    "key, value, stages",
    [
        ("packing.relax_steps", 5, ("packing", "packing")),
        ("contact.particle_particle.shear_modulus", 1e6, ("preload", "loading")),
        ("load_control.pfc_gain", 0.5, ("preload", "loading")),
        ("loading.local_damping", 0.1, ("loading", "loading")),
        ("output.rows_per_cycle", 80, ("packing", "loading")),
        ("output.keep_beds", [7], ("output", "output")),
        ("limits.kinetic_energy", 1.0, ("limit", "limit")),
        ("loading.cycles", 7, ("limit", "limit")),
    ],
)
def test_a_change_is_seen_from_the_stages_that_read_the_key_and_from_no_other(key, value, stages):
    order = ("packing", "preload", "loading", "output", "limit")
    here = load_scenario(NONLINEAR)
    there = with_value(here, key, value)
    since, until = map(order.index, stages)
    for number, stage in enumerate(order):
        assert here.changed_keys(there, stage, stage) == ([key] if since <= number <= until else []), stage
    physics = since < order.index("output")
    assert (here.hash != there.hash) == physics
    assert bool(here.changes(there)) == physics


def test_the_hash_is_that_of_the_step_that_runs_not_of_the_choice():
    verified = load_scenario(LINEAR)
    paper = with_value(with_value(verified, "time.verified_step", 1e-6), "time.choice", "verified")
    assert paper.hash == verified.hash  # the other step, and how it was chosen, are no physics
    assert load_scenario(LINEAR, variant="paper-step").hash != verified.hash


def test_a_key_that_is_newer_than_a_run_has_the_value_that_the_run_had():
    s = load_scenario(NONLINEAR)
    older = {key: p for key, p in s.parameters.items() if KEYS[key].neutral is None}
    assert len(older) < len(s.parameters)
    again = Scenario.from_json(Scenario(s.name, s.profile, s.title, older).to_json())
    assert again.changed_keys(s) == ["load_control.pfc_time_step"]
    assert again.hash == Scenario(s.name, s.profile, s.title, older).hash


# ------------------------------------------------------------------ what the engines are told


def test_liggghts_gets_every_new_parameter():
    text = parameter_deck(load_scenario(NONLINEAR, variant="damped,limit-rule,smooth-walls,sphere-mass"), 1)
    lines = dict(
        line.partition("#")[0].strip().split(" index ") for line in text.splitlines() if line.startswith("variable ")
    )
    assert lines["variable loading_local_damping"] == '"0.7"'
    assert lines["variable contact_dashpot_limit"] == lines["variable contact_dashpot_mass_share"] == '"0.5"'
    assert lines["variable contact_side_friction_share"] == '"0.0"'
    assert lines["variable load_control_pfc_time_step"] == '"6.3e-06"'
