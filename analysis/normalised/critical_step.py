"""The critical time step of a bed, measured on its contacts: 2 / omega_max of the whole bed about its present state.

Undamped central differences (leapfrog) are stable below dt_c = 2 / omega_max, omega_max^2 the largest eigenvalue of
M^-1 K (Belytschko). K is put together from all contacts: each ties two bodies at its point by the normal and shear
stiffness that its law has at the present overlap (tangent stiffness 1.5 F / overlap for Hertz, eq. 8; eq. 11 for shear;
the linear law's own), as if none slipped. M holds mass and inertia of every clump, and the masses of sleeper and plates
where a law moves them by force: many contacts on a light sleeper matter as much as a clump in a tight corner.

Not in it: the stiffness that forces have (small beside the contacts'), dashpots (one of ratio b lowers the step to
sqrt(1 + b^2) - b of it) and parallel bonds, whose scenarios are bounded by `derived.critical_time_step` alone.

Hertz contacts stiffen with load. What is told is the step for the cycle's largest stress: all forces in proportion to
the sleeper's stress, stiffness as force^(1/3). Contacts that only close under that stress are not known in the
preloaded bed; LARGEST_SHARE leaves room for them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy import sparse
from scipy.sparse.linalg import eigsh

from analysis import contact_laws
from analysis.formats.quantities import PLATES
from analysis.normalised import beds, microstructure
from analysis.scenarios import derived

LARGEST_SHARE = 0.85
"""Of the critical step: a run with a larger one is refused. Leapfrog is stable up to 1; the rest is left for contacts
that close only under the largest stress and for dashpots, which lower the critical step (assumed, not measured)."""
TOLERANCE = 1e-3
"""Of the eigenvalue: the step is good to half of it."""


def measure(bed_file: Path, contacts_file: Path, scenario, places: dict[str, float]) -> float | None:
    """Critical step (s) of the bed of two raw files, under the cycle's largest stress; None without contacts.

    places     settlement_m and lateral_1_m to _5_m of that moment
    Raises ValueError where a file is damaged.
    """
    bed, contacts = beds.read_bed(bed_file), microstructure.read_contacts(contacts_file)
    contacts = contacts[contacts["overlap_m"] > 0]
    if contacts.empty:
        return None
    rise = 1.0
    if scenario["contact.model"] == "hysteretic":
        rise = (scenario["loading.stress_max"] / scenario["preload.sleeper_stress"]) ** (1 / 3)
    return float(2 / np.sqrt(largest_eigenvalue(bed, contacts, scenario, places, rise)))


def largest_eigenvalue(
    bed: pd.DataFrame, contacts: pd.DataFrame, scenario, places: dict[str, float], rise: float = 1.0
) -> float:
    """omega_max squared, 1/s2; contacts between particles are `rise` times as stiff as their overlap says."""
    strains = _scaled_strains(bed, contacts, scenario, places, rise)
    stiffness = (strains.T @ strains).tocsr()
    if stiffness.shape[0] < 50:  # too small for Lanczos
        return float(np.linalg.eigvalsh(stiffness.toarray())[-1])
    start = np.random.default_rng(1).standard_normal(stiffness.shape[0])  # the same bed gives the same number
    return float(eigsh(stiffness, k=1, which="LA", v0=start, tol=TOLERANCE, return_eigenvectors=False)[0])


def _scaled_strains(bed, contacts, scenario, places, rise) -> sparse.csr_matrix:
    """A with A^T A = M^-1/2 K M^-1/2: three rows per contact, six columns per clump, then one per moving wall.

    A row is the root of a stiffness times the movement of body 1 relative to body 2 along one direction.
    """
    point = contacts[["x_m", "y_m", "z_m"]].to_numpy()
    frame = _frames(contacts[["nx", "ny", "nz"]].to_numpy())
    root = np.sqrt(_stiffnesses(contacts, scenario, rise))  # (contacts, 3)
    directions = frame * root[:, :, None]  # (contacts, direction, xyz)
    index = pd.Series(np.arange(len(bed)), index=bed["id"])
    entries = []
    for body, sign in (("clump_1", 1.0), ("clump_2", -1.0)):
        held = contacts[body].to_numpy() > 0
        clump = index.reindex(contacts[body][held]).to_numpy()
        if np.isnan(clump).any():
            raise ValueError("contacts name a clump that the bed does not have")
        entries.append(_clump_entries(np.flatnonzero(held), clump.astype(int), sign, directions, point, bed, scenario))
    walls, masses = _moving_walls(contacts, point, scenario, places)
    for k, (contact, axis) in enumerate(walls):
        column = np.full(len(contact) * 3, 6 * len(bed) + k)
        rows = (3 * contact[:, None] + np.arange(3)).ravel()
        entries.append((rows, column, -directions[contact][:, :, axis].ravel() / np.sqrt(masses[k])))
    rows, columns, values = (np.concatenate(part) for part in zip(*entries, strict=True))
    shape = 3 * len(contacts), 6 * len(bed) + len(walls)
    return sparse.csr_matrix((values, (rows, columns)), shape=shape)


def _clump_entries(contact, clump, sign, directions, point, bed, scenario):
    """Entries of the clumps on one side of contacts: u + theta x r at the contact's point, in units of M^-1/2."""
    body = derived.clump(scenario)
    arm = point[contact] - beds.positions(bed)[clump]
    axis = beds.axes(bed)[clump][:, None, :]
    way = sign * directions[contact]
    turn = np.cross(arm[:, None, :], way)  # way . (theta x r) = theta . (r x way)
    along = np.sum(turn * axis, axis=2, keepdims=True) * axis
    turn = along / np.sqrt(body.inertia_axial_kgm2) + (turn - along) / np.sqrt(body.inertia_transverse_kgm2)
    values = np.concatenate([way / np.sqrt(body.mass_kg), turn], axis=2)
    rows = np.broadcast_to((3 * contact[:, None] + np.arange(3))[:, :, None], values.shape)
    columns = np.broadcast_to(6 * clump[:, None, None] + np.arange(6), values.shape)
    return rows.ravel(), columns.ravel(), values.ravel()


