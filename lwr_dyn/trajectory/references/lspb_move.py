"""An LSPB move in joint space: all joints start, cruise and stop together, as the WAM's own controller moves it."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, fixed_array, real_array
from lwr_dyn.errors import OptionError, PathLimitError, ShapeError
from lwr_dyn.model.arm import Arm
from lwr_dyn.registry import Option
from lwr_dyn.trajectory.laws import Law, positive
from lwr_dyn.trajectory.lspb import lspb, lspb_at_rates, lspb_at_velocity
from lwr_dyn.trajectory.references.limits import worst_outside
from lwr_dyn.trajectory.references.point_to_point import JointReference
from lwr_dyn.trajectory.references.tasks import Duration, End, Start

FORMS = "duration and blend, duration and velocity, or velocity and acceleration"


def lspb_move(
    arm: Arm,
    start: ArrayLike,
    end: ArrayLike,
    *,
    duration: float | None = None,
    blend: float | None = None,
    velocity: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
) -> JointReference:
    """A move from `start` to `end` on one LSPB law for all joints, so that they move along a straight line.

    Given are duration and blend, duration and velocity, or velocity and acceleration. Velocities and accelerations are
    those of each joint: the joint that its own allows least for its travel cruises (accelerates) at it, the others in
    proportion to their travel. Joints that do not move ask for nothing.

    Parameters
    ----------
    arm : Arm
    start, end : (n,) array_like
        [rad or m]
    duration, blend : float, optional
        t_f and t_c [s].
    velocity, acceleration : float or (n,) array_like, optional
        [rad/s or m/s], [rad/s^2 or m/s^2], above 0.

    Returns
    -------
    JointReference
        q, dq, ddq are exact.

    Raises
    ------
    ShapeError
        Positions or rates of the wrong shape, or not finite.
    OptionError
        Another choice of what is given, or a law that does not exist, with the feasible range; no joint that moves and
        no duration.
    PathLimitError
        Start or end outside the position limits.

    >>> from lwr_dyn.front import load
    >>> move = lspb_move(load("wam7"), [0, -2, 0, 1.6, 0, 0, 0], [0.5, -2, 0, 1.6, 0, 0, 0], duration=7.0, blend=1.0)
    >>> move.sample(np.array([3.5])).dq[0, :2].round(5)
    array([0.08333, 0.     ])
    """
    points = np.stack([fixed_array(name, q, (arm.n,)) for name, q in (("start", start), ("end", end))])
    given = {"duration": duration, "blend": blend, "velocity": velocity, "acceleration": acceleration}
    names = {name for name, value in given.items() if value is not None}
    travel = np.abs(points[1] - points[0])
    if names == {"duration", "blend"} and duration is not None and blend is not None:
        law = lspb(1.0, duration, blend)
    elif names == {"duration", "velocity"} and duration is not None:
        law = _at_velocity(arm, travel, duration, _rates("velocity", velocity, arm.n))
    elif names == {"velocity", "acceleration"}:
        law = _at_rates(arm, travel, _rates("velocity", velocity, arm.n), _rates("acceleration", acceleration, arm.n))
    else:
        raise OptionError("LSPB", f"given by {', '.join(sorted(names)) or 'nothing'}", FORMS)
    _check(arm, law, points)
    return JointReference(points, (law,))


def timed_lspb_move(
    arm: Arm,
    *,
    start: Start,
    end: End,
    duration: Duration = 7.0,
    blend: Annotated[float, Option(float, "Time of each of the two blends, s.")] = 1.0,
) -> JointReference:
    """`lspb_move` given by duration and blend, by default those of the WAM paper; raises as `lspb_move`."""
    return lspb_move(arm, start, end, duration=duration, blend=blend)


def _at_velocity(arm: Arm, travel: Array, duration: float, velocity: Array) -> Law:
    if not travel.any():
        return lspb(1.0, positive("duration", duration), duration / 2.0)
    j = _least(velocity, travel)
    try:
        return _of_unit_length(lspb_at_velocity(float(travel[j]), duration, float(velocity[j])))
    except OptionError as fault:
        raise OptionError(f"{arm.joint_names[j]}, {fault.name}", fault.found, fault.allowed) from None


def _at_rates(arm: Arm, travel: Array, velocity: Array, acceleration: Array) -> Law:
    if not travel.any():
        raise OptionError("LSPB", "no joint moves, and no duration is given", "a duration to stand still for")
    j, k = _least(velocity, travel), _least(acceleration, travel)
    share = float(acceleration[k] * (travel[j] / travel[k]))
    try:
        return _of_unit_length(lspb_at_rates(float(travel[j]), float(velocity[j]), share))
    except OptionError as fault:
        raise OptionError(f"{arm.joint_names[j]}, {fault.name}", fault.found, fault.allowed) from None


def _least(rates: Array, travel: Array) -> int:
    """The joint whose rate is least for its travel, among those that move."""
    moving = np.where(travel > 0.0, travel, 1.0)
    return int(np.argmin(np.where(travel > 0.0, rates / moving, np.inf)))


def _of_unit_length(law: Law) -> Law:
    return replace(law, length=1.0, coefficients=law.coefficients / law.length)


def _rates(name: str, value: ArrayLike | None, n: int) -> Array:
    """One number for all joints, or one each, above 0."""
    rates = real_array(name, 0.0 if value is None else value)
    if rates.shape not in ((), (n,)):
        raise ShapeError(name, f"shape {rates.shape}", f"one number, or ({n},)")
    if not (rates > 0.0).all():
        raise OptionError(name, float(rates.min()), "a number above 0")
    return np.broadcast_to(rates, (n,))


def _check(arm: Arm, law: Law, points: Array) -> None:
    """The law runs monotonically, so start and end are the extremes of the move."""
    fault = worst_outside(arm, points)
    if fault is not None:
        i, joint, said, allowed, excess = fault
        raise PathLimitError(law.duration * i, ("start", "end")[i], said, allowed, joint, excess)
