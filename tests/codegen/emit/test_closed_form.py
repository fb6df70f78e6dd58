"""Closed-form inverse kinematics in C and JavaScript against Python: branches, arm angle, intervals, the nearest."""

import ctypes
import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.emit.closed_form import NAME, inverse_kinematics_function
from lwr_dyn.codegen.emit.emission import emitted_arm
from lwr_dyn.dynamics.pinocchio_engine import flange_and_jacobian
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.arm_geometry import srs_geometry
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.six_joints.exact_arms import six_joint_form
from lwr_dyn.kinematics.solution import BRANCHES, joint_ranges, wrap
from lwr_dyn.kinematics.srs import arm_triangle, closed_form
from lwr_dyn.kinematics.srs_margins import intervals_at_level, margin_problem
from tests.codegen.emit.programs import node
from tests.codegen.emit.shared_library import SharedLibrary
from tests.kinematics.six_joints.six_joint_arms import six_joint_arm

CLOSE = 1e-12
COUNT = 60
ROBOTS = ("lwr4plus", "wam7", "kr30ha", "ur10")


@pytest.fixture(scope="module", params=ROBOTS)
def library(request, tmp_path_factory):
    emitted = emitted_arm(lwr_dyn.load(request.param), [NAME])
    return SharedLibrary(emitted, tmp_path_factory.mktemp(request.param))


def states(arm, seed=0, count=COUNT):
    """Positions inside the limits, their poses (every tenth farther out), arm angles."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi), (count, arm.n))
    T = np.ascontiguousarray(flange_pose(arm.chain, q))
    T[::10, :3, 3] *= 2.5
    return q, T, rng.uniform(-np.pi, np.pi, count)


def assert_at(arm, q, T):
    """The flange is there, by our chain and by Pinocchio's model."""
    assert np.abs(flange_pose(arm.chain, q) - T).max() < CLOSE
    flange = flange_and_jacobian(arm)
    assert max(np.abs(flange(row)[0] - pose).max() for row, pose in zip(q, T, strict=True)) < CLOSE


def branches(library, T, psi):
    out, excess = np.zeros((len(T), 8, library.arm.n)), np.zeros(len(T))
    for k in range(len(T)):
        excess[k] = library.call(NAME, T[k], *([float(psi[k])] if library.arm.n == 7 else []), out[k])
    return out, excess


def intervals(library, pose, level):
    """(numbers at the ends, their counts) of every branch, and what is expected of each."""
    pairs, counts, arm = np.zeros((8, 16, 2)), np.zeros(8, dtype=np.intc), library.arm
    assert library.call(NAME + "_intervals", pose, level, pairs, counts) == 0.0
    rows, signs = np.broadcast_to(pose, (8, 4, 4)), np.array(BRANCHES, dtype=float)
    wanted = intervals_at_level(margin_problem(srs_geometry(arm.chain), joint_ranges(arm), rows, signs), level)
    return [(pairs[b, : counts[b]], np.array(wanted.of(b)).reshape(-1, 2)) for b in range(8)]


def expected_branches(arm, T, psi):
    if arm.n == 6:
        found = six_joint_form(arm).branches(T)
        return found.q, found.reach_excess.min(axis=1)
    geometry = srs_geometry(arm.chain)
    excess = arm_triangle(geometry, T).reach_excess
    q = np.stack([closed_form(geometry, joint_ranges(arm), T, psi, branch) for branch in BRANCHES], axis=1)
    return np.where((excess > 0.0)[:, None, None], np.nan, q), excess


@pytest.mark.slow
def test_branches_are_those_of_python_and_lead_to_the_pose(library):
    """Of 2000 poses for six joints, singular ones among them, where a branch is missing the sooner."""
    arm = library.arm
    q, T, psi = states(arm, count=2000 if arm.n == 6 else COUNT)
    singular = np.zeros(len(q), dtype=bool)
    if arm.n == 6:
        q[::7, 4], q[1::7, 2], q[2::11] = 0.0, 0.0, np.round(q[2::11] / (np.pi / 2.0)) * (np.pi / 2.0)
        singular[::7] = singular[1::7] = singular[2::11] = True
        T = np.ascontiguousarray(flange_pose(arm.chain, q))
        T[::10, :3, 3] *= 1.7
    out, excess = branches(library, T, psi)
    expected, beyond = expected_branches(arm, T, psi)
    reached = ~np.isnan(expected[..., 0])
    assert 0.05 < (beyond > 0.0).mean() < 0.5
    assert np.abs(excess - beyond).max() < CLOSE
    assert (np.isnan(out[..., 0]) == ~reached).all()
    close = CLOSE * (1.0 if arm.n == 7 else 100.0)
    assert np.abs(wrap(out - expected))[reached & ~singular[:, None]].max() < close
    assert reached.sum() > (10_000 if arm.n == 6 else 100)
    assert_at(arm, out[reached], np.broadcast_to(T[:, None], (*reached.shape, 4, 4))[reached])


