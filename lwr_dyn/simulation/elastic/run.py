"""`run_elastic`: a sampled run of an arm with elastic joints, with its record and its audit.

Events, and steps that the exponential refuses, are moved by Radau IIA of order 5: stiffly accurate and L-stable, so
stiff springs and dampers cost nothing. Its slopes are differences of the rates, so it follows any contact mode. Work
that the motion does not feel is summed with the stages' weights.

The audit of every run moves it again by another engine and this method. At samples of the run the state
(q, theta, dq, dtheta) is followed through one interval under the recorded torque, and its end is compared with the next
sample:

    residual = M(q) (dq_{k+1} - dq') / h,  B (dtheta_{k+1} - dtheta') / h [N m],   gap = |q_{k+1} - q'|, ... [rad]

Intervals with an event, and those in which a link leans on a stop, are left out. A motor at rest stays there, and what
has to hold it is compared with the recorded friction.

References
----------
E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., section IV.5, Table 5.6.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from lwr_dyn.control.protocol import reset
from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.arm_friction import FrictionTorque, Mask
from lwr_dyn.simulation.audit import Audit, OtherRoad, Rows, uneventful
from lwr_dyn.simulation.elastic.exponential import ElasticFlow, ElasticStep, OneSide
from lwr_dyn.simulation.elastic.plant import ElasticPlant, elastic_plant
from lwr_dyn.simulation.integrators import Integrator, Rates
from lwr_dyn.simulation.loops import Diverged, Log, Progress, divergence, run_sampled, unaudited_run
from lwr_dyn.simulation.plant import ExternalTorque, checked_external
from lwr_dyn.simulation.setup import Setup

_R = np.sqrt(6.0)

STAGES = np.array(
    [
        [(88 - 7 * _R) / 360, (296 - 169 * _R) / 1800, (-2 + 3 * _R) / 225],
        [(296 + 169 * _R) / 1800, (88 + 7 * _R) / 360, (-2 - 3 * _R) / 225],
        [(16 - _R) / 36, (16 + _R) / 36, 1 / 9],
    ]
)

TIMES = STAGES.sum(axis=1)

MOST_ITERATIONS = 100
"""Steep friction, whose slope changes within a step, takes 40; smooth motion takes 5."""

STAGE_CHANGE = 1e-14
"""Of the largest entry of the state: smaller changes of the stages are rounding."""

SLOPE_STEP = 1e-7
"""[rad, rad/s] of the differences for the slopes, which only speed Newton's iteration up."""


def radau(motion: int, substeps: int = 1) -> Integrator:
    """The method, for states whose first `motion` entries decide about the rates; a failed step gives NaN.

    >>> x = radau(1, 4)(lambda t, x: -1e6 * (x - 1.0), 0.0, np.zeros(1), 1.0)
    >>> bool(abs(x[0] - 1.0) < 1e-12)
    True
    """
    slopes_at = _remembered(motion)

    def advance(rates: Rates, t: float, x: Array, h: float) -> Array:
        d = h / substeps
        for i in range(substeps):
            s = t + i * d
            f0, J = slopes_at(rates, s, x)
            x = _step(rates, s, x, d, f0, J, motion)
        return x

    return advance


def _step(rates: Rates, t: float, x: Array, d: float, f0: Array, J: Array, m: int) -> Array:
    if not np.isfinite(J).all():
        return np.full_like(x, np.nan)
    newton = np.linalg.inv(np.eye(3 * m) - d * np.kron(STAGES, J))
    scale = STAGE_CHANGE * max(1.0, float(np.abs(x[:m]).max()))
    z, best = np.outer(TIMES * d, f0), np.inf
    for _ in range(MOST_ITERATIONS):
        f = np.array([rates(t + c * d, x + part) for c, part in zip(TIMES, z, strict=True)])
        rest = d * STAGES @ f - z
        change = (newton @ rest[:, :m].ravel()).reshape(3, m)
        z[:, :m] += change
        z[:, m:] += rest[:, m:]
        z[:, (f == 0.0).all(axis=0)] = 0.0  # what rests stays to the last bit: Newton's matrix leaves roundings
        size = float(np.abs(change).max())
        if not np.isfinite(size):
            break
        if size <= scale or (size >= best and size <= 1e3 * scale):
            return np.asarray(x + z[2])
        best = min(best, size)
    return np.full_like(x, np.nan)


def _remembered(m: int) -> Callable[[Rates, float, Array], tuple[Array, Array]]:
    """Rates and slopes (m, m) at a state; those of the last one are kept, since events ask for them again."""
    known: tuple[float, bytes, Array, Array] | None = None

    def slopes_at(rates: Rates, t: float, x: Array) -> tuple[Array, Array]:
        nonlocal known
        key = x.tobytes()
        if known is None or known[0] != t or known[1] != key:
            f0 = rates(t, x)
            J = np.empty((m, m))
            for j in range(m):
                moved = x.copy()
                moved[j] += SLOPE_STEP
                J[:, j] = (rates(t, moved)[:m] - f0[:m]) / SLOPE_STEP
            known = t, key, f0, J
        return known[2], known[3]

    return slopes_at


