"""One pose of an S-R-S arm by machine code against NumPy's closed form: branches, best arm angles, intervals."""

import copy
import pickle
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import MissingPackageError
from lwr_dyn.kinematics import srs_margins, srs_solver
from lwr_dyn.kinematics.arm_geometry import require_srs
from lwr_dyn.kinematics.closed_forms.arm_numbers import numbers_of_solutions, numbers_of_srs
from lwr_dyn.kinematics.closed_forms.runners import RUNNERS, python_runner
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.solution import BRANCHES, PoseProblem
from tests.kinematics.srs_arms import problem_of, random_srs_arm


def poses(arm, count, seed=0):
    rng = np.random.default_rng(seed)
    q = rng.uniform(arm.lower, arm.upper, (count, 7))
    q[4::5, 3] = 0.98 * arm.upper[3] + 0.02 * arm.lower[3]  # the elbow has the smallest margin at many arm angles
    T = lwr_dyn.forward_kinematics(arm, q)
    T[3::10, :3, 3] *= 3.0
    return q, T


def numpys(arm, T, **options):
    return srs_margins.solve_pose(PoseProblem(arm, T, **options), require_srs(arm))


@pytest.mark.parametrize("arm_angle", [None, 0.7])
@pytest.mark.parametrize("name", ["lwr4plus", "iiwa14", "wam7", 0, 11])
def test_the_solutions_and_intervals_are_those_of_numpy(name, arm_angle):
    """Of random arms too, whose ranges have their middles anywhere."""
    arm, statuses = random_srs_arm(name) if isinstance(name, int) else lwr_dyn.load(name), set()
    for k, T in enumerate(poses(arm, 5)[1]):
        options = {"limits": k % 3 > 0, "arm_angle": arm_angle}
        ours, theirs = inverse_kinematics(arm, T, **options), numpys(arm, T, **options)
        facts = [(x.status, x.complete, len(x.solutions), len(x.outside), x.joint) for x in (ours, theirs)]
        assert facts[0] == facts[1]
        assert (ours.distance or 0.0) == pytest.approx(theirs.distance or 0.0, abs=1e-13)
        assert (ours.excess or 0.0) == pytest.approx(theirs.excess or 0.0, abs=1e-9)
        for a, b in ((ours.solutions, theirs.solutions), (ours.outside, theirs.outside)):
            # a best arm angle is where a margin is flat: its own digits are half as many as the margin's
            close = 1e-9 if arm_angle is not None else 1e-5
            rows = [sorted((s.branch, *s.q.round(4), s.arm_angle, *s.q, s.margin) for s in each) for each in (a, b)]
            for one, other in zip(*rows, strict=True):
                assert one[0] == other[0]
                assert np.abs(np.array(one[8:-1]) - other[8:-1]).max() < close
                assert one[-1] == pytest.approx(other[-1], abs=1e-9)
            assert all(s.residual < 1e-12 for s in a)
        assert ours.arm_angle_intervals.keys() == theirs.arm_angle_intervals.keys()
        for label, pairs in theirs.arm_angle_intervals.items():
            assert np.array(ours.arm_angle_intervals[label]).ravel() == pytest.approx(np.array(pairs).ravel(), abs=1e-9)
        statuses.add(ours.status)
    assert statuses >= {"solved", "out of reach"}


@pytest.mark.parametrize("name", ["lwr4plus", 0, 5, 11])
def test_each_branch_stands_at_its_best_arm_angle(name):
    """No arm angle of a grid has a larger smallest margin; by NumPy's margins."""
    arm = random_srs_arm(name) if isinstance(name, int) else lwr_dyn.load(name)
    q, grid = poses(arm, 12, 3)[0], np.linspace(-np.pi, np.pi, 721)
    best = srs_margins.margins(problem_of(arm, q)[0], np.tile(grid, (96, 1))).min(axis=2).max(axis=1).reshape(12, 8)
    for T, rows in zip(lwr_dyn.forward_kinematics(arm, q), best, strict=True):
        found = inverse_kinematics(arm, T)
        margins = {s.branch: s.margin for s in (*found.outside, *found.solutions)}
        assert margins.keys() == {branch.label for branch in BRANCHES}
        assert all(
            margins[branch.label] >= row - srs_margins.CERTAIN for branch, row in zip(BRANCHES, rows, strict=True)
        )


