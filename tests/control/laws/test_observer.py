"""The estimate follows the true external torque as an ideal first-order filter would, on rigid and on moving arms."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter

import lwr_dyn
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.laws.observer import (
    OFFSET,
    SIGMAS,
    CollisionThreshold,
    MomentumObserver,
    box_threshold,
    friction_level,
    motion_threshold,
    noise_gain,
    observed,
)
from lwr_dyn.control.paper_laws import InverseDynamics
from lwr_dyn.control.protocol import JointReadings
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import JointLimits, arm_with_payload
from lwr_dyn.model.friction import Direction, JointFriction, Sigmoid
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.simulation.walls_and_pushes import Push
from tests.control.laws.collisions import PLACES, pushes, table
from tests.random_arms import random_arm
from tests.simulation.sample_runs import Still, joint_waves, lwr, lwr_dynamics
from tests.tolerances import OBSERVER_SHARE

NOTHING = 1e-4
"""[N m] What the trapezoid of b leaves in half a second of a fast movement: 1e-5; an Euler step leaves 1e-2."""
POSE = np.array([0.3, 0.8, -0.2, -1.2, 0.4, 0.7, 0.1])


def ideal(t, tau, gain):
    """The filter dr/dt = gain (tau - r) of torques (k, n) that are straight between the samples, exactly."""
    T, r = t[1] - t[0], np.zeros_like(tau)
    a = np.exp(-gain * T)
    last = (1 - a) / (gain * T)  # weights of both ends: the integral of exp(-gain (T - s)) gain over the line
    for k in range(1, len(t)):
        r[k] = a * r[k - 1] + (last - a) * tau[k - 1] + (1 - last) * tau[k]
    return r


def estimate(run, observer):
    """What an observer makes of a run's samples."""
    last = [None, *run.tau_applied[:-1]]
    return np.array([observer(*sample) for sample in zip(run.t.tolist(), run.q, run.dq, last, strict=True)])


def push(at="flange", force=(15.0, -10.0, 12.0), rise=0.02):
    return Push(lwr(), force, start=0.05, duration=0.3, rise=rise, at=at)


@cache
def moving(external, **options):
    """A push while the arm moves and gives way: its direction stays, the true torque changes with the pose."""
    law = lwr_dyn.controller("inverse-dynamics", lwr(), omega_n=15.0)
    return simulate(lwr(), law, joint_waves(), duration=0.4, external=external, **options)


@cache
def pushed():
    return moving(push())


@pytest.mark.slow
@pytest.mark.parametrize(("gain", "rise"), [(20.0, 0.02), (50.0, 0.02), (100.0, 0.02), (200.0, 0.05)])
@pytest.mark.parametrize("at", ["flange", "link_3"])
def test_within_a_thousandth_of_the_ideal_filter_for_a_moving_push(gain, rise, at):
    """Faster pushes leave more, K_O T^2 / 12 times their slope: a torque that is not constant within a sample."""
    run = moving(push(at, rise=rise))
    true = run.signals["tau_external"]
    error = estimate(run, MomentumObserver(lwr_dynamics(), gain)) - ideal(run.t, true, gain)
    assert np.linalg.norm(error, axis=1).max() <= OBSERVER_SHARE * np.linalg.norm(true, axis=1).max()
    if at == "flange":
        assert np.ptp(true[100:300], axis=0).max() > 0.2  # the force is held, the pose is not


def test_an_unknown_payload_is_seen_as_its_weight():
    """Held still, the estimate of a load that the model lacks tends to the load's weight at the joints."""
    load = 0.3
    law = lwr_dyn.controller("inverse-dynamics", lwr(), omega_n=15.0)
    run = simulate(lwr(), law, Still(POSE, 0.8), payload=load)
    r = estimate(run, MomentumObserver(lwr_dynamics(), 50.0))
    end = run.q[-1]
    weight = lwr_dynamics().gravity_vector(end) - lwr_dyn.dynamics_of(arm_with_payload(lwr(), load)).gravity_vector(end)
    assert np.abs(weight).max() > 1.0
    np.testing.assert_allclose(r[-1], weight, rtol=0, atol=0.02 * np.abs(weight).max())


