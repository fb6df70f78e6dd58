"""Bodies add up and are clouds of mass points; a changed chain is the same mechanism: payloads, locks, first links."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.chain import (
    Body,
    Convention,
    DHRow,
    JointKind,
    Rotor,
    first_links,
    is_physical,
    joint_motion,
    link_frames,
    lock_joint,
    unphysical_links,
    with_bodies,
    with_payload,
)
from lwr_dyn.model.spatial import Pose, from_rpy, rot_x, rot_y, rot_z
from tests.random_arms import arms, random_arm, random_body, random_pose

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


@pytest.mark.parametrize("sign", [1, -1])
def test_a_row_is_its_product_of_rotations_and_shifts(sign):
    """Standard: motion, Rz(theta) and d, then a and alpha; modified: a and alpha before. Sign -1: axis over."""

    def shift(*p):
        return Pose(np.eye(3), np.array(p))

    def turn(rotation):
        return Pose(rotation, np.zeros(3))

    row = DHRow(0.4, 0.3, 0.2, 0.7, sign, -0.1)
    bend = shift(0.3, 0.0, 0.0) @ turn(rot_x(0.4)) @ turn(rot_y(-0.1))
    rise = shift(0.0, 0.0, 0.2) @ turn(rot_z(0.7))
    for convention, first, last in (
        (Convention.STANDARD, Pose.identity(), rise @ bend),
        (Convention.MODIFIED, bend, rise),
    ):
        before, after = row.fixed_poses(convention)
        for q in (0.0, 0.5):
            whole = before @ joint_motion(JointKind.REVOLUTE, q) @ after
            wanted = first @ joint_motion(JointKind.REVOLUTE, sign * q) @ last
            np.testing.assert_allclose(whole.matrix(), wanted.matrix(), atol=1e-15)
            slid = before @ joint_motion(JointKind.PRISMATIC, q) @ after
            np.testing.assert_allclose(
                slid.matrix(), (first @ joint_motion(JointKind.PRISMATIC, sign * q) @ last).matrix(), atol=1e-15
            )


def test_unknown_parts_of_bodies_stay_unknown():
    body = Body(1.0, np.array([0.1, 0.0, 0.0]), np.eye(3), (4, 6))
    assert body.seen_from(Pose.identity()).unknown == (4, 6)
    assert body.seen_from(Pose(np.eye(3), np.array([0.0, 0.0, 1e-9]))).unknown == tuple(range(10))
    assert (body + Body(1.0, np.zeros(3), np.eye(3), (2, 6))).unknown == (2, 4, 6)
    assert is_physical(replace(body, inertia_com=-np.eye(3)))
    assert not Body(0.0, np.zeros(3), np.zeros((3, 3)), (0,)).is_weightless
    assert not Body(0.0, np.zeros(3), np.eye(3)).is_weightless
    moments = Body(0.0, np.zeros(3), np.eye(3)) + Body(0.0, np.zeros(3), 2.0 * np.eye(3))
    assert (moments.mass, moments.inertia_com.tolist()) == (0.0, (3.0 * np.eye(3)).tolist())
    assert Rotor(-50.0, 2e-4).armature == pytest.approx(0.5)
    for far in (Body(1.0, np.array([np.inf, 0, 0]), np.eye(3)), Body(np.inf, np.zeros(3), np.eye(3))):
        assert not is_physical(far)


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


TENSORS = {
    "negative moment": np.diag([-0.1, 1.0, 1.0]),
    "triangle inequality": np.diag([1.0, 1.0, 2.001]),
    "indefinite by a product": np.array([[1.0, 1.5, 0.0], [1.5, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    "not symmetric": np.array([[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    "not a number": np.full((3, 3), np.nan),
}


@given(arms)
def test_clouds_of_mass_points_are_bodies(arm):
    assert unphysical_links(arm.chain) == ()


@given(st.integers(0, 10**6))
def test_turned_borders_stay_inside_and_a_step_further_is_outside(seed):
    rng = np.random.default_rng(seed)
    R = from_rpy(rng.uniform(-3, 3, 3))
    moments = np.array([a := rng.uniform(0.1, 1), b := rng.uniform(0.1, 1), a + b])  # a lamina
    assert is_physical(Body(1.0, np.zeros(3), R @ np.diag(moments) @ R.T))
    beyond = moments * [1, 1, 1 + 1e-6]
    assert not is_physical(Body(1.0, np.zeros(3), R @ np.diag(beyond) @ R.T))


@pytest.mark.parametrize("fault", TENSORS)
def test_no_body_has_it(fault):
    assert not is_physical(Body(1.0, np.zeros(3), TENSORS[fault]))


@pytest.mark.parametrize(
    ("mass", "inertia", "physical"),
    [(0.0, 0.0, True), (0.0, 1.0, False), (-1.0, 1.0, False), (1.0, 0.0, True), (np.nan, 1.0, False)],
)
def test_mass_and_inertia_go_together(mass, inertia, physical):
    assert is_physical(Body(mass, np.zeros(3), inertia * np.eye(3))) is physical


def test_the_link_is_named():
    arm = random_arm(5, "RRR")
    bodies = [random_body(np.random.default_rng(i)) for i in range(3)]
    bodies[1] = Body(1.0, np.zeros(3), TENSORS["triangle inequality"])
    assert unphysical_links(with_bodies(arm.chain, bodies)) == ("link_2",)


def test_links_without_a_body_do_not_count():
    assert unphysical_links(lwr_dyn.load("lwr4").chain) == ()


def test_readings_and_a_point_payload_are_physical():
    for reading in lwr_dyn.readings("lwr4plus"):
        chain = lwr_dyn.load("lwr4plus", reading).chain
        assert unphysical_links(chain) == ()
        assert unphysical_links(with_payload(chain, 3.0, (0.0, 0.0, 0.1))) == ()
