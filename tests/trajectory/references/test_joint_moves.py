"""Joint moves: waypoints met at rest, exact derivatives, limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, PathLimitError, ShapeError
from lwr_dyn.trajectory.references.joint_moves import hold, lspb_move, one_move, point_to_point
from tests.examples import examples
from tests.trajectory.differences import check_derivatives

ARM, WAM = lwr_dyn.load("lwr4plus"), lwr_dyn.load("wam7")
START = np.array([0.0, -2.0, 0.0, 1.6, 0.0, 0.0, 0.0])
"""Of the simulations in the paper of the WAM."""


def test_waypoints_are_met_at_rest_with_exact_derivatives_between_and_it_stands_still_outside():
    a, b, c = np.zeros(7), np.linspace(-1, 1, 7), np.full(7, 0.5)
    reference = point_to_point(ARM, [a, b, c], [2.0, 3.0])
    assert reference.duration == 5.0
    motion = reference.sample(np.array([-1.0, 0.0, 2.0, 5.0, 9.0]))
    np.testing.assert_allclose(motion.q, [a, a, b, c, c], atol=1e-14)
    np.testing.assert_allclose(motion.dq, 0.0, atol=1e-14)
    np.testing.assert_allclose(motion.ddq, 0.0, atol=1e-13)
    t = np.concatenate([np.linspace(0.1, 1.9, 11), np.linspace(2.1, 4.9, 11)])
    check_derivatives(reference.sample, t, 1e-2, ("q", "dq", "ddq"), atol=1e-12)
    single = one_move(ARM, start=a, end=b)
    assert (single.duration, single.waypoints.tolist()) == (2.0, [a.tolist(), b.tolist()])


@pytest.mark.parametrize(
    "still", [lambda: hold(ARM, START / 2, 2.0), lambda: lspb_move(WAM, START / 2, START / 2, duration=2.0, blend=1.0)]
)
def test_standing_still(still):
    motion = still().sample(np.linspace(-1, 3, 9))
    assert still().duration == 2.0
    np.testing.assert_array_equal(motion.q, np.tile(START / 2, (9, 1)))
    assert not np.any([motion.dq, motion.ddq])


@pytest.mark.parametrize("side", [2.5, -2.5])
def test_a_waypoint_outside_the_limits_names_time_joint_and_excess(side):
    outside = np.array([0, 0, 0, side, 0, 0, 0.0])
    message = rf"at t = 2 s, waypoint 1: joint_4 at {side} rad, 0.406 rad outside"
    with pytest.raises(PathLimitError, match=message) as caught:
        point_to_point(ARM, [np.zeros(7), outside, np.zeros(7)], [2.0, 1.0])
    assert (caught.value.t, caught.value.joint) == (2.0, "joint_4")
    assert caught.value.excess == pytest.approx(2.5 - np.radians(120))


def moved(*joints, by=0.5):
    end = START.copy()
    end[[j - 1 for j in joints]] += by
    return end


BAD = [
    (lambda: point_to_point(ARM, [np.zeros(7)], []), OptionError, r"waypoints: shape \(1, 7\); allowed: \(m, 7\) with"),
    (lambda: point_to_point(ARM, np.zeros(7), []), OptionError, r"waypoints: shape \(7,\); .* at least two rows"),
    (lambda: point_to_point(ARM, np.zeros((3, 7)), [1.0]), OptionError, "durations: 1 of them; allowed: 2, one per"),
    (lambda: point_to_point(ARM, np.zeros((2, 7)), [0.0]), OptionError, "durations: 0.0"),
    (lambda: point_to_point(ARM, np.zeros((2, 6)), [1.0]), ShapeError, "waypoints"),
    (lambda: one_move(ARM, start=np.zeros(6), end=np.zeros(7)), ShapeError, "start: 6 numbers"),
    (lambda: hold(ARM, np.zeros((2, 7)), 1.0), OptionError, r"q: shape \(2, 7\); allowed: \(7,\)"),
    (lambda: hold(ARM, np.full(7, np.nan), 1.0), ShapeError, "q: nan"),
    (lambda: hold(ARM, np.zeros(7), -1.0), OptionError, "durations: -1.0"),
    (lambda: lspb_move(WAM, START, moved(1), blend=4.0), OptionError, "blend: 4 s; allowed: above 0, at most 3.5 s"),
    (lambda: lspb_move(WAM, START[:6], START), ShapeError, "start: 6 numbers; allowed: 7 numbers"),
    (lambda: lspb_move(WAM, START, START * np.nan), ShapeError, "end: nan at index"),
    (lambda: lspb_move(WAM, START, moved(2, by=-0.5)), PathLimitError,
     "at t = 7 s, end: joint_2 at -2.5 rad, 0.5 rad outside its limits"),
    (lambda: lspb_move(WAM, [0, -2, 0, 3.13, 0, 0, 0], START), PathLimitError,  # libbarrett's home
     "at t = 0 s, start: joint_4"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "error", "says"), BAD, ids=[says for *_, says in BAD])
def test_what_is_no_move_is_refused(make, error, says):
    with pytest.raises(error, match=says):
        make()


@pytest.mark.parametrize("joint", range(1, 8))
def test_the_papers_single_runs(joint):
    motion, step = lspb_move(WAM, START, moved(joint)).sample(np.array([0.0, 0.5, 3.5, 6.5, 7.0])), np.eye(7)[joint - 1]
    pace = 0.5 / 6
    np.testing.assert_allclose(motion.q, START + np.outer([0, pace / 8, 0.25, 0.5 - pace / 8, 0.5], step), atol=1e-15)
    np.testing.assert_allclose(motion.dq, np.outer([0, pace / 2, pace, pace / 2, 0], step), atol=1e-15)
    np.testing.assert_allclose(motion.ddq, np.outer([pace, pace, 0, -pace, -pace], step), atol=1e-15)


@given(st.integers(0, 10**6), st.floats(0.5, 20.0), st.floats(0.02, 0.5))
@examples(40)
def test_all_joints_start_and_stop_together_on_a_straight_line(seed, t_f, share):
    rng = np.random.default_rng(seed)
    start, end = rng.uniform(WAM.lower, WAM.upper, (2, 7))
    motion = lspb_move(WAM, start, end, duration=t_f, blend=share * t_f).sample(np.linspace(0, t_f, 41))
    progress = (motion.q - start) / (end - start)
    assert np.ptp(progress, axis=1).max() < 1e-12 / np.abs(end - start).min()
    np.testing.assert_allclose(motion.q[-1], end, atol=1e-14)
