"""Single faults that explain wrong cells."""

from lwr_dyn.checks.tables.formulas import corrections, exchanges, scale_or_sign
from lwr_dyn.model.printed_number import printed_number


def test_the_one_exchange_that_sorts_three_numbers():
    numbers = {i: printed_number(text) for i, text in enumerate(("3", "2", "1"))}
    assert exchanges(numbers, lambda new: all(n.value == i + 1 for i, n in new.items())) == [(0, 2)]


def test_a_power_of_ten_comes_before_a_sign_and_neither_is_none():
    assert scale_or_sign(25.0, [printed_number("2.5")]) == ("power-of-ten", "off by 1e1")
    assert scale_or_sign(-2.5, [printed_number("7"), printed_number("2.5")]) == ("sign", "the sign is the other one")
    assert scale_or_sign(2.6, [printed_number("2.5")]) is None
    assert scale_or_sign(2.56, [printed_number("-2.5")], slack=0.02) == ("sign", "the sign is the other one")


def test_corrections_of_a_number_are_scaled_signed_or_have_two_digits_exchanged():
    values = {value for value, _ in corrections(printed_number("1.23"))}
    assert values == {1.23e-3, 1.23e-2, 0.123, 12.3, 123.0, 1230.0, -1.23, 1.32}
    assert list(corrections(printed_number("0.0"))) == []
