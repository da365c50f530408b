"""The verification itself: its table, its refusals, and a few of its cases in both engines."""

import ast
import csv
import math
import shutil
import subprocess
import sys

import numpy as np
import pytest

from analysis.driver import engines
from analysis.files import KEPT_VERIFICATION, ROOT
from analysis.scenarios import derived
from analysis.scenarios.scenario import ScenarioError, load_scenario
from analysis.verification import impact, impact_file, impact_results, mutations, probes, verify_command
from analysis.verification.cases import impact_cases, path_cases
from analysis.verification.cases.case import ProbedCase, StagedCase
from analysis.verification.results import Results, write_rows

# ------------------------------------------------------------------ the table


def test_a_row_passes_within_its_tolerance_only():
    results = Results("liggghts")
    results.compare("case", "a", 2.0, 2.01, 0.0051)
    results.compare("case", "b", 2.0, 2.01, 0.0049)
    results.compare("case", "c", 0.0, 1e-9, 0.0)
    results.compare("case", "d", 0.0, 0.0, 0.0)
    results.compare("case", "e", 0.0, 0.01, 0.02, scale=1.0)
    results.compare("case", "f", 1.0, math.nan, 0.5)
    assert [row.passed for row in results.rows] == [True, False, False, True, True, False]


def test_curves_are_judged_by_their_worst_point():
    results = Results("yade")
    results.compare_curves("case", "force", [0.0, 10.0, 1.0], [0.0, 10.0, 1.1], 0.005)
    results.compare_curves("case", "force", [0.0, 10.0, 1.0], [0.0, 10.0, math.nan], 0.5)
    assert (
        not results.rows[0].passed
        and results.rows[0].measured == 1.1
        and results.rows[0].rel_error == pytest.approx(0.01)
    )
    assert not results.rows[1].passed


def test_the_table_has_the_promised_columns(tmp_path):
    results = Results("yade")
    results.compare("case", "force, N", 1.0, 1.0, 0.005, 'with "quotes", commas')
    results.fail("other", "yade: no end")
    write_rows(tmp_path / "verification.csv", results.rows)
    with open(tmp_path / "verification.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == [
        "code",
        "case",
        "quantity",
        "expected",
        "measured",
        "abs_error",
        "rel_error",
        "tolerance",
        "passed",
        "reason",
    ]
    assert [row["passed"] for row in rows] == ["true", "false"]
    assert rows[0]["reason"] == 'with "quotes", commas'


def test_curves_are_written_per_case_and_code(tmp_path):
    results = Results("yade")
    results.curve("path", "wall", step=[1, 2], force_N=[1.0, 2.0], force_N_expected=[1.0, 2.1])
    results.curve("path", "spheres", step=[1], force_N=[3.0], force_N_expected=[3.0])
    results.write_curves(tmp_path)
    assert (tmp_path / "path_yade.csv").read_text().splitlines() == [
        "series,step,force_N,force_N_expected",
        "wall,1,1,1",
        "wall,2,2,2.1",
        "spheres,1,3,3",
    ]


# ------------------------------------------------------------------ impact files

GOOD = """
base = "nonlinear-md1-en0.6"
[impact]
speed = { value = 2.0, unit = "m/s" }
angle = { value = 60.0, unit = "degrees" }
[body_1]
radius = { value = 0.01, unit = "m" }
density = { value = 3000.0, unit = "kg/m3" }
spin = { value = [0.0, 5.0, 0.0], unit = "rad/s" }
[body_2]
motion = { value = "held", unit = "-" }
[contact.particle_particle]
friction = { value = 0.3, unit = "-" }
"""

BAD = [
    ('speed = { value = 2.0, unit = "m/s" }', "", "impact.speed is missing"),
    ('unit = "m/s"', 'unit = "mm/s"', '"m/s"'),
    ("value = 2.0", "value = -2.0", ">= 1e-06"),
    ("value = 2.0", 'value = "fast"', "a number"),
    ("value = 60.0", "value = 90.0", "<= 89"),
    ("[0.0, 5.0, 0.0]", "[0.0, 5.0]", "three of them"),
    ("radius =", "radious =", "a known key, perhaps body_1.radius"),
    ("nonlinear-md1-en0.6", "nonlinear", "one of"),
    ('radius = { value = 0.01, unit = "m" }', "radius = 0.01", "value and unit"),
    ('motion = { value = "held", unit = "-" }', 'shear_modulus = { value = 1e7, unit = "Pa" }', "of both bodies"),
    ("[impact]", '[impact]\nagainst = { value = "wall", unit = "-" }', "no body_2"),
    ("friction = { value = 0.3", 'restitution = { value = 0.0, unit = "-" }\ndamping_mode = { value = 0', "singular"),
    ("[body_1]", "[body_1", "not valid TOML"),
]


