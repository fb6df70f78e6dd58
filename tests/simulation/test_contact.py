"""Position stops: against closed forms, against the formula of the impact, and never a joint beyond its limit."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.simulation import contact
from lwr_dyn.simulation.arm_friction import chosen_friction
from lwr_dyn.simulation.audit import audit, other_road
from lwr_dyn.simulation.contact import contact_mode, impact, resolve_stick_slip
from lwr_dyn.simulation.integrators import rk4
from lwr_dyn.simulation.plant import plant_of
from lwr_dyn.simulation.simulate import no_torque, simulate
from tests.random_arms import random_arm
from tests.simulation import sample_runs

STOPPED = sample_runs.one_joint(mass=2.0, lower=-1.0, upper=0.0)
"""A slider at its upper stop."""


def at_stops(seed):
    """A random arm with two or more joints at limits, moving any way."""
    rng = np.random.default_rng(seed)
    arm = random_arm(seed, "RRPRR")
    q = rng.uniform(-1, 1, 5)
    side = rng.integers(-1, 2, 5)
    side[:2] = rng.choice([-1, 1], 2)
    limited = sample_runs.with_limits(arm, lower=-9.0, upper=9.0)
    plant = plant_of(limited, lwr_dyn.dynamics_of(limited))
    object.__setattr__(plant, "upper", np.where(side > 0, q, 9.0))
    object.__setattr__(plant, "lower", np.where(side < 0, q, -9.0))
    return plant, q, rng.uniform(-2, 2, 5), side, rng


@given(st.integers(0, 10**6))
def test_impact_is_inelastic_and_its_work_is_the_lost_energy(seed):
    plant, q, dq, side, _ = at_stops(seed)
    B = plant.dynamics.mass_matrix(q)
    hit = impact(plant, q, dq)
    push = B @ (hit.dq - dq)
    scale = np.abs(B).max()
    assert (side * hit.dq <= 1e-9).all()  # no joint goes on outward
    assert (side * push <= 1e-9 * scale).all()  # stops push inward only
    assert np.abs(push[side == 0]).max(initial=0.0) <= 1e-9 * scale
    assert (hit.dq[hit.stopped] == 0.0).all()
    lost = (dq @ B @ dq - hit.dq @ B @ hit.dq) / 2
    assert -hit.work.sum() == pytest.approx(lost, abs=1e-9 * scale)
    assert lost >= -1e-9 * scale


def test_impact_of_one_joint_is_the_formula():
    plant, dynamics = plant_of(sample_runs.lwr(), sample_runs.lwr_dynamics()), sample_runs.lwr_dynamics()
    q, dq = sample_runs.MIDDLE.copy(), np.linspace(-0.5, 1.0, 7)
    q[3], dq[3] = plant.lower[3], -0.7
    B_inv = np.linalg.inv(dynamics.mass_matrix(q))
    effective, hit = 1.0 / B_inv[3, 3], impact(plant, q, dq)
    np.testing.assert_allclose(hit.dq, dq - B_inv[:, 3] * effective * dq[3], rtol=0, atol=1e-12)
    assert -hit.work.sum() == pytest.approx(effective * dq[3] ** 2 / 2, rel=1e-12)
    assert hit.stopped.tolist() == [False] * 3 + [True] + [False] * 3


@given(st.integers(0, 10**6))
def test_held_joints_are_pushed_outward_and_the_others_leave(seed):
    plant, q, _, side, rng = at_stops(seed)
    still, tau = np.zeros(5), rng.uniform(-20, 20, 5)
    mode = contact_mode(plant, q, resolve_stick_slip(plant, q, still, tau, np.zeros(5, dtype=int)))
    ddq = mode.accelerator()(q, still, tau)
    push = -mode.holding_torque(q, still, tau, ddq)
    assert (mode.at_rest <= (side != 0)).all()
    assert (side * push <= 1e-9).all()
    assert (side * ddq <= 1e-9 * np.abs(ddq).max(initial=1.0)).all()
    np.testing.assert_allclose(plant.dynamics.forward_dynamics(q, still, tau + push), ddq, rtol=1e-8, atol=1e-8)


def push_with(torque):
    return lambda t, q, dq, q_ref, dq_ref, ddq_ref: np.array([torque(t)])


@pytest.mark.slow
@pytest.mark.parametrize("method", ["rk4", "dop853"])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_slider_meets_its_stop_rests_and_leaves_on_time(method, side):
    arm = sample_runs.one_joint(mass=2.0, lower=-0.3, upper=0.3)
    force = push_with(lambda t: side * (4.0 if t < 0.7504 else -2.0))  # the sample at 0.751 is the first after it
    run = simulate(arm, force, sample_runs.Still(np.zeros(1), 1.0), method=method)
    stop, release = run.events
    assert (stop.kind, stop.t) == ("stop", pytest.approx(np.sqrt(2 * 0.3 / 2.0), abs=1e-12))
    assert stop.value == pytest.approx(4.0 * 0.3, abs=1e-12)  # all the work the force has done
    assert (release.kind, release.t) == ("release", 0.751)
    resting = (run.t > stop.t) & (run.t < release.t)
    assert not np.any([run.q[resting] - side * 0.3, run.dq[resting]])
    assert run.q[-1, 0] == pytest.approx(side * (0.3 - 0.5 * (1.0 - release.t) ** 2), abs=1e-12)
    assert run.work["stop"][-1] == pytest.approx(-stop.value, abs=1e-12)
    assert audit(run).worst_energy <= 1e-12


def test_a_release_between_samples_is_found_when_the_controller_is_continuous():
    run = simulate(STOPPED, push_with(lambda t: 1.0 - t / 0.4567), sample_runs.Still(np.zeros(1), 1.0), continuous=True)
    assert [(e.kind, e.t) for e in run.events] == [("release", pytest.approx(0.4567, abs=1e-9))]
    assert run.q[-1, 0] == pytest.approx(-((1.0 - 0.4567) ** 3) / (6 * 2.0 * 0.4567), abs=1e-10)
    assert audit(run).residual <= 1e-10


def test_no_joint_of_the_lwr_is_ever_beyond_its_limit():
    arm = sample_runs.with_limits(sample_runs.lwr(), lower=-1.7, upper=1.4)
    wave = sample_runs.joint_waves(1.0)
    wide = sample_runs.Sinusoids(sample_runs.MIDDLE, 3 * wave.amplitude, 8 * wave.w, 1.0)
    run = simulate(sample_runs.lwr(), sample_runs.controllers()["pd-gravity"], wide, plant=arm)
    stops = [event for event in run.events if event.kind == "stop"]
    assert len(stops) >= 5
    assert len({event.joint for event in stops}) >= 2
    assert -1.7 <= run.q.min() < run.q.max() == 1.4  # the loop puts it exactly there
    assert run.work["stop"][-1] == pytest.approx(-sum(event.value for event in stops), abs=1e-9)


def test_two_joints_at_once():
    """Both sliders of one axis reach their stops in the same instant, and rest."""
    arm = random_arm(3, "PP")
    dynamics, speed = lwr_dyn.dynamics_of(arm), np.array([0.5, 0.5])

    def keep_speed(t, q, dq, *reference):
        return dynamics.inverse_dynamics(q, dq, np.zeros(2)) + 5.0 * speed

    plant = sample_runs.with_limits(arm, lower=-0.05, upper=0.05)
    run = simulate(plant, keep_speed, sample_runs.Still(np.zeros(2), 0.3), dq0=speed)
    assert {event.joint for event in run.events if event.kind == "stop"} == {0, 1}
    assert (run.q <= 0.05).all()
    assert audit(run).worst_energy <= 1e-9


def test_a_start_at_a_limit_with_outward_speed_is_an_impact_at_once_and_without_limits_it_goes_on():
    run, free = (
        simulate(STOPPED, no_torque, sample_runs.Still(np.zeros(1), 0.01), dq0=[3.0], position_limits=limits)
        for limits in (True, False)
    )
    assert [(event.kind, event.t, event.value) for event in run.events] == [
        ("stop", 0.0, pytest.approx(9.0, rel=1e-15))
    ]
    assert (run.q == 0.0).all()
    assert audit(run).residual <= 1e-12
    assert (free.q[-1, 0], free.events) == (pytest.approx(0.03, rel=1e-12), ())


@pytest.mark.parametrize(
    ("torque", "guess", "speed", "expected"),
    [(1.0, 0, 0.0, 0), (1.0, -1, 0.0, 0), (-1.0, 0, 0.0, -1), (0.0, 0, 0.0, 0), (0.0, -1, 0.0, -1), (1.0, 0, -0.1, -1)],
)
def test_which_joint_rests_at_its_stop(torque, guess, speed, expected):
    """Pushed outward it rests, inward it leaves, by itself; only on the border the guess decides."""
    plant = plant_of(STOPPED, lwr_dyn.dynamics_of(STOPPED))
    given = (np.array([x]) for x in (speed, torque, guess))
    assert resolve_stick_slip(plant, np.zeros(1), *given).tolist() == [expected]


@pytest.mark.parametrize("options", [{"continuous": True}, {"continuous": True, "method": "dop853"}, {}])
def test_a_joint_at_its_stop_is_pushed_outward_from_nothing(options):
    """At first no torque holds it there, so it might leave; it does not, and no event is made of it."""
    run = simulate(STOPPED, push_with(lambda t: 3.0 * t), sample_runs.Still(np.zeros(1), 0.1), **options)
    assert ((run.q == 0.0).all(), run.events) == (True, ())


def test_sticking_joints_of_the_wam_are_held():
    arm = lwr_dyn.load("wam7")
    controller = lwr_dyn.controller("pd-gravity", arm, own_gains=True)
    wave = sample_runs.Sinusoids(
        np.array([0, 0.5, 0, 1.5, 0, 0, 0]), np.full(7, 0.05), np.array([2, 4, 6, 2, 4, 6, 2.0]), 0.4
    )
    run = simulate(arm, controller, wave)
    result = other_road(run)
    assert (run.dq == 0.0).any(axis=1).mean() > 0.2
    assert result.share <= 1.0
    assert result.eventful > 3
    for where in (run.dq == 0.0, run.dq != 0.0):
        assert other_road(replace(run, tau_friction=run.tau_friction + 1e-6 * where)).share > 10.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_joint_that_leans_on_its_stop_is_held_and_not_by_friction(side):
    arm = sample_runs.one_joint(mass=2.0, lower=min(-side, 0.0), upper=max(-side, 0.0))
    run = simulate(arm, lambda *_: np.array([3.0 * side]), sample_runs.Still(np.zeros(1), 0.02))
    road = run.audit["inverse_dynamics"]
    assert (road["closed"], road["residual"], road["gap"], road["judged"]) == (True, 0.0, 0.0, 20)


STEP, SPEED, BRAKE = 0.01, 2.0, 300.0
"""[s], [m/s], [m/s^2] of a slider that turns back within one step."""
MOMENT = 1e-14
"""[s] Root finding to 1e-15 of a parabola that RK4 follows to rounding."""


def slider(**limits):
    """A slider of 2 kg with Coulomb friction of 3 N, static 4 N."""
    arm = sample_runs.one_joint(**limits)
    both = Direction(3.0, 0.0, static=4.0)
    return plant_of(arm, lwr_dyn.dynamics_of(arm), chosen_friction(arm, [JointFriction(both, both)]))


def interval(speed=SPEED, acceleration=-BRAKE, h=STEP):
    def rates(t, y):
        return np.array([y[1], acceleration])

    return contact.Interval(rk4(1), rates, 0.0, h, np.array([0.0, speed]))


def none_holds(s):
    raise AssertionError("no joint is at rest")


def none_moves(t, y):
    raise AssertionError("all joints are at rest")


def found(mode, motion, holding=none_holds, barred=False):
    """The possible events of an interval of motion."""
    return contact.possible_events(mode, motion, motion.later(STEP), np.array([barred]), holding)


def mode(plant, side):
    return contact_mode(plant, np.zeros(1), np.array([side]))


def test_the_state_within_an_interval_is_the_parabola_and_is_kept():
    motion = interval()
    later = motion.later(0.004)
    np.testing.assert_allclose(later, [SPEED * 0.004 - BRAKE * 0.004**2 / 2, SPEED - BRAKE * 0.004], rtol=1e-14)
    assert motion.later(0.004) is later
    assert motion.later(0.0) is motion.y


@pytest.mark.parametrize("side", [1, -1])
def test_a_joint_past_its_limit_was_there_at_the_moment_of_the_parabola(side):
    motion = interval(side * SPEED, side * BRAKE)
    (event,) = found(mode(slider(lower=-0.03, upper=0.03), side), motion)
    assert (event.kind, event.joint, event.side) == ("stop", 0, side)
    crossing = contact.earliest([event])
    assert crossing.after == pytest.approx((-SPEED + np.sqrt(SPEED**2 + 2 * BRAKE * 0.03)) / BRAKE, abs=MOMENT)


def test_a_joint_that_is_braked_sticks_where_its_speed_is_zero_or_where_it_dips_below_zero():
    motion = interval()
    (event,) = found(mode(slider(), 1), motion)
    assert (event.kind, event.joint, event.side) == ("stick", 0, 0)
    assert contact.earliest([event]).after == pytest.approx(SPEED / BRAKE, abs=MOMENT)

    def rates(t, y):
        return np.array([y[1], 2 * 4e4 * (t - STEP / 2)])

    dip = contact.Interval(rk4(1), rates, 0.0, STEP, np.array([0.0, 0.9]))  # slowest 0.9 - 1.0 m/s, at half the step
    assert dip.later(STEP)[1] > 0.0
    (event,) = found(mode(slider(), 1), dip)
    assert contact.earliest([event]).after == pytest.approx(STEP / 2 - np.sqrt(0.1 / 4e4), abs=1e-12)


@pytest.mark.parametrize("side", [1, -1])
def test_a_joint_at_rest_slips_where_its_holding_torque_passes_the_static_level(side):
    rest, motion = mode(slider(), 0), contact.Interval(lambda rates, t, y, s: y, none_moves, 0.0, STEP, np.zeros(2))

    def ramp(s):
        return np.array([side * 8.0 * s / STEP])

    (event,) = found(rest, motion, ramp)
    assert (event.kind, event.side) == ("slip", side)
    assert contact.earliest([event]).after == pytest.approx(STEP / 2, abs=1e-12)
    assert found(rest, motion, ramp, barred=True) == []
    assert found(rest, motion, lambda s: ramp(s) / 2.1) == []


def test_the_first_of_several_events_is_chosen_and_a_start_on_the_root_is_left_or_is_the_answer():
    def at(moment, joint):
        return contact.EventFunction("stop", joint, 1, lambda s: s - moment, STEP)

    crossing = contact.earliest([at(0.006, 0), at(0.002, 1), at(0.004, 2), at(0.5, 3)])
    assert (crossing.event.joint, crossing.after) == (1, pytest.approx(0.002, abs=MOMENT))
    assert (contact.earliest([at(0.5, 3)]), contact.earliest([])) == (None, None)
    assert contact.first_root(lambda s: s * (s - 0.5), 1.0) == pytest.approx(0.5, abs=MOMENT)
    assert contact.first_root(lambda s: s, 1.0) == 0.0


def test_a_whole_turn_in_a_step_and_numbers_that_are_not_finite_cannot_be_followed():
    fastest = contact.TURN / STEP
    speeds = ([0.0, -fastest], [0.0, fastest * 1.001], [0.0, -1.001 * fastest], [np.nan, 0.0], [0.0, np.inf])
    assert [contact.followable(np.array(y), 1, STEP) for y in speeds] == [True] + [False] * 4
