"""Pictures of margins: what the curves and the map show, in which units, and the joints of a map."""

import numpy as np
import pytest

from lwr_dyn.design.loop_margins import loop_gain, single_loops
from lwr_dyn.design.margins import margins
from lwr_dyn.foundation.errors import FileAccessError, OptionError, UnknownNameError
from lwr_dyn.pages.figures.figure import Level
from lwr_dyn.pages.figures.margins import ACROSS, BANDS, CutLoops, picture_writer, pose_map, save_map, worst_loops
from lwr_dyn.pages.plotting.plots import draw
from tests.design.margin_cases import BENT, arm, dynamics, law
from tests.simulation.sample_runs import one_joint


@pytest.fixture(scope="module")
def report():
    return margins(arm(), law("pd-gravity"), engine=dynamics(), q=[BENT], delay=1)


def test_the_curves_are_the_loops_cut_at_each_joint(report):
    data = worst_loops(report)
    gain = loop_gain(report.loop, report.case.sampling, data.hz[::100])
    np.testing.assert_allclose(data.loops["joint_3"][::100], single_loops(gain)[0, :, 2], rtol=1e-9)
    assert data.shown == report.worst_joint
    assert [x for panel in data.figure("bode").panels for x in panel.levels] == [
        Level("0 dB", 0.0),
        Level("-180 deg", -180.0),
    ]
    assert max(np.abs(1 / (1 + x)).max() for x in data.loops.values()) == pytest.approx(
        report.worst.peak.max(), rel=1e-3
    )


@pytest.mark.slow
def test_the_map_holds_all_other_joints_and_shows_where_it_is(report):
    axes, peaks, here, (title, note) = pose_map(report, (1, 3))
    assert [label for label, _ in axes] == ["joint_2, deg", "joint_4, deg"]
    assert here == pytest.approx(np.degrees(BENT[[1, 3]]))
    q = BENT.copy()
    column, row = 12, 30
    q[1], q[3] = np.radians(axes[0][1][column]), np.radians(axes[1][1][row])
    at = margins(arm(), law("pd-gravity"), engine=dynamics(), q=[q], delay=1)
    assert peaks.shape == (ACROSS, ACROSS)
    assert peaks[row, column] == pytest.approx(at.worst.peak.max(), rel=0.02)
    assert "lwr4plus, reading physical" in title
    assert "other joints as at the worst pose" in note


def test_the_joints_that_change_nothing_are_not_those_of_the_map(report):
    across, up = pose_map(report)[0]
    assert "joint_1" not in across[0] + up[0]  # the inertias do not change with it
    assert "joint_7" not in across[0] + up[0]


def test_joints_of_a_map_that_cannot_be_are_refused(report):
    for joints in ((0, 0), (0, 7), (-1, 2)):
        with pytest.raises(OptionError, match="two of the joints 1 to 7"):
            pose_map(report, joints)
    slider = one_joint(mass=2.0)
    alone = margins(slider, lambda t, q, dq, q_ref, dq_ref, ddq_ref: -100 * (q - q_ref) - 20 * dq, q=[[0.0]])
    with pytest.raises(OptionError, match="one joint"):
        pose_map(alone)


@pytest.mark.parametrize(
    ("wish", "error"), [("chart", UnknownNameError), ("bode.pdf", FileAccessError), ("none/bode.png", FileAccessError)]
)
def test_wishes_that_cannot_be_are_refused_before_the_work(wish, error, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(error):
        picture_writer(wish)


@pytest.mark.slow
def test_a_map_is_written_as_png_and_svg(report, tmp_path):
    png, svg = picture_writer(str(tmp_path / "map.png"))(report, (1, 3))
    assert png.read_bytes()[:4] == b"\x89PNG"
    assert svg.stat().st_size > 5000


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


def test_a_map_paints_what_is_unstable_as_an_alarm(tmp_path):
    peaks = np.ones((4, 5))
    peaks[2], peaks[3] = np.inf, 100.0
    axes = [("x, deg", np.arange(5.0)), ("y, deg", np.arange(4.0))]
    png, _ = save_map(tmp_path / "map", axes, peaks, (1.0, 1.0), ("a title", "a note"))
    from matplotlib.image import imread

    colours = {tuple(np.round(255 * x[:3]).astype(int)) for x in imread(png).reshape(-1, 4)[::7]}
    assert (0xC1, 0x12, 0x1F) in colours
    assert len(BANDS) == 5
