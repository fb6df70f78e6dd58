"""The WAM is an S-R-S arm with its elbow off the line: the closed form solves it, every branch, at rounding."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.checks.arm.model_laws import random_states
from tests.tolerances import METRES


@pytest.mark.slow
def test_a_thousand_poses_inside_the_limits_are_solved_inside_the_limits():
    arm = lwr_dyn.load("wam7")
    poses = lwr_dyn.forward_kinematics(arm, random_states(arm, 1000, 20240607).q)
    for pose in poses:
        result = lwr_dyn.inverse_kinematics(arm, pose)
        assert result.status == "solved"
        assert result.complete
        for solution in result.solutions:
            assert solution.residual <= METRES
            assert (solution.q >= arm.lower - 1e-12).all()
            assert (solution.q <= arm.upper + 1e-12).all()


def test_the_given_joints_are_among_the_branches_at_their_own_arm_angle():
    arm = lwr_dyn.load("wam7")
    q = np.array([0.3, -0.7, 0.4, 1.6, -0.5, 0.6, 0.2])
    pose = lwr_dyn.forward_kinematics(arm, q)
    angles = np.linspace(-np.pi, np.pi, 181)
    nearest = min(
        min(np.abs(s.q - q).max() for s in lwr_dyn.inverse_kinematics(arm, pose, arm_angle=a, limits=False).solutions)
        for a in angles
    )
    assert nearest < np.radians(3.0)  # the angles stand 2 degrees apart


def test_out_of_reach_is_distinguished_from_outside_limits():
    pose = np.eye(4)
    pose[:3, 3] = 0.0, 0.0, 0.95
    reach = np.hypot(0.55, 0.045) + np.hypot(0.3, 0.045)
    result = lwr_dyn.inverse_kinematics(lwr_dyn.load("wam7"), pose)
    assert result.status == "out of reach"
    assert result.distance == pytest.approx(0.89 - reach, rel=1e-12)
