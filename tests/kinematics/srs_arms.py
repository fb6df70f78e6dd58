"""Random S-R-S arms: any base, any zero positions, elbow offsets, any flange."""

import numpy as np

from lwr_dyn.kinematics.arm_geometry import srs_geometry
from lwr_dyn.kinematics.solution import BRANCHES, joint_ranges
from lwr_dyn.kinematics.srs_margins import margin_problem
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Chain, ChainLink, JointKind, link_frames
from lwr_dyn.model.spatial import Pose, axis_to_z, from_rpy


def random_srs_arm(seed, half_range=(1.0, 3.0), wrist_off_plane=0.0):
    """Axes and points are drawn in the base; each link's frame is its axis with a random turn about it."""
    rng = np.random.default_rng(seed)
    base = Pose(from_rpy(rng.uniform(-3, 3, 3)), rng.uniform(-1, 1, 3))
    elbow_axis = _unit(rng)
    side = _square(rng, elbow_axis)
    other = np.cross(elbow_axis, side)
    shoulder = np.zeros(3)
    elbow = shoulder + rng.uniform(0.2, 0.5) * side + rng.uniform(-0.1, 0.1) * other
    wrist = elbow + rng.uniform(0.2, 0.5) * side + rng.uniform(-0.3, 0.3) * other + wrist_off_plane * elbow_axis
    axes = [*_ball(rng), elbow_axis, *_ball(rng)]
    points = [shoulder] * 3 + [elbow + rng.uniform(-1, 1) * elbow_axis] + [wrist] * 3
    links, last = [], Pose.identity()
    for i, (axis, point) in enumerate(zip(axes, points, strict=True)):
        slid = point if i == 3 else point + rng.uniform(-0.3, 0.3) * axis
        here = base @ Pose(axis_to_z(axis) @ from_rpy((0, 0, rng.uniform(-3, 3))), slid)
        after = Pose(from_rpy(rng.uniform(-3, 3, 3)), rng.uniform(-0.2, 0.2, 3))
        links.append(ChainLink(f"joint_{i + 1}", f"link_{i + 1}", JointKind.REVOLUTE, last.inverse() @ here, after))
        last = here @ after
    middle, half = rng.uniform(-1, 1, 7), rng.uniform(*half_range, 7)
    limits = tuple(JointLimits(float(m - h), float(m + h)) for m, h in zip(middle, half, strict=True))
    flange = Pose(from_rpy(rng.uniform(-3, 3, 3)), rng.uniform(-0.2, 0.2, 3))
    return Arm("random-srs", "none", "random S-R-S arm", Chain(tuple(links), flange, np.zeros(3)), limits)


def _unit(rng):
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def _square(rng, axis):
    v = np.cross(axis, _unit(rng))
    return v / np.linalg.norm(v)


def _ball(rng):
    tilt = _unit(rng)
    return _square(rng, tilt), tilt, _square(rng, tilt)


def fk(arm, q):
    """Flange poses (k, 4, 4), ungated."""
    *_, pose = link_frames(arm.chain, q)
    return pose


def each_branch(T):
    """Every pose with each of the eight branches."""
    return np.repeat(T, 8, axis=0), np.tile(np.array(BRANCHES), (len(T), 1))


def problem_of(arm, q):
    """The margins of every branch at the poses of q (k, 7), and what they were computed from."""
    geometry, ranges = srs_geometry(arm.chain), joint_ranges(arm)
    T, signs = each_branch(fk(arm, q))
    return margin_problem(geometry, ranges, T, signs), geometry, ranges, T, signs
