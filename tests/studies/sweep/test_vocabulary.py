"""Which side of a bound is bad, joints, and runs that diverged."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import UnknownNameError
from lwr_dyn.studies.sweep.vocabulary import metric_words


def test_the_worst_joint_counts_and_no_number_is_the_worst_of_all():
    torque = metric_words("peak_torque")
    assert torque.badness(np.array([[1.0, 3.0], [np.nan, 2.0]])).tolist() == [3.0, np.inf]
    margin = metric_words("limit_margin")
    assert margin.badness(np.array([[0.5, -0.1], [0.3, 0.4]])).tolist() == [0.1, -0.3]
    assert margin.shown(-0.3) == pytest.approx(300.0)


def test_bounds_of_either_side():
    tip = metric_words("tip_max")
    assert tip.is_within(np.array([1e-3, 2e-3, np.nan, np.inf]), 1e-3).tolist() == [True, False, False, False]
    violation = metric_words("first_violation")
    assert violation.is_within(np.array([np.inf, 3.0, 5.0, np.nan]), 4.0).tolist() == [True, False, True, False]
    assert violation.is_within(np.array([np.inf, 3.0]), np.inf).tolist() == [True, False]


def test_quantiles_over_time_belong_to_the_study():
    assert metric_words("tip_q95", (0.95,)).unit == "mm"
    with pytest.raises(UnknownNameError, match="tip_q95"):
        metric_words("tip_q9", (0.95,))
