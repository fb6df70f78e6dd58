"""Every run balances its energy: 14 s of every controller, any arm, stops and friction included."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from scipy.integrate import solve_ivp

import lwr_dyn
from lwr_dyn.control.protocol import joint_torque
from lwr_dyn.foundation.errors import DivergenceError, OptionError, ShapeError
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.simulation.audit import Intervals, audit
from lwr_dyn.simulation.contact import ACTIVE_FRICTION
from lwr_dyn.simulation.loops import REPORTS, Log, active_friction
from lwr_dyn.simulation.setup import Loop, prepare
from lwr_dyn.simulation.simulate import free_swing, simulate
from tests.examples import examples
from tests.random_arms import arms
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


@pytest.mark.slow
@examples(10)
@given(arms)
def test_any_arm_swings_freely(arm):
    run = free_swing(arm, "speed", duration=0.05, rate=100.0)
    assert run.audit["inverse_dynamics"]["closed"]
    assert audit(run, lwr_dyn.dynamics_of(arm, "newton-euler")).worst_energy <= 1e-8 * max(
        1.0, np.abs(run.energy).max()
    )


@pytest.mark.slow
@pytest.mark.parametrize("method", ["rk4", "dop853"])
@pytest.mark.parametrize("continuous", [False, True])
def test_with_friction_and_stops(method, continuous):
    wave, coefficients = joint_waves(0.3), np.array([2.0, 2.0, 0.5, 0.5, 0.02, 0.02, 0.01])
    fast = Sinusoids(MIDDLE, 2 * wave.amplitude, 20 * wave.w, 0.3)
    run = simulate(
        lwr(), controllers()["inverse-dynamics"], fast, plant=with_limits(lwr(), lower=-1.6, upper=1.35),
        friction=lambda dq: coefficients * dq, rate=2000.0, method=method, continuous=continuous, rtol=1e-10,
        substeps=2,
    )  # fmt: skip
    assert {event.kind for event in run.events} >= {"stop", "release"}
    for channel, least in (("friction", -0.01), ("stop", -1e-3)):
        assert run.work[channel][-1] < least
        assert (np.diff(run.work[channel]) <= 0).all()
    assert audit(run).residual <= 1e-8 * np.abs(run.work["actuator"]).max()
    np.testing.assert_allclose(run.tau_friction, coefficients * run.dq)


def test_the_arm_held_at_rest_stays_still_and_progress_is_reported_a_hundred_times():
    shares = []
    run = simulate(lwr(), controllers()["pd-gravity"], Still(MIDDLE, 1.0), progress=shares.append)
    assert np.abs(run.q - MIDDLE).max() <= 1e-14  # g of one algorithm against another's: 1e-15 N m
    assert np.abs(run.dq).max() <= 1e-13
    assert audit(run).worst_energy <= 1e-12
    np.testing.assert_allclose(shares, np.arange(1, REPORTS + 1) / REPORTS, atol=0.02)
    assert shares[-1] == 1.0


@pytest.mark.parametrize("samples", [0, 1, 3])
def test_commands_arrive_late_by_the_delay_and_the_first_acts_until_then(samples):
    def ramp(t, q, *_):
        return lwr_dynamics().gravity_vector(MIDDLE) + t

    at_once, late = (simulate(lwr(), ramp, joint_waves(0.02), delay=d) for d in (0, samples))
    arrived = np.maximum(np.arange(21) - samples, 0)
    np.testing.assert_array_equal(late.tau_applied, at_once.tau_applied[arrived])
    assert late.meta["options"]["delay"] == samples
    with pytest.raises(OptionError, match="delay: 1 samples in a continuous run"):
        simulate(lwr(), ramp, joint_waves(0.02), delay=1, continuous=True)


@pytest.mark.parametrize(
    ("given", "fault"),
    [([1.0], r"shape \(1,\)"), (0.0, r"shape \(\)"), ("fast", "not an array of numbers"), (None, r"shape \(\)")],
)
def test_torques_of_any_number_type_become_float64_and_what_is_none_is_refused(given, fault):
    for good in ([1, 2], (1.0, 2.0), np.array([1.0, 2.0], dtype=np.float32)):
        tau = joint_torque("torque", good, 2)
        assert (tau.dtype, tau.tolist()) == (np.float64, [1.0, 2.0])
    with pytest.raises(ShapeError, match=f"torque of a push: {fault}; allowed: 2 numbers"):
        joint_torque("torque of a push", given, 2)


class Reader:
    """A law that keeps what its joint sensors read."""

    def __init__(self):
        self.read = []

    def sense(self, readings):
        self.read.append((readings.q.copy(), readings.dq.copy(), readings.torque.copy()))
        assert readings.theta is readings.q

    def __call__(self, t, q, dq, q_ref, dq_ref, ddq_ref):
        return np.full(7, 1e3 if t < 0.0015 else 1.0)


@pytest.mark.parametrize("delay", [0, 2])
def test_rigid_joints_read_one_position_and_the_torque_that_was_last_applied(delay):
    law = Reader()
    run = simulate(lwr(), law, joint_waves(), duration=0.006, delay=delay)
    wanted = run.q, run.dq, np.vstack([np.zeros(7), run.tau_applied[:-1]])
    assert np.array_equal(np.array(law.read).swapaxes(0, 1), wanted)


def pushed(t, q, dq, q_ref, dq_ref, ddq_ref):
    return np.array([3.0])


def setup(friction="none", **options):
    return prepare(one_joint(), pushed, Still(np.zeros(1), 0.003), Loop(friction=friction, **options))


class WithIntegral:
    """A law whose memory is the integral of the position's error, and time."""

    memory_size = 2

    def __call__(self, *_):
        raise AssertionError("a continuous run asks for torque and rate")

    def torque_and_rate(self, memory, q, dq, q_ref, dq_ref, ddq_ref):
        tau = 3.0 * memory[:1] + memory[1:] ** 2 + 1.5 * (dq_ref - dq) + 2.0 * ddq_ref
        return tau, np.array([q_ref[0] - q[0], 1.0])


