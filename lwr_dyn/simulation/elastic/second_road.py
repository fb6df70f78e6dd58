"""An elastic run moved again by another engine and another method: Newton-Euler links, Radau IIA 5.

At samples of the run the state (q, theta, dq, dtheta) is followed through one interval under the recorded torque, and
its end is compared with the next sample:

    residual = M(q) (dq_{k+1} - dq') / h,  B (dtheta_{k+1} - dtheta') / h [N m],   gap = |q_{k+1} - q'|, ... [rad]

Intervals with an event, and those in which a link leans on a stop, are left out. A motor at rest stays there, and what
has to hold it is compared with the recorded friction.
"""

from collections.abc import Callable

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.arm_friction import FrictionTorque, Mask
from lwr_dyn.simulation.elastic.plant import ElasticPlant
from lwr_dyn.simulation.elastic.radau import STAGES, TIMES
from lwr_dyn.simulation.other_road import OtherRoad, Rows, uneventful

JUDGED = 50
"""Intervals of a run, evenly spread."""
STEPS = 2
"""Radau steps for each step of the run."""
METHOD_TORQUE = 1e-6
"""Of the largest torque: what the two methods may differ by, seen as a torque over an interval; 1e-9 to 1e-7 seen."""
METHOD_GAP = 1e-9
"""[rad] by which the two methods may differ in an interval; 1e-12 to 1e-10 seen."""
NEWTON_STEPS = 100
CHANGE = 1e-13
"""[rad, rad/s] Smaller changes end Newton's iteration, and so do changes below `ROUNDING` that do not halve."""
ROUNDING = 1e-9


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
        self.own, self.model = plant.model, type(plant.model)(plant.arm, run.setup.elasticity, other)
        x, dx = (np.hstack(pair) for pair in ((run.q, run.signals["theta"]), (run.dq, run.signals["dtheta"])))
        self.x, self.dx, self.after_x, self.after_dx = x[rows], dx[rows], x[rows + 1], dx[rows + 1]
        self.t, self.h = run.t[rows], np.diff(run.t)[rows][:, None]
        self.substeps = run.setup.options.substeps
        self.tau, self.recorded, self.external = run.tau_applied[rows], run.tau_friction[rows], run.setup.external
        still = (self.dx == 0.0) & (self.after_dx == 0.0) & (self.x == self.after_x) & plant.friction.directional
        self.moves = ~still
        self.frictions = [_friction(plant, d, a, s) for d, a, s in zip(self.dx, self.after_dx, still, strict=True)]

    def residuals(self) -> tuple[Array, Array]:
        """Residuals (k, 2n) [N m] and gaps (k, 2n) [rad]."""
        n, every = self.model.joints, np.arange(len(self.t))
        x, dx = self.x, self.dx
        parts = STEPS * self.substeps
        for i in range(parts):
            x, dx = self._step(x, dx, self.t + i / parts * self.h[:, 0], self.h / parts)
        B = self.model.mass_matrix(self.x)
        torque = np.einsum("kij,kj->ki", B, (self.after_dx - dx) / self.h)
        start = self._acceleration(self.x, self.dx, self.t, every)
        needed = self._force(self.x, self.dx, self.t, every) - np.einsum("kij,kj->ki", B, start)
        torque[:, n:] = np.where(self.moves[:, n:], torque[:, n:], needed[:, n:] - self.recorded)
        return np.abs(torque), np.abs(self.after_x - x)

    def scale(self) -> float:
        """The largest torque, of motors or gears [N m], at least 1."""
        gears = np.abs(self.model.gear_torque(self.x, self.dx)).max()
        return float(max(1.0, gears, np.abs(self.tau).max()))

    def _acceleration(self, x: Array, dx: Array, t: Array, rows: Rows) -> Array:
        """(m, 2n) at times t (m,) of the intervals `rows` (m,), 0 of motors at rest."""
        moves = self.moves[rows]
        rest = np.eye(x.shape[1]) * ~moves[:, None, :]
        B = self.model.mass_matrix(x) * (moves[:, :, None] * moves[:, None, :]) + rest
        return np.asarray(np.linalg.solve(B, (self._force(x, dx, t, rows) * moves)[..., None])[..., 0])

    def _force(self, x: Array, dx: Array, t: Array, rows: Rows) -> Array:
        """Torques less friction and less what the motion needs, (m, 2n)."""
        n = self.model.joints
        force = -self.model.bias_torque(x, dx)
        force[:, n:] += self.tau[rows]
        if self.external is not None:
            states = zip(t.tolist(), x[:, :n], dx[:, :n], strict=True)
            force[:, :n] += np.array([self.external(*state) for state in states])
        for row, at, v in zip(force, rows, dx, strict=True):
            friction = self.frictions[at]
            if friction is not None:
                row -= friction(v)
        return np.asarray(force)

    def _slopes(self, x: Array, dx: Array) -> Array:
        """Slopes (k, 4n, 4n) of the rates by the run's own model: they only decide how fast Newton's iteration ends."""
        n, model, (k, m) = self.model.joints, self.own, x.shape
        J = np.zeros((k, 2 * m, 2 * m))
        J[:, :m, m:] = np.eye(m)
        i = np.arange(n)
        for row, (J_k, q, v) in enumerate(zip(J, x, dx, strict=True)):
            model.link_rows(q, v, np.concatenate([np.zeros(n), self.tau[row]]), J_k[m : m + n])
            for block, slope in enumerate(model.motor_slopes()):
                J_k[m + n + i, block * n + i] = slope
        J[:, m:] *= self.moves[:, :, None]
        return J

    def _step(self, x: Array, dx: Array, t: Array, d: Array) -> tuple[Array, Array]:
        """One step of Radau IIA 5 of d (k, 1) [s] from t (k,)."""
        k, half = x.shape
        m, every = 2 * half, np.arange(k)
        stages, moments = np.repeat(every, 3), (t[:, None] + TIMES * d).ravel()
        y = np.hstack([x, dx])
        f0 = np.hstack([dx, self._acceleration(x, dx, t, every)])
        blocks = np.einsum("ij,kab->kiajb", STAGES, self._slopes(x, dx)).reshape(k, 3 * m, 3 * m)
        newton, z = np.linalg.inv(np.eye(3 * m) - blocks * d[:, :, None]), TIMES[None, :, None] * (d * f0)[:, None, :]
        before = np.inf
        for _ in range(NEWTON_STEPS):
            at = (y[:, None, :] + z).reshape(3 * k, m)
            ddx = self._acceleration(at[:, :half], at[:, half:], moments, stages)
            f = np.hstack([at[:, half:], ddx]).reshape(k, 3, m)
            rest = d[:, :, None] * np.einsum("ij,kja->kia", STAGES, f) - z
            change = np.einsum("kab,kb->ka", newton, rest.reshape(k, 3 * m)).reshape(k, 3, m)
            z = z + change
            size = float(np.abs(change).max())
            if not size > CHANGE or (size < ROUNDING and size > before / 2):
                break
            before = size
        end = y + z[:, 2]
        return end[:, :half], end[:, half:]


def _friction(plant: ElasticPlant, dx: Array, after: Array, still: Mask) -> Callable[[Array], Array] | None:
    """The friction of the sides that the motors move to in an interval; None without friction."""
    sides = np.where(dx != 0.0, np.sign(dx), np.sign(after)).astype(int) * ~still
    torque: FrictionTorque | None = plant.friction.torque(sides, still)
    return torque
