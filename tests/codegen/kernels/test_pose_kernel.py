"""The search of inverse kinematics: the formula of its step, and compiled: every pose that an arm takes is reached."""

import ctypes
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels import pose_kernel
from lwr_dyn.codegen.kernels.pose_kernel import curvature, finish
from lwr_dyn.codegen.kernels.pose_source import pose_step, step_source
from lwr_dyn.foundation.errors import MissingPackageError
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.kinematics.pose_solver import FOUND, NOT_REACHED, OUTSIDE, TAIL, pose_error, search_ranges
from tests.kinematics.solved_poses import arm_named, assert_reached, solver_of
from tests.public_arms import positions_at_limits, random_positions, singular_positions
from tests.random_arms import random_arm

KR30 = lwr_dyn.load("kr30ha")
RANGES = search_ranges(KR30, True, 1, 0)


def off(joint, beyond, error):
    """q with a joint beyond its limits and the others inside, and the pose that is this much away from it."""
    q = RANGES.middle + 0.2
    q[joint] = (RANGES.upper if beyond > 0.0 else RANGES.lower)[joint] + beyond
    T = lwr_dyn.forward_kinematics(KR30, q)
    T[:3, 3] += error
    return q, T


@pytest.mark.parametrize("repair", [0.0, 1.0, 2.0])
@pytest.mark.parametrize(("joint", "beyond", "error"), [(1, 0.1, [0.01, -0.02, 0.005]), (2, -0.05, [2.0, 3.0, -1.0])])
def test_the_step_is_that_of_the_formula(repair, joint, beyond, error):
    q, T = off(joint, beyond, error)
    error, here = np.array([*error, 0.0, 0.0, 0.0]), np.arange(6) == joint
    out = np.array(pose_step(KR30.chain, RANGES)(q, T[:3].ravel(), repair)).ravel()
    inside = RANGES.upper - RANGES.room if beyond > 0.0 else RANGES.lower + RANGES.room
    pull = np.where(here, inside - q, 0.0) * (repair == 1.0)
    J = jacobian(KR30.chain, q) * np.where(here & (repair == 2.0), 0.0, 1.0)
    damping = 0.1 * (error @ error) / 2 + 1e-12
    step = pull + J.T @ np.linalg.solve(J @ J.T + damping * np.eye(6), error - J @ pull)
    step /= max(1.0, np.linalg.norm(step))
    assert np.abs(out[:6] - q - step).max() < (1e-6 if repair == 2.0 else 1e-12)  # held: J J^T has lost rank
    assert np.abs(out[6:] - [error @ error, 0.0, 1.0, repair]).max() < 1e-12


@pytest.mark.parametrize("angle", [0.1, -1.0, 3.0])
def test_the_rotation_error_is_the_axis_times_twice_the_sine_of_half_the_angle(angle):
    q = RANGES.middle + 0.2
    T, u = lwr_dyn.forward_kinematics(KR30, q), np.array([2.0, -1.0, 2.0]) / 3.0
    cross = np.cross(np.eye(3), u)
    T[:3, :3] = (np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross) @ T[:3, :3]
    out = np.array(pose_step(KR30.chain, RANGES)(q, T[:3].ravel(), 0.0)).ravel()
    error, J = np.array([0.0, 0.0, 0.0, *(2.0 * np.sin(angle / 2.0) * u)]), jacobian(KR30.chain, q)
    step = J.T @ np.linalg.solve(J @ J.T + (0.05 * error @ error + 1e-12) * np.eye(6), error)
    assert np.abs(out[:6] - q - step / max(1.0, np.linalg.norm(step))).max() < 1e-9
    assert np.abs(out[6:] - [0.0, np.sin(angle) ** 2, np.cos(angle), 0.0]).max() < 1e-12


