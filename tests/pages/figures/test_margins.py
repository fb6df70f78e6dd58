"""Pictures of margins: what the curves and the map show, in which units, and the joints of a map."""

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from lwr_dyn.design.loop_margins import loop_gain, single_loops
from lwr_dyn.design.margins import margins
from lwr_dyn.foundation.errors import FileAccessError, OptionError, UnknownNameError
from lwr_dyn.pages.figures.figure import Level
from lwr_dyn.pages.figures.margins import ACROSS, CutLoops, picture_writer, pose_map, save_map, worst_loops
from lwr_dyn.pages.plotting import plots
from lwr_dyn.pages.plotting.plots import draw
from lwr_dyn.pages.replay.look import tokens
from tests.design.margin_cases import BENT, arm, dynamics, law
from tests.simulation.sample_runs import one_joint

LOOK = tokens()
WORST = f"worst pose ({' '.join(f'{x:.0f}' for x in np.degrees(BENT))}) deg"


@pytest.fixture(scope="module")
def report():
    return margins(arm(), law("pd-gravity"), engine=dynamics(), q=[BENT], delay=1)


def test_the_curves_are_the_loops_cut_at_each_joint(report):
    data = worst_loops(report)
    gain = loop_gain(report.loop, report.case.sampling, data.hz[::100])
    for j, loop in enumerate(data.loops.values()):
        np.testing.assert_allclose(loop[::100], single_loops(gain)[0, :, j], rtol=1e-9)
    assert (tuple(data.loops), data.shown, data.limit) == (arm().joint_names, report.worst_joint, report.limit)
    sensitive = max(np.abs(1 / (1 + x)).max() for x in data.loops.values())
    assert sensitive == pytest.approx(report.worst.peak.max(), rel=1e-3)
    assert data.note == f"all other joints closed; {report.label}; {report.case.words}; {WORST}"


def peaks_of(*poses):
    """The largest |S_ii| at poses, each judged alone."""
    return [margins(arm(), law("pd-gravity"), engine=dynamics(), q=[q], delay=1).worst.peak.max() for q in poses]


@pytest.mark.slow
def test_the_map_holds_all_other_joints_and_shows_where_it_is(report):
    axes, peaks, here, (title, note) = pose_map(report, (1, 3))
    assert [label for label, _ in axes] == ["joint_2, deg", "joint_4, deg"]
    for (_, side), joint in zip(axes, (1, 3), strict=True):
        np.testing.assert_allclose(side, np.degrees(np.linspace(arm().lower[joint], arm().upper[joint], ACROSS)))
    assert here == pytest.approx(np.degrees(BENT[[1, 3]]))
    q = BENT.copy()
    column, row = 12, 30
    q[1], q[3] = np.radians(axes[0][1][column]), np.radians(axes[1][1][row])
    assert peaks.shape == (ACROSS, ACROSS)
    assert peaks[row, column] == pytest.approx(peaks_of(q)[0], rel=0.02)
    assert title == "Margin of lwr4plus, reading physical"
    assert note == f"{report.label}; {report.case.words}\nother joints as at the {WORST}"


def test_the_map_is_of_the_joints_that_change_the_margin_most(report):
    """Joint 1 changes no inertia, joint 7 hardly any; 2 and 4 move the elbow and all behind it."""
    axes, *_ = pose_map(report)
    assert [label for label, _ in axes] == ["joint_2, deg", "joint_4, deg"]


def test_joints_of_a_map_that_cannot_be_are_refused(report):
    for joints in ((0, 0), (0, 7), (-1, 2), (7, 0), (2, -1)):
        with pytest.raises(OptionError, match=f"joints of the map: {joints[0] + 1}, {joints[1] + 1}; allowed: two of"):
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


