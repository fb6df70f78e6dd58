"""One direction of a friction map -> parameters: viscous and Coulomb by linear least squares, Stribeck by nonlinear."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy.optimize import least_squares

from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.friction.friction_map import FrictionPoint
from lwr_dyn.identification.regression.least_squares import HUBER, Estimate, has_full_rank, huber, weighted
from lwr_dyn.model.friction import Direction

Model = Literal["viscous+coulomb", "stribeck"]
MODELS = get_args(Model)
NAMES = {
    "viscous+coulomb": ("coulomb", "viscous"),
    "stribeck": ("coulomb", "viscous", "static", "stribeck_velocity"),
}
SAME_SPEED = 0.02
"""Share by which two speeds must differ to count as two."""
STRIBECK_CANDIDATES = 60
"""Stribeck velocities tried, evenly in their logarithm, before the best is refined."""
SCALES = 4
"""Rounds of a robust refinement, each with the noise that the one before leaves."""
WITHIN = 3.0
"""A Stribeck velocity must lie between the slowest speed over this and the fastest times this."""


@dataclass(frozen=True, slots=True, eq=False)
class DirectionFit:
    """Friction of one direction of one joint: magnitudes against the motion, as `model.friction.Direction`.

    An offset cannot be separated: it raises one direction's Coulomb level and lowers the other's.
    """

    joint: int
    sign: int
    model: Model
    robust: bool
    estimate: Estimate
    slowest: float
    fastest: float
    bias: Array | None
    """What averaging puts on each parameter when B ddq + C dq is left in (p,); None without a model of the arm."""

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters, as `estimate.values` has them."""
        return NAMES[self.model]

    def magnitude(self, speed: Array) -> Array:
        """The fitted friction against the motion at speeds (k,) > 0."""
        return _magnitude(self.estimate.values, speed)

    def direction(self) -> Direction:
        """As a friction model; raises `OptionError` for what no friction can be, such as a negative Coulomb level."""
        return Direction(*(float(v) for v in self.estimate.values))


def fit_direction(
    points: Sequence[FrictionPoint], model: Model = "viscous+coulomb", robust: bool = False,
    equal_weights: bool = False, inertia_left_in: bool = False,
) -> DirectionFit:  # fmt: skip
    """Fit the points of one joint in one direction.

    Parameters
    ----------
    model : {"viscous+coulomb", "stribeck"}
        F = Fc + sigma v (the paper's eq. 6), or with (Fs - Fc) exp(-(v/vs)^2) more.
    robust : bool
        Huber's loss instead of squares.
    equal_weights : bool
        Every cruise counts the same, as in the paper's eq. (7). Otherwise it counts as many times as it has samples,
        which is right where noise of the samples is what the averages miss the model by.
    inertia_left_in : bool
        Whether the torques still hold B ddq + C dq, so that `bias` is what they put on the parameters.

    Raises
    ------
    OptionError
        Another model.
    LogError
        Too few speeds for the model: names the joint's column, what is there and what is needed.

    References
    ----------
    Pineda Rico et al. (2012), eqs. (6), (7), section 3.3.1; Olsson et al. (1998), eq. (5).
    """
    if model not in MODELS:
        raise OptionError("friction model", repr(model), ", ".join(MODELS))
    sign = 1 if points[0].velocity > 0 else -1
    v = np.array([abs(p.velocity) for p in points])
    y = np.array([sign * p.torque for p in points])
    weights = np.ones_like(v) if equal_weights else np.array([float(p.samples) for p in points])
    count = distinct_speeds(v)
    if count < len(NAMES[model]):
        found = f"{count} speed{'s' if count > 1 else ''} ({v.min():.4g} to {v.max():.4g} rad/s)"
        raise _undetermined(points, found)
    estimate = _fitted(v, y, weights, model, robust)
    if estimate is None:
        raise _undetermined(points, "no Stribeck velocity within the speeds fits best")
    bias = None
    if points[0].inertia is not None:
        extra = np.array([sign * (p.inertia or 0.0) for p in points])
        other = _fitted(v, y - extra if inertia_left_in else y + extra, weights, model, robust)
        if other is not None:
            bias = read_only((estimate.values - other.values) * (1 if inertia_left_in else -1))
    return DirectionFit(points[0].joint, sign, model, robust, estimate, float(v.min()), float(v.max()), bias)


