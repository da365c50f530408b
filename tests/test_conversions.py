"""PARAMETERS.md's conversions against what the engines really got."""

import json
import math
import subprocess

import pytest

from analysis.driver.engine import write_bed
from analysis.driver.engines import LIGGGHTS
from analysis.driver.liggghts import parameter_deck
from analysis.files import ROOT
from analysis.scenarios import conversions, derived
from analysis.scenarios.conversions import CONVERSIONS, PP, PW
from analysis.scenarios.scenario import load_scenario
from analysis.verification.probes import ClumpAt, Probe, run_probes

# every conversion is met by at least one of these; walls and particles differ in each value
SCENARIOS = {
    "linear": load_scenario("linear-mu0.7").with_values(
        {"contact.particle_particle.shear_stiffness": 7e7, "contact.particle_wall.friction": 0.65}, "linear"
    ),
    "dashpots": load_scenario("linear-mu0.7").with_values(
        {
            "contact.particle_particle.damping_ratio": 0.2,
            "contact.particle_wall.damping_ratio": 0.1,
            "contact.particle_wall.shear_stiffness": 3e8,
        },
        "dashpots",
    ),
    "hysteretic": load_scenario("nonlinear-md1-en0.6"),
    "gonthier": load_scenario("nonlinear-md0-en0.3").with_values(
        {"contact.particle_particle.poisson_ratio": 0.2}, "gonthier"
    ),
}
CLUMP = derived.clump(load_scenario("linear-mu0.8"))
RADIUS = CLUMP.radius_m
# two upright clumps side by side, pressed on the floor and on each other by 10 micrometres
PAIR = tuple(ClumpAt((0.2 + k * (2 * RADIUS - 1e-5), 0.2, RADIUS + CLUMP.half_distance_m - 1e-5)) for k in (0, 1))


@pytest.fixture(scope="module")
def yade_values(tmp_path_factory):
    """Values by scenario and key, e.g. pp.kn, from YADE's own contacts."""
    folder = tmp_path_factory.mktemp("yade")
    probes = [
        Probe(name, scenario, derived.time_grid(scenario).step_s, 1, clumps=PAIR, wall="linear")
        for name, scenario in SCENARIOS.items()
    ]
    _, failures = run_probes("yade", probes, folder)
    assert not failures
    found = {}
    for name in SCENARIOS:
        contacts = json.loads((folder / "part_0" / f"{name}_contacts.json").read_text())
        assert {c["pair"] for c in contacts} == {"pp", "pw"}
        found[name] = {"sphere.mass": contacts[0]["mass"], "dt": contacts[0]["dt"]}
        for contact in contacts:
            found[name] |= {f"{contact['pair']}.{key}": value for key, value in contact.items() if key != "pair"}
    return found


@pytest.fixture(scope="module")
def liggghts_values(tmp_path_factory):
    """Values by scenario and key, e.g. normal_stiffness[1][2], as LIGGGHTS prints them."""
    found = {}
    for name, scenario in SCENARIOS.items():
        folder = tmp_path_factory.mktemp(name)
        (folder / "parameters.in").write_text(parameter_deck(scenario, 1))
        write_bed(folder / "bed.csv", [clump.position + clump.quaternion for clump in PAIR])
        out = subprocess.run(
            [LIGGGHTS.host, "-in", "liggghts/verify_values.in", "-log", "none", "-var", "run", folder],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        lines = [line.split() for line in out.splitlines() if line.startswith("VALUE ")]
        found[name] = {key: float(value) for _, key, value in lines}
    return found


def holds(conversion, scenario):
    return conversion.model in ("both", scenario["contact.model"])


@pytest.mark.parametrize("conversion", CONVERSIONS, ids=lambda c: c.parameter)
def test_yade_got_what_the_table_says(conversion, yade_values):
    compared = 0
    for name, scenario in SCENARIOS.items():
        values = yade_values[name]
        damped = conversion.yade_key.endswith(".cn")  # YADE has the coefficient in contacts with a dashpot only
        if not holds(conversion, scenario) or (damped and conversion.yade_key not in values):
            continue
        assert values[conversion.yade_key] == pytest.approx(conversion.yade_value(scenario), rel=1e-6), name
        compared += 1
    assert compared > 0


@pytest.mark.parametrize("conversion", CONVERSIONS, ids=lambda c: c.parameter)
def test_liggghts_got_what_the_table_says(conversion, liggghts_values):
    for name, scenario in SCENARIOS.items():
        assert liggghts_values[name][conversion.liggghts_key] == pytest.approx(
            conversion.liggghts_value(scenario), rel=1e-9
        ), name


def test_no_contact_parameter_is_left_out():
    rows = {c.parameter for c in CONVERSIONS}
    keys = {key for key in load_scenario("linear-mu0.8").parameters if key.startswith((PP, PW))}
    assert keys <= rows
    assert all(f"`{key}`" in conversions.markdown() for key in keys)


def test_values_differ_enough_to_notice_a_swap():
    """A row that mixed up walls and particles would fail in at least one scenario."""
    for way in ("normal_stiffness", "shear_stiffness", "friction", "damping_ratio"):
        assert any(not math.isclose(s[PP + way], s[PW + way]) for s in SCENARIOS.values()), way