@pytest.mark.parametrize("law", [WithIntegral(), lambda t, q, dq, *ref: t**2 - 3.0 * q + ref[0] - 0.5 * ref[1] * dq])
def test_a_continuous_run_and_its_works_are_those_of_scipys_integrator(law):
    """The reference, the law's memory and time as they are at each moment, not at samples; 2 ddq = tau - 0.7 dq."""
    wave = Sinusoids(np.array([0.2]), np.array([0.4]), np.array([9.0]), 0.5)
    arm, given = one_joint(mass=2.0, effort=1.9), {"q0": [0.5], "dq0": [-0.4]}
    friction = [JointFriction(Direction(0.0, 0.7), Direction(0.0, 0.7))]
    run = simulate(arm, law, wave, friction=friction, rate=50.0, method="dop853", continuous=True, rtol=1e-11, **given)

    def torque(t, y):
        sample = wave.sample(np.array([t]))
        ref = sample.q[0], sample.dq[0], sample.ddq[0]
        if isinstance(law, WithIntegral):
            return law.torque_and_rate(y[4:], y[:1], y[1:2], *ref)
        return law(t, y[:1], y[1:2], *ref), np.zeros(2)

    def slope(t, y):
        tau, rate = torque(t, y)
        tau = np.clip(tau, -1.9, 1.9)
        return np.array([y[1], (tau[0] - 0.7 * y[1]) / 2.0, tau[0] * y[1], -0.7 * y[1] ** 2, *rate])

    start = np.array([0.5, -0.4, 0.0, 0.0, 0.0, 0.0])
    y = solve_ivp(slope, (0.0, 0.5), start, "DOP853", run.t, rtol=1e-12, atol=1e-13, max_step=0.002).y
    np.testing.assert_allclose([run.q[:, 0], run.dq[:, 0]], y[:2], atol=2e-8)
    np.testing.assert_allclose([run.work["actuator"], run.work["friction"]], y[2:4], atol=2e-8)
    wanted = [torque(t, row)[0][0] for t, row in zip(run.t, y.T, strict=True)]
    np.testing.assert_allclose(run.tau_command[:, 0], wanted, atol=1e-6)
    assert np.array_equal(run.tau_applied, np.clip(run.tau_command, -1.9, 1.9))
    np.testing.assert_allclose(run.tau_friction, 0.7 * run.dq, rtol=1e-12)