def write(tmp_path, text):
    path = tmp_path / "case.toml"
    path.write_text(text)
    return path


def read_one(path):
    (case,) = impact_file.read_impacts(path).impacts
    return case


def test_impact_file(tmp_path):
    case = read_one(write(tmp_path, GOOD))
    first, second = case.balls
    assert first.radius == 0.01 and first.mass == pytest.approx(3000 * 4 / 3 * math.pi * 1e-6)
    assert first.velocity == pytest.approx((2 * math.sin(math.pi / 3), 0, -1.0)) and first.spin == (0, 5, 0)
    clump = derived.clump(load_scenario("linear-mu0.8", "full"))
    assert second.held and second.radius == clump.radius_m  # as nothing else is said
    assert case.scenario["contact.particle_particle.friction"] == 0.3
    assert case.scenario["contact.particle_particle.restitution"] == 0.6  # from the base
    assert case.normal_speed == pytest.approx(1.0)


@pytest.mark.parametrize("old, new, says", BAD)
def test_bad_impact_files_are_refused_in_one_line(tmp_path, capsys, old, new, says):
    assert old in GOOD
    path = write(tmp_path, GOOD.replace(old, new, 1))
    with pytest.raises(ScenarioError) as refused:
        impact_file.read_impacts(path)
    assert says in str(refused.value) and "case.toml" in str(refused.value) and "\n" not in str(refused.value)
    assert impact.main([str(path), "--out", str(tmp_path)]) != 0
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


@pytest.mark.parametrize("path", sorted((ROOT / "docs" / "examples").rglob("*.toml")), ids=lambda path: path.stem)
def test_every_example_is_a_good_file(path):
    file = impact_file.read_impacts(path)
    assert len({case.name for case in file.impacts}) == len(file.impacts) > 0
    for case in file.impacts[:: len(file.impacts) - 1 or 1]:
        assert case.probe().steps > 3000
        assert set(file.figure) <= set(impact_results.expected(case)), "no line of the law in the figure"


def test_all_eight_tests_of_chung_and_ooi_are_there():
    files = impact.files_of(str(ROOT / "docs" / "examples" / "chung-ooi"))
    assert [file.title[:21] for file in files] == [f"Chung and Ooi, test {n}" for n in range(1, 9)]
    assert all(len({case.curve for case in file.impacts}) >= 2 for file in files)


def test_a_sweep_is_an_impact_for_each_entry_of_each_curve(tmp_path):
    sweep = '[sweep.impact]\nangle = { value = [10.0, 70.0], unit = "degrees" }\n'
    curves = "".join(
        f'[curve.{name}.contact.particle_particle]\nfriction = {{ value = {mu}, unit = "-" }}\n'
        for name, mu in (("smooth", 0.1), ("rough", 0.8))
    )
    text = GOOD.replace('angle = { value = 60.0, unit = "degrees" }\n', "")
    file = impact_file.read_impacts(write(tmp_path, text + sweep + curves))
    assert [(c.curve, dict(c.swept)["impact.angle"]) for c in file.impacts] == [
        ("smooth", 10.0),
        ("smooth", 70.0),
        ("rough", 10.0),
        ("rough", 70.0),
    ]
    assert [c.scenario["contact.particle_particle.friction"] for c in file.impacts] == [0.1, 0.1, 0.8, 0.8]
    assert file.impacts[1].normal_speed == pytest.approx(2 * math.cos(math.radians(70)))


