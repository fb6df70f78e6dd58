"""Newton's last steps: their second derivatives, and poses at which an arm is stretched with its axes aligned."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.pose_kernel import curvature, finish
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.kinematics.pose_solver import FOUND, NOT_REACHED, OUTSIDE, pose_error, search_ranges
from tests.kinematics.solved_poses import arm_named, assert_reached, solver_of
from tests.random_arms import random_arm

STRETCHED = [  # Gen3, at which steps by J alone end at errors of 1e-8 to 1e-6; in the last four beside a minimum of E
    [-2.5626, -0.7695, 0.0, 0.0, 0.0, -1.5708, -2.729],
    [1.1242, -1.4311, 0.0, 0.0, 0.0, 0.2979, 1.5708],
    [1.8905, 0.4562, 0.0, 0.0, 0.0, 0.8877, 2.0709],
    [1.5708, -1.4656, 0.0, 0.0, 0.0, 0.8392, -2.0828],
    [2.7727, 0.5308, 0.0, 0.0, 0.0, -1.5708, 0.83],
    [-0.9206, 2.181, 0.0, 0.0, 0.0, 1.6214, 0.5331],
    [-1.5688, 0.8969, 0.0, 0.0, 0.0, 0.6108, -0.2034],
]


@pytest.mark.parametrize("joints", ["RRRRRRR", "RPRRPR"])
def test_the_second_derivatives_are_those_of_the_error(joints):
    arm, rng, step = random_arm(5, joints), np.random.default_rng(2), 1e-5
    q = rng.uniform(-1.0, 1.0, arm.n)
    T = lwr_dyn.forward_kinematics(arm, q + 1e-4 * rng.uniform(-1.0, 1.0, arm.n))

    def slope(q):
        return -jacobian(arm.chain, q).T @ pose_error(T, lwr_dyn.forward_kinematics(arm, q))[0]

    moved = step * np.eye(arm.n)
    numeric = np.array([(slope(q + row) - slope(q - row)) / (2.0 * step) for row in moved])
    error = pose_error(T, lwr_dyn.forward_kinematics(arm, q))[0]
    J = jacobian(arm.chain, q)
    numeric = (numeric + numeric.T) / 2.0
    assert np.abs(J.T @ J - numeric).max() > 1e-5  # what J alone leaves out
    assert np.abs(curvature(J, error) - numeric).max() < 1e-7


def test_newtons_steps_end_at_the_pose_or_leave_the_row_as_it_was():
    """From 1e-4 rad two steps; the row keeps its start and counts its steps."""
    arm = arm_named("kr30ha")
    x = search_ranges(arm, True, 1, 0)
    for beyond, code in ((0.0, FOUND), (0.1, OUTSIDE)):
        q = x.middle + 0.2
        q[1] = x.upper[1] + beyond if beyond else q[1]
        T = lwr_dyn.forward_kinematics(arm, q)
        row = np.array([*(q + 1e-4), NOT_REACHED, 1.0, 1.0, 1.0, 3.0, 7.0])
        found = finish(arm.chain, x, T, row, None)
        assert found[6:].tolist() == [code, *found[7:10], 3.0, 9.0]
        assert (found[7:9] < 1e-18).all()
        assert np.abs(found[:6] - q).max() < 1e-8
        turned = finish(arm.chain, x, T, row + 2.0 * np.pi * np.eye(12)[5], q)
        assert np.abs(turned[:6] - q).max() < 1e-8
        T[0, 3] += 10.0
        assert finish(arm.chain, x, T, row, None) is row


@pytest.mark.slow
def test_a_stretched_arm_with_its_axes_aligned_is_reached(monkeypatch):
    arm, solve = arm_named("gen3"), solver_of("gen3", "kernel")
    T = lwr_dyn.forward_kinematics(arm, STRETCHED)
    assert_reached(arm, solve.batch(T).q, T)
    assert_reached(arm, np.array([solve(pose) for pose in T]), T)
    monkeypatch.setattr("lwr_dyn.codegen.kernels.pose_kernel._AGAIN", 0)
    first = solve.batch(T).found.sum()
    monkeypatch.setattr("lwr_dyn.codegen.kernels.pose_kernel._CLOSE", 0.0)
    assert solve.batch(T).found.sum() < first < len(T)
