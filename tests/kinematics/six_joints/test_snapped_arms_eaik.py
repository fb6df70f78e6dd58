"""The solver "eaik": only what forward kinematics confirms is a solution; without EAIK the extra is named."""

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import MissingPackageError
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.solution import wrap
from tests.kinematics.six_joints.six_joint_arms import six_joint_arm

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


def test_a_list_without_a_confirmed_solution_is_not_a_solution(stand_in):
    stand_in.listed = (Q + 1e-3,)
    assert inverse_kinematics(ARM, T, solver="eaik").status == "out of reach"


def test_arms_that_eaik_does_not_solve_are_refused(stand_in):
    with pytest.raises(lwr_dyn.foundation.errors.OptionError, match="solver eaik: lwr4plus"):
        inverse_kinematics(lwr_dyn.load("lwr4plus"), np.eye(4), solver="eaik")
    stand_in.decomposes = False
    with pytest.raises(lwr_dyn.foundation.errors.OptionError, match="solver eaik: ur10e"):
        inverse_kinematics(ARM, T, solver="eaik")


def test_without_eaik_the_extra_is_named(monkeypatch):
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
