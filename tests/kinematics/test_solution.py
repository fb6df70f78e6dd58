"""Solutions of a pose: each once, in order; the nearest one; what a row of theirs says."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.solution import (
    MOST_COPIES,
    TURN,
    drawing_range,
    joint_distance,
    nearest_solution,
    whole_turns,
)
from lwr_dyn.kinematics.solution_rows import Solution, SolutionRows
from lwr_dyn.model.arm import JointLimits

LWR = lwr_dyn.load("lwr4plus")
RESIDUAL = 1e-12


def pose(arm, q):
    return lwr_dyn.forward_kinematics(arm, q)


def test_what_is_drawn_where_limits_are_not_known_is_one_turn_or_two_metres():
    inf = np.inf
    lower, upper = np.array([-1.0, -inf, 0.5, -inf, -inf, 0.5]), np.array([2.0, 1.0, inf, inf, 0.25, inf])
    turning = np.array([True, True, True, True, False, False])
    ends = drawing_range(turning, lower, upper)
    assert np.array(ends).T.tolist() == [
        [-1.0, 2.0], [1.0 - TURN, 1.0], [0.5, 0.5 + TURN], [-np.pi, np.pi], [-1.75, 0.25], [0.5, 2.5]]  # fmt: skip


def test_the_nearest_solution_has_the_smallest_joint_distance_and_a_stretched_arm_one_alone():
    kr30 = lwr_dyn.load("kr30ha")
    q = np.random.default_rng(4).uniform(kr30.lower, kr30.upper)
    result = lwr_dyn.inverse_kinematics(kr30, lwr_dyn.forward_kinematics(kr30, q))
    best = nearest_solution(result.solutions, q)
    assert joint_distance(best, q) < 1e-8
    assert joint_distance(best, q) == min(joint_distance(s, q) for s in result.solutions)
    result = inverse_kinematics(LWR, pose(LWR, np.zeros(7)))
    assert result.status == "solved"
    assert len(result.solutions) == 1
    assert np.abs(result.solutions[0].q).max() < 1e-4


def with_ranges(arm, **degrees):
    """The arm with other limits of some joints, j1=(-400, 400) [deg]."""
    limits = list(arm.limits)
    for name, (low, up) in degrees.items():
        i = int(name[1:]) - 1
        limits[i] = replace(limits[i], lower=np.radians(low), upper=np.radians(up))
    return replace(arm, limits=tuple(limits))


def test_every_copy_of_an_srs_arm_inside_wide_limits_is_listed_once():
    arm = with_ranges(LWR, j1=(-200, 380), j5=(-200, 200), j7=(-350, 350))
    narrow = lwr_dyn.inverse_kinematics(LWR, T := lwr_dyn.forward_kinematics(LWR, [0.1, 0.5, 0.2, -1.0, 0.3, 0.4, 0.2]))
    result = lwr_dyn.inverse_kinematics(arm, T, arm_angle=narrow.solutions[0].arm_angle)
    assert (result.status, result.complete, result.turns_left_out) == ("solved", True, 0)
    found = {tuple(s.q.round(9)) for s in result.solutions}
    assert len(found) == len(result.solutions)
    wanted = set()
    for solution in result.solutions:
        for turns in product((-2, -1, 0, 1, 2), repeat=3):
            q = solution.q.copy()
            q[[0, 4, 6]] += TURN * np.array(turns)
            if ((q >= arm.lower) & (q <= arm.upper)).all():
                wanted.add(tuple(q.round(9)))
    assert len(wanted) > len({s.branch for s in result.solutions})
    assert found == wanted
    assert max(s.residual for s in result.solutions) < RESIDUAL
    assert [s.margin for s in result.solutions] == sorted((s.margin for s in result.solutions), reverse=True)


@pytest.mark.parametrize(("robot", "at"), [("lwr4plus", [0.1, 0.5, 0.2, -1.0, 0.3, 0.4, 0.2]), ("kr30ha", [0.1] * 6)])
def test_too_many_copies_are_counted_and_not_called_complete(robot, at):
    arm = lwr_dyn.load(robot)
    wide = with_ranges(arm, j1=(-1e9, 1e9), j4=(-1e300, 1e300))
    result = lwr_dyn.inverse_kinematics(wide, lwr_dyn.forward_kinematics(arm, at))
    assert result.status == "solved"
    assert not result.complete
    assert result.turns_left_out > 1e300
    assert 1 <= len(result.solutions) <= 8
    assert lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, at)).complete


def test_whole_turns_are_listed_up_to_their_bound_at_limits_and_not_of_a_joint_without():
    q = np.zeros(7)
    eight = (-4 * 360 + 1, 4 * 360 - 1)  # 7 copies of 0
    limits = {"j1": eight, "j2": eight, "j3": eight}
    assert 7**2 < MOST_COPIES < 7**3
    assert len(whole_turns(with_ranges(LWR, j1=eight, j2=eight), q).q) == 7**2
    many = whole_turns(with_ranges(LWR, **limits), q)
    assert (len(many.q), many.left_out) == (1, 7**3 - 1)
    outside = replace(LWR, limits=(JointLimits(lower=1.0, upper=2.0), *LWR.limits[1:]))
    assert whole_turns(outside, q).q.tolist() == [q.tolist()]
    kr30 = lwr_dyn.load("kr30ha")
    free = replace(kr30, limits=(replace(kr30.limits[0], lower=None), *kr30.limits[1:]))
    assert len(whole_turns(free, np.array([3.0, 0, 0, 0.3, 0, 0.3])).q) == 4
    edge = np.array([kr30.upper[0], 0, 0, kr30.upper[3], 0, 0])
    assert any(np.array_equal(edge, q) for q in whole_turns(kr30, edge).q)


def test_the_command_says_how_many_are_left_out(tmp_path, lwr_dyn_command):
    urdf = tmp_path / "own.urdf"
    text = lwr_dyn.urdf_text(with_ranges(lwr_dyn.load("lwr4plus"), j1=(-1e6, 1e6)))
    urdf.write_text(text, encoding="utf-8")
    code, out, err = lwr_dyn_command("ik", str(urdf), "--xyz", "-0.05,-0.45,0.55", "--rpy-deg", "-90,0,0")
    assert not code, err
    assert "all branches, each at one arm angle; " in out
    assert "copies whole turns apart, inside the limits too, are not listed" in out


def test_a_result_is_the_same_in_words_and_in_its_record():
    found = inverse_kinematics(LWR, pose(LWR, [0.1, 0.5, 0.2, -1.0, 0.3, 0.4, 0.2]))
    parts = {"distance": 0.25, "joint": "joint_4", "excess": 0.5, "turn": 1.5, "turns_left_out": 3}
    made = replace(found, status="outside limits", solutions=(), outside=tuple(found.solutions), **parts)
    facts = {fact.key: fact.value for fact in made.document.facts}
    wanted = {"status": "outside limits", "complete": True, **{k: v for k, v in parts.items() if k != "turn"}}
    wanted |= {"turn_missed": 1.5, "position_only": False, "singular": []}
    assert {name: facts[name] for name in wanted} == wanted
    assert facts["arm_angle_intervals"] == dict(found.arm_angle_intervals)
    text = made.document.text()
    assert "0 solutions inside the limits, 8 outside; joint_4 outside by 0.5; out of reach by 0.25" in text
    assert "turned away by 1.5" in text
    assert ", ".join(f"{x:.4f}" for x in found.solutions[0].q) in text


ROWS = SolutionRows(
    ("A1", "A2"), np.array([[0.5, -1.0, 0.25, 1.0, 1.0], [3.0, 2.0, -0.5, 0.0, 0.0]]), ("+++", "++-"), (None, 0.25),
    (1e-16, 2e-16), ((), ("elbow",)),
)  # fmt: skip


def test_what_a_row_says():
    one, other = Solution(ROWS, 0), Solution(ROWS, 1)
    assert one.record == {
        "q": [0.5, -1.0], "branch": "++-", "arm_angle": 0.25, "margin": 0.25, "joint": "A2", "inside_limits": True,
        "residual": 2e-16, "singular": ["elbow"],
    }  # fmt: skip
    assert (other.branch, other.arm_angle, other.margin, other.joint) == ("+++", None, -0.5, "A1")
    assert (other.inside_limits, other.residual, other.singular) == (False, 1e-16, ())
    assert repr(other).startswith("Solution(q=array([3., 2.]), branch='+++', arm_angle=None, margin=-0.5, joint='A1'")
    assert [type(x) for x in (one.margin, one.residual, one.inside_limits, one.joint)] == [float, float, bool, str]


@pytest.mark.parametrize("name", ["kr30ha", "ur10", "lwr4plus", "panda"])
def test_every_number_is_that_of_its_position(name):
    """Margins, joints and residuals of all roads: closed forms as machine code, and the search."""
    arm = lwr_dyn.load(name)
    T = lwr_dyn.forward_kinematics(arm, np.clip(np.full(arm.n, 0.4), arm.lower, arm.upper))
    result = lwr_dyn.inverse_kinematics(arm, T)
    solutions = (*result.solutions, *result.outside)
    assert solutions
    for one in solutions:
        room = np.minimum(arm.upper - one.q, one.q - arm.lower)
        assert one.margin == room.min()
        assert one.joint == arm.joint_names[room.argmin()]
        assert one.inside_limits == (room.min() >= -1e-12)
        assert one.residual == pytest.approx(np.abs(flange_pose(arm.chain, one.q) - T).max(), abs=1e-14)
        assert not one.q.flags.writeable
