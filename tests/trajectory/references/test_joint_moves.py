"""Joint moves: waypoints met at rest, exact derivatives, limits."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, PathLimitError, ShapeError
from lwr_dyn.trajectory.references.joint_moves import hold, point_to_point

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
