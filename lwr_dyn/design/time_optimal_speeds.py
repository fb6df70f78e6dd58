"""Limits of torque, speed and acceleration along a path q(s), in the squared speed x = ds^2 and u = dds.

    tau = a(s) u + b(s) x + c(s)        a = B q',  b = B q'' + C(q, q') q',  c = g
    ddq = q' u + q'' x                  dq^2 = q'^2 x

On an interval of the grid u is constant and x linear in s. Rows are asked at both ends of an interval, with the values
of that side, so that q'' may jump from one to the next; between them `uses` measures. The fastest squared speeds on the
grid are toppra's, whose only door this is; they become motion profiles made of parabolas.

References
----------
Pham and Pham, A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis, IEEE T-RO 34 (2018).
"""

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.design.path_pieces import PathPiece
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingPackageError
from lwr_dyn.model.friction import JointFriction
from lwr_dyn.trajectory.motion_profile import DEGREE, MotionProfile

INSIDE = 1e-9
"""Share of the piece by which its ends and the ends of intervals are approached from inside."""

PLACES = (0.25, 0.5, 0.75)
"""Of an interval, where its uses are measured besides its ends."""


@dataclass(frozen=True, slots=True, eq=False)
class JointBounds:
    """Limits that a timing keeps: `effort` [N m], `speed` [rad/s], `acceleration` [rad/s^2], (n,) each, inf for none.

    `friction` (n,): the models of the joints; the motors must overcome them too.
    """

    effort: Array
    speed: Array
    acceleration: Array
    friction: tuple[JointFriction | None, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """The limits at places s (k,): torque a u + b x + c (k, n) and q', q'' (k, n)."""

    a: Array
    b: Array
    c: Array
    first: Array
    second: Array

    @classmethod
    def at(cls, piece: PathPiece, dynamics: Dynamics, bounds: JointBounds, s: Array) -> "Rows":
        """At places s (k,) of a piece."""
        q, first, second = piece.curve(np.clip(s, INSIDE * piece.length, (1.0 - INSIDE) * piece.length))
        still = np.zeros_like(q)
        hold = np.asarray(dynamics.gravity_vector(q))
        a = np.asarray(dynamics.inverse_dynamics(q, still, first)) - hold
        b = np.asarray(dynamics.inverse_dynamics(q, first, second)) - hold
        return cls(a, b, hold + np.sign(first) * friction_band(bounds)[0], first, second)

    def torque(self, u: Array, x: Array) -> Array:
        """tau (k, n) [N m] for u and x (k,)."""
        return self.a * u[:, None] + self.b * x[:, None] + self.c

    def acceleration(self, u: Array, x: Array) -> Array:
        """ddq (k, n)."""
        return self.first * u[:, None] + self.second * x[:, None]

    def speed(self, x: Array) -> Array:
        """|dq| (k, n)."""
        return np.abs(self.first) * np.sqrt(x)[:, None]


def friction_band(bounds: JointBounds) -> tuple[Array, Array]:
    """Friction of a moving joint from rest to its speed limit: its middle, and how far it may be off it, (n,) each."""
    middle, half = np.zeros_like(bounds.effort), np.zeros_like(bounds.effort)
    for j, model in enumerate(bounds.friction):
        if model is None:
            continue
        top = bounds.speed[j] if np.isfinite(bounds.speed[j]) else 0.0
        speeds = np.linspace(0.0, top, 201)[1:] if top else np.array([np.finfo(float).tiny])
        found = np.concatenate([model.torque(speeds), -np.asarray(model.torque(-speeds))])
        middle[j], half[j] = 0.5 * (found.max() + found.min()), 0.5 * np.ptp(found)
    return middle, half


KINDS = ("torque", "speed", "acceleration")
"""Of limits."""


@dataclass(frozen=True, slots=True, eq=False)
class Uses:
    """Shares (3, k, n) of the limits of `KINDS` that a timing uses at k places s (k,), and its time there (k,) [s]."""

    s: Array
    shares: Array
    seconds: Array

    def peaks(self) -> Array:
        """The largest of each kind, (3, n)."""
        return np.asarray(self.shares.max(axis=1))

    def peaks_on(self, s: Array) -> Array:
        """The largest on each interval of the grid s (m + 1,) and on its neighbours, (3, m, n)."""
        owner = np.clip(np.searchsorted(s, self.s, side="right") - 1, 0, s.size - 2)
        out = np.zeros((3, s.size + 1, self.shares.shape[2]))
        for kind, found in zip(out, self.shares, strict=True):
            np.maximum.at(kind, owner + 1, found)
        return np.maximum(np.maximum(out[:, :-2], out[:, 1:-1]), out[:, 2:])


def uses(piece: PathPiece, dynamics: Dynamics, bounds: JointBounds, profile: MotionProfile) -> Uses:
    """What a profile of parabolas uses of the limits: at both ends of each parabola, between them, at breaks of q''."""
    knots = np.union1d(profile.knots, [t for s in piece.breaks for t in times_at(profile, float(s))])
    step = np.diff(knots)[:, None]
    times = knots[:-1, None] + step * np.array([INSIDE, *PLACES, 1.0 - INSIDE])
    at = profile.at(times.ravel())
    rows, square = Rows.at(piece, dynamics, bounds, at.s), at.ds**2
    torque = np.abs(rows.torque(at.dds, square)) + friction_band(bounds)[1]
    acceleration = np.abs(rows.acceleration(at.dds, square)) / bounds.acceleration
    shares = np.stack([torque / bounds.effort, rows.speed(square) / bounds.speed, acceleration])
    return Uses(at.s, shares, np.broadcast_to(step / times.shape[1], times.shape).ravel())


def rows_of_intervals(piece: PathPiece, dynamics: Dynamics, bounds: JointBounds, s: Array) -> tuple[Rows, Rows]:
    """The rows at the begin and at the end of each interval of the grid s (m + 1,), seen from inside it."""
    side = INSIDE * np.diff(s)
    begin, end = (Rows.at(piece, dynamics, bounds, at) for at in (s[:-1] + side, s[1:] - side))
    return begin, end


@dataclass(frozen=True, slots=True, eq=False)
class LinearLimits:
    """|a u + b x + c| <= 1 at the m + 1 points of a grid, (m + 1, r) each, and x <= `top` (m + 1,)."""

    a: Array
    b: Array
    c: Array
    top: Array


def linear_limits(begin: Rows, end: Rows, bounds: JointBounds, s: Array, lowered: Array | float = 1.0) -> LinearLimits:
    """The limits on the grid s (m + 1,): those at both ends of the interval that begins there, each as a share.

    `lowered` (3, m, n): factors on the limits of torque, speed and acceleration on each interval.
    """
    factors = np.broadcast_to(lowered, (3, *begin.c.shape))
    twice = 2.0 * np.diff(s)[:, None]  # x at the end is x + 2 ds u
    a = np.hstack([begin.a, end.a + twice * end.b, begin.first, end.first + twice * end.second])
    b = np.hstack([begin.b, end.b, begin.second, end.second])
    c = np.hstack([begin.c, end.c, *np.zeros((2, *begin.c.shape))])
    torque, acceleration = (bounds.effort - friction_band(bounds)[1]) * factors[0], bounds.acceleration * factors[2]
    most = np.hstack([torque, torque, acceleration, acceleration])
    known = np.isfinite(most[0])
    a, b, c = (np.vstack([rows, rows[-1:]])[:, known] for rows in (a / most, b / most, c / most))
    slow = [(np.abs(at.first) / (bounds.speed * factors[1])).max(axis=1) for at in (begin, end)]
    with np.errstate(divide="ignore"):
        top = 1.0 / np.maximum(np.append(slow[0], 0.0), np.append(0.0, slow[1])) ** 2
    return LinearLimits(a, b, c, top)


NAME = "least time"

EARLY = 1e-12
"""Share of its time by which a knot lies before its sample, so that rounding cannot put it behind."""


def profile_of_squares(s: Array, x: Array) -> MotionProfile:
    """s(t) with ds^2 = x (k,) at s (k,), from 0 and from rest to rest; dds is constant between two places."""
    speed = np.sqrt(x)
    return _parabolas(2.0 * np.diff(s) / (speed[:-1] + speed[1:]), s, speed)


def on_samples(profile: MotionProfile, rate: float) -> MotionProfile:
    """The profile with dds constant from sample to sample, `rate` [Hz] of them a second, and no faster anywhere.

    At the samples it has the speeds of the profile, stretched to a whole number of samples and by what the corners
    that are cut off take from its length.
    """
    samples = max(2, int(np.ceil(profile.duration * rate * (1.0 - 1e-12))))
    while True:
        times = np.full(samples, (1.0 - EARLY) / rate)
        speed = profile.at(np.linspace(0.0, profile.duration, samples + 1)).ds.copy()
        speed[[0, -1]] = 0.0
        s = np.concatenate([[0.0], np.cumsum(0.5 * (speed[:-1] + speed[1:]) * times)])
        if s[-1] >= profile.length:
            return _parabolas(times, s * (profile.length / s[-1]), speed * (profile.length / s[-1]))
        samples += 1


def times_at(profile: MotionProfile, s: float) -> list[float]:
    """When a profile that never stands still is at s, 0 < s < length [s]."""
    at = profile.at(profile.knots).s
    k = int(np.searchsorted(at, s, side="right")) - 1
    start, speed, half = profile.coefficients[k, :3]
    root = np.sqrt(max(speed**2 + 4.0 * half * (s - start), 0.0))
    return [float(profile.knots[k] + 2.0 * (s - start) / (speed + root))] if speed + root > 0.0 else []


def _parabolas(times: Array, s: Array, speed: Array) -> MotionProfile:
    c = np.zeros((times.size, DEGREE + 1))
    c[:, 0], c[:, 1], c[:, 2] = s[:-1], speed[:-1], np.diff(speed) / (2.0 * times)
    return MotionProfile(NAME, float(s[-1]), np.concatenate([[0.0], np.cumsum(times)]), c)


INSTEAD = "the timings of the task itself, as --timing smooth-blended"

FASTEST = 1e8
"""Largest squared speed that toppra takes, of a path of length 1."""


def fastest_squares(s: Array, limits: LinearLimits) -> Array | None:
    """x = ds^2 (m + 1,) at the grid s (m + 1,), rising from 0, from rest to rest; None where toppra finds none.

    Raises `MissingPackageError`: toppra is not installed.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of its strings, where Python compiles it for the first time
            from toppra.algorithm import TOPPRA
            from toppra.constraint import LinearConstraint
            from toppra.interpolator import AbstractGeometricPath
    except ModuleNotFoundError as fault:
        raise MissingPackageError(fault.name or "toppra", "design", INSTEAD) from None
    length, rows = float(s[-1]), limits.a.shape[1]
    tempo = 1.0 / float(np.abs(limits.a).max() * length)

    class Grid(AbstractGeometricPath):  # type: ignore[misc]
        """toppra asks this path for its interval only: the limits on it are computed before, with exact derivatives."""

        dof, path_interval, waypoints = 1, np.array([0.0, 1.0]), None

    class Given(LinearConstraint):  # type: ignore[misc]
        """Limits that are known already, on a path of length 1, in a unit of time in which the largest a is 1."""

        def __init__(self) -> None:
            super().__init__()
            self.dof, self.identical = 1, True

        def compute_constraint_params(self, *_: Any, **__: Any) -> tuple[Any, ...]:
            both = np.vstack([np.eye(rows), -np.eye(rows)])
            top = np.column_stack([np.zeros(s.size), np.minimum(limits.top / (length**2 * tempo), FASTEST)])
            a, b = limits.a * (length * tempo), limits.b * (length**2 * tempo)
            return a, b, limits.c, both, np.ones(2 * rows), None, top

    with _quiet():
        solver = TOPPRA([Given()], Grid(), gridpoints=s / length, solver_wrapper="seidel")
        speeds = solver.compute_parameterization(0.0, 0.0)[1]
    return None if speeds is None or not np.isfinite(speeds).all() else np.asarray(speeds**2 * (length**2 * tempo))


@contextmanager
def _quiet() -> Iterator[None]:
    """Without toppra's warnings: what it cannot solve is an error of ours."""
    logger = logging.getLogger("toppra")
    before, logger.disabled = logger.disabled, True
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.disabled = before
        logger.setLevel(level)
