"""The friction-velocity map: one point for every cruise, the averages of velocity and torque over it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LogError
from lwr_dyn.identification.friction.cruise import DEFAULT_CRUISE, Cruise, CruiseRule, find_cruises
from lwr_dyn.identification.friction.torque_model import ModelTorque
from lwr_dyn.identification.logs.joint_log import JointLog


@dataclass(frozen=True, slots=True)
class FrictionPoint:
    """One cruise: the mean velocity [rad/s or m/s], the mean friction torque [N m or N] and the samples behind them.

    `spread` is the standard deviation of the torque inside the cruise. `inertia` is the mean of B ddq + C dq over it:
    the bias of a plain average, left in unless `ModelTorque.subtract` is "inertia" or "all"; None without a model.
    `first` and `last` are rows of the source, counted from 1.
    """

    joint: int
    velocity: float
    torque: float
    spread: float
    samples: int
    inertia: float | None
    source: str
    first: int
    last: int


def map_points(
    log: JointLog, model: ModelTorque | None = None, rule: CruiseRule = DEFAULT_CRUISE
) -> tuple[FrictionPoint, ...]:
    """The points of every joint's cruises in one log.

    Parameters
    ----------
    log : JointLog
    model : ModelTorque, optional
        Its torques are taken out; without it they count as friction as they are.
    rule : CruiseRule

    Raises
    ------
    LogError
        No cruise at all, or only ones that are too short.
    """
    cruises = {i: find_cruises(log.t, log.q[:, i], rule) for i in range(len(log.joints))}
    kept = {i: [c for c in several if c.duration >= rule.shortest] for i, several in cruises.items()}
    if not any(kept.values()):
        raise _no_cruise(log, cruises, rule)
    friction, inertia = _friction(log, model, cruise_span(kept, log.t.size))
    return tuple(
        _point(log, i, cruise, friction[:, i], None if inertia is None else inertia[:, i])
        for i, cruises in kept.items()
        for cruise in cruises
    )


def cruise_span(kept: dict[int, list[Cruise]], rows: int) -> slice:
    """The rows from the first cruise to the end of the last: the model is evaluated only there."""
    cruises = [c for several in kept.values() for c in several]
    return slice(min(c.first for c in cruises), min(rows, max(c.last for c in cruises) + 1))


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
