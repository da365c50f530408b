"""What comes out of an impact: measured in an engine's trajectory, and expected from the paper's law."""

from __future__ import annotations

import math

import numpy as np

from analysis.verification import oracle
from analysis.verification.engine_laws import ENGINE_LAWS
from analysis.verification.impact_file import Impact
from analysis.verification.probes import Probe, Trajectory

UNITS = {"-": "", "m/s": "_m_s", "rad/s": "_rad_s", "kg/m3": "_kg_m3", "N/m": "_N_m"}


def column_of(key: str, unit: str) -> str:
    """The column of a swept key: `impact.angle` in degrees is impact_angle_degrees."""
    return key.replace(".", "_") + UNITS.get(unit, f"_{unit}")


def expected(impact: Impact) -> dict[str, float]:
    """Results of the paper's law for rigid bodies whose line of centres does not turn; nan for spins out of the plane.

    Two spheres meet as one of their effective mass meets a plane, because each has the moment of inertia 0.4 m r^2.
    """
    balls, law, mass = impact.balls, impact.law(), impact.effective_mass
    names = ("restitution", "tangential_restitution", "rebound_angle_degrees", "impulse_ratio", "velocity_1_x_m_s")
    spins = [f"spin_{k}_y_rad_s" for k in range(1, len(balls) + 1)]
    head_on = oracle.head_on(law, impact.normal_speed)
    if any(ball.spin[0] or ball.spin[2] for ball in balls):
        return dict.fromkeys((*names, *spins), math.nan) | {"restitution": head_on.restitution}
    radius, (along, _, down) = balls[0].radius, balls[0].velocity
    turns = sum(ball.radius * ball.spin[1] for ball in balls)
    along_after, up, spin = along, -down * head_on.restitution, turns / radius
    if law.friction > 0:
        body = oracle.Body(mass, 0.4 * mass * radius**2, ((0.0, 0.0, radius),))
        start = (0.0, radius, 0.0, along, down, spin)
        _, states, _ = oracle.bounce(body, [law], start, 1.3 * head_on.duration_s, 20)
        along_after, up, spin = states[-1][3:]
    dragged, pushed = mass * (along_after - along), mass * (up - down)
    values = (
        up / -down,
        along_after / along if along else math.nan,
        math.degrees(math.atan2((along_after - spin * radius) * math.copysign(1, along - turns), up)),
        abs(dragged) / pushed,
        along + dragged / balls[0].mass,
    )
    turned = mass * radius * (spin - turns / radius)
    after = (ball.spin[1] + turned / (ball.mass * ball.radius) for ball in balls)
    return dict(zip((*names, *spins), (*values, *after), strict=True))


def measured(impact: Impact, probe: Probe, code: str, found: Trajectory) -> tuple[dict, np.ndarray]:
    """Results of one code as a row; time, overlap, normal and shear force (4, n) as the series."""
    first = probe.balls[0]
    if len(probe.balls) == 1:
        normal = np.tile([0.0, 0.0, 1.0], (len(found.time), 1))
        overlap = first.radius - found.position[:, 0, 2]
        relative = found.velocity[:, 0]
    else:
        apart = found.position[:, 0] - found.position[:, 1]
        distance = np.linalg.norm(apart, axis=1)
        normal, overlap = apart / distance[:, None], first.radius + probe.balls[1].radius - distance
        relative = found.velocity[:, 0] - found.velocity[:, 1]
    normal_force = np.einsum("ni,ni->n", found.force[:, 0], normal)
    shear = found.force[:, 0] - normal_force[:, None] * normal
    touching = np.flatnonzero(overlap > 0)
    separated = len(touching) > 0 and touching[-1] + 1 < len(overlap)
    row = {
        "peak_overlap_m": overlap.max(),
        "peak_normal_force_N": normal_force.max(),
        "peak_shear_force_N": np.linalg.norm(shear, axis=1).max(),
        "duration_s": (touching[-1] - touching[0] + 1) * probe.step if separated else math.nan,
        **_rebound(probe, found, relative, normal, touching, separated),
    }
    for k in range(len(probe.balls)):
        for what, values in (("velocity", found.velocity), ("spin", found.spin)):
            unit = "m_s" if what == "velocity" else "rad_s"
            row |= {f"{what}_{k + 1}_{axis}_{unit}": values[-1, k, n] for n, axis in enumerate("xyz")}
    row |= {f"expected_{name}": value for name, value in expected(impact).items()}
    law = impact.law(ENGINE_LAWS[code])
    row["expected_peak_overlap_m"] = oracle.head_on(law, impact.normal_speed).peak_overlap_m
    remarks = [] if separated else ["no separation within the time that was run"]
    if isinstance(law, oracle.ViscousHertz):
        remarks.insert(0, ENGINE_LAWS[code].hysteretic_remark)
    return row | {"remark": "; ".join(remarks)}, np.array(
        [found.time, overlap, normal_force, np.linalg.norm(shear, axis=1)]
    )


def _rebound(probe: Probe, found: Trajectory, relative, normal, touching, separated: bool) -> dict[str, float]:
    """What comes out along and across the line of centres at first touch; nan without separation."""
    names = ("restitution", "tangential_restitution", "rebound_angle_degrees", "impulse_ratio")
    if not separated:
        return dict.fromkeys(names, math.nan)
    first, along = probe.balls[0], normal[touching[0]]
    start = np.subtract(first.velocity, probe.balls[1].velocity if len(probe.balls) > 1 else 0.0)
    turns = [sum(ball.radius * np.array(ball.spin) for ball in probe.balls)]
    turns.append(sum(ball.radius * found.spin[-1, k] for k, ball in enumerate(probe.balls)))
    # velocity of body 1's contact point against that of body 2, before and after
    patch = [v - np.cross(turn, along) for v, turn in zip((start, relative[-1]), turns, strict=True)]

    def split(vector) -> tuple[float, np.ndarray]:
        across = vector - (vector @ along) * along
        return float(vector @ along), across

    (before, came), (after, went) = split(start), split(relative[-1])
    (_, slid), (_, slides) = split(patch[0]), split(patch[-1])
    size, sliding = float(np.linalg.norm(came)), float(np.linalg.norm(slid))
    pushed, dragged = split(first.mass * (found.velocity[-1, 0] - np.array(first.velocity)))
    # rounding of the speeds is no tangential motion
    whole = 1e-9 * (abs(before) + size + sliding)
    sideways = float(slides @ slid) / sliding if sliding > whole else 0.0
    values = (
        after / -before,
        float(went @ came) / size**2 if size > whole else math.nan,
        math.degrees(math.atan2(sideways, after)),
        float(np.linalg.norm(dragged)) / pushed,
    )
    return dict(zip(names, values, strict=True))