def test_the_text_is_python_that_makes_the_step():
    """Rows of the buffer: q, T, repair, a flag, the next q, the measures."""
    text, lanes = step_source(KR30.chain, RANGES, 2), 2
    names = {"sqrt": math.sqrt, "abs": abs, "fma": lambda x, y, z: x * y + z}
    exec(text, names)
    given = [off(1, 0.1, [0.01, 0.0, 0.0]), off(3, -0.2, [0.0, 0.3, 0.0])]
    b = np.zeros(30 * lanes)
    b[: 19 * lanes] = np.transpose([[*q, *T[:3].ravel(), 1.0] for q, T in given]).ravel()
    names["body"](b)
    for lane, (q, T) in enumerate(given):
        expected = np.array(pose_step(KR30.chain, RANGES)(q, T[:3].ravel(), 1.0)).ravel()
        assert np.abs(b.reshape(30, lanes)[20:, lane] - expected).max() < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "positions", "count"),
    [
        ("lwr4plus", random_positions, 200), ("ur10e", random_positions, 200), ("ur10e", singular_positions, 60),
        ("panda", random_positions, 200), ("panda", singular_positions, 60), ("panda", positions_at_limits, 100),
        ("j2n6s300", random_positions, 200), ("j2n6s300", positions_at_limits, 100),
    ],
)  # fmt: skip
def test_the_kernel_reaches_every_pose_that_the_arm_takes(name, positions, count):
    arm, solve = arm_named(name), solver_of(name, "kernel")
    q = positions(arm, count, seed=3)
    T = lwr_dyn.forward_kinematics(arm, q)
    cold, near = solve.batch(T), solve.batch(T, np.clip(q + 0.05, arm.lower, arm.upper))
    assert cold.found.all()
    assert near.found.all()
    assert_reached(arm, cold.q, T)
    assert_reached(arm, near.q, T)


@pytest.mark.slow
def test_both_searches_follow_the_same_start_to_the_same_solution():
    arm = arm_named("ur10e")
    q = random_positions(arm, 20, seed=5)
    T = lwr_dyn.forward_kinematics(arm, q)
    for pose, start in zip(T, q + 0.02, strict=True):
        answers = [solver_of("ur10e", search).near(pose, start) for search in ("kernel", "pinocchio")]
        assert np.abs(answers[0] - answers[1]).max() < 1e-5  # a wrist near its singularity: pose errors of 1e-9 / 1e-4


@pytest.mark.slow
def test_a_batch_is_the_single_calls_also_of_many_threads():
    arm, solve = arm_named("panda"), solver_of("panda", "kernel")
    q = random_positions(arm, 200, seed=6)
    T = lwr_dyn.forward_kinematics(arm, q)
    with ThreadPoolExecutor(4) as pool:
        several = np.array(list(pool.map(solve, T)))
    assert np.array_equal(several, [solve(pose) for pose in T])
    assert np.array_equal(solve.batch(T.reshape(20, 10, 4, 4)).q.reshape(200, 7), several)
    assert np.array_equal(solve.batch(T[:30], q[0]).q, [solve(pose, q[0]) for pose in T[:30]])


def test_without_the_packages_of_kernels_pinocchio_searches(monkeypatch):
    def missing():
        raise MissingPackageError("llvmlite", "batch")

    monkeypatch.setattr("lwr_dyn.codegen.kernels.pose_kernel.require_packages", missing)
    arm = arm_named("kr30ha")
    assert type(lwr_dyn.ik_solver(arm).search).__name__ == "PinocchioSearch"
    with pytest.raises(MissingPackageError):
        lwr_dyn.ik_solver(arm, search="kernel")


@pytest.mark.slow
def test_a_kept_kernel_is_loaded_and_another_arm_has_its_own(monkeypatch):
    arm = arm_named("ur10e")
    first = lwr_dyn.ik_solver(arm, search="kernel")
    monkeypatch.setattr("lwr_dyn.codegen.kernels.kernel._codes", {})
    monkeypatch.setattr("lwr_dyn.codegen.kernels.pose_source.pose_loop", None)
    T = lwr_dyn.forward_kinematics(arm, np.full(6, 0.3))
    assert np.array_equal(lwr_dyn.ik_solver(arm, search="kernel")(T), first(T))
    assert pose_kernel._key(arm) != pose_kernel._key(arm_named("lwr4plus"))


