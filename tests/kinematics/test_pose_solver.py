"""One solution of a pose: reached to 1e-9 inside the limits, or an error that says by how much it is not."""

from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, PoseNotReachedError, ShapeError, UnknownNameError
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.kinematics.pose_solver import (
    FOUND,
    NOT_REACHED,
    OUTSIDE,
    POSE_SEARCHES,
    PinocchioSearch,
    PoseSolver,
    pinocchio_search,
    pose_error,
    search_ranges,
    with_turns,
)
from lwr_dyn.model.arm import JointLimits
from tests.kinematics.solved_poses import arm_named, assert_reached, solver_of
from tests.public_arms import random_positions, singular_positions
from tests.random_arms import random_arm

SEARCHES = tuple(name for name in POSE_SEARCHES.rows if name != "kernel" or find_spec("llvmlite"))
KERNEL_SLOW = [pytest.param(x, marks=[pytest.mark.slow] * (x == "kernel")) for x in SEARCHES]


@pytest.mark.parametrize("limits", [True, False])
@pytest.mark.parametrize("search", KERNEL_SLOW)
def test_a_batch_and_a_miss(search, limits):
    """What each row says: found and near q0, outside the limits, out of reach with the distance; and so the error."""
    arm = arm_named("kr30ha")
    q = (arm.lower + arm.upper) / 2 + 0.1
    beyond = np.where(np.arange(6) == 1, arm.upper[1] + 0.3, q)
    poses = lwr_dyn.forward_kinematics(arm, np.array([q, beyond]))
    far = poses[0].copy()
    far[:3, 3] *= 10.0
    solve = lwr_dyn.ik_solver(arm, search=search, starts=3, limits=limits)
    found = solve.batch(np.array([poses[0], poses[1], far]), np.array([q + 0.01, beyond + 0.01, q]))
    assert found.found.tolist() == [True, not limits, False]
    assert found.outside.tolist() == [False, limits, False]
    np.testing.assert_allclose(found.q[0], q, atol=1e-6)
    assert np.isnan(found.q[2]).all()
    assert found.distance[0] < 1e-9
    with pytest.raises(PoseNotReachedError, match=r"m and .* rad off") as caught:
        solve(far, q)
    assert caught.value.distance == pytest.approx(found.distance[2], rel=1e-9)
    reached = lwr_dyn.forward_kinematics(arm, caught.value.q)
    assert np.linalg.norm(reached[:3, 3] - far[:3, 3]) == pytest.approx(caught.value.distance, abs=1e-9)
    assert (caught.value.joint, caught.value.excess) == (None, 0.0)
    if limits:
        with pytest.raises(PoseNotReachedError, match="limits") as caught:
            solve(poses[1], beyond)
        joint = arm.joint_names.index(caught.value.joint)
        excess = np.maximum(arm.lower - caught.value.q, caught.value.q - arm.upper)
        assert (joint, caught.value.excess) == (int(np.argmax(excess)), pytest.approx(excess.max()))
        np.testing.assert_allclose(lwr_dyn.forward_kinematics(arm, caught.value.q), poses[1], atol=1e-8)
    else:
        np.testing.assert_allclose(solve(poses[1], beyond), beyond, atol=1e-6)
    np.testing.assert_allclose(solve.near(poses[0], q + 0.01), q, atol=1e-6)
    with pytest.raises(PoseNotReachedError):
        solve.near(far, q)


@pytest.mark.slow
@pytest.mark.parametrize("search", SEARCHES)
def test_the_turns_of_an_endless_joint_are_those_of_q0(search):
    arm = arm_named("j2n6s300")
    q = random_positions(arm, 1, seed=8)[0]
    T = lwr_dyn.forward_kinematics(arm, q)
    turned = q + 2 * np.pi * np.array([3, 0, 0, -2, 1, 0])
    solve = solver_of("j2n6s300", search)
    assert np.abs(solve(T, turned) - turned).max() < 1e-6
    assert np.abs(solve.near(T, turned + 1e-3) - turned).max() < 1e-6
    assert (np.abs(solve(T)) < np.pi + 1e-12).all()


