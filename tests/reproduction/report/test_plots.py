"""PNG and SVG: curves, levels and names are drawn, always as the same bytes; Matplotlib is imported only then."""

import subprocess
import sys
from dataclasses import replace

import matplotlib
import numpy as np
import pytest

from lwr_dyn.errors import FileAccessError, OptionError
from lwr_dyn.reproduction.report.run_figures import error_figure, path_figure, torque_figure
from lwr_dyn.viewer.figures import PALETTE, Curve, Figure, Level, Panel, Series
from lwr_dyn.viewer.plots import draw, figure_bytes, save_figure
from lwr_dyn.viewer.replayed_runs import RUN_COLOURS, replayed_runs

X = np.linspace(-1.0, 1.0, 20)


@pytest.fixture(scope="module")
def runs(arm, two_runs):
    return replayed_runs(two_runs, arm, ["first", "second"])


def lines_of(drawing):
    return [line for axes in drawing.axes for line in axes.lines if not line.get_label().startswith("_")]


def names_of(drawing):
    return [text.get_text() for text in drawing.subfigs[0].legends[0].get_texts()]


def test_every_curve_of_a_figure_is_drawn_with_its_numbers_and_colour(runs):
    figure = torque_figure(runs)
    drawing = draw(figure, runs)
    for line, curve in zip(lines_of(drawing), figure.curves, strict=True):
        np.testing.assert_array_equal(line.get_xydata(), np.column_stack(curve.points(runs)))
        assert line.get_color() == RUN_COLOURS[curve.y.run]
    assert names_of(drawing) == ["first", "second"]
    assert [one.get_color() for one in lines_of(draw(error_figure(runs), runs))] == 2 * [*PALETTE[:7]]


def test_levels_titles_and_units(runs):
    first, *_, last, empty = draw(torque_figure(runs), runs).axes
    broken = sorted(line.get_ydata()[0] for line in first.lines if line.get_linestyle() == "--")
    assert broken == [-176.0, 176.0]
    assert first.get_title("left") == "joint_1 (limit 176 N m)"
    assert (first.get_ylabel(), first.get_xlabel(), last.get_xlabel()) == ("torque [N m]", "", "time [s]")
    assert not empty.get_visible()


def test_many_curves_are_named_at_the_side_and_a_note_stands_under_the_title(runs):
    drawing = draw(replace(error_figure(runs), note="assumed"), runs)
    assert names_of(drawing) == list(runs[0].arm.joint_names)
    assert drawing.subfigs[0].get_suptitle() == "Position errors of the joints\nassumed"
    assert drawing.subfigs[0].legends[0]._outside_loc


def test_numbers_points_gaps_fills_and_levels_across():
    curves = (
        Curve("law", np.where(X > 0.5, np.nan, X), X, dashed=True, is_filled=True),
        Curve("measured", X, X, "points", colour=5),
        Curve("places", X[:2], X[:2], "points", text=("a", "b")),
    )
    panel = Panel("p", "y", "m", curves, (Level("v", 0.5, "x"),))
    drawing = draw(Figure("f", "f", "", "x", "m", (panel,), equal_aspect=True))
    law, measured, *places = lines_of(drawing)
    assert (law.get_linestyle(), measured.get_marker(), measured.get_color()) == ("--", "o", PALETTE[5])
    assert [(one.get_label(), one.get_color()) for one in places] == [
        ("a, places", PALETTE[0]),
        ("b, places", PALETTE[1]),
    ]
    assert len(drawing.axes[0].patches) == 1
    assert [0.5, 0.5] in [list(line.get_xdata()) for line in drawing.axes[0].lines]


def test_figures_stand_side_by_side_each_with_its_title(runs):
    drawing = draw([path_figure(runs), torque_figure(runs)], runs)
    assert [part.get_suptitle() for part in drawing.subfigs] == ["Path of the flange", "Torques and their limits"]


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


def test_a_series_of_no_run_is_refused():
    panel = Panel("", "y", "", (Curve("c", Series(0, "q", 0)),))
    with pytest.raises(OptionError, match="no run is shown"):
        draw(Figure("f", "f", "", "t", "s", (panel,)))


def test_matplotlib_is_imported_only_to_draw_and_its_absence_names_the_extra():
    program = """
import sys
sys.modules["matplotlib"] = None
from lwr_dyn.errors import MissingPackageError
from lwr_dyn.reproduction.report import run_figures
from lwr_dyn.viewer import plots
try:
    plots.figure_bytes(run_figures.register_figure(0, 0), "png")
except MissingPackageError as fault:
    print(fault)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "matplotlib is not installed; install it with: pip install 'lwr_dyn[plots]'"
