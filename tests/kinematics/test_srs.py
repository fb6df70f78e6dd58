import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.kinematics.arm_geometry import require_srs, srs_geometry
from lwr_dyn.kinematics.solution import BRANCHES, joint_ranges, wrap
from lwr_dyn.kinematics.srs import _ball_angles, arm_triangle, closed_form
from lwr_dyn.model.chain import link_frames
from lwr_dyn.model.spatial import rot_y, rot_z
from tests.kinematics.srs_arms import each_branch, fk, random_srs_arm

RESIDUAL = 1e-12
"""Largest entry of FK(q) - T."""
LWR = lwr_dyn.load("lwr4plus")
G, RANGES = srs_geometry(LWR.chain), joint_ranges(LWR)


@given(st.integers(0, 10**6))
def test_every_branch_of_any_such_arm_at_any_arm_angle_meets_the_pose(seed):
    arm, rng = random_srs_arm(seed), np.random.default_rng(seed)
    geometry, ranges = srs_geometry(arm.chain), joint_ranges(arm)
    T, signs = each_branch(fk(arm, rng.uniform(-3, 3, (20, 7))))
    psi = rng.uniform(-np.pi, np.pi, len(T))
    q = closed_form(geometry, ranges, T, psi, signs)
    assert np.abs(fk(arm, q) - T).max() <= RESIDUAL
    tilts = np.stack(
        [q[:, 1] + geometry.first.offset, q[:, 3] - geometry.straight, q[:, 5] + geometry.last.offset], axis=1
    )
    assert (np.sign(np.sin(tilts)) == signs).all()
    assert (np.abs(q - ranges.middle) <= np.pi).all()


def test_one_branch_and_arm_angle_give_back_the_positions_the_pose_came_from():
    q = np.random.default_rng(3).uniform(LWR.lower, LWR.upper, (500, 7))
    T = fk(LWR, q)
    triangle = arm_triangle(G, T)
    elbow = np.stack(list(link_frames(LWR.chain, q)))[2, :, :3, 3]
    psi = np.arctan2(
        np.einsum("ki,ki->k", elbow, np.cross(triangle.u, triangle.up)), np.einsum("ki,ki->k", elbow, triangle.up)
    )
    again = closed_form(G, RANGES, T, psi, np.sign(q[:, [1, 3, 5]]))
    # the elbow direction of a nearly straight arm is read off short lengths
    assert np.abs(wrap(again - q)).max() < 1e-9


def test_zero_of_the_arm_angle_is_the_elbow_above_the_line_from_shoulder_to_wrist():
    T = fk(LWR, np.array([[0.3, 0.9, 0.2, -1.2, 0.1, 0.7, 0.0]]))
    up, side = (closed_form(G, RANGES, T, np.array([psi]), BRANCHES[0]) for psi in (0.0, np.pi / 2))
    w = T[0, :3, 3] + T[0, :3, :3] @ G.wrist_in_flange
    for q, direction in ((up, [0, 0, 1]), (side, np.cross(w, [0, 0, 1]))):
        elbow = list(link_frames(LWR.chain, q))[2][0, :3, 3]
        off = elbow - (elbow @ w) / (w @ w) * w
        square = np.array(direction) - (np.array(direction) @ w) / (w @ w) * w
        assert off @ square == pytest.approx(np.linalg.norm(off) * np.linalg.norm(square))


@pytest.mark.parametrize("zero", [(1, 3, 5), (1,), (3,), (5,), (1, 3), (3, 5), (1, 5), range(7)])
def test_aligned_joints_are_solved(zero):
    q = np.random.default_rng(1).uniform(LWR.lower, LWR.upper, (50, 7))
    q[:, list(zero)] = 0.0
    T, signs = each_branch(fk(LWR, q))
    for psi in (-2.0, 0.0, 1.0):
        result = closed_form(G, RANGES, T, np.full(len(T), psi), signs)
        assert np.abs(fk(LWR, result) - T).max() <= RESIDUAL


@pytest.mark.parametrize("tilt", [1e-5, 1e-8, 1e-11, 1e-14])
def test_nearly_aligned_joints_keep_the_residual(tilt):
    q = np.random.default_rng(1).uniform(LWR.lower, LWR.upper, (50, 7))
    q[:, [1, 5]] = tilt
    T, signs = each_branch(fk(LWR, q))
    result = closed_form(G, RANGES, T, np.full(len(T), 0.4), signs)
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


def test_another_reference_turns_the_zero_only():
    T = fk(LWR, np.array([[0.3, 0.9, 0.2, -1.2, 0.1, 0.7, 0.0]]))
    other = require_srs(LWR, [2.0, 0.0, 0.0])
    up = arm_triangle(other, T).up[0]
    old = arm_triangle(G, T)
    psi = np.arctan2(up @ np.cross(old.u[0], old.up[0]), up @ old.up[0])
    a = closed_form(other, RANGES, T, np.array([0.5]), BRANCHES[3])
    b = closed_form(G, RANGES, T, np.array([0.5 + psi]), BRANCHES[3])
    assert a == pytest.approx(b)
