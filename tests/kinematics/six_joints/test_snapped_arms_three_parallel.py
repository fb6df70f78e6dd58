"""Arms with three parallel axes: every branch of many poses, and poses where wrist, elbow or shoulder is singular."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics.six_joints.snapped_arms import snapped_arm, three_parallel_closed_form
from lwr_dyn.kinematics.six_joints.spherical_wrist import NEAR_SINGULAR
from lwr_dyn.kinematics.solution import joint_ranges, wrap
from tests.kinematics.six_joints.six_joint_arms import PARALLEL, six_joint_arm

POSE, FOUND = 1e-11, 1e-8
"""[m and dimensionless], [rad]"""


@pytest.mark.slow
@pytest.mark.parametrize("name", PARALLEL)
def test_q_is_among_the_branches_and_each_branch_gives_the_pose(name):
    arm = six_joint_arm(name)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (2000, 6))
    T = lwr_dyn.forward_kinematics(arm, q)
    result = three_parallel_closed_form(snapped_arm(arm.chain, 4).geometry, joint_ranges(arm), T)
    gap = np.abs(wrap(result.q - q[:, None])).max(axis=2)
    gap = np.where(np.isnan(gap), np.inf, gap)
    nearest = gap.argmin(axis=1)
    clear = (result.clearance[np.arange(len(q)), nearest] >= 1e-3).all(axis=1)
    assert clear.mean() > 0.9
    assert gap.min(axis=1)[clear].max() < FOUND
    back = lwr_dyn.forward_kinematics(arm, np.nan_to_num(result.q))
    assert np.abs(back - T[:, None])[result.reachable].max() < POSE


@pytest.mark.slow
@pytest.mark.parametrize("distance", [0.0, 1e-16, 1e-12, 1e-9, 1e-6])
def test_an_aligned_wrist_is_named_and_gives_one_of_its_many_solutions(distance):
    arm = six_joint_arm("ur10e")
    for q in np.random.default_rng(2).uniform(-np.pi, np.pi, (30, 6)):
        q[4] = distance
        result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, q))
        assert result.status == "solved"
        assert "wrist" in result.singular
        assert max(s.residual for s in result.solutions) < POSE


def test_stretched_and_folded_elbows_are_named_and_solved():
    arm = six_joint_arm("ur10e")
    for q in np.random.default_rng(3).uniform(-np.pi, np.pi, (30, 6)):
        q[2] = 0.0
        result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, q))
        assert "elbow" in result.singular
        assert max(s.residual for s in result.solutions) < POSE
        assert min(np.abs(wrap(s.q - q)).max() for s in result.solutions) < 1e-6


def test_out_of_reach_says_by_how_much():
    arm = six_joint_arm("ur10e")
    g = snapped_arm(arm.chain, 4).geometry
    T = lwr_dyn.forward_kinematics(arm, np.array([0.3, -0.7, 0.0, 0.4, 1.2, 0.1]))
    wrist = T[:3, 3] + T[:3, :3] @ g.wrist_in_flange
    T[2, 3] += 4.0 - wrist[2]
    result = lwr_dyn.inverse_kinematics(arm, T)
    assert (result.status, result.complete) == ("out of reach", True)
    assert 4.0 - 0.1807 - 0.6127 - 0.57155 - 0.11985 <= result.distance < 4.0
    T[:3, 3] -= wrist * [1, 1, 0] + [0, 0, 3.2]  # W on axis 1: its offset from the plane cannot be had
    result = lwr_dyn.inverse_kinematics(arm, T)
    assert result.status == "out of reach"
    assert result.distance > NEAR_SINGULAR
