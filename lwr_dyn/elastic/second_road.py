"""An elastic run moved again by another engine and another method: Newton-Euler links, Radau IIA 5.

At samples of the run the state (q, theta, dq, dtheta) is followed through one interval under the recorded torque, and
its end is compared with the next sample:

    residual = M(q) (dq_{k+1} - dq') / h,  B (dtheta_{k+1} - dtheta') / h [N m],   gap = |q_{k+1} - q'|, ... [rad]

Intervals with an event, and those in which a link leans on a stop, are left out. A motor at rest stays there, and what
has to hold it is compared with the recorded friction.
"""

from collections.abc import Callable

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.elastic.plant import ElasticPlant
from lwr_dyn.elastic.radau import STAGES, TIMES
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.arm_friction import FrictionTorque, Mask
from lwr_dyn.simulation.other_road import OtherRoad, Rows, uneventful

JUDGED = 100
"""Intervals of a run, evenly spread; each costs as much as 40 steps of the run."""
HALVES = 2
"""Radau steps an interval."""
METHOD_TORQUE = 1e-6
"""Of the largest torque: what the two methods may differ by, seen as a torque over an interval; 1e-9 to 1e-7 seen."""
METHOD_GAP = 1e-9
"""[rad] by which the two methods may differ in an interval; 1e-12 to 1e-10 seen."""
NEWTON_STEPS = 12
CHANGE = 1e-15
"""[rad, rad/s] Smaller changes end Newton's iteration."""
SLOPE_STEP = 1e-6
"""[rad, rad/s] of the differences for its slopes."""


def second_road(run: Run, plant: ElasticPlant, most: int = JUDGED) -> OtherRoad | None:
    """The residual of an elastic run with its setup; None where nothing is left to judge."""
    plain = uneventful(run, False)
    leans = ((run.q <= plant.arm.lower) | (run.q >= plant.arm.upper)) & np.isfinite(plant.lower[: run.n])
    plain = plain[~leans[plain].any(axis=1)]
    rows = plain[np.unique(np.linspace(0, plain.size - 1, min(most, plain.size)).astype(int))]
    if not rows.size:
        return None
    judge = _ElasticIntervals(run, plant, rows)
    with np.errstate(over="ignore", invalid="ignore"):
        residual, gap = judge.residuals()
    scale, intervals = judge.scale(), len(run.t) - 1
    worst = float(np.max(residual)) if np.isfinite(residual).all() else float("nan")
    return OtherRoad(
        f"{judge.model.name} and Radau IIA 5", worst, int(np.argmax(residual.max(axis=0))) % run.n, float(np.max(gap)),
        METHOD_TORQUE * scale, METHOD_GAP, scale, rows.size, intervals - plain.size, intervals,
    )  # fmt: skip


