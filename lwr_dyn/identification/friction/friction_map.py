"""The friction-velocity map: one point for every cruise, the averages of velocity and torque over it.

A cruise is a stretch of a recording in which a joint moves at constant speed, by its positions alone. An arm's model
may take its part out of the torques row by row: gravity, inertia (B ddq + C dq), or both.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite, sqrt
from typing import Annotated, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.log_columns import even_step, recordings
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import ZERO

SIGMAS = 5.0
"""Standard deviations of the position noise by which a speed may wander and count as constant."""
LEAST_ROWS = 5


@dataclass(frozen=True, slots=True)
class CruiseRule:
    """What counts as a cruise: every number above 0, else it raises `OptionError`."""

    shortest: Annotated[float, "Least duration, s."] = 0.5
    window: Annotated[
        float, "Span over which a speed is taken, s; a change of speed is one between two neighbouring spans."
    ] = 0.2
    tolerance: Annotated[float, "Share of its speed by which a cruise may wander."] = 0.03
    slowest: Annotated[float, "Least speed that is a motion, rad/s (m/s)."] = 1e-3

    def __post_init__(self) -> None:
        for name in ("shortest", "window", "tolerance", "slowest"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0.0):
                raise OptionError(f"cruise {name}", value, "a number above 0")


DEFAULT_CRUISE = CruiseRule()


@dataclass(frozen=True, slots=True)
class Cruise:
    """Rows `first` to `last` (from 0, both inside) in which a joint moves at constant speed, and for how long [s]."""

    first: int
    last: int
    duration: float


def find_cruises(t: Array, q: Array, rule: CruiseRule = DEFAULT_CRUISE) -> tuple[Cruise, ...]:
    """Every constant-speed stretch of one joint, t and q (k,), the short ones too: see `CruiseRule.shortest`.

    The speed of a row is the slope between the rows half a window before and after it. It is steady where neighbouring
    slopes differ by at most the tolerance (or by what the position noise explains); a steady stretch is then cut to the
    longest part that stays within the tolerance of its own median.

    >>> t = np.arange(300) / 100
    >>> [(c.first, c.last) for c in find_cruises(t, 0.2 * np.clip(t, 0.5, 2.5))]
    [(67, 233)]
    """
    return tuple(c for piece in recordings(t) for c in _in_piece(t[piece], q[piece], piece.start, rule))


def position_noise(q: Array) -> float:
    """Standard deviation of the noise in positions (k,) [rad or m], rounding to counts included.

    Third differences are free of any motion of constant acceleration; white noise enters them 20-fold in variance.
    A joint that stands still shows no rounding, so a count over sqrt(12) is the least.
    """
    third = np.abs(np.diff(q, 3))
    moves = np.abs(np.diff(q))
    moves = moves[moves > 0.0]
    if not (third.size and moves.size):
        return 0.0
    return max(1.4826 * float(np.median(third)) / sqrt(20.0), float(moves.min()) / sqrt(12.0))


def _in_piece(t: Array, q: Array, start: int, rule: CruiseRule) -> list[Cruise]:
    if t.size < LEAST_ROWS:
        return []
    step = float(np.median(np.diff(t)))
    h = max(1, round(rule.window / (2 * step)))
    if t.size < 4 * h + LEAST_ROWS:
        return []
    speed = (q[2 * h :] - q[: -2 * h]) / (t[2 * h :] - t[: -2 * h])  # of rows h .. k-h-1
    noise = SIGMAS * sqrt(2.0) * position_noise(q) / (2 * h * step)
    inner = speed[h:-h]  # of rows 2h .. k-2h-1
    change = np.abs(speed[2 * h :] - speed[: -2 * h])
    moving = np.abs(inner) > np.maximum(rule.slowest, 2 * noise)
    steady = moving & (change <= rule.tolerance * np.abs(inner) + sqrt(2.0) * noise)
    cruises = []
    for first, last in _stretches(steady, LEAST_ROWS):
        part = inner[first : last + 1]
        middle = float(np.median(part))
        near = np.abs(part - middle) <= rule.tolerance * abs(middle) + noise
        inside = _stretches(near, LEAST_ROWS)
        if inside:
            a, b = max(inside, key=lambda span: span[1] - span[0])
            i, j = first + a + 2 * h, first + b + 2 * h
            cruises.append(Cruise(start + i, start + j, float(t[j] - t[i])))
    return cruises


def _stretches(mask: NDArray[np.bool_], least: int) -> list[tuple[int, int]]:
    """First and last index of every run of at least `least` true values."""
    edges = np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8))
    first, last = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    long = last - first + 1 >= least
    return list(zip(first[long].tolist(), last[long].tolist(), strict=True))


Subtract = Literal["none", "gravity", "inertia", "all"]
SUBTRACT = get_args(Subtract)
CHUNK = 20_000
"""Rows the recursion takes at once, so that its intermediate values stay in the cache."""
DEGREE = 3
"""Of the local polynomials: their slope is exact where the acceleration changes linearly."""


class ModelTorque:
    """The torques of an arm's model along a log, by the recursion on its own frames in batches."""

    __slots__ = ("_recursion", "_weightless", "arm", "subtract", "window")

    def __init__(self, arm: Arm, subtract: Subtract = "gravity", window: float = 0.08) -> None:
        """Raises `OptionError` for another word than `SUBTRACT`, `MissingDataError` for an arm without inertias."""
        if subtract not in SUBTRACT:
            raise OptionError("subtract", repr(subtract), ", ".join(SUBTRACT))
        self.arm, self.subtract, self.window = arm, subtract, window
        self._recursion = Recursion.of(arm.require_dynamics())
        self._weightless = replace(self._recursion, gravity=ZERO)

    def gravity(self, log: JointLog) -> Array:
        """g(q) of every row, (k, n) [N m or N]."""
        return np.concatenate([self._recursion.gravity_vector(q) for q in _chunks(log.q)])

    def inertia(self, log: JointLog) -> Array:
        """B ddq + C dq of every row, (k, n) [N m or N], from positions alone; raises `LogError` for uneven rows."""
        out = np.empty_like(log.q)
        for piece in recordings(log.t):
            states = log.q[piece], *local_derivatives(log, piece, self.window)
            rows = zip(*map(_chunks, states), strict=True)
            out[piece] = np.concatenate([self._weightless.inverse_dynamics(*row) for row in rows])
        return out


