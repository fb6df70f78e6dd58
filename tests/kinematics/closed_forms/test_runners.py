"""Python and machine code give the same bits, refuse the same poses, and share nothing between threads."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics.closed_forms.arm_numbers import numbers_of_solutions
from lwr_dyn.kinematics.closed_forms.runners import RUNNERS, python_runner
from lwr_dyn.kinematics.six_joints.exact_arms import six_joint_form


def of(make, arm):
    form = six_joint_form(arm)
    return make((*form.texts, "solutions", "solutions_six_joints"), {**form.numbers, **numbers_of_solutions(arm)})


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
    plain, compiled = of(python_runner, arm), of(RUNNERS.load("compiled"), arm)
    for T in poses(arm, 120):
        ours, theirs = plain(T), compiled(T)
        reached = np.repeat(ours[:48:6] == ours[:48:6], 6)
        assert np.array_equal(ours[:48], theirs[:48], equal_nan=True)
        assert np.array_equal(ours[-8:], theirs[-8:])
        rows = slice(72, 72 + 48)
        assert np.array_equal(ours[rows][reached], theirs[rows][reached])


def test_threads_have_their_own_room():
    arm = lwr_dyn.load("kr30ha")
    run, T = of(RUNNERS.load("compiled"), arm), poses(arm, 400)
    wanted = [run(pose)[:48] for pose in T]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda pose: run(pose)[:48], [*T] * 4))
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(found, wanted * 4, strict=True))


@pytest.mark.parametrize("make", ["python", "compiled"])
def test_what_is_no_pose_gives_nothing(make):
    arm = lwr_dyn.load("ur10")
    run, good = of(RUNNERS.load(make), arm), poses(arm, 2)[1]
    assert run(good) is not None
    for place, value in (((0, 0), np.nan), ((3, 3), 2.0), ((3, 0), 1e-9), ((0, 3), np.inf), ((1, 1), 2.0)):
        bad = good.copy()
        bad[place] = value
        assert run(bad) is None
    assert run(good @ np.diag([1.0, 1.0, -1.0, 1.0])) is None
