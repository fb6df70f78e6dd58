"""An observer beside a controller: the law's torques as they are, the estimate and the flag in the run."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.laws.observer import CollisionThreshold, MomentumObserver, observed
from lwr_dyn.control.protocol import JointReadings
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.simulation.environment.walls_and_pushes import Push
from lwr_dyn.simulation.simulate import simulate
from tests.simulation.sample_runs import joint_waves, lwr, lwr_dynamics
from tests.slips import uncaught

OPTIONS = {"duration": 0.3}


def run_of(law, **options):
    push = Push(lwr(), (30.0, 0.0, 0.0), start=0.1, duration=0.2)
    return simulate(lwr(), law, joint_waves(), external=push, **OPTIONS | options)


@pytest.mark.parametrize("name", ["pid", "inverse-dynamics"])
def test_the_law_is_untouched(name):
    plain, watched = run_of(make_controller(name, lwr())), run_of(make_controller(f"{name}+observer", lwr()))
    np.testing.assert_array_equal(watched.q, plain.q)
    assert watched.meta["controller"]["name"] == f"{name}+observer"
    assert watched.meta["controller"]["parameters"]["observer"]["sigmas"] == 7.0


@pytest.mark.parametrize("delay", [0, 3])
def test_the_estimate_is_that_of_the_torque_that_was_applied(delay):
    """Through a delay too, and where torques are cut at their limits."""
    run = run_of(make_controller("inverse-dynamics+observer", lwr()), delay=delay)
    assert delay == 3 or (run.tau_command == run.tau_applied).all()
    observer, last = MomentumObserver(lwr_dynamics(), 50.0), [None, *run.tau_applied[:-1]]
    again = [observer(*sample) for sample in zip(run.t.tolist(), run.q, run.dq, last, strict=True)]
    np.testing.assert_allclose(run.signals["external_torque"], again, rtol=0, atol=1e-11)


def test_a_push_is_flagged_and_nothing_before_it():
    run = run_of(make_controller("inverse-dynamics+observer", lwr()))
    flag = run.signals["collision"][:, 0]
    assert set(flag) == {0.0, 1.0}
    assert 0.1 < run.t[np.argmax(flag)] < 0.13


def test_a_controller_of_ones_own_and_one_without_sensors():
    """Called without `sense`, it takes the law's own torques, cut at the limits."""
    law = observed(lambda *state: np.full(7, 1e4), lwr(), lwr_dynamics())
    q, zero = np.full(7, 0.3), np.zeros(7)
    law.reset()
    for k in range(3):
        law(1e-3 * k, q, zero, q, zero, zero)
    seen = -(lwr().effort - lwr_dynamics().gravity_vector(q))  # at rest all the same: something holds it
    share = 1 - np.exp(-2 * 0.05)
    np.testing.assert_allclose(law.signals["external_torque"], share * seen, rtol=1e-9)


def test_it_watches_the_link_side_of_elastic_joints():
    """The readings of the joint torque sensors, and B without the rotors, where a spring stands between."""
    law, rng = make_controller("inverse-dynamics+observer", lwr()), np.random.default_rng(0)
    law.reset()
    rows = rng.uniform(-1, 1, (5, 3, 7))
    links, last = MomentumObserver(lwr_dynamics(), 50.0, lwr().armature), None
    for k, (q, dq, torque) in enumerate(rows):
        law.sense(JointReadings(q + 0.01, 2 * dq, q, dq, torque))
        law(1e-3 * k, q + 0.01, 2 * dq, q, dq, dq)
        expected = links(1e-3 * k, q, dq, None if last is None else (last + torque) / 2)
        np.testing.assert_allclose(law.signals["external_torque"], expected, rtol=0, atol=1e-9 * np.abs(expected).max())
        last = torque


def test_a_push_on_elastic_joints_is_seen_through_the_torque_sensors():
    """Plant with springs; the law reads the motors, the observer the links: a thousandth of the push is left."""
    arm = lwr_dyn.load("lwr4plus", reading="physical")
    push = Push(arm, (20.0, 0.0, 0.0), start=0.05, duration=0.15, rise=0.03)
    law = make_controller("inverse-dynamics+observer", arm, omega_n=20.0)
    run = simulate(arm, law, joint_waves(), duration=0.25, external=push, elasticity="file")
    true, seen = run.signals["tau_external"], run.signals["external_torque"]
    ideal = np.zeros_like(true)
    for k in range(1, len(true)):
        ideal[k] = np.exp(-0.05) * ideal[k - 1] + (1 - np.exp(-0.05)) * (true[k - 1] + true[k]) / 2
    assert np.abs(seen - ideal).max() < 1e-3 * np.abs(true).max()
    assert np.abs(run.signals["torque_sensor"] - run.tau_applied).max() > 0.1  # not the torque of the motors