def distinct_speeds(v: Array) -> int:
    """How many speeds there are, those within 2 % of each other counted once.

    >>> distinct_speeds(np.array([0.1, 0.1005, 0.2]))
    2
    """
    count, last = 0, 0.0
    for speed in np.sort(v).tolist():
        if count == 0 or speed > last * (1 + SAME_SPEED):
            count, last = count + 1, speed
    return count


def _undetermined(points: Sequence[FrictionPoint], found: str) -> LogError:
    files = ", ".join(dict.fromkeys(p.source for p in points))
    way = "positive" if points[0].velocity > 0 else "negative"
    where = f"column q{points[0].joint}, {way} direction"
    needed = "two or more different speeds each way for Coulomb and viscous friction, four around the dip for Stribeck"
    return LogError(files, where, f"{found} in {len(points)} cruise{'s' if len(points) > 1 else ''}", needed)


def _fitted(v: Array, y: Array, weights: Array, model: Model, robust: bool) -> Estimate | None:
    """With a Stribeck velocity, in all else linear: the best of many, then all four parameters refined together."""
    solve = huber if robust else weighted
    if model == "viscous+coulomb":
        return solve(np.column_stack([np.ones_like(v), v]), y, weights)
    low, high = v.min() / WITHIN, v.max() * WITHIN
    best, start = np.inf, None
    for vs in np.geomspace(low, high, STRIBECK_CANDIDATES):
        X = np.column_stack([np.ones_like(v), v, np.exp(-np.square(v / float(vs)))])
        if not has_full_rank(X):
            continue
        estimate = solve(X, y, weights)
        misses = np.abs(np.sqrt(weights) * estimate.residuals)
        loss = float(misses.sum() if robust else misses @ misses)  # squares would follow a wild cruise
        if loss < best:
            coulomb, viscous, extra = estimate.values
            best, start = loss, np.array([coulomb, viscous, coulomb + extra, vs])
    return None if start is None else _refined(start, v, y, weights, robust, (low, high))


def _refined(
    start: Array, v: Array, y: Array, weights: Array, robust: bool, between: tuple[float, float]
) -> Estimate | None:
    root = np.sqrt(weights)

    def misses(b: Array) -> Array:
        return np.asarray(root * (_magnitude(b, v) - y))

    def derivatives(b: Array) -> Array:
        return np.asarray(root[:, None] * _jacobian(b, v))

    for _ in range(SCALES if robust else 1):  # what is left of a start between two candidates is no noise
        scale = HUBER * max(1.4826 * float(np.median(np.abs(misses(start)))), 1e-12 * float(np.abs(root * y).max()))
        done = least_squares(
            misses, start, jac=derivatives,
            x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15, loss="huber" if robust else "linear", f_scale=scale,
        )  # fmt: skip
        start = done.x
    if not between[0] < done.x[3] < between[1]:
        return None
    J = _jacobian(done.x, v)
    if not has_full_rank(J):
        return None
    # the tangent plane at the minimum is a linear problem: its covariance is that of the parameters
    tangent = (huber if robust else weighted)(J, y - _magnitude(done.x, v) + J @ done.x, weights)
    return Estimate(done.x, tangent.covariance, y - _magnitude(done.x, v), tangent.dof)


def _magnitude(b: Array, v: Array) -> Array:
    line: Array = b[0] + b[1] * v
    return line if b.size == 2 else line + (b[2] - b[0]) * np.exp(-np.square(v / b[3]))


def _jacobian(b: Array, v: Array) -> Array:
    stribeck = np.exp(-np.square(v / b[3]))
    return np.column_stack([1 - stribeck, v, stribeck, (b[2] - b[0]) * stribeck * 2 * v**2 / b[3] ** 3])
