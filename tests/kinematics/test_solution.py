"""Solutions of a pose: each once, in order; the nearest one."""

import numpy as np

import lwr_dyn
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.solution import joint_distance, nearest_solution

LWR = lwr_dyn.load("lwr4plus")
RESIDUAL = 1e-12


def pose(arm, q):
    return lwr_dyn.forward_kinematics(arm, q)


def test_the_stretched_arm_has_one_solution_and_is_solved():
    result = inverse_kinematics(LWR, pose(LWR, np.zeros(7)))
    assert result.status == "solved"
    assert len(result.solutions) == 1
    assert np.abs(result.solutions[0].q).max() < 1e-4


def test_the_nearest_solution_has_the_smallest_joint_distance():
    kr30 = lwr_dyn.load("kr30ha")
    q = np.random.default_rng(4).uniform(kr30.lower, kr30.upper)
    result = lwr_dyn.inverse_kinematics(kr30, lwr_dyn.forward_kinematics(kr30, q))
    best = nearest_solution(result.solutions, q)
    assert joint_distance(best, q) < 1e-8
    assert joint_distance(best, q) == min(joint_distance(s, q) for s in result.solutions)
