"""The closed form of S-R-S arms meets any pose on every branch; rates of a motion against its differences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, OutOfReachError, ShapeError, SingularArmError
from lwr_dyn.kinematics.arm_geometry import require_srs, srs_geometry
from lwr_dyn.kinematics.forward import jacobian, joint_axes, velocity_product_at
from lwr_dyn.kinematics.solution import BRANCHES, joint_ranges, wrap
from lwr_dyn.kinematics.srs import _ball_angles, arm_triangle, closed_form, follow
from lwr_dyn.model.chain import link_frames
from lwr_dyn.model.spatial import rot_y, rot_z
from tests.kinematics.srs_arms import each_branch, fk, random_srs_arm
from tests.random_arms import random_arm

RESIDUAL = 1e-12
"""Largest entry of FK(q) - T."""
LWR = lwr_dyn.load("lwr4plus")
G, RANGES = srs_geometry(LWR.chain), joint_ranges(LWR)


def test_constants_follow_from_the_axes():
    """Lengths of the WAM are the hypotenuses over the offset of its elbow."""
    lwr, wam = srs_geometry(LWR.chain), srs_geometry(lwr_dyn.load("wam7").chain)
    assert lwr.lengths == pytest.approx((0.40, 0.39))
    assert lwr.wrist_in_flange == pytest.approx([0, 0, -0.078])
    assert (lwr.straight, lwr.first.offset, lwr.last.offset) == (0, 0, 0)
    assert wam.lengths == pytest.approx((np.hypot(0.55, 0.045), np.hypot(0.3, 0.045)), rel=1e-14)
    assert wam.straight == pytest.approx(np.arctan2(0.045, 0.55) + np.arctan2(0.045, 0.3), rel=1e-14)


def test_arms_that_are_not_s_r_s_are_refused():
    assert srs_geometry(random_srs_arm(5).chain) is not None
    others = [random_arm(2, joints) for joints in ("RRRRRR", "RRRPRRR")]
    for arm in (random_srs_arm(5, wrist_off_plane=0.01), *others):
        assert srs_geometry(arm.chain) is None
    for arm, reference, error, words in (
        (random_arm(2, "RRRRRRR"), None, OptionError, "seven-joint"),
        (LWR, [0, 0, 0], OptionError, "not zero"),
        (LWR, [0, 0], ShapeError, "reference"),
    ):
        with pytest.raises(error, match=words):
            require_srs(arm, reference)


@given(st.integers(0, 10**6))
def test_every_branch_of_any_such_arm_at_any_arm_angle_meets_the_pose(seed):
    arm, rng = random_srs_arm(seed), np.random.default_rng(seed)
    geometry, ranges = srs_geometry(arm.chain), joint_ranges(arm)
    T, signs = each_branch(fk(arm, rng.uniform(-3, 3, (20, 7))))
    psi = rng.uniform(-np.pi, np.pi, len(T))
    q = closed_form(geometry, ranges, T, psi, signs)
    assert np.abs(fk(arm, q) - T).max() <= RESIDUAL
    tilts = q[:, [1, 3, 5]] + [geometry.first.offset, -geometry.straight, geometry.last.offset]
    assert (np.sign(np.sin(tilts)) == signs).all()
    assert (np.abs(q - ranges.middle) <= np.pi).all()


@pytest.mark.parametrize("name", ["lwr4plus", "wam7"])
def test_one_branch_and_arm_angle_give_back_the_positions_the_pose_came_from(name):
    arm = lwr_dyn.load(name)
    geometry, q = srs_geometry(arm.chain), np.random.default_rng(3).uniform(arm.lower, arm.upper, (500, 7))
    triangle, axes = arm_triangle(geometry, fk(arm, q)), joint_axes(arm.chain, q)
    z, to_axis = axes.z[:, 3], axes.p[:, 3] - geometry.shoulder
    elbow = to_axis - z * (z * to_axis).sum(-1, keepdims=True)
    across = np.cross(triangle.u, triangle.up)
    psi = np.arctan2((elbow * across).sum(-1), (elbow * triangle.up).sum(-1))
    tilts = q[:, [1, 3, 5]] + [geometry.first.offset, -geometry.straight, geometry.last.offset]
    again = closed_form(geometry, joint_ranges(arm), fk(arm, q), psi, np.sign(np.sin(tilts)))
    # the elbow direction of a nearly straight arm is read off short lengths
    assert np.abs(wrap(again - q)).max() < 1e-9


def test_zero_of_the_arm_angle_is_the_elbow_above_the_line_to_the_wrist_and_a_reference_turns_it_only():
    T = fk(LWR, np.array([[0.3, 0.9, 0.2, -1.2, 0.1, 0.7, 0.0]]))
    up, side = (closed_form(G, RANGES, T, np.array([psi]), BRANCHES[0]) for psi in (0.0, np.pi / 2))
    w = T[0, :3, 3] + T[0, :3, :3] @ G.wrist_in_flange
    for q, direction in ((up, [0, 0, 1]), (side, np.cross(w, [0, 0, 1]))):
        elbow = list(link_frames(LWR.chain, q))[2][0, :3, 3]
        off = elbow - (elbow @ w) / (w @ w) * w
        square = np.array(direction) - (np.array(direction) @ w) / (w @ w) * w
        assert off @ square == pytest.approx(np.linalg.norm(off) * np.linalg.norm(square))
    T = fk(LWR, np.array([[0.3, 0.9, 0.2, -1.2, 0.1, 0.7, 0.0]]))
    other = require_srs(LWR, [2.0, 0.0, 0.0])
    up = arm_triangle(other, T).up[0]
    old = arm_triangle(G, T)
    psi = np.arctan2(up @ np.cross(old.u[0], old.up[0]), up @ old.up[0])
    a = closed_form(other, RANGES, T, np.array([0.5]), BRANCHES[3])
    b = closed_form(G, RANGES, T, np.array([0.5 + psi]), BRANCHES[3])
    assert a == pytest.approx(b)


@pytest.mark.parametrize(
    ("joints", "value"),
    [
        *((joints, 0.0) for joints in ((1, 3, 5), (1,), (3,), (5,), (1, 3), (3, 5), (1, 5), range(7))),
        *(((1, 5), tilt) for tilt in (1e-5, 1e-8, 1e-11, 1e-14)),
    ],
)
def test_aligned_and_nearly_aligned_joints_keep_the_residual(joints, value):
    q = np.random.default_rng(1).uniform(LWR.lower, LWR.upper, (50, 7))
    q[:, list(joints)] = value
    T, signs = each_branch(fk(LWR, q))
    for psi in (-2.0, 0.0, 0.4):
        result = closed_form(G, RANGES, T, np.full(len(T), psi), signs)
        assert np.abs(fk(LWR, result) - T).max() <= RESIDUAL


@pytest.mark.parametrize("tilt", [0.0, np.pi])
@pytest.mark.parametrize("seed", range(5))
def test_aligned_rolls_share_their_sum_evenly_between_their_ranges(tilt, seed):
    a, c, *middle = np.random.default_rng(seed).uniform(-1, 1, 5)
    M = rot_z(a) @ rot_y(tilt) @ rot_z(c)
    roll, found_tilt, second = _ball_angles(M[None], G.first, np.ones(1), np.array(middle))[0]
    assert rot_z(roll) @ rot_y(found_tilt) @ rot_z(second) == pytest.approx(M, abs=1e-12)
    assert abs(wrap(roll - middle[0])) == pytest.approx(abs(wrap(second - middle[2])))


def test_wrist_on_the_axis_of_joint_1_counts_from_x():
    T = fk(LWR, np.array([[0.0, 0.6, 0.0, -1.2, 0.0, 0.3, 0.0]]))
    w = T[0, :3, 3] + T[0, :3, :3] @ G.wrist_in_flange
    T[0, :2, 3] -= w[:2]
    triangle = arm_triangle(G, T)
    assert triangle.up[0] == pytest.approx([1, 0, 0])
    q = closed_form(G, RANGES, T, np.array([0.0]), BRANCHES[2])
    elbow = list(link_frames(LWR.chain, q))[2][0, :3, 3]
    assert elbow[0] > 0.1
    assert abs(elbow[1]) < RESIDUAL
    assert np.abs(fk(LWR, q) - T).max() <= RESIDUAL


STEP = 2e-3
DIFFERENCES = 1e-8
"""Sixth-order central differences at 2 ms of a motion of about 1 rad/s: rounding / step and step^6 balance here."""
TASK = 1e-9
"""Velocity and acceleration met by dq and ddq, [m/s, rad/s]; the extended Jacobian's condition times rounding."""
WEIGHTS = {1: 45.0, 2: -9.0, 3: 1.0}


