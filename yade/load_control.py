"""Sleeper and plates under load: one law each, force | pfc | fixed, evaluated at every step.

force -- a small mass with drag: v += dt (F_target - F_contact - c v) / M
pfc   -- v = gain (F_target - F_contact) / (k_n N_c dt), capped; N_c contacts, counted now and then; dt is the paper's
         step (load_control.pfc_time_step), whatever step the run takes
fixed -- does not move
v is the velocity along the load: down for the sleeper, inward for the plates. The weight of the walls is not applied.
"""

from __future__ import annotations

import math
from collections import deque

from yade.wrapper import Omega, PyRunner

import __main__
from analysis.files import write_aside
from analysis.formats.file_columns import RAW_LOADING, header
from analysis.formats.growing_csv import append_text
from analysis.scenarios import derived
from apparatus import WallIds

O = Omega()


def centre(block, axis: int) -> float:
    """Middle of a box along an axis, m."""
    return (block.low[axis] + block.high[axis]) / 2


class Wall:
    """The sleeper (axis 2) or a plate (axis 0). Both are loaded towards smaller coordinates."""

    def __init__(
        self, scenario, stage: str, kind: str, body: int, axis: int, area_m2: float, start_m: float, outward: int
    ):
        """`start_m` is the coordinate at displacement 0; `outward` the sign of a displacement along the load."""
        control = derived.load_control(scenario)
        self.law = derived.wall_laws(scenario, stage)[kind]
        self.body, self.axis, self.area, self.start, self.outward = body, axis, area_m2, start_m, outward
        self.mass, self.drag = control[f"{kind}_mass"], control[f"{kind}_drag"]
        self.state = O.bodies[body].state
        self.v = -self.state.vel[axis]
        self.contacts = scenario["load_control.pfc_contact_floor"]
        self.force = self.sum = 0.0

    def displacement(self) -> float:
        """Displacement since the start of preload, m: sleeper positive down, plates positive outward."""
        return self.outward * (self.start - self.state.pos[self.axis])


