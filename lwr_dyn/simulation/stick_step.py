"""The usual step with set-valued friction under a held torque, written for speed: RK4 while nobody starts or stops.

It is the method of `rk4` on the rates of `StickFlow`, to rounding. A step in which a joint may change its side, give
way, or meet a stop is refused, and goes through `StickFlow.advance`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.simulation.events import PUSH, TURN
from lwr_dyn.simulation.stick import Regime
from lwr_dyn.simulation.stick_flow import StickFlow


class StickStep:
    """One sample of `h` [s] in `substeps` RK4 steps; `friction` and `work` are those of the last step that was taken.

    `take(now, tau, after)` with states (2, n) = (q, dq) says whether the step is good.
    """

    __slots__ = (
        "_accelerate", "_ceiling", "_d", "_floor", "_flow", "_high", "_least", "_low", "_most", "_regime", "_stage",
        "_substeps", "_table", "_tables", "friction", "work",
    )  # fmt: skip

    def __init__(self, flow: StickFlow, h: float, substeps: int) -> None:
        plant, n, d = flow.plant, flow.plant.n, h / substeps
        self._flow, self._d, self._substeps = flow, d, substeps
        cap = np.full(n, TURN / h)
        self._ceiling, self._floor = np.array([plant.upper, cap]), np.array([plant.lower, -cap])
        self._tables = (
            np.array([[1.0, d / 2, 0.0], [0.0, 1.0, d / 2]]),
            np.array([[1.0, d / 2, d * d / 4, 0.0], [0.0, 1.0, 0.0, d / 2]]),
            np.array([[1.0, d, 0.0, d * d / 2, 0.0], [0.0, 1.0, 0.0, 0.0, d]]),
            np.array([[1.0, d, d * d / 6, d * d / 6, d * d / 6, 0.0], [0.0, 1.0, d / 6, d / 3, d / 3, d / 6]]),
        )
        self._table, self._stage = np.zeros((6, n)), np.zeros((2, n))
        self._regime: Regime | None = None
        self._accelerate: Callable[[Array, Array, Array], Array] = plant.raw.forward_dynamics
        self._high = self._low = self._most = self._least = self.friction = np.zeros(n)
        self.work = 0.0

    def take(self, now: Array, tau: Array, after: Array) -> bool:
        """The step from `now` into `after`; False where it has to be done with care, `after` then means nothing."""
        flow, regime = self._flow, self._flow.now
        if regime is not self._regime:
            self._adopt(regime)
        if regime.anybody_rests and not self._held(regime, now, tau):
            return False
        if regime.everybody_rests:
            after[:] = now
            self.work = 0.0
            return True
        if not regime.anybody_rests:
            self.friction = regime.law(now[1])
        self.work = self._runge_kutta(regime, now, tau, after)
        flow.evaluations += 4 * self._substeps
        return self._whole(regime, tau, after)

    def _adopt(self, regime: Regime) -> None:
        self._regime, self._accelerate = regime, regime.accelerator()
        self._high, self._low = regime.highest + PUSH, regime.lowest - PUSH
        dry = self._flow.dry
        self._most, self._least = (np.where(regime.resting, x, 0.0) for x in (dry.highest, dry.lowest))

    def _held(self, regime: Regime, state: Array, tau: Array) -> bool:
        """Whether joints at rest stay so under tau; also keeps the friction torque."""
        q, dq = state
        drag = regime.law(dq)
        net = tau - drag
        push = regime.push(q, dq, net, self._accelerate(q, dq, net))
        self._flow.evaluations += 1
        self.friction = drag + np.minimum(np.maximum(push, self._least), self._most)  # the rest is a stop's
        return bool(((push <= self._high) & (push >= self._low)).all())

    def _runge_kutta(self, regime: Regime, now: Array, tau: Array, after: Array) -> float:
        table, stage, law, accelerate, dot = self._table, self._stage, regime.law, self._accelerate, np.dot
        c2, c3, c4, c = self._tables
        start, q0, dq0, q, dq = table[:2], table[0], table[1], stage[0], stage[1]
        upto1, upto2, upto3, k1, k2, k3, k4 = table[:3], table[:4], table[:5], *table[2:]
        work, state = 0.0, now
        for _ in range(self._substeps):
            start[:] = state
            drag = law(dq0)
            power = drag.dot(dq0)
            k1[:] = accelerate(q0, dq0, tau - drag)
            dot(c2, upto1, out=stage)
            drag = law(dq)
            power += 2.0 * drag.dot(dq)
            k2[:] = accelerate(q, dq, tau - drag)
            dot(c3, upto2, out=stage)
            drag = law(dq)
            power += 2.0 * drag.dot(dq)
            k3[:] = accelerate(q, dq, tau - drag)
            dot(c4, upto3, out=stage)
            drag = law(dq)
            power += drag.dot(dq)
            k4[:] = accelerate(q, dq, tau - drag)
            dot(c, table, out=after)
            work -= power
            state = after
        return float(work * self._d / 6)

    def _whole(self, regime: Regime, tau: Array, after: Array) -> bool:
        """Nobody passed a limit, turned round (or might have, by a line drawn from the start), or gave way."""
        if not ((after <= self._ceiling) & (after >= self._floor)).all():
            return False
        sides, speed = regime.sides, after[1]
        # a braked joint might touch zero and come back: a line drawn from the (last) start would then pass zero
        line = self._table[1] + self._d * self._table[2]
        if not (((sides * speed > 0.0) & (sides * line >= 0.0)) | regime.resting).all():
            return False
        if not regime.anybody_rests:
            return True
        kept = self.friction
        held = self._held(regime, after, tau)
        self.friction = kept
        return held
