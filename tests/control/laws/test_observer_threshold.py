"""Levels of a momentum observer: what an unknown load, friction and noise leave in its estimate, and nothing above."""

from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.laws.observer import (
    OFFSET,
    SIGMAS,
    CollisionThreshold,
    box_threshold,
    friction_level,
    motion_threshold,
    observed,
)
from lwr_dyn.control.paper_laws import InverseDynamics
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.simulate import simulate
from tests.control.laws.collisions import PLACES, pushes, table
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
    ("/ interval**2", "/ interval"),
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


def test_friction_is_in_the_level_where_it_is_known():
    wam = lwr_dyn.load("wam7")
    dynamics = lwr_dyn.dynamics_of(wam)
    without = box_threshold(lwr_dyn.load("lwr4plus"), lwr_dynamics())
    assert (friction_level(lwr()) == 0.0).all()
    assert (box_threshold(wam, dynamics, 0.0).bias >= friction_level(wam)).all()
    assert (without.bias > 0.0).all()


def test_levels_of_ones_own_have_no_noise():
    threshold = CollisionThreshold(np.full(7, 2.0))
    np.testing.assert_array_equal(threshold.level(GAINS, T), np.full(7, 2.0))
    assert threshold.record()["noise"] == 0.0


def test_bad_noise_and_payload_are_refused():
    with pytest.raises(OptionError, match="observer noise"):
        CollisionThreshold(np.ones(7), np.ones(7), -1.0)
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
