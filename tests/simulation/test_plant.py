"""The plant: limits that are off or unknown are infinite, payloads and scaled masses, arms that cannot exist."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import NotPhysicalError, OptionError, RatingWarning
from lwr_dyn.model.arm import arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.model.chain import Body, with_bodies
from lwr_dyn.simulation.plant import plant_of
from tests.simulation.sample_runs import lwr, one_joint


def slider(**options):
    arm = one_joint(lower=-1.0, upper=2.0, effort=9.0)
    return plant_of(arm, lwr_dyn.dynamics_of(arm), **options)


def test_limits_are_those_of_the_arm_or_infinite():
    assert [slider().lower[0], slider().upper[0], slider().effort[0]] == [-1.0, 2.0, 9.0]
    assert [slider(position_limits=False).upper[0], slider(saturate=False).effort[0]] == [np.inf, np.inf]
    assert slider(position_limits=False).lower[0] == -np.inf
    assert slider().friction.form == "none"


@pytest.mark.parametrize(
    ("q", "side", "beyond"), [(-1.1, -1, True), (-1.0, -1, False), (0.0, 0, False), (2.0, 1, False), (2.1, 1, True)]
)
def test_at_a_limit_is_not_yet_beyond_it(q, side, beyond):
    assert slider().at_limit(np.array([q])).tolist() == [side]
    assert slider().beyond(np.array([q])).tolist() == [beyond]


def test_a_payload_adds_its_mass_and_scaling_multiplies_all_inertia():
    q, dq, ddq = np.random.default_rng(0).uniform(-1, 1, (3, 7))
    plain = lwr_dyn.dynamics_of(lwr())
    heavy = lwr_dyn.dynamics_of(arm_with_payload(lwr(), 2.0))
    p = lwr_dyn.forward_kinematics(lwr(), q)[2, 3]
    added = heavy.potential_energy(q) - plain.potential_energy(q)
    assert added == pytest.approx(-2.0 * lwr().chain.gravity[2] * p, rel=1e-9)
    assert arm_with_payload(lwr(), 0.0).chain.links[-1].body.mass == lwr().chain.links[-1].body.mass
    arm = one_joint(lever=0.3, gravity=(0.0, -9.81, 0.0))
    one, three = (lwr_dyn.dynamics_of(x) for x in (arm, arm_with_scaled_inertia(arm, 3.0)))
    state = q[:1], dq[:1], ddq[:1]
    np.testing.assert_allclose(three.inverse_dynamics(*state), 3.0 * one.inverse_dynamics(*state), rtol=1e-12)


def test_what_cannot_be_carried_is_refused_and_an_overload_is_warned_of():
    with pytest.raises(OptionError, match=r"payload mass: -1\.0; allowed: a number >= 0"):
        arm_with_payload(lwr(), -1.0)
    with pytest.raises(OptionError, match=r"mass factor: 0\.0; allowed: a number above 0"):
        arm_with_scaled_inertia(lwr(), 0.0)
    arm = one_joint()
    rated = replace(arm, ratings=replace(arm.ratings, payload=3.0))
    with pytest.warns(RatingWarning, match="one: a payload of 4 kg is over the rated 3 kg"):
        arm_with_payload(rated, 4.0)


def test_an_inertia_that_no_body_has_is_refused_unless_it_is_allowed():
    arm = one_joint()
    bad = replace(arm, chain=with_bodies(arm.chain, [Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 3.0]))]))
    dynamics = lwr_dyn.dynamics_of(bad)
    with pytest.raises(NotPhysicalError, match=r"one \(none\)"):
        plant_of(bad, dynamics)
    assert plant_of(bad, dynamics, allow_unphysical=True).n == 1