PLANE = """
base = "nonlinear-en1.0"
[impact]
against = { value = "plane", unit = "-" }
normal_speed = { value = 0.5, unit = "m/s" }
tangential_speed = { value = 1.5, unit = "m/s" }
restitution = { value = 0.8, unit = "-" }
[body_1]
radius = { value = 0.01, unit = "m" }
density = { value = 2500.0, unit = "kg/m3" }
young_modulus = { value = 2e9, unit = "Pa" }
poisson_ratio = { value = 0.25, unit = "-" }
[contact.particle_particle]
friction = { value = 0.2, unit = "-" }
"""

BAD_PLANE = [
    ('normal_speed = {', 'angle = { value = 5.0, unit = "degrees" }\nnormal_speed = {', "not both"),
    ('normal_speed = { value = 0.5, unit = "m/s" }', "", "impact.normal_speed is missing"),
    ("restitution = { value = 0.8", "restitution = { value = 0.3", "gives restitutions from 0.663 to 1"),
    ("friction =", 'restitution = { value = 0.8, unit = "-" }\nfriction =', "not both"),
    ("[body_1]", '[body_2]\nradius = { value = 1.0, unit = "m" }\n[body_1]', "no body_2 but its material"),
    ("nonlinear-en1.0", "linear-mu0.8", "wall with the linear law"),
    ("[body_1]", '[body_1]\nmass = { value = 1.0, unit = "kg" }', "mass or density, not both"),
    ("[body_1]", '[sweep.impact]\nangle = { value = [], unit = "degrees" }\n[body_1]', "a list of at most"),
    ("[body_1]", '[sweep]\nimpact = 3\n[body_1]', "a known key"),
    ("[body_1]", "[sweep]\nbody_1.radius = { value = [0.1, 0.2], unit = \"m\" }\n"
     "body_1.poisson_ratio = { value = [0.1], unit = \"-\" }\n[body_1]", "as many entries"),
    ("base =", "curve = 3\nbase =", "a table"),
    ("base =", 'figure = "restitution"\nbase =', "a list of columns"),
]  # fmt: skip


@pytest.mark.parametrize("old, new, says", BAD_PLANE)
def test_contradictions_of_an_impact_file_are_refused_in_one_line(tmp_path, old, new, says):
    assert old in PLANE
    with pytest.raises(ScenarioError) as refused:
        impact_file.read_impacts(write(tmp_path, PLANE.replace(old, new, 1)))
    assert says in str(refused.value) and "case.toml" in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize("code", engines.CODES)
def test_a_sphere_on_a_plane_of_the_particles_law(code, tmp_path):
    """Sliding throughout: restitution as asked, impulse ratio = friction, and all that follows from them."""
    path = write(tmp_path, PLANE.replace("title", ""))
    assert impact.main([str(path), "--code", code, "--out", str(tmp_path)]) == 0
    with open(tmp_path / "case.csv", newline="") as file:
        (row,) = csv.DictReader(file)
    assert float(row["restitution"]) == pytest.approx(0.8, rel=0.003)
    # also where the dashpot counts in the slip limit, as in YADE: its impulse is that of the restitution
    assert float(row["impulse_ratio"]) == pytest.approx(0.2, rel=0.01)
    # the lever of the shear force is shorter by up to the overlap, 1 % here
    for name in ("tangential_restitution", "spin_1_y_rad_s", "rebound_angle_degrees"):
        assert float(row[name]) == pytest.approx(float(row[f"expected_{name}"]), rel=0.02), name
    assert (tmp_path / "case.png").stat().st_size > 5000 and (tmp_path / "case.svg").exists()


def test_the_expected_result_of_two_spheres_keeps_momentum_and_spin_together(tmp_path):
    case = read_one(write(tmp_path, GOOD.replace('"held"', '"free"')))
    found = impact_results.expected(case)
    first, second = case.balls
    drag = first.mass * (found["velocity_1_x_m_s"] - first.velocity[0])
    for k, ball in enumerate((first, second), start=1):
        turned = 0.4 * ball.mass * ball.radius**2 * (found[f"spin_{k}_y_rad_s"] - ball.spin[1])
        # the lever is the radius less half the overlap, here up to a tenth of the radius
        assert turned == pytest.approx(-ball.radius * drag, rel=0.06)
    assert found["impulse_ratio"] == pytest.approx(0.3, rel=1e-3)  # 60 degrees at friction 0.3: it slides throughout


