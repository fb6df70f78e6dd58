"""The pieces of a page that belong to one arm: those of another arm are kept where they differ, and nothing else is."""

import pytest

import lwr_dyn
from lwr_dyn.pages.explorer.arm_html import arm_pieces, changed_pieces, tables, template


def test_the_same_arm_changes_nothing(arm):
    assert changed_pieces(arm, "", arm, "") == {}
    assert changed_pieces(arm, "no torques", arm, "").keys() == {"arm-notes"}


def test_a_reading_changes_the_numbers_that_its_errata_change():
    arm, printed = (lwr_dyn.load("lwr4plus", reading) for reading in ("computed", "printed"))
    pieces, page = changed_pieces(printed, "", arm, ""), tables(arm)
    cells = [key for key in pieces if key.endswith("_c")]
    assert 0 < len(cells) < 12
    assert all(f"id={key}>" in page for key in cells)
    assert "sliders" not in pieces
    assert template(1, {"a": "<b>"}) == '<template id="arm-1"><div data-for="a"><b></div></template>'


@pytest.mark.parametrize("other", ["kr30ha", "wam7"])
def test_another_robot_changes_whole_tables_where_its_rows_are_others(arm, other):
    robot = lwr_dyn.load(other)
    pieces = changed_pieces(robot, "", arm, "")
    assert ("links" in pieces) == (other == "kr30ha")
    assert pieces["arm-title"] == arm_pieces(robot, "")["arm-title"]
    assert {"sliders", "arm-by"} <= pieces.keys()