def test_rows_of_states_are_observed_as_single_ones():
    run, gain = pushed(), 50.0
    alone = estimate(run, MomentumObserver(lwr_dynamics(), gain))
    rows = MomentumObserver(lwr_dynamics(), gain)
    rows.sample_every(1e-3)
    for k, (q, dq) in enumerate(zip(run.q[:50], run.dq[:50], strict=True)):
        q, dq = np.tile(q, (3, 1)), np.tile(dq, (3, 1))
        p = np.einsum("kij,kj->ki", lwr_dynamics().mass_matrix(q), dq)
        b = np.einsum("kij,ki->kj", lwr_dynamics().coriolis_matrix(q, dq), dq) - lwr_dynamics().gravity_vector(q)
        r = rows.advance(p, b, np.tile(run.tau_applied[max(k - 1, 0)], (3, 1)))
        np.testing.assert_allclose(np.broadcast_to(r, (3, 7)), np.tile(alone[k], (3, 1)), rtol=0, atol=1e-11)


@pytest.mark.parametrize(
    ("observer", "options", "words"),
    [
        ({"observer_gain": 1001.0}, {}, "observer gain: 1001 1/s; allowed: at most the rate, 1000 1/s"),
        ({"observer_cutoff": 600.0}, {}, "cut-off of the velocity filter: 600.0; allowed: above 0 and below 500 Hz"),
        ({}, {"continuous": True}, "continuous: "),
    ],
)
def test_what_the_loop_does_not_allow_is_one_line(observer, options, words):
    law = make_controller("inverse-dynamics+observer", lwr(), **observer)
    with pytest.raises(OptionError) as fault:
        simulate(lwr(), law, Still(POSE, 0.01), **options)
    assert str(fault.value).startswith(words)
    assert "\n" not in str(fault.value)
    if not options:
        simulate(lwr(), law, Still(POSE, 0.01), rate=2000.0)


def test_the_estimate_follows_the_ideal_filter():
    """The estimate against the ideal filter, pushed and not; with rotors taken off, against the links' own momentum."""
    run, gain = pushed(), 50.0
    true = run.signals["tau_external"]
    error = estimate(run, MomentumObserver(lwr_dynamics(), gain)) - ideal(run.t, true, gain)
    assert np.linalg.norm(error, axis=1).max() <= OBSERVER_SHARE * np.linalg.norm(true, axis=1).max()
    assert np.abs(estimate(moving(None), MomentumObserver(lwr_dynamics(), gain))).max() < NOTHING
    rotor = lwr().armature + 0.1
    links = MomentumObserver(lwr_dynamics(), gain, rotor)
    turned = np.gradient(run.dq, run.t, axis=0)
    seen = estimate(run, links)
    expected = ideal(run.t, true - rotor * turned, gain)
    np.testing.assert_allclose(seen[150:], expected[150:], rtol=0, atol=0.05)


def run_of(law, **options):
    push = Push(lwr(), (30.0, 0.0, 0.0), start=0.1, duration=0.2)
    return simulate(lwr(), law, joint_waves(), external=push, **{"duration": 0.3} | options)


@pytest.mark.parametrize("name", ["pid", "inverse-dynamics"])
def test_the_law_is_untouched_and_a_push_is_flagged_and_nothing_before_it(name):
    plain, watched = run_of(make_controller(name, lwr())), run_of(make_controller(f"{name}+observer", lwr()))
    np.testing.assert_array_equal(watched.q, plain.q)
    record = watched.meta["controller"]
    assert (record["name"], record["parameters"]["observer"]["sigmas"]) == (f"{name}+observer", 7.0)
    flag = watched.signals["collision"][:, 0]
    assert set(flag) == {0.0, 1.0}
    assert 0.1 < watched.t[np.argmax(flag)] < 0.13