def _frames(normal: np.ndarray) -> np.ndarray:
    """For each normal, itself and two directions of the contact plane: (n, 3, 3), a direction per row."""
    helper = np.where(np.abs(normal[:, [0]]) < 0.6, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([normal, first, np.cross(normal, first)], axis=1)


def _stiffnesses(contacts: pd.DataFrame, scenario, rise: float) -> np.ndarray:
    """Normal and twice the shear stiffness of every contact, (n, 3), N/m."""
    at_wall = contacts["clump_2"].to_numpy() == 0
    of = {name: scenario[f"contact.particle_particle.{name}"] for name in ("normal_stiffness", "shear_stiffness")}
    normal, shear = (np.full(len(contacts), of[f"{way}_stiffness"]) for way in ("normal", "shear"))
    if scenario["contact.model"] == "hysteretic":
        modulus, poisson = (
            scenario[f"contact.particle_particle.{name}"] for name in ("shear_modulus", "poisson_ratio")
        )
        radius, root = derived.clump(scenario).radius_m, np.sqrt(contacts["overlap_m"].to_numpy())
        normal = rise * 1.5 * contact_laws.hertz_coefficient(modulus, poisson, radius) * root
        shear = rise * contact_laws.mindlin_shear_stiffness(1.0, modulus, poisson, radius) * root
    normal = np.where(at_wall, scenario["contact.particle_wall.normal_stiffness"], normal)
    shear = np.where(at_wall, scenario["contact.particle_wall.shear_stiffness"], shear)
    return np.stack([normal, shear, shear], axis=1)


def _moving_walls(contacts, point, scenario, places):
    """Contacts and axis of sleeper and plates that are moved by force, and their masses, kg."""
    box, control = derived.apparatus(scenario), derived.load_control(scenario)
    laws_of = derived.wall_laws(scenario, "cyclic")
    blocks = [("sleeper", box.sleeper, 2, -places.get("settlement_m", 0.0))]
    blocks += [
        ("plate", plate, 0, places.get(f"lateral_{k}_m", 0.0)) for k, plate in zip(PLATES, box.plates, strict=True)
    ]
    reach = 1e-6 + contacts["overlap_m"].to_numpy()  # a contact's point lies half an overlap inside the wall
    at_wall = contacts["clump_2"].to_numpy() == 0
    walls, masses = [], []
    for kind, block, axis, way in blocks:
        low, high = np.array(block.low), np.array(block.high)
        low[axis], high[axis] = low[axis] + way, high[axis] + way
        near = np.linalg.norm(point - np.clip(point, low, high), axis=1) <= reach
        if laws_of[kind] == "force":
            walls.append((np.flatnonzero(at_wall & near), axis))
            masses.append(control[f"{kind}_mass"])
    return walls, masses