def local_derivatives(log: JointLog, piece: slice, window: float) -> tuple[Array, Array]:
    """Velocities and accelerations of a stretch of a log from local cubics over `window` [s], (k, n) each.

    Raises
    ------
    LogError
        Rows that are not evenly spaced, or fewer than a window holds.

    References
    ----------
    Savitzky and Golay, Smoothing and differentiation of data by simplified least squares procedures (1964).
    """
    t = log.t[piece]
    step = even_step(log.source, t, piece.start)
    rows = max(DEGREE + 2, 2 * round(window / (2 * step)) + 1) if step else DEGREE + 2
    if t.size < rows:
        where = f"rows {piece.start + 1} to {piece.start + t.size}"
        raise LogError(log.source, where, f"{t.size} between gaps in time", f"at least {rows}")
    dq, ddq = (savgol_filter(log.q[piece], rows, DEGREE, deriv=d, delta=step, axis=0) for d in (1, 2))
    return np.asarray(dq), np.asarray(ddq)


def _chunks(array: Array) -> list[Array]:
    return [array[i : i + CHUNK] for i in range(0, len(array), CHUNK)]


@dataclass(frozen=True, slots=True)
class FrictionPoint:
    """One cruise."""

    joint: Annotated[int, "From 1."]
    velocity: Annotated[float, "Its mean, rad/s (m/s)."]
    torque: Annotated[float, "Mean of the friction, N m (N)."]
    spread: Annotated[float, "Standard deviation of the torque inside the cruise."]
    samples: Annotated[int, "How many are behind the means."]
    inertia: Annotated[
        float | None,
        "Mean of B ddq + C dq, the bias of a plain average, left in unless it is taken out; null without a model.",
    ]
    source: Annotated[str, "The log."]
    first: Annotated[int, "Row of the source, from 1."]
    last: Annotated[int, "Row of the source, from 1."]


