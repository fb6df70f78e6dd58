"""`lwr-dyn reproduce kr30ha` writes a folder that holds, and its movement is the report's."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.kr30ha.points import RISE, SPEED_SHARE, WAIT, cycle_reference, right_points
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
        "check kr30ha, reading kuka",
        "erratum theta1-p2",
        "544.9",
        "alpha = -90 deg, theta = q1",
        "2032.72",
        "B_22 = I2zz + m2*(a2 + c2x)^2",
        "entries not 0",
        "product-term",
        "largest |tau|",
    ):
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
