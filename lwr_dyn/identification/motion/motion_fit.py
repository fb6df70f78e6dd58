"""Identification from any motion: least squares on the Newton-Euler regressor plus friction, judged on held-out time.

Beyond the paper, which needs constant velocities. The parameters are base parameters: other sets give the same torques.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d
from scipy.signal import savgol_filter

from lwr_dyn.arrays import Array
from lwr_dyn.dynamics.regressor import JOINT, Regressor, chain_parameters
from lwr_dyn.errors import OptionError
from lwr_dyn.identification.bodies.possible_bodies import BodyVerdict, judge_bodies
from lwr_dyn.identification.friction.torque_model import DEGREE, local_derivatives
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.log_columns import LogError
from lwr_dyn.identification.logs.recordings import recordings
from lwr_dyn.identification.regression.base_parameters import ROUNDING, BaseParameters, base_parameters
from lwr_dyn.identification.regression.least_squares import IDENTIFIED, Estimate, has_full_rank, weighted
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.shown import repr_html, short_repr

MOST_ROWS = 20_000
"""Instants used at most: more are thinned out evenly."""
PROBES = 300
"""Random states whose regressor determines the base parameters of a chain."""


@dataclass(frozen=True, slots=True)
class MotionRule:
    """How instants are taken from logs.

    Parameters
    ----------
    window : float
        Span of the local cubics that give velocities and accelerations and smooth the torques [s]; one instant is
        used for each, so their noise is not shared.
    slowest : float
        Speed below which a joint's equation is left out: dry friction is not determined there [rad/s or m/s].
    held_out : float
        Share of every recording, at its end, that is kept for validation.

    Raises
    ------
    OptionError
        A window or speed that is not above 0, a share not between 0 and 1.
    """

    window: float = 0.1
    slowest: float = 0.02
    held_out: float = 0.25

    def __post_init__(self) -> None:
        for name in ("window", "slowest"):
            if not (isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise OptionError(f"motion {name}", getattr(self, name), "a number above 0")
        if not 0.0 < self.held_out < 1.0:
            raise OptionError("held out share", self.held_out, "a number between 0 and 1")


DEFAULT_MOTION = MotionRule()


@dataclass(frozen=True, slots=True, eq=False)
class Instants:
    """Smoothed instants of logs: q, dq, ddq, tau (k, n), which equations are used (k, n), which are held out (k,)."""

    q: Array
    dq: Array
    ddq: Array
    tau: Array
    counts: NDArray[np.bool_]
    held: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Validation:
    """RMS torques of one joint [N m or N]: measured, and what is left by the fit and by the arm's own model.

    `fitted` is on the time the fit saw, the others on the held-out time; `model` has the arm's inertias, no friction.
    """

    joint: int
    measured: float
    fitted: float
    held_out: float
    model: float


@dataclass(frozen=True, slots=True, eq=False)
class MotionIdentification:
    """Base parameters with their estimate, and how well they predict torques that they were not fitted to.

    `condition` is that of the scaled regressor: above a few hundred the motion excites some parameters poorly.
    """

    base: BaseParameters
    estimate: Estimate
    of_the_model: Array
    """Values from the arm's own inertias for the base parameters (b,), friction 0."""
    condition: float
    validation: tuple[Validation, ...]
    equations: int
    bodies: BodyVerdict
    """Whether no bodies can have the values."""
    __repr__ = short_repr
    _repr_html_ = repr_html

    @property
    def states(self) -> tuple[str, ...]:
        """Of each base parameter: identified, or why not (`Estimate.states`)."""
        return self.estimate.states(self.of_the_model)

    @property
    def identified(self) -> int:
        """How many base parameters are identified."""
        return self.states.count(IDENTIFIED)


