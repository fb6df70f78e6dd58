"""The recursion and the inertia seen at a joint: formulas by hand, and the diagonal of B by both roads."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics import recursion
from lwr_dyn.dynamics.seen_inertia import seen_inertia, seen_inertia_along
from lwr_dyn.model.chain import Body, Chain, ChainLink, JointKind, Rotor
from lwr_dyn.model.spatial import Pose, Vector, rot_z
from tests.random_arms import random_arm
from tests.tolerances import EXACT

G, MASS, LEVER, INERTIA = 9.81, 2.0, 0.4, 0.05
GRAVITY = Vector(0.0, -G, 0.0)
RATIO, SPIN_INERTIA = 100.0, 1e-4


def link(kind, lever=LEVER, rotor=None):
    body = Body(MASS, np.array([lever, 0.0, 0.0]), INERTIA * np.eye(3))
    return ChainLink("joint", "link", kind, Pose.identity(), Pose.identity(), body, rotor)


def constants(*links):
    return recursion.link_constants(Chain(links, Pose.identity(), np.array([0.0, -G, 0.0])))


@pytest.mark.parametrize(("rotors", "armature"), [("none", 0.0), ("armature", 1.0), ("full", 1.0)])
def test_a_pendulum_with_a_rotor(rotors, armature):
    links = constants(link(JointKind.REVOLUTE, rotor=Rotor(RATIO, SPIN_INERTIA)))
    q, dq, ddq = 0.3, 2.0, -1.5
    (tau,) = recursion.inverse_dynamics(links, GRAVITY, [q], [dq], [ddq], rotors)
    inertia = INERTIA + MASS * LEVER**2 + armature * RATIO**2 * SPIN_INERTIA
    assert tau == pytest.approx(inertia * ddq + MASS * G * LEVER * np.cos(q), rel=EXACT)
    assert recursion.potential_energy(links, GRAVITY, [q]) == pytest.approx(MASS * G * LEVER * np.sin(q), rel=EXACT)


def test_a_slider_on_a_turning_arm_has_coriolis_and_centrifugal_forces():
    along_x = Pose(np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]), np.zeros(3))  # z of the slider is x
    arm = ChainLink("turn", "arm", JointKind.REVOLUTE, Pose.identity(), Pose.identity())
    slider = ChainLink(
        "slide", "mass", JointKind.PRISMATIC, along_x, Pose.identity(), Body(MASS, np.zeros(3), np.zeros((3, 3)))
    )
    links = constants(arm, slider)
    (q, r), (omega, speed), (alpha, a) = (0.7, 0.5), (1.2, -0.8), (0.4, 0.9)
    torque, force = recursion.inverse_dynamics(links, GRAVITY, [q, r], [omega, speed], [alpha, a])
    weight = MASS * G
    assert torque == pytest.approx(MASS * (r**2 * alpha + 2 * r * speed * omega) + weight * r * np.cos(q), rel=EXACT)
    assert force == pytest.approx(MASS * (a - r * omega**2) + weight * np.sin(q), rel=EXACT)
    assert recursion.potential_energy(links, GRAVITY, [q, r]) == pytest.approx(weight * r * np.sin(q), rel=EXACT)


def test_a_link_without_body_and_rotor_weighs_nothing():
    (empty,) = constants(ChainLink("j", "l", JointKind.REVOLUTE, Pose.identity(), Pose.identity()))
    assert (empty.mass, empty.gear_ratio, empty.rotor_inertia, empty.before_is_identity) == (0.0, 0.0, 0.0, True)
    assert recursion.inverse_dynamics([empty], GRAVITY, [0.1], [2.0], [3.0]) == [0.0]


def test_rotation_and_lever():
    R = recursion.turn_about_z(0.4)
    v = R @ Vector(1.0, 2.0, 3.0)
    np.testing.assert_allclose([v.x, v.y, v.z], rot_z(0.4) @ [1.0, 2.0, 3.0], rtol=EXACT)
    a = recursion.lever_acceleration(Vector(0.0, 0.0, 2.0), Vector(0.0, 0.0, 3.0), Vector(0.5, 0.0, 0.0))
    assert (a.x, a.y, a.z) == (-2.0, 1.5, 0.0)  # -omega^2 r and domega r


def largest_difference(arm, engine, **options):
    """Of B_ii over states and joints, as a share of the largest."""
    q = np.random.default_rng(5).uniform(-3.0, 3.0, (40, arm.n))
    links = recursion.link_constants(arm.chain)
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
    links, q, values = (
        recursion.link_constants(arm.chain),
        rng.uniform(-3.0, 3.0, (4, arm.n)),
        rng.uniform(-3.0, 3.0, 5),
    )
    for j in range(1, arm.n):
        lines = np.repeat(q[:, None], 5, axis=1)
        lines[:, :, j] = values
        each = seen_inertia(links, lines.reshape(-1, arm.n)).reshape(4, 5)
        np.testing.assert_allclose(seen_inertia_along(links, q, j, values), each, rtol=1e-14)


@pytest.mark.parametrize("seed", range(6))
def test_so_it_is_of_arms_with_any_frames_and_sliding_joints(seed):
    assert largest_difference(random_arm(seed), "newton-euler", rotors="none") < 1e-13
