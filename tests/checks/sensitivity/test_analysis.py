"""A task under several readings: what is compared, which conclusions follow, which input is refused."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.checks.sensitivity.analysis import error_table, notes, sensitivity
from lwr_dyn.checks.sensitivity.closed_loops import Conclusion, closed_loops, conclusions, shared_poses, statics_of
from lwr_dyn.checks.sensitivity.study_tasks import PublishedClaim, simulated_task
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError, UnknownNameError
from lwr_dyn.model.arm import arm_with_scaled_inertia
from lwr_dyn.trajectory.references.joint_moves import point_to_point

PD, INVERSE = "PD + gravity, damping on dq", "inverse dynamics with feed-forward"
RATE = 250.0
"""[Hz] Inverse dynamics holds at it, PD at five times as much."""


@pytest.fixture(scope="module")
def arms():
    """The LWR 4+ with its rotors as built and its wrist held: in the default reading PD is sampled at 11 kHz."""
    arm = lwr_dyn.load("lwr4plus", "physical", lock=dict.fromkeys(("joint_5", "joint_6", "joint_7"), 0.5))
    return {"true": arm, "heavy": arm_with_scaled_inertia(arm, 1.1)}


@pytest.fixture(scope="module")
def result(arms):
    return sensitivity(arms, "joint-move", rate=RATE, poses=50)


def test_gravity_and_inertia_scale_with_the_masses(result):
    true, heavy = result.statics["true"], result.statics["heavy"]
    assert heavy.gravity == pytest.approx(1.1 * true.gravity, rel=1e-9, abs=1e-12)
    assert heavy.gravity_off(true) == pytest.approx(0.1 * np.abs(true.gravity).max(axis=0), rel=1e-6, abs=1e-12)
    assert heavy.gains.Kp == pytest.approx(2500.0 * heavy.b)
    assert heavy.gains.Kd == pytest.approx(100.0 * heavy.b)
    record = result.document.record()
    assert record["statics"]["heavy"]["gravity_difference"] == pytest.approx(heavy.gravity_off(true).tolist())
    assert (record["rate"], record["poses"], record["readings"]) == (RATE, 50, ["true", "heavy"])


def test_a_controller_that_knows_its_plant_does_best(result):
    """Rows are models and columns plants: the arm droops where the model is lighter than the plant."""
    tips = result.tip_rms_mm(INVERSE)
    assert (np.argmin(tips, axis=0).tolist(), tips[0, 1] > 10 * tips[0, 0]) == ([0, 1], True)
    assert np.isfinite(result.tip_rms_mm(PD)).all()
    runs = {(o.model, o.plant): o for o in result.runs if o.controller == INVERSE}
    light, heavy = (runs[key].metrics.position_mrad.mean for key in (("true", "heavy"), ("heavy", "true")))
    assert np.sign(light[1]) == -np.sign(heavy[1])
    assert result.worst_mrad(INVERSE)[0, 1] == runs["true", "heavy"].worst_mrad


def test_conclusions_are_computed(result):
    by_text = {c.text: c for c in result.conclusions}
    better = by_text[f"{INVERSE} tracks better than {PD} (RMS of the tip)"]
    tips = result.tip_rms_mm(INVERSE) < result.tip_rms_mm(PD)
    assert better.holds == {(x, y): tips[i, j] for i, x in enumerate(result.names) for j, y in enumerate(result.names)}
    gains = [c.holds for c in result.conclusions if c.text.startswith("gains")]
    assert gains == [{("heavy",): False}, {("heavy",): False}]


def test_largest_joints_are_a_proposition(result):
    claims = (
        PublishedClaim("as published", "", "PD", _two_largest(result), "max"),
        PublishedClaim("never", "", "PD", tuple({0, 1, 2, 3} - {*_two_largest(result)}), "max"),
    )
    study = replace(result.study, task=replace(result.study.task, claims=claims))
    by_text = {c.text: c for c in conclusions(study, result.runs, result.statics)}
    assert by_text[f"as published under {PD}"].holds["true", "true"] is True
    assert not by_text[f"never under {PD}"].survives


def _two_largest(result):
    run = next(o for o in result.runs if (o.controller, o.model, o.plant) == (PD, "true", "true"))
    return tuple(np.argsort(-np.abs(run.metrics.position_mrad.max))[:2].tolist())


def test_verdicts_in_words():
    keys = [(a, b) for a in "xy" for b in "xy"]
    every, none = (Conclusion("", dict.fromkeys(keys, value)) for value in (True, False))
    one = Conclusion("", {**dict.fromkeys(keys, True), ("x", "y"): None})
    assert [(c.verdict(), c.survives, c.share) for c in (every, none, one)] == [
        ("holds under all 4 pairs", True, 1.0), ("holds under none of 4 pairs", False, 0.0),
        ("fails for x on y (3 of 4 hold)", False, 0.75),
    ]  # fmt: skip


@pytest.mark.slow
def test_a_loop_that_would_chatter_is_sampled_faster():
    """The physical wrist has 90 times the inertia that the computed one has: its Kd is far too strong there."""
    arms = {name: lwr_dyn.load("lwr4plus", name) for name in ("computed", "physical")}
    study = simulated_task(arms["computed"], "joint-move")
    move = point_to_point(arms["computed"], study.reference.waypoints[:2], [0.5])
    statics = statics_of(arms, 5, 0, 50.0, 1.0)
    runs = {
        (o.model, o.plant): o
        for o in closed_loops(arms, replace(study, reference=move), statics, 1000.0)
        if o.controller == PD
    }
    assert runs["computed", "physical"].rate == 1000.0
    assert runs["physical", "computed"].rate > 5000.0
    assert runs["physical", "computed"].worst_mrad < 2 * runs["physical", "physical"].worst_mrad


@pytest.fixture
def narrow(arms):
    """The arm beside one whose first joint has less room."""
    arm = arms["true"]
    limits = (replace(arm.limits[0], lower=1.0, upper=2.0), *arm.limits[1:])
    return {"true": arm, "narrow": replace(arm, limits=limits)}


def test_a_simulation_that_fails_is_reported(narrow):
    result = sensitivity(narrow, "joint-move", rate=RATE, poses=5)
    faults = {(o.model, o.plant): o.fault for o in result.runs if o.controller == PD}
    assert (faults["narrow", "true"], "joint_1" in faults["true", "narrow"]) == ("", True)
    assert np.isnan(result.tip_rms_mm(PD)[0, 1])
    assert next(iter(result.conclusions)).holds["true", "narrow"] is None


def test_poses_lie_in_the_box_that_all_allow(narrow):
    q = shared_poses(narrow, 100, 0)
    assert 1.0 <= q[:, 0].min() < 1.1 < 1.9 < q[:, 0].max() <= 2.0
    assert np.array_equal(q, shared_poses(narrow, 100, 0))


@pytest.mark.slow
def test_readings_of_the_lwr_differ_in_gravity_by_the_copied_centre_of_mass():
    arms = {name: lwr_dyn.load("lwr4plus", name) for name in ("computed", "printed", "physical")}
    s = statics_of(arms, 200, 0, 50.0, 1.0)
    off = s["printed"].gravity_off(s["computed"])
    m, g, c5z = 1.8789, 9.81, 0.0238 - 0.004375432
    assert off[4] <= m * g * c5z * (1 + 1e-9)
    assert off[4] > 0.9 * m * g * c5z
    assert s["physical"].gravity_off(s["computed"]).max() < 1e-9


@pytest.mark.parametrize(("robot", "task"), [("lwr4plus", "ist-clear"), ("wam7", "lspb"), ("kr30ha", "two-points")])
def test_each_paper_sets_its_task(robot, task):
    arm = lwr_dyn.load(robot)
    study = simulated_task(arm)
    assert study.task.name == task
    q = study.reference.sample(np.linspace(0, study.reference.duration, 50)).q
    assert ((q >= arm.lower - 1e-9) & (q <= arm.upper + 1e-9)).all()
    if task == "two-points":
        T = lwr_dyn.forward_kinematics(arm, study.reference.waypoints)
        assert T[1, :3, 3] == pytest.approx([0.091, -1.139, 1.392], abs=1e-9)
        assert T[2, :3, :3] == pytest.approx(np.eye(3), abs=1e-9)


BAD = [
    (lambda a: {"one": a}, {}, OptionError, "arms: 1; allowed: 2 to 8 readings or files"),
    (lambda a: {"a": a, "b": lwr_dyn.load("kr30ha")}, {}, ShapeError, "7"),
    (lambda a: {"a": a, "b": a}, {"task": "dance"}, UnknownNameError, "'dance'"),
    (lambda a: {"a": a, "b": a}, {"poses": 0}, OptionError, "poses: 0; allowed: from 1 to 1000000"),
    (lambda a: {"a": a, "b": a}, {"poses": 1_000_001}, OptionError, "poses: 1000001; allowed"),
    (lambda a: {"a": a, "b": a}, {"task": "two-points"}, OptionError, "task: lwr4plus has no mastering position"),
    (lambda a: {"a": a, "b": lwr_dyn.load("lwr4")}, {}, MissingDataError, "masses"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "options", "error", "says"), BAD)
def test_bad_input(arm, make, options, error, says):
    with pytest.raises(error, match=says):
        sensitivity(make(arm), **options)


TIPS = np.array([[1.0, 2.0], [4.0, np.nan]])


def result_of(**stops):
    def run(model, plant):
        met = stops.get(model + plant, "")
        figures = SimpleNamespace(stops=SimpleNamespace(met=bool(met), sentence=lambda: met))
        rate = 2000.0 if (model, plant) == ("a", "b") else 1000.0
        return SimpleNamespace(model=model, plant=plant, controller="pd", rate=rate, metrics=figures, fault="")

    return SimpleNamespace(
        names=("a", "b"), rate=1000.0, runs=tuple(run(m, p) for m in "ab" for p in "ab"),
        tip_rms_mm=lambda name: TIPS, worst_mrad=lambda name: 10 * TIPS,
    )  # fmt: skip


def test_errors_are_written_with_their_marks_and_shaded_by_their_share():
    table = error_table(result_of(), "pd")
    assert table.cells == (("a", "1 (10)", "2 (20)*"), ("b", "4 (40)", "no run"))
    assert table.shades == ((None, 0.0, pytest.approx(0.25)), (None, pytest.approx(0.75), 0.0))
    stopped = result_of(ab="joint_6 on its stop for 1.6 s")
    assert error_table(stopped, "pd").cells[0] == ("a", "1 (10)", "2 (20)*!")
    assert "! pd, a on b: joint_6 on its stop for 1.6 s" in notes(stopped)
