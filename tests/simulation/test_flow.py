"""True stick: closed forms for one joint, and its stops; several joints: `test_flow_of_several_joints.py`."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lwr_dyn
from lwr_dyn.model.friction import Direction, JointFriction, symmetric
from lwr_dyn.simulation.audit import audit
from lwr_dyn.simulation.flow import Flow
from lwr_dyn.simulation.integrators import rk4
from lwr_dyn.simulation.plant import plant_of
from lwr_dyn.simulation.simulate import no_torque, simulate
from tests.simulation.sample_runs import Still, one_joint, with_limits
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