@pytest.mark.slow
@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("joints", ["PRP", "RRPRRPR"])
def test_sliding_joints_and_any_number_of_them(joints, search):
    arm = random_arm(11, joints)
    q = np.random.default_rng(1).uniform(-1, 1, arm.n)
    T = lwr_dyn.forward_kinematics(arm, q)
    solve = lwr_dyn.ik_solver(arm, search=search)
    assert_reached(arm, solve.near(T, q + 0.02), T)
    assert_reached(arm, solve(T), T)


@pytest.mark.parametrize("search", KERNEL_SLOW)
def test_arguments_that_are_none_are_refused(search):
    solve, q = solver_of("kr30ha", search), np.zeros(6)
    T = lwr_dyn.forward_kinematics(solve.arm, q)
    mirrored, skew = T.copy(), T.copy()
    mirrored[:3, 0] *= -1.0
    skew[0, 0] += 1e-3
    for error, function, arguments in (
        *((OptionError, solve, (bad,)) for bad in (mirrored, skew, T + np.eye(4)[3])),
        *((ShapeError, solve, (bad,)) for bad in (T[:3], T * np.nan, "T", T * 1j, None)),
        *((ShapeError, solve, (T, bad)) for bad in (np.zeros(5), q * np.nan, "q", 0.0)),
        (ShapeError, solve.near, (T, None)),
    ):
        with pytest.raises(error):
            function(*arguments)
    with pytest.raises(ShapeError, match=r"q0: shape \(2, 6\); allowed: \(3, 6\) or \(6,\), as T"):
        solve.batch(np.array([T] * 3), np.zeros((2, 6)))
    with pytest.raises(ShapeError, match=r"T: shape \(3, 3\); allowed: \(..., 4, 4\), homogeneous matrices"):
        solve.batch(np.eye(3))
    assert np.array_equal(solve(T.tolist(), q.astype(int)), solve(T, q))


def test_options_are_checked():
    for options, error, words in (
        ({"starts": 0}, OptionError, "starts"),
        ({"search": "newton"}, UnknownNameError, "newton"),
    ):
        with pytest.raises(error, match=words):
            lwr_dyn.ik_solver(arm_named("kr30ha"), **options)


@pytest.mark.parametrize(("below", "above", "joint", "excess"), [(0.3, 0.2, "A2", 0.3), (0.1, 0.2, "A5", 0.2)])
def test_the_error_names_the_joint_that_is_furthest_outside(below, above, joint, excess):
    arm = arm_named("kr30ha")
    q, solve = (arm.lower + arm.upper) / 2.0, lwr_dyn.ik_solver(arm, search="pinocchio")
    q[1], q[4] = arm.lower[1] - below, arm.upper[4] + above
    for state, named in ((OUTSIDE, (joint, pytest.approx(excess))), (NOT_REACHED, (None, 0.0))):
        with pytest.raises(PoseNotReachedError) as caught:
            solve._found(np.array([*q, state, 4e-6, 0.04, -0.5]), np.eye(4), None)
        error = caught.value
        assert (error.joint, error.excess) == named
        assert (error.distance, error.angle) == pytest.approx((2e-3, np.arctan2(0.2, -0.5)))
        assert error.q.tolist() == q.tolist()


@pytest.mark.parametrize("name", ["kr30ha", "lwr4plus", "j2n6s300"])
def test_random_poses_are_reached(name):
    arm = arm_named(name)
    solve = PoseSolver(arm, pinocchio_search(arm, limits=True, starts=300, seed=0))
    T = lwr_dyn.forward_kinematics(arm, random_positions(arm, 25, seed=4))
    assert_reached(arm, np.array([solve(pose) for pose in T]), T)


def test_singular_poses_are_reached():
    arm = arm_named("ur10e")
    T = lwr_dyn.forward_kinematics(arm, singular_positions(arm, 20, seed=4))
    solve = lwr_dyn.ik_solver(arm, search="pinocchio")
    assert isinstance(solve.search, PinocchioSearch)
    assert_reached(arm, solve.batch(T).q, T)


def test_a_redundant_arm_is_pulled_inside_its_limits(monkeypatch):
    arm = arm_named("lwr4plus")
    search = pinocchio_search(arm, limits=True, starts=1, seed=0)
    q = random_positions(arm, 40, seed=9)
    T = lwr_dyn.forward_kinematics(arm, q)

    def found():
        rows = search.rows(T, np.clip(q + 0.8, arm.lower, arm.upper), False)
        good = rows[:, arm.n] == FOUND
        assert_reached(arm, rows[good, : arm.n], T[good])
        return good.sum()

    pulled = found()
    monkeypatch.setattr("lwr_dyn.kinematics.pose_solver._REPAIR", 0)
    assert found() < pulled


