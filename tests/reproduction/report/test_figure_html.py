"""Figures on a page: limits as lines or gauges, peaks said, logarithmic tip errors, names at the ends."""

import re
from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.pages.figures.figure import Axis, Curve, Figure, Level, Panel, axis_of
from lwr_dyn.pages.figures.run_figures import path_figure, tip_error_figure, torque_figure
from lwr_dyn.pages.plotting.drawn_panel import DrawnCurve, DrawnPanel
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.reproduction.report import figure_html as module
from lwr_dyn.reproduction.report.figure_html import HEIGHT, TOLERANCE, WIDTH, figure_html, line_path, simplified
from tests.pages.replay.replayed import lagging_run

X = np.linspace(0.0, 10.0, 2001)


def drawn(panel, **options):
    return figure_html(Figure("f", "F", "", "time", "s", (panel, panel), over_time=True, **options))


def points(path):
    return np.array(re.findall(r"(-?\d+),(-?\d+)", path), dtype=float)


TEN, ONE = Axis(0.0, 10.0, (0.0, 5.0, 10.0)), Axis(-1.0, 1.0, (-1.0, 0.0, 1.0))


def panel(*curves, inks=("r1", "r2", "ref"), y=TEN, levels=(), unit="N m", **more):
    """Curves over 0 to 10 with these inks, as they are drawn."""
    one = Panel("j", "torque", unit, curves, levels)
    drawn = tuple(DrawnCurve(c, c.x, c.y, ink, np.ptp(c.y)) for c, ink in zip(curves, inks, strict=False))
    shown = tuple(x for x in levels if x.label != "limit" and 0.0 <= x.value <= 10.0)
    return DrawnPanel(one, drawn, TEN, y, shown, tuple(x for x in levels if x not in shown), **more)


def line(label="a", high=4.0, **more):
    return Curve(label, np.array([0.0, high]), np.array([0.0, 10.0]), **more)


@pytest.mark.parametrize(
    ("peak", "limit", "bar", "words"),
    [
        (0.5, 100, "0.5", "below 1 %"), (4, 100, "4.0", "4 %"), (94.6, 100, "94.6", "95 %"),
        (99.6, 100, "99.6", "100 %"),
        (120, 100, "100.0", "120 %"), (3, 0, "0.0", "below 1 %"),
    ],
)  # fmt: skip
def test_a_limit_is_a_gauge_in_words(peak, limit, bar, words):
    html = module._gauge(panel(line(high=peak), levels=(Level("limit", -float(limit)),)))
    alarm = " alarm" if peak > limit > 0 else ""
    assert html == (
        f'<div class="gauge{alarm}"><u style="width:{bar}%"></u></div><p class="share">{words} of the limit</p>'
    )


def test_levels_beyond_the_axes_and_notes_are_words():
    far = (Level("printed", 12.0), Level("read", 0.00025))
    assert module._gauge(panel(line())) is None
    assert module._gauge(panel(line(), levels=far[:1])) == '<p class="share">printed: 12</p>'
    noted = replace(panel(line()), panel=Panel("j", "torque", "N m", (line(),), note="as read"), far=far)
    assert module._gauge(noted) == '<p class="share">as read; printed: 12; read: 0.00025</p>'


def test_levels_and_zero_stand_at_their_values():
    levels = (Level("low", 2.5), Level("high", 7.5), Level("at", 4.0, "x"))
    one = panel(line(), levels=levels)
    grid = '<path class="grid" d="M0,1000H2000M0,500H2000M0,0H2000"/>'
    lines = "".join(f'<path class="level" d="{d}"/>' for d in ("M0,750H2000", "M0,250H2000", "M800,0V1000"))
    assert module._levels(one) == grid + lines
    assert [module._level_name(one, level) for level in levels] == [
        '<span class="level-name above" style="top:75.0%">low</span>',
        '<span class="level-name below" style="top:25.0%">high</span>',
        '<span class="level-name across" style="left:40.0%">at</span>',
    ]
    assert module._levels(panel(line(), y=ONE)).endswith('<path class="zero" d="M0,500H2000"/>')
    for y in (Axis(0.0, 1.0, ()), Axis(-1.0, 0.0, ()), Axis(0.1, 1.0, (), True)):
        assert "zero" not in module._levels(panel(line(), y=y))
    assert module._levels(panel(line(), y=ONE, magnified=10)) == ""


