"""Gains of a second-order loop."""

import pytest

from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.foundation.errors import OptionError


def test_gains_are_the_second_order_formulas_and_refuse_what_is_not_positive():
    gains = second_order_gains([2.0, 0.5], omega_n=10.0, xi=0.7)
    assert gains.Kp == pytest.approx([200.0, 50.0])
    assert gains.Kd == pytest.approx([28.0, 7.0])
    for bad in ({"omega_n": 0.0}, {"xi": -1.0}, {"omega_n": float("nan")}):
        with pytest.raises(OptionError, match="allowed: a number above 0"):
            second_order_gains([1.0], **bad)
    with pytest.raises(OptionError):
        second_order_gains([1.0, 0.0])