@pytest.mark.slow
def test_arm_angle_and_intervals_of_every_branch(library):
    arm = library.arm
    if arm.n == 6:
        pytest.skip("a six-joint arm has no arm angle")
    _, T, psi = states(arm, 1, 24)
    out, excess = branches(library, T, psi)
    found, several = np.zeros(4), 0
    for k in np.flatnonzero(excess == 0.0):
        for b, signs in enumerate(BRANCHES):
            library.call(NAME + "_arm_angle", out[k, b].copy(), found, kind=None)
            assert abs(wrap(found[0] - psi[k])) < CLOSE
            assert (found[1:] == signs).all()
        for level in (0.0, 0.1):
            for pairs, wanted in intervals(library, T[k], level):
                assert len(pairs) == len(wanted)
                assert np.abs(pairs - wanted).max(initial=0.0) < CLOSE
                several += len(pairs)
    assert several > 100


@pytest.mark.slow
def test_aligned_joints_keep_the_pose_and_the_length_of_the_intervals(library):
    arm, step = library.arm, np.pi / 4.0
    q, _, psi = states(arm, 5, 80)
    q = np.clip(np.round(q / step) * step, arm.lower, arm.upper)
    if arm.n == 7:
        # stretched, both balls aligned at every arm angle
        geometry = srs_geometry(arm.chain)
        q[0] = 0.3, -geometry.first.offset, -0.1, geometry.straight, 0.2, -geometry.last.offset, 0.1
    T = np.ascontiguousarray(flange_pose(arm.chain, q))
    out, _ = branches(library, T, psi)
    there = ~np.isnan(out[..., 0])
    assert there.any(axis=1).all()
    expected, _ = expected_branches(arm, T, psi)
    assert np.abs(wrap(out - expected))[there].max() < 1e-7
    assert_at(arm, out[there], np.broadcast_to(T[:, None], (*there.shape, 4, 4))[there])
    for pose in T if arm.n == 7 else ():
        for pairs, wanted in intervals(library, pose, 0.0):
            # where a joint touches its limit, rounding decides about an interval of one point
            assert abs(np.diff(pairs).sum() - np.diff(wanted).sum()) < 1e-6


def test_rolls_that_turn_about_one_line_share_their_ranges(tmp_path):
    """A straight arm whose rolls have narrow and uneven ranges: the intervals of their sums, at several levels."""
    arm, several = lwr_dyn.load("lwr4plus"), 0
    rolls = {0: (-0.5, 1.1), 2: (-0.9, 0.7), 4: (-0.8, 1.0), 6: (-0.7, 0.9)}
    limits = [replace(x, lower=rolls[i][0], upper=rolls[i][1]) if i in rolls else x for i, x in enumerate(arm.limits)]
    arm = replace(arm, limits=tuple(limits))
    library = SharedLibrary(emitted_arm(arm, [NAME]), tmp_path)
    for first, last in ((0.3, -0.1), (-0.4, 0.4), (0.0, 0.8), (1.0, -0.5)):
        T = np.ascontiguousarray(flange_pose(arm.chain, np.array([first, 0.0, 0.2, 0.0, first - last, 0.0, last])))
        poses, psi = np.tile(T, (7, 1, 1)), np.linspace(-3.0, 3.0, 7)
        assert np.abs(wrap(branches(library, poses, psi)[0] - expected_branches(arm, poses, psi)[0])).max() < 1e-7
        for level in (-0.5, 0.0, 0.1):
            for pairs, wanted in intervals(library, T, level):
                assert abs(np.diff(pairs).sum() - np.diff(wanted).sum()) < 1e-6
                several += 0.0 < np.diff(wanted).sum() < 6.0
    assert several > 20