def test_a_push_on_elastic_joints_is_seen_through_the_torque_sensors():
    """Plant with springs; the law reads the motors, the observer the links: a thousandth of the push is left."""
    arm = lwr_dyn.load("lwr4plus", reading="physical")
    push = Push(arm, (20.0, 0.0, 0.0), start=0.05, duration=0.15, rise=0.03)
    law = make_controller("inverse-dynamics+observer", arm, omega_n=20.0)
    run = simulate(arm, law, joint_waves(), duration=0.25, external=push, elasticity="file")
    true = run.signals["tau_external"]
    middle = (true + np.vstack([0.0 * true[:1], true[:-1]])) / 2.0
    wanted = lfilter([1.0 - np.exp(-0.05)], [1.0, -np.exp(-0.05)], middle, axis=0)
    assert np.abs(run.signals["external_torque"] - wanted).max() < 1e-3 * np.abs(true).max()
    assert np.abs(run.signals["torque_sensor"] - run.tau_applied).max() > 0.1  # not the torque of the motors


def test_signals_sensors_and_beginning_of_the_inner_law_stay():
    begun, sensed = [], []

    def law(*state):
        return np.zeros(7)

    law.signals, law.reset, law.sense = {"own": np.ones(2)}, lambda: begun.append(0.0), sensed.append
    watched = observed(law, lwr(), lwr_dynamics())
    assert set(watched.signals) == {"own", "external_torque", "collision"}
    begun.clear()
    watched.reset()
    assert begun == [0.0]
    readings = JointReadings(*np.zeros((5, 7)))
    watched.sense(readings)
    assert sensed == [readings]


def test_observed_laws_say_what_they_see():
    """The estimate with a delay, without sensors (the law's torques, cut), on elastic readings; one's own level."""
    law = lwr_dyn.controller("inverse-dynamics", lwr())
    threshold = CollisionThreshold(np.full(7, 2.0))
    assert not threshold.bias.flags.writeable
    watched = observed(law, lwr(), lwr_dynamics(), observer_threshold=threshold)
    run = run_of(watched, delay=2)
    observer, last = MomentumObserver(lwr_dynamics(), 50.0), [None, *run.tau_applied[:-1]]
    again = np.array([observer(*sample) for sample in zip(run.t.tolist(), run.q, run.dq, last, strict=True)])
    np.testing.assert_allclose(run.signals["external_torque"], again, rtol=0, atol=1e-11)
    np.testing.assert_array_equal(run.signals["collision"][2:, 0], (np.abs(again[2:]) > 2.0).any(axis=1))
    even = CollisionThreshold(np.abs(run.signals["external_torque"][50]))  # at its level, and not beyond it
    even_run = run_of(observed(law, lwr(), lwr_dynamics(), observer_threshold=even), delay=2)
    assert not even_run.signals["collision"][50].any()
    np.testing.assert_array_equal(run.tau_command, run_of(law, delay=2).tau_command)
    np.testing.assert_array_equal(run_of(watched, delay=2).signals["collision"], run.signals["collision"])
    law = observed(lambda *state: np.full(7, 1e4), lwr(), lwr_dynamics())
    q, zero, links, torque = np.full(7, 0.3), np.zeros(7), MomentumObserver(lwr_dynamics(), 50.0, lwr().armature), None
    for k in range(3):
        law(1e-3 * k, q, zero, q, zero, zero)
    seen = lwr_dynamics().gravity_vector(q) - lwr().effort  # at rest all the same: something holds it
    np.testing.assert_allclose(law.signals["external_torque"], (1 - np.exp(-2 * 0.05)) * seen, rtol=1e-9)
    law.reset()
    for k in range(4):
        law.sense(JointReadings(q, zero, q + 0.1 * k, zero + k, np.full(7, 3.0 * k)))
        law(1e-3 * k, q, zero, q, zero, zero)
        torque = None if k == 0 else np.full(7, 3.0 * k - 1.5)
        expected = links(1e-3 * k, q + 0.1 * k, zero + k, torque)
    np.testing.assert_allclose(law.signals["external_torque"], expected, rtol=1e-9)