class _ElasticIntervals:
    """Some intervals of a run, by their first samples `rows` (k,)."""

    def __init__(self, run: Run, plant: ElasticPlant, rows: Rows) -> None:
        other = "pinocchio" if plant.model.name == "newton-euler" else "newton-euler"
        self.model = type(plant.model)(plant.arm, run.setup.elasticity, other)
        x, dx = (np.hstack(pair) for pair in ((run.q, run.signals["theta"]), (run.dq, run.signals["dtheta"])))
        self.x, self.dx, self.after_x, self.after_dx = x[rows], dx[rows], x[rows + 1], dx[rows + 1]
        self.t, self.h = run.t[rows], np.diff(run.t)[rows][:, None]
        self.tau, self.recorded, self.external = run.tau_applied[rows], run.tau_friction[rows], run.setup.external
        still = (self.dx == 0.0) & (self.after_dx == 0.0) & (self.x == self.after_x) & plant.friction.directional
        self.moves = ~still
        self.frictions = [_friction(plant, d, a, s) for d, a, s in zip(self.dx, self.after_dx, still, strict=True)]

    def residuals(self) -> tuple[Array, Array]:
        """Residuals (k, 2n) [N m] and gaps (k, 2n) [rad]."""
        n = self.model.joints
        x, dx = self.x, self.dx
        for i in range(HALVES):
            x, dx = self._step(x, dx, i / HALVES, self.h / HALVES)
        B = self.model.mass_matrix(self.x)
        torque = np.einsum("kij,kj->ki", B, (self.after_dx - dx) / self.h)
        start = self._acceleration(self.x, self.dx, 0.0)
        needed = self._force(self.x, self.dx, 0.0) - np.einsum("kij,kj->ki", B, start)
        torque[:, n:] = np.where(self.moves[:, n:], torque[:, n:], needed[:, n:] - self.recorded)
        return np.abs(torque), np.abs(self.after_x - x)

    def scale(self) -> float:
        """The largest torque, of motors or gears [N m], at least 1."""
        gears = np.abs(self.model.gear_torque(self.x, self.dx)).max()
        return float(max(1.0, gears, np.abs(self.tau).max()))

    def _acceleration(self, x: Array, dx: Array, share: float) -> Array:
        """(k, 2n) at a share of the intervals, 0 of motors at rest."""
        both, rest = self.moves[:, :, None] * self.moves[:, None, :], np.eye(x.shape[1]) * ~self.moves[:, None, :]
        B = self.model.mass_matrix(x) * both + rest
        return np.asarray(np.linalg.solve(B, (self._force(x, dx, share) * self.moves)[..., None])[..., 0])

    def _force(self, x: Array, dx: Array, share: float) -> Array:
        """Torques less friction and less what the motion needs, (k, 2n)."""
        n = self.model.joints
        force = -self.model.bias_torque(x, dx)
        force[:, n:] += self.tau
        if self.external is not None:
            times = (self.t + share * self.h[:, 0]).tolist()
            force[:, :n] += np.array([self.external(*row) for row in zip(times, x[:, :n], dx[:, :n], strict=True)])
        for row, friction, v in zip(force, self.frictions, dx, strict=True):
            if friction is not None:
                row -= friction(v)
        return np.asarray(force)

    def _step(self, x: Array, dx: Array, share: float, d: Array) -> tuple[Array, Array]:
        """One step of Radau IIA 5 of d (k, 1) [s], from the share of the interval that is done."""
        k, m = x.shape[0], 2 * x.shape[1]
        half = m // 2

        def rates(y: Array, at: float) -> Array:
            return np.hstack([y[:, half:], self._acceleration(y[:, :half], y[:, half:], at)])

        y = np.hstack([x, dx])
        f0, J = rates(y, share), np.empty((k, m, m))
        for j in range(m):
            moved = y.copy()
            moved[:, j] += SLOPE_STEP
            J[:, :, j] = (rates(moved, share) - f0) / SLOPE_STEP
        newton = np.eye(3 * m) - np.einsum("ij,kab->kiajb", STAGES, J).reshape(k, 3 * m, 3 * m) * d[:, :, None]
        newton, z = np.linalg.inv(newton), TIMES[None, :, None] * (d * f0)[:, None, :]
        for _ in range(NEWTON_STEPS):
            f = np.stack([rates(y + z[:, i], share + c / HALVES) for i, c in enumerate(TIMES)], axis=1)
            rest = d[:, :, None] * np.einsum("ij,kja->kia", STAGES, f) - z
            change = np.einsum("kab,kb->ka", newton, rest.reshape(k, 3 * m)).reshape(k, 3, m)
            z = z + change
            if not np.abs(change).max() > CHANGE:
                break
        end = y + z[:, 2]
        return end[:, :half], end[:, half:]


def _friction(plant: ElasticPlant, dx: Array, after: Array, still: Mask) -> Callable[[Array], Array] | None:
    """The friction of the sides that the motors move to in an interval; None without friction."""
    sides = np.where(dx != 0.0, np.sign(dx), np.sign(after)).astype(int) * ~still
    torque: FrictionTorque | None = plant.friction.torque(sides, still)
    return torque
