"""The usual step of a sampled run, in which the contact mode stays: written for speed, refused where it may change.

It is the method of `integrators.rk4` on the rates of `Flow`, to rounding. A step in which a joint may stop, turn round,
start to slip or reach a limit is refused, and `Flow` computes it again.
"""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.simulation.contact import ContactMode
from lwr_dyn.simulation.events import HOLDING, TURN
from lwr_dyn.simulation.flow import Flow, held_by_stop
from lwr_dyn.simulation.integrators import HeldStep, held_rk4


class FastStep:
    """One sample of `h` [s] in RK4 substeps.

    `friction` (n,) [N m] at its start and `work`, what the step returned, are those of the last step that was taken.
    """

    def __init__(self, flow: Flow, h: float, substeps: int) -> None:
        plant, n = flow.plant, flow.plant.n
        self._flow, self._h, self._substeps = flow, h, substeps
        cap = np.full(n, TURN / h)
        self._ceiling, self._floor = np.array([plant.upper, cap]), np.array([plant.lower, -cap])
        self._inside = np.zeros((2, 2, n), dtype=bool)
        self._below, self._above = self._inside
        self._all_inside = np.ones_like(self._inside).tobytes()
        self._directional = plant.friction.directional
        self._mode: ContactMode | None = None
        self._step: HeldStep = lambda t, now, tau, after: (0.0, 0.0)
        self.friction, self.on_stop = np.zeros(n), np.zeros(n, dtype=bool)
        self.work: tuple[float, ...] = (0.0, 0.0)

    def take(self, t: float, now: Array, tau: Array, after: Array) -> bool:
        """The step from `now` at t into `after`, states (2, n) = (q, dq); False where refused: `after` is invalid."""
        flow, mode = self._flow, self._flow.mode
        if mode is not self._mode:
            self._adopt(mode)
        if not self._plain:
            if not self._stays_at_rest(mode, t, now, tau):
                return False
            if mode.all_at_rest and flow.external is None:
                after[:], self.work = now, (0.0, 0.0)
                flow.stop_seconds += self._h * self.on_stop
                return True
        self.work = self._step(t, now, tau, after)
        flow.evaluations += 4 * self._substeps
        # one comparison finds a limit that is passed, a speed that cannot be followed, and NaN
        np.less_equal(after, self._ceiling, out=self._below)
        np.greater_equal(after, self._floor, out=self._above)
        if self._inside.tobytes() != self._all_inside:
            return False
        if not (self._plain or self._keeps(mode, t + self._h, tau, after)):
            return False
        if mode.any_at_rest:
            flow.stop_seconds += self._h * self.on_stop
        return True

    def _adopt(self, mode: ContactMode) -> None:
        self._mode, self._accelerate = mode, mode.accelerator()
        n, external = mode.plant.n, self._flow.external
        self._step, self._tangent = held_rk4(self._accelerate, n, self._h, self._substeps, mode.friction, external)
        self._high, self._low = mode.highest + HOLDING, mode.lowest - HOLDING
        self._plain = mode.friction is None and not mode.any_at_rest

    def _stays_at_rest(self, mode: ContactMode, t: float, state: Array, tau: Array) -> bool:
        """Whether joints at rest, if any, stay so under tau; it also keeps the friction torque."""
        q, dq = state
        friction = mode.friction_torque(dq)
        if not mode.any_at_rest:
            self.friction = friction
            return True
        external = self._flow.external
        net = tau - friction if external is None else tau - friction + external(t, q, dq)
        holding = mode.holding_torque(q, dq, net, self._accelerate(q, dq, net))
        self._flow.evaluations += 1
        by_friction = mode.friction_part(holding)
        self.friction, self.on_stop = friction + by_friction, held_by_stop(holding, by_friction)
        return bool(((holding <= self._high) & (holding >= self._low)).all())

    def _keeps(self, mode: ContactMode, t: float, tau: Array, after: Array) -> bool:
        """Whether no joint turned round (or might have, by the tangent at the last substep), or started to slip."""
        sides = mode.sides
        same = ((sides * after[1] > 0.0) & (sides * self._tangent() >= 0.0)) | mode.at_rest | ~self._directional
        if not same.all():
            return False
        if not mode.any_at_rest:
            return True
        friction, on_stop = self.friction, self.on_stop
        stays = self._stays_at_rest(mode, t, after, tau)
        self.friction, self.on_stop = friction, on_stop
        return stays
