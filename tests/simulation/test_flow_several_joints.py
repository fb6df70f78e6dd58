"""True stick of several joints, against references that do not share our code."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Body, Chain, ChainLink, JointKind
from lwr_dyn.model.friction import Direction, JointFriction, symmetric
from lwr_dyn.model.spatial import Pose
from lwr_dyn.simulation.audit import audit
from lwr_dyn.simulation.simulate import simulate
from tests.simulation.phases import Phases
from tests.simulation.sample_runs import Sinusoids, Still, controllers, lwr
from tests.simulation.stick_cases import constant, kinds, plane_arm

REFERENCE = 1e-9
"""[rad], against scipy's DOP853 at 1e-12 in every phase; RK4 at 1 kHz leaves 1e-11."""
INSTANT = 1e-9
"""[s], events against the same reference."""


class TestTwoJoints:
    def test_both_stop_in_the_same_instant(self):
        """Two sliders on one axis have a constant mass matrix, so each phase is a parabola."""
        friction, load, t_stop = np.array([3.0, 2.0]), np.array([0.5, 0.2]), 0.31237
        speed = np.linalg.solve(SLIDING, friction - load) * t_stop
        run = simulate(
            sliders(),
            constant(*load),
            Still(np.zeros(2), 0.6),
            dq0=speed,
            friction=[symmetric(f, 0.0) for f in friction],
        )
        assert (speed > 0).all()
        assert kinds(run) == ["stick", "stick"]
        assert run.events[0].t == run.events[1].t == pytest.approx(t_stop, abs=1e-12)
        np.testing.assert_allclose(run.q[-1], run.dq[0] * t_stop / 2, rtol=0, atol=1e-12)
        assert (run.q[run.t > t_stop] == run.q[-1]).all()
        np.testing.assert_allclose(run.tau_friction[-1], [0.5, 0.2], rtol=0, atol=1e-14)

    def test_both_stop_and_only_one_may_stay(self):
        """Either load alone exceeds break-away; but joint 1, which turns back, takes enough off joint 2 to keep it."""
        t_stop, friction, load = 0.2, np.array([1.0, 2.0]), np.array([-4.5, -2.3])
        speed = np.linalg.solve(SLIDING, friction - load) * t_stop
        run = simulate(
            sliders(),
            constant(*load),
            Still(np.zeros(2), 0.5),
            dq0=speed,
            friction=[symmetric(f, 0.0) for f in friction],
        )
        assert (np.abs(load) > friction).all()
        assert (speed > 0).all()
        assert [(e.kind, e.joint) for e in run.events] == [("reverse", 0), ("stick", 1)]
        s = 0.5 - t_stop
        back = np.array([(load[0] + friction[0]) / SLIDING[0, 0], 0.0])
        assert run.tau_friction[-1, 1] == pytest.approx(load[1] - SLIDING[1, 0] * back[0], abs=1e-12)
        np.testing.assert_allclose(run.q[-1], speed * t_stop / 2 + back * s**2 / 2, rtol=0, atol=1e-11)

    def test_the_rule_where_static_friction_exceeds_coulombs(self):
        """5 N frees joint 1; while it resisted with 4 N joint 2 could stay, with its Coulomb level of 1 N it cannot."""
        models = [JointFriction(Direction(c, 0.0, s), Direction(c, 0.0, s)) for c, s in ((1.0, 4.0), (0.5, 1.0))]
        reaction = [1.5 * (5.0 - f) / 3.5 for f in (4.0, 1.0)]  # on joint 2 at rest
        assert reaction[0] < 1.0 < reaction[1]
        run = simulate(sliders(), constant(5.0, 0.0), Still(np.zeros(2), 0.3), friction=models)
        ddq = np.linalg.solve(SLIDING, [5.0 - 1.0, 0.5])
        assert ddq[0] > 0 > ddq[1]
        np.testing.assert_allclose(run.q[-1], ddq * 0.3**2 / 2, rtol=0, atol=1e-12)
        held = simulate(sliders(), constant(3.9, 0.9), Still(np.zeros(2), 0.3), friction=models)
        assert (held.q == 0.0).all()

    @pytest.mark.slow
    @pytest.mark.parametrize("options", [{}, {"substeps": 2}, {"method": "dop853"}])
    def test_a_joint_at_rest_is_pushed_by_the_other_ones_motion(self, options):
        """A level arm: joint 1 swings, joint 2 is held until the swing's reaction exceeds break-away."""
        arm, dynamics = plane_arm(), lwr_dyn.dynamics_of(plane_arm(), "newton-euler")
        models = [symmetric(0.5, 0.1), JointFriction(Direction(0.4, 0.2, 0.6), Direction(0.5, 0.2, 0.7))]
        start, torque = np.array([0.0, 1.2]), lambda t: np.array([5.0 * np.sin(6.0 * t), 0.0])
        run = simulate(arm, lambda t, *state: torque(t), Still(start, 1.2), friction=models, continuous=True, **options)
        events, q_end = Phases(dynamics, models, torque).follow(start, 1.2)
        mine = [(e.kind, e.joint) for e in run.events]
        assert mine == [(kind, joint) for kind, joint, _ in events]
        assert ("slip", 1) in mine
        assert ("stick", 1) in mine
        np.testing.assert_allclose([e.t for e in run.events], [t for *_, t in events], rtol=0, atol=INSTANT)
        np.testing.assert_allclose(run.q[-1], q_end, rtol=0, atol=REFERENCE)

    @pytest.mark.slow
    @pytest.mark.parametrize("options", [{}, {"substeps": 2}, {"method": "dop853"}])
    def test_it_is_pushed_off_between_two_samples_of_a_held_torque(self, options):
        """A constant torque on joint 1: its growing speed throws joint 2 outward at a moment of its own."""
        models = [symmetric(0.5, 0.1), JointFriction(Direction(0.4, 0.2, 0.6), Direction(0.5, 0.2, 0.7))]
        start, torque = np.array([0.0, 1.2]), np.array([2.0, 0.0])
        run = simulate(plane_arm(), constant(*torque), Still(start, 1.2), friction=models, **options)
        reference = Phases(lwr_dyn.dynamics_of(plane_arm(), "newton-euler"), models, lambda t: torque)
        events, q_end = reference.follow(start, 1.2, signs=(1, 0))
        assert [(e.kind, e.joint) for e in run.events] == [event[:2] for event in events] == [("slip", 1)]
        assert run.events[0].t == pytest.approx(events[0][2], abs=INSTANT)
        np.testing.assert_allclose(run.q[-1], q_end, rtol=0, atol=REFERENCE)