def test_a_call_hands_over_poses_q0_and_settings():
    """By a kernel that gives a row of its own."""
    arm = arm_named("kr30ha")
    x, seen, row = search_ranges(arm, True, 2, 0), [], [*range(6), FOUND, *[0.0] * 5]

    def numbers(at, count):
        return np.ctypeslib.as_array(ctypes.cast(at, ctypes.POINTER(ctypes.c_double)), (count,))

    def call(T, T_step, q0, q0_step, s, s_step, out, b, start, stop):
        given = numbers(q0, 6 * stop).tolist() if q0_step >= 0 else None
        seen.append((numbers(T, 16 * stop).tolist(), T_step, given, q0_step, numbers(s, s_step).tolist(), start, stop))
        numbers(out, 12 * stop)[:] = row * stop
        numbers(b, 8)[:] = 0.0

    search = pose_kernel.KernelSearch(arm.chain, x, call, 8, (arm, True, 2, 0))
    assert (search.n, len(row)) == (6, 6 + TAIL)
    T, q0 = np.arange(32.0).reshape(2, 4, 4), np.arange(12.0).reshape(2, 6)
    joints = np.ravel([x.lower, x.upper, x.middle, x.turning]).tolist()
    full, once = [2.0, 1.0, 0.0, 6.0, *joints, *x.starts.ravel()], [1.0, 0.0, 0.0, 6.0, *joints]
    for single, given, restart in ((T[0], None, True), (T[0].tolist(), q0[0], True), (T[0], q0[0].tolist(), False)):
        assert search.one(single, given, restart).tolist() == row
        q = None if given is None else q0[0].tolist()
        assert seen.pop() == (T[0].ravel().tolist(), 16, q, -1 if q is None else 6, full if restart else once, 0, 1)
    for given, restart in ((None, True), (q0, False)):
        assert search.rows(T, given, restart).tolist() == [row] * 2
        q = None if given is None else q0.ravel().tolist()
        assert seen.pop() == (T.ravel().tolist(), 16, q, -1 if q is None else 6, full if restart else once, 0, 2)
    assert seen == []


def test_a_near_miss_is_finished_from_the_middle_or_from_q0(monkeypatch):
    """By a kernel that reaches nothing: by 1 um, or by 10 um; from where Newton's method begins is noted."""
    arm, seen, codes, apart = arm_named("kr30ha"), [], [], [1e-12]
    x = search_ranges(arm, True, 2, 0)

    def call(T, T_step, q0, q0_step, s, s_step, out, b, start, stop):
        rows = np.ctypeslib.as_array(ctypes.cast(out, ctypes.POINTER(ctypes.c_double)), (stop, 12))
        rows[:] = [*range(6), NOT_REACHED, apart[0], 0.0, 1.0, 0.0, 0.0]

    def finished(chain, ranges, T, row, near):
        seen.append(None if near is None else near.tolist())
        return np.array([*row[:6], codes.pop() if codes else FOUND, *row[7:]])

    monkeypatch.setattr(pose_kernel, "finish", finished)
    search = pose_kernel.KernelSearch(arm.chain, x, call, 8, (arm, True, 2, 0))
    T, q0 = np.tile(np.eye(4), (2, 1, 1)), np.array([[0.1] * 6, [9.0] * 6])
    clipped = np.clip(q0, x.lower, x.upper).tolist()
    for given, expected in (
        ((T[0], None, True), [x.middle.tolist()]), ((T[0], q0[0], True), clipped[:1]), ((T[0], q0[0], False), [None]),
    ):  # fmt: skip
        assert search.one(*given)[6] == FOUND
        assert seen == expected
        seen.clear()
    for given, expected in (((None, True), [x.middle.tolist()] * 2), ((q0, True), clipped), ((q0, False), [None] * 2)):
        assert (search.rows(T, *given)[:, 6] == FOUND).all()
        assert seen == expected
        seen.clear()
    codes.extend([NOT_REACHED] * 2)  # not from there, nor from where the first start ends
    assert search.one(T[0], None, True)[6] == FOUND
    assert seen == [x.middle.tolist()] * 3
    seen.clear()
    codes.extend([NOT_REACHED] * 3)
    assert search.one(T[0], None, True)[6] == NOT_REACHED
    seen.clear()
    apart[0] = 1e-10
    assert search.one(T[0], None, True)[6] == NOT_REACHED
    assert seen == []