def test_missing_impact_file(tmp_path, capsys):
    assert impact.main([str(tmp_path / "none.toml")]) != 0
    assert "cannot be read" in capsys.readouterr().err


# ------------------------------------------------------------------ cases without an engine


def test_help_makes_no_case(monkeypatch, capsys):
    def refuse(self, code):
        raise AssertionError(f"{type(self).__name__} was made")

    for kind in (ProbedCase, StagedCase):
        monkeypatch.setattr(kind, "__init__", refuse)
    with pytest.raises(SystemExit) as ended:
        verify_command.main(["--help"])
    assert ended.value.code == 0 and all(case.name in capsys.readouterr().out for case in verify_command.CASES[:1])
    with pytest.raises(AssertionError, match="was made"):
        verify_command.PROBED[0]("liggghts")


def test_no_case_asks_which_engine_it_runs_in():
    """What an engine does otherwise is told by engine_laws alone."""
    found = list((ROOT / "analysis" / "verification" / "cases").glob("*.py"))
    assert len(found) > 5
    for path in found:
        names = [node.value for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Constant)]
        assert not {"yade", "liggghts"} & {name for name in names if isinstance(name, str)}, path.name


def test_head_on_measures_of_a_known_motion():
    """`measure` on a half sine: peak, duration between the crossings, restitution."""
    scenario = load_scenario("linear-mu0.8")
    law = impact_cases.wall_law(scenario, 0.07)
    probe = impact_cases.against_wall("known", scenario, law, 0.015, 0.07, 1.0, "linear")
    time = np.arange(probe.steps + 1) * probe.step
    omega = math.sqrt(law.normal_stiffness / law.mass)
    touch, leave = 20.4 * probe.step, 20.4 * probe.step + math.pi / omega
    inside = (time > touch) & (time < leave)
    overlap = np.where(
        inside, np.sin(omega * (time - touch)) / omega, np.where(time < touch, time - touch, leave - time)
    )
    speed = np.where(time < touch, -1.0, np.where(inside, -np.cos(omega * (time - touch)), 0.7))
    position, velocity, force, none = (np.zeros((len(time), 1, 3)) for _ in range(4))
    position[:, 0, 2], velocity[:, 0, 2] = 0.015 - overlap, speed
    force[:, 0, 2] = np.where(inside, law.normal_stiffness * overlap, 0)
    found = probes.Trajectory(time, position, velocity, none, force, none, *[none[:, 0, 0]] * 3)
    measured, _, _ = impact_cases.measure(probe, found)
    assert measured["peak_overlap_m"] == pytest.approx(1 / omega, rel=1e-5)
    assert measured["duration_s"] == pytest.approx(math.pi / omega, rel=1e-5)
    assert measured["restitution"] == pytest.approx(0.7)


def test_path_reaches_every_branch():
    """The imposed path closes within a step, slips both ways, leaves the contact, and closes again."""
    case = path_cases.PrescribedPaths("liggghts")
    for probe in case.probes():
        overlap, closing, sliding, _, _ = case.geometry(probe)
        inside = overlap > 0
        assert not inside[0] and inside[2]  # closes within the first step or the second
        assert (np.diff(inside.astype(int)) == 1).sum() == 2 and (np.diff(inside.astype(int)) == -1).sum() == 1
        assert inside[-1] and sliding.min() < 0 < sliding.max()


@pytest.mark.parametrize("mutation", mutations.MUTATIONS, ids=lambda m: m.name)
def test_mutations_fit_the_source(tmp_path, mutation):
    """A mutation that no longer finds its line would test nothing."""
    original = ROOT / ("yade" if mutation.code == "yade" else "liggghts/src")
    shutil.copytree(original, tmp_path / "src", ignore=shutil.ignore_patterns("__pycache__"))
    mutations.mutate(mutation, tmp_path / "src")
    changed = [p.name for p in (tmp_path / "src").iterdir() if p.read_bytes() != (original / p.name).read_bytes()]
    assert sorted(changed) == sorted({name for name, *_ in mutation.changes})


# ------------------------------------------------------------------ cases in the engines