@pytest.mark.parametrize(
    ("wish", "kind"), [("My_Nyquist.svg", "nyquist"), ("bode", "bode"), ("sensitivity.PNG", "sensitivity")]
)
def test_a_wish_is_the_kind_of_the_files_name(wish, kind, report, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(plots, "check_figure", lambda path: None)
    monkeypatch.setattr(plots, "save_figure", lambda figure, path: (figure.id, path.name))
    assert picture_writer(wish)(report, None) == (kind, wish)


@pytest.mark.slow
def test_a_map_is_written_as_png_and_svg(report, tmp_path):
    png, svg = picture_writer(str(tmp_path / "map.png"))(report, (1, 3))
    assert png.read_bytes()[:4] == b"\x89PNG"
    assert svg.stat().st_size > 5000


HZ = np.geomspace(0.1, 500, 400)
DELAY = np.exp(-2j * np.pi * HZ * 1e-3)
LOOPS = CutLoops(HZ, {"a": 20 / (1j * HZ) * DELAY, "b": 5 / (1j * HZ) * DELAY}, "b", 1.7, "a test")


def test_bode_is_in_decibel_and_degrees_and_passes_180_where_it_is():
    figure = LOOPS.figure("bode")
    size, phase = figure.panels
    for panel in (size, phase):
        assert [curve.label for curve in panel.curves] == ["b", "other joints"]
        np.testing.assert_array_equal(panel.curves[1].x, HZ)
    for k, gain in enumerate((5, 20)):
        np.testing.assert_allclose(size.curves[k].y, 20 * np.log10(gain / HZ), atol=1e-9)
        np.testing.assert_allclose(phase.curves[k].y, -90 - 360 * HZ * 1e-3, atol=1e-9)
    assert [*size.levels, *phase.levels] == [Level("0 dB", 0.0), Level("-180 deg", -180.0)]
    assert [(x.title, x.y_label, x.y_unit) for x in (size, phase)] == [
        ("magnitude, dB", "|L_i|", "dB"), ("phase, deg", "phase of L_i", "deg"),
    ]  # fmt: skip
    assert (figure.x_label, figure.x_unit, figure.note) == ("frequency", "Hz", "a test")
    turned = CutLoops(HZ, {"a": -20 / (1j * HZ) * DELAY}, "a", 1.7, "")
    np.testing.assert_allclose(turned.figure("bode").panels[1].curves[0].y, -270 - 360 * HZ * 1e-3, atol=1e-9)
    none = CutLoops(HZ, {"a": 0j * HZ}, "a", 1.7, "")
    np.testing.assert_allclose(none.figure("bode").panels[0].curves[0].y, -240.0)


def test_nyquist_shows_what_is_near_minus_one():
    figure = LOOPS.figure("nyquist")
    own, other, circle, point = figure.panels[0].curves
    for curve, gain in ((own, 5), (other, 20)):
        loop = gain / (1j * HZ) * DELAY
        inside = np.maximum(np.abs(loop.real + 1), np.abs(loop.imag)) <= 3.0
        assert 0 < inside.sum() < HZ.size
        np.testing.assert_array_equal(np.isfinite(curve.y), inside)
        np.testing.assert_allclose(curve.x[inside] + 1j * curve.y[inside], loop[inside])
    edges = CutLoops(HZ[:4], {"a": np.array([2.0, -4.0 + 3j, 2.001, 3.001j])}, "a", 1.7, "").figure("nyquist")
    assert np.isfinite(edges.panels[0].curves[0].y).tolist() == [True, True, False, False]
    np.testing.assert_allclose(np.hypot(circle.x + 1, circle.y), 1 / 1.7)
    turn = np.unwrap(np.arctan2(circle.y, circle.x + 1))
    np.testing.assert_allclose(turn, np.linspace(0, 2 * np.pi, 181), atol=1e-9)
    assert (circle.label, circle.colour, point.x.item(), point.y.item(), point.style) == (
        "|S_ii| = 1.7", 0, -1.0, 0.0, "points",
    )  # fmt: skip
    assert figure.equal_aspect


def test_sensitivity_has_its_limit():
    panel = LOOPS.figure("sensitivity").panels[0]
    for curve, gain in zip(panel.curves, (5, 20), strict=True):
        np.testing.assert_allclose(curve.y, np.abs(1 / (1 + gain / (1j * HZ) * DELAY)))
    assert panel.levels == (Level("margin 1.7", 1.7),)


@pytest.mark.parametrize("kind", ["bode", "nyquist", "sensitivity"])
def test_every_figure_can_be_drawn(kind):
    drawing = draw(LOOPS.figure(kind))
    assert len(drawing.axes) == (2 if kind == "bode" else 1)
    assert drawing.axes[0].get_xscale() == ("linear" if kind == "nyquist" else "log")


@pytest.fixture
def picture(tmp_path, monkeypatch):
    """The drawing of a map whose rows are at the edges of the bands, beyond them and unstable."""
    drawn = []
    monkeypatch.setattr(plots, "drawing_bytes", lambda drawing, kind: drawn.append((drawing, kind)) or b"x")
    peaks = np.array([[1.0, 1.19, 1.2, 1.4], [1.69, 1.7, 2.5, 4.9], [5.0, 100.0, np.inf, 2.4]])
    axes = [("x, deg", np.arange(4.0)), ("y, m", np.arange(3.0))]
    written = save_map(tmp_path / "map", axes, peaks, (1.0, 2.0), ("a title", "a note\nanother"))
    assert [path.name for path in written] == ["map.png", "map.svg"]
    assert [kind for _, kind in drawn] == ["png", "svg"]
    return drawn[0][0]


BANDS = [[0, 0, 1, 2], [2, 3, 4, 4], [5, 5, 6, 3]]
NAMES = ["up to 1.2", "1.2 to 1.4", "1.4 to 1.7", "1.7 to 2.5", "2.5 to 5", "over 5", "unstable"]


def test_a_map_has_a_shade_for_each_band_and_the_alarm_for_what_is_unstable(picture):
    (panel,) = picture.axes
    (mesh,) = panel.collections
    np.testing.assert_array_equal(mesh.get_array(), BANDS)
    shades = [to_hex(x) for x in mesh.to_rgba(np.arange(7))]
    assert shades[6] == LOOK["alarm"]
    card, blue = (np.array([int(LOOK[x][i : i + 2], 16) for i in (1, 3, 5)]) for x in ("card", "run1"))
    for shade, share in zip(shades[:6], np.linspace(0.06, 0.85, 6), strict=True):
        found = np.array([int(shade[i : i + 2], 16) for i in (1, 3, 5)])
        np.testing.assert_allclose(found, card + share * (blue - card), atol=1.5)
    (mark,) = panel.lines
    assert (mark.get_xydata().tolist(), mark.get_marker(), mark.get_markersize()) == ([[1.0, 2.0]], "o", 7)
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("x, deg", "y, m")
    assert panel.get_position().bounds == pytest.approx((0.1, 0.1, 0.62, 0.715))
    assert picture.get_size_inches().tolist() == [6.8, 5.9]
    assert not any(side.get_visible() for side in panel.spines.values())


def test_a_map_names_its_bands_the_pose_and_what_it_is_of(picture):
    rows = [0.74 - 0.045 * k for k in range(7)]
    pose = 0.74 - 0.045 * 7.4
    below = zip(NAMES, [0.8] * 7, rows, strict=True)
    expected = [
        ("a title", 0.025, 0.955),
        ("a note", 0.025, 0.915),
        ("another", 0.025, 0.88),
        ("max |S_ii|", 0.755, 0.785),
        *below,
        ("worst pose", 0.8, pose),
    ]
    for text, (words, x, y) in zip(picture.texts, expected, strict=True):
        assert (text.get_text(), text.get_va()) == (words, "center")
        assert text.get_position() == pytest.approx((x, y))
    boxes = [x for x in picture.get_children() if isinstance(x, Rectangle) and x.get_width() < 1]
    shades = [to_hex(x) for x in picture.axes[0].collections[0].to_rgba(np.arange(7))]
    assert [to_hex(box.get_facecolor()) for box in boxes] == shades
    for box, row in zip(boxes, rows, strict=True):
        assert (*box.get_xy(), box.get_width(), box.get_height()) == pytest.approx((0.755, row - 0.0125, 0.03, 0.025))
    (dot,) = [x for x in picture.get_children() if isinstance(x, Line2D)]
    assert dot.get_xydata()[0] == pytest.approx([0.77, pose])


def test_an_unstable_loop_is_said(report):
    worse = SimpleNamespace(**{x: getattr(report, x) for x in ("case", "loop", "label", "arm", "worst_joint", "limit")},
                            worst=SimpleNamespace(is_stable=False, q=BENT))  # fmt: skip
    assert worst_loops(worse).note.endswith(f"{WORST}, an unstable loop")