def velocity_product(chain, q, dq):
    """dJ/dt dq of the flange."""
    axes = joint_axes(chain, q)
    return velocity_product_at(axes, axes.flange[..., :3, 3], dq)


def around(T0):
    """A smooth motion around a pose: T, velocity, acceleration, psi, dpsi, ddpsi at times t, all in closed form."""

    def at(t):
        x, dx, ddx = 0.1 * np.sin(t), 0.1 * np.cos(t), -0.1 * np.sin(t)
        shape = np.array([1.0, -0.5, 0.7])
        turn, dturn, ddturn = 0.4 * np.sin(0.8 * t), 0.32 * np.cos(0.8 * t), -0.256 * np.sin(0.8 * t)
        axis = np.array([2.0, -1.0, 2.0]) / 3.0
        T = np.tile(T0, (len(t), 1, 1))
        T[:, :3, 3] += x[:, None] * shape
        T[:, :3, :3] = Rotation.from_rotvec(turn[:, None] * axis).as_matrix() @ T0[:3, :3]
        velocity = np.hstack([dx[:, None] * shape, dturn[:, None] * axis])
        acceleration = np.hstack([ddx[:, None] * shape, ddturn[:, None] * axis])
        return T, velocity, acceleration, 0.5 * np.sin(t) + 0.3, 0.5 * np.cos(t), -0.5 * np.sin(t)

    return at


