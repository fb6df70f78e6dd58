"""A figure's heading and panels as Matplotlib gets them: each line, tick, level, gauge and name at its place."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import to_hex

from lwr_dyn.pages.figures.figure import GREY, Axis, Curve, Figure, Level, Panel
from lwr_dyn.pages.plotting.drawn_panel import DrawnCurve, DrawnPanel
from lwr_dyn.pages.plotting.panels import (
    CAPTION,
    EDGE,
    LABELS,
    LETTER,
    LINE,
    NO_CAPTION,
    SQUARE,
    TICKS,
    TITLE,
    about_text,
    colour_of,
    draw_panel,
    layout_of,
    places_of,
)
from lwr_dyn.pages.plotting.plots import draw, drawing_class
from lwr_dyn.pages.replay.look import tokens
from tests.pages.plotting.test_drawn_panel import path_of

LOOK = tokens()
X = np.array([0.0, 1.0, 2.0, 4.0])


def figure_of(*curves, levels=(), title="", unit="N m", x_unit="m", note="", **more):
    panel = Panel(title, "pull", unit, curves, levels, note)
    return Figure("f", "A figure", "", "way", x_unit, (panel,), **more)


def axes_of(figure):
    (axes,) = draw(figure).axes
    return axes


def look_of(line):
    """Colour, width, dashes and mark of a line."""
    dashes = line.get_linestyle()
    return to_hex(line.get_color()), line.get_linewidth(), dashes, line.get_marker()


def test_an_axis_has_its_ends_its_ticks_with_the_unit_at_the_last_and_lines_at_zero():
    axes = axes_of(figure_of(Curve("a", np.array([-2000.0, 0.0, 12000.0, 3.0]), X)))
    assert axes.get_xlim() == pytest.approx((-0.24, 4.24))
    assert axes.get_ylim() == pytest.approx((-2840.0, 12840.0))
    assert [x.get_text() for x in axes.get_xticklabels()] == ["0", "2", "4 m"]
    assert [x.get_text() for x in axes.get_yticklabels()] == ["0", "5", "10"]
    assert axes.get_yticks().tolist() == [0.0, 5000.0, 10000.0]
    power, *_ = [x for x in axes.texts if x.get_text() == "\u00d7 1000"]
    assert (power.xy, power.get_ha(), power.get_va()) == ((0.0, 1.0), "right", "center")
    zeros = [line for line in axes.lines if to_hex(line.get_color()) == LOOK["zero"]]
    assert [line.get_zorder() for line in zeros] == [0.9, 0.9]
    assert [list(line.get_ydata()) for line in zeros] == [[0.0, 0.0], [0, 1]]
    assert [list(line.get_xdata()) for line in zeros] == [[0, 1], [0.0, 0.0]]
    assert [line.get_visible() for line in axes.yaxis.get_gridlines()] == [True] * 3
    assert not axes.xaxis.get_gridlines()[0].get_visible()
    for tick in (*axes.xaxis.get_major_ticks(), *axes.yaxis.get_major_ticks()):
        assert (tick.tick1line.get_markersize(), tick.label1.get_fontsize(), tick.get_pad()) == (0, 8.5, 4)


@pytest.mark.parametrize(
    ("y", "lines"),
    [([-1.0, 1.0, 0.5, 0.2], 1), ([1.0, 2.0, 3.0, 4.0], 0), ([-4.0, -3.0, -2.0, -1.0], 0), ([0.0, 1.0, 2.0, 3.0], 1)],
)
def test_zero_is_a_line_where_it_is_inside_the_axis(y, lines):
    """Over time the vertical one is not drawn."""
    axes = axes_of(figure_of(Curve("a", np.array(y), X + 1.0), x_unit="s", over_time=True))
    assert sum(to_hex(line.get_color()) == LOOK["zero"] for line in axes.lines) == lines


def test_frequencies_and_errors_far_apart_have_logarithmic_axes_without_a_zero():
    axes = axes_of(figure_of(Curve("a", X, 1.0 + X), x_unit="Hz"))
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "linear")
    axis, up = Axis(0.0, 4.0, (0.0, 4.0)), Axis(0.1, 100.0, (0.1, 1.0, 10.0, 100.0), True)
    one = Curve("a", 1.0 + X, X)
    panel = DrawnPanel(Panel("", "pull", "m", (one,)), (DrawnCurve(one, X, 1.0 + X, "ink", 5.0),), axis, up, (), ())
    laid = layout_of(figure_of(one), [])
    laid = type(laid)(**{name: getattr(laid, name) for name in laid.__slots__} | {"panels": (panel,)})
    assert about_text(laid.figure, [panel]) == "pull, m; over way, m; logarithmic"
    with drawing_class() as drawing:
        place = drawing()
        draw_panel(place, laid, 0)
        assert (place.axes[0].get_xscale(), place.axes[0].get_yscale()) == ("linear", "log")
        assert not [line for line in place.axes[0].lines if list(line.get_ydata()) == [0.0, 0.0]]


@pytest.mark.parametrize(
    ("more", "look"),
    [
        ({}, (LOOK["ink"], 1.3, "-", "None")),
        ({"dashed": True}, (LOOK["ink"], 1.3, "--", "None")),
        ({"style": "points"}, (LOOK["ink"], 1.3, "None", "o")),
        ({"style": "both", "colour": 2}, (LOOK["run3"], 1.3, "-", "o")),
        ({"colour": GREY}, (LOOK["ref"], 4.5, "-", "None")),
    ],
)
def test_a_curve_looks_as_it_is_described_and_keeps_its_numbers(more, look):
    axes = axes_of(figure_of(Curve("a", X, X, **more)))
    (line,) = [line for line in axes.lines if line.get_label() == "a"]
    assert (look_of(line), line.get_gid(), line.get_zorder()) == (look, "f-0-0", 2.0)
    np.testing.assert_array_equal(line.get_xydata(), np.column_stack([X, X]))


def test_what_swings_most_lies_below_and_a_fill_is_pale():
    curves = (Curve("a", X, X), Curve("b", 3 * X, X, is_filled=True), Curve("c", 2 * X, X))
    axes = axes_of(figure_of(*curves))
    assert {line.get_label(): line.get_zorder() for line in axes.lines if line.get_gid()} == {
        "a": 2.02, "b": 2.0, "c": 2.01,
    }  # fmt: skip
    (fill,) = axes.patches
    assert (fill.get_alpha(), fill.get_linewidth(), to_hex(fill.get_facecolor())) == (0.12, 0.0, LOOK["soft"])


def test_names_of_points_stand_below_where_another_point_is_just_above():
    y = np.array([0.0, 0.0, 10.0, 10.5])
    x = np.array([0.0, 5.0, 10.0, 10.0])
    axes = axes_of(figure_of(Curve("a", y, x, "points", text=("p", "q", "r", "s"))))
    found = {t.get_text(): (t.xy, t.xyann, t.get_va()) for t in axes.texts}
    assert found == {
        "p": ((0.0, 0.0), (5, 3), "bottom"), "q": ((5.0, 0.0), (5, 3), "bottom"),
        "r": ((10.0, 10.0), (5, -3), "top"), "s": ((10.0, 10.5), (5, 3), "bottom"),
    }  # fmt: skip


def test_levels_are_dashed_and_named_on_the_side_with_room():
    levels = (Level("low", 0.5), Level("high", 3.9), Level("here", 1.0, "x"))
    axes = axes_of(figure_of(Curve("a", X, X), levels=levels))
    dashed = [line for line in axes.lines if to_hex(line.get_color()) == LOOK["soft"]]
    assert [list(line.get_ydata()) for line in dashed] == [[0.5, 0.5], [3.9, 3.9], [0, 1]]
    assert list(dashed[2].get_xdata()) == [1.0, 1.0]
    assert {line.get_linewidth() for line in dashed} == {0.9}
    found = {t.get_text(): (t.xy, t.xycoords, t.xyann, t.get_va(), t.get_ha()) for t in axes.texts}
    right = ("axes fraction", "data")
    assert found == {
        "low": ((1.0, 0.5), right, (-3, 3), "bottom", "right"),
        "high": ((1.0, 3.9), right, (-3, -3), "top", "right"),
        "here": ((1.0, 1.0), right[::-1], (3, -3), "top", "left"),
    }  # fmt: skip


@pytest.mark.parametrize(
    ("levels", "note", "words", "shares", "colour"),
    [
        ((), "", "peak 4", [], "soft"),
        ((), "limit not known", "peak 4; limit not known", [], "soft"),
        ((Level("printed", 9.0),), "", "peak 4; printed 9", [], "soft"),
        ((Level("limit", 8.0), Level("limit", -8.0)), "limit 8 N m", "peak 4 of 8 N m", [1.0, 0.5], "soft"),
        ((Level("limit", 4.0),), "", "peak 4 of 4 N m", [1.0, 1.0], "soft"),
        ((Level("limit", 3.0),), "", "peak 4 of 3 N m", [1.0, 1.0], "alarm"),
    ],
)
def test_the_peak_stands_beside_its_limit_with_a_gauge(levels, note, words, shares, colour):
    axes = axes_of(figure_of(Curve("a", X, X), levels=levels, note=note, over_time=True, x_unit="s"))
    assert (axes.get_title("right"), to_hex(axes._right_title.get_color())) == (words, LOOK[colour])
    bars = [(p.get_xy(), p.get_width(), round(p.get_height(), 9), to_hex(p.get_facecolor())) for p in axes.patches]
    inks = [LOOK["grid"], LOOK[colour]]
    tall = round(0.04 / 2.6, 9)
    assert bars == [((0.0, 1.03), share, tall, ink) for share, ink in zip(shares, inks, strict=False)]


def test_what_is_not_over_time_or_follows_a_reference_has_no_peak():
    assert axes_of(figure_of(Curve("a", X, X))).get_title("right") == ""
    curves = (Curve("wanted", X, X, colour=GREY), Curve("a", X, X))
    assert axes_of(figure_of(*curves, over_time=True)).get_title("right") == ""
    assert axes_of(figure_of(Curve("a", X, X), Curve("b", X, X), over_time=True)).get_title("right") == ""
    two = Panel("one", "pull", "N m", (Curve("a", X, X),)), Panel("other", "push", "N", (Curve("a", X, X),))
    drawn = draw(Figure("f", "A figure", "", "time", "s", two, over_time=True)).axes
    assert [(x.get_title("left"), x.get_title("right")) for x in drawn] == [
        ("one", "peak 4 N m"),
        ("other", "peak 4 N"),
    ]


def test_the_lines_of_the_heading_are_below_each_other_and_names_beside():
    """Three names in a row, with a mark each; the points' mark is in the middle of the others'."""
    curves = (Curve("one", X, X), Curve("two", 2 * X, X, "points", colour=1), Curve("grey", X, X, colour=GREY))
    figure = replace(figure_of(*curves), note="assumed")
    laid, drawing = layout_of(figure, []), draw(figure)
    place, wide, tall = drawing.subfigs[0], laid.width, laid.height
    rows = [EDGE + 0.5 * TITLE, EDGE + TITLE + 0.5 * LINE, EDGE + TITLE + 1.5 * LINE]
    at = [EDGE, EDGE, *(EDGE + 0.34 + x for x in (0.0, 0.55 + 3 * LETTER, 1.1 + 6 * LETTER))]
    inks = [LOOK["ink"], LOOK["soft"], LOOK["ink"], LOOK["run2"], LOOK["ink"]]
    words = ["A figure", "pull, N m; over way, m; assumed", "one", "two", "grey"]
    for text, said, ink, x, row in zip(place.texts, words, inks, at, [0, 1, 2, 2, 2], strict=True):
        assert (text.get_text(), to_hex(text.get_color())) == (said, ink)
        assert text.get_position() == pytest.approx((x / wide, 1.0 - rows[row] / tall))
    marks = [line.get_xdata() for line in place.artists]
    begin = [EDGE, EDGE + 0.55 + 3 * LETTER, EDGE + 1.1 + 6 * LETTER]
    assert marks[0] == pytest.approx([(begin[0] + 0.02) / wide, (begin[0] + 0.26) / wide])
    assert marks[1] == pytest.approx([(begin[1] + 0.14) / wide])
    assert [look_of(line)[0] for line in place.artists] == [LOOK["ink"], LOOK["run2"], LOOK["ref"]]


@pytest.mark.parametrize(
    ("letters", "rows"), [(10, [[0, 1, 2, 3]]), (40, [[0, 1], [2, 3]]), (120, [[0], [1], [2], [3]])]
)
def test_names_go_on_in_another_row_where_one_is_full(letters, rows):
    curves = tuple(Curve(f"{k}" * letters, X, X) for k in range(4))
    named = layout_of(figure_of(*curves), []).names
    assert [[int(one.curve.label[0]) for one in row] for row in named] == rows


@pytest.mark.parametrize(
    ("figure", "names", "ends", "caption"),
    [
        (figure_of(Curve("a", X, X)), 0, False, CAPTION),  # a lone line in ink is named by the title
        (figure_of(Curve("a", X, X, colour=1)), 1, False, CAPTION),
        (figure_of(Curve("a", X, X, "points", text=tuple("abcd"))), 1, False, CAPTION),
        (figure_of(Curve("a", X, X), Curve("b", X, X)), 1, False, NO_CAPTION),
        (figure_of(Curve("a", X, X), Curve("b", X, X), over_time=True), 0, True, NO_CAPTION),
        (figure_of(Curve("a" * 36, X, X), Curve("b", X, X), over_time=True), 0, True, NO_CAPTION),
        (figure_of(Curve("a" * 37, X, X), Curve("b", X, X), over_time=True), 1, False, NO_CAPTION),
        (figure_of(Curve("a", X, X), over_time=True), 0, False, CAPTION),
        (figure_of(Curve("a", X, X), Curve("b", X, X), title="t"), 1, False, CAPTION),
        (figure_of(Curve("a", X, X), Curve("b", X, X), levels=(Level("limit", 1.0),)), 1, False, CAPTION),
        (figure_of(Curve("a", X, X), Curve("b", X, X), levels=(Level("far", 99.0),)), 1, False, CAPTION),
        (figure_of(Curve("a", X, X), equal_aspect=True), 0, False, NO_CAPTION),
    ],
)
def test_where_names_stand_and_what_room_a_caption_has(figure, names, ends, caption):
    laid = layout_of(figure, [])
    assert (len(laid.names), laid.has_ends, laid.caption) == (names, ends, caption)
    longest = max(len(curve.label) for curve in figure.curves)
    assert laid.right == pytest.approx(LETTER * longest + 0.1 if ends else 0.0)


def test_names_at_the_ends_are_apart_and_the_axes_leave_them_room():
    curves = (Curve("one", 0.5 * X, X), Curve("two", 0.5 * X + 0.01, X), Curve("three", X, X))
    figure = figure_of(*curves, over_time=True)
    laid, axes = layout_of(figure, []), axes_of(figure)
    texts = {t.get_text(): t.get_position() for t in axes.texts}
    share = (np.array([2.0, 2.01, 4.0]) - axes.get_ylim()[0]) / np.ptp(axes.get_ylim())
    assert texts["three"] == pytest.approx((1.012, share[2]))
    assert texts["two"][1] - texts["one"][1] == pytest.approx(0.075)
    assert texts["one"][1] == pytest.approx(share[0])
    left, _, wide, tall = laid.box(0)
    assert (left * 9.0, wide * 9.0) == pytest.approx((EDGE + LABELS, 9.0 - laid.right - 2 * EDGE - LABELS))
    assert tall * laid.height == pytest.approx(2.6)


def test_boxes_of_panels_follow_rows_and_columns():
    panels = tuple(Panel(name, "pull", "m", (Curve("a", X, X),)) for name in "abc")
    laid = layout_of(Figure("f", "A figure", "", "way", "m", panels, columns=2), [])
    cell, down = (9.0 - EDGE) / 2, CAPTION + 1.25 + TICKS
    for k, (row, column) in enumerate(((0, 0), (0, 1), (1, 0))):
        left, bottom, wide, tall = np.array(laid.box(k)) * [9.0, laid.height, 9.0, laid.height]
        assert (left, wide, tall) == pytest.approx((EDGE + column * cell + LABELS, cell - LABELS - EDGE, 1.25))
        assert laid.height - bottom - tall == pytest.approx(laid.header + row * down + CAPTION)


@pytest.mark.parametrize(
    ("titles", "columns", "places"),
    [
        ("abc", 2, [(0, 0), (0, 1), (1, 0)]),
        ("abab", 3, [(0, 0), (0, 1), (1, 0), (1, 1)]),
        (["", "", ""], 3, [(0, 0), (0, 1), (0, 2)]),
    ],
)
def test_a_row_begins_where_it_is_full_or_the_first_title_comes_again(titles, columns, places):
    assert places_of([SimpleNamespace(panel=SimpleNamespace(title=x)) for x in titles], columns) == places


def test_square_panels_have_one_scale_and_a_grid_both_ways():
    figure = figure_of(Curve("a", X, 10 * X), equal_aspect=True)
    axes, laid = axes_of(figure), layout_of(figure, [])
    assert np.ptp(axes.get_xlim()) == pytest.approx(np.ptp(axes.get_ylim())) == pytest.approx(40.0 * 1.12)
    assert np.mean(axes.get_ylim()) == pytest.approx(2.0)
    assert (laid.width, laid.panel_height) == pytest.approx((EDGE + SQUARE + LABELS + EDGE, SQUARE))
    assert axes.xaxis.get_gridlines()[0].get_visible()
    assert about_text(figure, laid.panels) == "pull over way, m"


def test_a_path_has_bars_for_its_lengths_and_for_those_of_its_errors():
    """A square of 1 m with errors of 1 mm, drawn 100 times as large: an axis of 1.22 m."""
    figure, runs = path_of(1e-3)
    (axes,) = draw(figure, runs).axes
    whole = np.ptp(axes.get_xlim())
    bars = [(p.get_xy(), p.get_width(), p.get_height(), to_hex(p.get_facecolor())) for p in axes.patches]
    assert bars == [
        ((0.0, -0.035), pytest.approx(0.2 / whole), 0.006, LOOK["soft"]),
        ((0.0, -0.035 - 0.04), pytest.approx(100 * 0.002 / whole), 0.006, LOOK["soft"]),
    ]
    texts = [(t.get_text(), t.get_position()) for t in axes.texts]
    assert texts == [
        ("path: 200 mm", pytest.approx((0.2 / whole + 0.02, -0.035))),
        ("errors: 2 mm", pytest.approx((0.2 / whole + 0.02, -0.035 - 0.04))),
    ]
    laid = layout_of(figure, runs)
    assert laid.height == pytest.approx(laid.header + NO_CAPTION + SQUARE + TICKS + LINE + EDGE / 2)
    assert about_text(figure, laid.panels) == "y over x, m; errors drawn 100 times as large"


def test_colours_of_runs_are_tokens():
    assert [colour_of(ink) for ink in ("r1", "r5", "ref", "soft")] == [LOOK[x] for x in ("run1", "run5", "ref", "soft")]