def map_points(
    log: JointLog, model: ModelTorque | None = None, rule: CruiseRule = DEFAULT_CRUISE
) -> tuple[FrictionPoint, ...]:
    """The points of every joint's cruises in one log.

    Parameters
    ----------
    model : ModelTorque, optional
        Its torques are taken out; without it they count as friction as they are.

    Raises
    ------
    LogError
        No cruise at all, or only ones that are too short.
    """
    cruises = {i: find_cruises(log.t, log.q[:, i], rule) for i in range(len(log.joints))}
    kept = {i: [c for c in several if c.duration >= rule.shortest] for i, several in cruises.items()}
    if not any(kept.values()):
        raise _no_cruise(log, cruises, rule)
    every = [cruise for several in kept.values() for cruise in several]
    rows = slice(min(c.first for c in every), min(log.t.size, max(c.last for c in every) + 1))
    friction, inertia = _friction(log, model, rows)  # the model is evaluated only from the first cruise to the last
    return tuple(
        _point(log, i, cruise, friction[:, i], None if inertia is None else inertia[:, i])
        for i, cruises in kept.items()
        for cruise in cruises
    )


def _friction(log: JointLog, model: ModelTorque | None, rows: slice) -> tuple[Array, Array | None]:
    """Torques less what the model takes out, and B ddq + C dq where it can be had; valid in `rows`."""
    if model is None:
        return log.tau, None
    part = JointLog(log.source, log.joints, log.t[rows], log.q[rows], log.tau[rows])
    friction = np.full_like(log.tau, np.nan)
    friction[rows] = part.tau
    if model.subtract in ("gravity", "all"):
        friction[rows] -= model.gravity(part)
    moving = _inertia(part, model)
    if moving is None:
        return friction, None
    inertia = np.full_like(log.tau, np.nan)
    inertia[rows] = moving
    if model.subtract in ("inertia", "all"):
        friction[rows] -= moving
    return friction, inertia


def _inertia(part: JointLog, model: ModelTorque) -> Array | None:
    """B ddq + C dq; None where the rows are too uneven for accelerations and it need not be taken out."""
    try:
        return model.inertia(part)
    except LogError:
        if model.subtract in ("inertia", "all"):
            raise
        return None


def _point(log: JointLog, i: int, cruise: Cruise, friction: Array, inertia: Array | None) -> FrictionPoint:
    rows = slice(cruise.first, cruise.last + 1)
    t, q, torque = log.t[rows], log.q[rows, i], friction[rows]
    velocity = float((q[-1] - q[0]) / (t[-1] - t[0])) if log.dq is None else time_mean(t, log.dq[rows, i])
    return FrictionPoint(
        joint=log.joints[i], velocity=velocity, torque=time_mean(t, torque), spread=float(torque.std(ddof=1)),
        samples=int(torque.size), inertia=None if inertia is None else time_mean(t, inertia[rows]),
        source=log.source, first=cruise.first + 1, last=cruise.last + 1,
    )  # fmt: skip


def time_mean(t: Array, values: Array) -> float:
    """The mean over time by the trapezoidal rule, which is what (q_end - q_start)/T is of the velocity.

    >>> time_mean(np.array([0.0, 1.0, 4.0]), np.array([0.0, 2.0, 2.0]))
    1.75
    """
    return float((values[1:] + values[:-1]) @ np.diff(t) / (2 * (t[-1] - t[0])))


def _no_cruise(log: JointLog, cruises: dict[int, tuple[Cruise, ...]], rule: CruiseRule) -> LogError:
    needed = f"{rule.shortest:g} s at constant speed (within {rule.tolerance:.0%}) of at least one joint"
    every = [(c, i) for i, several in cruises.items() for c in several]
    if not every:
        duration = float(log.t[-1] - log.t[0])
        columns = f"columns {', '.join(f'q{j}' for j in log.joints)}"
        return LogError(log.source, columns, f"no cruise in {duration:.4g} s, {log.t.size} rows", needed)
    longest, i = max(every, key=lambda pair: pair[0].duration)
    where = f"rows {longest.first + 1} to {longest.last + 1}, column q{log.joints[i]}"
    return LogError(log.source, where, f"the longest cruise takes {longest.duration:.3g} s", needed)


def points_of(points: Sequence[FrictionPoint], joint: int, sign: int) -> tuple[FrictionPoint, ...]:
    """The points of one joint in one direction, slow ones first."""
    chosen = [p for p in points if p.joint == joint and p.velocity * sign > 0.0]
    return tuple(sorted(chosen, key=lambda p: abs(p.velocity)))
