"""The search on Pinocchio: random and singular poses, the pull inside the limits, its first step by the formula."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.kinematics.pose_solver import FOUND, PinocchioSearch, PoseSolver, pinocchio_search
from tests.kinematics.solved_poses import arm_named, assert_reached
from tests.public_arms import random_positions, singular_positions


@pytest.mark.parametrize("name", ["kr30ha", "lwr4plus", "j2n6s300"])
def test_random_poses_are_reached(name):
    arm = arm_named(name)
    solve = PoseSolver(arm, pinocchio_search(arm, limits=True, starts=300, seed=0))
    T = lwr_dyn.forward_kinematics(arm, random_positions(arm, 25, seed=4))
    assert_reached(arm, np.array([solve(pose) for pose in T]), T)


def test_singular_poses_are_reached():
    arm = arm_named("ur10e")
    T = lwr_dyn.forward_kinematics(arm, singular_positions(arm, 20, seed=4))
    solve = lwr_dyn.ik_solver(arm, search="pinocchio")
    assert isinstance(solve.search, PinocchioSearch)
    assert_reached(arm, solve.batch(T).q, T)


def test_a_redundant_arm_is_pulled_inside_its_limits(monkeypatch):
    arm = arm_named("lwr4plus")
    search = pinocchio_search(arm, limits=True, starts=1, seed=0)
    q = random_positions(arm, 40, seed=9)
    T = lwr_dyn.forward_kinematics(arm, q)

    def found():
        rows = search.rows(T, np.clip(q + 0.8, arm.lower, arm.upper), False)
        good = rows[:, arm.n] == FOUND
        assert_reached(arm, rows[good, : arm.n], T[good])
        return good.sum()

    pulled = found()
    monkeypatch.setattr("lwr_dyn.kinematics.pose_solver._REPAIR", 0)
    assert found() < pulled


def test_the_first_step_is_that_of_the_formula():
    arm = arm_named("kr30ha")
    q = (arm.lower + arm.upper) / 2 + 0.3
    T = lwr_dyn.forward_kinematics(arm, q)
    target = T.copy()
    target[:3, 3] += 0.01, -0.02, 0.005
    search = pinocchio_search(arm, limits=True, starts=1, seed=0)
    steps = search._steps(target, q, None)
    next(steps)
    J, error = jacobian(arm.chain, q), np.array([0.01, -0.02, 0.005, 0.0, 0.0, 0.0])
    damping = 0.1 * (error @ error) / 2 + 1e-12
    expected = q + J.T @ np.linalg.solve(J @ J.T + damping * np.eye(6), error)
    assert np.abs(next(steps)[0] - expected).max() < 1e-12
