"""Bodies add up, and a changed chain is the same mechanism: payloads, locked joints, the first links alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.chain import Body, first_links, link_frames, lock_joint, with_bodies, with_payload
from tests.random_arms import random_arm, random_body, random_pose

ROUNDING = 1e-12
"""Relative to the largest entry: a dozen products of numbers near one."""
seeds = st.integers(0, 10**6)


def close(a, b):
    return np.abs(np.asarray(a) - b).max() <= ROUNDING * max(1.0, np.abs(np.asarray(b)).max())


def points_of(rng):
    """A cloud of mass points: masses (k,) and places (k, 3)."""
    return rng.uniform(0.1, 2.0, 6), rng.normal(size=(6, 3))


def body_of(masses, places):
    com = masses @ places / masses.sum()
    r = places - com
    tensor = sum(m * ((x @ x) * np.eye(3) - np.outer(x, x)) for m, x in zip(masses, r, strict=True))
    return Body(float(masses.sum()), com, tensor)


@given(seeds)
def test_two_bodies_together_are_the_body_of_all_their_points(seed):
    rng = np.random.default_rng(seed)
    (m, x), (n, y) = points_of(rng), points_of(rng)
    both, whole = body_of(m, x) + body_of(n, y), body_of(np.r_[m, n], np.r_[x, y])
    assert close(both.mass, whole.mass)
    assert close(both.com, whole.com)
    assert close(both.inertia_com, whole.inertia_com)


@given(seeds)
def test_a_body_in_another_frame_is_that_of_the_moved_points(seed):
    rng = np.random.default_rng(seed)
    masses, places = points_of(rng)
    pose = random_arm(seed % 100).chain.links[0].pose(0.3)
    moved = body_of(masses, places @ pose.rotation.T + pose.position)
    assert close(body_of(masses, places).seen_from(pose).com, moved.com)
    assert close(body_of(masses, places).seen_from(pose).inertia_origin(), moved.inertia_origin())


@given(seeds)
def test_a_locked_chain_stands_where_the_whole_one_does(seed):
    rng = np.random.default_rng(seed)
    chain = random_arm(seed % 100).chain
    q, index = rng.uniform(-1, 1, chain.n), int(rng.integers(chain.n))
    *_, flange = link_frames(chain, q)
    *frames, locked_flange = link_frames(lock_joint(chain, index, float(q[index])), np.delete(q, index))
    assert close(locked_flange, flange)
    assert len(frames) == chain.n - 1


def test_mass_is_kept_by_a_lock_and_grows_by_a_payload():
    chain = random_arm(5).chain
    mass = sum(body.mass for body in chain.bodies)
    locked = lock_joint(chain, 1, 0.2)
    assert sum(body.mass for body in locked.bodies) == pytest.approx(mass, rel=ROUNDING)
    loaded = with_payload(chain, 3.0, com=(0.0, 0.0, 0.1))
    assert sum(body.mass for body in loaded.bodies) == pytest.approx(mass + 3.0, rel=ROUNDING)
    assert loaded.links[:-1] == chain.links[:-1]


@pytest.mark.parametrize("mass", [-1.0, np.nan, np.inf])
def test_a_payload_that_cannot_be_is_refused(mass):
    with pytest.raises(OptionError, match="payload mass"):
        with_payload(random_arm(5).chain, mass)


def test_the_first_links_end_in_the_frame_of_the_last_of_them():
    chain = random_arm(5).chain
    q = np.linspace(-0.5, 0.5, chain.n)
    *_, last, flange = link_frames(first_links(chain, 2), q[:2])
    np.testing.assert_array_equal(last, flange)
    np.testing.assert_array_equal(last, list(link_frames(chain, q))[1])
    assert first_links(chain, chain.n) is chain


def test_bodies_are_exchanged_link_by_link():
    chain = random_arm(5).chain
    bodies = [Body.massless()] * chain.n
    assert with_bodies(chain, bodies).bodies == tuple(bodies)
    assert (Body.massless() + Body.massless()).mass == 0.0


def test_a_turned_or_joined_body_has_an_exactly_symmetric_tensor():
    rng = np.random.default_rng(6)
    for _ in range(20):
        one, two = random_body(rng), random_body(rng)
        for body in (one.seen_from(random_pose(rng)), one.seen_from(random_pose(rng)) + two):
            assert np.array_equal(body.inertia_com, body.inertia_com.T)


def test_a_body_of_zeros_leaves_the_other_as_it_is():
    body = random_body(np.random.default_rng(7))
    for joined in (body + Body.massless(), Body.massless() + body):
        assert joined is body
