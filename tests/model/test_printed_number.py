"""A number as printed: its digits, half a unit of the last one, and what rounds to it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.model.printed_number import agrees, last_digit, power_of_ten, printed_number


@pytest.mark.parametrize(
    ("text", "value", "half"),
    [("2.924", 2.924, 5e-4), ("7310", 7310.0, 0.5), ("1.325e-7", 1.325e-7, 5e-11), ("\N{MINUS SIGN}.5", -0.5, 0.05)],
)
def test_value_and_half_of_the_last_digit(text, value, half):
    number = printed_number(text)
    assert (number.value, number.half) == (value, half)


def test_a_unit_scales_value_and_half():
    number = printed_number("12.5", 1e-3)
    assert (number.value, number.half, number.text) == (12.5e-3, 0.05e-3, "12.5")


@pytest.mark.parametrize(
    "text", ["-", "", "n/a", "cos(q1)", "1_000", "nan", "inf", "1e999", "1e3000000", "1e9999999999999999999", "1" * 61]
)
def test_what_prints_no_number(text):
    assert printed_number(text) is None


@given(st.floats(-1e6, 1e6), st.integers(0, 8))
def test_a_value_agrees_with_itself_rounded_and_not_with_the_next_digit(value, digits):
    text = f"{value:.{digits}f}"
    assert agrees(text, value)
    assert printed_number(text).meets(value)
    assert not agrees(text, value + 1.01 * float(last_digit(text)))


def test_a_finer_step_narrows_what_agrees():
    assert agrees("0", 0.4)
    assert not agrees("0", 0.4, "0.01")
    assert agrees("0.25", 0.2549, "1")


def test_powers_of_ten():
    assert power_of_ten(1.325e-5, printed_number("1.325e-7")) == 2
    assert power_of_ten(1.0, printed_number("1000")) == -3
    assert power_of_ten(2.0, printed_number("1000")) == 0
    assert power_of_ten(0.0, printed_number("0")) == 0
