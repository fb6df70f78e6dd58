"""A panel ready to draw: colours, magnified errors, levels, axes, and as a chart on a page."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from lwr_dyn.pages.figures.figure import GREY, Curve, Figure, Level, Panel, Series
from lwr_dyn.pages.plotting.drawn_panel import (
    NEAR_LEVEL,
    chart_html,
    drawn_panels,
    is_near,
    magnification,
    run_ink,
    widest_first,
)

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
    """Of two lines over 2 s, on an axis from -2.24 to 2.24 (6 % beyond the data): the whole text."""
    text = chart_html(figure_of(panel_of(Curve("one & all", T, T), Curve("two", -T, T))), [])
    across = "".join(f'<span style="left:{50 * t:.1f}%">{t}{" s" * (t == 2)}</span>' for t in (0.0, 0.5, 1.0, 1.5, 2.0))
    assert text == (
        "<figure><figcaption><h3>A &lt; B <small>N m</small></h3></figcaption>"
        '<div class="area"><div class="yt" aria-hidden="true"><span style="top:94.6%">\u22122</span>'
        '<span style="top:50.0%">0</span><span style="top:5.4%">2</span></div>'
        '<div class="plane" role="img" aria-label="A &lt; B: one &amp; all at most 2 N m; two at most 0 N m">'
        '<svg viewBox="0 0 2000 1000" preserveAspectRatio="none" aria-hidden="true">'
        '<path class="grid" d="M0,946H2000M0,500H2000M0,54H2000"/><path class="ink" d="M0,500 1000,277 2000,54"/>'
        '<path class="soft" d="M0,500 1000,723 2000,946"/></svg></div>'
        '<div class="ends"><span style="top:5.4%"><i class="sw ink"></i>one &amp; all</span>'
        '<span style="top:94.6%"><i class="sw soft"></i>two</span></div>'
        f'<div class="xt" aria-hidden="true">{across}</div></div>'
        '<ul class="names"><li><i class="sw ink"></i>one &amp; all</li>'
        '<li><i class="sw soft"></i>two</li></ul></figure>'
    )


def test_names_at_the_ends_of_a_chart_do_not_touch():
    curves = (Curve("a", T, T), Curve("b", T + 0.01, T), Curve("c", 0.1 * T, T))
    text = chart_html(figure_of(panel_of(*curves)), [])
    tops = {
        name: float(top) for top, name in re.findall(r'<span style="top:([\d.]+)%"><i class="sw \w+"></i>(\w)', text)
    }
    assert tops["a"] - tops["b"] == pytest.approx(9.0, abs=0.11)
    assert tops["b"] == pytest.approx(100 * 0.06 / 1.12, abs=0.11)
    assert tops["c"] > tops["a"] + 50


def path_of(error, far=1.0):
    """A figure of a square of 1 m, whose run is `error` [m] too far to the right, and its run."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, far], [0.0, far]])
    pose, pose_ref = np.zeros((2, 4, 4, 4))
    pose_ref[:, :2, 3] = square
    pose[:, :2, 3] = square + np.array([error, 0.0])
    curves = (
        Curve("reference", Series(0, "reference y"), Series(0, "reference x"), dashed=True, colour=GREY),
        Curve("run", Series(0, "flange y"), Series(0, "flange x")),
    )
    panel = Panel("", "y", "m", curves)
    figure = Figure("path", "Path", "", "x", "m", (panel,), equal_aspect=True)
    return figure, [SimpleNamespace(pose=pose, pose_ref=pose_ref, place=2, run=None)]


@pytest.mark.parametrize(
    ("error", "times"),
    [(1.4e-4, 1000), (1.6e-4, 100), (1.4e-3, 100), (1.6e-3, 10), (1.4e-2, 10), (1.6e-2, 1), (0.0, 1000)],
)
def test_errors_of_a_path_are_drawn_larger_up_to_15_percent_of_it(error, times):
    figure, runs = path_of(error)
    assert magnification(figure, runs) == times
    (panel,) = drawn_panels(figure, runs)
    assert [one.ink for one in panel.curves] == ["ref", "r3"]
    assert panel.curves[1].swing == pytest.approx(error)
    np.testing.assert_allclose(panel.curves[1].x, runs[0].pose_ref[:, 0, 3] + times * error, atol=1e-12)
    np.testing.assert_allclose(panel.curves[1].y, runs[0].pose_ref[:, 1, 3], atol=1e-12)
    assert magnification(replace(figure, equal_aspect=False), runs) == 1


