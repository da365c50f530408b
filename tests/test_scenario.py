"""The scenario file: what the loader accepts, what it refuses and in which words, and what follows from a scenario."""

import json
import math
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from analysis.scenarios import derived
from analysis.scenarios.lattice import lattice_bed, site_count
from analysis.scenarios.scenario import (
    SCENARIO_FILE,
    Scenario,
    ScenarioError,
    load_scenario,
    profile_names,
    scenario_names,
)
from analysis.scenarios.schema import KEYS, PROFILE_KEYS, STATUSES

PAPER_SCENARIOS = [
    "linear-mu0.7",
    "linear-mu0.8",
    "linear-mu0.9",
    "nonlinear-en1.0",
    "nonlinear-md0-en0.3",
    "nonlinear-md0-en0.6",
    "nonlinear-md0-en0.9",
    "nonlinear-md1-en0.0",
    "nonlinear-md1-en0.3",
    "nonlinear-md1-en0.6",
    "nonlinear-md1-en0.9",
    "nonlinear-md2-en0.3",
    "nonlinear-md2-en0.6",
    "nonlinear-md2-en0.9",
]


@pytest.fixture
def write(tmp_path):
    """Write a scenario file and return its path."""

    def _write(text, name="mine.toml"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return _write


@pytest.fixture(scope="module")
def paper():
    return SCENARIO_FILE.read_text()


def changed(text, key, value):
    """The file with the value of `key` in [base.<table>] replaced by the TOML text `value`."""
    table, name = key.rsplit(".", 1)
    head, tail = text.split(f"[base.{table}]", 1)
    tail, count = re.subn(rf"(?m)^({name} *= {{ value = )(\[.*?\]|[^,]+)", lambda m: m[1] + value, tail, count=1)
    assert count == 1
    return f"{head}[base.{table}]{tail}"


def with_scenario(text, body):
    """The file with a scenario `mine` added at the end."""
    return text + f'\n[scenario.mine]\ntitle = "mine"\n{body}\n'


def leaf(value, unit="-", status="assumed", source="a test"):
    return f'{{ value = {value}, unit = "{unit}", status = "{status}", source = "{source}" }}'


# ------------------------------------------------------------------ good files


@pytest.mark.parametrize("profile", ["full", "demo"])
@pytest.mark.parametrize("name", PAPER_SCENARIOS)
def test_every_scenario_of_the_paper_loads_at_every_profile(name, profile):
    s = load_scenario(name, profile)
    assert set(s.parameters) == set(KEYS)
    assert all(p.unit == KEYS[key].unit and p.status in STATUSES and p.source for key, p in s.parameters.items())


def test_the_file_holds_the_scenarios_and_profiles_of_the_paper():
    assert set(PAPER_SCENARIOS) <= set(scenario_names())
    assert {"full", "demo"} <= set(profile_names())


@pytest.mark.parametrize(
    "name, expected",
    [
        (
            "linear-mu0.7",
            {
                "contact.model": "linear",
                "contact.particle_particle.friction": 0.7,
                "contact.particle_wall.friction": 0.7,
                "contact.particle_wall.normal_stiffness": 1e9,
                "contact.particle_wall.damping_ratio": 0.0,
                "time.paper_step": 2.9e-6,
                "load_control.pfc_time_step": 2.9e-6,
            },
        ),
        (
            "nonlinear-en1.0",
            {
                "contact.model": "hysteretic",
                "contact.particle_particle.friction": 0.75,
                "contact.particle_wall.friction": 0.9,
                "contact.particle_wall.normal_stiffness": 1e8,
                "contact.particle_wall.damping_ratio": 0.06,
                "contact.particle_particle.restitution": 1.0,
                "time.paper_step": 6.3e-6,
                "load_control.pfc_time_step": 6.3e-6,
                "packing.bed_from": "linear-mu0.8",
            },
        ),
        (
            "nonlinear-md2-en0.3",
            {
                "contact.model": "hysteretic",
                "contact.particle_particle.damping_mode": 2,
                "contact.particle_particle.restitution": 0.3,
                "contact.particle_wall.friction": 0.9,
                "contact.particle_particle.shear_modulus": 35e6,
                "contact.particle_particle.poisson_ratio": 0.3,
            },
        ),
    ],
)
def test_a_scenario_has_the_values_of_the_papers_tables(name, expected):
    s = load_scenario(name)
    assert {key: s[key] for key in expected} == expected


@pytest.mark.parametrize("name", PAPER_SCENARIOS[4:])
def test_the_name_of_a_damped_scenario_tells_its_mode_and_restitution(name):
    mode, restitution = re.fullmatch(r"nonlinear-md(\d)-en(\d\.\d)", name).groups()
    s = load_scenario(name)
    assert s["contact.particle_particle.damping_mode"] == int(mode)
    assert s["contact.particle_particle.restitution"] == float(restitution)


def test_a_scenario_is_added_by_a_few_lines(paper, write):
    path = write(with_scenario(paper, 'base = "nonlinear-en1.0"\ncontact.particle_particle.friction = ' + leaf(0.6)))
    mine, parent = load_scenario("mine", path=path), load_scenario("nonlinear-en1.0", path=path)
    assert parent.differences(mine) == ["contact.particle_particle.friction: 0.75 -> 0.6"]
    assert mine.title == "mine" and mine.parameters["contact.particle_particle.friction"].source == "a test"
    assert "mine" in scenario_names(path)


def test_the_example_in_the_contributing_guide_works(paper, write):
    guide = SCENARIO_FILE.with_name("CONTRIBUTING.md").read_text()
    example = re.search(r"```toml\n(.*?)```", guide, re.DOTALL)[1]
    path = write(paper + "\n" + example)
    (added,) = set(scenario_names(path)) - set(scenario_names())
    parent = load_scenario("nonlinear-en1.0", path=path)
    assert len(parent.differences(load_scenario(added, "demo", path=path, cycles=1000))) >= 1


def test_a_scenario_without_any_difference_is_the_base(paper, write):
    path = write(paper + "\n[scenario.plain]\n")
    plain = load_scenario("plain", path=path)
    assert plain.differences(load_scenario("linear-mu0.8", path=path)) == []
    assert plain.title == "plain"


def test_later_layers_win_base_then_parent_then_scenario_then_profile(paper, write):
    text = with_scenario(
        paper, f'base = "linear-mu0.9"\ncontact.particle_wall.friction = {leaf(0.5)}\nloading.cycles = {leaf(7)}'
    )
    path = write(text)
    full, demo = load_scenario("mine", path=path), load_scenario("mine", "demo", path=path)
    assert full["contact.particle_particle.friction"] == 0.9  # of the parent, not of base (0.8)
    assert full["contact.particle_wall.friction"] == 0.5  # its own, not the parent's
    assert (full["loading.cycles"], demo["loading.cycles"]) == (7, 5)
    assert load_scenario("mine", "demo", path=path, cycles=3)["loading.cycles"] == 3


def test_whole_numbers_are_accepted_where_a_number_is_wanted_and_mean_the_same(paper, write):
    whole = write(changed(changed(paper, "clump.density", "2600"), "packing.relax_stiffness", "[1e-3, 1e-2, 1e-1, 1]"))
    s = load_scenario("linear-mu0.8", path=whole)
    assert isinstance(s["clump.density"], float)
    assert s.hash == load_scenario("linear-mu0.8").hash


def test_the_hash_changes_with_a_value_and_only_with_a_value(paper, write):
    original = load_scenario("linear-mu0.8")
    other_words = write(paper.replace("Table 1", "the first table"), "words.toml")
    other_value = write(changed(paper, "clump.density", "2601.0"), "value.toml")
    assert load_scenario("linear-mu0.8", path=other_words).hash == original.hash
    assert load_scenario("linear-mu0.8", path=other_value).hash != original.hash
    assert re.fullmatch("[0-9a-f]{12}", original.hash)
    hashes = [load_scenario(name, profile).hash for name in PAPER_SCENARIOS for profile in ("full", "demo")]
    # linear-mu0.8 is the base; every other scenario and profile differs from all the rest
    assert len(set(hashes)) == len(hashes)


def test_a_scenario_survives_its_json_form():
    s = load_scenario("nonlinear-md2-en0.6", "demo")
    again = Scenario.from_json(s.to_json())
    assert (again.name, again.profile, again.title, again.hash) == (s.name, s.profile, s.title, s.hash)
    assert again.parameters == s.parameters
    assert json.loads(s.to_json())["hash"] == s.hash


def test_the_loader_needs_the_standard_library_only():
    code = (
        "import sys; sys.path.insert(0, '.'); from analysis.scenarios import derived, lattice, scenario; "
        "lattice.lattice_bed(scenario.load_scenario('linear-mu0.8', 'demo'), 1)"
    )
    # -S leaves out site-packages
    done = subprocess.run([sys.executable, "-S", "-c", code], cwd=SCENARIO_FILE.parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


# ------------------------------------------------------------------ bad files


def _base(key, value):
    return lambda text: changed(text, key, value)


def _mine(body):
    return lambda text: with_scenario(text, body)


def _entry(key, entry):
    return _mine(f"{key} = {entry}")


def _replace(old, new):
    def edit(text):
        assert old in text
        return text.replace(old, new, 1)

    return edit


G, P, PP = "geometry", "packing", "contact.particle_particle"

# what is wrong: (edit, what the line must name: key, value, and what is allowed)
BAD = {
    # structure and units
    "not TOML": (lambda t: t + "\n[[[", ["not valid TOML"]),
    "not UTF-8": (lambda t: t.encode() + b"\n# \xff\xfe", ["not valid TOML"]),
    "empty file": (lambda t: "", ["base", "null", "a table [base]"]),
    "unknown section": (
        lambda t: t + "\n[scenarios.mine]\n",
        ["scenarios", "the sections base, scenario, profile, variant, study"],
    ),
    "no profiles": (lambda t: t.split("[profile.full]")[0], ["profile", "a table [profile]"]),
    "missing key": (_replace("clump]\nball_radius", "clump]\n#ball_radius"), ["base.clump.ball_radius", "missing"]),
    "misspelt key": (
        _entry(f"{PP}.fricton", leaf(0.5)),
        [f"scenario.mine.{PP}.fricton", "perhaps contact.particle_particle.friction"],
    ),
    "unknown table": (_entry("weather.rain", leaf(1)), ["scenario.mine.weather.rain", "a known key"]),
    "empty unknown table": (lambda t: t + "\n[scenario.mine.contcat]\n", ["scenario.mine.contcat", "a known key"]),
    "bare value": (
        _entry(f"{PP}.friction", "0.5"),
        [f"{PP}.friction", "0.5", "exactly value, unit, status and source"],
    ),
    "no source": (
        _entry(f"{PP}.friction", '{ value = 0.5, unit = "-", status = "assumed" }'),
        [f"{PP}.friction", "exactly value, unit, status and source"],
    ),
    "no value": (
        _entry(f"{PP}.friction", '{ unit = "-", status = "assumed", source = "x" }'),
        [f"{PP}.friction", "exactly value, unit, status and source"],
    ),
    "extra field": (
        _entry(f"{PP}.friction", '{ value = 0.5, unit = "-", status = "assumed", source = "x", note = "y" }'),
        [f"{PP}.friction", "exactly value"],
    ),
    "empty source": (_entry(f"{PP}.friction", leaf(0.5, source=" ")), [f"{PP}.friction.source", "not empty"]),
    "unknown status": (
        _entry(f"{PP}.friction", leaf(0.5, status="guessed")),
        [f"{PP}.friction.status", "guessed", "reported, derived, assumed, calibrated"],
    ),
    "wrong unit": (_entry("clump.ball_radius", leaf(18.5, unit="mm")), ["clump.ball_radius.unit", "mm", '"m"']),
    "scenario is no table": (
        lambda t: t.replace("[base.geometry]", "scenario.mine = 5\n[base.geometry]"),
        ["scenario.mine", "5", "a table"],
    ),
    "title is no text": (lambda t: t + "\n[scenario.mine]\ntitle = 5\n", ["scenario.mine.title", "5", "a text"]),
    "base is no text": (_mine("base = 5"), ["scenario.mine.base", "5", "a text"]),
    "base is unknown": (_mine('base = "nonlinear"'), ["scenario.mine.base", "nonlinear", "nonlinear-en1.0"]),
    "bases go in a circle": (
        lambda t: with_scenario(t, 'base = "other"') + '\n[scenario.other]\nbase = "mine"\n',
        ["scenario.other.base", "mine", "without a circle"],
    ),
    "name is a path": (lambda t: with_scenario(t, "") + '\n[scenario."../up"]\n', ["../up", "letters, digits"]),
    "profile changes physics": (
        lambda t: t + f"\n[profile.full.contact.particle_particle]\nfriction = {leaf(0.5)}\n",
        [f"profile.full.{PP}.friction", "0.5", "size and length only", *PROFILE_KEYS],
    ),
    # types
    "text for a number": (
        _entry("time.paper_step", leaf('"fast"', unit="s")),
        ["time.paper_step.value", "fast", "a number"],
    ),
    "number for a text": (_entry("contact.model", leaf(1)), ["contact.model.value", "1", "linear, hysteretic"]),
    "truth for a number": (_entry(f"{PP}.friction", leaf("true")), [f"{PP}.friction.value", "true", "a number"]),
    "fraction for a count": (_entry("loading.cycles", leaf(10.5)), ["loading.cycles.value", "10.5", "a whole number"]),
    "number for a list": (
        _entry(f"{G}.measurement_x", leaf(0.4, unit="m")),
        [f"{G}.measurement_x.value", "0.4", "a list of numbers"],
    ),
    "empty list": (_entry("output.keep_beds", leaf("[]")), ["output.keep_beds.value", "[]", "a list of whole numbers"]),
    "fraction in a list of counts": (
        _entry("output.keep_beds", leaf("[1, 2.5]")),
        ["output.keep_beds.value", "2.5", "whole numbers"],
    ),
    "text in a list": (
        _entry(f"{P}.relax_stiffness", leaf('[0.1, "one"]')),
        [f"{P}.relax_stiffness.value", "one", "a list of numbers"],
    ),
    "date for a number": (
        _entry("time.paper_step", leaf("2021-11-06", unit="s")),
        ["time.paper_step.value", "2021-11-06", "a number"],
    ),
    # limits
    "negative time step": (
        _entry("time.paper_step", leaf("-1e-6", unit="s")),
        ["time.paper_step.value", "-1e-06", ">= 1e-09"],
    ),
    "zero time step": (_entry("time.paper_step", leaf("0.0", unit="s")), ["time.paper_step.value", "0.0", ">= 1e-09"]),
    "not a number": (
        _entry("clump.density", leaf("nan", unit="kg/m3")),
        ["clump.density.value", "NaN", "a number >= 1"],
    ),
    "infinite": (
        _entry(f"{PP}.shear_modulus", leaf("inf", unit="Pa")),
        [f"{PP}.shear_modulus.value", "Infinity", "a number >= 1"],
    ),
    "too large for a double": (
        _entry(f"{PP}.shear_modulus", leaf("1" + "0" * 400, unit="Pa")),
        [f"{PP}.shear_modulus.value", "a number >= 1"],
    ),
    "negative friction": (_entry(f"{PP}.friction", leaf(-0.1)), [f"{PP}.friction.value", "-0.1", ">= 0"]),
    "restitution above one": (_entry(f"{PP}.restitution", leaf(1.1)), [f"{PP}.restitution.value", "1.1", "<= 1"]),
    "incompressible": (_entry(f"{PP}.poisson_ratio", leaf(0.5)), [f"{PP}.poisson_ratio.value", "0.5", "<= 0.49"]),
    "unknown damping mode": (
        _entry(f"{PP}.damping_mode", leaf(3)),
        [f"{PP}.damping_mode.value", "3", "one of 0, 1, 2"],
    ),
    "unknown contact model": (
        _entry("contact.model", leaf('"hertz"')),
        ["contact.model.value", "hertz", "one of linear, hysteretic"],
    ),
    "time step itself": (
        _entry("time.step", leaf(1e-6, unit="s")),
        ["scenario.mine.time.step", "nothing: it is made from time.paper_step or time.verified_step"],
    ),
    "unknown choice of the step": (
        _entry("time.choice", leaf('"half"')),
        ["time.choice.value", "half", "paper, verified"],
    ),
    "unknown group": (_mine('group = "mine"'), ["scenario.mine.group", "mine", "one of paper, chen2015, own"]),
    "name of two variants": (lambda t: t + '\n[variant."a+b"]\n', ["variant name", "a+b", "letters, digits"]),
    "unknown plate law": (
        _entry("load_control.plate_law", leaf('"servo"')),
        ["load_control.plate_law.value", "servo", "one of force, pfc, fixed"],
    ),
    "aspect of two separate balls": (_entry("clump.aspect", leaf(2.5)), ["clump.aspect.value", "2.5", "<= 2"]),
    "aspect of one ball": (_entry("clump.aspect", leaf(1.0)), ["clump.aspect.value", "1.0", "> 1"]),
    "zero cycles": (_entry("loading.cycles", leaf(0)), ["loading.cycles.value", "0", ">= 1"]),
    "too few output rows": (_entry("output.rows_per_cycle", leaf(16)), ["output.rows_per_cycle.value", "16", ">= 40"]),
    "box wider than the box": (
        lambda t: t + f"\n[profile.full.geometry]\nwidth_scale = {leaf(1.5)}\n",
        ["geometry.width_scale.value", "1.5", "<= 1"],
    ),
    # impossible together
    "singular damping": (
        _mine(f'base = "nonlinear-en1.0"\n{PP}.damping_mode = {leaf(0)}\n{PP}.restitution = {leaf("0.0")}'),
        [f"{PP}.restitution", "0.0", "singular"],
    ),
    "load falls where it should rise": (
        _entry("loading.stress_max", leaf(40e3, unit="Pa")),
        ["loading.stress_max", "40000.0", "> loading.stress_min = 50000"],
    ),
    "preload is not the least load": (
        _entry("preload.sleeper_stress", leaf(60e3, unit="Pa")),
        ["preload.sleeper_stress", "60000.0", "loading.stress_min"],
    ),
    "sleeper longer than the box": (
        _entry(f"{G}.sleeper_length", leaf(0.9, unit="m")),
        [f"{G}.sleeper_length", "0.9", "<= geometry.box_length"],
    ),
    "sleeper as wide as the box": (
        _entry(f"{G}.sleeper_width", leaf(0.6, unit="m")),
        [f"{G}.sleeper_width", "0.6", "< geometry.box_width"],
    ),
    "sleeper above the box": (
        _entry(f"{G}.sleeper_height", leaf(0.2, unit="m")),
        [f"{G}.sleeper_height", "0.2", "not above the box"],
    ),
    "plate outside the box": (
        _entry(f"{G}.plate_height", leaf(0.1, unit="m")),
        [f"{G}.plate_height", "0.1", "inside the box"],
    ),
    "clumps fall through the plates' gap": (
        _mine(
            f"{G}.plate_gap = {leaf(0.01, unit='m')}\nclump.ball_radius = {leaf(0.006, unit='m')}\n"
            f"{P}.lattice_radius = {leaf(0.00375, unit='m')}"
        ),
        [f"{G}.plate_gap", "0.01", "radius"],
    ),
    "measurement sphere outside the box": (
        _entry(f"{G}.measurement_x", leaf("[0.1, 0.4, 0.666]", unit="m")),
        [f"{G}.measurement_x", "0.1", "inside the box"],
    ),
    "two measurement spheres": (
        _entry(f"{G}.measurement_x", leaf("[0.2, 0.6]", unit="m")),
        [f"{G}.measurement_x", "three values"],
    ),
    "measurement sphere in the sleeper": (
        _entry(f"{G}.measurement_z", leaf(0.25, unit="m")),
        [f"{G}.measurement_z", "0.25", "between floor and sleeper base"],
    ),
    "growth misses the ball": (_entry(f"{P}.growth", leaf(1.5)), [f"{P}.growth", "1.5", "0.0185"]),
    "relaxation ends soft": (_entry(f"{P}.relax_stiffness", leaf("[0.1, 0.5]")), [f"{P}.relax_stiffness", "end at 1"]),
    "porosity of nothing": (
        _entry(f"{P}.lattice_gap", leaf("0.0", unit="m")),
        [f"{P}.lattice_gap", "0.0", "more than the whole box"],
    ),
    "porosity of one": (
        _entry(f"{P}.lattice_gap", leaf(0.9, unit="m")),
        [f"{P}.lattice_gap", "0.9", "at most 0.6, here 1"],
    ),
    "no clump fits the slice": (
        lambda t: t + f"\n[profile.full.geometry]\nwidth_scale = {leaf(0.05)}\n",
        ["geometry.width_scale", "0.05", "one clump"],
    ),
    "rows and blocks do not meet": (
        _entry("output.rows_per_cycle", leaf(50)),
        ["output.rows_per_cycle", "50", "a multiple of"],
    ),
    "step above the critical one": (
        _entry("time.verified_step", leaf(2e-5, unit="s")),
        ["time.step", "2e-05", "critical"],
    ),
    "rounding makes the step critical": (
        _mine(f"loading.frequency = {leaf('900.0', unit='Hz')}\ntime.verified_step = {leaf(1.66e-5, unit='s')}"),
        ["time.step", "1.66e-05", "critical"],
    ),
    "bed of an unknown scenario": (
        _entry(f"{P}.bed_from", leaf('"linear"')),
        [f"{P}.bed_from", "linear", "linear-mu0.8"],
    ),
    "bed of itself": (_entry(f"{P}.bed_from", leaf('"mine"')), [f"{P}.bed_from", "mine", "another scenario"]),
    "bed of a scenario that makes none": (
        _entry(f"{P}.bed_from", leaf('"nonlinear-en1.0"')),
        [f"{P}.bed_from", "nonlinear-en1.0", "packs its own bed"],
    ),
    "bed of other clumps": (
        _mine(f'base = "nonlinear-en1.0"\nclump.aspect = {leaf(1.5)}'),
        [f"{P}.bed_from", "linear-mu0.8", "clump.aspect"],
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_file_is_refused_in_one_line_that_names_file_key_and_remedy(case, paper, write):
    edit, words = BAD[case]
    text = edit(paper)
    path = write(text)
    with pytest.raises(ScenarioError) as caught:
        load_scenario("mine" if "scenario.mine" in str(text) else "linear-mu0.8", path=path)
    message = str(caught.value)
    assert "\n" not in message and message.startswith("mine.toml: ")
    for word in words:
        assert word in message
    assert len(message) < 1000


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(ScenarioError, match=r"^none\.toml: cannot be read \(No such file or directory\)"):
        load_scenario("linear-mu0.8", path=tmp_path / "none.toml")


def test_a_scenario_whose_name_lacks_its_quotes_is_told_so(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(SCENARIO_FILE.read_text() + '\n[scenario.linear-mu0.6]\nbase = "linear-mu0.8"\n')
    with pytest.raises(
        ScenarioError, match=r's\.toml: scenario\.linear-mu0\.6: put the name in quotes, \[scenario\."linear'
    ):
        load_scenario("linear-mu0.6", path=path)


@pytest.mark.parametrize(
    "name, profile, message",
    [
        ("linear", "full", "scenario 'linear' is unknown, perhaps linear-mu0."),
        ("linear-mu0.8", "tiny", "profile 'tiny' is unknown; known: full, demo"),
    ],
)
def test_an_unknown_scenario_or_profile_is_answered_by_the_known_ones(name, profile, message):
    with pytest.raises(ScenarioError) as caught:
        load_scenario(name, profile)
    assert message in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("cycles", [0, -5, 2.5, "many", True])
def test_impossible_cycles_on_the_command_line_are_refused(cycles):
    with pytest.raises(ScenarioError, match=r"CYCLES\.loading\.cycles\.value"):
        load_scenario("linear-mu0.8", cycles=cycles)


# ------------------------------------------------------------------ what follows from a scenario


def with_aspect(aspect):
    s = load_scenario("linear-mu0.8")
    parameters = s.parameters | {"clump.aspect": replace(s.parameters["clump.aspect"], value=aspect)}
    return Scenario(s.name, s.profile, s.title, parameters)


def integrated_clump(radius, half_distance, density, points=400):
    """Mass, volume and inertias of the union of two spheres, by midpoint sums over rings (axis, distance)."""
    end = radius + half_distance
    z = (np.arange(points) + 0.5) / points * 2 * end - end
    rho = (np.arange(points) + 0.5) / points * radius
    z, rho = np.meshgrid(z, rho, indexing="ij")
    solid = rho**2 + (np.abs(z) - half_distance) ** 2 < radius**2
    ring = np.where(solid, 2 * np.pi * rho, 0.0) * (2 * end / points) * (radius / points)
    volume = ring.sum()
    axial = density * (ring * rho**2).sum()
    return volume, density * volume, axial, axial / 2 + density * (ring * z**2).sum()


@pytest.mark.parametrize("aspect", [1.5, 1.75, 1.875, 2.0])
def test_clump_mass_volume_and_inertia_are_those_of_the_union(aspect):
    s = with_aspect(aspect)
    c = derived.clump(s)
    assert c.half_distance_m / c.radius_m == pytest.approx(aspect - 1)
    measured = c.volume_m3, c.mass_kg, c.inertia_axial_kgm2, c.inertia_transverse_kgm2
    assert measured == pytest.approx(integrated_clump(c.radius_m, c.half_distance_m, s["clump.density"]), rel=1e-3)
    assert c.volume_m3 == pytest.approx(4 / 3 * math.pi * 0.0185**3, rel=1e-12)


@pytest.mark.parametrize(
    "aspect, radius_mm, axial, transverse",
    [
        (1.875, 14.739, 6.0465e-6, 1.76519e-5),
        (1.75, 14.900, 6.2959e-6, 1.53378e-5),
        (1.5, 15.539, 7.0764e-6, 1.22797e-5),
    ],
)
def test_clumps_have_the_published_radius_and_inertia(aspect, radius_mm, axial, transverse):
    c = derived.clump(with_aspect(aspect))
    assert c.radius_m * 1e3 == pytest.approx(radius_mm, abs=5e-4)
    assert c.mass_kg == pytest.approx(0.068957, abs=5e-7)
    assert c.inertia_axial_kgm2 == pytest.approx(axial, rel=1e-5)
    assert c.inertia_transverse_kgm2 == pytest.approx(transverse, rel=1e-5)


@pytest.mark.parametrize("name, steps", [("linear-mu0.8", 17241), ("nonlinear-en1.0", 7937)])
def test_a_cycle_has_the_papers_steps_to_one_per_cent_and_divides_into_rows_and_blocks(name, steps):
    s = load_scenario(name, variant="paper-step")
    grid = derived.time_grid(s)
    assert grid.steps_per_cycle == pytest.approx(steps, rel=0.01)
    assert grid.step_s * grid.steps_per_cycle == pytest.approx(1 / 20, rel=1e-14)
    assert grid.steps_per_row * s["output.rows_per_cycle"] == grid.steps_per_cycle
    assert grid.steps_per_block * s["output.blocks_per_cycle"] == grid.steps_per_cycle
    assert grid.steps_per_block % grid.steps_per_row == 0
    assert grid.steps_per_cycle % (2 * grid.steps_per_row) == 0  # peak load falls on a row


def test_loads_and_volumes_of_the_full_apparatus():
    box = derived.apparatus(load_scenario("linear-mu0.8"))
    assert box.sleeper_area_m2 * 50e3 == pytest.approx(10.40e3)
    assert box.sleeper_area_m2 * 460e3 == pytest.approx(95.68e3)
    assert box.plate_area_m2 * 10e3 == pytest.approx(384)
    assert box.ballast_volume_m3 == pytest.approx(0.1968, abs=5e-5)
    solid = 4583 * derived.clump(load_scenario("linear-mu0.8")).volume_m3
    assert 1 - solid / box.ballast_volume_m3 == pytest.approx(0.382, abs=5e-4)


def test_plates_fill_the_face_up_to_the_fixed_wall_with_their_gaps():
    box = derived.apparatus(load_scenario("linear-mu0.8"))
    assert [p.low[2] for p in box.plates] == pytest.approx([0, 0.065, 0.130, 0.195, 0.260])
    assert [p.high[2] - p.low[2] for p in box.plates] == pytest.approx([0.064] * 5)
    assert box.plates[-1].high[2] == pytest.approx(0.324) and box.fixed_wall.low[2] == pytest.approx(0.325)
    assert all(p.low[0] == 0.8 for p in (*box.plates, box.fixed_wall))
    assert box.sleeper.low == pytest.approx((0, 0.17, 0.325)) and box.sleeper.high == pytest.approx((0.8, 0.43, 0.475))


def test_a_narrower_box_narrows_sleeper_plates_and_control_in_one_ratio():
    full, scale = load_scenario("linear-mu0.8"), 0.5
    narrow = full.with_values({"geometry.width_scale": scale})
    a, b = derived.apparatus(full), derived.apparatus(narrow)
    assert b.width_m == pytest.approx(scale * a.width_m) and (b.length_m, b.height_m) == (a.length_m, a.height_m)
    for small, large in (
        (b.sleeper_area_m2, a.sleeper_area_m2),
        (b.plate_area_m2, a.plate_area_m2),
        (b.ballast_volume_m3, a.ballast_volume_m3),
        (b.sleeper.high[1] - b.sleeper.low[1], a.sleeper.high[1] - a.sleeper.low[1]),
    ):
        assert small == pytest.approx(scale * large)
    assert b.sleeper.low[1] + b.sleeper.high[1] == pytest.approx(b.width_m)  # centred
    assert {k: pytest.approx(scale * v) for k, v in derived.load_control(full).items()} == derived.load_control(narrow)


def test_the_demo_bed_holds_a_third_of_the_clumps():
    s = load_scenario("linear-mu0.8", "demo")
    assert 1000 <= len(lattice_bed(s, 1)) <= 1700
    assert site_count(s) == len(lattice_bed(s, 1))


def test_lattice_clumps_lie_inside_the_box_clear_of_the_sleeper_and_depend_on_the_seed_only():
    s = load_scenario("linear-mu0.8", "demo")
    bed, box, radius = np.array(lattice_bed(s, 1)), derived.apparatus(s), s["clump.ball_radius"]
    assert (bed[:, :3] >= np.array([box.end_m, 0, 0]) + radius - 1e-12).all()
    assert (bed[:, :3] <= np.array([box.length_m, box.width_m, box.height_m]) - radius + 1e-12).all()
    nearest = np.clip(bed[:, :3], box.sleeper.low, box.sleeper.high)
    assert (np.linalg.norm(bed[:, :3] - nearest, axis=1) >= radius - 1e-12).all()
    assert np.linalg.norm(bed[:, 3:], axis=1) == pytest.approx(1)
    assert lattice_bed(s, 1) == lattice_bed(s, 1)
    other = np.array(lattice_bed(s, 2))
    assert (other[:, :3] == bed[:, :3]).all() and not np.allclose(other[:, 3:], bed[:, 3:])


def test_lattice_orientations_favour_no_direction():
    q = np.array(lattice_bed(load_scenario("linear-mu0.8"), 1))[:, 3:]
    axis = np.stack(
        [
            2 * (q[:, 1] * q[:, 3] + q[:, 0] * q[:, 2]),
            2 * (q[:, 2] * q[:, 3] - q[:, 0] * q[:, 1]),
            1 - 2 * (q[:, 1] ** 2 + q[:, 2] ** 2),
        ],
        axis=1,
    )
    fabric = axis.T @ axis / len(axis)
    assert fabric == pytest.approx(np.eye(3) / 3, abs=4 * math.sqrt(4 / 45 / len(axis)))


def test_the_papers_time_steps_lie_below_the_critical_step_of_one_contact():
    for name in ("linear-mu0.8", "nonlinear-en1.0"):
        s = load_scenario(name)
        assert 0.1 < derived.time_grid(s).step_s / derived.critical_time_step(s) < 0.5


def test_bonds_that_are_off_leave_a_scenario_the_same():
    """The keys of the bond stand in every scenario; the hash of one without bonds is the one it had before them."""
    plain = load_scenario("linear-mu0.8")
    without = {key: p for key, p in plain.parameters.items() if not key.startswith("contact.bond.")}
    assert len(without) < len(plain.parameters)
    older = Scenario(plain.name, plain.profile, plain.title, without)
    assert older.hash == plain.hash
    assert plain.with_values({"contact.bond.model": "parallel"}).hash != plain.hash
