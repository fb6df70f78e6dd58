"""PNG and SVG: curves, levels and names are drawn, always as the same bytes; Matplotlib is imported only then."""

import subprocess
import sys
import warnings
from dataclasses import replace

import matplotlib
import numpy as np
import pytest

from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.pages.figures.figure import Curve, Figure, Panel
from lwr_dyn.pages.figures.run_figures import error_figure, path_figure, torque_figure
from lwr_dyn.pages.plotting import panels
from lwr_dyn.pages.plotting.panels import CAPTION, EDGE, LABELS, LINE, NO_CAPTION, TICKS, TITLE
from lwr_dyn.pages.plotting.plots import draw, figure_bytes, save_figure
from lwr_dyn.pages.replay.look import tokens
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from tests.pages.replay.replayed import lagging_run

X = np.linspace(-1.0, 1.0, 20)


@pytest.fixture(scope="module")
def runs(arm, two_runs):
    return replayed_runs(two_runs, arm, ["first", "second"])


def lines_of(drawing):
    return [line for axes in drawing.axes for line in axes.lines if not line.get_label().startswith("_")]


def words_of(drawing):
    """Heading and names of the lines."""
    return [text.get_text() for text in drawing.subfigs[0].texts]


def test_captions_stand_where_matplotlib_would_put_them(runs, monkeypatch):
    figures = [torque_figure(runs, (0, 1)), path_figure(runs, (0,))]
    drawn = [figure_bytes(figure, "svg", runs) for figure in figures]
    monkeypatch.setattr(panels, "_CAPTION", {"pad": 9})
    assert [figure_bytes(figure, "svg", runs) for figure in figures] == drawn


def test_every_curve_of_a_figure_is_drawn_with_its_numbers_and_the_colour_of_its_run(runs):
    figure = torque_figure(runs)
    drawing = draw(figure, runs)
    for line, curve in zip(lines_of(drawing), figure.curves, strict=True):
        np.testing.assert_array_equal(line.get_xydata(), np.column_stack(curve.points(runs)))
        assert line.get_color() == runs[curve.y.run].colour
    assert words_of(drawing) == ["Torques and their limits", "torque, N m", "first", "second"]
    assert [text.get_color() for text in drawing.subfigs[0].texts[2:]] == [one.colour for one in runs]
    drawing = draw(replace(figure, where="Fig. 4", note="assumed"), runs)
    assert words_of(drawing)[1] == "Fig. 4; torque, N m; assumed"


def test_a_path_has_its_errors_magnified_and_says_so(arm):
    """The lines are the reference plus ten times the error, the widest first, over the reference as a pale band."""
    runs = replayed_runs([lagging_run(arm, lag, name) for lag, name in ((0.02, "pid"), (0.001, "pd-gravity"))], arm)
    figure = path_figure(runs)
    drawing = draw(figure, runs)
    assert words_of(drawing)[1].endswith("errors drawn 10 times as large")
    assert [text.get_text().split(":")[0] for text in drawing.axes[0].texts] == ["path", "errors"]
    band, *paths = lines_of(drawing)
    assert (band.get_color(), band.get_linewidth() > 3.0) == (tokens()["ref"], True)
    for line, one in zip(paths, runs, strict=True):
        wanted = [one.pose_ref[:, "xyz".index(axis), 3] for axis in (figure.x_label, figure.panels[0].y_label)]
        actual = [one.pose[:, "xyz".index(axis), 3] for axis in (figure.x_label, figure.panels[0].y_label)]
        expected = [ref + 10 * (at - ref) for ref, at in zip(wanted, actual, strict=True)]
        np.testing.assert_allclose(line.get_xydata(), np.column_stack(expected), atol=1e-12)
    assert runs[0].tip_error.max() > runs[1].tip_error.max()
    assert band.get_zorder() < paths[0].get_zorder() < paths[1].get_zorder()


def test_text_is_in_the_font_of_the_package_and_no_letter_is_missing(runs):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        svg = figure_bytes(
            replace(torque_figure(runs), note="\u03b8 \u2264 \u03c0, 10\u207b\u2076"), "svg", runs
        ).decode()
    assert "PlexSans" in svg


def test_figures_stand_side_by_side_each_with_its_title(runs):
    drawing = draw([path_figure(runs), torque_figure(runs)], runs)
    titles = [part.texts[0].get_text() for part in drawing.subfigs]
    assert titles == ["Path of the flange", "Torques and their limits"]


def one_of(panels, columns, curves):
    labels = "abcdefgh"[:curves]
    panel = Panel("", "y", "m", tuple(Curve(name, X, X) for name in labels))
    return Figure("f", "f", "", "x", "m", (panel,) * panels, columns=columns)


HEADING = EDGE + TITLE + LINE + 0.06 + EDGE / 2
"""Title and units, and the edges above and below."""


@pytest.mark.parametrize(
    ("figure", "inches"),
    [
        (one_of(1, 1, 1), (9.0, HEADING + CAPTION + 2.6 + TICKS)),
        (one_of(2, 1, 1), (9.0, HEADING + 2 * (CAPTION + 1.7 + TICKS))),
        (one_of(4, 1, 1), (9.0, HEADING + 4 * (CAPTION + 1.25 + TICKS))),
        (one_of(1, 1, 8), (9.0, HEADING + LINE + NO_CAPTION + 2.6 + TICKS)),
        (one_of(4, 2, 1), (9.0, HEADING + 2 * (CAPTION + 1.25 + TICKS))),
        (
            replace(one_of(3, 2, 1), equal_aspect=True),
            (EDGE + 2 * (5.2 + LABELS + EDGE), HEADING + 2 * (CAPTION + 5.2 + TICKS)),
        ),
    ],
)
def test_a_figure_is_as_large_as_its_panels_and_names_need(figure, inches):
    assert draw(figure).get_size_inches() == pytest.approx(inches)


@pytest.mark.slow
@pytest.mark.parametrize("make", [error_figure, torque_figure, path_figure], ids=lambda make: make.__name__)
def test_same_runs_give_the_same_bytes_whatever_the_settings(runs, make):
    def both():
        return tuple(figure_bytes(make(runs), kind, runs) for kind in ("png", "svg"))

    png, svg = both()
    with matplotlib.rc_context({"font.size": 20.0, "axes.facecolor": "pink", "lines.linewidth": 5.0}):
        assert both() == (png, svg)
    assert png.startswith(b"\x89PNG")
    assert b"<svg" in svg


def test_save_writes_both_kinds_and_leaves_the_settings(runs, tmp_path):
    before = dict(matplotlib.rcParams)
    written = save_figure(path_figure(runs), tmp_path / "path.png", runs)
    assert [path.name for path in written] == ["path.png", "path.svg"]
    assert all(path.stat().st_size > 1000 for path in written)
    assert dict(matplotlib.rcParams) == before
    with pytest.raises(FileAccessError):
        save_figure(path_figure(runs), tmp_path / "none" / "path", runs)
    with pytest.raises(OptionError, match="pdf"):
        figure_bytes(path_figure(runs), "pdf", runs)


@pytest.mark.slow
def test_matplotlib_is_imported_only_to_draw_and_its_absence_names_the_extra():
    program = """
import sys
sys.modules["matplotlib"] = None
from lwr_dyn.foundation.errors import MissingPackageError
from lwr_dyn.pages.figures import run_figures
from lwr_dyn.pages.plotting import plots
try:
    plots.figure_bytes(run_figures.register_figure(0, 0), "png")
except MissingPackageError as fault:
    print(fault)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "matplotlib is not installed; install it with: pip install 'lwr_dyn[plots]'"