@pytest.mark.parametrize("code", engines.CODES)
def test_path_and_wall_dashpot(code, tmp_path):
    results, _ = verify_command.verify([code], tmp_path, ["path", "wall-dashpot"])
    assert {row.case for row in results.rows} == {"path", "wall-dashpot"}
    assert [row for row in results.rows if not row.passed] == []


@pytest.mark.parametrize("code", engines.CODES)
def test_impact_command(code, tmp_path):
    """A nearly head-on impact by file gives the restitution of its law and conserves momentum."""
    path = write(
        tmp_path,
        GOOD.replace("60.0", "3.0").replace(
            'motion = { value = "held", unit = "-" }', 'radius = { value = 0.02, unit = "m" }'
        ),
    )
    done = subprocess.run(
        [sys.executable, "-m", "analysis", "impact", str(path), "--code", code, "--out", str(tmp_path)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    with open(tmp_path / "case.csv", newline="") as file:
        (row,) = csv.DictReader(file)
    assert float(row["restitution"]) == pytest.approx(float(row["expected_restitution"]), rel=0.005)
    first, second = read_one(path).balls
    momentum = first.mass * float(row["velocity_1_z_m_s"]) + second.mass * float(row["velocity_2_z_m_s"])
    assert momentum == pytest.approx(first.mass * first.velocity[2], rel=1e-6)
    assert (tmp_path / "case_series.csv").read_text().startswith("curve,code,time_s,overlap_m,")


def test_a_grazing_impact_keeps_its_ball_and_has_no_restitution_beyond_one(tmp_path):
    """30 m/s at 80 degrees: the ball flies far, and glances past so soft a contact, along the first line of centres."""
    path = write(tmp_path, GOOD.replace("value = 2.0", "value = 30.0").replace("60.0", "80.0"))
    assert impact.main([str(path), "--code", "liggghts", "--out", str(tmp_path)]) == 0
    with open(tmp_path / "case.csv", newline="") as file:
        row = {
            key: float(value)
            for key, value in next(csv.DictReader(file)).items()
            if key not in ("code", "curve", "remark")
        }
    first = read_one(path).balls[0]
    assert row["restitution"] == pytest.approx(row["velocity_1_z_m_s"] / -first.velocity[2], rel=1e-3)
    assert -1 < row["restitution"] < 0 and 0.99 < row["tangential_restitution"] < 1
    change = [row["velocity_1_x_m_s"] - first.velocity[0], row["velocity_1_z_m_s"] - first.velocity[2]]
    assert row["impulse_ratio"] == pytest.approx(-change[0] / change[1], rel=0.01)


def test_youngs_modulus_is_as_good_as_the_shear_modulus(tmp_path):
    body = 'shear_modulus = { value = 30e6, unit = "Pa" }\npoisson_ratio = { value = 0.25, unit = "-" }\n'
    both = GOOD.replace("[contact", body + "[contact", 1).replace("[body_2]", body + "[body_2]", 1)
    young = both.replace("shear_modulus = { value = 30e6", "young_modulus = { value = 75e6")
    one, other = (read_one(write(tmp_path, text)).scenario for text in (both, young))
    key = "contact.particle_particle.shear_modulus"
    assert one[key] == pytest.approx(other[key], rel=1e-12)


def test_a_run_that_fails_is_a_failed_row(tmp_path, monkeypatch):
    """An engine that breaks down must not make the suite pass."""
    broken = tmp_path / "ballast"
    broken.write_text("#!/bin/sh\necho 'ERROR: out of order'\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setattr(engines.LIGGGHTS, "host", broken)
    results, _ = verify_command.verify(["liggghts"], tmp_path / "run", ["wall-dashpot", "load-control"])
    assert [(row.case, row.passed) for row in results.rows] == [("wall-dashpot", False), ("load-control", False)]
    assert "out of order" in results.rows[0].reason


def test_the_kept_result_passes_and_has_every_case():
    kept = KEPT_VERIFICATION
    with open(kept / "verification.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["case"] for row in rows} == {case.name for case in verify_command.CASES}, (
        "ballast verify --out reference_data/verification"
    )
    assert all(row["passed"] == "true" for row in rows), [row for row in rows if row["passed"] != "true"]
    for code in engines.CODES:
        assert list((kept / "verification").glob(f"*_{code}.csv")), "the curves of both codes"