def difference(f, t):
    """Of angles within half a turn: a step over the seam is a small step."""
    steps = {i: f(t + i * STEP) - f(t - i * STEP) for i in WEIGHTS}
    return sum(w * (np.mod(steps[i] + np.pi, 2 * np.pi) - np.pi) for i, w in WEIGHTS.items()) / (60.0 * STEP)


def lwr_motion():
    return around(lwr_dyn.forward_kinematics(LWR, [0.3, 0.7, 0.2, -1.3, 0.4, 0.9, 0.1]))


@pytest.mark.parametrize("branch", BRANCHES, ids=lambda b: b.label)
def test_rates_are_those_of_the_closed_form(branch):
    motion, t = lwr_motion(), np.linspace(0, 3, 60)
    _, dq, ddq = follow(LWR, branch, *motion(t))
    assert np.abs(difference(lambda x: follow(LWR, branch, *motion(x))[0], t) - dq).max() < DIFFERENCES
    assert np.abs(difference(lambda x: follow(LWR, branch, *motion(x))[1], t) - ddq).max() < DIFFERENCES * 10


@pytest.mark.parametrize("seed", range(8))
def test_any_arm_and_any_reference(seed):
    arm, rng = random_srs_arm(seed, (6.0, 7.0)), np.random.default_rng(seed)
    q = rng.uniform(-1.5, 1.5, 7)
    q[3] = srs_geometry(arm.chain).straight + 1.6
    motion, t = around(lwr_dyn.forward_kinematics(arm, q)), np.linspace(0, 0.3, 5)
    reference, branch = rng.normal(size=3), BRANCHES[seed]
    q, dq, ddq = follow(arm, branch, *motion(t), reference=reference)
    T, velocity, acceleration = motion(t)[:3]
    *_, pose = link_frames(arm.chain, q)
    assert np.abs(pose - T).max() < 1e-12
    assert np.abs(np.einsum("kij,kj->ki", jacobian(arm.chain, q), dq) - velocity).max() < TASK
    met = np.einsum("kij,kj->ki", jacobian(arm.chain, q), ddq) + velocity_product(arm.chain, q, dq)
    assert np.abs(met - acceleration).max() < TASK * (1 + np.abs(ddq).max())
    scale = 1 + np.abs(ddq).max()
    rate = difference(lambda x: follow(arm, branch, *motion(x), reference=reference)[0], t)
    assert np.abs(rate - dq).max() < 1e-6 * scale
    change = difference(lambda x: follow(arm, branch, *motion(x), reference=reference)[1], t)
    assert np.abs(change - ddq).max() < 1e-4 * scale**2


