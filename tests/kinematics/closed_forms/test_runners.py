"""Python and machine code give the same bits, refuse the same poses, and share nothing between threads."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.branches.compiled_text import ctypes_runner
from lwr_dyn.kinematics.closed_forms.arm_numbers import numbers_of_solutions, places
from lwr_dyn.kinematics.closed_forms.runners import RUNNERS, python_runner
from lwr_dyn.kinematics.six_joints.exact_arms import six_joint_form
from lwr_dyn.kinematics.solution import MOST_COPIES, TURN
from lwr_dyn.kinematics.solution_rows import TOUCH
from tests.kinematics.six_joints.six_joint_arms import six_joint_arm


def of(make, arm):
    form = six_joint_form(arm)
    return make(
        (*form.texts, "solutions", "solutions_six_joints", "rows"),
        {**form.numbers, **numbers_of_solutions(arm, form.texts[-1] == "three_parallel")},
    )


def poses(arm, count):
    rng = np.random.default_rng(4)
    q = rng.uniform(-3.0, 3.0, (count, 6))
    q[::7, 4], q[1::7, 2], q[2::11] = 0.0, 0.0, np.round(q[2::11] / (np.pi / 2.0)) * (np.pi / 2.0)
    T = lwr_dyn.forward_kinematics(arm, q)
    T[::10, :3, 3] *= 1.7
    T[3::10, :3, :3] += 1e-8 * rng.standard_normal((len(T[3::10]), 3, 3))
    return T


@pytest.mark.parametrize("name", ["kr30ha", "ur10", "tx40", "ur5e"])
def test_python_gives_the_bits_of_machine_code(name):
    arm = lwr_dyn.load(name)
    plain, compiled, by_ctypes = of(python_runner, arm), of(RUNNERS.load("compiled"), arm), of(ctypes_runner, arm)
    for T in poses(arm, 120):
        ours, theirs = plain.run(T), compiled.run(T)
        assert np.array_equal(by_ctypes.run(T), theirs, equal_nan=True)
        reached = np.repeat(ours[:48:6] == ours[:48:6], 6)
        assert np.array_equal(ours[:48], theirs[:48], equal_nan=True)
        assert np.array_equal(ours[-8:], theirs[-8:])
        rows = slice(72, 72 + 48)
        assert np.array_equal(ours[rows][reached], theirs[rows][reached])
        count = int(ours[places(6)["INSIDE"]] + ours[places(6)["OUTSIDE"]])
        if count:
            listed = plain.rows_of(ours, count)
            assert listed.shape == (count, 9)
            assert np.all(np.diff(listed[:, 6]) <= 0.0)
            assert listed.tobytes() == compiled.rows_of(theirs, count).tobytes()
            assert listed.tobytes() == by_ctypes.rows_of(theirs, count).tobytes()
            residual = slice(places(6)["RESIDUAL"], places(6)["RESIDUAL"] + 8)
            assert ours[residual].tobytes() == theirs[residual].tobytes()
            assert ours[residual].max() > 0.0


@pytest.mark.parametrize("make", ["python", "compiled"])
@pytest.mark.parametrize("reach", [None, 2.1, 20.0])
def test_branches_are_judged_as_numpy_judges_their_positions(reach, make):
    """Whole turns inside the limits, their products and sums, the branch that is least outside, the residuals."""
    arm = lwr_dyn.load("kr30ha") if reach is None else six_joint_arm("ur10", reach=reach)
    run, at = of(RUNNERS.load(make), arm).run, places(6)
    checked, seen = six_joint_form(arm).texts[-1] == "three_parallel", set()
    for T in poses(arm, 24):
        out = run(T)
        q = out[:48].reshape(8, 6)
        first = np.ceil((arm.lower - TOUCH - q) / TURN)
        many = np.floor((arm.upper + TOUCH - q) / TURN) - first + 1.0
        total = np.where((many < 1.0).any(axis=1), 0.0, many.prod(axis=1))
        there = np.isfinite(q[:, 0])
        too_many = there & (total > MOST_COPIES)
        copies, out_of = np.where(too_many, 1.0, total)[there].sum(), there & (total == 0.0)
        kept = there & ~too_many
        assert np.array_equal(out[at["FIRST"] : at["FIRST"] + 48].reshape(8, 6)[kept], first[kept])
        assert np.array_equal(out[at["MANY"] : at["MANY"] + 48].reshape(8, 6)[kept], many[kept])
        sums = [out[at[name]] for name in ("INSIDE", "OUTSIDE", "LEFT_OUT")]
        assert sums == [copies, out_of.sum(), (total[too_many] - 1.0).sum()]
        room = np.minimum(arm.upper - q, q - arm.lower)
        if out_of.any():
            least = room[out_of][room[out_of].min(axis=1).argmax()]
            assert (out[at["MARGIN"]], out[at["JOINT"]]) == (least.min(), least.argmin())
        off = np.abs(lwr_dyn.forward_kinematics(arm, np.where(there[:, None], q, 0.0)) - T)[there].max(axis=(1, 2))
        worst = out[at["RESIDUAL"] : at["RESIDUAL"] + 8]
        if checked and abs(np.trace(T[:3, :3] @ T[:3, :3].T) - 3.0) < 1e-12:  # else it is judged by the nearest pose
            np.testing.assert_allclose(worst[there], off, rtol=0, atol=5e-16)
            assert out[at["WORST"]] == worst.max() > 0.0 or not there.any()
        seen |= {
            name for name, found in (("inside", copies), ("outside", out_of.any()), ("cut", too_many.any())) if found
        }
    assert seen == {"inside", "cut" if reach == 20.0 else "outside"}


def test_rows_of_many_copies_and_of_none_inside():
    """Whole turns of each joint, so that thousands of rows are put in order; and a branch outside once."""
    for reach, count in ((2.1 * np.pi, 500), (9.0, 400), (0.01, 1)):
        arm, most = six_joint_arm("ur10", reach=reach), 0
        plain, compiled = of(python_runner, arm), of(RUNNERS.load("compiled"), arm)
        for T in poses(arm, 12):
            out = compiled.run(T)
            k = int(out[places(6)["INSIDE"]] + out[places(6)["OUTSIDE"]])
            if k:
                assert compiled.rows_of(out, k).tobytes() == plain.rows_of(out, k).tobytes()
                most = max(most, k)
        assert most >= count or reach < 0.1
        assert 0 < most <= 2048


@pytest.mark.parametrize("make", [RUNNERS.load("compiled"), ctypes_runner])
def test_threads_have_their_own_room(make):
    arm = lwr_dyn.load("kr30ha")
    run, T = of(make, arm).run, poses(arm, 400)
    wanted = [run(pose)[:48] for pose in T]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda pose: run(pose)[:48], [*T] * 4))
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(found, wanted * 4, strict=True))


@pytest.mark.parametrize("make", ["python", "compiled"])
def test_what_is_no_pose_gives_nothing(make):
    arm = lwr_dyn.load("ur10")
    run, good = of(RUNNERS.load(make), arm).run, poses(arm, 2)[1]
    assert run(good) is not None
    for place, value in (((0, 0), np.nan), ((3, 3), 2.0), ((3, 0), 1e-9), ((0, 3), np.inf), ((1, 1), 2.0)):
        bad = good.copy()
        bad[place] = value
        assert run(bad) is None
    assert run(good @ np.diag([1.0, 1.0, -1.0, 1.0])) is None
    for i, j in ((0, 1), (1, 2), (2, 0)):  # a row too long, and one that leans towards another
        for row in (1.001 * good[i, :3], np.cos(0.001) * good[i, :3] + np.sin(0.001) * good[j, :3]):
            bad = good.copy()
            bad[i, :3] = row
            assert run(bad) is None