NOISE, CUTOFF, STILL_GAIN, T = 1e-5, 30.0, 50.0, 1e-3
GAINS = np.full(7, STILL_GAIN)


def still():
    return Still(POSE, 1.0).sample(np.zeros(1))


@cache
def standard_deviation(noise, cutoff, gain):
    """Of the estimate (n,) while the arm stands, by a run."""
    law = observed(InverseDynamics(lwr_dynamics(), 225.0, 30.0), lwr(), lwr_dynamics(), observer_gain=gain)
    encoder = Encoder(noise=noise, cutoff_hz=cutoff)
    run = simulate(lwr(), law, Still(POSE, 3.0), encoder=encoder, seed=3)
    return run.signals["external_torque"][300:].std(axis=0)


def test_levels_bound_what_may_be_seen():
    """Sigma against a run at two cut-offs and gains; the bias against arms that carry the load; the level of both."""
    for cutoff, gain in ((30.0, 50.0), (100.0, 20.0)):
        threshold = motion_threshold(lwr(), lwr_dynamics(), still(), 0.3, NOISE, cutoff)
        sigma = threshold.sigma(np.full(7, gain), T)
        np.testing.assert_allclose(sigma, standard_deviation(NOISE, cutoff, gain), rtol=0.15)
        np.testing.assert_allclose(threshold.level(np.full(7, gain), T), threshold.bias + SIGMAS * sigma, rtol=1e-12)
    motion = joint_waves().sample(np.linspace(0.0, 14.0, 50))
    state, least, sides = (motion.q, motion.dq, motion.ddq), np.zeros(7), np.random.default_rng(1).normal(size=(40, 3))
    without = lwr_dynamics().inverse_dynamics(*state)
    for com in OFFSET * sides / np.linalg.norm(sides, axis=1)[:, None]:
        loaded = lwr_dyn.dynamics_of(arm_with_payload(lwr(), 0.3, com)).inverse_dynamics(*state)
        least = np.maximum(least, np.abs(loaded - without).max(axis=0))
    bias = motion_threshold(lwr(), lwr_dynamics(), motion, 0.3, NOISE, CUTOFF).bias
    assert (bias >= 0.9999 * least).all()  # OFFSET^2 of the tensor is left out
    assert (bias <= 1.25 * least + 0.01).all()
    box = box_threshold(lwr(), lwr_dynamics(), 0.3, NOISE, CUTOFF)
    assert box.bias[1] == pytest.approx(0.3 * 9.81 * 0.91, rel=0.1)  # the reach of the shoulder, less the last corners
    wam = lwr_dyn.load("wam7")
    first = wam.friction_models()[0].positive
    slope = max(first.viscous, 0.0) * wam.velocity[0] if np.isfinite(wam.velocity[0]) else 0.0
    assert friction_level(wam)[0] >= max(first.holding, first.coulomb) + slope


@pytest.mark.parametrize(("gain", "cutoff"), [(50.0, 30.0), (20.0, 100.0), (2 * np.pi * 30.0, 30.0)])
def test_the_gain_of_noise_is_that_of_the_two_filters_and_differences(gain, cutoff):
    """By SciPy's filter, over white noise as its impulse response; equal poles too."""
    a, c = np.exp(-gain * T), np.exp(-2 * np.pi * cutoff * T)
    numerator = (1 - a) * (1 - c) / T**2 * np.array([1.0, -2.0, 1.0])
    response = lfilter(numerator, np.convolve([1.0, -a], [1.0, -c]), np.eye(1, 20_000)[0])
    assert noise_gain(gain, cutoff, T) == pytest.approx(np.linalg.norm(response), rel=1e-9)


