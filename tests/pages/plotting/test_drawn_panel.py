"""A panel ready to draw: colours, magnified errors, levels, axes, and as a chart on a page."""

from types import SimpleNamespace

import numpy as np
import pytest

from lwr_dyn.pages.figures.figure import GREY, Curve, Figure, Level, Panel
from lwr_dyn.pages.plotting.drawn_panel import NEAR_LEVEL, chart_html, drawn_panels, is_near, run_ink, widest_first

T = np.array([0.0, 1.0, 2.0])


def figure_of(*panels, unit="s", over_time=True):
    return Figure("f", "A < B", "", "time", unit, panels, over_time)


def panel_of(*curves, levels=()):
    return Panel("joint", "torque", "N m", curves, levels)


@pytest.mark.parametrize(
    ("value", "near"),
    [(1.0, True), (4.0 * NEAR_LEVEL, True), (6.1, False), (0.0, True), (-2.0 * NEAR_LEVEL, True), (-3.1, False)],
)
def test_a_level_is_near_the_data_on_its_side(value, near):
    assert is_near(Level("limit", value), np.array([-2.0, np.nan, 4.0])) is near


def test_a_level_on_a_side_without_data():
    below, above = np.array([-4.0, -2.0]), np.array([2.0, 4.0])
    assert [is_near(Level("x", x), below) for x in (-1.0, 0.0, 1.0, -6.0, -6.1)] == [True, False, False, True, False]
    assert [is_near(Level("x", x), above) for x in (1.0, 0.0, -1.0)] == [True, True, False]


def test_colours_of_runs():
    assert [run_ink(SimpleNamespace(place=k)) for k in (0, 3, 4, 9)] == ["r1", "r4", "r5", "r5"]
    curves = (
        Curve("a", T, T), Curve("b", 2 * T, T), Curve("grey", 9 * T, T, colour=GREY), Curve("c", T, T, colour=1),
        Curve("d", T, T, colour=5), Curve("e", 3 * T, T, colour=1, is_filled=True),
    )  # fmt: skip
    (panel,) = drawn_panels(figure_of(panel_of(*curves)), [])
    assert [one.ink for one in panel.curves] == ["ink", "soft", "ref", "r2", "r5", "soft"]
    assert [one.swing for one in panel.curves] == [2.0, 4.0, 18.0, 2.0, 2.0, 6.0]
    assert [one.curve.label for one in widest_first(panel)] == ["grey", "e", "b", "a", "c", "d"]
    assert panel.peak == 6.0  # what is grey does not count


def test_levels_are_drawn_or_said_and_limits_are_known():
    levels = (Level("limit", -2.5), Level("limit", 90.0), Level("printed", 200.0), Level("here", 1.5, "x"))
    (panel,) = drawn_panels(figure_of(panel_of(Curve("a", -T, T), levels=levels)), [])
    assert panel.levels == (levels[0], levels[3])
    assert panel.far == levels[1:3]
    assert (panel.limit, panel.magnified) == (90.0, 1)
    assert panel.y.low <= -2.5 < 0.0 <= panel.y.high < 3.0


def test_panels_over_time_share_their_axis_and_frequencies_are_logarithmic():
    one, other = drawn_panels(figure_of(panel_of(Curve("a", T, T)), panel_of(Curve("a", T, 5 * T))), [])
    assert one.x == other.x
    assert (one.x.low, one.x.high) == (0.0, 10.0)
    apart_ = drawn_panels(figure_of(panel_of(Curve("a", T, 1 + T)), unit="Hz", over_time=False), [])[0]
    assert (apart_.x.is_logarithmic, apart_.y.is_logarithmic) == (True, False)


def test_a_chart_has_heading_lines_names_and_a_description():
    text = chart_html(figure_of(panel_of(Curve("one & all", T, T), Curve("two", -T, T))), [])
    assert text.startswith("<figure><figcaption><h3>A &lt; B <small>N m</small></h3></figcaption>")
    assert "A &lt; B: one &amp; all at most 2 N m; two at most 0 N m" in text
    assert text.count("<path class=") >= 2
    ends = text[text.index('<div class="ends">') :]
    assert ends.index("one &amp; all") < ends.index("two")  # the higher end stands above
    assert text.endswith(
        '<ul class="names"><li><i class="sw ink"></i>one &amp; all</li>'
        '<li><i class="sw soft"></i>two</li></ul></figure>'
    )