def test_a_position_inside_the_limits_is_in_an_interval_and_found_again_there():
    """The arm angle of q is where the branch that NumPy gives at it is q."""
    arm, found = lwr_dyn.load("lwr4plus"), 0
    for q in poses(arm, 3, 5)[0]:
        T = lwr_dyn.forward_kinematics(arm, q)
        psi = np.linspace(-np.pi, np.pi, 241)
        away = [min(np.abs(s.q - q).max() for s in inverse_kinematics(arm, T, limits=False, arm_angle=x).solutions)
                for x in psi]  # fmt: skip
        k = int(np.argmin(away))
        near = inverse_kinematics(arm, T, limits=False, arm_angle=float(psi[k])).solutions
        branch = min(near, key=lambda s: np.abs(s.q - q).max()).branch
        assert away[k] < 0.1
        pairs = inverse_kinematics(arm, T).arm_angle_intervals[branch]
        gap = min(max(a - x, x - b) for a, b in pairs for x in (psi[k], psi[k] + 2.0 * np.pi))
        found += gap < 0.03
    assert found == 3


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lwr4plus", "wam7"])
def test_stretched_and_aligned_arms(name):
    arm = lwr_dyn.load(name)
    q, _ = poses(arm, 20, 2)
    q = np.clip(np.round(q / (np.pi / 4.0)) * (np.pi / 4.0), arm.lower, arm.upper)
    for T in lwr_dyn.forward_kinematics(arm, q):
        ours, theirs = inverse_kinematics(arm, T), numpys(arm, T)
        assert (ours.status, ours.complete) == (theirs.status, theirs.complete)
        assert ours.solutions[0].margin == pytest.approx(theirs.solutions[0].margin, abs=1e-7)
        assert all(s.residual < 1e-11 for s in ours.solutions)


def test_python_gives_the_bits_of_machine_code():
    arm = lwr_dyn.load("lwr4plus")
    numbers = {**numbers_of_srs(arm, require_srs(arm)), **numbers_of_solutions(arm, False)}
    plain = python_runner(srs_solver.TEXTS, numbers).run
    compiled = RUNNERS.load("compiled")(srs_solver.TEXTS, numbers).run
    for T in poses(arm, 4, 9)[1]:
        a, b = plain(T, 0.4, 0.0), compiled(T, 0.4, 0.0)
        assert np.isnan(a[0]) == np.isnan(b[0])
        assert np.array_equal(a[:56], b[:56]) or np.isnan(a[0])
        assert np.array_equal(a[-8:], b[-8:])
        counts = slice(numbers["COUNTS"], numbers["COUNTS"] + 8)
        assert np.array_equal(a[counts], b[counts]) or np.isnan(a[0])
    T = poses(arm, 1, 9)[1][0]
    assert np.array_equal(plain(T, np.nan, 0.0)[:56], compiled(T, np.nan, 0.0)[:56])


def test_without_llvm_numpy_does_it(monkeypatch):
    def missing(name):
        raise MissingPackageError("llvmlite", "batch")

    monkeypatch.setattr(srs_solver, "RUNNERS", SimpleNamespace(load=missing))
    assert srs_solver.ready.__wrapped__(lwr_dyn.load("lwr4")) is None


def test_intervals_are_found_when_read_and_copies_are_plain():
    arm = lwr_dyn.load("lwr4plus")
    T = poses(arm, 1)[1][0]
    result, theirs = inverse_kinematics(arm, T, arm_angle=0.2), numpys(arm, T, arm_angle=0.2)
    T[:] = 0.0  # they are of the pose that was given
    other = pickle.loads(pickle.dumps(result)).arm_angle_intervals
    assert type(other) is dict
    assert other == dict(result.arm_angle_intervals) == dict(copy.deepcopy(result.arm_angle_intervals))
    assert list(other) == list(theirs.arm_angle_intervals)
    assert [len(x) for x in other.values()] == [len(x) for x in theirs.arm_angle_intervals.values()]
    assert len(result.arm_angle_intervals) == 8
