"""Whether an arm has room beside floor, column and own links."""

import pytest

import lwr_dyn
from lwr_dyn.identification.excitation.motion_design import check_room, column_words, links_inside
from lwr_dyn.identification.excitation.motion_limits import clearance_of


def test_the_column_says_what_it_reaches_and_what_it_does_not_hold():
    arm = lwr_dyn.load("lwr4plus", "physical")
    assert column_words(clearance_of(arm, column=0.0)) == ""
    words = column_words(clearance_of(arm, column=0.3))
    assert words.startswith("column of radius 0.3 m up to joint_1 at 0 m, rounded above it; not held against it")
    drawn, wide = (links_inside(clearance_of(arm, column=x)) for x in (None, 0.3))
    assert set(drawn) < set(wide)
    assert set(wide) < set(links_inside(clearance_of(arm, column=5.0)))


@pytest.mark.parametrize("robot", ["lwr4plus", "wam7", "kr30ha"])
def test_arms_that_stand_as_drawn_have_room(robot):
    check_room(clearance_of(lwr_dyn.load(robot)))