@pytest.mark.parametrize("degree", [3, 5])
def test_between_samples_of_a_continuous_run_the_torque_is_a_polynomial_through_six(degree):
    """What four say otherwise, with a millionth of the largest torque, is uncertain; in the motion h^2 B^-1 of it."""
    run = simulate(lwr(), controllers()["pd-gravity"], joint_waves(0.02), continuous=True)
    rows = np.array([0, 1, 2, 9, 17, 19])

    def torque(t):
        return np.outer(1.0 + 3.0 * (t / 0.02) ** degree, np.linspace(1.0, 2.0, 7))

    judge = Intervals(replace(run, tau_applied=torque(run.t)), rows, lwr_dynamics("newton-euler"))
    for s in (0.0, 0.3, 1.0):
        np.testing.assert_allclose(judge.torque(s), torque(run.t[rows] + s * 1e-3), rtol=1e-10)
    least, B = 1e-6 * judge.scale(), lwr_dynamics().mass_matrix(run.q[rows])
    assert judge.scale() == max(np.abs(lwr_dynamics().gravity_vector(run.q[rows])).max(), 8.0)
    found, gap = judge.uncertainties()
    off = max(np.abs(judge.torque(s, 4) - torque(run.t[rows] + s * 1e-3)).max() for s in (0.25, 0.5, 0.75))
    assert found == pytest.approx(least + off, rel=1e-6)
    assert (off > 1e-5) == (degree == 5)
    assert gap == pytest.approx(found * 1e-6 * np.abs(np.linalg.inv(B)).max(), rel=1e-9)


def test_under_hold_the_work_is_torque_times_travel_and_continuous_runs_bring_their_own():
    log = Log.blank(setup(q0=[0.2], dq0=[-1.0]))  # it has the start and nothing else
    assert log.states.tolist() == [[[0.2], [-1.0]], *[[[0.0], [0.0]]] * 3]
    assert (log.done, log.friction) == (0, None)
    assert Log.blank(setup([JointFriction(Direction(1.0, 0.0), Direction(1.0, 0.0))])).friction.shape == (4, 1)
    log.states[:, 0, 0] = [0.0, 0.1, 0.4, 0.4]
    log.applied[:, 0] = [2.0, -1.0, 5.0, 7.0]
    log.works[:, 1] = [0.0, -0.1, -0.2, -0.4]
    log.works[:, 0] = [0.0, 1.0, 1.0, 1.0]
    log.done = 3
    found = [log.work()[name] for name in ("actuator", "friction", "stop")]
    np.testing.assert_allclose(found, [[0.0, 0.2, -0.1], [0.0, -0.1, -0.3], [0.0, 0.0, 0.0]], atol=1e-15)
    log.continuous = True
    np.testing.assert_allclose(log.work()["actuator"], [0.0, 1.0, 2.0])


def test_friction_that_feeds_energy_in_is_reported_once_per_joint_and_direction():
    t = np.arange(5.0)
    dq = np.array([[1.0, 1.0], [2.0, 0.0], [3.0, 0.0], [-1.0, 1.0], [-2.0, 1.0]])
    tau = np.array([[1.0, 1.0], [-1.0, 9.0], [-1.0, -9.0], [-1.0, 0.0], [1.0, 1.0]])
    found = [(event.t, event.kind, event.joint, event.value) for event in active_friction(t, dq, tau)]
    assert found == [(1.0, ACTIVE_FRICTION, 0, 2.0), (4.0, ACTIVE_FRICTION, 0, -2.0)]


def test_a_run_that_diverges_names_joint_and_time_and_keeps_what_was_computed():
    with pytest.raises(DivergenceError, match=r"joint_1.*; allowed: ") as fault:
        simulate(one_joint(), lambda t, *_: [np.nan if t > 0.0015 else 1e9], Still(np.zeros(1), 0.01))
    run = fault.value.run
    diverged = run.meta["diverged"]
    assert (diverged["t"], diverged["joint"]) == (fault.value.t, "joint_1") == (run.t[-1], "joint_1")
    assert np.isfinite(run.q).all()
    for kind, unit in ((JointKind.PRISMATIC, "m/s"), (JointKind.REVOLUTE, "rad/s")):
        with pytest.raises(DivergenceError) as fault:
            simulate(one_joint(kind, lever=1.0), lambda *_: [1e300], Still(np.zeros(1), 0.01), dq0=[2.5], rate=500.0)
        assert str(fault.value) == (
            f"the simulation diverges at t = 0 s: joint_1: 2.5 {unit} at the last sample that can be followed, beyond "
            "reach at the next; allowed: less than a turn a sample (3142 rad/s), finite numbers; try a higher rate or "
            "lower gains"
        )