class TestJointsWithoutFrictionBesideOthers:
    def test_one_that_turned_round_is_not_stopped_when_another_sticks(self):
        """Both happen within one sample; closed form, since the mass matrix of the sliders is constant."""
        t_stick, t_turn, load = 0.2006, 0.2003, np.array([0.5, -1.7])
        ddq = np.linalg.solve(SLIDING, load - [3.0, 0.0])
        speed = -ddq * np.array([t_stick, t_turn])
        assert (speed > 0).all()
        friction = [symmetric(3.0, 0.0), None]
        run = simulate(sliders(), constant(*load), Still(np.zeros(2), 0.4), dq0=speed, friction=friction)
        assert [(e.kind, e.joint) for e in run.events] == [("stick", 0)]
        s = 0.4 - t_stick
        q = speed * t_stick + ddq * t_stick**2 / 2
        at_stick, after = speed[1] + ddq[1] * t_stick, load[1] / SLIDING[1, 1]
        assert run.q[-1, 0] == pytest.approx(q[0], abs=1e-12)
        assert run.q[-1, 1] == pytest.approx(q[1] + at_stick * s + after * s**2 / 2, abs=1e-11)
        assert (run.tau_friction[:, 1] == 0.0).all()

    @pytest.mark.parametrize("offset", [0.0, 0.2])
    def test_a_viscous_joint_is_braked_from_rest_on(self, offset):
        smooth = JointFriction(Direction(0.0, 0.5), Direction(0.0, 0.5), offset=offset)
        run = simulate(sliders(), constant(4.0, 1.0), Still(np.zeros(2), 0.3), friction=[symmetric(3.0, 0.0), smooth])
        assert {e.joint for e in run.events} <= {0}
        np.testing.assert_allclose(run.tau_friction[:, 1], offset + 0.5 * run.dq[:, 1], rtol=0, atol=1e-15)
        assert np.abs(run.dq[-1, 1]) > 0.1
        assert audit(run).worst_energy <= 1e-11


SLIDING = np.array([[3.5, 1.5], [1.5, 1.5]])


def sliders():
    """Two sliding joints on one axis, of 2.0 and 1.5 kg: their mass matrix `SLIDING` is constant."""
    links = [
        ChainLink(
            f"joint_{i + 1}", f"link_{i + 1}", JointKind.PRISMATIC, Pose.identity(), Pose.identity(),
            Body(mass, np.zeros(3), mass * 0.01 * np.eye(3)),
        )
        for i, mass in enumerate((2.0, 1.5))
    ]  # fmt: skip
    return Arm(
        "sliders", "none", "two sliders", Chain(tuple(links), Pose.identity(), np.zeros(3)), (JointLimits(),) * 2
    )


LEVELS = np.array([20.0, 20.0, 8.0, 8.0, 0.3, 0.3, 0.1])


def test_the_lwr_with_friction_in_every_joint_balances_its_energy():
    wave = Sinusoids(np.array([0.0, 1.2, 0.0, -1.4, 0.0, 0.6, 0.0]), np.full(7, 0.1), np.linspace(3, 9, 7), 2.0)
    models = [JointFriction(Direction(f, 0.2 * f, 1.3 * f), Direction(0.8 * f, 0.1 * f, f)) for f in LEVELS]
    run = simulate(lwr(), controllers()["inverse-dynamics"], wave, friction=models)
    assert len([e for e in run.events if e.kind == "stick"]) >= 3
    assert audit(run).residual <= 1e-8
    assert (np.diff(run.work["friction"]) <= 1e-15).all()
