"""Porosity against closed forms: lattices, overlapping pairs, the whole chain on a lattice of clumps."""

import math

import numpy as np
import pandas as pd
import pytest

from analysis.formats import file_columns
from analysis.normalised import beds, porosity
from analysis.scenarios import derived
from analysis.scenarios.scenario import load_scenario

CUBIC = 1 - math.pi / 6  # 0.4764
HEXAGONAL = 1 - math.pi / (3 * math.sqrt(2))  # 0.2595


def cubic_lattice(radius, low, high):
    """Touching spheres on a simple cubic lattice that fills the box and its surroundings."""
    axes = [
        np.arange(math.floor(a / (2 * radius)) - 1, math.ceil(b / (2 * radius)) + 2) * 2 * radius
        for a, b in zip(low, high, strict=True)
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def hexagonal_lattice(radius, half_size):
    """Touching spheres in hexagonal close packing, layers ABAB, around the origin."""
    n = math.ceil(half_size / (2 * radius)) + 2
    i, j, k = np.meshgrid(*[np.arange(-n - 2, n + 3)] * 3, indexing="ij")
    j, i = j.ravel(), i.ravel()
    k = k.ravel()
    return radius * np.column_stack(
        [2 * i + (j % 2) + (k % 2), math.sqrt(3) * (j + (k % 2) / 3), 2 * math.sqrt(6) / 3 * k]
    )


def unit_cell_void(centres, radius, corner, edges, count=200_000):
    points = np.array(corner) + np.array(edges) * porosity.qmc.Halton(3, scramble=False).random(count)
    return porosity.porosity(porosity.solid(points, centres, radius))


def test_simple_cubic_cell():
    value, error = unit_cell_void(cubic_lattice(0.5, [0] * 3, [3] * 3), 0.5, (0.3, 0.1, 0.2), (2, 2, 2))
    assert error < 0.0012
    assert value == pytest.approx(CUBIC, abs=0.001)


def test_hexagonal_close_packing_cell():
    cell = (2 * 0.5, 2 * math.sqrt(3) * 0.5, 4 * math.sqrt(6) / 3 * 0.5)  # orthogonal cell of four spheres
    value, _ = unit_cell_void(hexagonal_lattice(0.5, 3), 0.5, (-0.4, -0.2, -0.3), cell)
    assert value == pytest.approx(HEXAGONAL, abs=0.001)


@pytest.mark.parametrize("aspect", [1.25, 1.5, 1.75, 1.875, 2.0])
def test_overlapping_pair_counts_its_lens_once(aspect):
    s = load_scenario("linear-mu0.8")
    s.parameters["clump.aspect"] = type(s.parameters["clump.aspect"])(aspect, "-", "assumed", "test")
    clump = derived.clump(s)
    bed = pd.DataFrame(
        [[1, 0.1, 0.2, 0.3, 0.6, -0.3, 0.5, math.sqrt(1 - 0.36 - 0.09 - 0.25)]], columns=file_columns.BED
    )
    centres = beds.sphere_centres(bed, clump.half_distance_m)
    corner, edge = np.array([0.1, 0.2, 0.3]) - 0.04, 0.08
    value, error = unit_cell_void(centres, clump.radius_m, corner, [edge] * 3)
    volume = (1 - value) * edge**3
    assert volume == pytest.approx(clump.volume_m3, abs=2 * error * edge**3)
    r, c = clump.radius_m, clump.half_distance_m
    lens = 2 * math.pi / 3 * (r - c) ** 2 * (2 * r + c)
    assert clump.volume_m3 == pytest.approx(2 * 4 / 3 * math.pi * r**3 - lens, rel=1e-12)


def test_sphere_axis_follows_the_quaternion():
    half = math.sqrt(0.5)
    bed = pd.DataFrame(
        [
            [1, 0, 0, 0, 1, 0, 0, 0],
            [2, 0, 0, 0, half, 0, half, 0],
            [3, 0, 0, 0, half, half, 0, 0],
            [4, 0, 0, 0, half, 0, 0, half],
        ],
        columns=file_columns.BED,
    )
    assert np.allclose(beds.axes(bed), [[0, 0, 1], [1, 0, 0], [0, -1, 0], [0, 0, 1]])


def test_measurement_spheres_on_a_cubic_lattice():
    """A lattice of one material everywhere has its own porosity in every sphere."""
    s = load_scenario("linear-mu0.8")
    box, radius = derived.apparatus(s), derived.clump(s).radius_m
    lattice = cubic_lattice(radius, (0, 0, 0), (box.length_m, box.width_m, box.height_m))
    values, error = porosity.MeasurementSpheres(s).measure(lattice)
    assert 0 < error <= 0.001
    # A finite sphere does not hold whole unit cells.
    assert values == pytest.approx([CUBIC] * 3, abs=0.02)


def test_error_is_an_upper_bound_of_the_scatter():
    """Random shifts of a random bed under the fixed points: the measured porosity scatters less than the stated
    error."""
    generator = np.random.default_rng(3)
    centres, radius = generator.uniform(0, 1, (900, 3)), 0.055
    points = porosity.sphere_points((0.5, 0.5, 0.5), 0.4, (0, 0, 0), (1, 1, 1), 20_000)
    rotations = [np.linalg.qr(generator.standard_normal((3, 3)))[0] for _ in range(20)]
    values, errors = zip(
        *[porosity.porosity(porosity.solid((points - 0.5) @ q + 0.5, centres, radius)) for q in rotations], strict=True
    )
    assert np.std(values) < np.mean(errors)


def test_points_stay_in_the_box_and_in_the_sphere():
    points = porosity.sphere_points((0.134, 0.045, 0.1625), 0.134, (0, 0, 0), (0.8, 0.09, 0.475), 5000)
    assert points.shape == (5000, 3)
    assert (points.min(axis=0) >= 0).all() and points[:, 1].max() <= 0.09
    assert np.linalg.norm(points - (0.134, 0.045, 0.1625), axis=1).max() <= 0.134
    assert points[:, 1].mean() == pytest.approx(0.045, abs=1e-4)


def test_inside_of_sleeper_and_plates_is_not_void():
    s = load_scenario("linear-mu0.8")
    spheres, radius = porosity.MeasurementSpheres(s, 40_000), derived.clump(s).radius_m
    below = cubic_lattice(radius, (0, 0, 0), (0.8, 0.6, 0.20))
    below = below[below[:, 2] < 0.22]  # nothing above: void up to the sleeper
    high, _ = spheres.measure(below)
    low, _ = spheres.measure(below, sleeper_down_m=0.325 - 0.22 + 0.0325)
    assert all(b < a - 0.02 for a, b in zip(high, low, strict=True))
    moved, _ = spheres.measure(below, plates_out_m=[-0.1] * 5)
    assert moved[:2] == high[:2] and moved[2] != high[2]


def test_empty_bed_and_sphere_outside_the_box():
    assert porosity.porosity(porosity.solid(np.zeros((10, 3)) + 0.5, np.empty((0, 3)), 0.1))[0] == 1.0
    assert porosity.sphere_points((5, 5, 5), 0.1, (0, 0, 0), (1, 1, 1)).shape == (0, 3)
    assert math.isnan(porosity.porosity(np.empty(0, dtype=bool))[0])


def test_bed_file_errors_are_one_line(tmp_path):
    good = "id,x_m,y_m,z_m,qw,qx,qy,qz\n2,1,1,1,1,0,0,0\n1,0,0,0,1,0,0,0\n"
    for name, text, said in (
        ("a.csv", good.replace("qz\n", "q\n"), "line 1 is not id,x_m,y_m,z_m,qw,qx,qy,qz"),
        ("b.csv", good.replace("0,0,0,1", "0,x,0,1"), "line 3 is no clump"),
        ("c.csv", "id,x_m,y_m,z_m,qw,qx,qy,qz\n", "no clumps"),
        ("d.csv", "", "line 1 is not id"),
    ):
        (tmp_path / name).write_text(text)
        with pytest.raises(ValueError, match=said) as caught:
            beds.read_bed(tmp_path / name)
        assert "\n" not in str(caught.value) and name in str(caught.value)
    (tmp_path / "good.csv").write_text(good)
    assert list(beds.read_bed(tmp_path / "good.csv")["id"]) == [1, 2]