def test_the_most_that_friction_takes_is_at_rest_or_at_the_largest_speed():
    directions = Direction(2.0, 0.5, 3.0, 0.1), Direction(2.5, -1.0)
    models = (JointFriction(*directions, offset=-0.3), JointFriction(*directions[::-1], sigmoid=Sigmoid(0.8, 2.0, 0.3)))
    speeds = (4.0, 4.0, None)
    limits = tuple(JointLimits(velocity=x, viscous=0.2 if x is None else None) for x in speeds)
    one = random_arm(2, "RRR")
    arm = replace(one, limits=limits, friction=(*models, None))
    most = 0.8 / (1.0 + np.exp(-0.6))
    np.testing.assert_allclose(friction_level(arm), [0.3 + 3.0 + 2.0, 3.0 + 2.0 + most, 0.0])


def test_the_levels_of_a_box_are_the_largest_of_its_poses():
    """2 000 poses drawn, a joint without limits over a turn; the torque of 0.3 kg within 5 cm of the flange."""
    arm = lwr()
    free = replace(arm, limits=(replace(arm.limits[0], lower=None, upper=None), *arm.limits[1:]))
    found, dynamics = box_threshold(free, lwr_dynamics()), lwr_dynamics()
    low, up = np.r_[-np.pi, arm.lower[1:]], np.r_[np.pi, arm.upper[1:]]
    q = np.random.default_rng(26).uniform(low, up, (2000, 7))
    loads = [lwr_dyn.dynamics_of(arm_with_payload(arm, 0.3, com)).gravity_vector(q) - dynamics.gravity_vector(q)
             for com in (np.zeros(3), *(0.05 * np.eye(3)))]  # fmt: skip
    aside = np.linalg.norm([load - loads[0] for load in loads[1:]], axis=0)
    np.testing.assert_allclose(found.bias, (np.abs(loads[0]) + aside).max(axis=0), atol=1e-12)
    np.testing.assert_allclose(
        found.inertia, np.sqrt((dynamics.mass_matrix(q) ** 2).sum(axis=2)).max(axis=0), rtol=1e-12
    )
    record = {"noise": 1e-5, "cutoff_hz": 100.0, "sigmas": 7.0}
    assert found.record() == {"bias": found.bias.tolist(), "inertia": found.inertia.tolist(), **record}
    parameters = lwr_dyn.controller("pid+observer", arm).parameters["observer"]
    assert (parameters["gain"], parameters["sigmas"]) == ([50.0] * 7, 7.0)


def test_levels_without_inertia_or_noise_are_the_bias_and_friction_is_added_where_it_is_known():
    for given in ((), (None, 1e-5), (np.ones(7), 0.0)):
        threshold = CollisionThreshold(np.full(7, 2.0), *given)
        np.testing.assert_array_equal(threshold.level(GAINS, T), np.full(7, 2.0))
    assert CollisionThreshold(np.ones(7)).record()["noise"] == 0.0
    wam = lwr_dyn.load("wam7")
    assert not friction_level(lwr()).any()
    np.testing.assert_array_equal(box_threshold(wam, lwr_dyn.dynamics_of(wam), 0.0).bias, friction_level(wam))
    for noise in (np.inf, -1.0):
        with pytest.raises(OptionError, match=f"observer noise: {noise}; allowed: a number >= 0, in rad or m"):
            CollisionThreshold(np.ones(7), None, noise)
    with pytest.raises(OptionError, match="payload mass"):
        motion_threshold(lwr(), lwr_dynamics(), still(), payload=-1.0)


@pytest.mark.slow
def test_a_share_of_the_pushes_that_the_soak_counts():
    """Twelve of the 200 of `scripts/soak.py pushes`: most are found, in some ms, and nothing is flagged before."""
    found = list(pushes(12))
    assert not any(f.early for f in found)
    strong = [f for f in found if f.force >= 15.0]
    assert all(f.delay is not None and f.delay < 0.05 for f in strong)
    assert sum(f.delay is not None for f in found) >= 10
    assert {row[0] for row in table(found)} == set(PLACES)
