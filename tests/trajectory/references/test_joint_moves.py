"""Joint moves: waypoints met at rest, exact derivatives, limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, PathLimitError, ShapeError
from lwr_dyn.trajectory.references.joint_moves import hold, lspb_move, point_to_point
from tests.examples import examples

ARM = lwr_dyn.load("lwr4plus")
STENCIL = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
STEP = 1e-2
DIFFERENCE = 1e-12
"""The stencil is exact for quintics; rounding 1e-16 / 1e-2 and two orders of cancellation."""


def move():
    points = [np.zeros(7), np.linspace(-1, 1, 7), np.full(7, 0.5)]
    return point_to_point(ARM, points, [2.0, 3.0]), points


def test_waypoints_are_met_at_rest_and_it_stands_still_outside():
    reference, (a, b, c) = move()
    assert reference.duration == 5.0
    motion = reference.sample(np.array([-1.0, 0.0, 2.0, 5.0, 9.0]))
    np.testing.assert_allclose(motion.q, [a, a, b, c, c], atol=1e-14)
    np.testing.assert_allclose(motion.dq, 0.0, atol=1e-14)
    np.testing.assert_allclose(motion.ddq, 0.0, atol=1e-13)


def test_dq_and_ddq_are_the_derivatives_of_q():
    reference, _ = move()
    t = np.concatenate([np.linspace(0.1, 1.9, 11), np.linspace(2.1, 4.9, 11)])
    here, around = reference.sample(t), reference.sample((t[:, None] + STEP * STENCIL).ravel())
    dq = np.einsum("ksj,s->kj", around.q.reshape(len(t), -1, 7), WEIGHTS) / STEP
    ddq = np.einsum("ksj,s->kj", around.dq.reshape(len(t), -1, 7), WEIGHTS) / STEP
    np.testing.assert_allclose(here.dq, dq, atol=DIFFERENCE)
    np.testing.assert_allclose(here.ddq, ddq, atol=DIFFERENCE)


def test_hold_stands_still():
    motion = hold(ARM, np.full(7, 0.3), 2.0).sample(np.linspace(-1, 3, 9))
    np.testing.assert_array_equal(motion.q, np.full((9, 7), 0.3))
    assert not motion.dq.any()
    assert not motion.ddq.any()


@pytest.mark.parametrize("side", [2.5, -2.5])
def test_a_waypoint_outside_the_limits_names_time_joint_and_excess(side):
    outside = np.array([0, 0, 0, side, 0, 0, 0.0])
    message = rf"at t = 2 s, waypoint 1: joint_4 at {side} rad, 0.406 rad outside"
    with pytest.raises(PathLimitError, match=message) as caught:
        point_to_point(ARM, [np.zeros(7), outside, np.zeros(7)], [2.0, 1.0])
    assert caught.value.joint == "joint_4"
    assert caught.value.excess == pytest.approx(2.5 - np.radians(120))


@pytest.mark.parametrize(
    ("make", "error", "says"),
    [
        (lambda: point_to_point(ARM, [np.zeros(7)], []), OptionError, "at least two rows"),
        (lambda: point_to_point(ARM, np.zeros((3, 7)), [1.0]), OptionError, "durations: 1 of them; allowed: 2"),
        (lambda: point_to_point(ARM, np.zeros((2, 7)), [0.0]), OptionError, "durations"),
        (lambda: point_to_point(ARM, np.zeros((2, 6)), [1.0]), ShapeError, "waypoints"),
        (lambda: hold(ARM, np.zeros((2, 7)), 1.0), OptionError, "q: shape"),
        (lambda: hold(ARM, np.full(7, np.nan), 1.0), ShapeError, "nan"),
        (lambda: hold(ARM, np.zeros(7), -1.0), OptionError, "durations"),
    ],
)
def test_what_is_no_move_is_refused(make, error, says):
    with pytest.raises(error, match=says):
        make()


LSPB_ARM = lwr_dyn.load("wam7")
START = np.array([0.0, -2.0, 0.0, 1.6, 0.0, 0.0, 0.0])
"""Of the paper's simulations."""


def moved(*joints, by=0.5):
    end = START.copy()
    end[[j - 1 for j in joints]] += by
    return end


@pytest.mark.parametrize("joint", range(1, 8))
def test_the_papers_single_runs(joint):
    move = lspb_move(LSPB_ARM, START, moved(joint), duration=7.0, blend=1.0)
    motion = move.sample(np.array([0.0, 0.5, 3.5, 6.5, 7.0]))
    assert move.duration == 7.0
    others = np.arange(7) != joint - 1
    np.testing.assert_array_equal(motion.q[:, others], np.broadcast_to(START[others], (5, 6)))
    assert not motion.dq[:, others].any()
    assert motion.q[[0, -1], joint - 1] == pytest.approx([START[joint - 1], START[joint - 1] + 0.5], abs=1e-15)
    assert motion.dq[2, joint - 1] == pytest.approx(0.5 / 6, rel=1e-14)
    assert motion.ddq[[1, 2, 3], joint - 1] == pytest.approx([0.5 / 6, 0.0, -0.5 / 6], rel=1e-14)


@given(st.integers(0, 10**6), st.floats(0.5, 20.0), st.floats(0.02, 0.5))
@examples(40)
def test_all_joints_start_and_stop_together_on_a_straight_line(seed, t_f, share):
    rng = np.random.default_rng(seed)
    start, end = rng.uniform(LSPB_ARM.lower, LSPB_ARM.upper, (2, 7))
    move = lspb_move(LSPB_ARM, start, end, duration=t_f, blend=share * t_f)
    motion = move.sample(np.linspace(0, t_f, 41))
    progress = (motion.q - start) / (end - start)
    assert np.ptp(progress, axis=1).max() < 1e-12 / np.abs(end - start).min()
    np.testing.assert_allclose(motion.q[-1], end, atol=1e-14)


def test_no_joint_moving_is_standing_still_for_the_time():
    move = lspb_move(LSPB_ARM, START, START, duration=3.0, blend=1.0)
    motion = move.sample(np.linspace(-1, 4, 9))
    assert move.duration == 3.0
    np.testing.assert_array_equal(motion.q, np.broadcast_to(START, (9, 7)))
    assert not np.any([motion.dq, motion.ddq])


def test_a_blend_that_does_not_fit_is_refused():
    with pytest.raises(OptionError, match=r"blend: 4 s; allowed: above 0, at most 3.5 s"):
        lspb_move(LSPB_ARM, START, moved(1), duration=7.0, blend=4.0)


def test_wrong_shapes_are_refused():
    with pytest.raises(ShapeError, match=r"start: 6 numbers; allowed: 7 numbers"):
        lspb_move(LSPB_ARM, START[:6], START, duration=7.0, blend=1.0)
    with pytest.raises(ShapeError, match="end: nan at index"):
        lspb_move(LSPB_ARM, START, START * np.nan, duration=7.0, blend=1.0)


def test_an_end_outside_the_limits_is_refused_with_its_time():
    with pytest.raises(PathLimitError, match=r"at t = 7 s, end: joint_2 at -2.5 rad, 0.5 rad outside its limits"):
        lspb_move(LSPB_ARM, START, moved(2, by=-0.5), duration=7.0, blend=1.0)
    with pytest.raises(PathLimitError, match="at t = 0 s, start: joint_4"):  # libbarrett's home
        lspb_move(LSPB_ARM, [0, -2, 0, 3.13, 0, 0, 0], START, duration=7.0, blend=1.0)
