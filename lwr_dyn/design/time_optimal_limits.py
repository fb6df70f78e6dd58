"""Limits of torque, speed and acceleration along a path q(s), in the squared speed x = ds^2 and u = dds.

    tau = a(s) u + b(s) x + c(s)        a = B q',  b = B q'' + C(q, q') q',  c = g
    ddq = q' u + q'' x                  dq^2 = q'^2 x

On an interval of the grid u is constant and x linear in s. Rows are asked at both ends of an interval, with the values
of that side, so that q'' may jump from one to the next; between them `uses` measures.

References
----------
Pham and Pham, A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis, IEEE T-RO 34 (2018).
"""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.design.time_optimal_pieces import PathPiece
from lwr_dyn.design.time_optimal_profiles import times_at
from lwr_dyn.design.toppra_solver import LinearLimits
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.friction import JointFriction
from lwr_dyn.trajectory.motion_profile import MotionProfile

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


@dataclass(frozen=True, slots=True, eq=False)
class Uses:
    """Shares of the limits (k, n) that a timing uses at k places s (k,), and its time there (k,) [s]."""

    s: Array
    torque: Array
    speed: Array
    acceleration: Array
    seconds: Array

    def peaks(self) -> Array:
        """The largest of torque, speed and acceleration, (3, n)."""
        return np.stack([self.torque.max(axis=0), self.speed.max(axis=0), self.acceleration.max(axis=0)])

    def peaks_on(self, s: Array) -> Array:
        """The largest on each interval of the grid s (m + 1,) and on its neighbours, (3, m, n)."""
        owner = np.clip(np.searchsorted(s, self.s, side="right") - 1, 0, s.size - 2)
        out = np.zeros((3, s.size + 1, self.torque.shape[1]))
        for k, found in enumerate((self.torque, self.speed, self.acceleration)):
            np.maximum.at(out[k], owner + 1, found)
        return np.maximum(np.maximum(out[:, :-2], out[:, 1:-1]), out[:, 2:])


def uses(piece: PathPiece, dynamics: Dynamics, bounds: JointBounds, profile: MotionProfile) -> Uses:
    """What a profile of parabolas uses of the limits: at both ends of each parabola, between them, at breaks of q''."""
    knots = np.union1d(profile.knots, [t for s in piece.breaks for t in times_at(profile, float(s))])
    step = np.diff(knots)[:, None]
    times = knots[:-1, None] + step * np.array([INSIDE, *PLACES, 1.0 - INSIDE])
    at = profile.at(times.ravel())
    rows, square = Rows.at(piece, dynamics, bounds, at.s), at.ds**2
    torque = np.abs(rows.torque(at.dds, square)) + friction_band(bounds)[1]
    return Uses(
        at.s,
        torque / bounds.effort,
        rows.speed(square) / bounds.speed,
        np.abs(rows.acceleration(at.dds, square)) / bounds.acceleration,
        np.broadcast_to(step / times.shape[1], times.shape).ravel(),
    )


def rows_of_intervals(piece: PathPiece, dynamics: Dynamics, bounds: JointBounds, s: Array) -> tuple[Rows, Rows]:
    """The rows at the begin and at the end of each interval of the grid s (m + 1,), seen from inside it."""
    side = INSIDE * np.diff(s)
    begin, end = (Rows.at(piece, dynamics, bounds, at) for at in (s[:-1] + side, s[1:] - side))
    return begin, end


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
