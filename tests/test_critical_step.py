"""The critical time step of a bed, against small beds whose frequencies are known."""

import json
import math

import numpy as np
import pandas as pd
import pytest

from analysis import contact_laws
from analysis.driver import refusal
from analysis.driver.settings import RunSettings
from analysis.driver.supervise import RunError
from analysis.files import write_aside
from analysis.formats import bed_file, file_columns
from analysis.normalised import critical_step
from analysis.scenarios import derived
from analysis.scenarios.scenario import load_scenario

LINEAR, HERTZ = load_scenario("linear-mu0.8", "full"), load_scenario("nonlinear-en1.0", "full")
CLUMP = derived.clump(LINEAR)
OVERLAP = 1e-5


def step(tmp_path, scenario, poses, contacts):
    """Critical step of clumps (id, x, y, z, quaternion) with contacts (clumps, point, normal)."""
    bed, file = tmp_path / "bed.csv", tmp_path / "contacts.csv"
    bed_file.write(bed, poses)
    rows = [[*clumps, *point, *normal, OVERLAP, 1.0, 0.0, 0] for clumps, point, normal in contacts]
    pd.DataFrame(rows, columns=list(file_columns.CONTACTS)).to_csv(file, index=False)
    return critical_step.measure(bed, file, scenario, {})


UPRIGHT = (1, 0, 0, 0)
FAR = (0.4, 0.3, 0.1)  # from all walls that move


def two_towers(gap=2 * (CLUMP.radius_m + CLUMP.half_distance_m)):
    """Two upright clumps, one on the other, and their contact."""
    x, y, z = FAR
    poses = [(1, x, y, z, *UPRIGHT), (2, x, y, z + gap, *UPRIGHT)]
    return poses, [((1, 2), (x, y, z + gap / 2), (0, 0, 1))]


def shear_rate(mass, arm, shear):
    """omega^2 of two equal bodies that tilt against each other about a contact on their axis."""
    return 2 * shear * (1 / mass + arm**2 / CLUMP.inertia_transverse_kgm2)


def test_two_clumps_vibrate_along_or_across_their_contact(tmp_path):
    k, arm = LINEAR["contact.particle_particle.normal_stiffness"], CLUMP.radius_m + CLUMP.half_distance_m
    shear = shear_rate(CLUMP.mass_kg, arm, LINEAR["contact.particle_particle.shear_stiffness"])
    expected = 2 / math.sqrt(max(2 * k / CLUMP.mass_kg, shear))
    assert step(tmp_path, LINEAR, *two_towers()) == pytest.approx(expected, rel=1e-9)  # rounding of a 12 x 12 matrix


def test_a_hertz_contact_is_as_stiff_as_under_the_largest_stress(tmp_path):
    modulus, poisson = (HERTZ[f"contact.particle_particle.{key}"] for key in ("shear_modulus", "poisson_ratio"))
    rise = (HERTZ["loading.stress_max"] / HERTZ["preload.sleeper_stress"]) ** (1 / 3)
    normal = 1.5 * contact_laws.hertz_normal_force(OVERLAP, modulus, poisson, CLUMP.radius_m) / OVERLAP
    shear = contact_laws.mindlin_shear_stiffness(OVERLAP, modulus, poisson, CLUMP.radius_m)
    arm = CLUMP.radius_m + CLUMP.half_distance_m
    expected = 2 / math.sqrt(rise * max(2 * normal / CLUMP.mass_kg, shear_rate(CLUMP.mass_kg, arm, shear)))
    assert step(tmp_path, HERTZ, *two_towers()) == pytest.approx(expected, rel=1e-9)


def test_the_step_does_not_depend_on_how_the_bed_is_turned(tmp_path):
    poses, contacts = two_towers()
    half = math.sqrt(0.5)
    turned = [(i, x, 0.3, 0.1, half, 0, half, 0) for i, x in ((1, 0.4), (2, 0.4 + poses[1][3] - poses[0][3]))]
    (_, point, _), *_ = contacts
    lying = [((1, 2), (0.4 + point[2] - FAR[2], 0.3, 0.1), (1, 0, 0))]
    assert step(tmp_path, LINEAR, turned, lying) == pytest.approx(step(tmp_path, LINEAR, poses, contacts), rel=1e-9)


def test_a_light_sleeper_on_many_contacts_sets_the_step(tmp_path):
    box, count = derived.apparatus(LINEAR), 400
    under = box.sleeper.low[2] - CLUMP.radius_m
    grid = np.stack(np.meshgrid(np.linspace(0.1, 0.7, 20), np.linspace(0.2, 0.4, 20)), axis=-1).reshape(-1, 2)
    poses = [(i + 1, x, y, under, math.sqrt(0.5), 0, math.sqrt(0.5), 0) for i, (x, y) in enumerate(grid)]
    contacts = [((i + 1, 0), (x, y, box.sleeper.low[2]), (0, 0, 1)) for i, (x, y) in enumerate(grid)]
    k, mass = LINEAR["contact.particle_wall.normal_stiffness"], derived.load_control(LINEAR)["sleeper_mass"]
    expected = 2 / math.sqrt(k * (count / mass + 1 / CLUMP.mass_kg))
    assert step(tmp_path, LINEAR, poses, contacts) == pytest.approx(expected, rel=critical_step.TOLERANCE)


def test_a_bed_without_contacts_has_no_critical_step(tmp_path):
    assert step(tmp_path, LINEAR, two_towers()[0], []) is None


@pytest.mark.parametrize(("share", "refused"), [(0.84, False), (0.86, True)])
def test_a_run_too_near_to_the_critical_step_is_refused_in_one_line(tmp_path, share, refused):
    settings = RunSettings(LINEAR, "liggghts", results=tmp_path)
    settings.folder.mkdir(parents=True)
    told = {"preload": {"critical_step_s": 6e-6, "step_share": share}}
    write_aside(settings.folder / "stages.json", json.dumps(told))
    if not refused:
        refusal.refuse_step(settings)
        return
    with pytest.raises(RunError, match=r"^the step is 0\.86 of the critical one of this bed, 6e-06 s; at most 0\.85"):
        refusal.refuse_step(settings)
