"""Inverse kinematics by closed form or search: every branch at rounding, what is out of reach, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied, template
from lwr_dyn.foundation.errors import OptionError, ShapeError, UnknownNameError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.inverse import IK_SOLVERS, _step, inverse_kinematics
from lwr_dyn.kinematics.solution import IkSolver
from lwr_dyn.model.arm import JointLimits
from lwr_dyn.model.chain import lock_joint
from tests.kinematics.wrong_poses import refused_or_right
from tests.random_arms import random_arm

RESIDUAL = 1e-12
NUMERIC = 1e-11
"""The numeric search stops here."""
LWR = lwr_dyn.load("lwr4plus")
SIX = replace(LWR, name="six", chain=lock_joint(LWR.chain, 2, 0.3), limits=LWR.limits[:2] + LWR.limits[3:])


def pose(arm, q):
    return lwr_dyn.forward_kinematics(arm, q)


@pytest.mark.slow
def test_random_poses_are_solved_and_every_solution_describes_itself():
    rng = np.random.default_rng(2)
    for q in rng.uniform(LWR.lower, LWR.upper, (60, 7)):
        T = pose(LWR, q)
        result = inverse_kinematics(LWR, T)
        assert (result.status, result.complete) == ("solved", True)
        assert len(result.solutions) + len(result.outside) == 8
        for s in result.solutions + result.outside:
            assert np.abs(pose(LWR, s.q) - T).max() <= RESIDUAL
            assert s.inside_limits == (s in result.solutions) == bool(result.arm_angle_intervals[s.branch])
        order = [s.margin for s in result.solutions]
        assert order == sorted(order, reverse=True)


def test_a_given_arm_angle_is_kept_and_its_intervals_show_whether_it_is_inside():
    T = pose(LWR, [0.3, 0.7, 0.2, -1.3, 0.4, 0.9, 0.1])
    for psi in np.linspace(-3, 3, 25):
        result = inverse_kinematics(LWR, T, arm_angle=psi)
        for s in result.solutions + result.outside:
            arcs = result.arm_angle_intervals[s.branch]
            assert s.arm_angle == psi
            assert s.inside_limits == any(a <= psi + turn <= b for a, b in arcs for turn in (0, 2 * np.pi))


def test_out_of_reach_is_distinguished_from_outside_limits():
    T = pose(LWR, [0.3, 0.7, 0.2, -1.3, 0.4, 0.9, 0.1])
    far = T.copy()
    far[:3, 3] = [0, 0, 1.5 + 0.078]
    far[:3, :3] = np.eye(3)
    result = inverse_kinematics(LWR, far)
    assert (result.status, result.complete, result.solutions) == ("out of reach", True, ())
    assert result.distance == pytest.approx(1.5 - 0.79)
    for arm, height, distance in (
        (LWR, 0.005 + 0.078, 0.005),
        (lwr_dyn.load("wam7"), 0.89 + 0.06, 0.89 - np.hypot(0.55, 0.045) - np.hypot(0.3, 0.045)),
    ):
        far[2, 3] = height
        result = inverse_kinematics(arm, far)
        assert (result.status, result.distance) == ("out of reach", pytest.approx(distance, rel=1e-10))
    bent = pose(LWR, [0.3, 0.7, 0.2, -2.3, 0.4, 0.9, 0.1])
    result = inverse_kinematics(LWR, bent)
    assert (result.status, result.joint, result.distance) == ("outside limits", "joint_4", None)
    assert result.excess == pytest.approx(2.3 - np.radians(120))
    assert len(result.outside) == 8
    assert inverse_kinematics(LWR, bent, limits=False).status == "solved"
    assert len(inverse_kinematics(LWR, bent, limits=False).solutions) == 8


@pytest.mark.slow
def test_a_moving_joint_outside_at_every_arm_angle_is_named_with_its_least_excess():
    tight = replace(LWR, limits=(*LWR.limits[:5], JointLimits(-0.1, 0.1), LWR.limits[6]))
    T = pose(LWR, [0.3, 0.7, 0.2, -1.3, 0.4, 1.5, 0.1])
    result = inverse_kinematics(tight, T)
    assert (result.status, result.joint) == ("outside limits", "joint_6")
    angles = np.linspace(-3.14, 3.14, 600)
    found = (s for x in angles for s in inverse_kinematics(tight, T, arm_angle=x, limits=False).solutions)
    least = min(abs(s.q[5]) - 0.1 for s in found if s.joint == "joint_6")
    assert least - 1e-3 < result.excess <= least + 1e-9


XYZ = [0.1, 0.2, 0.3]
REFUSED = [
    *((arm, T, {}, error, words) for arm in (LWR, SIX) for T, error, words in (
        (np.eye(3), ShapeError, "allowed: 4 x 4 numbers"), (np.full((4, 4), np.nan), ShapeError, "finite"),
        (np.diag([1, 1, -1, 1.0]), OptionError, "mirror"), (np.diag([1, 1, 1.1, 1.0]), OptionError, "rotation"),
        (np.ones((4, 4)), OptionError, "last row"), ("pose", ShapeError, "numbers"), (XYZ, ShapeError, "4 x 4"))),
    *((LWR, np.eye(4), {"arm_angle": x}, OptionError, "arm_angle.*finite") for x in (np.inf, np.nan)),
    (SIX, np.eye(4), {"arm_angle": 0.0}, OptionError, "arm_angle.*S-R-S"),
    (SIX, np.eye(4), {"starts": 0}, OptionError, "starts"),
    (LWR, XYZ, {"position_only": True, "arm_angle": 0.0}, OptionError, "position only"),
    (LWR, XYZ, {"position_only": True, "solver": "srs"}, OptionError, "position only"),
    (LWR, XYZ, {"position_only": True, "q0": [0.0]}, ShapeError, "q0"),
    (LWR, np.eye(4), {"solver": "newton"}, UnknownNameError, r"known: srs, spherical-wrist.*numeric"),
    (lwr_dyn.load("kr30ha"), np.eye(4), {"solver": "srs"}, OptionError,
     "solver srs: kr30ha is not an arm that it solves; allowed: a seven"),
    (LWR, np.eye(4), {"solver": "numeric", "arm_angle": 0.0}, OptionError, "arm_angle"),
]  # fmt: skip


@pytest.mark.parametrize(("arm", "T", "options", "error", "words"), REFUSED, ids=range(len(REFUSED)))
def test_what_is_no_pose_or_option_is_refused(arm, T, options, error, words):
    with pytest.raises(error, match=words):
        inverse_kinematics(arm, T, **options)


@pytest.mark.parametrize("name", IK_SOLVERS.names)
def test_every_row_of_the_solvers_loads(name):
    solver = IK_SOLVERS.load(name)
    assert isinstance(solver, IkSolver)
    assert solver.arms
    recognised = {robot for robot in studied() if solver.recognise(lwr_dyn.load(robot).chain) is not None}
    expected = {"srs": {"lwr4", "lwr4plus", "wam7"}, "spherical-wrist": {"kr30ha"}, "numeric": {*studied()}}
    expected |= {"three-parallel": set(), "rounded-wrist": {"kr30ha"}, "eaik": {"kr30ha"}}
    assert recognised == expected[name]


@pytest.mark.parametrize(("robot", "closed"), [("lwr4plus", "srs"), ("kr30ha", "spherical-wrist")])
def test_a_solver_can_be_chosen_and_finds_poses_of_the_closed_form(robot, closed):
    arm = lwr_dyn.load(robot)
    T = pose(arm, np.clip(np.full(arm.n, 0.5), arm.lower, arm.upper))
    first, named = inverse_kinematics(arm, T), inverse_kinematics(arm, T, solver=closed)
    assert [s.q.tolist() for s in named.solutions] == [s.q.tolist() for s in first.solutions]
    searched = inverse_kinematics(arm, T, solver="numeric", starts=16)
    assert (searched.status, searched.complete) == ("solved", False)
    assert all(np.abs(pose(arm, s.q) - T).max() <= NUMERIC for s in searched.solutions)


@pytest.mark.slow
def test_numeric_search_solves_other_arms_inside_limits_and_calls_itself_incomplete():
    for q in np.random.default_rng(4).uniform(SIX.lower, SIX.upper, (10, 6)):
        T = pose(SIX, q)
        result = inverse_kinematics(SIX, T, starts=32)
        assert (result.status, result.complete) == ("solved", False)
        for s in result.solutions:
            assert max(np.abs(pose(SIX, s.q) - T).max(), s.residual) <= NUMERIC
            assert ((s.q >= SIX.lower) & (s.q <= SIX.upper)).all()
    again = inverse_kinematics(SIX, T, starts=32)
    assert all((a.q == b.q).all() for a, b in zip(result.solutions, again.solutions, strict=True))


def test_a_joint_that_pushes_against_its_limit_is_held_and_the_others_do_the_work():
    rng = np.random.default_rng(1)
    J, error = rng.normal(size=(1, 6, 7)), rng.normal(size=(1, 6))
    free = np.linalg.pinv(J[0]) @ error[0]
    q, wide, weak = np.zeros((1, 7)), np.full(7, 9.0), np.array([1e-14])
    j = int(np.argmax(free))
    upper = np.where(np.arange(7) == j, 0.0, wide)
    step = _step(J, error, weak, q, -wide, upper)[0]
    assert step[j] == 0.0
    assert J[0] @ step == pytest.approx(error[0], abs=1e-9)


@pytest.mark.parametrize("rank", range(5))
def test_a_jacobian_that_has_lost_rank_gives_a_step(rank):
    """UR10e with a stretched elbow and others ended with "Singular matrix": J J^T alone is singular to rounding."""
    rng = np.random.default_rng(rank)
    J = np.round(rng.normal(size=(300, 6, rank)), 2) @ np.round(rng.normal(size=(300, rank, 7)), 1)
    error, wide, q = np.einsum("kij,kj->ki", J, rng.normal(size=(300, 7))), np.full(7, 9.0), np.zeros((300, 7))
    step = _step(J, error, np.full(300, 1e-20), q, -wide, wide)
    assert np.abs(np.einsum("kij,kj->ki", J, step) - error).max() <= 1e-6 * max(1.0, np.abs(error).max())
    _step(J, rng.normal(size=(300, 6)), np.full(300, 1e-20), q, -wide, wide)  # a pose out of reach


@pytest.mark.parametrize("seed", range(4))
def test_numeric_search_with_sliding_joints(seed):
    arm = random_arm(seed, "RPRRPRR")
    T = pose(arm, np.random.default_rng(seed).uniform(-0.8, 0.8, 7))
    result = inverse_kinematics(arm, T, starts=32)
    assert result.status == "solved"
    assert result.solutions[0].residual <= NUMERIC


def test_numeric_search_distinguishes_reach_from_limits():
    far = np.eye(4)
    far[0, 3] = 3.0
    result = inverse_kinematics(SIX, far, starts=16)
    assert (result.status, result.complete) == ("out of reach", False)
    assert result.distance > 2.0
    bent = pose(SIX, [0.3, 0.7, -2.3, 0.4, 0.9, 0.1])
    result = inverse_kinematics(SIX, bent, starts=16)
    assert (result.status, result.joint) == ("outside limits", "joint_4")
    assert result.excess >= 2.3 - np.radians(120) - 1e-9
    facts = result.document.record()
    assert [facts[name] for name in ("status", "joint", "excess")] == [result.status, "joint_4", result.excess]
    position = pose(SIX, [0.3, 0.7, -2.6, 0.4, 0.0, 0.1])[:3, 3]
    result = inverse_kinematics(SIX, position, position_only=True, starts=16)
    assert (result.status, result.position_only) == ("outside limits", True)
    result = inverse_kinematics(SIX, [3.0, 0.0, 0.0], position_only=True, starts=16)
    assert (result.status, result.turn) == ("out of reach", None)
    assert result.distance > 2.0


def test_an_arm_of_four_joints_meets_a_position_and_says_how_far_the_orientation_is_off(tmp_path):
    file = tmp_path / "arm.toml"
    file.write_text(template(str(file), "arm", joints="RRPR", convention="modified"))
    arm, T = lwr_dyn.load(file), np.eye(4)
    T[:3, 3] = 0.3, 0.1, 0.3
    result = inverse_kinematics(arm, T)
    assert (result.status, result.complete, result.distance) == ("out of reach", False, 0.0)
    found = inverse_kinematics(arm, T[:3, 3], position_only=True).solutions[0]
    R = flange_pose(arm.chain, found.q)[:3, :3]
    assert 0.1 < result.turn <= np.arccos((np.trace(R) - 1.0) / 2.0) + 1e-9


@pytest.mark.parametrize("robot", ["kr30ha", "lwr4plus", "wam7"])
def test_a_position_alone_is_reached_from_a_start_inside_the_limits(robot):
    arm, rng = lwr_dyn.load(robot), np.random.default_rng(6)
    for q in rng.uniform(arm.lower, arm.upper, (8, arm.n)):
        position = pose(arm, q)[:3, 3]
        result = inverse_kinematics(arm, position, position_only=True)
        (solution,) = result.solutions
        assert (result.status, result.position_only, result.complete) == ("solved", True, False)
        assert np.abs(pose(arm, solution.q)[:3, 3] - position).max() <= NUMERIC
        assert solution.residual <= NUMERIC
        assert solution.inside_limits
        near = np.clip(q + 0.01, arm.lower, arm.upper)
        moved = inverse_kinematics(arm, pose(arm, q), position_only=True, q0=near).solutions[0].q
        assert np.abs(moved - near).max() < 0.3


@pytest.mark.parametrize("name", ["kr30ha", "ur5e", "lwr4plus"])
def test_poses_in_every_form_are_refused_or_solved_rightly(name):
    refused, answered = refused_or_right(lwr_dyn.load(name), 150, 1)
    assert min(refused, answered) > 40
