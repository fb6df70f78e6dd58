"""`lwr-dyn reproduce kr30ha` writes a folder that holds; its movement is the report's, its envelope a figure."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.checks.datasheet.envelope import working_envelope
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.run import Run
from lwr_dyn.pages.plotting.plots import draw, figure_bytes
from lwr_dyn.reproduction.kr30ha.points import RISE, SPEED_SHARE, WAIT, Cycle, Waypoint, cycle_reference, right_points
from lwr_dyn.reproduction.kr30ha.study import closed_outlines, cycle_table, envelope_figures, pictures
from lwr_dyn.reproduction.reproduce import reproduce
from tests.reproduction.pages import faults, lost

ARM = lwr_dyn.load("kr30ha")
ROADS = 1e-9
"""[N m] Torques of some thousands by both roads."""
TRACKED = 1e-3
"""[mm] What is left of the tracking error after two seconds of rest."""


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    place = tmp_path_factory.mktemp("kr30ha")
    steps = []
    return reproduce("kr30ha", place, progress=steps.append), place, steps


@pytest.mark.slow
def test_it_holds_and_writes_what_it_promises(outcome):
    found, place, steps = outcome
    assert found.holds
    assert len(steps) == 8
    written = {str(p.relative_to(place)) for p in place.rglob("*") if p.is_file()}
    assert written >= {
        "tables.txt", "errata.txt", "results.json", "checks.txt", "equations.txt", "equations.tex",
        "equations_general.tex", "replay.html", "report.html",
        "plots/envelope.png", "plots/torque.svg", "models/kr30ha.urdf",
        "runs/mastering_p1_p2_mastering.npz",
    }  # fmt: skip
    assert json.loads((place / "results.json").read_text())["holds"] is True


@pytest.mark.slow
def test_the_report_loses_nothing_and_is_as_short_as_its_message(outcome, browser):
    assert lost(outcome[1]) == []
    assert faults(browser, outcome[1] / "report.html", wide=10_000, narrow=20_000) == []
    text = (outcome[1] / "report.html").read_text(encoding="utf-8")
    assert "80 hold, 6 fail as expected" in text
    assert "FAIL" not in text.replace("FAILS", "").split("<main>")[1].split("As text")[0]


@pytest.mark.slow
def test_the_text_carries_points_matrices_envelope_equations_and_movement(outcome):
    text = outcome[0].document.text()
    for promise in (
        "check kr30ha, reading kuka", "erratum theta1-p2", "544.9", "alpha = -90 deg, theta = q1", "2032.72",
        "B_22 = I2zz + m2*(a2 + c2x)^2", "entries not 0", "product-term", "largest |tau|",
    ):  # fmt: skip
        assert promise in text


@pytest.mark.slow
def test_the_run_stands_at_each_point_and_both_roads_hold_it(outcome):
    found, place, _ = outcome
    run = Run.load(place / "runs" / "mastering_p1_p2_mastering.npz")
    assert run.meta["note"]["speed_share"] == {"value": SPEED_SHARE, "kind": "assumed"}
    for stop in found.document.record()["stops"]:
        assert stop["missed_mm"] < TRACKED
        a, b = stop["g"].values()
        assert np.abs(a - b).max() < ROADS
        assert np.abs(a[[0, 3]]).max() < ROADS  # a vertical axis, and a mirror-symmetric arm in its own plane
    for end in (run.q[0], run.q[-1]):
        assert np.degrees(end) == pytest.approx([0, -90, 90, 0, 0, 0], abs=1e-6)


def test_the_movement_waits_as_the_program_does_and_keeps_speed_and_rise():
    points = right_points(ARM)
    reference, ends = cycle_reference(ARM, points)
    t = np.linspace(0.0, reference.duration, 5001)
    motion = reference.sample(t)
    assert np.abs(motion.dq / ARM.velocity).max() == pytest.approx(SPEED_SHARE, rel=1e-4)
    assert np.abs(motion.ddq / ARM.velocity).max() <= (1 + 1e-9) / RISE
    for point, end in zip(points, ends, strict=True):
        at = reference.sample(np.linspace(end - WAIT, end, 11))
        assert np.abs(at.q - point.q).max() < 1e-12
        assert np.abs(at.dq).max() < 1e-12


def test_the_movement_in_a_table():
    a, b = np.array([0.0, 1.0, -2.0, 0, 0, 0]), np.array([0.0, 1.0, -2.5, 0, 0, 0])
    speeds, meta = np.array([ARM.velocity / 2, 0.0 * a]), {"controller": {"label": "law"}}
    run = SimpleNamespace(meta=meta, tau_applied=np.array([a, -2 * a]), dq=speeds)
    points = (Waypoint("home", {"x": a, "y": b}, 1.5e-4),)
    table = cycle_table(Cycle(SimpleNamespace(duration=12.254), run, points), ARM)
    assert table.title == (
        "Mastering, Point 1, Point 2, mastering in 12.25 s, at most 50% of rated speed, 0.5 s to come to it (both "
        "assumed), law, estimated masses"
    )
    assert list(table.cells) == [("home", "0.00 1.00 -2.00 0.00 0.00 0.00", "5.0e-01", "1.5e-04")]
    assert table.note.splitlines() == [
        "largest |tau|, A1 to A6 [N m]: 0.00 2.00 4.00 0.00 0.00 0.00",
        "largest speed over rated, A1 to A6: 0.500 0.500 0.500 0.500 0.500 0.500",
    ]


def test_the_pictures_are_those_of_the_report():
    """Axes in degrees, one panel each; torques of the movement alone; the arm at A = 0, mastering, the points."""
    hold = lwr_dyn.reference("hold", ARM, q=ARM.mastering, duration=0.02)
    run, points = lwr_dyn.simulate(ARM, lwr_dyn.controller("inverse-dynamics", ARM), hold), right_points(ARM)
    found, label = pictures(ARM, points, run, run), "inverse dynamics with feed-forward"
    assert found.simulated == ((label, "mastering_p1_p2_mastering.npz", run),)
    assert [one.caption for one in found.shown] == [label, "KRL program, corrected"]
    assert (found.title, found.replayed) == ("KUKA KR 30 HA: mastering, Point 1, Point 2, mastering", 1)
    (movement,), (torque,), (side, top) = (found.figures[name] for name in ("movement", "torque", "envelope"))
    assert (movement.title, movement.over_time, movement.columns) == ("Axes over the movement", True, 3)
    assert [(x.title, x.y_label, x.y_unit) for x in movement.panels] == [(f"A{j}", "axis", "deg") for j in range(1, 7)]
    for j, one in enumerate(movement.curves):
        assert one.label == label
        np.testing.assert_allclose(one.y.values(found.shown), np.degrees(run.q[:, j]))
    assert torque.title == "Torques of the movement, estimated masses"
    assert {one.label for one in torque.curves} == {label}
    assert (side.panels[0].curves[-1].text, top.panels[0].curves[-1].text) == (("point_1", "point_2", "home"),) * 2
    np.testing.assert_allclose(top.panels[0].curves[-1].y, [1e-3 * p.wrist_mm[1] for p in points])
    assert [(one.label, one.note) for one in found.stills] == [
        ("Figure 5: DH frames, A = 0", "the arm stretched out, KUKA's zero"),
        ("mastering", "A = (0, -90, 90, 0, 0, 0) deg"),
        *((f"Figure 6: point_{k}, elbow up", "flange there with A = B = C = 0") for k in (1, 2)),
    ]
    at = [np.zeros(6), np.radians([0, -90, 90, 0, 0, 0]), points[0].q, points[1].q]
    np.testing.assert_allclose([one.q for one in found.stills], at, atol=1e-12)


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
