"""The filtered difference: right on a ramp, 3 dB down at its cut-off, quieter than the bare difference."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.simulation.plant import FilteredDifference

RATE = 1000.0


def answers(signal, cutoff_hz=50.0, **start):
    estimate = FilteredDifference(cutoff_hz, RATE)
    estimate.start(signal[:1], **start)
    return np.array([estimate(np.array([x]))[0] for x in signal[1:]])


def test_a_ramp_is_followed_exactly_in_the_end():
    t = np.arange(400) / RATE
    assert answers(3.0 * t)[-1] == pytest.approx(3.0, rel=1e-12)


def test_a_step_in_speed_rises_like_a_first_order_lag():
    t = np.arange(200) / RATE
    expected = 1 - np.exp(-2 * np.pi * 50.0 * t[1:])
    np.testing.assert_allclose(answers(t), expected, atol=1e-12)


def test_it_may_start_at_speed():
    t = np.arange(50) / RATE
    np.testing.assert_allclose(answers(2.0 * t, dq=[2.0]), 2.0, rtol=1e-12)


def test_the_cut_off_is_three_decibels_down():
    cutoff = 20.0
    t = np.arange(4000) / RATE
    w = 2 * np.pi * cutoff
    out = answers(np.sin(w * t) / w, cutoff)[2000:]
    assert np.sqrt(2) * out.std() == pytest.approx(1 / np.sqrt(2), rel=0.005)


def test_one_count_makes_one_minus_pole_of_its_bare_speed():
    estimate = FilteredDifference(50.0, RATE)
    out = answers(np.array([0.0, 1e-3, 1e-3]))
    assert out[0] == pytest.approx(1 - estimate.pole, rel=1e-12)
    assert out[1] == pytest.approx((1 - estimate.pole) * estimate.pole, rel=1e-12)


@pytest.mark.parametrize("cutoff", [0.0, -1.0, 500.0, np.nan])
def test_cut_off_must_lie_below_half_the_rate(cutoff):
    with pytest.raises(OptionError, match="cut-off"):
        FilteredDifference(cutoff, RATE)


@pytest.mark.parametrize("rate", [0.0, -1.0, np.inf])
def test_rate_must_be_positive(rate):
    with pytest.raises(OptionError, match="rate"):
        FilteredDifference(10.0, rate)


def test_a_start_of_another_length():
    with pytest.raises(ShapeError):
        FilteredDifference(10.0, RATE).start([0.0, 1.0], [0.0])
