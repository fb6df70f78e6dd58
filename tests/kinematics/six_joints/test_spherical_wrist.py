"""Six-joint arms with a spherical wrist: every branch, every whole turn, singular poses, reach against limits."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.six_joints import spherical_wrist
from lwr_dyn.kinematics.solution import BRANCHES, joint_ranges, wrap
from tests.kinematics.six_joints.six_joint_arms import assert_recovered, six_joint_arm
from tests.random_arms import random_arm

FOUND = 1e-9
"""[rad] Largest error of a recovered q, at least 1e-5 from every singularity; sqrt of it is lost nearer."""
POSE = 1e-9
"""[m] Largest error of the pose of a solution, everywhere."""
ELBOW_STRAIGHT = np.arctan2(0.145, 0.82)


KR30 = lwr_dyn.load("kr30ha")


@pytest.fixture
def kr30():
    return KR30


def random_q(arm, k, seed=0):
    return np.random.default_rng(seed).uniform(arm.lower, arm.upper, (k, arm.n))


@pytest.mark.slow
@pytest.mark.parametrize("reading", ["kuka", "printed"])
def test_q_is_among_the_branches_and_each_branch_gives_the_pose(reading):
    arm = lwr_dyn.load("kr30ha", reading)
    q = random_q(arm, 100_000)
    result = spherical_wrist.all_branches(arm, lwr_dyn.forward_kinematics(arm, q))
    assert_recovered(arm, result, q, spherical_wrist.NEAR_SINGULAR, FOUND, 0.999)


def near(which, distance):
    """q of the KR 30 HA at a distance from one singularity [m or rad]."""
    q = np.radians([20.0, -80.0, 60.0, 40.0, 30.0, -70.0])
    if which == "wrist":
        q[4] = distance
    elif which == "elbow":
        q[2] = ELBOW_STRAIGHT + distance
    else:
        # 0.35 + 0.85 cos(A2) + 0.8327 cos(A2 + A3 - 10 deg) = distance, for A2 = -80 deg
        cosine = (distance - 0.35 - 0.85 * np.cos(q[1])) / np.hypot(0.145, 0.82)
        q[2] = -np.arccos(cosine) - q[1] + ELBOW_STRAIGHT
    return q


@pytest.mark.parametrize("which", ["shoulder", "elbow", "wrist"])
@pytest.mark.parametrize("distance", [0.0, 1e-16, 1e-13, 1e-10, 1e-8, 3e-6, 1e-4])
def test_near_a_singularity_the_pose_comes_back_and_it_is_named(kr30, which, distance):
    q = near(which, distance)
    result = lwr_dyn.inverse_kinematics(kr30, lwr_dyn.forward_kinematics(kr30, q), limits=False)
    assert result.status == "solved"
    assert (which in result.singular) == (distance < 1e-4)
    assert max(solution.residual for solution in result.solutions) < POSE
    assert which in result.singular or min(np.abs(wrap(s.q - q)).max() for s in result.solutions) < FOUND


def test_eight_branches_of_a_pose_differ_and_every_whole_turn_of_them_is_listed_once(kr30):
    q = np.radians([20.0, -110.0, 110.0, 40.0, 50.0, -70.0])
    result = spherical_wrist.all_branches(kr30, lwr_dyn.forward_kinematics(kr30, q)[None])
    assert result.reachable.all()
    for i, j in product(range(8), repeat=2):
        assert i == j or np.abs(wrap(result.q[0, i] - result.q[0, j])).max() > 1e-3
    assert [b.label for b in BRANCHES][:2] == ["+++", "++-"]
    assert BRANCHES[np.abs(wrap(result.q[0] - q)).max(axis=1).argmin()].shoulder == 1
    q = np.radians([178.0, -60.0, 100.0, 40.0, 50.0, -70.0])
    result = lwr_dyn.inverse_kinematics(kr30, lwr_dyn.forward_kinematics(kr30, q))
    wanted = set(product((-182.0, 178.0), (40.0, -320.0), (-70.0, 290.0)))  # A1 turns to +-185 deg
    there = [s.q for s in result.solutions if abs(np.degrees(s.q[4]) - 50.0) < 1e-6]
    assert {tuple(np.degrees(q[[0, 3, 5]]).round(6)) for q in there} >= wanted
    assert len({tuple(s.q.round(9)) for s in result.solutions}) == len(result.solutions)
    for solution in result.solutions:
        assert ((solution.q >= kr30.lower - 1e-12) & (solution.q <= kr30.upper + 1e-12)).all()
        assert solution.residual < POSE


def test_out_of_reach_is_distinguished_from_outside_limits(kr30):
    far = lwr_dyn.forward_kinematics(kr30, np.zeros(6))
    far[0, 3] += 0.5
    result = lwr_dyn.inverse_kinematics(kr30, far)
    assert (result.status, result.complete, result.solutions) == ("out of reach", True, ())
    span = np.hypot(2.52 - 0.35, 0.145) - 0.85 - np.hypot(0.145, 0.82)
    assert result.distance == pytest.approx(span, abs=1e-12)
    beyond = np.radians([0.0, 60.0, 20.0, 0.0, 40.0, 0.0])
    result = lwr_dyn.inverse_kinematics(kr30, lwr_dyn.forward_kinematics(kr30, beyond))
    assert (result.status, result.joint, result.complete) == ("outside limits", "A2", True)
    assert result.excess == pytest.approx(np.radians(60 - 35 - 7.83), abs=0.7)
    assert all(not s.inside_limits for s in result.outside)
    assert lwr_dyn.inverse_kinematics(kr30, lwr_dyn.forward_kinematics(kr30, beyond), limits=False).status == "solved"


def test_an_aligned_wrist_shares_its_turn_so_that_both_axes_stay_inside(kr30):
    narrow = replace(kr30, limits=(*kr30.limits[:5], replace(kr30.limits[5], lower=-0.5, upper=0.5)))
    q = np.radians([10.0, -90.0, 90.0, 100.0, 0.0, 20.0])
    result = lwr_dyn.inverse_kinematics(narrow, lwr_dyn.forward_kinematics(narrow, q))
    aligned = [s.inside_limits and s.residual < POSE for s in result.solutions if "wrist" in s.singular]
    assert aligned
    assert all(aligned)


def test_where_both_have_room_axis_4_of_an_aligned_wrist_is_in_the_middle_of_its_range(kr30):
    one_sided = replace(kr30.limits[3], lower=-0.2, upper=1.2)
    arm = replace(kr30, limits=(*kr30.limits[:3], one_sided, *kr30.limits[4:]))
    pose = lwr_dyn.forward_kinematics(arm, np.radians([10.0, -90.0, 90.0, 20.0, 0.0, 20.0]))
    found = [s.q[3] for s in lwr_dyn.inverse_kinematics(arm, pose).solutions if "wrist" in s.singular]
    branches = spherical_wrist.all_branches(arm, pose[None])
    for q4 in (found, branches.q[0, branches.clearance[0, :, 2] < 1e-9, 3]):
        assert len(q4) > 1
        assert np.abs((np.array(q4) - 0.5 + np.pi / 2) % np.pi - np.pi / 2).max() < 1e-9


SHAPES = {
    "beside the plane, axis 3 reversed":
        ([90, 180, 90, -90, 90, 0], [0.2, 0.6, 0.1, 0, 0, 0], [0.5, 0.12, 0, 0.5, 0, 0.1]),
    "no shoulder offset, elbow in line": ([-90, 0, 90, -90, 90, 0], [0, 0.4, 0, 0, 0, 0], [0.4, 0, 0, 0.45, 0, 0.08]),
    "axis 1 down, flange tilted":
        ([90, 0, -90, 90, -90, 40], [0.1, 0.5, -0.2, 0, 0, 0.1], [-0.3, 0.05, -0.1, 0.4, 0, 0.2]),
}  # fmt: skip
"""alpha [deg], a [m], d [m]."""


@pytest.mark.parametrize("name", SHAPES)
def test_other_arms_of_the_kind_are_solved_too(name):
    arm = six_joint_arm(name, reach=np.radians(170), table=SHAPES[name])
    assert spherical_wrist.wrist_arm_geometry(arm.chain) is not None
    q = random_q(arm, 2000)
    T = lwr_dyn.forward_kinematics(arm, q)
    result = spherical_wrist.closed_form(spherical_wrist.require_wrist_arm(arm), joint_ranges(arm), T)
    assert_recovered(arm, result, q, 1e-3, FOUND, 0.9)


def test_constants_are_those_of_the_table_and_arms_without_a_spherical_wrist_are_refused():
    with pytest.raises(OptionError, match="lwr4plus"):
        spherical_wrist.require_wrist_arm(lwr_dyn.load("lwr4plus"))
    assert spherical_wrist.six_axes(random_arm(1, "RRPRRR").chain) is None
    bent = replace(KR30.chain.links[3], after=KR30.chain.links[0].after)
    other = KR30.with_chain(replace(KR30.chain, links=(*KR30.chain.links[:3], bent, *KR30.chain.links[4:])))
    assert spherical_wrist.wrist_arm_geometry(other.chain) is None
    with pytest.raises(OptionError, match="only for an S-R-S arm"):
        lwr_dyn.inverse_kinematics(KR30, np.eye(4), arm_angle=0.1)
    g = spherical_wrist.wrist_arm_geometry(KR30.chain)
    assert g.lengths == pytest.approx((0.85, np.hypot(0.145, 0.82)), rel=1e-14)
    assert (abs(g.lateral), np.hypot(*g.lever)) == pytest.approx((0.0, 0.0), abs=1e-14)
    assert abs(g.straight) == pytest.approx(np.arctan2(0.145, 0.82))
    assert spherical_wrist.planar_arm(spherical_wrist.six_axes(KR30.chain), ball_starts=4) is None
    mounted = spherical_wrist.wrist_arm_geometry(
        lwr_dyn.load("kr30ha", mount={"xyz": [0.3, -0.2, 1.4], "rpy_deg": [0, 0, 35]}).chain
    )
    assert (mounted.lateral, mounted.front) == pytest.approx((g.lateral, g.front), abs=1e-14)
