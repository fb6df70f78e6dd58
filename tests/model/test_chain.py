"""Bodies add up and are clouds of mass points; a changed chain is the same mechanism: payloads, locks, first links."""

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
    Installation,
    JointKind,
    Rotor,
    Tool,
    first_links,
    is_physical,
    joint_motion,
    link_frames,
    lock_joint,
    names_of_ends,
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
    loaded = with_payload(chain, 3.0, com=(0.0, 0.0, 0.1))
    for changed, expected in ((lock_joint(chain, 1, 0.2), mass), (loaded, mass + 3.0)):
        assert sum(body.mass for body in changed.bodies) == pytest.approx(expected, rel=ROUNDING)
    assert loaded.links[:-1] == chain.links[:-1]
    assert with_payload(chain, 0.0).bodies == chain.bodies
    assert not any(x.flags.writeable for x in (chain.gravity, chain.flange.position, chain.bodies[0].com))
    for impossible in (-1e-9, np.nan, np.inf):
        with pytest.raises(OptionError, match=r"payload mass: .*; allowed: a number >= 0, in kg"):
            with_payload(chain, impossible)


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
        for q, kind in ((0.0, JointKind.REVOLUTE), (0.5, JointKind.REVOLUTE), (0.5, JointKind.PRISMATIC)):
            whole = before @ joint_motion(kind, q) @ after
            wanted = first @ joint_motion(kind, sign * q) @ last
            np.testing.assert_allclose(whole.matrix(), wanted.matrix(), atol=1e-15)


def test_joined_bodies_keep_what_is_unknown_and_exactly_symmetric_tensors_and_zeros_change_nothing():
    body = Body(1.0, np.array([0.1, 0.0, 0.0]), np.eye(3), (4, 6))
    assert body.seen_from(Pose.identity()).unknown == (4, 6)
    assert body.seen_from(Pose(np.eye(3), np.array([0.0, 0.0, 1e-9]))).unknown == tuple(range(10))
    assert (body + Body(1.0, np.zeros(3), np.eye(3), (2, 6))).unknown == (2, 4, 6)
    assert not Body(0.0, np.zeros(3), np.zeros((3, 3)), (0,)).is_weightless
    assert not Body(0.0, np.zeros(3), np.eye(3)).is_weightless
    moments = Body(0.0, np.zeros(3), np.eye(3)) + Body(0.0, np.zeros(3), 2.0 * np.eye(3))
    assert (moments.mass, moments.inertia_com.tolist()) == (0.0, (3.0 * np.eye(3)).tolist())
    assert Rotor(-50.0, 2e-4).armature == pytest.approx(0.5)
    rng = np.random.default_rng(6)
    for _ in range(20):
        one, two = random_body(rng), random_body(rng)
        for body in (one.seen_from(random_pose(rng)), one.seen_from(random_pose(rng)) + two):
            assert np.array_equal(body.inertia_com, body.inertia_com.T)
    for joined in (one + Body.massless(), Body.massless() + one):
        assert joined is one
    assert (Body.massless() + Body.massless()).mass == 0.0


def test_the_first_links_end_in_the_frame_of_the_last_of_them():
    chain = random_arm(5).chain
    q = np.linspace(-0.5, 0.5, chain.n)
    *_, last, flange = link_frames(first_links(chain, 2), q[:2])
    np.testing.assert_array_equal(last, flange)
    np.testing.assert_array_equal(last, list(link_frames(chain, q))[1])
    assert first_links(chain, chain.n) is chain


def test_the_ends_of_a_chain_are_named():
    chain, turned = random_arm(5).chain, Pose(rot_x(0.1), np.zeros(3))
    for mount, frame, names in (
        (None, Pose.identity(), ("base", "flange")), (turned, Pose.identity(), ("world", "flange")),
        (None, turned, ("base", "tool centre point")), (turned, turned, ("world", "tool centre point")),
    ):  # fmt: skip
        assert names_of_ends(Installation.of(chain, mount, Tool(frame))) == names
    assert names_of_ends(None) == ("base", "flange")


LAMINA = np.diag([1.0, 1.0, 2.0])
JUDGED = [
    (1.0, np.diag([-0.1, 1.0, 1.0]), False), (1.0, LAMINA, True), (1.0, np.diag([1.0, 1.0, 2.001]), False),
    (1.0, np.array([[1.0, 1.5, 0.0], [1.5, 1.0, 0.0], [0.0, 0.0, 1.0]]), False),  # indefinite by a product
    (1.0, np.array([[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), False),  # not symmetric
    (1.0, np.full((3, 3), np.nan), False), (np.nan, np.eye(3), False), (np.inf, np.eye(3), False),
    (-1.0, np.eye(3), False), (0.0, np.eye(3), False), (0.0, np.zeros((3, 3)), True), (1.0, np.zeros((3, 3)), True),
    (1.0, LAMINA + np.diag([0.0, 0.0, 1.9e-12]), True), (1.0, LAMINA + np.diag([0.0, 0.0, 2.1e-12]), False),
    (1.0, np.diag([-0.9e-12, 1.0, 1.0]), True), (1.0, np.diag([-1.1e-12, 1.0, 1.0]), False),
]  # fmt: skip


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


@pytest.mark.parametrize(("mass", "inertia", "physical"), JUDGED)
def test_what_mass_and_inertia_a_body_can_have(mass, inertia, physical):
    assert is_physical(Body(mass, np.zeros(3), inertia)) is physical
    assert is_physical(Body(mass, np.zeros(3), inertia, (4,)))  # with an unknown part it is not judged
    assert not is_physical(Body(mass, np.array([np.inf, 0, 0]), inertia))


def test_bodies_are_exchanged_link_by_link_and_an_impossible_one_is_named():
    chain = random_arm(5, "RRR").chain
    bodies = [random_body(np.random.default_rng(i)) for i in range(3)]
    bodies[1] = Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 2.001]))
    assert with_bodies(chain, bodies).bodies == tuple(bodies)
    assert unphysical_links(with_bodies(chain, bodies)) == ("link_2",)
    assert unphysical_links(lwr_dyn.load("lwr4").chain) == ()  # without a body nothing is judged
    for reading in lwr_dyn.readings("lwr4plus"):
        known = lwr_dyn.load("lwr4plus", reading).chain
        assert unphysical_links(known) == unphysical_links(with_payload(known, 3.0, (0.0, 0.0, 0.1))) == ()