def test_the_name_of_a_kernel_follows_from_geometry_kinds_and_limits():
    arm = arm_named("kr30ha")
    others = [
        arm_named("lwr4plus"), lwr_dyn.load("kr30ha", tool={"xyz": [0.0, 0.0, 0.1]}), random_arm(5, "RRRRRR"),
        random_arm(5, "RRPRRR"), replace(arm, limits=(*arm.limits[:5], replace(arm.limits[5], upper=1.0))),
        replace(arm, limits=(replace(arm.limits[0], lower=-1.0), *arm.limits[1:])),
    ]  # fmt: skip
    keys = {pose_kernel._key(each) for each in (arm, lwr_dyn.load("kr30ha"), *others)}
    assert len(keys) == 1 + len(others)
    assert all(key.startswith("pose-") for key in keys)


STRETCHED = [  # Gen3, at which steps by J alone end at errors of 1e-8 to 1e-6; in the last four beside a minimum of E
    [-2.5626, -0.7695, 0.0, 0.0, 0.0, -1.5708, -2.729],
    [1.1242, -1.4311, 0.0, 0.0, 0.0, 0.2979, 1.5708],
    [1.8905, 0.4562, 0.0, 0.0, 0.0, 0.8877, 2.0709],
    [1.5708, -1.4656, 0.0, 0.0, 0.0, 0.8392, -2.0828],
    [2.7727, 0.5308, 0.0, 0.0, 0.0, -1.5708, 0.83],
    [-0.9206, 2.181, 0.0, 0.0, 0.0, 1.6214, 0.5331],
    [-1.5688, 0.8969, 0.0, 0.0, 0.0, 0.6108, -0.2034],
]


@pytest.mark.parametrize("joints", ["RRRRRRR", "RPRRPR"])
def test_the_second_derivatives_are_those_of_the_error(joints):
    arm, rng, step = random_arm(5, joints), np.random.default_rng(2), 1e-5
    q = rng.uniform(-1.0, 1.0, arm.n)
    T = lwr_dyn.forward_kinematics(arm, q + 1e-4 * rng.uniform(-1.0, 1.0, arm.n))

    def slope(q):
        return -jacobian(arm.chain, q).T @ pose_error(T, lwr_dyn.forward_kinematics(arm, q))[0]

    moved = step * np.eye(arm.n)
    numeric = np.array([(slope(q + row) - slope(q - row)) / (2.0 * step) for row in moved])
    error = pose_error(T, lwr_dyn.forward_kinematics(arm, q))[0]
    J = jacobian(arm.chain, q)
    numeric = (numeric + numeric.T) / 2.0
    assert np.abs(J.T @ J - numeric).max() > 1e-5  # what J alone leaves out
    assert np.abs(curvature(J, error) - numeric).max() < 1e-7


def test_newtons_steps_end_at_the_pose_or_leave_the_row_as_it_was():
    """From 1e-4 rad two steps; the row keeps its start and counts its steps."""
    arm = arm_named("kr30ha")
    x = search_ranges(arm, True, 1, 0)
    for beyond, code in ((0.0, FOUND), (0.1, OUTSIDE)):
        q = x.middle + 0.2
        q[1] = x.upper[1] + beyond if beyond else q[1]
        T = lwr_dyn.forward_kinematics(arm, q)
        row = np.array([*(q + 1e-4), NOT_REACHED, 1.0, 1.0, 1.0, 3.0, 7.0])
        found = finish(arm.chain, x, T, row, None)
        assert found[6:].tolist() == [code, *found[7:10], 3.0, 9.0]
        assert (found[7:9] < 1e-18).all()
        assert np.abs(found[:6] - q).max() < 1e-8
        turned = finish(arm.chain, x, T, row + 2.0 * np.pi * np.eye(12)[5], q)
        assert np.abs(turned[:6] - q).max() < 1e-8
        T[0, 3] += 10.0
        assert finish(arm.chain, x, T, row, None) is row


@pytest.mark.slow
def test_a_stretched_arm_with_its_axes_aligned_is_reached(monkeypatch):
    arm, solve = arm_named("gen3"), solver_of("gen3", "kernel")
    T = lwr_dyn.forward_kinematics(arm, STRETCHED)
    assert_reached(arm, solve.batch(T).q, T)
    assert_reached(arm, np.array([solve(pose) for pose in T]), T)
    monkeypatch.setattr("lwr_dyn.codegen.kernels.pose_kernel._AGAIN", 0)
    first = solve.batch(T).found.sum()
    monkeypatch.setattr("lwr_dyn.codegen.kernels.pose_kernel._CLOSE", 0.0)
    assert solve.batch(T).found.sum() < first < len(T)
