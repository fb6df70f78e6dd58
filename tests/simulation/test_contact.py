"""Position stops: against closed forms, against the formula of the impact, and never a joint beyond its limit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.simulation.audit import audit
from lwr_dyn.simulation.contact import contact_mode, impact, resolve_stick_slip
from lwr_dyn.simulation.plant import plant_of
from lwr_dyn.simulation.simulate import no_torque, simulate
from tests.random_arms import random_arm
from tests.simulation.sample_runs import (
    MIDDLE,
    Sinusoids,
    Still,
    controllers,
    joint_waves,
    lwr,
    lwr_dynamics,
    one_joint,
    with_limits,
)

BEYOND = 1e-9
"""[rad] A joint may be past its limit by no more; the loop puts it exactly there."""


def at_stops(seed):
    """A random arm with two or more joints at limits, moving any way."""
    rng = np.random.default_rng(seed)
    arm = random_arm(seed, "RRPRR")
    q = rng.uniform(-1, 1, 5)
    side = rng.integers(-1, 2, 5)
    side[:2] = rng.choice([-1, 1], 2)
    limited = with_limits(arm, lower=-9.0, upper=9.0)
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
    plant = plant_of(lwr(), lwr_dynamics())
    q, dq = MIDDLE.copy(), np.linspace(-0.5, 1.0, 7)
    q[3], dq[3] = plant.lower[3], -0.7
    B_inv, J = np.linalg.inv(lwr_dynamics().mass_matrix(q)), np.eye(7)[3:4]
    effective = np.linalg.inv(J @ B_inv @ J.T)
    hit = impact(plant, q, dq)
    np.testing.assert_allclose(hit.dq, dq - B_inv @ J.T @ effective @ J @ dq, rtol=0, atol=1e-12)
    assert -hit.work.sum() == pytest.approx(float((J @ dq) @ effective @ (J @ dq)) / 2, rel=1e-12)
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
    arm = one_joint(mass=2.0, lower=-0.3, upper=0.3)
    switch = 0.7504  # the sample at 0.751 is the first after it

    def force(t):
        return side * (4.0 if t < switch else -2.0)

    run = simulate(arm, push_with(force), Still(np.zeros(1), 1.0), method=method)
    stop, release = run.events
    assert stop.kind == "stop"
    assert stop.t == pytest.approx(np.sqrt(2 * 0.3 / 2.0), abs=1e-12)
    assert stop.value == pytest.approx(4.0 * 0.3, abs=1e-12)  # all the work the force has done
    assert (release.kind, release.t) == ("release", 0.751)
    resting = (run.t > stop.t) & (run.t < release.t)
    assert (run.q[resting] == side * 0.3).all()
    assert (run.dq[resting] == 0.0).all()
    assert run.q[-1, 0] == pytest.approx(side * (0.3 - 0.5 * (1.0 - release.t) ** 2), abs=1e-12)
    assert run.work["stop"][-1] == pytest.approx(-stop.value, abs=1e-12)
    assert audit(run).worst_energy <= 1e-12


def test_a_release_between_samples_is_found_when_the_controller_is_continuous():
    arm = one_joint(mass=2.0, lower=-1.0, upper=0.0)
    run = simulate(arm, push_with(lambda t: 1.0 - t / 0.4567), Still(np.zeros(1), 1.0), continuous=True)
    (release,) = run.events
    assert release.t == pytest.approx(0.4567, abs=1e-9)
    expected = -((1.0 - 0.4567) ** 3) / (6 * 2.0 * 0.4567)
    assert run.q[-1, 0] == pytest.approx(expected, abs=1e-10)
    assert audit(run).residual <= 1e-10


def test_no_joint_of_the_lwr_is_ever_beyond_its_limit():
    arm = with_limits(lwr(), lower=-1.7, upper=1.4)
    wave = joint_waves(1.0)
    wide = Sinusoids(MIDDLE, 3 * wave.amplitude, 8 * wave.w, 1.0)
    run = simulate(lwr(), controllers()["pd-gravity"], wide, plant=arm)
    stops = [event for event in run.events if event.kind == "stop"]
    assert len(stops) >= 5
    assert len({event.joint for event in stops}) >= 2
    assert max((run.q - 1.4).max(), (-1.7 - run.q).max()) <= BEYOND
    assert run.work["stop"][-1] == pytest.approx(-sum(event.value for event in stops), abs=1e-9)


def test_two_joints_at_once():
    """Both sliders of one axis reach their stops in the same instant, and rest."""
    arm = random_arm(3, "PP")
    plant_arm = with_limits(arm, lower=-0.05, upper=0.05)
    dynamics = lwr_dyn.dynamics_of(arm)
    speed = np.array([0.5, 0.5])

    def keep_speed(t, q, dq, q_ref, dq_ref, ddq_ref):
        return dynamics.inverse_dynamics(q, dq, np.zeros(2)) + (5.0 * np.linalg.solve(np.eye(2), speed))

    run = simulate(plant_arm, keep_speed, Still(np.zeros(2), 0.3), dq0=speed, position_limits=True)
    assert {event.joint for event in run.events if event.kind == "stop"} == {0, 1}
    assert (run.q <= 0.05).all()
    assert audit(run).worst_energy <= 1e-9


def test_a_start_at_a_limit_with_outward_speed_is_an_impact_at_once():
    arm = one_joint(mass=2.0, lower=-1.0, upper=0.0)
    run = simulate(arm, no_torque, Still(np.zeros(1), 0.01), dq0=[3.0])
    assert [(event.kind, event.t) for event in run.events] == [("stop", 0.0)]
    assert run.events[0].value == pytest.approx(9.0, rel=1e-15)
    assert (run.q == 0.0).all()
    assert audit(run).residual <= 1e-12


def test_without_limits_it_goes_on():
    arm = one_joint(mass=2.0, lower=-1.0, upper=0.0)
    run = simulate(arm, no_torque, Still(np.zeros(1), 0.01), dq0=[3.0], position_limits=False)
    assert run.q[-1, 0] == pytest.approx(0.03, rel=1e-12)
    assert run.events == ()


@pytest.mark.parametrize(
    ("torque", "guess", "speed", "expected"),
    [(1.0, 0, 0.0, 0), (1.0, -1, 0.0, 0), (-1.0, 0, 0.0, -1), (0.0, 0, 0.0, 0), (0.0, -1, 0.0, -1), (1.0, 0, -0.1, -1)],
)
def test_which_joint_rests_at_its_stop(torque, guess, speed, expected):
    """Pushed outward it rests, inward it leaves, by itself; only on the border the guess decides."""
    arm = one_joint(mass=2.0, lower=-1.0, upper=0.0)
    plant = plant_of(arm, lwr_dyn.dynamics_of(arm))
    q, dq, tau = np.zeros(1), np.array([speed]), np.array([torque])
    assert resolve_stick_slip(plant, q, dq, tau, np.array([guess])).tolist() == [expected]


def test_a_joint_at_its_stop_is_pushed_outward_from_nothing():
    """At first no torque holds it there, so it might leave; it does not, and no event is made of it."""
    arm = one_joint(mass=2.0, lower=-1.0, upper=0.0)
    for options in ({"continuous": True}, {"continuous": True, "method": "dop853"}, {}):
        run = simulate(arm, push_with(lambda t: 3.0 * t), Still(np.zeros(1), 0.1), **options)
        assert (run.q == 0.0).all()
        assert run.events == ()