def test_a_curve_is_a_line_points_or_both_and_may_be_filled():
    d, dots = "M0,1000 2000,600", "M0,1000h0M2000,600h0"
    for more, wanted in (
        ({}, f'<path class="l r1" data-c="0" d="{d}"/>'),
        ({"dashed": True}, f'<path class="l r1 dashed" data-c="0" d="{d}"/>'),
        ({"is_filled": True}, f'<path class="fill r1" d="{d}Z"/><path class="l r1" data-c="0" d="{d}"/>'),
        ({"style": "points"}, f'<path class="dots r1" d="{dots}"/>'),
        ({"style": "both"}, f'<path class="l r1" data-c="0" d="{d}"/><path class="dots r1" d="{dots}"/>'),
    ):
        one = panel(line(**more))
        assert module._curve_path(one, one.curves[0]) == wanted
    two = panel(line(), line("b", 8.0))
    assert 'class="l r2" data-c="1"' in module._curve_path(two, two.curves[1])


def test_names_stand_beside_points_and_at_ends_apart():
    text = Curve("m", np.array([5.0, 5.2, 5.0, 9.0]), np.array([2.0, 2.5, 4.1, 2.0]), "points", text=tuple("abcd"))
    names = re.findall(r'left:([\d.]+)%;top:([\d.]+)%">(\w)<', "".join(module._point_names(panel(text))))
    assert names == [("20.0", "50.0", "a"), ("25.0", "55.5", "b"), ("41.0", "50.0", "c"), ("20.0", "10.0", "d")]
    ends = module._end_names(panel(line("a", 5.0), line("b", 5.5), line("c", 1.0)))
    assert re.findall(r'class="end (\w+)" style="top:([\d.]+)%">(\w)<', ends) == [
        ("r2", "45.0", "b"), ("r1", "53.5", "a"), ("ref", "90.0", "c"),
    ]  # fmt: skip


def test_a_legend_names_each_line_once_and_none_that_is_alone_in_ink():
    two = panel(line(), line("b", dashed=True), line("wanted", dashed=True))
    assert re.findall(r'class="sw ([^"]+)"></i>(\w+)', module._legend([two, two])) == [
        ("r1", "a"), ("r2 dashed", "b"), ("ref", "wanted"),
    ]  # fmt: skip
    assert [module._legend([panel(line(), inks=(ink,))]) is None for ink in ("ink", "soft", "r1")] == [
        True, True, False,
    ]  # fmt: skip


def test_peaks_scales_and_descriptions_in_words():
    figure, one = Figure("f", "F", "", "time", "s", (), over_time=True), panel(line(), levels=(Level("limit", 50.0),))
    many = replace(figure, panels=(one.panel,) * 2)
    fact = module._fact
    assert fact(many, one, True) == "peak 4 of 50 N m"
    assert (fact(many, one, False), fact(many, panel(line()), True)) == ("peak 4 of 50", "peak 4 N m")
    for other in (
        replace(many, panels=many.panels[:1]),
        replace(many, over_time=False),
        replace(many, equal_aspect=True),
    ):
        assert fact(other, one, True) == ""
    bars = module._scale_bars(panel(line(), magnified=100))
    assert 'style="width:20.00%"' in bars
    assert "path 2000 mm, error 20 mm" in bars
    gap = Curve("b", np.array([np.nan, 3.0, -1.0]), np.arange(3.0))
    assert module._description(many, panel(line(), gap)) == (
        "j, torque: a from 0 to 4 N m; b from \u22121 to 3 N m"
    )  # fmt: skip
    assert module._description(replace(many, equal_aspect=True), panel(line(), line())) == "j, torque: a"


