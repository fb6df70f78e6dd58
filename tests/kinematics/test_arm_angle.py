"""Corridors of arm angles: intervals that overlap from pose to pose, unwrapped, or where they end."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, OutOfReachError, OutsideLimitsError, ShapeError
from lwr_dyn.kinematics import arm_angle
from lwr_dyn.kinematics.arm_angle import Corridor, CorridorBreak, best_arm_angle, connected_arm_angles, overlap
from lwr_dyn.kinematics.arm_geometry import srs_geometry
from lwr_dyn.kinematics.solution import BRANCHES, joint_ranges, wrap
from lwr_dyn.kinematics.srs import arm_triangle, closed_form, elbow_angle
from lwr_dyn.kinematics.srs_margins import AngleIntervals, best_angles, margin_problem, margins
from lwr_dyn.model.arm import JointLimits
from lwr_dyn.model.spatial import rot_z
from tests.kinematics.srs_arms import random_srs_arm

LWR = lwr_dyn.load("lwr4plus")
TOOL = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


def ist(count=1401, rotation=TOOL):
    """The paper's letters, written here once more: points of Table V, two semicircles of 0.075 m."""
    x, p = -0.05, []
    angle = np.linspace(0, np.pi, 200)
    p += [(-0.45, 0.55), (-0.45, 0.25), (-0.35, 0.25)]
    p += [(-0.35 + 0.075 * np.sin(a), 0.325 - 0.075 * np.cos(a)) for a in angle]
    p += [(-0.35 - 0.075 * np.sin(a), 0.475 - 0.075 * np.cos(a)) for a in angle[1:]]
    p += [(-0.2, 0.55), (-0.25, 0.55), (-0.25, 0.25)]
    p = np.array(p)
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    keep = np.concatenate([[True], np.diff(length) > 0])
    s = np.linspace(0, length[-1], count)
    T = np.tile(np.eye(4), (count, 1, 1))
    T[:, :3, :3] = rotation
    T[:, 0, 3] = x
    for column, values in ((1, p[:, 0]), (2, p[:, 1])):
        T[:, column, 3] = np.interp(s, length[keep], values[keep])
    return s, T


def spinning(seed, turn, count=201):
    """A flange that stays where it is and turns about its own axis."""
    q = np.random.default_rng(seed).uniform(LWR.lower, LWR.upper) * 0.6
    s = np.linspace(0, 1, count)
    T = np.tile(lwr_dyn.forward_kinematics(LWR, q), (count, 1, 1))
    T[:, :3, :3] = T[:, :3, :3] @ np.array([rot_z(x * turn) for x in s])
    return s, T


def kept(curve, s, T):
    q = closed_form(srs_geometry(LWR.chain), joint_ranges(LWR), T, curve.evaluate(s)[0], curve.branch)
    return q, np.minimum(q - LWR.lower, LWR.upper - q)


def test_ist_keeps_1_2_degrees_at_joint_6_at_its_first_point():
    s, T = ist()
    curve = best_arm_angle(LWR, s, T)
    assert np.degrees(curve.margin) == pytest.approx(1.2, abs=0.05)
    assert (curve.joint, curve.at) == (5, 0.0)
    assert curve.margin_bound - arm_angle.SLACK - arm_angle.RESOLUTION <= curve.margin <= curve.margin_bound
    q, room = kept(curve, s, T)
    assert room.min() == pytest.approx(curve.margin, abs=1e-12)
    assert np.abs(np.diff(q, axis=0)).max() < 0.02  # 1 mm of path between


@pytest.mark.parametrize(
    ("axis", "degrees"),
    [((1, 0, 0), 3.2), ((-1, 0, 0), 6.7), ((0, 0, -1), 12.6), ((0, -1, 0), 14.2), ((0, 0, 1), 14.2)],
)
def test_other_tool_directions_leave_the_limits_by_known_amounts(axis, degrees):
    z = np.array(axis, dtype=float)
    rotation = np.column_stack([np.roll(z, 1), np.cross(z, np.roll(z, 1)), z])
    s, T = ist(301, rotation)
    with pytest.raises(OutsideLimitsError, match=r"leaves the limits of lwr4plus at s = .* joint_[46]") as caught:
        best_arm_angle(LWR, s, T)
    assert np.degrees(caught.value.excess) == pytest.approx(degrees, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "turn"), [(3, 4.0), (5, 6.2)])
