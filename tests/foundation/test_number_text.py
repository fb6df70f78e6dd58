"""Numbers for people: what is written is the number to its digits, and nothing else."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.foundation.number_text import number_text, raised, short, written_out


@given(st.floats(-9e5, 9e5).filter(lambda x: x == 0.0 or abs(x) > 1e-8))
def test_six_digits_are_kept_without_an_exponent(x):
    assert "e" not in written_out(x)
    assert float(written_out(x)) == float(f"{x:.6g}")
    assert float(number_text(x)) == float(f"{x:.6g}")


@pytest.mark.parametrize(("x", "text"), [
    (-2.0, "\u22122"), (1e6, "10\u2076"), (3.2e-7, "3.2\u00b710\u207b\u2077"), (1e-4, "0.0001"),
    (9.99e-5, "9.99\u00b710\u207b\u2075"), (99900.0, "99900"), (1e5, "10\u2075"), (-1e5, "\u221210\u2075"),
])  # fmt: skip
def test_a_short_number_has_a_true_minus_and_a_power(x, text):
    assert short(x) == text


def test_zeros_are_written_out_from_a_billionth_to_a_billion():
    numbers = (1e-9, 9.99e-10, 999999.6, 1234567.0, 999999999.0, 1e9, -1e-9)
    texts = ["0.000000001", "9.99e-10", "1000000", "1234567", "999999999", "1e+09", "-0.000000001"]
    assert [written_out(x) for x in numbers] == texts


def test_an_exponent_of_more_than_one_digit_stays():
    assert raised("m^2 s^-10") == "m\u00b2 s\u207b\u00b90"
