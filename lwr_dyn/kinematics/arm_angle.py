"""A smooth arm angle along a path that maximises the smallest joint-limit margin.

Inside the corridor of `arm_angle_search`, the curve is the natural cubic spline with the least bending,

    minimise  integral of psi''^2 + PULL (psi - middle of the corridor)^2   subject to  low <= psi <= high,

by bounded least squares at a few knots; where it leaves the corridor between knots, a knot is added there.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.optimize import lsq_linear

from lwr_dyn.foundation.arrays import Array, read_only, real_array
from lwr_dyn.foundation.errors import OptionError, OutOfReachError, OutsideLimitsError, ShapeError
from lwr_dyn.kinematics.arm_angle_search import BranchOptimum, Corridor, largest_margin
from lwr_dyn.kinematics.arm_geometry import SrsGeometry, require_srs
from lwr_dyn.kinematics.branches import Branch, JointRanges, joint_ranges, one_turn_note
from lwr_dyn.kinematics.srs import ON_AXIS, arm_triangle
from lwr_dyn.kinematics.srs_margins import margin_problem, margins
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import pose_array

PULL = 1e3
"""Weight of the distance from the corridor's middle, for a path of length 1: bends die out over 1/PULL^(1/4) of it."""
FIRST_KNOTS = 33
INSET = 0.05
"""Part of the corridor's width kept free at each side at the knots, so that between them the curve stays inside."""


@dataclass(frozen=True, slots=True, eq=False)
class ArmAngleCurve:
    """psi(s) along one path, and the smallest joint-limit margin it keeps over the poses of that path."""

    branch: Branch
    margin: float
    """Smallest margin [rad] over all poses and joints."""
    joint: int
    """The joint that has it, 0-based."""
    at: float
    """The path parameter s where it has it."""
    margin_bound: float
    """[rad] No continuous arm angle, on any branch, keeps a larger smallest margin at these poses (see `one_turn`)."""
    reference: Array
    """(3,) The direction psi is counted from; pass it on to `follow`."""
    knots: Array
    """(m,) s of the spline's knots."""
    values: Array
    """(m,) psi at the knots [rad]."""
    one_turn: str = ""
    """What `margin_bound` leaves out, in words: the joints whose wider range counted as one turn; "" if none."""

    def evaluate(self, s: ArrayLike) -> tuple[Array, Array, Array]:
        """psi [rad], dpsi/ds and d2psi/ds2 at s (k,), each (k,); the second derivative is continuous."""
        spline, at = CubicSpline(self.knots, self.values, bc_type="natural"), real_array("s", s)
        return spline(at), spline(at, 1), spline(at, 2)


def best_arm_angle(arm: Arm, s: ArrayLike, T: ArrayLike, *, reference: ArrayLike | None = None) -> ArmAngleCurve:
    """The continuous arm angle that keeps the largest smallest joint-limit margin along a path, of all branches.

    A range of more than a turn, or an unknown one, counts as one turn about its middle, so that no position jumps; the
    result and the error name such joints. Beyond that turn there may be more margin, or a way where none is found.

    Parameters
    ----------
    arm : Arm
        An S-R-S arm.
    s : (k,) array_like
        Path parameter, increasing, k >= 2; its unit is the caller's.
    T : (k, 4, 4) array_like
        Flange poses in the base; the limits are checked at these poses only, so sample the path finely.
    reference : (3,) array_like, optional
        Direction psi is counted from (see `srs`); the axis of joint 1 if not given.

    Raises
    ------
    ShapeError
        Wrong shapes, s not increasing, T not poses.
    OptionError
        Not an S-R-S arm; or the wrist passes the line of `reference`, where psi has no zero: choose another direction.
    OutOfReachError
        `.at` is the s of the pose furthest out of reach, `.distance` by how much [m].
    OutsideLimitsError
        `.at` is the s where the limits are left, `.joint` which, `.excess` by how much at the best arm angle [rad].
    """
    geometry, ranges = require_srs(arm, reference), joint_ranges(arm)
    at, poses = _gate(s, T)
    triangle = arm_triangle(geometry, poses)
    if triangle.reach_excess.any():
        worst = int(np.argmax(triangle.reach_excess))
        raise OutOfReachError(arm.name, float(at[worst]), float(triangle.reach_excess[worst]))
    _require_zero(geometry, triangle.u, triangle.up, at)
    # a joint without limits still has a seam, half a turn from its middle, where its position would jump
    one_turn = JointRanges(ranges.middle, np.minimum(ranges.half, np.pi))
    best = largest_margin(geometry, one_turn, poses)
    if best.margin_bound < 0.0 or best.passage is None:
        why = "at the best arm angle" if best.continuous else "at least; no arm angle leads on without a jump"
        why = "; ".join(filter(None, (why, one_turn_note(arm))))
        joint, excess = arm.joint_names[best.joint], -best.margin_bound
        raise OutsideLimitsError(arm.name, float(at[best.index]), joint, excess, why)
    knots, values = _smooth(at, best.passage)
    return replace(_measured(geometry, ranges, at, poses, best, knots, values), one_turn=one_turn_note(arm))


