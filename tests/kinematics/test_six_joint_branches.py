"""All branches of six-joint arms: as many as a search from many starts finds, also where the arm is not quite exact."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics.branches import wrap
from lwr_dyn.kinematics.six_joint_branches import SixJointBranches, solve_pose
from lwr_dyn.kinematics.solution import PoseProblem
from lwr_dyn.kinematics.three_parallel import SOLVER
from tests.kinematics.six_joint_arms import TABLES, against_search, six_joint_arm

SOLVED = 1e-11
"""[m and dimensionless] The polish stops here."""
SAME = 1e-9
"""[rad] Largest difference of a branch to the same solution of a search, away from singularities."""


@pytest.mark.parametrize(
    ("name", "error", "seed"),
    [("ur10e", 0.0, 0), ("ur10e", 1e-4, 1), ("kr210", 1e-3, 2), ("m1013", 0.0, 3), ("z1", 1e-4, 4), ("tx60", 0.0, 5)],
)
def test_branches_are_those_of_a_search_from_many_starts(name, error, seed):
    arm = six_joint_arm(name, error, seed)
    T = lwr_dyn.forward_kinematics(arm, np.random.default_rng(seed).uniform(-np.pi, np.pi, 6))
    count, shared, only_searched, gap = against_search(arm, T, starts=120)
    assert (count, only_searched) == (shared, 0)
    assert count >= 2
    assert gap < SAME


@pytest.mark.parametrize("error", [0.0, 1e-4])
@pytest.mark.parametrize("name", TABLES)
def test_the_joints_of_random_poses_are_among_their_branches(name, error):
    arm = six_joint_arm(name, error)
    for q in np.random.default_rng(1).uniform(-np.pi, np.pi, (5, 6)):
        result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, q))
        exact = error == 0.0 and name not in ("m1013", "lite6")
        assert (result.status, result.complete) == ("solved", exact)
        assert min(np.abs(wrap(s.q - q)).max() for s in result.solutions) < 1e-7
        assert max(s.residual for s in result.solutions) < SOLVED
        labels = {s.branch for s in result.solutions}
        assert len(labels) == len({tuple(np.round(np.exp(1j * s.q), 6)) for s in result.solutions})


@pytest.mark.parametrize("name", ["ur10e", "kr210"])
@pytest.mark.parametrize("joint", [2, 4])
def test_stretched_and_aligned_arms_with_calibrated_numbers_keep_their_branches(name, joint):
    arm = six_joint_arm(name, 1e-4, seed=3)
    q = np.array([0.4, -1.0, 1.1, -0.6, 1.3, 0.2])
    q[joint] = (np.arctan2(0.054, 1.5) - np.pi / 2) * (joint == 2 and name == "kr210")
    result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, q))
    assert min(np.abs(wrap(s.q - q)).max() for s in result.solutions) < 1e-4
    assert max(s.residual for s in result.solutions) < SOLVED


def test_every_copy_whole_turns_apart_is_listed():
    arm = six_joint_arm("ur10e")
    result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, [0.1, -1.0, 1.2, 0.3, 0.4, 0.5]))
    assert len(result.solutions) == 2**6 * len({s.branch for s in result.solutions})
    assert len({tuple(s.q.round(9)) for s in result.solutions}) == len(result.solutions)
    assert max(s.residual for s in result.solutions) < SOLVED
    assert all(s.inside_limits for s in result.solutions)


def test_a_pose_out_of_reach_is_proven_so_only_on_an_exact_arm():
    far = np.eye(4)
    far[0, 3] = 3.0
    for error, proven in ((0.0, True), (1e-4, False)):
        result = lwr_dyn.inverse_kinematics(six_joint_arm("ur10e", error), far)
        assert (result.status, result.complete) == ("out of reach", proven)
        assert 1.5 < result.distance < 2.0


def test_a_closed_form_that_finds_nothing_is_out_of_reach():
    arm = six_joint_arm("ur10e")
    nothing = SixJointBranches(np.full((1, 8, 6), np.nan), np.full((1, 8), 0.25), np.ones((1, 8, 3)))
    problem = PoseProblem(arm, np.eye(4))
    result = solve_pose(lambda *given: nothing, problem, SOLVER.recognise(arm.chain))
    assert (result.status, result.distance) == ("out of reach", 0.25)
