"""The friction of a run: its forms, its record, and options that are refused."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.friction import Direction, JointFriction, symmetric
from lwr_dyn.simulation.arm_friction import chosen_friction
from lwr_dyn.simulation.contact import ACTIVE_FRICTION
from lwr_dyn.simulation.flow import FastStep
from lwr_dyn.simulation.simulate import no_torque, simulate
from tests.simulation.sample_runs import Still, controllers, joint_waves, lwr, one_joint, with_limits

SMOOTH = 2e-4
"""[m] A slider that brakes from 0.2 m/s over 7 mm against tanh friction at 1e-3 m/s stops later by less."""


def one(*joints, **options):
    return simulate(one_joint(), no_torque, Still(np.zeros(1), 0.3), dq0=[0.2], friction=list(joints), **options)


def test_the_arms_own_friction_is_the_default_with_true_stick():
    arm = replace(one_joint(), friction=(symmetric(3.0, 0.5),))
    run = simulate(arm, no_torque, Still(np.zeros(1), 0.3), dq0=[0.2])
    assert run.meta["friction_law"]["form"] == "set-valued"
    assert run.meta["friction_law"]["highest"] == [3.0]
    assert "stays at rest if its static level holds it" in run.meta["friction_law"]["rule"]
    assert [event.kind for event in run.events] == ["stick"]
    assert run.dq[-1, 0] == 0.0


def test_coulomb_levels_of_a_urdf_stick_too():
    run = simulate(one_joint(coulomb=3.0), no_torque, Still(np.zeros(1), 0.3), dq0=[0.2])
    assert [event.kind for event in run.events] == ["stick"]


def test_none_and_arms_without_friction():
    arm = replace(one_joint(), friction=(symmetric(3.0, 0.5),))
    for run in (
        simulate(arm, no_torque, Still(np.zeros(1), 0.3), dq0=[0.2], friction="none"),
        simulate(one_joint(), no_torque, Still(np.zeros(1), 0.3), dq0=[0.2]),
    ):
        assert run.meta["friction"] is False
        assert run.meta["friction_law"]["form"] == "none"
        assert run.q[-1, 0] == pytest.approx(0.06, abs=1e-12)
        assert (run.tau_friction == 0.0).all()


def test_smooth_friction_comes_near_but_creeps():
    arm = replace(one_joint(), friction=(symmetric(3.0, 0.0),))

    def push(*state):
        return np.array([1.5])

    runs = {
        form: simulate(arm, push, Still(np.zeros(1), 0.5), dq0=[0.2], friction=form, substeps=4)
        for form in ("set-valued", "smooth")
    }
    assert runs["smooth"].q[-1, 0] == pytest.approx(runs["set-valued"].q[-1, 0], abs=5 * SMOOTH)
    assert runs["set-valued"].dq[-1, 0] == 0.0
    assert 1e-4 < runs["smooth"].dq[-1, 0] < 1e-3  # arctanh(1.5/3) mm/s


def test_a_step_too_long_for_stiff_friction_is_refused_with_what_it_takes():
    arm = replace(one_joint(), friction=(symmetric(30.0, 0.0),))
    with pytest.raises(OptionError, match="substeps from 6 on, method dop853, or friction set-valued"):
        simulate(arm, no_torque, Still(np.zeros(1), 0.1), friction="smooth")
    with pytest.raises(OptionError, match="too fast for RK4 steps"):
        one(symmetric(1.0, 6000.0))
    simulate(arm, no_torque, Still(np.zeros(1), 0.01), friction="smooth", substeps=6)
    one(symmetric(1.0, 6000.0), method="dop853")


def test_bad_options():
    with pytest.raises(OptionError, match="set-valued, smooth, none"):
        simulate(one_joint(), no_torque, Still(np.zeros(1), 0.1), friction="sticky")
    with pytest.raises(ShapeError, match="2 joints; allowed: 1"):
        one(None, None)


def test_viscous_friction_alone_needs_no_events():
    friction = chosen_friction(with_limits(lwr(), viscous=0.5))
    assert friction.form == "viscous"
    assert not friction.directional.any()
    np.testing.assert_array_equal(friction.smooth(np.arange(7.0)), 0.5 * np.arange(7))
    asymmetric = chosen_friction(one_joint(), [JointFriction(Direction(0.0, 1.0), Direction(0.0, 2.0))])
    assert asymmetric.form == "set-valued"
    assert asymmetric.directional.all()
    constant = chosen_friction(one_joint(), [JointFriction(Direction(0.0, 1.0), Direction(0.0, 1.0), offset=0.3)])
    assert constant.form == "set-valued"
    assert not constant.directional.any()


def test_friction_that_drives_is_an_event_once_a_side_and_never_clamped():
    model = JointFriction(Direction(1.0, -2.0), Direction(1.0, 0.5))
    run = simulate(one_joint(), no_torque, Still(np.zeros(1), 0.4), dq0=[0.8], friction=[model])
    (event,) = run.events
    assert (event.kind, event.joint, event.t) == (ACTIVE_FRICTION, 0, 0.0)
    assert event.value == pytest.approx(0.8)
    assert run.work["friction"][-1] > 0.1
    assert (np.diff(run.dq[:, 0]) > 0).all()
    np.testing.assert_allclose(run.dq[:, 0], 0.5 + 0.3 * np.exp(run.t), rtol=0, atol=1e-12)
    slow = simulate(one_joint(), no_torque, Still(np.zeros(1), 0.4), dq0=[0.4], friction=[model])
    assert ACTIVE_FRICTION not in [event.kind for event in slow.events]


def test_the_number_of_evaluations_is_reported():
    plain = simulate(one_joint(), no_torque, Still(np.zeros(1), 0.1), substeps=3)
    assert plain.meta["evaluations"] == 4 * 3 * 100
    still = one(symmetric(1e3, 0.0))
    assert 0 < still.meta["evaluations"] < 4 * 300


def test_the_seven_joints_of_the_wam_have_their_table():
    arm = lwr_dyn.load("wam7")
    friction = chosen_friction(arm)
    assert friction.form == "set-valued"
    for dq in (0.1, -0.1):
        torque = friction.torque(np.full(7, int(np.sign(dq))), np.zeros(7, dtype=bool))
        want = [float(model.torque(dq)) for model in arm.friction_models()]
        np.testing.assert_allclose(torque(np.full(7, dq)), want, rtol=1e-15)


@pytest.mark.slow
def test_the_fast_path_and_the_flow_give_the_same_run(monkeypatch):
    """A fast step that is refused every time gives the same run, to rounding, events included."""
    models = [symmetric(f, 0.1) for f in (9.0, 9.0, 4.0, 4.0, 0.3, 0.3, 0.1)]
    wave = joint_waves(2.0)
    wave = replace(wave, w=4 * wave.w)
    fast = simulate(lwr(), controllers()["pd-gravity"], wave, friction=models)
    monkeypatch.setattr(FastStep, "take", lambda *_: False)
    slow = simulate(lwr(), controllers()["pd-gravity"], wave, friction=models)
    assert [(e.kind, e.joint) for e in fast.events] == [(e.kind, e.joint) for e in slow.events]
    assert len(fast.events) >= 8
    np.testing.assert_allclose(fast.q, slow.q, rtol=0, atol=1e-12)
    np.testing.assert_allclose(fast.tau_friction, slow.tau_friction, rtol=0, atol=1e-8)
    np.testing.assert_allclose(fast.work["friction"], slow.work["friction"], rtol=0, atol=1e-11)