def test_a_continuous_run_is_refused():
    for name in ("inverse-dynamics+observer", "pid+observer"):
        with pytest.raises(OptionError, match="continuous"):
            run_of(make_controller(name, lwr()), continuous=True)


def test_signals_of_the_inner_law_stay():
    def law(*state):
        return np.zeros(7)

    law.signals = {"own": np.ones(2)}
    assert set(observed(law, lwr(), lwr_dynamics()).signals) == {"own", "external_torque", "collision"}


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"observer_gain": 0.0}, OptionError, "observer gain"),
        ({"observer_threshold": [1.0] * 6}, ShapeError, "observer threshold"),
        ({"observer_threshold": -1.0}, OptionError, "observer threshold"),
        ({"observer_payload": -0.3}, OptionError, "payload mass"),
        ({"observer_noise": -1e-5}, OptionError, "observer noise"),
        ({"observer_noise": np.nan}, OptionError, "observer noise"),
        ({"observer_speed": 3.0}, OptionError, "observer_speed"),
    ],
)
def test_bad_options_are_refused(options, error, words):
    with pytest.raises(error, match=words):
        make_controller("inverse-dynamics+observer", lwr(), **options)


def test_a_velocity_filter_that_the_rate_does_not_allow():
    with pytest.raises(OptionError, match="velocity filter"):
        run_of(make_controller("inverse-dynamics+observer", lwr(), observer_cutoff=600.0))


def check(module):
    """The estimate of a run with a delay, with torque cut, on elastic readings; the flag at a level of one's own."""
    law = lwr_dyn.controller("inverse-dynamics", lwr())
    threshold = CollisionThreshold(np.full(7, 2.0))
    watched = module.observed(law, lwr(), lwr_dynamics(), observer_threshold=threshold)
    run = run_of(watched, delay=2)
    observer, last = MomentumObserver(lwr_dynamics(), 50.0), [None, *run.tau_applied[:-1]]
    again = np.array([observer(*sample) for sample in zip(run.t.tolist(), run.q, run.dq, last, strict=True)])
    np.testing.assert_allclose(run.signals["external_torque"], again, rtol=0, atol=1e-11)
    np.testing.assert_array_equal(run.signals["collision"][2:, 0], (np.abs(again[2:]) > 2.0).any(axis=1))
    np.testing.assert_array_equal(run.tau_command, run_of(law, delay=2).tau_command)
    np.testing.assert_array_equal(run_of(watched, delay=2).signals["collision"], run.signals["collision"])
    law = module.observed(lambda *state: np.full(7, 1e4), lwr(), lwr_dynamics())
    q, zero, links, torque = np.full(7, 0.3), np.zeros(7), MomentumObserver(lwr_dynamics(), 50.0, lwr().armature), None
    for k in range(3):
        law(1e-3 * k, q, zero, q, zero, zero)
    assert (law.signals["external_torque"] < 0.0).all()
    law.reset()
    for k in range(4):
        law.sense(JointReadings(q, zero, q + 0.1 * k, zero + k, np.full(7, 3.0 * k)))
        law(1e-3 * k, q, zero, q, zero, zero)
        torque = None if k == 0 else np.full(7, 3.0 * k - 1.5)
        expected = links(1e-3 * k, q + 0.1 * k, zero + k, torque)
    np.testing.assert_allclose(law.signals["external_torque"], expected, rtol=1e-9)


SLIPS = (
    ("self._torque if readings is None else readings.torque", "self._torque"),
    ("saturate(tau, self._effort)", "tau * 0"),
    ("(self._torque + torque) / 2", "torque"),
    ("np.abs(r) > self._level", "r > self._level"),
    ("observer.reset()", "pass"),
    ("self._observe(t, readings.q, readings.dq,", "self._observe(t, q, dq,"),
    ("MomentumObserver(dynamics, observer_gain, arm.armature)", "MomentumObserver(dynamics, observer_gain)"),
)


def test_planted_slips_are_caught():
    assert not uncaught("lwr_dyn.control.laws.observer", SLIPS, check)