def test_ranges_are_those_of_the_limits_or_of_half_a_turn():
    arm = random_arm(3, "RRPP")
    limits = ((-0.4, 0.8), (None, None), (-0.1, 0.3), (None, None))
    arm = replace(arm, limits=tuple(JointLimits(lower=low, upper=up) for low, up in limits))
    x = search_ranges(arm, True, 400, 5)
    np.testing.assert_allclose(x.middle, [0.2, 0.0, 0.1, 0.0], atol=1e-12)
    assert x.lower.tolist() == [-0.4, -np.inf, -0.1, -np.inf]
    assert x.turning.tolist() == [True, True, False, False]
    reach = np.array([0.6, np.pi, 0.2, 1.0])
    share = np.random.default_rng(5).uniform(-1.0, 1.0, (400, 4))
    np.testing.assert_allclose(x.starts, x.middle + share * reach, atol=1e-12)
    np.testing.assert_allclose(x.room, [0.3, 0.3, 0.1, 0.3])
    free = search_ranges(arm, False, 400, 5)
    assert np.isinf(free.lower).all()
    assert np.isinf(free.upper).all()
    np.testing.assert_array_equal(free.starts, x.starts)


def test_the_error_of_a_pose_is_twice_the_sine_of_half_its_turn_and_the_first_step_that_of_the_formula():
    rng = np.random.default_rng(6)
    for angle in (0.0, 0.3, 2.5):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        pose, T = np.eye(4), np.eye(4)
        pose[:3, :3], pose[:3, 3] = Rotation.from_rotvec(rng.normal(size=3)).as_matrix(), rng.normal(size=3)
        T[:3, :3] = Rotation.from_rotvec(angle * axis).as_matrix() @ pose[:3, :3]
        T[:3, 3] = pose[:3, 3] + [0.1, -0.2, 0.3]
        error, sizes = pose_error(T, pose)
        np.testing.assert_allclose(error, [0.1, -0.2, 0.3, *(2.0 * np.sin(angle / 2.0) * axis)], atol=1e-12)
        np.testing.assert_allclose(sizes, [0.14, np.sin(angle) ** 2, np.cos(angle)], atol=1e-12)
    arm = arm_named("kr30ha")
    q = (arm.lower + arm.upper) / 2 + 0.3
    T = lwr_dyn.forward_kinematics(arm, q)
    target = T.copy()
    target[:3, 3] += 0.01, -0.02, 0.005
    search = pinocchio_search(arm, limits=True, starts=1, seed=0)
    steps = search._steps(target, q, None)
    next(steps)
    J, error = jacobian(arm.chain, q), np.array([0.01, -0.02, 0.005, 0.0, 0.0, 0.0])
    damping = 0.1 * (error @ error) / 2 + 1e-12
    expected = q + J.T @ np.linalg.solve(J @ J.T + damping * np.eye(6), error)
    assert np.abs(next(steps)[0] - expected).max() < 1e-12


def test_whole_turns_lead_next_to_a_position_and_inside_the_limits():
    limits = tuple(JointLimits(*ends) for ends in ((-7, 7), (-1, 6), (-6, 1), (-9, 9)))
    arm = replace(random_arm(3, "RRRP"), limits=limits)
    x, turn = search_ranges(arm, True, 1, 0), 2.0 * np.pi
    near = np.array([6.0, 0.0, 0.0, 0.0])
    tight = replace(x, lower=np.full(4, -1.0), upper=np.full(4, 1.0))
    for q, q0, ranges, wanted in (
        ([0.1, 0.5, 0.5, 8.0], near, x, [0.1 + turn, 0.5, 0.5, 8.0]),
        ([0.0, -1.5, 1.5, 8.0], near, x, [turn, -1.5 + turn, 1.5 - turn, 8.0]),
        ([0.0, -1.5, 1.5, 8.0], 0 * near, tight, [0.0, -1.5, 1.5, 8.0]),
    ):
        np.testing.assert_allclose(with_turns(np.array(q), q0, ranges), wanted)
