"""A number as printed: its digits, half a unit of the last one, and what rounds to it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.model.printed_number import agrees, last_digit, power_of_ten, printed_number


@pytest.mark.parametrize(
    ("text", "value", "half"),
    [
        ("2.924", 2.924, 5e-4),
        ("7310", 7310.0, 0.5),
        ("1.325e-7", 1.325e-7, 5e-11),
        ("\N{MINUS SIGN}.5", -0.5, 0.05),
        ("\N{EN DASH}2", -2.0, 0.5),
        ("1" * 60, float("1" * 60), 0.5),
        ("1e300", 1e300, 5e299),
        ("1e-300", 1e-300, 5e-301),
    ],
)
def test_value_and_half_of_the_last_digit(text, value, half):
    number, scaled = printed_number(text), printed_number(text, 1e-3)
    assert (number.value, number.half, number.is_whole) == (value, half, "." not in text and "e" not in text)
    assert (scaled.value, scaled.half, scaled.text) == (value * 1e-3, half * 1e-3, number.text)


@pytest.mark.parametrize(
    "text",
    [
        "-",
        "",
        "n/a",
        "cos(q1)",
        "1_000",
        "nan",
        "inf",
        "1e301",
        "1e-301",
        "1e3000000",
        "1e9999999999999999999",
        "1" * 61,
    ],
)
def test_what_prints_no_number(text):
    assert printed_number(text) is None


@given(st.floats(-1e6, 1e6), st.integers(0, 8))
def test_a_value_agrees_with_itself_rounded_and_not_with_the_next_digit(value, digits):
    text = f"{value:.{digits}f}"
    assert agrees(text, value)
    assert printed_number(text).meets(value)
    assert not agrees(text, value + 1.01 * float(last_digit(text)))


def test_what_prints_no_number_has_no_last_digit_and_agrees_with_nothing():
    for function, text, *more in ((last_digit, "inf"), (last_digit, "1 2"), (agrees, "-", 1.0)):
        with pytest.raises(ValueError, match=f"^{text}$"):
            function(text, *more)


def test_a_finer_step_narrows_what_agrees_and_slack_widens_it():
    assert [agrees("0", 0.4), agrees("0", 0.4, "0.01"), agrees("0.25", 0.2549, "1")] == [True, False, True]
    assert [printed_number("2.0").meets(2.07, slack) for slack in (0.0, 0.019, 0.021)] == [False, False, True]
    halves = [0.5 * (1.0 + share) for share in (0.9e-9, 1.1e-9)]  # what is a half up to rounding
    assert [printed_number("2").meets(2.0 + half) for half in halves] == [True, False]
    assert [power_of_ten(20.0 + 10.0 * half, printed_number("2")) for half in halves] == [1, 0]


@pytest.mark.parametrize(
    ("value", "text", "options", "power"),
    [
        (1.325e-5, "1.325e-7", {}, 2), (1.0, "1000", {}, -3), (2.0, "1000", {}, 0), (0.0, "0", {}, 0),
        (5.0, "5", {}, 0),
        (-2.0, "-20", {}, -1), (1e9, "1", {}, 9), (1e10, "1", {}, 0), (1e10, "1", {"most": 10}, 10),
        (10.7, "1.0", {}, 0), (10.7, "1.0", {"slack": 0.25}, 1),
    ],
)  # fmt: skip
def test_powers_of_ten(value, text, options, power):
    assert power_of_ten(value, printed_number(text), **options) == power
