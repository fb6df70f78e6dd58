"""All branches of six-joint arms: as many as a search from many starts finds, also where the arm is not quite exact."""

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import MissingPackageError, OptionError
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.six_joints.snapped_arms import snapped_arm, solve_snapped, three_parallel_closed_form
from lwr_dyn.kinematics.six_joints.spherical_wrist import NEAR_SINGULAR, SixJointBranches
from lwr_dyn.kinematics.solution import PoseProblem, joint_ranges, wrap
from tests.kinematics.six_joints.six_joint_arms import PARALLEL, TABLES, against_search, assert_recovered, six_joint_arm

SOLVED = 1e-11
"""[m and dimensionless] The polish stops here."""
SAME = 1e-9
"""[rad] Largest difference of a branch to the same solution of a search, away from singularities."""


ROUNDED = ("m1013", "lite6")


@pytest.mark.parametrize("name", TABLES)
def test_each_arm_is_of_one_kind_exactly_or_snapped(name):
    exact, calibrated = six_joint_arm(name).chain, six_joint_arm(name, error=1e-4).chain
    ball, other = (4, 3) if name in PARALLEL else (3, 4)
    assert 1e-5 < snapped_arm(calibrated, ball).off < 1e-3
    assert (snapped_arm(exact, ball).off > 0.0) == (name in ROUNDED)
    assert snapped_arm(exact, other) is None
    for error in (0.02, 0.1):  # axes far from the kind
        far = six_joint_arm(name, error).chain
        assert snapped_arm(far, 3) is snapped_arm(far, 4) is None


def test_constants_of_a_ur10e_are_those_of_its_table():
    g = snapped_arm(six_joint_arm("ur10e").chain, 4).geometry
    assert g.lengths == pytest.approx((0.6127, 0.57155), abs=1e-15)
    assert abs(g.lateral) == pytest.approx(0.17415, abs=1e-15)
    assert np.hypot(*g.lever) == pytest.approx(0.11985, abs=1e-15)
    assert abs(g.straight) < 1e-12
    calibrated = snapped_arm(six_joint_arm("ur10e", error=1e-4).chain, 4).geometry
    assert calibrated.lengths == pytest.approx(g.lengths, abs=1e-3)


@pytest.mark.parametrize(
    ("name", "error", "seed"),
    [("ur10e", 0.0, 0), ("ur10e", 1e-4, 1), ("kr210", 1e-3, 2), ("m1013", 0.0, 3), ("z1", 1e-4, 4), ("tx60", 0.0, 5)],
)
def test_branches_are_those_of_a_search_from_many_starts(name, error, seed):
    arm = six_joint_arm(name, error, seed)
    T = lwr_dyn.forward_kinematics(arm, np.random.default_rng(seed).uniform(-np.pi, np.pi, 6))
    count, shared, only_searched, gap = against_search(arm, T, starts=120)
    assert (count, only_searched) == (shared, 0)
    assert count >= 2
    assert gap < SAME


@pytest.mark.slow
@pytest.mark.parametrize("error", [0.0, 1e-4])
@pytest.mark.parametrize("name", TABLES)
def test_the_joints_of_random_poses_are_among_their_branches(name, error):
    arm = six_joint_arm(name, error)
    for q in np.random.default_rng(1).uniform(-np.pi, np.pi, (5, 6)):
        result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, q))
        exact = error == 0.0 and name not in ROUNDED
        assert (result.status, result.complete) == ("solved", exact)
        assert min(np.abs(wrap(s.q - q)).max() for s in result.solutions) < 1e-7
        assert max(s.residual for s in result.solutions) < SOLVED
        labels = {s.branch for s in result.solutions}
        assert len(labels) == len({tuple(np.round(np.exp(1j * s.q), 6)) for s in result.solutions})


@pytest.mark.parametrize("name", ["ur10e", "kr210"])
@pytest.mark.parametrize("joint", [2, 4])
def test_stretched_and_aligned_arms_with_calibrated_numbers_keep_their_branches(name, joint):
    arm = six_joint_arm(name, 1e-4, seed=3)
    q = np.array([0.4, -1.0, 1.1, -0.6, 1.3, 0.2])
    q[joint] = (np.arctan2(0.054, 1.5) - np.pi / 2) * (joint == 2 and name == "kr210")
    result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, q))
    assert min(np.abs(wrap(s.q - q)).max() for s in result.solutions) < 1e-4
    assert max(s.residual for s in result.solutions) < SOLVED


def test_a_pose_out_of_reach_is_proven_so_only_on_an_exact_arm_and_by_a_form_that_finds_nothing():
    far = np.eye(4)
    far[0, 3] = 3.0
    for error, proven in ((0.0, True), (1e-4, False)):
        result = lwr_dyn.inverse_kinematics(six_joint_arm("ur10e", error), far)
        assert (result.status, result.complete) == ("out of reach", proven)
        assert 1.5 < result.distance < 2.0
    arm = six_joint_arm("ur10e")
    nothing = SixJointBranches(np.full((1, 8, 6), np.nan), np.full((1, 8), 0.25), np.ones((1, 8, 3)))
    problem = PoseProblem(arm, np.eye(4))
    result = solve_snapped(lambda *given: nothing, problem, snapped_arm(arm.chain, 4))
    assert (result.status, result.distance) == ("out of reach", 0.25)


ARM = six_joint_arm("ur10e")
Q = np.array([0.1, -1.0, 1.2, 0.3, 0.4, 0.5])
T = lwr_dyn.forward_kinematics(ARM, Q)


