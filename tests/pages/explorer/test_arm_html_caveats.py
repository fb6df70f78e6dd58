"""The line of an arm's source in the explorer says what must be known before its numbers."""

import pytest

import lwr_dyn
from lwr_dyn.pages.explorer.arm_html import arm_pieces


@pytest.mark.parametrize(
    ("robot", "reading", "words"),
    [
        ("lwr4plus", "computed", "leaves rotor-inertia-power in place, a proven error</b>"),
        ("kr30ha", "kuka", "masses, centres of mass and inertias estimated from drawn solids"),
    ],
)
def test_it_stands_first_in_the_line_of_the_source(robot, reading, words):
    assert arm_pieces(lwr_dyn.load(robot, reading), "")["arm-by"].startswith(f'<b class="caveat">{words}')


def test_nothing_is_said_of_printed_numbers():
    assert "caveat" not in arm_pieces(lwr_dyn.load("wam7"), "")["arm-by"]
