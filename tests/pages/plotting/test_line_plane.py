"""Lines, dots, bands and ticks stand where the axes say."""

import re

import numpy as np

from lwr_dyn.pages.figures.figure import Axis
from lwr_dyn.pages.plotting.line_plane import band_path, dots_path, grid_path, line_path, marks, plane_html, tick_marks

X, Y = Axis(0.0, 10.0, (0.0, 5.0, 10.0)), Axis(-1.0, 1.0, (-1.0, 0.0, 1.0))


def points(path):
    return [tuple(map(int, one)) for one in re.findall(r"(\d+),(\d+)", path)]


def test_a_line_keeps_its_ends_and_its_extremes():
    x = np.linspace(0.0, 10.0, 5001)
    y = 0.5 * np.sin(x)
    y[2345] = 0.9  # one row
    found = points(line_path(x, y, X, Y, "r1", points=50))
    assert found[0] == (0, 500)
    assert found[-1] == (2000, round(1000 * (1 - (y[-1] + 1) / 2)))
    assert (round(2000 * x[2345] / 10), 50) in found
    assert len(found) <= 2 * 50 + 2


def test_a_gap_begins_a_new_line():
    x, y = np.arange(6.0), np.array([0.0, 0.1, np.nan, 0.2, 0.3, np.nan])
    path = line_path(x, y, X, Y, "left")
    assert path.count("M") == 2
    assert [p[0] for p in points(path)] == [0, 200, 600, 800]
    assert line_path(x, np.full(6, np.nan), X, Y, "left") == ""


def test_a_gap_inside_a_thinned_stretch_is_kept():
    x, y = np.linspace(0.0, 10.0, 1000), np.zeros(1000)
    y[400:420] = np.nan
    assert line_path(x, y, X, Y, "left", points=10).count("M") == 2


def test_dots_bands_and_grid():
    dots = dots_path(np.array([5.0, 11.0, 2.0]), np.array([0.0, 0.0, 3.0]), X, Y, "dots")
    assert re.findall(r"M\d+,\d+h0", dots) == ["M1000,500h0"]
    assert dots_path(np.array([11.0]), np.array([0.0]), X, Y, "dots") == ""
    band = band_path(np.array([0.0, 10.0]), np.full(2, -0.5), np.full(2, 0.5), X, Y, "band")
    assert points(band) == [(0, 750), (2000, 750), (2000, 250), (0, 250)]
    assert grid_path(X, Y).count("M") == 6
    assert 'aria-label="a &lt;b&gt;"' in plane_html("a <b>", [])


def test_ticks_are_texts_at_their_places():
    assert marks([0.0, 0.25], ["<", "b"], "xt", "left") == (
        '<div class="xt" aria-hidden="true"><span style="left:0.0%">&lt;</span><span style="left:25.0%">b</span></div>'
    )
    assert '>before<span style="top:75.0%"' in marks([0.25], ["a"], "yt", "top", "before")
    made = tick_marks(Axis(0.0, 4.0, (0.0, 1.0, 2.0)), "xt", "left", "s")
    assert made.count("<span") == 3
    assert '<span style="left:50.0%">2 s</span></div>' in made
    assert 'left:25.0%">1</span>' in made
    assert tick_marks(Axis(0.0, 4.0, (0.0, 1.0, 2.0)), "xt", "left", "s", every=2).count("<span") == 2
