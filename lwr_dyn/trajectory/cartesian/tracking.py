"""Joint positions of any arm along a curve of poses, each found from the one before: no start is drawn at random.

    q <- q + J^+ e + (1 - J^+ J) z        e = [p - p(q); turn from R(q) to R]

Newton's method from a predicted position leads back onto the curve. Where the arm has more joints than the task needs,
z moves them away from their limits, x = (q - middle) / half of a range:

    z = - gain half x / (EDGE - x^2)    over the whole curve

References: Siciliano et al., Robotics, eq. 3.54 (z in the null space of J) and sec. 3.7 (Newton's method along a path).

`PathStopError` says why an arm cannot follow a curve further: a joint at its limit, a singular position, or the end of
its reach. Legs of an S-R-S arm that may begin anywhere have the arm angle with the largest margin over the whole way.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError, OutOfReachError, OutsideLimitsError
from lwr_dyn.kinematics import inverse as numeric
from lwr_dyn.kinematics.arm_angle import best_arm_angle
from lwr_dyn.kinematics.arm_geometry import require_srs
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.solution import joint_ranges
from lwr_dyn.kinematics.srs import closed_form
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind
from lwr_dyn.trajectory.pose_path import PoseCurve

ON_CURVE = 1e-11
"""Largest pose error that counts as on the curve [m and rad]."""

STEP_LENGTH, STEP_TURN = 0.002, 0.01
"""[m, rad] Largest step along the curve."""

LEAST_PLACES = 60
"""Steps of a curve at least."""

JUMP = 0.1
"""[rad or m] A joint that moves further in one step is not followed: the step is halved."""

HALVINGS = 9
"""How often a step is halved before the arm counts as stopped."""

ITERATIONS = 8

EDGE = 1.05
"""Keeps z finite at the limits."""

GAINS = (0.0, 4.0, 40.0)
"""Gains of z, tried one after the other."""

AT_LIMIT = 1e-9
"""[rad or m] A joint this far outside its limits is at them."""


@dataclass(frozen=True, slots=True, eq=False)
class Tracked:
    """Joint positions q (k, n) [rad or m] at the places u (k,) of a curve; u[-1] < 1 where the arm stopped."""

    u: Array
    q: Array
    at_limit: int | None = None
    """The joint (from 0) that stopped it; None where it was no limit."""

    @property
    def is_whole(self) -> bool:
        """Whether the end of the curve was reached."""
        return float(self.u[-1]) >= 1.0


def attempts(arm: Arm, curve: PoseCurve, q_start: Array, turning: bool) -> Iterator[Tracked]:
    """Joint positions inside the limits along a curve, from q_start (n,), which is at its begin, as far as they go.

    One attempt for each of `GAINS` for an arm with more joints than the task needs, else one.

    Parameters
    ----------
    arm : Arm
    curve : PoseCurve
    q_start : (n,) array
        [rad or m]
    turning : bool
        False: only the place of the tip follows the curve, its orientation is free.
    """
    for gain in GAINS if arm.n > (6 if turning else 3) else GAINS[:1]:
        yield _attempt(arm, curve, q_start, turning, gain)


def places_on(curve: PoseCurve) -> Array:
    """Places u (k,) from 0 to 1, at most `STEP_LENGTH` and `STEP_TURN` apart."""
    steps = max(LEAST_PLACES, int(np.ceil(max(curve.length / STEP_LENGTH, curve.turn / STEP_TURN))))
    return np.linspace(0.0, 1.0, steps + 1)


def _attempt(arm: Arm, curve: PoseCurve, q_start: Array, turning: bool, gain: float) -> Tracked:
    places, positions = [0.0], [q_start]
    step = widest = float(places_on(curve)[1])
    while places[-1] < 1.0 and step > widest / 2.0**HALVINGS:
        u = places[-1] + step
        u = 1.0 if u > 1.0 - widest / 2.0 ** (HALVINGS + 1) else u  # no last step as small as rounding
        T = curve.poses(np.array([u]))[0]
        q = onto_pose(arm, T, _predicted(arm, T, positions[-1], gain * (u - places[-1]), turning), turning)
        if not np.abs(q - positions[-1]).max() <= JUMP:
            step /= 2.0
        elif not is_inside(arm, q):
            return Tracked(np.array(places), np.array(positions), int(np.argmin(margins(arm, q))))
        else:
            places.append(u)
            positions.append(q)
            step = min(2.0 * step, widest)
    return Tracked(np.array(places), np.array(positions))


def is_inside(arm: Arm, q: Array) -> bool:
    """Whether q (n,) was found and is inside the limits."""
    return bool(margins(arm, q).min() >= -AT_LIMIT)


def margins(arm: Arm, q: Array) -> Array:
    """Distances (..., n) from the nearer limit of each joint [rad or m], negative outside."""
    return np.asarray(np.minimum(arm.upper - q, q - arm.lower))


def onto_pose(arm: Arm, T: Array, q: Array, turning: bool) -> Array:
    """Newton's method from q (n,) to the tip pose T (4, 4), whatever the limits; NaN where it does not arrive."""
    for _ in range(ITERATIONS):
        e, J = pose_error(arm, T, q, turning)
        if np.abs(e).max() <= ON_CURVE:
            return q
        q = q + _pseudo_inverse(J) @ e
    e, _ = pose_error(arm, T, q, turning)
    return q if np.abs(e).max() <= 10.0 * ON_CURVE else np.full(arm.n, np.nan)


