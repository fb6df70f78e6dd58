"""The working envelope as a figure: both views, the points in it, the outline closed."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.checks.datasheet.envelope import working_envelope
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.pages.plotting.plots import draw, figure_bytes
from lwr_dyn.reproduction.kr30ha.study import closed_outlines, envelope_figures

POINTS = {"near": (0.091, -1.139, 1.222), "far": (1.0, 0.5, 1.5)}


@pytest.mark.slow
def test_side_and_top_show_the_outline_and_the_points():
    arm = lwr_dyn.load("kr30ha")
    views = envelope_figures(arm, POINTS)
    envelope = working_envelope(arm)
    (side,), (top,) = (view.panels for view in views)
    assert len(side.curves[:-1]) == len(closed_outlines(envelope))
    np.testing.assert_allclose(np.hypot(top.curves[0].x, top.curves[0].y), envelope.reach)
    assert side.curves[-1].text == top.curves[-1].text == tuple(POINTS)
    assert (side.curves[-1].x[0], side.curves[-1].y[0]) == pytest.approx((np.hypot(0.091, 1.139), 1.222))
    assert (top.curves[-1].x[0], top.curves[-1].y[0]) == pytest.approx((0.091, -1.139))
    drawn = draw(views)
    assert [len(axes.patches) for axes in drawn.axes] == [len(closed_outlines(envelope)), 1]
    assert [text.get_text() for text in drawn.subfigs[0].texts][-2:] == ["envelope", "wrist centre"]
    assert [text.get_text() for text in drawn.axes[0].texts] == list(POINTS)
    assert figure_bytes(views, "svg") == figure_bytes(envelope_figures(arm, POINTS), "svg")


def test_the_polygon_has_the_volume():
    envelope = working_envelope(lwr_dyn.load("kr30ha"))
    (loop,) = closed_outlines(envelope)
    r, z = loop.T
    # pi r^2 dz along straight pieces: r^2 is a quadratic, Simpson is exact
    area = np.diff(z) * (r[:-1] ** 2 + r[:-1] * r[1:] + r[1:] ** 2) / 3
    assert np.pi * area.sum() == pytest.approx(envelope.volume, rel=1e-3)


def test_without_points_there_is_only_the_envelope():
    (side,), (top,) = (view.panels for view in envelope_figures(lwr_dyn.load("kr30ha")))
    assert {curve.label for curve in (*side.curves, *top.curves)} == {"envelope", "reach"}


def test_bad_input():
    with pytest.raises(ShapeError, match="far"):
        envelope_figures(lwr_dyn.load("kr30ha"), {"far": (1.0, 2.0)})
    with pytest.raises(OptionError):
        envelope_figures(lwr_dyn.load("lwr4plus"))