def identify_motion(logs: Iterable[JointLog], arm: Arm, rule: MotionRule = DEFAULT_MOTION) -> MotionIdentification:
    """Inertial and friction parameters from recordings of any motion.

    Parameters
    ----------
    logs : iterable of JointLog
        Evenly sampled.
    arm : Arm
        Gives the geometry; its masses only serve for comparison.
    rule : MotionRule

    Returns
    -------
    MotionIdentification

    Raises
    ------
    LogError
        Uneven or too few rows, or a motion that leaves parameters undetermined: names them.
    """
    regressor = Regressor(arm.chain)
    base = chain_base(arm)
    several = list(logs)
    seen = _samples(several, rule)
    W = regressor(seen.q, seen.dq, seen.ddq)[:, :, base.kept]
    training = seen.counts & ~seen.held[:, None]
    _check_excited(several, W, training, base)
    estimate = _fit(W, seen.tau, training)
    left = seen.tau - W @ estimate.values
    of_the_model = base.of(chain_parameters(arm.chain))
    of_the_model[np.abs(of_the_model) < ROUNDING] = 0.0
    own = seen.tau - W @ of_the_model
    held = seen.counts & seen.held[:, None]
    validation = tuple(
        Validation(j + 1, _rms(seen.tau, held, j), _rms(left, training, j), _rms(left, held, j), _rms(own, held, j))
        for j in range(arm.n)
    )
    scaled = W[training] / np.linalg.norm(W[training], axis=0)
    condition, bodies = float(np.linalg.cond(scaled)), judge_bodies(arm, base, estimate)
    return MotionIdentification(base, estimate, of_the_model, condition, validation, int(training.sum()), bodies)


def chain_base(arm: Arm) -> BaseParameters:
    """The base parameters of an arm's geometry and friction, from random states."""
    regressor = Regressor(arm.chain)
    q, dq, ddq = np.random.default_rng(0).uniform(-2.0, 2.0, (3, PROBES, arm.n))
    Y = regressor(q, dq, ddq)
    return base_parameters(Y.reshape(-1, Y.shape[-1]), regressor.names)


def _samples(logs: Sequence[JointLog], rule: MotionRule) -> Instants:
    total = sum(log.t.size for log in logs)
    parts = [part for log in logs for piece in recordings(log.t) for part in [_piece(log, piece, rule, total)]]
    if not parts:
        raise LogError("logs", "rows", "none", "recordings of a moving arm")
    names = ("q", "dq", "ddq", "tau", "counts", "held")
    return Instants(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def _piece(log: JointLog, piece: slice, rule: MotionRule, total: int) -> Instants:
    dq, ddq = local_derivatives(log, piece, rule.window)
    step = float(np.median(np.diff(log.t[piece])))
    window = max(DEGREE + 2, 2 * round(rule.window / (2 * step)) + 1)
    q, tau = (savgol_filter(x[piece], window, DEGREE, axis=0) for x in (log.q, log.tau))
    stride = max(window, -(-total // MOST_ROWS))
    chosen = np.arange(window // 2, len(q) - window // 2, stride)
    one_way = (minimum_filter1d(dq, window, axis=0) > rule.slowest) | (
        maximum_filter1d(dq, window, axis=0) < -rule.slowest
    )
    held = chosen >= (1.0 - rule.held_out) * len(q)
    return Instants(q[chosen], dq[chosen], ddq[chosen], tau[chosen], one_way[chosen], held)


def _check_excited(logs: Sequence[JointLog], W: Array, training: NDArray[np.bool_], base: BaseParameters) -> None:
    rows = W[training]
    if has_full_rank(rows):
        return
    files = ", ".join(dict.fromkeys(log.source for log in logs))
    silent = [base.names[k] for k, column in zip(base.kept, rows.T, strict=True) if not column.any()]
    joints = len(base.names) // (10 + len(JOINT))
    what = ", ".join(silent) if silent else f"{base.count} parameters from {len(rows)} equations of {joints} joints"
    needed = "motion of every joint both ways, at changing speeds"
    raise LogError(files, f"columns q1..q{joints}", f"{what} not determined", needed)


def _fit(W: Array, tau: Array, rows: NDArray[np.bool_]) -> Estimate:
    """Least squares with every joint weighted by its own noise, estimated from a first fit."""
    y, X, joint = tau[rows], W[rows], np.nonzero(rows)[1]
    noise = np.ones(tau.shape[1])
    for _ in range(2):
        estimate = weighted(X, y, 1.0 / noise[joint] ** 2)
        squares = np.bincount(joint, estimate.residuals**2, tau.shape[1])
        mean = squares / np.maximum(1, np.bincount(joint, minlength=tau.shape[1]))
        noise = np.sqrt(np.maximum(mean, 1e-24 + 1e-24 * float(np.mean(np.square(y)))))
    return weighted(X, y, 1.0 / noise[joint] ** 2)


def _rms(values: Array, rows: NDArray[np.bool_], joint: int) -> float:
    chosen = values[rows[:, joint], joint]
    return float(np.sqrt(np.mean(np.square(chosen)))) if chosen.size else float("nan")