def pose_error(arm: Arm, T: Array, q: Array, turning: bool) -> tuple[Array, Array]:
    """The error (..., 6) from the tip at q to T [m, rad] and its Jacobian (..., 6, n).

    The first three rows of each if only the place counts.
    """
    rows = 6 if turning else 3
    e, J, _ = numeric.pose_error(arm.chain, T, q)
    return e[..., :rows], J[..., :rows, :]


def _predicted(arm: Arm, T: Array, q: Array, gain: float, turning: bool) -> Array:
    """The position at T by the Jacobian at q, with the motion away from the limits."""
    e, J = pose_error(arm, T, q, turning)
    inverse = _pseudo_inverse(J)
    away = _away_from_limits(arm, q, gain)
    ahead: Array = q + inverse @ e + away - inverse @ (J @ away)
    return ahead


def _away_from_limits(arm: Arm, q: Array, gain: float) -> Array:
    """z (n,) [rad or m] of one step, linearly implicit, so that steep ends do not oscillate; 0 without limits."""
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    middle = np.where(limited, arm.lower, 0.0) / 2.0 + np.where(limited, arm.upper, 0.0) / 2.0
    half = np.where(limited, np.where(limited, arm.upper, 0.0) - middle, 1.0)
    x = np.where(limited & (half > 0.0), (q - middle) / np.where(half > 0.0, half, 1.0), 0.0)
    room = EDGE - np.minimum(x**2, 1.0)
    slope = (EDGE + x**2) / room**2
    z: Array = -half * gain * x / room / (1.0 + gain * slope)
    return z


def _pseudo_inverse(J: Array) -> Array:
    """J^+ (n, m), singular values below 1e-9 of the largest dropped."""
    return np.asarray(np.linalg.pinv(J, rcond=1e-9), dtype=np.float64)


LOOK_AHEAD = 0.002
"""Share of the curve ahead of the stop at which its cause is looked for."""

STARTS = 40
"""Random positions from which a place out of reach is looked for, where only the place of the tip counts."""


class PathStopError(LwrDynError, ValueError):
    """An arm cannot follow `line`: `why` is "limit", "singular" or "reach", at `share` of its way.

    `joint` is the joint at its limit.
    """

    def __init__(self, line: str, share: float, place: Array, why: str, words: str, joint: str = "") -> None:
        x, y, z = place + 0.0
        where = f"at {100.0 * share:.3g} % of its way, point ({x:.4g}, {y:.4g}, {z:.4g}) m"
        super().__init__(f"{line} stops {where}: {words}; allowed: a line that the arm can follow")
        self.line, self.share, self.why, self.joint = line, share, why, joint


