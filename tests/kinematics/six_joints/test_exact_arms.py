"""One pose by the text of the closed form against NumPy's closed form with all copies listed one by one."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics import solution
from lwr_dyn.kinematics.closed_forms import runners
from lwr_dyn.kinematics.closed_forms.lazy_solutions import LazySolutions
from lwr_dyn.kinematics.inverse import SOLVED, inverse_kinematics
from lwr_dyn.kinematics.six_joints import exact_arms
from lwr_dyn.kinematics.six_joints.exact_arms import six_joint_form
from lwr_dyn.kinematics.six_joints.spherical_wrist import branch_result
from lwr_dyn.kinematics.solution import PoseProblem, wrap
from tests.kinematics.six_joints.six_joint_arms import six_joint_arm

ARMS = ("kr30ha", "tx40", "puma560", "ur10", "ur5e")


def one_by_one(arm, T, limits=True):
    """The result as NumPy's branches give it."""
    found, problem = six_joint_form(arm).branches(T[None]), PoseProblem(arm, T, limits)
    which = np.flatnonzero(found.reachable[0])
    if not len(which):
        distance = float(found.reach_excess.min())
        return solution.InverseResult("out of reach", (), (), True, distance=distance)
    return branch_result(problem, found, found.q[0, which], which, complete=True)


