"""Radau IIA 5: its order, stiff rates, work that the motion does not feel, steps that fail."""

import numpy as np
import pytest

from lwr_dyn.simulation.elastic.run import STAGES, TIMES, radau


def test_its_tableau_integrates_polynomials():
    for k in range(3):
        assert STAGES @ TIMES**k == pytest.approx(TIMES ** (k + 1) / (k + 1), rel=1e-13)
    assert [STAGES[2] @ TIMES**k for k in range(5)] == pytest.approx([1 / (k + 1) for k in range(5)], rel=1e-13)


def test_order_five_on_a_pendulum():
    def rates(t, y):
        return np.array([y[1], -np.sin(y[0])])

    ends = [radau(2, 2**k)(rates, 0.0, np.array([1.0, 0.0]), 2.0)[0] for k in range(2, 8)]
    errors = np.abs(np.array(ends[:3]) - ends[-1])
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(5.0, abs=0.3)


def test_stiff_motion_and_time():
    end = radau(1, 10)(lambda t, y: -1e7 * (y - np.cos(t)) - np.sin(t), 0.0, np.array([1.0]), 1.0)
    assert end[0] == pytest.approx(np.cos(1.0), abs=1e-9)


def test_work_is_summed_beside_the_motion():
    def rates(t, y):
        return np.array([y[1], -y[0], y[1] ** 2])

    for _ in range(2):  # the second time with slopes that are known
        end = radau(2, 16)(rates, 0.0, np.array([0.0, 1.0, 0.0]), 1.0)
        assert end[2] == pytest.approx(0.5 + np.sin(2.0) / 4, abs=1e-9)


@pytest.mark.parametrize("rates", [lambda t, y: y / 0.0, lambda t, y: 1e30 * y**2])
def test_a_step_that_fails_is_not_finite(rates):
    with np.errstate(all="ignore"):
        assert np.isnan(radau(1)(rates, 0.0, np.array([1.0]), 1.0)).all()


def test_what_rests_stays_to_the_last_bit():
    def rates(t, y):
        q, rest, dq, still = y
        return np.array([dq, still, -1e4 * (q - rest) - 10.0 * dq, 0.0])

    end = radau(4, 3)(rates, 0.0, np.array([1.0, 0.3, 0.0, 0.0]), 0.01)
    assert (end[1], end[3]) == (0.3, 0.0)
