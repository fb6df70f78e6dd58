"""True stick: closed forms for one joint, and its stops; several joints: `test_flow_of_several_joints.py`."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lwr_dyn
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Body, Chain, ChainLink, JointKind
from lwr_dyn.model.friction import Direction, JointFriction, symmetric
from lwr_dyn.model.spatial import Pose
from lwr_dyn.simulation.audit import audit
from lwr_dyn.simulation.flow import Flow
from lwr_dyn.simulation.integrators import rk4
from lwr_dyn.simulation.plant import plant_of
from lwr_dyn.simulation.simulate import no_torque, simulate
from tests.simulation.phases import Phases
from tests.simulation.sample_runs import Sinusoids, Still, controllers, lwr, one_joint, with_limits
from tests.simulation.stick_cases import constant, kinds, plane_arm

CLOSED_FORM = 1e-10
"""[s] and [rad], largest error of a joint that stops."""
ASYMMETRIC = JointFriction(Direction(3.0, 0.5, static=4.0), Direction(2.0, 1.5, static=2.5))


class TestOneJoint:
    @pytest.mark.slow
    @pytest.mark.parametrize("side", [1.0, -1.0])
    @pytest.mark.parametrize("options", [{}, {"continuous": True}, {"method": "dop853"}, {"substeps": 3}])
    @pytest.mark.parametrize("viscous", [0.0, 0.8])
    def test_it_stops_at_the_time_and_place_of_the_closed_form(self, side, options, viscous):
        """m dv = -(F + c v): t = (m/c) ln(1 + c v0/F), or m v0/F without viscous friction."""
        mass, speed = 2.0, 0.7
        force = 3.0 if side > 0 else 2.0
        models = [JointFriction(Direction(3.0, viscous, 4.0), Direction(2.0, viscous))]
        run = simulate(
            one_joint(mass=mass),
            no_torque,
            Still(np.zeros(1), 0.9),
            dq0=[side * speed],
            friction=models,
            **options,
        )
        if viscous:
            t = mass / viscous * np.log1p(viscous * speed / force)
            q = mass / viscous * (speed - force / viscous * np.log1p(viscous * speed / force))
        else:
            t, q = mass * speed / force, mass * speed**2 / (2 * force)
        assert kinds(run) == ["stick"]
        assert run.events[0].t == pytest.approx(t, abs=CLOSED_FORM)
        assert run.q[-1, 0] == pytest.approx(side * q, abs=CLOSED_FORM)
        after = run.t > t
        assert (run.dq[after] == 0.0).all()
        assert (run.q[after] == run.q[-1]).all()
        assert (run.tau_friction[after] == 0.0).all()
        assert run.work["friction"][-1] == pytest.approx(-mass * speed**2 / 2, abs=CLOSED_FORM)
        assert audit(run).worst_energy <= 1e-11

    @pytest.mark.slow
    @pytest.mark.parametrize(("side", "level"), [(1.0, 4.0), (-1.0, 2.5)])
    def test_below_break_away_not_a_bit_moves_in_a_minute(self, side, level):
        start = 0.123456789
        run = simulate(
            one_joint(), constant(0.99 * side * level), Still(np.full(1, start), 60.0), friction=[ASYMMETRIC]
        )
        assert (run.q == start).all()
        assert (run.dq == 0.0).all()
        assert run.events == ()
        np.testing.assert_allclose(run.tau_friction, 0.99 * side * level, rtol=1e-15)
        assert all((work == 0.0).all() for work in run.work.values())

    @pytest.mark.parametrize(("side", "level"), [(1.0, 4.0), (-1.0, 2.5)])
    def test_above_it_moves_and_then_only_coulomb_resists(self, side, level):
        run = simulate(one_joint(), constant(1.01 * side * level), Still(np.zeros(1), 0.5), friction=[ASYMMETRIC])
        kinetic = ASYMMETRIC.positive if side > 0 else ASYMMETRIC.negative
        c, drive, mass = kinetic.viscous, 1.01 * level - kinetic.coulomb, 2.0
        expected = drive / c * (run.t - mass / c * -np.expm1(-c * run.t / mass))
        np.testing.assert_allclose(side * run.q[:, 0], expected, rtol=0, atol=CLOSED_FORM)
        assert abs(run.q[-1, 0]) > 0.01

    def test_a_rising_torque_frees_it_at_the_right_moment(self):
        """Continuous torque 8 t: break-away at 4.0/8 s, then m ddq = 8 t - 3 without viscous friction."""
        models = [JointFriction(Direction(3.0, 0.0, static=4.0), Direction(2.0, 0.0))]
        run = simulate(
            one_joint(), lambda t, *state: np.array([8.0 * t]), Still(np.zeros(1), 1.0), friction=models,
            continuous=True,
        )  # fmt: skip
        (slip,) = run.events
        assert (slip.kind, slip.value) == ("slip", 1.0)
        assert slip.t == pytest.approx(0.5, abs=1e-12)
        s = 0.5
        assert run.q[-1, 0] == pytest.approx((8 * s**3 / 6 + (4.0 - 3.0) * s**2 / 2) / 2.0, abs=CLOSED_FORM)

    @pytest.mark.parametrize("options", [{}, {"continuous": True}, {"method": "dop853"}])
    def test_it_reverses_without_sticking(self, options):
        """Thrown against a force above break-away: up m dv = -(F + 3), back m dv = -(F - 2)."""
        mass, speed, force = 2.0, 0.6, 5.0
        models = [JointFriction(Direction(3.0, 0.0, static=4.0), Direction(2.0, 0.0, static=4.0))]
        run = simulate(
            one_joint(mass=mass),
            constant(-force),
            Still(np.zeros(1), 0.4),
            dq0=[speed],
            friction=models,
            **options,
        )
        t = mass * speed / (force + 3.0)
        assert kinds(run) == ["reverse"]
        assert run.events[0].t == pytest.approx(t, abs=CLOSED_FORM)
        turned = run.t > t
        q = speed * t / 2 - (force - 2.0) / mass * (run.t[turned] - t) ** 2 / 2
        np.testing.assert_allclose(run.q[turned, 0], q, rtol=0, atol=CLOSED_FORM)
        assert audit(run).worst_energy <= 1e-11

    @pytest.mark.parametrize("method", ["rk4", "dop853"])
    def test_a_touch_of_rest_within_one_step_is_seen(self, method):
        """Speed v0 - t + 1000 t^2 would pass zero and be back before the sample ends: it sticks until 3 N m again."""
        h, v0 = 1e-3, 2e-4
        run = simulate(
            one_joint(mass=1.0), lambda t, *state: np.array([2.0 + 2000.0 * t]), Still(np.zeros(1), h), dq0=[v0],
            friction=[symmetric(3.0, 0.0)], continuous=True, method=method,
        )  # fmt: skip
        t = (1 - np.sqrt(1 - 4000 * v0)) / 2000
        assert kinds(run) == ["stick", "slip"]
        np.testing.assert_allclose([event.t for event in run.events], [t, 5e-4], rtol=0, atol=1e-12)
        assert run.dq[-1, 0] == pytest.approx(1000 * (h / 2) ** 2, abs=1e-12)
        q = v0 * t - t**2 / 2 + 1000 * t**3 / 3 + 1000 * (h / 2) ** 3 / 3
        assert run.q[-1, 0] == pytest.approx(q, abs=1e-14)

    def test_stribeck_friction_slows_it_as_in_the_reference(self):
        model = JointFriction(Direction(2.0, 0.3, 3.5, 0.2), Direction(2.0, 0.3))
        run = simulate(one_joint(), no_torque, Still(np.zeros(1), 0.5), dq0=[0.5], friction=[model], substeps=2)

        def rates(t, y):
            return [y[1], -(2.0 + 0.3 * y[1] + 1.5 * np.exp(-((y[1] / 0.2) ** 2))) / 2.0]

        def at_rest(t, y):
            return y[1]

        at_rest.terminal = True
        reference = solve_ivp(rates, (0, 1), [0.0, 0.5], "DOP853", rtol=1e-12, atol=1e-14, events=at_rest)
        assert run.events[0].t == pytest.approx(reference.t_events[0][0], abs=CLOSED_FORM)
        assert run.q[-1, 0] == pytest.approx(reference.y[0, -1], abs=CLOSED_FORM)

    def test_an_offset_shifts_what_is_held(self):
        model = JointFriction(Direction(1.0, 0.0), Direction(1.0, 0.0), offset=0.5)
        for torque, moves in ((1.49, False), (1.51, True), (-0.49, False), (-0.51, True)):
            run = simulate(one_joint(), constant(torque), Still(np.zeros(1), 0.1), friction=[model])
            assert (run.q[-1, 0] != 0.0) == moves
        for torque, ddq in ((2.0, 0.5 / 2), (-2.0, -1.5 / 2)):
            run = simulate(one_joint(), constant(torque), Still(np.zeros(1), 0.1), friction=[model])
            assert run.q[-1, 0] == pytest.approx(ddq * 0.1**2 / 2, abs=1e-14)

    def test_a_motor_cut_below_break_away_moves_nothing(self):
        run = simulate(one_joint(effort=3.9), constant(100.0), Still(np.zeros(1), 0.1), friction=[ASYMMETRIC])
        assert (run.q == 0.0).all()
        assert (run.tau_friction == 3.9).all()
        free = simulate(
            one_joint(effort=3.9), constant(100.0), Still(np.zeros(1), 0.1), friction=[ASYMMETRIC], saturate=False
        )
        assert free.q[-1, 0] > 0.1


class TestStops:
    def test_a_joint_runs_into_its_stop_stays_and_needs_more_than_friction_to_leave(self):
        arm = one_joint(lower=-1.0, upper=0.2)
        models = [symmetric(1.0, 0.0)]

        def force(t, *state):
            return np.array([5.0 if t < 0.5 else -0.9 if t < 0.7 else -3.0])

        run = simulate(arm, force, Still(np.zeros(1), 1.0), friction=models)
        stop, stick, release = run.events
        assert (stop.kind, stick.kind, release.kind) == ("stop", "stick", "release")
        assert stop.t == pytest.approx(np.sqrt(2 * 0.2 * 2.0 / 4.0), abs=1e-12)
        assert release.t == pytest.approx(0.7, abs=1e-12)
        resting = (run.t > stop.t) & (run.t <= 0.7)
        assert (run.q[resting] == 0.2).all()
        assert run.q[-1, 0] == pytest.approx(0.2 - 1.0 * 0.3**2 / 2, abs=CLOSED_FORM)
        assert (np.abs(run.tau_friction) <= 1.0).all()
        assert audit(run).worst_energy <= 1e-12

    def test_an_impact_jerks_joints_that_were_stuck(self):
        """No finite friction holds against an impulse; energy balances all the same."""
        arm = with_limits(plane_arm(), lower=-3.0, upper=0.3)
        run = simulate(
            arm,
            constant(4.0, 0.0),
            Still(np.array([0.0, -0.5]), 1.0),
            friction=[symmetric(0.1, 0.0), symmetric(9.0, 0.2)],
        )
        assert kinds(run, 0)[:2] == ["slip", "stop"] or kinds(run, 0)[:1] == ["stop"]
        assert "slip" in kinds(run, 1)
        assert (run.q <= 0.3).all()
        assert audit(run).worst_energy <= 1e-9


def test_one_interval_with_an_impact_has_its_moment_its_work_and_its_rest():
    arm = one_joint(mass=2.0, lower=-1.0, upper=0.25)
    flow = Flow(plant_of(arm, lwr_dyn.dynamics_of(arm)), rk4(1))

    def pushed(t, q, dq, memory):
        return np.array([8.0]), np.zeros(0)

    y = flow.advance(pushed, 0.0, np.array([0.0, 1.0, 0.0, 0.0]), 0.5)
    moment = (-1.0 + np.sqrt(1.0 + 8.0 * 0.25)) / 4.0  # 0.25 = t + 2 t^2
    (event,) = [event for event in flow.events if event.kind == "stop"]
    assert event.t == pytest.approx(moment, abs=1e-12)
    assert y[:2].tolist() == [0.25, 0.0]
    kinetic = 0.5 * 2.0 * (1.0 + 4.0 * moment) ** 2
    assert event.value == pytest.approx(kinetic, rel=1e-10)
    assert flow.stop_work == pytest.approx(-kinetic, rel=1e-10)
    assert y[2] == pytest.approx(8.0 * 0.25, rel=1e-10)  # the motor's work until the stop, none after it


@pytest.mark.parametrize(("half", "is_followed"), [(1e-5, False), (1e-3, True)])
def test_fifty_impacts_in_one_interval_are_followed(half, is_followed):
    """A force that turns round at each stop drives a joint of 2 kg to and fro in its range, without friction."""
    arm = one_joint(mass=2.0, lower=-half, upper=half)
    flow = Flow(plant_of(arm, lwr_dyn.dynamics_of(arm)), rk4(1))

    def turning_round(t, q, dq, memory):
        stops = sum(event.kind == "stop" for event in flow.events)
        return np.array([8.0 * (-1) ** stops]), np.zeros(0)

    y = flow.advance(turning_round, 0.0, np.array([-half, 0.0, 0.0, 0.0]), 0.5)
    kinds, crossing = [event.kind for event in flow.events], np.sqrt(half)  # 2 half = 4 t^2 / 2
    assert np.isfinite(y).all()
    assert ("more events than followed" in kinds) != is_followed
    assert kinds.count("stop") == (int(0.5 / crossing) if is_followed else 50)
    if not is_followed:
        assert flow.events[-1].t == pytest.approx(50 * crossing, rel=1e-6)


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
