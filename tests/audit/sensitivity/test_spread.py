"""The spread over readings: what it compares, what it concludes, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.audit.sensitivity.conclusions import Conclusion, conclusions
from lwr_dyn.audit.sensitivity.jobs import INVERSE, PD, Said, job_of
from lwr_dyn.audit.sensitivity.matrix import spread
from lwr_dyn.audit.sensitivity.pairs import outcomes
from lwr_dyn.audit.sensitivity.statics import shared_poses, statics_of
from lwr_dyn.errors import LwrDynError, MissingDataError, OptionError, ShapeError, UnknownNameError
from lwr_dyn.simulation.plant import scaled
from lwr_dyn.trajectory.references.point_to_point import point_to_point

RATE = 250.0
"""[Hz] Loops of 50 rad/s hold at it."""


@pytest.fixture(scope="module")
def arms():
    arm = lwr_dyn.load("lwr4plus")
    return {"true": arm, "heavy": scaled(arm, 1.1)}


@pytest.fixture(scope="module")
def found(arms):
    return spread(arms, "joint-move", rate=RATE, poses=50)


def test_gravity_and_inertia_scale_with_the_masses(found):
    true, heavy = found.statics["true"], found.statics["heavy"]
    assert heavy.gravity == pytest.approx(1.1 * true.gravity, rel=1e-9, abs=1e-12)
    assert heavy.gravity_off(true) == pytest.approx(0.1 * np.abs(true.gravity).max(axis=0), rel=1e-6, abs=1e-12)
    assert heavy.gains.Kp == pytest.approx(2500.0 * heavy.b)


def test_a_controller_that_knows_its_plant_does_best(found):
    tips = found.tip_rms_mm(INVERSE)
    assert np.argmin(tips, axis=0).tolist() == [0, 1]
    assert tips[0, 1] > 10 * tips[0, 0]
    assert np.isfinite(found.tip_rms_mm(PD)).all()


def test_the_matrix_is_believed_by_real(arms, found):
    """The droop of inverse dynamics hangs down where it believes in less than is there."""
    runs = {(o.believed, o.real): o for o in found.outcomes if o.law == INVERSE}
    light = runs["true", "heavy"].figures.position_mrad.mean
    heavy = runs["heavy", "true"].figures.position_mrad.mean
    assert np.sign(light[1]) == -np.sign(heavy[1])
    assert found.worst_mrad(INVERSE)[0, 1] == runs["true", "heavy"].worst_mrad


def test_conclusions_are_computed(found):
    said = {c.text: c for c in found.conclusions}
    better = said[f"{INVERSE} tracks better than {PD} (RMS of the tip)"]
    tips = {law: found.tip_rms_mm(law) for law in (INVERSE, PD)}
    for i, believed in enumerate(found.names):
        for j, real in enumerate(found.names):
            assert better.holds[believed, real] == (tips[INVERSE][i, j] < tips[PD][i, j])
    gains = {c.text: c.holds for c in found.conclusions if c.text.startswith("gains")}
    assert list(gains.values()) == [{("heavy",): False}, {("heavy",): False}]


def test_largest_joints_are_a_proposition(found):
    job = replace(found.job, said=(Said("as found", PD, _two_largest(found), "max"), Said("never", PD, (5, 6), "max")))
    said = {c.text: c for c in conclusions(job, found.outcomes, found.statics)}
    assert said["as found"].holds["true", "true"] is True
    assert not said["never"].survives


def _two_largest(found):
    run = next(o for o in found.outcomes if (o.law, o.believed, o.real) == (PD, "true", "true"))
    return tuple(np.argsort(-np.abs(run.figures.position_mrad.max))[:2].tolist())


def test_verdicts_in_words():
    keys = [(a, b) for a in "xy" for b in "xy"]
    assert Conclusion("", dict.fromkeys(keys, True)).verdict() == "holds under all 4 pairs"
    assert Conclusion("", dict.fromkeys(keys, False)).verdict() == "holds under none of 4 pairs"
    one = Conclusion("", {**dict.fromkeys(keys, True), ("x", "y"): None})
    assert one.verdict() == "fails for x on y (3 of 4 hold)"
    assert not one.survives
    assert one.share == 0.75


def test_a_loop_that_would_chatter_is_sampled_faster():
    """The physical wrist has 90 times the inertia that the computed one has: its Kd is far too strong there."""
    arms = {name: lwr_dyn.load("lwr4plus", name) for name in ("computed", "physical")}
    job = job_of(arms["computed"], "joint-move")
    move = point_to_point(arms["computed"], job.reference.waypoints[:2], [0.5])
    statics = statics_of(arms, 5, 0, 50.0, 1.0)
    runs = {
        (o.believed, o.real): o for o in outcomes(arms, replace(job, reference=move), statics, 1000.0) if o.law == PD
    }
    assert runs["computed", "physical"].rate == 1000.0
    assert runs["physical", "computed"].rate > 5000.0
    assert runs["physical", "computed"].worst_mrad < 2 * runs["physical", "physical"].worst_mrad


def test_a_run_that_comes_to_nothing_is_told(arms):
    arm = arms["true"]
    narrow = replace(arm, limits=(replace(arm.limits[0], lower=1.0, upper=2.0), *arm.limits[1:]))
    found = spread({"true": arm, "narrow": narrow}, "joint-move", rate=RATE, poses=5)
    faults = {(o.believed, o.real): o.fault for o in found.outcomes if o.law == PD}
    assert not faults["narrow", "true"]
    assert "joint_1" in faults["true", "narrow"]
    assert np.isnan(found.tip_rms_mm(PD)[0, 1])
    assert next(iter(found.conclusions)).holds["true", "narrow"] is None


def test_poses_lie_in_the_box_that_all_allow(arms):
    arm = arms["true"]
    narrow = replace(arm, limits=(replace(arm.limits[0], lower=1.0, upper=2.0), *arm.limits[1:]))
    q = shared_poses({"true": arm, "narrow": narrow}, 100, 0)
    assert q[:, 0].min() >= 1.0
    assert q[:, 0].max() <= 2.0
    assert np.array_equal(q, shared_poses({"true": arm, "narrow": narrow}, 100, 0))


def test_readings_of_the_lwr_differ_in_gravity_by_the_copied_centre_of_mass():
    arms = {name: lwr_dyn.load("lwr4plus", name) for name in ("computed", "printed", "physical")}
    s = statics_of(arms, 200, 0, 50.0, 1.0)
    off = s["printed"].gravity_off(s["computed"])
    m, g, c5z = 1.8789, 9.81, 0.0238 - 0.004375432
    assert off[4] <= m * g * c5z * (1 + 1e-9)
    assert off[4] > 0.9 * m * g * c5z
    assert s["physical"].gravity_off(s["computed"]).max() < 1e-9


@pytest.mark.parametrize(("robot", "task"), [("lwr4plus", "ist"), ("wam7", "lspb"), ("kr30ha", "two-points")])
def test_each_paper_sets_its_task(robot, task):
    arm = lwr_dyn.load(robot)
    job = job_of(arm)
    assert job.name == task
    q = job.reference.sample(np.linspace(0, job.reference.duration, 50)).q
    assert (q >= arm.lower - 1e-9).all()
    assert (q <= arm.upper + 1e-9).all()


def test_two_points_reach_the_points():
    arm = lwr_dyn.load("kr30ha")
    q = job_of(arm).reference.waypoints
    T = lwr_dyn.forward_kinematics(arm, q)
    assert T[1, :3, 3] == pytest.approx([0.091, -1.139, 1.392], abs=1e-9)
    assert T[2, :3, :3] == pytest.approx(np.eye(3), abs=1e-9)


BAD = [
    (lambda a: {"one": a}, {}, OptionError),
    (lambda a: {"a": a, "b": lwr_dyn.load("kr30ha")}, {}, ShapeError),
    (lambda a: {"a": a, "b": a}, {"task": "dance"}, UnknownNameError),
    (lambda a: {"a": a, "b": a}, {"poses": 0}, OptionError),
    (lambda a: {"a": a, "b": a}, {"task": "two-points"}, OptionError),
    (lambda a: {"a": a, "b": lwr_dyn.load("lwr4")}, {}, MissingDataError),
]


@pytest.mark.parametrize(("make", "options", "error"), BAD)
def test_bad_input(arms, make, options, error):
    with pytest.raises(error) as caught:
        spread(make(arms["true"]), **options)
    assert isinstance(caught.value, LwrDynError)


def test_poses_are_bounded():
    with pytest.raises(OptionError, match="poses: 99999999999; allowed: from 1 to 1000000"):
        spread({name: lwr_dyn.load("lwr4plus", name) for name in ("computed", "printed")}, poses=99999999999)
