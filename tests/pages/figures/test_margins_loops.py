"""Figures of loops: which curves, in which units, and what is left out of a Nyquist picture."""

import numpy as np
import pytest

from lwr_dyn.pages.figures.margins import BANDS, CutLoops, save_map
from lwr_dyn.pages.plotting.plots import draw

HZ = np.geomspace(0.1, 500, 400)
DELAY = np.exp(-2j * np.pi * HZ * 1e-3)
LOOPS = CutLoops(HZ, {"a": 20 / (1j * HZ) * DELAY, "b": 5 / (1j * HZ) * DELAY}, "b", 1.7, "a test")


def test_bode_is_in_decibel_and_degrees_and_passes_180_where_it_is():
    size, phase = LOOPS.figure("bode").panels
    np.testing.assert_allclose(size.curves[0].y, 20 * np.log10(5 / HZ), atol=1e-9)
    near = int(np.argmin(np.abs(HZ - 100.0)))
    assert phase.curves[0].y[near] == pytest.approx(-90 - 360 * HZ[near] * 1e-3, abs=0.1)
    assert [curve.label for curve in size.curves] == ["b", "other joints"]


def test_nyquist_shows_what_is_near_minus_one():
    curves = LOOPS.figure("nyquist").panels[0].curves
    inside = np.isfinite(curves[1].y)
    np.testing.assert_array_equal(inside, np.maximum(np.abs(curves[1].x + 1), np.abs(curves[1].y)) <= 3.0)
    assert 0 < inside.sum() < HZ.size
    circle = np.hypot(curves[2].x + 1, curves[2].y)
    np.testing.assert_allclose(circle, 1 / 1.7)


def test_sensitivity_has_its_limit():
    panel = LOOPS.figure("sensitivity").panels[0]
    np.testing.assert_allclose(panel.curves[1].y, np.abs(1 / (1 + 20 / (1j * HZ) * DELAY)))
    assert panel.levels[0].value == 1.7


@pytest.mark.parametrize("kind", ["bode", "nyquist", "sensitivity"])
def test_every_figure_can_be_drawn(kind):
    drawing = draw(LOOPS.figure(kind))
    assert len(drawing.axes) == (2 if kind == "bode" else 1)
    assert drawing.axes[0].get_xscale() == ("linear" if kind == "nyquist" else "log")


@pytest.mark.slow
def test_a_map_paints_what_is_unstable_as_an_alarm(tmp_path):
    peaks = np.ones((4, 5))
    peaks[2], peaks[3] = np.inf, 100.0
    axes = [("x, deg", np.arange(5.0)), ("y, deg", np.arange(4.0))]
    png, _ = save_map(tmp_path / "map", axes, peaks, (1.0, 1.0), ("a title", "a note"))
    from matplotlib.image import imread

    colours = {tuple(np.round(255 * x[:3]).astype(int)) for x in imread(png).reshape(-1, 4)[::7]}
    assert (0xC1, 0x12, 0x1F) in colours
    assert len(BANDS) == 5
