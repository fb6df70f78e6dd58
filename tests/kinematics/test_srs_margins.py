"""The best arm angle of a pose: better than every other on the circle, and inside the limits where one is."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.kinematics.arm_geometry import srs_geometry
from lwr_dyn.kinematics.solution import BRANCHES, joint_ranges, wrap
from lwr_dyn.kinematics.srs import arm_triangle, closed_form
from lwr_dyn.kinematics.srs_margins import CERTAIN, best_angles, intervals_at_level, margin_problem, margins
from lwr_dyn.model.arm import JointLimits
from lwr_dyn.model.chain import link_frames
from tests.kinematics.srs_arms import each_branch, fk, problem_of, random_srs_arm

ROUNDING = 1e-9
"""[rad] Margins by two routes; near an alignment a roll is worth fewer digits than 1e-15."""
ON_THE_LIMIT = 1e-7
"""[rad] At the end of an interval; where a joint only just touches its limit the crossing is a double root."""
LWR = lwr_dyn.load("lwr4plus")


def inside(intervals, psi):
    """Which psi (m,) lie in the intervals of each row."""
    start, end = (np.nan_to_num(side, nan=np.inf)[:, None] for side in (intervals.start, intervals.end))
    within = [(psi[:, None] + turn >= start) & (psi[:, None] + turn <= end) for turn in (0.0, 2 * np.pi)]
    return (within[0] | within[1]).any(axis=2)


@given(st.integers(0, 10**6))
def test_margins_are_those_of_the_closed_form(seed):
    arm, rng = random_srs_arm(seed), np.random.default_rng(seed)
    problem, geometry, ranges, T, signs = problem_of(arm, rng.uniform(arm.lower, arm.upper, (5, 7)))
    psi = rng.uniform(-np.pi, np.pi, len(T))
    q = closed_form(geometry, ranges, T, psi, signs)
    expected = ranges.half - np.abs(wrap(q - ranges.middle))
    assert np.abs(margins(problem, psi[:, None])[:, 0] - expected).max() < ROUNDING


@given(st.integers(0, 10**6), st.sampled_from([0.0, 0.3, -0.4]))
def test_intervals_hold_exactly_the_arm_angles_that_keep_the_margin(seed, level):
    arm, rng = random_srs_arm(seed), np.random.default_rng(seed)
    problem, *_ = problem_of(arm, rng.uniform(arm.lower, arm.upper, (5, 7)))
    psi = np.linspace(-np.pi, np.pi, 361)
    smallest = margins(problem, np.broadcast_to(psi, (40, 361))).min(axis=2)
    clear = np.abs(smallest - level) > ROUNDING
    result = inside(intervals_at_level(problem, np.full(40, level)), psi)
    assert (result == (smallest >= level))[clear].all()


def test_ends_of_intervals_lie_on_a_limit_or_where_rolls_jump():
    q = np.random.default_rng(5).uniform(LWR.lower, LWR.upper, (100, 7))
    problem, *_ = problem_of(LWR, q)
    intervals = intervals_at_level(problem, np.zeros(800))
    for row in range(800):
        for start, end in intervals.of(row):
            assert end >= start
            if end - start < 2 * np.pi:
                at = margins(problem.rows(np.array([row])), np.array([[start, end]]))[0].min(axis=1)
                assert np.abs(at).max() < ON_THE_LIMIT


@pytest.mark.slow
@pytest.mark.parametrize(("half", "middles"), [(0.2, (0, 0)), (0.8, (0, 0)), (1.3, (0, 0)), (0.8, (0.3, -0.7))])
def test_stretched_arm_has_the_intervals_of_its_shared_rolls(half, middles):
    """Arm straight along the axis of joint 1: psi turns rolls 1 and 3 together, each takes half."""
    first, third = (JointLimits(x - half, x + half) for x in middles)
    arm = replace(LWR, limits=(first, *LWR.limits[1:2], third, *LWR.limits[3:]))
    problem, geometry, ranges, T, signs = problem_of(arm, np.array([[0.1, 0, 0.05, 0, 0, 0.4, 0.3]]))
    psi = np.linspace(-np.pi, np.pi, 400)
    intervals = intervals_at_level(problem, np.zeros(8))
    kept = []
    for x in psi:
        q = closed_form(geometry, ranges, T, np.full(8, x), signs)
        kept.append((ranges.half - np.abs(wrap(q - ranges.middle))).min(axis=1) >= 0)
    assert (inside(intervals, psi) == np.array(kept).T).all()
    assert 0 < inside(intervals, psi).mean() < 1


@pytest.mark.parametrize("tilt", [0.0, np.pi])
def test_rolls_about_one_line_share_what_is_determined(tilt):
    """Joint 2 at 0: the sum of rolls 1 and 3; at half a turn: their difference."""
    limits = tuple(JointLimits(x - 3.1, x + 3.1) for x in (0.5, 0.2, -0.8, 0.0, 0.0, 0.0, 0.0))
    problem, geometry, ranges, T, signs = problem_of(
        replace(LWR, limits=limits), np.array([[0.9, tilt, 0.3, 0.0, 0.2, 0.6, 0.1]])
    )
    for psi in np.linspace(-3.0, 3.0, 7):
        q = closed_form(geometry, ranges, T, np.full(8, psi), signs)
        expected = ranges.half - np.abs(wrap(q - ranges.middle))
        assert np.abs(margins(problem, np.full((8, 1), psi))[:, 0] - expected).max() < ROUNDING


def test_an_interval_is_cut_where_a_ball_aligns():
    """Wrist such that the shoulder's tilt passes zero at one psi: roll 1 jumps by half a turn there."""
    free = replace(LWR, limits=(JointLimits(-3.1415, 3.1415),) * 7)
    q = np.array([[0.4, 0.0, 0.3, -1.1, 0.2, 0.6, 0.1]])
    problem, geometry, ranges, T, _ = problem_of(free, q)
    intervals = intervals_at_level(problem, np.zeros(8))
    ends = [e for b in range(8) for arc in intervals.of(b) for e in arc]
    elbow = np.array(list(link_frames(free.chain, q)))[2, 0, :3, 3]
    triangle = arm_triangle(geometry, T)
    at = np.arctan2(elbow @ np.cross(triangle.u[0], triangle.up[0]), elbow @ triangle.up[0])
    near = [abs((e - at + np.pi) % (2 * np.pi) - np.pi) for e in ends]
    assert min(near) < ON_THE_LIMIT
    jump = [closed_form(geometry, ranges, T[:1], np.array([at + d]), BRANCHES[0])[0, 0] for d in (-1e-4, 1e-4)]
    assert abs(wrap(np.array(jump[1] - jump[0]))) == pytest.approx(np.pi, abs=1e-3)


