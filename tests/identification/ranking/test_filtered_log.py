"""The one filter: derivatives of a known motion, edges, bad input."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.ranking.filtered_log import EDGE, FilterRule, filtered_log, trained_and_tested


def log(t, noise=0.0):
    q = np.sin(3.0 * t)[:, None]
    return JointLog("sine", (1,), t, q + noise * np.random.default_rng(0).normal(size=q.shape), 2.0 * q)


def test_a_slow_motion_passes_with_its_derivatives():
    found = filtered_log(log(np.arange(0.0, 5.0, 0.002)), FilterRule())
    np.testing.assert_allclose(found.q[:, 0], np.sin(3 * found.t), atol=1e-4)
    np.testing.assert_allclose(found.dq[:, 0], 3 * np.cos(3 * found.t), atol=1e-3)
    np.testing.assert_allclose(found.ddq[:, 0], -9 * np.sin(3 * found.t), atol=5e-3)
    np.testing.assert_allclose(found.tau, 2 * found.q, atol=1e-12)
    np.testing.assert_allclose(np.diff(found.t), 0.01)
    assert found.t[0] == EDGE


def test_noise_beyond_the_cutoff_is_taken_away():
    t = np.arange(0.0, 5.0, 0.001)
    rough = [np.std(np.diff(filtered_log(log(t, 1e-3), FilterRule(f)).ddq[:, 0], 2)) for f in (5.0, 40.0)]
    assert rough[0] < 0.05 * rough[1]


def test_rounded_times_are_an_even_clock():
    t = np.arange(150) / 30.0
    exact, rounded = (filtered_log(log(x), FilterRule(5.0)) for x in (t, t.round(4)))
    assert len(rounded) == len(exact)
    np.testing.assert_allclose(rounded.q, filtered_log(log(t), FilterRule(5.0)).q, atol=2e-4)


def test_a_gap_splits_a_log():
    t = np.concatenate([np.arange(0.0, 3.0, 0.01), np.arange(5.0, 8.0, 0.01)])
    found = filtered_log(log(t), FilterRule())
    np.testing.assert_allclose(found.ddq[:, 0], -9 * np.sin(3 * found.t), atol=5e-2)
    assert not ((found.t > 2.5) & (found.t < 5.5 - 1e-9)).any()


def test_the_first_rows_train_and_the_others_test():
    whole = filtered_log(log(np.arange(0.0, 5.0, 0.01)), FilterRule())
    train, test = trained_and_tested(whole, 0.6)
    assert len(train) == int(0.6 * len(whole))
    assert train.t[-1] < test.t[0]
    assert len(train) + len(test) == len(whole)


def test_too_short_a_log_and_numbers_that_cannot_be_are_refused():
    with pytest.raises(LogError, match="a recording with"):
        filtered_log(log(np.arange(0.0, 1.2, 0.01)), FilterRule())
    t = np.arange(0.0, 5.0, 0.01)
    with pytest.raises(LogError, match="finite"):
        filtered_log(JointLog("x", (1,), t, np.zeros((t.size, 1)), np.full((t.size, 1), np.nan)), FilterRule())
    for bad in ({"cutoff": 0.0}, {"spacing": -1.0}, {"share": 1.0}):
        with pytest.raises(OptionError):
            FilterRule(**bad)
