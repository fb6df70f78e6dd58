"""LSPB moves of an arm: synchronised, straight in joint space, exact rates, what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, PathLimitError, ShapeError
from lwr_dyn.trajectory.references.joint_moves import lspb_move
from tests.examples import examples

ARM = lwr_dyn.load("wam7")
START = np.array([0.0, -2.0, 0.0, 1.6, 0.0, 0.0, 0.0])
"""Of the paper's simulations."""


def moved(*joints, by=0.5):
    end = START.copy()
    end[[j - 1 for j in joints]] += by
    return end


@pytest.mark.parametrize("joint", range(1, 8))
def test_the_papers_single_runs(joint):
    move = lspb_move(ARM, START, moved(joint), duration=7.0, blend=1.0)
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
    start, end = rng.uniform(ARM.lower, ARM.upper, (2, 7))
    move = lspb_move(ARM, start, end, duration=t_f, blend=share * t_f)
    motion = move.sample(np.linspace(0, t_f, 41))
    progress = (motion.q - start) / (end - start)
    assert np.ptp(progress, axis=1).max() < 1e-12 / np.abs(end - start).min()
    np.testing.assert_allclose(motion.q[-1], end, atol=1e-14)


def test_no_joint_moving_is_standing_still_for_the_time():
    move = lspb_move(ARM, START, START, duration=3.0, blend=1.0)
    motion = move.sample(np.linspace(-1, 4, 9))
    assert move.duration == 3.0
    np.testing.assert_array_equal(motion.q, np.broadcast_to(START, (9, 7)))
    assert not np.any([motion.dq, motion.ddq])


def test_a_blend_that_does_not_fit_is_refused():
    with pytest.raises(OptionError, match=r"blend: 4 s; allowed: above 0, at most 3.5 s"):
        lspb_move(ARM, START, moved(1), duration=7.0, blend=4.0)


def test_wrong_shapes_are_refused():
    with pytest.raises(ShapeError, match=r"start: 6 numbers; allowed: 7 numbers"):
        lspb_move(ARM, START[:6], START, duration=7.0, blend=1.0)
    with pytest.raises(ShapeError, match="end: nan at index"):
        lspb_move(ARM, START, START * np.nan, duration=7.0, blend=1.0)


def test_an_end_outside_the_limits_is_refused_with_its_time():
    with pytest.raises(PathLimitError, match=r"at t = 7 s, end: joint_2 at -2.5 rad, 0.5 rad outside its limits"):
        lspb_move(ARM, START, moved(2, by=-0.5), duration=7.0, blend=1.0)
    with pytest.raises(PathLimitError, match="at t = 0 s, start: joint_4"):  # libbarrett's home
        lspb_move(ARM, [0, -2, 0, 3.13, 0, 0, 0], START, duration=7.0, blend=1.0)