JUDGED = 50
"""Intervals of a run, evenly spread."""

STEPS = 2
"""Radau steps for each step of the run."""

METHOD_TORQUE = 1e-6
"""Of the largest torque: what the two methods may differ by, seen as a torque over an interval; 1e-9 to 1e-7 seen."""

METHOD_GAP = 1e-9
"""[rad] by which the two methods may differ in an interval; 1e-12 to 1e-10 seen."""

NEWTON_STEPS = 100

BASE_CHANGE = 1e-13
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
        self.substeps = run.setup.loop.substeps
        self.tau, self.recorded, self.external = run.tau_applied[rows], run.tau_friction[rows], run.setup.loop.external
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
            if not size > BASE_CHANGE or (size < ROUNDING and size > before / 2):
                break
            before = size
        end = y + z[:, 2]
        return end[:, :half], end[:, half:]


def _friction(plant: ElasticPlant, dx: Array, after: Array, still: Mask) -> Callable[[Array], Array] | None:
    """The friction of the sides that the motors move to in an interval; None without friction."""
    sides = np.where(dx != 0.0, np.sign(dx), np.sign(after)).astype(int) * ~still
    torque: FrictionTorque | None = plant.friction.torque(sides, still)
    return torque


TOLERANCE = 1e-7
"""[J] of the energy audit for a run of 14 s at 1 kHz: springs of 1e4 N m/rad turn the method's error, 1e-12 rad a step,
into 1e-9 to 1e-8 J in all; dry friction and stops leave a little more. Substeps leave less."""

METHODS = {"rk4": "exponential", "radau": "radau"}
"""Option `method` of a run -> what moves elastic joints."""


def run_elastic(setup: Setup, progress: Progress | None = None) -> Run:
    """As `lwr_dyn.simulation.simulate.run_setup`, of elastic joints: q and dq of the run are the links'.

    Signals of the run are "theta" [rad], "dtheta" [rad/s] (the motors, seen at the joints) and "torque_sensor" [N m]
    (what goes through the gears); its channel "damper" is the work of the gears' dampers. Raises `MissingDataError`,
    `OptionError` (as `elastic_plant`; a continuous run, a method for rigid joints), `DivergenceError` (as `run_setup`).
    """
    loop = setup.loop
    if loop.continuous:
        raise OptionError("continuous", "with elastic joints", "a sampled run")
    if loop.method not in METHODS:
        raise OptionError("method", f"{loop.method} with elastic joints", "rk4 (an exponential step), radau")
    plant = elastic_plant(setup)
    log, wide = _wide(setup, plant)
    flow = ElasticFlow(plant, radau(4 * plant.arm.n, loop.substeps), wide.loop.external)
    meta = setup.record()
    meta["options"] = {**meta["options"], "method": METHODS[loop.method]}
    reset(setup.controller)
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            run_sampled(wide, flow, log, progress, ElasticStep)
    except Diverged as end:
        raise divergence(end, setup, log, meta, lambda meta: _run_of(setup, plant, log, flow, meta)) from None
    return _run_of(setup, plant, log, flow, meta)


def _wide(setup: Setup, plant: ElasticPlant) -> tuple[Log, Setup]:
    """The setup for 2n coordinates, with its log; in its first state the springs carry the arm."""
    model, (q, dq) = plant.model, setup.start
    theta = q + model.links.bias_torque(q, dq) / model.stiffness
    loop = setup.loop
    pushed = replace(loop, external=None if loop.external is None else _on_links(loop.external, plant.arm.n))
    wide = replace(setup, plant=plant, start=read_only([[*q, *theta], [*dq, *dq]]), loop=pushed)
    log = Log.blank(wide)
    return log, replace(wide, controller=OneSide(setup.controller, model, loop.encoders, log))


def _on_links(external: ExternalTorque, n: int) -> ExternalTorque:
    checked, still = checked_external(external, n), np.zeros(n)
    return lambda t, x, dx: np.concatenate([checked(t, x[:n], dx[:n]), still])


def _run_of(setup: Setup, plant: ElasticPlant, log: Log, flow: ElasticFlow, meta: Mapping[str, Any]) -> Run:
    """The run as far as it was computed."""
    n, done, model = plant.arm.n, log.done, plant.model
    x, dx = log.states[:done, 0], log.states[:done, 1]
    sides = {"theta": x[:, n:], "dtheta": dx[:, n:], "torque_sensor": model.gear_torque(x, dx)}
    damper = {"damper": np.cumsum([0.0, *flow.damped])[:done]}
    run = unaudited_run(setup, log, flow, meta, model.energies(x, dx), sides, damper)
    cut = (run.tau_command != run.tau_applied).mean(axis=0).round(6).tolist()
    return replace(run, meta={**run.meta, "cut_share": cut, "audit": elastic_audit(run, plant).to_json()})


def elastic_audit(run: Run, plant: ElasticPlant) -> Audit:
    """The audit of a run of this plant: as `lwr_dyn.simulation.audit.audit`, with springs, dampers and rotors."""
    road = second_road(run, plant)
    return Audit.of(run, actuator_gap=None, energy_gap=None, other_road=road, tolerance=TOLERANCE)
