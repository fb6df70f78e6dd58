"""Test vectors of closed-form inverse kinematics for other languages: a few calls, and what Python finds."""

import math

import numpy as np

from lwr_dyn.codegen.emit.closed_form_cases import ARM_ANGLES, POSES, TOLERANCE, branches, poses, positions
from lwr_dyn.codegen.emit.functions import Argument, TemplateCase
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.arm_geometry import SrsGeometry
from lwr_dyn.kinematics.branches import BRANCHES, joint_ranges
from lwr_dyn.kinematics.six_joints.spherical_wrist import all_branches
from lwr_dyn.kinematics.srs import arm_triangle
from lwr_dyn.kinematics.srs_margins import intervals_at_level, margin_problem
from lwr_dyn.model.arm import Arm

NAME = "inverse_kinematics"
MARGIN = 0.05
"""[rad]"""
_FAR, _AWAY = 10.0, 1e-3
_POSE, _ARM_ANGLE = Argument("pose", 16, "4 x 4 row by row, m"), Argument("arm_angle", 1, "rad")


def vectors_of_srs(arm: Arm, geometry: SrsGeometry) -> tuple[TemplateCase, ...]:
    """Of the four functions of an S-R-S arm; one pose is out of reach."""
    T = poses(arm)
    q, excess = branches(arm, geometry, T, ARM_ANGLES), arm_triangle(geometry, T).reach_excess
    some = list(range(POSES))
    of_branches = np.column_stack([ARM_ANGLES, np.array(BRANCHES, dtype=np.float64)[some]])
    angles, position = [[float(x)] for x in (*ARM_ANGLES, 0.0)], Argument("q", arm.n, "rad")
    pairs = [_intervals(arm, geometry, pose) for pose in T]
    return (
        _all(T, q, (*excess, float(arm_triangle(geometry, _far(T)).reach_excess[0])), ((_ARM_ANGLE, angles),)),
        TemplateCase(f"{NAME}_arm_angle", ((position, q[some, some].tolist()),), "rad; signs of shoulder, elbow, wrist",
                     of_branches.tolist(), None, TOLERANCE),
        TemplateCase(f"{NAME}_intervals", ((_POSE, _flat(T)), (Argument("margin", 1, "rad"), [[MARGIN]] * POSES)),
                     "rad, pairs (start, end) of each branch", pairs, excess.tolist(), TOLERANCE),
        _near(arm, *_inside(arm, geometry, T)),
    )  # fmt: skip


def vectors_of_six_joints(arm: Arm) -> tuple[TemplateCase, ...]:
    """Of the two functions of an arm with a spherical wrist; one pose is out of reach."""
    T = poses(arm)
    found, q = all_branches(arm, T), positions(arm)
    beyond = all_branches(arm, _far(T)).reach_excess.min()
    return (
        _all(T, found.q, (*found.reach_excess.min(axis=1), float(beyond)), ()),
        _near(arm, T, None, q),
    )


def _all(
    T: Array, q: Array, excess: tuple[float, ...], more: tuple[tuple[Argument, list[list[float]]], ...]
) -> TemplateCase:  # fmt: skip
    """All branches of some poses, and none of one far out."""
    rows = [*_flat(q), [math.nan] * q[0].size]
    pose = (_POSE, [*_flat(T), *_flat(_far(T))])
    return TemplateCase(NAME, (pose, *more), "rad", rows, [float(x) for x in excess], TOLERANCE)


def _near(arm: Arm, T: Array, psi: Array | None, q: Array) -> TemplateCase:
    """From close by, each position is found again."""
    angle = () if psi is None else ((_ARM_ANGLE, psi[:, None].tolist()),)
    start = (Argument("q_near", arm.n, "rad"), (q + _AWAY).tolist())
    return TemplateCase(f"{NAME}_near", ((_POSE, _flat(T)), *angle, start), "rad", q.tolist(), [0.0] * len(q),
                        TOLERANCE)  # fmt: skip


def _inside(arm: Arm, geometry: SrsGeometry, T: Array) -> tuple[Array, Array, Array]:
    """(pose, arm angle, position inside the limits) of each pose where one of some arm angles has one."""
    ranges = joint_ranges(arm)
    rows = []
    for pose in T:
        psi = np.linspace(-3.0, 3.0, 61)
        q = branches(arm, geometry, np.broadcast_to(pose, (len(psi), 4, 4)), psi)
        good = np.argwhere((np.abs(q - ranges.middle) < ranges.half).all(axis=-1))
        rows += [(pose, psi[k], q[k, b]) for k, b in good[len(good) // 2 :][:1]]
    return np.array([r[0] for r in rows]), np.array([r[1] for r in rows]), np.array([r[2] for r in rows])


def _intervals(arm: Arm, geometry: SrsGeometry, T: Array) -> list[list[tuple[float, float]]]:
    every = np.broadcast_to(T, (len(BRANCHES), 4, 4))
    problem = margin_problem(geometry, joint_ranges(arm), every, np.array(BRANCHES, dtype=np.float64))
    found = intervals_at_level(problem, MARGIN)
    return [[(float(a), float(b)) for a, b in found.of(k)] for k in range(len(BRANCHES))]


def _far(T: Array) -> Array:
    """The first pose, out of reach."""
    out = T[:1].copy()
    out[:, :3, 3] *= _FAR
    return out


def _flat(rows: Array) -> list[list[float]]:
    return [row.ravel().tolist() for row in rows]
