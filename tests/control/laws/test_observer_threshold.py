"""Levels of a momentum observer: what an unknown load, friction and noise leave in its estimate, and nothing above."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter

import lwr_dyn
from lwr_dyn.control.laws.observer import (
    OFFSET,
    SIGMAS,
    CollisionThreshold,
    box_threshold,
    friction_level,
    motion_threshold,
    noise_gain,
    observed,
)
from lwr_dyn.control.paper_laws import InverseDynamics
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import JointLimits, arm_with_payload
from lwr_dyn.model.friction import Direction, JointFriction, Sigmoid
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.simulate import simulate
from tests.control.laws.collisions import PLACES, pushes, table
from tests.random_arms import random_arm
from tests.simulation.sample_runs import Still, joint_waves, lwr, lwr_dynamics
from tests.slips import uncaught

POSE = np.array([0.3, 0.8, -0.2, -1.2, 0.4, 0.7, 0.1])
NOISE, CUTOFF, GAIN, T = 1e-5, 30.0, 50.0, 1e-3
GAINS = np.full(7, GAIN)


def still():
    return Still(POSE, 1.0).sample(np.zeros(1))


@cache
def standard_deviation(noise, cutoff, gain):
    """Of the estimate (n,) while the arm stands, by a run."""
    law = observed(InverseDynamics(lwr_dynamics(), 225.0, 30.0), lwr(), lwr_dynamics(), observer_gain=gain)
    encoder = Encoder(noise=noise, cutoff_hz=cutoff)
    run = simulate(lwr(), law, Still(POSE, 3.0), encoder=encoder, seed=3)
    return run.signals["external_torque"][300:].std(axis=0)


def check(module):
    """Sigma against a run at two cut-offs and gains; the bias against arms that carry the load; the level of both."""
    for cutoff, gain in ((30.0, 50.0), (100.0, 20.0)):
        threshold = module.motion_threshold(lwr(), lwr_dynamics(), still(), 0.3, NOISE, cutoff)
        sigma = threshold.sigma(np.full(7, gain), T)
        np.testing.assert_allclose(sigma, standard_deviation(NOISE, cutoff, gain), rtol=0.15)
        np.testing.assert_allclose(threshold.level(np.full(7, gain), T), threshold.bias + SIGMAS * sigma, rtol=1e-12)
    motion = joint_waves().sample(np.linspace(0.0, 14.0, 50))
    state, least, sides = (motion.q, motion.dq, motion.ddq), np.zeros(7), np.random.default_rng(1).normal(size=(40, 3))
    without = lwr_dynamics().inverse_dynamics(*state)
    for com in OFFSET * sides / np.linalg.norm(sides, axis=1)[:, None]:
        loaded = lwr_dyn.dynamics_of(arm_with_payload(lwr(), 0.3, com)).inverse_dynamics(*state)
        least = np.maximum(least, np.abs(loaded - without).max(axis=0))
    bias = module.motion_threshold(lwr(), lwr_dynamics(), motion, 0.3, NOISE, CUTOFF).bias
    assert (bias >= 0.9999 * least).all()  # OFFSET^2 of the tensor is left out
    assert (bias <= 1.25 * least + 0.01).all()
    box = module.box_threshold(lwr(), lwr_dynamics(), 0.3, NOISE, CUTOFF)
    assert box.bias[1] == pytest.approx(0.3 * 9.81 * 0.91, rel=0.1)  # the reach of the shoulder, less the last corners
    wam = lwr_dyn.load("wam7")
    first = wam.friction_models()[0].positive
    slope = max(first.viscous, 0.0) * wam.velocity[0] if np.isfinite(wam.velocity[0]) else 0.0
    assert module.friction_level(wam)[0] >= max(first.holding, first.coulomb) + slope


SLIPS = (
    ("* (1 - a) * (1 - c) / interval**2", "* (1 - a) / interval**2"),
    ("np.diff(both, 2,", "np.diff(both, 1,"),
    ("(a ** (k + 1) - c ** (k + 1)) / (a - c)", "a**k - c**k"),
    ("self.bias + SIGMAS * self.sigma", "self.bias + self.sigma"),
    ("np.linalg.norm(dynamics.mass_matrix(q), axis=-1)", "np.diagonal(dynamics.mass_matrix(q), 0, -2, -1)"),
    ("np.abs(centre) + aside", "np.abs(centre)"),
    ("- without\n", "\n"),
    ("bias + friction_level(arm)", "bias - 1.0"),
)


@pytest.mark.slow
def test_planted_slips_are_caught():
    assert not uncaught("lwr_dyn.control.laws.observer", SLIPS, check)


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