def test_turning_the_elbow_alone_leaves_the_flange_where_it_is():
    T = lwr_dyn.forward_kinematics(LWR, [0.3, 0.7, 0.2, -1.3, 0.4, 0.9, 0.1])[None]
    one, none = np.ones(1), np.zeros((1, 6))
    q, dq, ddq = follow(LWR, BRANCHES[2], T, none, none, 0.4 * one, one, 0 * one)
    assert np.abs(jacobian(LWR.chain, q[0]) @ dq[0]).max() < 1e-13
    assert abs(dq[0, 3]) < 1e-13
    assert np.abs(jacobian(LWR.chain, q[0]) @ ddq[0] + velocity_product(LWR.chain, q[0], dq[0])).max() < 1e-12


@pytest.mark.parametrize(
    ("q", "why"),
    [
        ([0.3, 0.7, 0.2, 0.0, 0.4, 0.9, 0.1], "stretched"),
        ([0.3, 0.7, 0.2, -1.3, 0.4, 0.0, 0.1], "wrist are aligned"),
        ([0.3, 0.0, 0.2, -1.3, 0.4, 0.9, 0.1], "shoulder are aligned"),
    ],
)
def test_singular_arms_stand_still_or_are_refused(q, why):
    T = np.tile(lwr_dyn.forward_kinematics(LWR, q), (3, 1, 1))
    none, flat = np.zeros((3, 6)), np.zeros(3)
    elbow = list(link_frames(LWR.chain, np.array(q)))[2][:3, 3]
    w = T[0, :3, 3] - 0.078 * T[0, :3, 2]
    u = w / np.linalg.norm(w)
    up = np.array([0, 0, 1.0]) - u[2] * u
    psi = np.full(3, np.arctan2(elbow @ np.cross(u, up), elbow @ up))
    assert (follow(LWR, BRANCHES[2], T, none, none, psi, flat, flat)[1] == 0).all()
    moving = none.copy()
    moving[1, 0] = 0.1
    with pytest.raises(SingularArmError, match=why) as caught:
        follow(LWR, BRANCHES[2], T, moving, none, psi, flat, flat)
    assert caught.value.index == 1


def test_a_stretched_wam_is_singular_where_its_elbow_is_in_line():
    wam, none = lwr_dyn.load("wam7"), np.zeros((2, 6))
    q = [0.3, 0.7, 0.2, srs_geometry(wam.chain).straight, 0.4, 0.9, 0.1]
    T = np.tile(lwr_dyn.forward_kinematics(wam, q), (2, 1, 1))
    with pytest.raises(SingularArmError, match="stretched"):
        follow(wam, BRANCHES[2], T, none + np.eye(6)[0], none, np.full(2, 0.4), np.zeros(2), np.zeros(2))


def test_on_the_line_of_a_tilted_reference_the_elbow_counts_from_a_direction_across_it():
    other = require_srs(LWR, [1.0, 2.0, 3.0])
    T = np.tile(np.eye(4), (2, 1, 1))
    T[0, :3, 3] = np.array([1.0, 2.0, 3.0]) / 8.0 - other.wrist_in_flange + other.shoulder
    T[1, :3, 3] = [0.4, 0.1, 0.3]
    triangle = arm_triangle(other, T)
    assert triangle.u[0] == pytest.approx(other.reference)
    assert (triangle.u * triangle.up).sum(-1) == pytest.approx([0.0, 0.0], abs=1e-15)
    assert np.linalg.norm(triangle.up, axis=1) == pytest.approx([1.0, 1.0])


def test_bad_input_is_named():
    T, v, a, *psi = lwr_motion()(np.linspace(0, 1, 4))
    far = T.copy()
    far[2, :3, 3] *= 9
    for arm, poses, speeds, angle, error, words in (
        (LWR, T, v[:3], psi[0], ShapeError, "velocity"),
        (LWR, T, v, psi[0][:, None], ShapeError, "psi"),
        (random_arm(2, "RRRRRR"), T, v, psi[0], OptionError, "seven-joint"),
        (LWR, far, v, psi[0], OutOfReachError, "row = 2"),
    ):
        with pytest.raises(error, match=words):
            follow(arm, BRANCHES[0], poses, speeds, a, angle, *psi[1:])