def positions(arm, count, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(np.maximum(arm.lower, -6.0), np.minimum(arm.upper, 6.0), (count, 6))


def facts(result):
    names = "status", "complete", "joint", "turn", "turns_left_out", "singular"
    return len(result.solutions), len(result.outside), *(getattr(result, name) for name in names)


def same(ours, theirs):
    """Largest difference of q and margin between solutions of the same branch, matched one to one."""
    a, b = (np.array([[*s.q, s.margin, solution.BRANCHES.index(tuple(2 * (x == "+") - 1 for x in s.branch))]
                      for s in each]).reshape(-1, 8) for each in (ours, theirs))  # fmt: skip
    assert len(a) == len(b)
    if not len(a):
        return 0.0
    gaps = np.abs(a[:, None] - b).max(axis=2)
    nearest = gaps.argmin(axis=1)
    assert len(set(nearest.tolist())) == len(a)
    assert [s.singular for s in ours] == [theirs[i].singular for i in nearest]
    return float(gaps.min(axis=1).max(initial=0.0))


def test_a_row_of_the_solvers_gives_what_the_text_gives():
    arm, solver = lwr_dyn.load("kr30ha"), exact_arms.WRIST_SOLVER
    T = lwr_dyn.forward_kinematics(arm, np.radians([10.0, -80.0, 95.0, 30.0, 40.0, -20.0]))
    found, exact = solver.solve(PoseProblem(arm, T, True), solver.recognise(arm.chain)), one_by_one(arm, T)
    assert facts(found) == facts(exact)
    assert same(found.solutions, exact.solutions) < 1e-9


@pytest.mark.parametrize("name", ARMS)
def test_the_solutions_are_those_of_numpys_closed_form(name):
    arm, worst, statuses = lwr_dyn.load(name), 0.0, set()
    T = lwr_dyn.forward_kinematics(arm, positions(arm, 8))
    T[::3, :3, 3] *= 1.25
    T[4, :3, 3] *= 9.0
    for k, pose in enumerate(T):
        limits = k % 4 != 1
        ours, theirs = inverse_kinematics(arm, pose, limits=limits), one_by_one(arm, pose, limits)
        assert facts(ours) == facts(theirs)
        assert exact_arms.ready(arm)(pose, limits) is not None  # no other road did it
        assert ours.solutions == () or isinstance(ours.solutions, LazySolutions)
        assert (ours.distance or 0.0) == pytest.approx(theirs.distance or 0.0, abs=1e-13)
        assert (ours.excess or 0.0) == pytest.approx(theirs.excess or 0.0, abs=1e-12)
        margins = [s.margin for s in ours.solutions]
        assert margins == sorted(margins, reverse=True)
        assert all(s.residual < 1e-12 for s in (*ours.solutions, *ours.outside))
        worst = max(worst, same(ours.solutions, theirs.solutions), same(ours.outside, theirs.outside))
        statuses.add(ours.status)
    assert worst < 1e-9
    assert statuses >= {"solved", "out of reach"}


@pytest.mark.parametrize("name", ARMS)
def test_outside_narrow_limits_the_branch_that_is_least_so_is_named_by_its_worst_joint(name):
    arm, half, worst = lwr_dyn.load(name), 0.2, set()
    middle = positions(arm, 1, 5)[0]
    limits = [replace(x, lower=q - half, upper=q + half) for x, q in zip(arm.limits, middle, strict=True)]
    narrow = replace(arm, limits=tuple(limits))
    for T in lwr_dyn.forward_kinematics(arm, positions(arm, 12, 6)):
        branches = np.array([s.q for s in inverse_kinematics(arm, T, limits=False).solutions])
        room = half - np.abs(wrap(branches - middle))
        least = room.min(axis=1).argmax()
        found = inverse_kinematics(narrow, T)
        assert (found.status, found.joint) == ("outside limits", arm.joint_names[room[least].argmin()])
        assert found.excess == pytest.approx(-room[least].min(), abs=1e-12)
        worst.add(found.joint)
    assert len(worst) >= 4


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_every_position_is_found_again(name):
    arm = lwr_dyn.load(name)
    q = positions(arm, 200, 7)
    q[::7, 4], q[1::7, 2] = 0.0, np.clip(0.0, arm.lower[2], arm.upper[2])
    lost = 0
    for row, T in zip(q, lwr_dyn.forward_kinematics(arm, q), strict=True):
        found = inverse_kinematics(arm, T)
        assert found.status == "solved"
        assert max(s.residual for s in found.solutions) < 1e-11
        gap = np.abs(np.array([s.q for s in found.solutions]) - row).max(axis=1).min()
        # on a singularity only a sum of joints, or the elbow to half the digits, is determined
        lost += gap > 1e-9 and not found.singular
    assert lost == 0


@pytest.mark.parametrize("name", ["kr30ha", "ur10"])
def test_singular_poses_and_joints_at_their_limits(name):
    arm, q = lwr_dyn.load(name), positions(lwr_dyn.load(name), 16, 3)
    q[::4, 4], q[1::4, 2] = 0.0, np.clip(0.0, arm.lower[2], arm.upper[2])
    q[2::4] = np.where(np.arange(6) % 2, arm.lower, arm.upper)
    q[3::4] = np.clip(np.round(q[3::4] / (np.pi / 2.0)) * (np.pi / 2.0), arm.lower, arm.upper)
    seen = set()
    for T in lwr_dyn.forward_kinematics(arm, q):
        ours, theirs = inverse_kinematics(arm, T), one_by_one(arm, T)
        assert (ours.status, ours.complete, ours.singular) == (theirs.status, theirs.complete, theirs.singular)
        assert all(s.residual < 1e-11 for s in ours.solutions)
        a, b = (np.array([s.q for s in each.solutions]) for each in (ours, theirs))
        away = np.abs(wrap(a[:, None] - b)).max(axis=2)
        # stretched, rounding decides between one branch and two that are 1e-8 apart
        assert max(away.min(axis=0).max(), away.min(axis=1).max()) < 1e-6 or "wrist" in ours.singular
        seen |= set(ours.singular)
    assert {"wrist", "elbow"} <= seen or name == "kr30ha"


def test_branches_that_meet_are_one_solution_and_too_many_whole_turns_are_counted_not_listed():
    """A stretched elbow, whole turns apart too: half as many as of a bent one."""
    arm = lwr_dyn.load("ur10")
    straight = [0.3, -1.0, 0.0, 0.5, 1.0, 0.2]
    T = lwr_dyn.forward_kinematics(arm, straight)
    found = inverse_kinematics(arm, T)
    places = np.round(np.array([s.q for s in found.solutions]), 6)
    assert len(np.unique(places, axis=0)) >= len(found.solutions) / 2
    assert np.abs(np.array([s.q for s in found.solutions]) - straight).max(axis=1).min() < 1e-7
    assert exact_arms.ready(six_joint_arm("ur10", 1e-4)) is None
    assert six_joint_form(lwr_dyn.load("panda")) is None
    # an arm whose axes are parallel to rounding only may need a polish, by its residuals
    solvers = [exact_arms.ready(lwr_dyn.load(name)) for name in ("kr30ha", "ur10")]
    assert [(x.largest, x.numbers["IS_CHECKED"]) for x in solvers] == [(np.inf, 0), (SOLVED, 1)]
    arm = six_joint_arm("ur10", reach=20.0)
    T = lwr_dyn.forward_kinematics(arm, [0.1, -1.0, 1.2, 0.3, 0.4, 0.5])
    ours, theirs = inverse_kinematics(arm, T), one_by_one(arm, T)
    assert facts(ours) == facts(theirs)
    assert ours.turns_left_out > 1000
    assert not ours.complete
    assert isinstance(ours.solutions, LazySolutions)


def test_without_llvm_the_same_solutions(monkeypatch):
    arm = lwr_dyn.load("kr30ha")
    T = lwr_dyn.forward_kinematics(arm, positions(arm, 6))
    wanted = [inverse_kinematics(arm, pose) for pose in T]
    monkeypatch.setattr(exact_arms, "runner", runners.python_runner)
    found = [exact_arms.ready.__wrapped__(arm)(pose, True) for pose in T]
    for a, b in zip(found, wanted, strict=True):
        assert facts(a) == facts(b)
        assert np.array_equal([s.q for s in a.solutions], [s.q for s in b.solutions])