def test_a_chart_of_a_path_says_its_scale_and_that_of_its_errors():
    """Drawn from -0.05 - 0.066 m on: the path is 1 m, the error of 1 mm drawn 100 times as large."""
    figure, runs = path_of(1e-3)
    text, whole = chart_html(figure, runs), 1.12 * 1.1
    assert text.startswith(
        '<figure class="path"><figcaption><h3>Path <small>errors \u00d7 100</small></h3></figcaption>'
        '<div class="plane" role="img" aria-label="Path, errors \u00d7 100: reference, run">'
    )
    bars = re.findall(r'<li><i style="width:([\d.]+)%"></i>(.*?)</li>', text)
    assert bars == [(f"{100 * 0.2 / whole:.2f}", "path 200 mm"), (f"{100 * 0.2 / whole:.2f}", "error 2 mm")]
    lines = dict(re.findall(r'<path class="(\w+)" d="M(.*?)"/>', text))
    places = [[tuple(map(int, x.split(","))) for x in lines[ink].split()] for ink in ("ref", "r3")]
    left, low, wide, tall = 0.066, 0.116, 1.232, 1.232
    for found, shift in zip(places, (0.0, 0.1), strict=True):
        expected = [((x + shift + left) / wide, (y + low) / tall) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
        np.testing.assert_allclose(found, [(2000 * x, 1000 * (1 - y)) for x, y in expected], atol=0.6)
    still = chart_html(*path_of(0.5))
    assert "<small>true to scale</small>" in still
    assert still.count("<li><i") == 1


@pytest.mark.parametrize(("peaks", "logarithmic"), [((1.0, 29.0), False), ((1.0, 31.0), True), ((0.0, 31.0), False)])
def test_tip_errors_far_apart_have_a_logarithmic_axis(peaks, logarithmic):
    runs = [SimpleNamespace(tip_error=peak * np.array([0.1, 1.0, 0.5]), place=k, arm=None,
                            run=SimpleNamespace(t=T)) for k, peak in enumerate(peaks)]  # fmt: skip
    curves = tuple(Curve(f"run {k}", Series(k, "tip error")) for k in range(2))
    (panel,) = drawn_panels(figure_of(panel_of(*curves)), runs)
    assert panel.y.is_logarithmic is logarithmic
    assert ("N m, logarithmic</small>" in chart_html(figure_of(panel_of(*curves)), runs)) is logarithmic
    assert [one.ink for one in panel.curves] == ["r1", "r2"]
    again = panel_of(curves[0], Curve("again", Series(0, "tip error")))
    assert [one.ink for one in drawn_panels(figure_of(again), runs)[0].curves] == ["r1", "soft"]
    assert not drawn_panels(figure_of(panel_of(curves[1])), runs)[0].y.is_logarithmic


@pytest.mark.parametrize(("size", "half"), [(0.9e-9, 0.1), (1.1e-9, 1.1e-7)])
def test_what_rounding_leaves_is_drawn_as_zero_below_a_billionth_of_its_limit(size, half):
    levels = (Level("limit", 100.0), Level("limit", -100.0))
    (panel,) = drawn_panels(figure_of(panel_of(Curve("a", 100.0 * size * (T - 1.0), T), levels=levels)), [])
    assert (panel.y.low, panel.y.high) == pytest.approx((-1.12 * half, 1.12 * half))


@pytest.mark.parametrize(("panels", "ticks"), [(1, 6), (3, 6), (4, 3)])
def test_many_panels_over_time_have_few_ticks(panels, ticks):
    drawn = drawn_panels(figure_of(*[panel_of(Curve("a", T, 5 * T))] * panels), [])
    assert [len(one.x.ticks) for one in drawn] == [ticks] * panels