def test_the_nearest_follows_a_path_and_stops_at_the_limits(library):
    arm, out = library.arm, np.zeros(library.arm.n)
    q, _, _ = states(arm, 2, 10)
    angle, seen = np.zeros(4), set()
    for start in q:
        end = np.clip(start + 2e-3, arm.lower, arm.upper)
        T = np.ascontiguousarray(flange_pose(arm.chain, end))
        more = []
        if arm.n == 7:
            library.call(NAME + "_arm_angle", end, angle, kind=None)
            more = [float(angle[0])]
        assert library.call(NAME + "_near", T, *more, start, out, kind=ctypes.c_int) == 0
        assert np.abs(out - end).max() < 1e-9
        if arm.n == 7:
            status = library.call(NAME + "_near", T, more[0] + 1.5, start, out, kind=ctypes.c_int)
            assert np.maximum(arm.lower - out, out - arm.upper).max() < 1e-9
            assert np.abs(flange_pose(arm.chain, out) - T).max() < CLOSE
            library.call(NAME + "_arm_angle", out.copy(), angle, kind=None)
            label = "".join("+" if sign > 0.0 else "-" for sign in angle[1:])
            ends = np.array(lwr_dyn.inverse_kinematics(arm, T).arm_angle_intervals[label])
            away = np.abs(wrap(more[0] + 1.5 - ends.mean(axis=1))) - np.ptp(ends, axis=1) / 2.0
            assert abs(wrap(angle[0] - more[0] - 1.5)) == pytest.approx(max(0.0, away.min()), abs=1e-9)
            seen.add(status)
        T[:3, 3] *= 10.0
        out[:] = 9.0
        assert library.call(NAME + "_near", T, *more, start, out, kind=ctypes.c_int) == 3
        assert (out == 9.0).all()
    assert arm.n == 6 or seen == {0, 1}


def test_a_pose_that_only_branches_outside_the_limits_reach_has_none_near_and_one_out_of_reach_no_interval(library):
    arm, found = library.arm, 0
    q = np.random.default_rng(4).uniform(-3.0, 3.0, (40, arm.n))
    for start, T in zip(q, np.ascontiguousarray(flange_pose(arm.chain, q)), strict=True):
        out, more = np.full(arm.n, 9.0), [0.5] if arm.n == 7 else []
        status = lwr_dyn.inverse_kinematics(arm, T).status
        assert (library.call(NAME + "_near", T, *more, start, out, kind=ctypes.c_int) == 2) == (status != "solved")
        assert (out == 9.0).all() == (status != "solved")
        found += status == "outside limits"
    assert found > 3 or arm.name == "ur10"  # all of its joints turn more than once
    if arm.n == 7:
        T[:3, 3] *= 10.0
        pairs, counts = np.zeros((8, 16, 2)), np.ones(8, dtype=np.intc)
        assert library.call(NAME + "_intervals", T, 0.0, pairs, counts) > 1.0
        assert not counts.any()


def test_numbers_that_are_none_give_none(library):
    T, n = np.full((4, 4), np.nan), library.arm.n
    out = np.zeros((8, n))
    angle = [0.5] if n == 7 else []
    assert np.isnan(library.call(NAME, T, *angle, out))
    assert np.isnan(out).all()
    assert library.call(NAME + "_near", T, *angle, np.zeros(n), out[0], kind=ctypes.c_int) == 3


@pytest.mark.slow
@pytest.mark.parametrize("robot", ROBOTS)
def test_javascript_gives_the_same(robot, tmp_path):
    arm = lwr_dyn.load(robot)
    function = inverse_kinematics_function(None, NAME, arm)
    _, T, psi = states(arm, 3)
    arguments = [[row.ravel().tolist(), *([angle] if arm.n == 7 else [])] for row, angle in zip(T, psi, strict=True)]
    script = f"""{function.source["js"]}
const rows = {json.dumps(arguments)}.map(a => {{
  const out = new Float64Array({8 * arm.n}), excess = {NAME}(...a, out);
  return [excess, ...out].map(x => Number.isNaN(x) ? null : x);
}});
console.log(JSON.stringify(rows));
"""
    found = np.array(node(tmp_path, script), dtype=float)
    q, excess = expected_branches(arm, T, psi)
    assert np.abs(found[:, 0] - excess).max() < CLOSE
    assert (np.isnan(found[:, 1:]) == np.isnan(q.reshape(COUNT, -1))).all()
    assert np.nanmax(np.abs(wrap(found[:, 1:] - q.reshape(COUNT, -1)))) < CLOSE * (1.0 if arm.n == 7 else 100.0)


@pytest.mark.parametrize("name", ["lwr4plus", "ur10"])
def test_an_arm_without_closed_form_says_so(name):
    arm = six_joint_arm(name, 1e-4) if name == "ur10" else lwr_dyn.load(name, lock={"joint_3": 0.1})
    with pytest.raises(OptionError, match=r"no closed form.*3 and 4 parallel"):
        inverse_kinematics_function(None, NAME, arm)
