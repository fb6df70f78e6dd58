"""Corrections of one cell: the number of fewest decimals in a range."""

import math

from lwr_dyn.checks.conventions.cell_corrections import shortest_between


def test_a_range_narrower_than_sixteen_digits_gives_its_middle():
    third = 1.0 / 3.0
    assert shortest_between(third, third) == third
    above = math.nextafter(third, 1.0)
    assert third <= shortest_between(third, above) <= above


def test_the_number_lies_in_the_range_and_has_fewest_decimals():
    assert shortest_between(-0.02386, -0.02372) == -0.0238
    assert shortest_between(0.4, 1.6) == 1.0
    assert shortest_between(-3.2, -2.9) == -3.0
