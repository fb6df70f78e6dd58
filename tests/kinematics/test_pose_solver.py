"""One solution of a pose: reached to 1e-9 inside the limits, or an error that says by how much it is not."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.errors import MissingPackageError, OptionError, PoseNotReachedError, ShapeError, UnknownNameError
from lwr_dyn.kinematics.pose_solver import POSE_SEARCHES, search_ranges
from tests.arms import random_arm
from tests.public_arms import positions_at_limits, public_arm, random_positions, singular_positions
from tests.tolerances import POSE_SOLVED

SEARCHES = tuple(POSE_SEARCHES.rows)
_SOLVERS = {}


def arm_named(name):
    return lwr_dyn.load(name) if name in lwr_dyn.robots() else public_arm(name)


def solver_of(name, search):
    if (name, search) not in _SOLVERS:
        _SOLVERS[name, search] = lwr_dyn.ik_solver(arm_named(name), search=search)
    return _SOLVERS[name, search]


def assert_reached(arm, q, T):
    assert ((q >= arm.lower) & (q <= arm.upper)).all()
    reached = lwr_dyn.forward_kinematics(arm, q)
    assert np.linalg.norm(reached[..., :3, 3] - T[..., :3, 3], axis=-1).max() <= POSE_SOLVED
    turn = np.swapaxes(reached[..., :3, :3], -1, -2) @ T[..., :3, :3]
    sine = np.stack([turn[..., i, j] - turn[..., j, i] for i, j in ((2, 1), (0, 2), (1, 0))]) / 2.0
    assert np.linalg.norm(sine, axis=0).max() <= POSE_SOLVED
    assert (np.trace(turn, axis1=-2, axis2=-1) > 2.9).all()


@pytest.mark.parametrize(
    ("name", "positions", "count"),
    [
        ("lwr4plus", random_positions, 200),
        ("ur10e", random_positions, 200),
        ("ur10e", singular_positions, 60),
        ("panda", random_positions, 200),
        ("panda", singular_positions, 60),
        ("panda", positions_at_limits, 100),
        ("j2n6s300", random_positions, 200),
        ("j2n6s300", positions_at_limits, 100),
    ],
)
def test_the_kernel_reaches_every_pose_that_the_arm_takes(name, positions, count):
    arm, solve = arm_named(name), solver_of(name, "kernel")
    q = positions(arm, count, seed=3)
    T = lwr_dyn.forward_kinematics(arm, q)
    cold, near = solve.batch(T), solve.batch(T, np.clip(q + 0.05, arm.lower, arm.upper))
    assert cold.found.all()
    assert near.found.all()
    assert_reached(arm, cold.q, T)
    assert_reached(arm, near.q, T)


def test_both_searches_follow_the_same_start_to_the_same_solution():
    arm = arm_named("ur10e")
    q = random_positions(arm, 20, seed=5)
    T = lwr_dyn.forward_kinematics(arm, q)
    for pose, start in zip(T, q + 0.02, strict=True):
        answers = [solver_of("ur10e", search).near(pose, start) for search in SEARCHES]
        assert np.abs(answers[0] - answers[1]).max() < 1e-5  # a wrist near its singularity: pose errors of 1e-9 / 1e-4


def test_a_batch_is_the_single_calls():
    arm, solve = arm_named("panda"), solver_of("panda", "kernel")
    q = random_positions(arm, 30, seed=6)
    T = lwr_dyn.forward_kinematics(arm, q)
    single = np.array([solve(pose) for pose in T])
    assert np.array_equal(solve.batch(T.reshape(5, 6, 4, 4)).q.reshape(30, 7), single)
    from_one = np.array([solve(pose, q[0]) for pose in T])
    assert np.array_equal(solve.batch(T, q[0]).q, from_one)


def test_threads_do_not_disturb_each_other():
    arm, solve = arm_named("panda"), solver_of("panda", "kernel")
    T = lwr_dyn.forward_kinematics(arm, random_positions(arm, 400, seed=7))
    with ThreadPoolExecutor(4) as pool:
        several = np.array(list(pool.map(solve, T)))
    assert np.array_equal(several, solve.batch(T).q)


@pytest.mark.parametrize("search", SEARCHES)
def test_out_of_reach_says_by_how_much(search):
    solve = lwr_dyn.ik_solver(arm_named("ur10e"), search=search, starts=9)
    T = np.eye(4)
    T[:3, 3] = 11.0, 0.0, 0.2
    with pytest.raises(PoseNotReachedError, match=r"m and .* rad off") as caught:
        solve(T)
    assert 9.4 < caught.value.distance < 10.5
    reached = lwr_dyn.forward_kinematics(solve.arm, caught.value.q)
    assert abs(np.linalg.norm(reached[:3, 3] - T[:3, 3]) - caught.value.distance) < 1e-9
    marked = solve.batch(np.stack([T, lwr_dyn.forward_kinematics(solve.arm, np.full(6, 0.4))]))
    assert marked.found.tolist() == [False, True]
    assert np.isnan(marked.q[0]).all()
    assert abs(marked.distance[0] - caught.value.distance) < 1e-9


@pytest.mark.parametrize("search", SEARCHES)
def test_a_pose_beyond_the_limits_names_the_joint_and_is_solved_without_them(search):
    arm = arm_named("kr30ha")
    q = np.where(np.arange(6) == 1, arm.upper[1] + 0.3, (arm.lower + arm.upper) / 2 + 0.1)
    T = lwr_dyn.forward_kinematics(arm, q)
    solve = lwr_dyn.ik_solver(arm, search=search, starts=20)
    with pytest.raises(PoseNotReachedError, match="limits") as caught:
        solve(T, q)
    assert caught.value.joint in arm.joint_names
    assert 0.0 < caught.value.excess <= 0.3 + 1e-6
    assert solve.batch(T[None]).outside.all()
    free = lwr_dyn.ik_solver(arm, search=search, limits=False)(T, q)
    assert np.abs(free - q).max() < 1e-6


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


@pytest.mark.parametrize("search", SEARCHES)
def test_near_does_not_start_again(search):
    arm, solve = arm_named("kr30ha"), solver_of("kr30ha", search)
    q = (arm.lower + arm.upper) / 2 + 0.2
    T = lwr_dyn.forward_kinematics(arm, q)
    assert np.abs(solve.near(T, q + 0.01) - q).max() < 1e-6
    stretched = T.copy()
    stretched[:3, 3] *= 10.0
    with pytest.raises(PoseNotReachedError):
        solve.near(stretched, q)


@pytest.mark.parametrize(
    ("joints", "search"),
    [("PRP", "kernel"), ("RRPRRPR", "kernel"), ("R", "pinocchio"), ("PRP", "pinocchio"), ("RRPRRPR", "pinocchio")],
)
def test_sliding_joints_and_any_number_of_them(joints, search):
    arm = random_arm(11, joints)
    q = np.random.default_rng(1).uniform(-1, 1, arm.n)
    T = lwr_dyn.forward_kinematics(arm, q)
    solve = lwr_dyn.ik_solver(arm, search=search)
    assert_reached(arm, solve.near(T, q + 0.02), T)
    assert_reached(arm, solve(T), T)


@pytest.mark.parametrize("search", SEARCHES)
def test_arguments_that_are_none_are_refused(search):
    solve = solver_of("kr30ha", search)
    q = np.zeros(6)
    T = lwr_dyn.forward_kinematics(solve.arm, q)
    mirrored, skew = T.copy(), T.copy()
    mirrored[:3, 0] *= -1.0
    skew[0, 0] += 1e-3
    for bad in (mirrored, skew, T + np.eye(4)[3]):
        with pytest.raises(OptionError):
            solve(bad)
    for bad in (T[:3], T * np.nan, "T", T * 1j, None):
        with pytest.raises(ShapeError):
            solve(bad)
    for bad in (np.zeros(5), q * np.nan, "q", 0.0):
        with pytest.raises(ShapeError):
            solve(T, bad)
    with pytest.raises(ShapeError):
        solve.near(T, None)
    with pytest.raises(ShapeError):
        solve.batch(T[None], np.zeros((2, 6)))
    assert np.array_equal(solve(T.tolist(), q.astype(int)), solve(T, q))


def test_options_are_checked():
    arm = arm_named("kr30ha")
    with pytest.raises(OptionError, match="starts"):
        lwr_dyn.ik_solver(arm, starts=0)
    with pytest.raises(UnknownNameError):
        lwr_dyn.ik_solver(arm, search="newton")


def test_without_the_packages_of_kernels_pinocchio_searches(monkeypatch):
    def missing():
        raise MissingPackageError("numba", "batch")

    monkeypatch.setattr("lwr_dyn.codegen.pose_kernel.require_packages", missing)
    arm = arm_named("kr30ha")
    assert type(lwr_dyn.ik_solver(arm).search).__name__ == "PinocchioSearch"
    with pytest.raises(MissingPackageError):
        lwr_dyn.ik_solver(arm, search="kernel")


def test_starts_lie_inside_the_limits():
    for arm in (arm_named("panda"), arm_named("j2n6s300"), random_arm(11, "PRP")):
        x = search_ranges(arm, True, 50, 0)
        assert ((x.starts >= arm.lower) & (x.starts <= arm.upper)).all()
        assert (np.abs(x.starts - x.middle) <= np.pi).all()
        assert np.isinf(search_ranges(arm, False, 1, 0).lower).all()
