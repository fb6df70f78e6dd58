"""The inertia seen at a joint is the diagonal of B by both roads, of turning and sliding joints."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.recursion import link_constants
from lwr_dyn.dynamics.seen_inertia import seen_inertia, seen_inertia_along
from tests.random_arms import random_arm


def largest_difference(arm, engine, **options):
    """Of B_ii over states and joints, as a share of the largest."""
    q = np.random.default_rng(5).uniform(-3.0, 3.0, (40, arm.n))
    links = link_constants(arm.chain)
    seen = np.stack([seen_inertia(links[i:], q[:, i:]) for i in range(arm.n)], axis=-1)
    B = np.diagonal(lwr_dyn.dynamics_of(arm, engine, **options).mass_matrix(q), axis1=1, axis2=2)
    rotors = 0.0 if options else arm.armature
    return np.abs(seen + rotors - B).max() / B.max()


@pytest.mark.parametrize("name", ["lwr4plus", "kr30ha", "stanford", "wam7"])
def test_it_is_the_diagonal_of_the_mass_matrix(name):
    arm = lwr_dyn.load(name)
    assert largest_difference(arm, "newton-euler", rotors="none") < 1e-14
    assert largest_difference(arm, "pinocchio") < 1e-14


@pytest.mark.parametrize("seed", range(6))
def test_along_one_joint_it_is_that_of_every_row_with_every_value(seed):
    arm, rng = random_arm(seed), np.random.default_rng(seed)
    links, q, values = link_constants(arm.chain), rng.uniform(-3.0, 3.0, (4, arm.n)), rng.uniform(-3.0, 3.0, 5)
    for j in range(1, arm.n):
        lines = np.repeat(q[:, None], 5, axis=1)
        lines[:, :, j] = values
        each = seen_inertia(links, lines.reshape(-1, arm.n)).reshape(4, 5)
        np.testing.assert_allclose(seen_inertia_along(links, q, j, values), each, rtol=1e-14)


@pytest.mark.parametrize("seed", range(6))
def test_so_it_is_of_arms_with_any_frames_and_sliding_joints(seed):
    assert largest_difference(random_arm(seed), "newton-euler", rotors="none") < 1e-13