def test_a_figure_says_what_it_shows_and_how_many_panels_stand_in_a_row():
    def made(count, **more):
        one = Panel("j", "torque", "N m", (line(), line("b", 8.0)))
        return figure_html(Figure("f", "F", "Fig. 3", "time", "s", (one,) * count, **more))

    columns = {n: int(re.search(r"--n:(\d)", made(n, over_time=True))[1]) for n in (1, 2, 3, 5, 6, 8, 9, 11, 14)}
    assert columns == {1: 1, 2: 2, 3: 3, 5: 5, 6: 6, 8: 4, 9: 3, 11: 7, 14: 7}
    wide = Panel("j", "torque", "N m", (Curve("a", np.zeros(4), np.array([0.0, 2.0, 4.0, 6.0])),))
    shown = {n: figure_html(Figure("f", "F", "", "time", "s", (wide,) * n)) for n in (2, 3, 4)}
    ticks = {n: re.search(r'<div class="xt".*?</div>', html)[0] for n, html in shown.items()}
    assert ticks[2] == ticks[3] != ticks[4]  # every second one below more than three
    for count, more, about, kind in (
        (1, {"over_time": True, "note": "m^2"}, "torque, N m; m\u00b2", "times single"),
        (2, {}, "torque, N m; over time, s", "maps many"),
        (2, {"equal_aspect": True}, None, "paths many"),
    ):  # fmt: skip
        html = made(count, **more)
        found = re.search(r'<p class="about">(.*?)</p>', html)
        assert (found[1] if found else None) == about
        assert f'class="box chart {kind}" data-plot="f"' in html
        assert "F<small>Fig. 3</small>" in html
        assert ('class="ends"' in html) == (count == 1)
        assert ('class="names"' in html) == (count > 1)


def test_axes_follow_the_data_not_the_limits(arm, two_runs):
    runs = replayed_runs(two_runs, arm)
    text = figure_html(torque_figure(runs), runs)
    for j, (low, high) in enumerate(re.findall(r'data-y="(\S+) (\S+)"', text)):
        values = np.concatenate([one.run.tau_applied[:, j] for one in runs])
        assert float(low) < values.min() < values.max() < float(high)
        assert float(high) - float(low) < 1.2 * np.ptp(values)


def test_tip_errors_that_are_far_apart_are_logarithmic_and_named_at_their_ends(arm):
    for lag, logarithmic in ((0.0001, True), (0.01, False)):
        runs = replayed_runs([lagging_run(arm, 0.02, "slow"), lagging_run(arm, lag, "quick")], arm)
        text = figure_html(tip_error_figure(runs), runs)
        assert ("logarithmic" in text) == ("data-log" in text) == logarithmic
        assert re.findall(r'class="end r\d" style="top:[\d.-]+%">(\w+)<', text) != []


def test_the_unit_stands_in_the_heading_once_and_a_run_has_its_colour(arm, two_runs):
    runs = replayed_runs(two_runs, arm)
    text = figure_html(torque_figure(runs), runs)
    assert text.count("torque, N m") == 1
    for one in runs:
        assert text.count(f'class="l r{one.place + 1}"') == 7
    assert "reference" in figure_html(path_figure(runs), runs)


def test_a_curve_has_gaps_and_single_values_are_dots():
    y = np.where(np.abs(X - 5.0) < 1.0, np.nan, X)
    assert line_path(axis_of(X), axis_of(y), (X, y)).count("M") == 2
    y = np.array([1.0, np.nan, 5.0, np.nan, 2.0, 3.0])
    assert line_path(TEN, TEN, (np.arange(6.0), y)) == "M0,900h0M400,500h0M800,800 1000,700"


def test_a_path_is_as_near_to_its_curve_as_half_a_pixel():
    y = np.sin(5.0 * X) * np.exp(-0.2 * X) + (np.abs(X - 3.0) < 0.004)
    x_axis, y_axis = axis_of(X, padding=0.0), axis_of(y)
    path = points(line_path(x_axis, y_axis, (X, y)))
    at = np.column_stack([WIDTH * x_axis.share(X), HEIGHT * (1.0 - y_axis.share(y))])
    ends = np.linspace(0.0, 1.0, 20)[:, None, None]
    along = (path[:-1] + ends * np.diff(path, axis=0)).reshape(-1, 2)
    away = np.abs(np.sqrt(((at[::7, None] - along) ** 2).sum(axis=2)).min(axis=1))
    assert len(path) < 400
    assert away.max() < TOLERANCE + 12.0  # pieces are sampled 20 times
    assert path[:, 1].min() == pytest.approx(at[:, 1].min(), abs=1.0)  # the peak of one sample is not lost


def test_nothing_is_left_out_within_no_tolerance():
    rng = np.random.default_rng(1)
    cloud = rng.normal(size=(50, 2))
    np.testing.assert_array_equal(simplified(cloud, 0.0), cloud)


def test_hostile_texts_are_escaped():
    text = drawn(replace(Panel("<b>", "<i>", "<u>", (Curve("<s>", X, X),)), note="<em>"), note="<a>")
    assert not re.findall("<(b|i|u|s|em|a)>(?!</b>)", text.replace("<b>&lt;b&gt;", "").replace("<u ", ""))