def stop_of(arm: Arm, curve: PoseCurve, tracked: Tracked, turning: bool, line: str) -> PathStopError:
    """The error for a curve that was not followed to its end; `line` names it."""
    if tracked.is_whole:  # but its spline leaves the curve or the limits: up to where it comes nearest to a limit
        row, nearest = np.unravel_index(int(np.argmin(margins(arm, tracked.q))), tracked.q.shape)
        tracked = Tracked(tracked.u[: row + 1], tracked.q[: row + 1], int(nearest))
    u, q, i = float(tracked.u[-1]), tracked.q[-1], tracked.at_limit
    ahead = min(u + LOOK_AHEAD, 1.0)
    T = curve.poses(np.array([u, ahead]))
    if i is not None:
        joint, unit = arm.joint_names[i], "rad" if arm.chain.links[i].kind is JointKind.REVOLUTE else "m"
        words = f"{joint} comes to its limit ({arm.lower[i]:.4g} to {arm.upper[i]:.4g} {unit})"
        return PathStopError(line, u, T[0, :3, 3], "limit", words, joint)
    return PathStopError(line, u, T[0, :3, 3], *_cause(arm, T[1], q, turning))


def _cause(arm: Arm, T: Array, q: Array, turning: bool) -> tuple[str, str]:
    """ "singular" or "reach", with the reason."""
    _, J = pose_error(arm, T, q, turning)
    smallest = f"smallest singular value of J {np.linalg.svd(J, compute_uv=False).min():.2g}"
    if _is_reached(arm, T, turning):
        return "singular", f"the arm is singular there ({smallest}) and would have to jump to another branch"
    return "reach", f"no joint positions reach the pose behind it ({smallest})"


def _is_reached(arm: Arm, T: Array, turning: bool) -> bool:
    """Whether any joint positions, in or out of the limits, were found for a pose."""
    if not turning:
        starts = np.random.default_rng(0).uniform(-np.pi, np.pi, (STARTS, arm.n))
        return any(np.isfinite(onto_pose(arm, T, start, turning)).all() for start in starts)
    try:
        return inverse_kinematics(arm, T, limits=False).status == "solved"
    except LwrDynError:
        return False


def best_legs(arm: Arm, curves: Sequence[PoseCurve], names: Sequence[str]) -> list[Tracked]:
    """Joint positions along all curves, one after the other, from `kinematics.arm_angle.best_arm_angle`.

    Raises `PathStopError` (the wrist is out of reach, or no arm angle keeps the limits; `names` name the curves),
    `OptionError` (not an S-R-S arm, or the wrist passes the axis of joint 1, where the arm angle has no zero).
    """
    places = [places_on(curve) for curve in curves]
    s = np.concatenate([[0.0], *(k + u[1:] for k, u in enumerate(places))])
    T = np.concatenate([curves[0].poses(np.zeros(1)), *(c.poses(u[1:]) for c, u in zip(curves, places, strict=True))])
    try:
        best = best_arm_angle(arm, s, T)
    except OutOfReachError as fault:
        words = f"the wrist is {fault.distance:.3g} m out of reach"
        raise _stop(curves, names, fault.at, "reach", words) from None
    except OutsideLimitsError as fault:
        words = f"no arm angle keeps {fault.joint} within its limits, {fault.excess:.3g} rad outside ({fault.why})"
        raise _stop(curves, names, fault.at, "limit", words, fault.joint) from None
    q = closed_form(require_srs(arm), joint_ranges(arm), T, best.evaluate(s)[0], best.branch)
    ends = np.cumsum([0, *(len(u) - 1 for u in places)])
    return [Tracked(u, q[a : b + 1]) for u, a, b in zip(places, ends, ends[1:], strict=False)]


def _stop(
    curves: Sequence[PoseCurve], names: Sequence[str], at: float, why: str, words: str, joint: str = ""
) -> PathStopError:
    leg = max(math.ceil(at) - 1, 0)
    place: Array = curves[leg].poses(np.array([at - leg]))[0, :3, 3]
    return PathStopError(names[leg], at - leg, place, why, words, joint)
