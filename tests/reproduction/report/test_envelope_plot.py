"""The envelope as a figure: both views, the points in it, the outline closed."""

import numpy as np
import pytest
from lwr_dyn.reproduction.report.envelope_plot import closed_outlines, envelope_figure

import lwr_dyn
from lwr_dyn.errors import OptionError, ShapeError
from lwr_dyn.kinematics.envelope import working_envelope
from lwr_dyn.viewer.plots import figure_bytes

POINT = {"point": (0.091, -1.139, 1.222)}


def test_side_and_top_show_the_outline_and_the_points():
    arm = lwr_dyn.load("kr30ha")
    figure = envelope_figure(arm, POINT)
    side, top = figure.axes
    spots = [line for line in side.lines if line.get_label() == "point"]
    assert spots[0].get_xydata()[0] == pytest.approx((np.hypot(0.091, 1.139), 1.222))
    spots = [line for line in top.lines if line.get_label() == "point"]
    assert spots[0].get_xydata()[0] == pytest.approx((0.091, -1.139))
    assert top.patches[0].radius == pytest.approx(working_envelope(arm).reach)
    arcs = [line for line in side.lines if len(line.get_xdata()) > 10]
    assert len(arcs) == len(working_envelope(arm).outline)
    assert figure_bytes(figure, "svg") == figure_bytes(envelope_figure(arm, POINT), "svg")


def test_the_polygon_has_the_volume():
    found = working_envelope(lwr_dyn.load("kr30ha"))
    (loop,) = closed_outlines(found)
    r, z = loop.T
    # pi r^2 dz along straight pieces: r^2 is a quadratic, Simpson is exact
    area = np.diff(z) * (r[:-1] ** 2 + r[:-1] * r[1:] + r[1:] ** 2) / 3
    assert np.pi * area.sum() == pytest.approx(found.volume, rel=1e-3)


def test_bad_input():
    with pytest.raises(ShapeError, match="far"):
        envelope_figure(lwr_dyn.load("kr30ha"), {"far": (1.0, 2.0)})
    with pytest.raises(OptionError):
        envelope_figure(lwr_dyn.load("lwr4plus"))