class LoadControl:
    """Drives the six walls and writes a row of raw/<stage>.csv every steps_per_row steps.

    Step n of the stage's clock is the state at which the contact forces of step n act; a row gives forces and positions
    of that same state.
    """

    def __init__(self, scenario, stage: str, clock, box, path, memory: dict | None = None):
        """`stage` is preload or cyclic; `memory` is what `memory()` returned before the simulation was saved."""
        ids, grid = WallIds.of(box), derived.time_grid(scenario)
        self.scenario, self.clock, self.path = scenario, clock, path
        self.dt, self.per_row = grid.step_s, grid.steps_per_row
        self.gain_step = derived.pfc_time_step(scenario)
        self.sleeper = Wall(scenario, stage, "sleeper", ids.sleeper, 2, box.sleeper_area_m2, centre(box.sleeper, 2), 1)
        self.plates = [
            Wall(scenario, stage, "plate", body, 0, box.plate_area_m2, centre(block, 0), -1)
            for body, block in zip(ids.plates, box.plates, strict=True)
        ]
        self.walls = [self.sleeper, *self.plates]
        self.skipped = 0 if memory else 1  # YADE does not call a new PyRunner in its first step
        self.count, self.error, self.rows = 0, 0.0, []
        self.recent = deque(maxlen=max(1, math.ceil(scenario["preload.averaging_time"] / (self.dt * self.per_row))))
        self.hold()
        if memory:
            for wall, contacts in zip(self.walls, memory["contacts"], strict=True):
                wall.contacts = contacts
        __main__.load_control_step = self.step  # where PyRunner looks names up

    @staticmethod
    def engine() -> PyRunner:
        """The engine that calls `step`, to stand between the contact loop and the integrator."""
        return PyRunner(command="load_control_step()", iterPeriod=1, firstIterRun=0, label="load_control")

    def memory(self) -> dict:
        """What the checkpoint must keep beside YADE's state. Row sums are empty at the end of a block."""
        return {"contacts": [wall.contacts for wall in self.walls]}

    def hold(self) -> None:
        """Keep all walls where they are; targets are 0."""
        self.targets = lambda n: (0.0, 0.0)
        self.moving = []

    def ramp(self) -> None:
        """Raise the loads linearly from 0, from the step that comes next."""
        s = self.scenario
        first, steps = self.clock.step - self.skipped, s["preload.ramp_time"] / self.dt
        self.ramp_start_s = O.time
        sleeper, plate = s["preload.sleeper_stress"], s["preload.plate_stress"]

        def targets(step: int) -> tuple[float, float]:
            share = min(1.0, (step - first) / steps)
            return share * sleeper, share * plate

        self.targets = targets
        self._release()

    def cycle(self) -> None:
        """Load the sleeper by the cyclic signal, the plates by their constant stress."""
        s = self.scenario
        low, high = s["loading.stress_min"], s["loading.stress_max"]
        mean, amplitude = (high + low) / 2, (high - low) / 2
        omega_dt, plate = 2 * math.pi * s["loading.frequency"] * self.dt, s["preload.plate_stress"]
        self.targets = lambda n: (mean - amplitude * math.cos(omega_dt * n), plate)
        self._release()

    def _release(self) -> None:
        self.moving = [wall for wall in self.walls if wall.law != "fixed"]

    def step(self) -> None:
        """One step: read the contact forces, move the walls, keep a row now and then."""
        n, force = self.clock.step - self.skipped, O.forces.f
        sleeper_target, plate_target = self.targets(n)
        for wall in self.walls:
            wall.force = f = force(wall.body)[wall.axis]
            wall.sum += f
        stress = self.sleeper.force / self.sleeper.area
        self.error += (stress - sleeper_target) ** 2
        self.count += 1
        if n % self.per_row == 0:
            self._keep_row(n, sleeper_target, stress)
        for wall in self.moving:
            target = (sleeper_target if wall is self.sleeper else plate_target) * wall.area
            if wall.law == "force":
                wall.v += self.dt * (target - wall.force - wall.drag * wall.v) / wall.mass
            else:
                wall.v = self._pfc(n, wall, target)
            wall.state.vel = (0.0, 0.0, -wall.v) if wall.axis == 2 else (-wall.v, 0.0, 0.0)

    def _pfc(self, n: int, wall: Wall, target: float) -> float:
        s = self.scenario
        if n % s["load_control.pfc_update_interval"] == 0:
            count = sum(1 for i in O.bodies[wall.body].intrs() if i.isReal)
            wall.contacts = max(count, s["load_control.pfc_contact_floor"])
        v = (
            s["load_control.pfc_gain"]
            * (target - wall.force)
            / (s["contact.particle_wall.normal_stiffness"] * wall.contacts * self.gain_step)
        )
        limit = s["load_control.pfc_velocity_limit"]
        return max(-limit, min(limit, v))

    def _keep_row(self, n: int, target: float, stress: float) -> None:
        row = [
            target,
            stress,
            self.sleeper.sum / self.count / self.sleeper.area,
            self.error / self.count,
            self.sleeper.displacement(),
        ]
        for plate in self.plates:
            row += [plate.force / plate.area, plate.sum / self.count / plate.area, plate.displacement()]
        self.rows.append(f"{n},{n * self.dt!r}," + ",".join(map(repr, row)) + "\n")
        self.recent.append([wall.sum / self.count / wall.area for wall in self.walls])
        for wall in self.walls:
            wall.sum = 0.0
        self.error, self.count = 0.0, 0

    def start_file(self) -> None:
        """Begin raw/<stage>.csv with its header."""
        write_aside(self.path, header(RAW_LOADING))

    def write_rows(self) -> None:
        """Append the rows since the last call to the file."""
        append_text(self.path, "".join(self.rows), sync=False)
        self.rows.clear()

    def mean_stresses(self) -> list[float]:
        """Means over the last preload.averaging_time of sleeper and plates, Pa."""
        return [sum(column) / len(self.recent) for column in zip(*self.recent, strict=True)]

    def means(self) -> str:
        """These means as part of a line."""
        means = ", ".join(f"{mean / 1e3:.2f}" for mean in self.mean_stresses())
        return f"mean stress on sleeper and plates {means} kPa"

    def targets_met(self) -> bool:
        """True where, with the whole ramp behind them, these means are within preload.stress_tolerance of the preload.

        Fixed walls are not asked.
        """
        s = self.scenario
        if O.time - self.ramp_start_s <= s["preload.ramp_time"] + s["preload.averaging_time"]:
            return False
        full = [s["preload.sleeper_stress"]] + [s["preload.plate_stress"]] * len(self.plates)
        return len(self.recent) == self.recent.maxlen and all(
            abs(mean - target) <= s["preload.stress_tolerance"] * target
            for wall, mean, target in zip(self.walls, self.mean_stresses(), full, strict=True)
            if wall in self.moving
        )
