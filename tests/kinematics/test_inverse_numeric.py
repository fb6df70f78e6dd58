"""The numeric search: its solutions are right, inside the limits where possible, and never called complete."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.inverse import _step, inverse_kinematics
from lwr_dyn.model.chain import lock_joint
from tests.random_arms import random_arm

NUMERIC = 1e-11
"""The numeric search stops here."""
LWR = lwr_dyn.load("lwr4plus")
SIX = replace(LWR, name="six", chain=lock_joint(LWR.chain, 2, 0.3), limits=LWR.limits[:2] + LWR.limits[3:])


def pose(arm, q):
    return lwr_dyn.forward_kinematics(arm, q)


@pytest.mark.slow
def test_numeric_search_solves_other_arms_inside_limits_and_calls_itself_incomplete():
    rng = np.random.default_rng(4)
    for q in rng.uniform(SIX.lower, SIX.upper, (10, 6)):
        T = pose(SIX, q)
        result = inverse_kinematics(SIX, T, starts=32)
        assert (result.status, result.complete) == ("solved", False)
        for s in result.solutions:
            assert np.abs(pose(SIX, s.q) - T).max() <= NUMERIC
            assert s.residual <= NUMERIC
            assert ((s.q >= SIX.lower) & (s.q <= SIX.upper)).all()
    assert len(result.solutions) >= 1
    again = inverse_kinematics(SIX, T, starts=32)
    assert all((a.q == b.q).all() for a, b in zip(result.solutions, again.solutions, strict=True))


def test_a_joint_that_pushes_against_its_limit_is_held_and_the_others_do_the_work():
    rng = np.random.default_rng(1)
    J, error = rng.normal(size=(1, 6, 7)), rng.normal(size=(1, 6))
    free = np.linalg.pinv(J[0]) @ error[0]
    q, wide, weak = np.zeros((1, 7)), np.full(7, 9.0), np.array([1e-14])
    j = int(np.argmax(free))
    upper = np.where(np.arange(7) == j, 0.0, wide)
    step = _step(J, error, weak, q, -wide, upper)[0]
    assert step[j] == 0.0
    assert J[0] @ step == pytest.approx(error[0], abs=1e-9)


@pytest.mark.parametrize("rank", range(5))
def test_a_jacobian_that_has_lost_rank_gives_a_step(rank):
    """UR10e with a stretched elbow and others ended with "Singular matrix": J J^T alone is singular to rounding."""
    rng = np.random.default_rng(rank)
    J = np.round(rng.normal(size=(300, 6, rank)), 2) @ np.round(rng.normal(size=(300, rank, 7)), 1)
    error, wide, q = np.einsum("kij,kj->ki", J, rng.normal(size=(300, 7))), np.full(7, 9.0), np.zeros((300, 7))
    step = _step(J, error, np.full(300, 1e-20), q, -wide, wide)
    assert np.abs(np.einsum("kij,kj->ki", J, step) - error).max() <= 1e-6 * max(1.0, np.abs(error).max())
    _step(J, rng.normal(size=(300, 6)), np.full(300, 1e-20), q, -wide, wide)  # a pose out of reach


@pytest.mark.parametrize("seed", range(4))
def test_numeric_search_with_sliding_joints(seed):
    arm = random_arm(seed, "RPRRPRR")
    T = pose(arm, np.random.default_rng(seed).uniform(-0.8, 0.8, 7))
    result = inverse_kinematics(arm, T, starts=32)
    assert result.status == "solved"
    assert result.solutions[0].residual <= NUMERIC


def test_numeric_search_distinguishes_reach_from_limits():
    far = np.eye(4)
    far[0, 3] = 3.0
    result = inverse_kinematics(SIX, far, starts=16)
    assert (result.status, result.complete) == ("out of reach", False)
    assert result.distance > 2.0
    bent = pose(SIX, [0.3, 0.7, -2.3, 0.4, 0.9, 0.1])
    result = inverse_kinematics(SIX, bent, starts=16)
    assert (result.status, result.joint) == ("outside limits", "joint_4")
    assert result.excess >= 2.3 - np.radians(120) - 1e-9


def test_an_arm_of_four_joints_meets_a_position_and_says_how_far_the_orientation_is_off(tmp_path):
    file = tmp_path / "arm.toml"
    file.write_text(template(str(file), "arm", joints="RRPR", convention="modified"))
    arm, T = lwr_dyn.load(file), np.eye(4)
    T[:3, 3] = 0.3, 0.1, 0.3
    result = inverse_kinematics(arm, T)
    assert (result.status, result.complete, result.distance) == ("out of reach", False, 0.0)
    found = inverse_kinematics(arm, T[:3, 3], position_only=True).solutions[0]
    R = flange_pose(arm.chain, found.q)[:3, :3]
    assert 0.1 < result.turn <= np.arccos((np.trace(R) - 1.0) / 2.0) + 1e-9


@pytest.mark.parametrize("robot", ["kr30ha", "lwr4plus", "wam7"])
def test_a_position_alone_is_reached_from_a_start_inside_the_limits(robot):
    arm, rng = lwr_dyn.load(robot), np.random.default_rng(6)
    for q in rng.uniform(arm.lower, arm.upper, (8, arm.n)):
        position = pose(arm, q)[:3, 3]
        result = inverse_kinematics(arm, position, position_only=True)
        (solution,) = result.solutions
        assert (result.status, result.position_only, result.complete) == ("solved", True, False)
        assert np.abs(pose(arm, solution.q)[:3, 3] - position).max() <= NUMERIC
        assert solution.residual <= NUMERIC
        assert solution.inside_limits
        near = np.clip(q + 0.01, arm.lower, arm.upper)
        moved = inverse_kinematics(arm, pose(arm, q), position_only=True, q0=near).solutions[0].q
        assert np.abs(moved - near).max() < 0.3


@pytest.mark.slow
def test_a_position_outside_limits_or_out_of_reach_is_told_apart():
    bent = pose(SIX, [0.3, 0.7, -2.6, 0.4, 0.0, 0.1])[:3, 3]
    result = inverse_kinematics(SIX, bent, position_only=True)
    assert (result.status, result.position_only) == ("outside limits", True)
    result = inverse_kinematics(SIX, [3.0, 0.0, 0.0], position_only=True)
    assert (result.status, result.turn) == ("out of reach", None)
    assert result.distance > 2.0
