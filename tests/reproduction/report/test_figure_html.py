"""Figures on a page: limits as lines or gauges, peaks said, logarithmic tip errors, names at the ends."""

import re
from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.pages.figures.figure import Curve, Figure, Level, Panel, axis_of
from lwr_dyn.pages.figures.run_figures import path_figure, tip_error_figure, torque_figure
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.reproduction.report.figure_html import HEIGHT, TOLERANCE, WIDTH, figure_html, line_path, simplified
from tests.pages.replay.replayed import lagging_run

X = np.linspace(0.0, 10.0, 2001)


def drawn(panel, **options):
    return figure_html(Figure("f", "F", "", "time", "s", (panel, panel), over_time=True, **options))


def points(path):
    return np.array(re.findall(r"(-?\d+),(-?\d+)", path), dtype=float)


def test_a_limit_far_beyond_the_data_is_a_gauge_in_words_and_a_near_one_a_line():
    far = drawn(Panel("j", "torque", "N m", (Curve("a", 4.0 * np.sin(X), X),), (Level("limit", 100.0),)))
    assert "peak 4 of 100" in far
    assert 'class="gauge"><u style="width:4.0%">' in far
    assert "4 % of the limit" in far
    assert 'class="level"' not in far
    near = drawn(Panel("j", "torque", "N m", (Curve("a", 90.0 * np.sin(X), X),), (Level("limit", 100.0),)))
    assert near.count('class="level"') == 2
    assert "90 % of the limit" in near
    broken = drawn(Panel("j", "torque", "N m", (Curve("a", 120.0 * np.sin(X), X),), (Level("limit", 100.0),)))
    assert 'class="gauge alarm"><u style="width:100.0%">' in broken


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


def test_gaps_points_and_single_values_are_drawn():
    y = np.where(np.abs(X - 5.0) < 1.0, np.nan, X)
    x_axis, y_axis = axis_of(X), axis_of(y)
    assert line_path(x_axis, y_axis, (X, y)).count("M") == 2
    text = drawn(Panel("p", "y", "", (Curve("m", X[:3], X[:3], "points", text=("a", "b", "c")),)))
    assert text.count("h0") == 6
    assert text.count('class="point-name"') == 6


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
