"""True stick: closed forms for one joint, its stops, and joints beside each other."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lwr_dyn
from lwr_dyn.model.arm import JointLimits
from lwr_dyn.model.friction import Direction, JointFriction, symmetric
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


def slid(torque=no_torque, duration=0.5, friction=(ASYMMETRIC,), speed=0.0, start=0.0, arm=None, **options):
    """A run of the slider of 2 kg, or another arm of one joint."""
    still = Still(np.full(1, start), duration)
    return simulate(arm or one_joint(), torque, still, dq0=[speed], friction=list(friction), **options)


@pytest.mark.slow
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("options", [{}, {"continuous": True}, {"method": "dop853"}, {"substeps": 3}])
@pytest.mark.parametrize("viscous", [0.0, 0.8])
def test_it_stops_at_the_time_and_place_of_the_closed_form(side, options, viscous):
    """m dv = -(F + c v): t = (m/c) ln(1 + c v0/F), or m v0/F without viscous friction."""
    mass, speed, force = 2.0, 0.7, 3.0 if side > 0 else 2.0
    model = JointFriction(Direction(3.0, viscous, 4.0), Direction(2.0, viscous))
    run = slid(duration=0.9, friction=[model], speed=side * speed, **options)
    if viscous:
        t = mass / viscous * np.log1p(viscous * speed / force)
        q = mass / viscous * (speed - force / viscous * np.log1p(viscous * speed / force))
    else:
        t, q = mass * speed / force, mass * speed**2 / (2 * force)
    assert kinds(run) == ["stick"]
    assert run.events[0].t == pytest.approx(t, abs=CLOSED_FORM)
    assert run.q[-1, 0] == pytest.approx(side * q, abs=CLOSED_FORM)
    after = run.t > t
    assert not np.any([run.dq[after], run.q[after] - run.q[-1], run.tau_friction[after]])
    assert run.work["friction"][-1] == pytest.approx(-mass * speed**2 / 2, abs=CLOSED_FORM)
    assert audit(run).worst_energy <= 1e-11


@pytest.mark.parametrize(("side", "level"), [(1.0, 4.0), (-1.0, 2.5)])
def test_below_break_away_not_a_bit_moves_and_above_it_only_coulomb_resists(side, level):
    held = slid(constant(0.99 * side * level), 5.0, start=0.123456789)
    assert not np.any([held.q - 0.123456789, held.dq, *(work[:, None] for work in held.work.values())])
    assert held.events == ()
    np.testing.assert_allclose(held.tau_friction, 0.99 * side * level, rtol=1e-15)
    run = slid(constant(1.01 * side * level))
    kinetic = ASYMMETRIC.positive if side > 0 else ASYMMETRIC.negative
    c, drive, mass = kinetic.viscous, 1.01 * level - kinetic.coulomb, 2.0
    expected = drive / c * (run.t - mass / c * -np.expm1(-c * run.t / mass))
    np.testing.assert_allclose(side * run.q[:, 0], expected, rtol=0, atol=CLOSED_FORM)
    assert abs(run.q[-1, 0]) > 0.01


def test_a_rising_torque_frees_it_at_the_right_moment():
    """Continuous torque 8 t: break-away at 4.0/8 s, then m ddq = 8 t - 3 without viscous friction."""
    model = JointFriction(Direction(3.0, 0.0, static=4.0), Direction(2.0, 0.0))
    run = slid(lambda t, *state: np.array([8.0 * t]), 1.0, [model], continuous=True)
    assert [(e.kind, e.value, e.t) for e in run.events] == [("slip", 1.0, pytest.approx(0.5, abs=1e-12))]
    s = run.t[run.t >= 0.5] - 0.5
    np.testing.assert_allclose(run.q[run.t >= 0.5, 0], (8 * s**3 / 6 + s**2 / 2) / 2, rtol=0, atol=CLOSED_FORM)


@pytest.mark.parametrize("options", [{}, {"continuous": True}, {"method": "dop853"}])
def test_it_reverses_without_sticking(options):
    """Thrown against a force above break-away: up m dv = -(F + 3), back m dv = -(F - 2)."""
    mass, speed, force = 2.0, 0.6, 5.0
    model = JointFriction(Direction(3.0, 0.0, static=4.0), Direction(2.0, 0.0, static=4.0))
    run = slid(constant(-force), 0.4, [model], speed, **options)
    t = mass * speed / (force + 3.0)
    assert kinds(run) == ["reverse"]
    assert run.events[0].t == pytest.approx(t, abs=CLOSED_FORM)
    turned = run.t > t
    q = speed * t / 2 - (force - 2.0) / mass * (run.t[turned] - t) ** 2 / 2
    np.testing.assert_allclose(run.q[turned, 0], q, rtol=0, atol=CLOSED_FORM)
    assert audit(run).worst_energy <= 1e-11


@pytest.mark.parametrize("method", ["rk4", "dop853"])
def test_a_touch_of_rest_within_one_step_is_seen(method):
    """Speed v0 - t + 1000 t^2 would pass zero and be back before the sample ends: it sticks until 3 N m again."""
    h, v0 = 1e-3, 2e-4
    run = slid(
        lambda t, *state: np.array([2.0 + 2000.0 * t]), h, [symmetric(3.0, 0.0)], v0, arm=one_joint(mass=1.0),
        continuous=True, method=method,
    )  # fmt: skip
    t = (1 - np.sqrt(1 - 4000 * v0)) / 2000
    assert kinds(run) == ["stick", "slip"]
    np.testing.assert_allclose([event.t for event in run.events], [t, 5e-4], rtol=0, atol=1e-12)
    assert run.dq[-1, 0] == pytest.approx(1000 * (h / 2) ** 2, abs=1e-12)
    q = v0 * t - t**2 / 2 + 1000 * t**3 / 3 + 1000 * (h / 2) ** 3 / 3
    assert run.q[-1, 0] == pytest.approx(q, abs=1e-14)


def test_stribeck_friction_slows_it_as_in_the_reference():
    run = slid(friction=[JointFriction(Direction(2.0, 0.3, 3.5, 0.2), Direction(2.0, 0.3))], speed=0.5, substeps=2)

    def rates(t, y):
        return [y[1], -(2.0 + 0.3 * y[1] + 1.5 * np.exp(-((y[1] / 0.2) ** 2))) / 2.0]

    def at_rest(t, y):
        return y[1]

    at_rest.terminal = True
    reference = solve_ivp(rates, (0, 1), [0.0, 0.5], "DOP853", rtol=1e-12, atol=1e-14, events=at_rest)
    assert run.events[0].t == pytest.approx(reference.t_events[0][0], abs=CLOSED_FORM)
    assert run.q[-1, 0] == pytest.approx(reference.y[0, -1], abs=CLOSED_FORM)


@pytest.mark.parametrize(
    ("torque", "ddq"), [(1.49, 0.0), (1.51, 0.01 / 2), (-0.49, 0.0), (-0.51, -0.01 / 2), (2.0, 0.25), (-2.0, -0.75)]
)
def test_an_offset_shifts_what_is_held(torque, ddq):
    run = slid(constant(torque), 0.1, [JointFriction(Direction(1.0, 0.0), Direction(1.0, 0.0), offset=0.5)])
    assert run.q[-1, 0] == pytest.approx(ddq * 0.1**2 / 2, abs=1e-14)


def test_a_motor_cut_below_break_away_moves_nothing():
    weak = one_joint(effort=3.9)
    run = slid(constant(100.0), 0.1, arm=weak)
    assert (run.q == 0.0).all()
    assert (run.tau_friction == 3.9).all()
    assert slid(constant(100.0), 0.1, arm=weak, saturate=False).q[-1, 0] > 0.1


def test_a_joint_runs_into_its_stop_stays_and_needs_more_than_friction_to_leave():
    def force(t, *state):
        return np.array([5.0 if t < 0.5 else -0.9 if t < 0.7 else -3.0])

    run = slid(force, 1.0, [symmetric(1.0, 0.0)], arm=one_joint(lower=-1.0, upper=0.2))
    moment = np.sqrt(2 * 0.2 * 2.0 / 4.0)
    assert [(event.kind, event.t) for event in run.events] == [
        ("stop", pytest.approx(moment, abs=1e-12)), ("stick", pytest.approx(moment, abs=1e-3)),
        ("release", pytest.approx(0.7, abs=1e-12)),
    ]  # fmt: skip
    resting = (run.t > moment) & (run.t <= 0.7)
    assert (run.q[resting] == 0.2).all()
    assert run.q[-1, 0] == pytest.approx(0.2 - 1.0 * 0.3**2 / 2, abs=CLOSED_FORM)
    assert (np.abs(run.tau_friction) <= 1.0).all()
    assert audit(run).worst_energy <= 1e-12


def moved(arm, torque, start, duration, friction, **options):
    """A run of several joints under a constant torque."""
    return simulate(arm, constant(*torque), Still(np.array(start), duration), friction=friction, **options)


def test_an_impact_jerks_joints_that_were_stuck():
    """No finite friction holds against an impulse; energy balances all the same."""
    arm = with_limits(plane_arm(), lower=-3.0, upper=0.3)
    run = moved(arm, (4.0, 0.0), [0.0, -0.5], 1.0, [symmetric(0.1, 0.0), symmetric(9.0, 0.2)])
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
    left = flow.advance(pushed, 0.0, np.array([0.25, -1e-20, 0.0, 0.0]), 0.5)  # by less than a float can show
    assert left.tolist() == [0.25, 0.0, 0.0, 0.0]
    unknown, counted = np.full(4, np.nan), flow.evaluations
    assert flow.begin(pushed, 0.0, unknown) is unknown
    assert (flow.evaluations, flow.on_stop.tolist()) == (counted, [False])


def test_a_joint_put_back_on_its_stop_leaves_it_later_in_the_same_interval():
    """It left by less than a float can show; the other one stops after 88 ms, and nothing holds it after 0.46 s."""
    arm = replace(sliders(), limits=(JointLimits(lower=-9.0, upper=0.25), JointLimits(lower=-9.0, upper=0.1)))
    flow = Flow(plant_of(arm, lwr_dyn.dynamics_of(arm)), rk4(200))

    def turning(t, q, dq, memory):
        return np.array([20.0 - 200.0 * t**3, 5.0]), np.zeros(0)

    y = flow.advance(turning, 0.0, np.array([0.25, 0.0, -1e-20, 1.0, 0.0, 0.0]), 0.5)
    assert [(e.kind, e.joint) for e in flow.events] == [("stop", 1), ("release", 0)]
    left = np.cbrt(0.1)  # until 0.5 s, with both masses
    back = 10.0 * (0.5**2 - left**2 - 0.5**5 + left**5) - (20.0 * left - 50.0 * left**4) * (0.5 - left)
    np.testing.assert_allclose(y[:2], [0.25 + back / 3.5, 0.1], rtol=1e-9)


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


@pytest.mark.parametrize(
    ("friction", "load", "t_stop", "duration", "kinds"),
    [([3.0, 2.0], [0.5, 0.2], 0.31237, 0.6, {"stick"}), ([1.0, 2.0], [-4.5, -2.3], 0.2, 0.5, {"reverse", "stick"})],
)
def test_both_stop_in_the_same_instant_and_stay_or_only_one_may(friction, load, t_stop, duration, kinds):
    """Two sliders on one axis have a constant mass matrix, so each phase is a parabola.

    Either load of the second case exceeds break-away; but joint 1, which turns back, takes enough off joint 2.
    """
    speed = np.linalg.solve(SLIDING, np.subtract(friction, load)) * t_stop
    run = moved(sliders(), load, [0.0, 0.0], duration, [symmetric(f, 0.0) for f in friction], dq0=speed)
    assert (speed > 0).all()
    assert [(e.t, e.joint) for e in run.events] == [(pytest.approx(t_stop, abs=1e-12), joint) for joint in (0, 1)]
    assert {e.kind for e in run.events} == kinds
    assert run.events[1].kind == "stick"
    back = np.array([(load[0] + friction[0]) / SLIDING[0, 0], 0.0]) * ("reverse" in kinds)
    place = speed * t_stop / 2 + back * (duration - t_stop) ** 2 / 2
    np.testing.assert_allclose(run.q[-1], place, rtol=0, atol=1e-11)
    held = load - SLIDING @ back
    np.testing.assert_allclose(run.tau_friction[-1, 1], held[1], rtol=0, atol=1e-12)
    if kinds == {"stick"}:
        assert (run.q[run.t > t_stop] == run.q[-1]).all()
        np.testing.assert_allclose(run.tau_friction[-1], load, rtol=0, atol=1e-14)


def test_the_rule_where_static_friction_exceeds_coulombs():
    """5 N frees joint 1; while it resisted with 4 N joint 2 could stay, with its Coulomb level of 1 N it cannot."""
    models = [JointFriction(Direction(c, 0.0, s), Direction(c, 0.0, s)) for c, s in ((1.0, 4.0), (0.5, 1.0))]
    reaction = [1.5 * (5.0 - f) / 3.5 for f in (4.0, 1.0)]  # on joint 2 at rest
    assert reaction[0] < 1.0 < reaction[1]
    ddq = np.linalg.solve(SLIDING, [5.0 - 1.0, 0.5])
    assert ddq[0] > 0 > ddq[1]
    run = moved(sliders(), (5.0, 0.0), [0.0, 0.0], 0.3, models)
    np.testing.assert_allclose(run.q[-1], ddq * 0.3**2 / 2, rtol=0, atol=1e-12)
    assert (moved(sliders(), (3.9, 0.9), [0.0, 0.0], 0.3, models).q == 0.0).all()


SWING = [symmetric(0.5, 0.1), JointFriction(Direction(0.4, 0.2, 0.6), Direction(0.5, 0.2, 0.7))]
"""Of a level arm: joint 1 moves, joint 2 is held until the reaction exceeds break-away."""


@pytest.mark.slow
@pytest.mark.parametrize("options", [{}, {"substeps": 2}, {"method": "dop853"}])
@pytest.mark.parametrize(
    ("torque", "signs"),
    [(lambda t: np.array([5.0 * np.sin(6.0 * t), 0.0]), (0, 0)), (lambda t: np.array([2.0, 0.0]), (1, 0))],
)
def test_a_joint_at_rest_is_pushed_by_the_other_ones_motion(torque, signs, options):
    """By its swing in a continuous run; by its growing speed between two samples of a held torque."""
    start, swings = np.array([0.0, 1.2]), signs == (0, 0)
    run = simulate(
        plane_arm(), lambda t, *state: torque(t), Still(start, 1.2), friction=SWING, continuous=swings, **options
    )
    events, q_end = Phases(lwr_dyn.dynamics_of(plane_arm(), "newton-euler"), SWING, torque).follow(start, 1.2, signs)
    mine = [(e.kind, e.joint) for e in run.events]
    assert mine == [(kind, joint) for kind, joint, _ in events]
    assert {("slip", 1), ("stick", 1)} <= set(mine) if swings else mine == [("slip", 1)]
    np.testing.assert_allclose([e.t for e in run.events], [t for *_, t in events], rtol=0, atol=INSTANT)
    np.testing.assert_allclose(run.q[-1], q_end, rtol=0, atol=REFERENCE)


def test_one_without_friction_that_turned_round_is_not_stopped_when_another_sticks():
    """Both happen within one sample; closed form, since the mass matrix of the sliders is constant."""
    t_stick, t_turn, load = 0.2006, 0.2003, np.array([0.5, -1.7])
    ddq = np.linalg.solve(SLIDING, load - [3.0, 0.0])
    speed = -ddq * np.array([t_stick, t_turn])
    assert (speed > 0).all()
    run = moved(sliders(), load, [0.0, 0.0], 0.4, [symmetric(3.0, 0.0), None], dq0=speed)
    assert [(e.kind, e.joint) for e in run.events] == [("stick", 0)]
    s = 0.4 - t_stick
    q = speed * t_stick + ddq * t_stick**2 / 2
    at_stick, after = speed[1] + ddq[1] * t_stick, load[1] / SLIDING[1, 1]
    np.testing.assert_allclose(run.q[-1], [q[0], q[1] + at_stick * s + after * s**2 / 2], rtol=0, atol=1e-11)
    assert (run.tau_friction[:, 1] == 0.0).all()


@pytest.mark.parametrize("offset", [0.0, 0.2])
def test_a_viscous_joint_beside_others_is_braked_from_rest_on(offset):
    smooth = JointFriction(Direction(0.0, 0.5), Direction(0.0, 0.5), offset=offset)
    run = moved(sliders(), (4.0, 1.0), [0.0, 0.0], 0.3, [symmetric(3.0, 0.0), smooth])
    assert {e.joint for e in run.events} <= {0}
    np.testing.assert_allclose(run.tau_friction[:, 1], offset + 0.5 * run.dq[:, 1], rtol=0, atol=1e-15)
    assert np.abs(run.dq[-1, 1]) > 0.1
    assert audit(run).worst_energy <= 1e-11


SLIDING = np.array([[3.5, 1.5], [1.5, 1.5]])


def sliders():
    """Two sliding joints on one axis, of 2.0 and 1.5 kg: their mass matrix `SLIDING` is constant."""
    one, other = (one_joint(mass=mass).chain.links[0] for mass in (2.0, 1.5))
    other = replace(other, joint="joint_2", link="link_2")
    return replace(one_joint(), chain=replace(one_joint().chain, links=(one, other)), limits=(JointLimits(),) * 2)


LEVELS = np.array([20.0, 20.0, 8.0, 8.0, 0.3, 0.3, 0.1])


def test_the_lwr_with_friction_in_every_joint_balances_its_energy():
    wave = Sinusoids(np.array([0.0, 1.2, 0.0, -1.4, 0.0, 0.6, 0.0]), np.full(7, 0.1), np.linspace(3, 9, 7), 2.0)
    models = [JointFriction(Direction(f, 0.2 * f, 1.3 * f), Direction(0.8 * f, 0.1 * f, f)) for f in LEVELS]
    run = simulate(lwr(), controllers()["inverse-dynamics"], wave, friction=models)
    assert len([e for e in run.events if e.kind == "stick"]) >= 3
    assert audit(run).residual <= 1e-8
    assert (np.diff(run.work["friction"]) <= 1e-15).all()