def _gate(s: ArrayLike, T: ArrayLike) -> tuple[Array, Array]:
    at, poses = real_array("s", s), pose_array("T", T)
    if at.ndim != 1 or len(at) < 2 or poses.shape != (len(at), 4, 4):
        raise ShapeError("s, T", f"shapes {at.shape}, {poses.shape}", "(k,) and (k, 4, 4), k >= 2")
    if not (np.diff(at) > 0.0).all():
        where = int(np.argmin(np.diff(at) > 0.0))
        raise ShapeError("s", f"{at[where]} then {at[where + 1]}", "increasing values")
    return at, poses


def _require_zero(geometry: SrsGeometry, u: Array, up: Array, at: Array) -> None:
    sine = np.linalg.norm(np.cross(u, geometry.reference), axis=1)
    turned = np.append(np.einsum("ki,ki->k", up[1:], up[:-1]) <= 0.0, False)
    if (bad := (sine < ON_AXIS) | turned).any():
        where = float(at[int(np.argmax(bad))])
        fault = f"the wrist passes the line of {geometry.reference.tolist()} through the shoulder at s = {where:.6g}"
        raise OptionError("reference", fault, "a direction that the path keeps away from")


def _smooth(s: Array, passage: Corridor) -> tuple[Array, Array]:
    """Knots and values of the spline with the least bending inside the corridor."""
    x = (s - s[0]) / (s[-1] - s[0])
    middle, half_width = (passage.low + passage.high) / 2.0, (0.5 - INSET) * (passage.high - passage.low)
    chosen = np.unique(np.linspace(0, len(x) - 1, min(len(x), FIRST_KNOTS)).round().astype(int))
    while True:
        values = _least_bending(x[chosen], middle[chosen], half_width[chosen])
        psi = CubicSpline(x[chosen], values, bc_type="natural")(x)
        outside = np.maximum(passage.low - psi, psi - passage.high)
        outside[chosen] = 0.0
        if not (outside > 0.0).any():
            return s[chosen], values
        chosen = np.union1d(chosen, _worst_of_each_run(outside))


def _worst_of_each_run(outside: Array) -> Array:
    bad = np.flatnonzero(outside > 0.0)
    runs = np.split(bad, np.flatnonzero(np.diff(bad) > 1) + 1)
    return np.array([run[np.argmax(outside[run])] for run in runs])


def _least_bending(x: Array, middle: Array, half_width: Array) -> Array:
    """Values at the knots x (m,) within middle +- half_width (m,)."""
    spline = CubicSpline(x, np.eye(len(x)), bc_type="natural")
    bend, h = spline(x, 2), np.diff(x)[:, None]
    # psi'' is linear from a to b over each span: its square integrates to h [(a + b)^2 / 4 + (b - a)^2 / 12]
    total, change = np.sqrt(h) / 2.0 * (bend[:-1] + bend[1:]), np.sqrt(h / 12.0) * np.diff(bend, axis=0)
    pull = np.diag(np.sqrt(PULL * np.gradient(x)))
    target = np.concatenate([np.zeros(2 * len(h)), pull @ middle])
    half_width = np.maximum(half_width, np.finfo(float).eps * (1.0 + np.abs(middle)) * 4.0)
    fit = lsq_linear(
        np.concatenate([total, change, pull]), target, (middle - half_width, middle + half_width), method="bvls"
    )
    values: Array = fit.x
    return values


def _measured(
    geometry: SrsGeometry, ranges: JointRanges, s: Array, T: Array, best: BranchOptimum, knots: Array, values: Array
) -> ArmAngleCurve:
    """The curve with the margin that it keeps at the poses."""
    psi = CubicSpline(knots, values, bc_type="natural")(s)
    kept = margins(margin_problem(geometry, ranges, T, best.branch), psi[:, None])[:, 0]
    row, joint = (int(i) for i in np.unravel_index(np.argmin(kept), kept.shape))
    margin = float(kept[row, joint])
    return ArmAngleCurve(
        branch=best.branch,
        margin=margin,
        joint=joint,
        at=float(s[row]),
        margin_bound=max(best.margin_bound, margin),
        reference=read_only(geometry.reference),
        knots=read_only(knots),
        values=read_only(values),
    )