def test_no_path_over_a_grid_of_arm_angles_does_better(seed, turn):
    """Brute force: the widest path over a 1 deg grid on every branch, a step of 12 deg allowed between poses."""
    s, T = spinning(seed, turn)
    curve = best_arm_angle(LWR, s, T)
    grid = np.broadcast_to(np.radians(np.arange(360.0)), (len(T), 360))
    geometry, ranges, best = srs_geometry(LWR.chain), joint_ranges(LWR), -np.inf
    for branch in BRANCHES:
        margin = margins(margin_problem(geometry, ranges, T, branch), grid).min(axis=2)
        widest = margin[0]
        for row in margin[1:]:
            widest = np.minimum(row, np.max([np.roll(widest, i) for i in range(-12, 13)], axis=0))
        best = max(best, widest.max())
    assert curve.margin >= best - arm_angle.SLACK - arm_angle.RESOLUTION
    assert curve.margin <= best + np.radians(1.0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_the_curve_is_twice_differentiable_and_its_joints_do_not_jump(seed):
    s, T = spinning(seed, 3.0)
    curve = best_arm_angle(LWR, s, T)
    fine = np.linspace(0, 1, 20001)
    psi, slope, bend = curve.evaluate(fine)
    h = fine[1]
    assert np.abs(np.gradient(psi, h) - slope)[1:-1].max() < 1e-4 * (1 + np.abs(bend).max())
    assert np.abs(np.diff(bend)).max() < 0.02 * (1 + np.abs(bend).max())
    q, room = kept(curve, s, T)
    assert room.min() >= 0
    assert np.abs(np.diff(q, axis=0)).max() < 0.5
    assert np.abs(np.diff(kept(best_arm_angle(LWR, s, T), s, T)[0] - q, axis=0)).max() == 0.0


def test_out_of_reach_names_place_and_distance_and_a_turn_that_no_wrist_can_follow_its_joint():
    s, T = ist(101)
    T[60, 0, 3] = -3.0
    with pytest.raises(OutOfReachError, match=r"s = 0\.82") as caught:
        best_arm_angle(LWR, s, T)
    assert caught.value.at == s[60]
    w = T[60, :3, 3] - 0.078 * T[60, :3, 2]
    assert caught.value.distance == pytest.approx(np.linalg.norm(w) - 0.79)
    with pytest.raises(OutsideLimitsError, match=r"joint_7 is outside by .*without a jump") as caught:
        best_arm_angle(LWR, *spinning(0, 8.0, 41))
    assert 0 < caught.value.at < 1
    assert 0.0 < caught.value.excess < 0.2


def test_a_wrist_that_passes_the_axis_needs_another_reference():
    s = np.linspace(-0.2, 0.2, 81)
    T = np.tile(np.eye(4), (81, 1, 1))
    T[:, 0, 3], T[:, 2, 3] = s, 0.7
    with pytest.raises(OptionError, match="passes the line"):
        best_arm_angle(LWR, s, T)
    curve = best_arm_angle(LWR, s, T, reference=[0, 1, 0])
    assert curve.margin > 0.5
    assert curve.reference == pytest.approx([0, 1, 0])


def test_bad_paths_are_named():
    s, T = ist(11)
    for places, poses, error, words in (
        (s[::-1], T, ShapeError, "increasing"),
        (np.zeros(11), T, ShapeError, r"s: 0\.0 then 0\.0; allowed: increasing"),
        (s[:3], T, ShapeError, "k >= 2"),
        (s, 2 * T - np.diag([0, 0, 0, 1.0]), OptionError, "rotation"),
    ):
        with pytest.raises(error, match=words):
            best_arm_angle(LWR, places, poses)


@pytest.mark.slow
def test_a_tight_place_between_the_poses_of_the_first_look_is_found():
    s = np.arange(1401.0)
    q = np.tile([0.3, 0.7, 0.2, -1.0, 0.4, 0.9, 0.1], (1401, 1))
    q[:, 3] -= 1.05 * np.exp(-(((s - 10) / 3) ** 2))
    curve = best_arm_angle(LWR, s, lwr_dyn.forward_kinematics(LWR, q))
    assert (curve.at, curve.joint) == (10.0, 3)
    assert curve.margin == pytest.approx(np.radians(120) - 2.05)
    assert curve.margin_bound == pytest.approx(curve.margin)


def test_a_joint_at_its_limit_is_inside_and_any_s_r_s_arm_has_its_best_angle():
    T = lwr_dyn.forward_kinematics(LWR, np.tile([0.3, 0.7, 0.2, -1.0, 0.4, 0.9, 0.1], (2, 1)))
    geometry = srs_geometry(LWR.chain)
    triangle = arm_triangle(geometry, T)
    bend = min(float(abs(wrap(elbow_angle(geometry, triangle, np.full(2, x))))[0]) for x in (1.0, -1.0))
    tight = replace(LWR, limits=(*LWR.limits[:3], JointLimits(-bend, bend), *LWR.limits[4:]))
    assert best_arm_angle(tight, [0.0, 1.0], T).margin_bound == 0.0
    arm = random_srs_arm(11, (2.0, 3.0))
    ranges = joint_ranges(arm)
    q = ranges.middle + 0.3 * np.sin(np.linspace(0, 3, 101)[:, None] + np.arange(7))
    s, T = np.linspace(0, 3, 101), lwr_dyn.forward_kinematics(arm, q)
    curve = best_arm_angle(arm, s, T)
    assert curve.margin > 1.0
    problem = margin_problem(srs_geometry(arm.chain), ranges, T, curve.branch)
    least, start = best_angles(problem).margin, arm_angle.BranchOptimum(curve.branch, 9.0, 0, 0, None)
    optimum = arm_angle._best_of_branch(problem, start, least.min() - 1e-2)
    assert (optimum.margin_bound, optimum.index) == (pytest.approx(least.min(), abs=1e-8), least.argmin())
    assert arm_angle._best_of_branch(problem, start, least.min() + 1e-3) is None


def test_no_curve_in_the_corridor_bends_less():
    """The squared second derivative, integrated, and a weak pull to the middle: any change of the values adds to it."""
    x, rng = np.sort(np.random.default_rng(2).uniform(0.0, 1.0, 9)), np.random.default_rng(3)
    middle, half = np.cumsum(rng.normal(size=9)), np.full(9, 0.4)
    fine = np.linspace(x[0], x[-1], 20_001)

    def cost(values):
        bend = CubicSpline(x, values, bc_type="natural")(fine, 2)
        return np.trapezoid(bend**2, fine) + arm_angle.PULL * np.gradient(x) @ (values - middle) ** 2

    best = arm_angle._least_bending(x, middle, half)
    assert np.abs(best - middle).max() <= 0.4 + 1e-12
    for change in 1e-3 * rng.normal(size=(200, 9)):
        assert cost(np.clip(best + change, middle - half, middle + half)) >= cost(best) * (1 - 1e-9)


@pytest.mark.slow
def test_a_range_of_more_than_a_turn_counts_as_one_and_result_and_error_say_so():
    wide = replace(LWR, limits=(replace(LWR.limits[0], lower=-6.0, upper=6.0), *LWR.limits[1:]))
    assert best_arm_angle(LWR, *spinning(0, 3.0)).one_turn == ""
    assert "joint_1 counted as one turn" in best_arm_angle(wide, *spinning(0, 3.0)).one_turn
    with pytest.raises(OutsideLimitsError, match="joint_1 counted as one turn about the middle of the range"):
        best_arm_angle(wide, *spinning(0, 8.0))


def test_the_smooth_curve_is_the_middle_of_an_even_corridor_and_stays_inside_one_that_winds():
    s = np.linspace(0.0, 2.0, 101)
    for middle in (0.3, -2.0):
        at, values = arm_angle._smooth(s, Corridor(np.full(101, middle - 0.2), np.full(101, middle + 0.2)))
        assert np.ptp(values) < 1e-6
        assert np.abs(values - middle).max() < 0.2
        assert at[[0, -1]].tolist() == [0.0, 2.0]
    s = np.linspace(0, 2, 1401)
    middle = np.sin(60 * s)
    knots, values = arm_angle._smooth(s, Corridor(middle - 0.01, middle + 0.01))
    psi = CubicSpline(knots, values, bc_type="natural")(s)
    assert np.abs(psi - middle).max() <= 0.01
    assert len(knots) > arm_angle.FIRST_KNOTS


def test_corridors_across_the_seam_are_unwrapped_and_a_chain_that_ends_is_found():
    nan = np.nan
    seam = AngleIntervals(np.array([[3.0], [-3.2], [-3.1]]), np.array([[3.3], [-2.8], [-2.5]]))
    result = connected_arm_angles(seam)
    assert isinstance(result, Corridor)
    assert result.low == pytest.approx([3.0, 2 * np.pi - 3.2, 2 * np.pi - 3.1])
    assert result.high == pytest.approx([3.3, 2 * np.pi - 2.8, 2 * np.pi - 2.5])
    # the one that is wide until it is narrow in the last row loses to an even one
    narrowing = AngleIntervals(np.array([[-3.0, 2.0]] * 3), np.array([[0.0, 3.0], [0.0, 3.0], [-2.9, 3.0]]))
    assert connected_arm_angles(narrowing).low == pytest.approx([2.0, 2.0, 2.0])
    ending = np.array([[0.0, 2.0], [0.1, nan], [2.0, nan]]), np.array([[1.0, 3.0], [0.9, nan], [3.0, nan]])
    assert connected_arm_angles(AngleIntervals(*ending)) == CorridorBreak(2)
    assert connected_arm_angles(AngleIntervals(np.array([[nan]]), np.array([[nan]]))) == CorridorBreak(0)
    assert overlap((0.0, 1.0), (2.0, 3.0))[0] == pytest.approx(-1.0)
    assert overlap((-np.pi, np.pi), (3.0, 3.5))[0] == pytest.approx(0.5)


@pytest.mark.parametrize("middle", [-3.0, -0.2, 0.2, 3.0])
def test_beside_a_whole_circle_an_interval_stays_where_it_is(middle):
    whole, narrow = (-np.pi, np.pi), (middle - 0.1, middle + 0.1)
    for a, b in ((whole, narrow), (narrow, whole)):
        width, turn = overlap(a, b)
        assert (width, turn) == (pytest.approx(0.2), 0.0)
    rows = AngleIntervals(*(np.array([narrow, whole, narrow])[:, [k]] for k in (0, 1)))
    found = connected_arm_angles(rows)  # a whole circle is cut opposite to the row before
    around = (middle - np.pi, middle + np.pi)
    assert pytest.approx(np.array([narrow, around, narrow])) == np.array([found.low, found.high]).T
