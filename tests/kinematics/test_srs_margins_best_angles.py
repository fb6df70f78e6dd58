"""The best arm angle of a pose: better than every other on the circle, and inside the limits where one is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.kinematics.arm_geometry import srs_geometry
from lwr_dyn.kinematics.solution import joint_ranges
from lwr_dyn.kinematics.srs import closed_form
from lwr_dyn.kinematics.srs_margins import CERTAIN, best_angles, intervals_at_level, margin_problem, margins
from tests.kinematics.srs_arms import each_branch, fk, problem_of, random_srs_arm

RESIDUAL = 1e-12
"""Largest entry of FK(q) - T."""
LWR = lwr_dyn.load("lwr4plus")


@given(st.integers(0, 10**6))
def test_best_arm_angle_is_the_best_of_all(seed):
    arm, rng = random_srs_arm(seed, (0.3, 2.0)), np.random.default_rng(seed)
    problem, *_ = problem_of(arm, rng.uniform(-3, 3, (3, 7)))
    best = best_angles(problem)
    psi = np.linspace(-np.pi, np.pi, 721)
    smallest = margins(problem, np.broadcast_to(psi, (24, 721))).min(axis=2).max(axis=1)
    assert (best.margin >= smallest - CERTAIN).all()
    assert intervals_at_level(problem, best.margin + 10 * CERTAIN).empty.all()
    assert not intervals_at_level(problem, best.margin - 10 * CERTAIN).empty.any()


@pytest.mark.slow
def test_1000_random_poses_inside_the_limits_are_all_solved():
    q = np.random.default_rng(7).uniform(LWR.lower, LWR.upper, (1000, 7))
    T, signs = each_branch(fk(LWR, q))
    geometry, ranges = srs_geometry(LWR.chain), joint_ranges(LWR)
    best = best_angles(margin_problem(geometry, ranges, T, signs))
    result = closed_form(geometry, ranges, T, best.psi, signs)
    assert np.abs(fk(LWR, result) - T).max() <= RESIDUAL
    inside = ((result >= LWR.lower) & (result <= LWR.upper)).all(axis=1).reshape(1000, 8)
    assert inside.any(axis=1).all()