class StandIn:
    """Lists a solution twice, a whole turn apart, one of least squares, and one that is not a number."""

    decomposes, listed = True, (Q, Q + 2.0 * np.pi, Q + 1e-3, np.full(6, np.nan))

    def __init__(self, axes, offsets):
        assert np.asarray(axes).shape == (6, 3)
        assert np.asarray(offsets).shape == (7, 3)

    def hasKnownDecomposition(self):
        return self.decomposes

    def IK(self, pose):
        assert pose.shape == (4, 4)
        return SimpleNamespace(Q=np.array(self.listed))


@pytest.fixture
def stand_in(monkeypatch):
    module = ModuleType("eaik.IK_HP")
    module.HPRobot = type("Listing", (StandIn,), {})
    monkeypatch.setitem(sys.modules, "eaik", ModuleType("eaik"))
    monkeypatch.setitem(sys.modules, "eaik.IK_HP", module)
    return module.HPRobot


def test_only_confirmed_solutions_are_kept_each_once_with_its_whole_turns(stand_in):
    result = inverse_kinematics(ARM, T, solver="eaik")
    assert (result.status, result.complete, len(result.solutions)) == ("solved", False, 2**6)
    assert all(np.abs(wrap(s.q - Q)).max() < 1e-12 for s in result.solutions)
    stand_in.listed = (Q + 1e-3,)
    assert inverse_kinematics(ARM, T, solver="eaik").status == "out of reach"


def test_arms_that_eaik_does_not_solve_are_refused_and_without_it_the_extra_is_named(stand_in, monkeypatch):
    with pytest.raises(OptionError, match="solver eaik: lwr4plus"):
        inverse_kinematics(lwr_dyn.load("lwr4plus"), np.eye(4), solver="eaik")
    stand_in.decomposes = False
    with pytest.raises(OptionError, match="solver eaik: ur10e"):
        inverse_kinematics(ARM, T, solver="eaik")
    monkeypatch.setitem(sys.modules, "eaik.IK_HP", None)
    with pytest.raises(MissingPackageError, match=r"pip install 'lwr_dyn\[eaik\]'"):
        inverse_kinematics(ARM, T, solver="eaik")


@pytest.mark.parametrize("name", ["ur10e", "kr210", "tx60"])
def test_its_solutions_are_our_branches(name):
    arm, rng = six_joint_arm(name), np.random.default_rng(4)
    for q in rng.uniform(-np.pi, np.pi, (20, 6)):
        pose = lwr_dyn.forward_kinematics(arm, q)
        theirs = inverse_kinematics(arm, pose, solver="eaik", limits=False).solutions
        ours = inverse_kinematics(arm, pose, limits=False).solutions
        assert len(theirs) == len(ours)
        mine = np.array([s.q for s in ours])
        assert max(np.abs(s.q - mine).max(axis=1).min() for s in theirs) < 1e-8


POSE, FOUND = 1e-11, 1e-8
"""[m and dimensionless], [rad]"""


@pytest.mark.slow
@pytest.mark.parametrize("name", PARALLEL)
def test_q_is_among_the_branches_and_each_branch_gives_the_pose(name):
    arm = six_joint_arm(name)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (2000, 6))
    T = lwr_dyn.forward_kinematics(arm, q)
    result = three_parallel_closed_form(snapped_arm(arm.chain, 4).geometry, joint_ranges(arm), T)
    assert_recovered(arm, result, q, 1e-3, FOUND, 0.9)


@pytest.mark.slow
@pytest.mark.parametrize("distance", [0.0, 1e-16, 1e-12, 1e-9, 1e-6])
def test_an_aligned_wrist_is_named_and_gives_one_of_its_many_solutions(distance):
    arm = six_joint_arm("ur10e")
    for q in np.random.default_rng(2).uniform(-np.pi, np.pi, (30, 6)):
        q[4] = distance
        result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, q))
        assert result.status == "solved"
        assert "wrist" in result.singular
        assert max(s.residual for s in result.solutions) < POSE


def test_stretched_elbows_are_named_and_solved_and_every_copy_whole_turns_apart_is_listed():
    arm = six_joint_arm("ur10e")
    for q in np.random.default_rng(3).uniform(-np.pi, np.pi, (30, 6)):
        q[2] = 0.0
        result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, q))
        assert "elbow" in result.singular
        assert max(s.residual for s in result.solutions) < POSE
        assert min(np.abs(wrap(s.q - q)).max() for s in result.solutions) < 1e-6
    arm = six_joint_arm("ur10e")
    result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, [0.1, -1.0, 1.2, 0.3, 0.4, 0.5]))
    assert len(result.solutions) == 2**6 * len({s.branch for s in result.solutions})
    assert len({tuple(s.q.round(9)) for s in result.solutions}) == len(result.solutions)
    assert max(s.residual for s in result.solutions) < SOLVED
    assert all(s.inside_limits for s in result.solutions)


def test_out_of_reach_says_by_how_much():
    """Above the arm by 4 m; and with W on axis 1, whose offset from the plane cannot be had."""
    arm = six_joint_arm("ur10e")
    T = lwr_dyn.forward_kinematics(arm, np.array([0.3, -0.7, 0.0, 0.4, 1.2, 0.1]))
    wrist = T[:3, 3] + T[:3, :3] @ snapped_arm(arm.chain, 4).geometry.wrist_in_flange
    for place, least, most in (
        ([*wrist[:2], 4.0], 4.0 - 0.1807 - 0.6127 - 0.57155 - 0.11985, 4.0),
        ([0.0, 0.0, 0.8], NEAR_SINGULAR, 1.0),
    ):
        far = T.copy()
        far[:3, 3] += place - wrist
        result = lwr_dyn.inverse_kinematics(arm, far)
        assert (result.status, result.complete) == ("out of reach", True)
        assert least < result.distance < most