def test_unknown_limits_restrict_nothing_and_a_margin_one_picoradian_below_a_level_keeps_it():
    """The elbow's margin is the same at every arm angle: where it is the smallest, all of them or none keep a level."""
    free, q = (JointLimits(),) * 7, np.array([[0.4, 0.5, 0.3, -1.1, 0.2, 0.6, 0.1]])
    wide = replace(LWR, limits=(JointLimits(), JointLimits(-7.0, 7.0), JointLimits(lower=0.0), *free[3:]))
    assert intervals_at_level(problem_of(wide, q)[0], np.zeros(8)).of(0) == ((-np.pi, np.pi),)
    problem, *_ = problem_of(replace(LWR, limits=(*free[:3], JointLimits(-2.0, 2.0), *free[4:])), q)
    below = np.linspace(0.0, 3e-12, 13)
    kept = [not intervals_at_level(problem, problem.elbow_margin + x).empty.any() for x in below]
    assert kept == [bool(x < 1.1e-12) for x in below]


RESIDUAL = 1e-12
"""Largest entry of FK(q) - T."""


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
@pytest.mark.parametrize("name", ["lwr4plus", "wam7"])
def test_1000_random_poses_inside_the_limits_are_all_solved(name):
    arm = lwr_dyn.load(name)
    q = np.random.default_rng(7).uniform(arm.lower, arm.upper, (1000, 7))
    T, signs = each_branch(fk(arm, q))
    geometry, ranges = srs_geometry(arm.chain), joint_ranges(arm)
    best = best_angles(margin_problem(geometry, ranges, T, signs))
    result = closed_form(geometry, ranges, T, best.psi, signs)
    assert np.abs(fk(arm, result) - T).max() <= RESIDUAL
    inside = ((result >= arm.lower) & (result <= arm.upper)).all(axis=1).reshape(1000, 8)
    assert inside.any(axis=1).all()
