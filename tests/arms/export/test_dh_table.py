"""The table of an arm moves as the arm and needs the same torque, in both conventions; known tables come out."""

import math
from dataclasses import astuple, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.arms.export.dh_table import FAR, Normal, Screw, _cleaned, _is_screw, decomposed, dh_table, residual
from lwr_dyn.arms.papers.assembly import dh_rows
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from lwr_dyn.model.chain import Convention, JointKind
from lwr_dyn.model.spatial import Pose, from_rpy, rot_x
from tests.agreement.test_foreign_arms import ROBOTS
from tests.random_arms import arms, random_pose
from tests.tolerances import METRES, RANDOM_ARM

PANDA = {"tip": "panda_link8", "lock": {"panda_finger_joint1": 0.0}}


@pytest.mark.hypothesis
@given(arms)
def test_any_arm_moves_as_its_table(arm):
    rng = np.random.default_rng(3)
    q, dq, ddq = rng.uniform(-3, 3, (3, 5, arm.n))
    for convention in Convention:
        table = dh_table(arm, convention)
        left = residual(table, arm, states=5)
        assert left.metres <= METRES
        assert left.radians <= METRES
        theirs = newton_euler_dynamics(table.chain(arm)).inverse_dynamics(q, dq, ddq)
        ours = newton_euler_dynamics(arm.chain).inverse_dynamics(q, dq, ddq)
        assert np.abs(theirs - ours).max() <= RANDOM_ARM * np.abs(ours).max()


def test_a_residual_is_seen():
    arm = lwr_dyn.load("lwr4plus")
    table = dh_table(arm, Convention.STANDARD)
    rows = (replace(table.rows[0], a=1e-3), *table.rows[1:])
    assert residual(replace(table, rows=rows), arm).metres == pytest.approx(1e-3, rel=0.01)
    rows = (*table.rows[:6], replace(table.rows[6], theta_offset=1e-3))
    assert residual(replace(table, rows=rows), arm).radians == pytest.approx(1e-3, rel=1e-6)


@pytest.mark.parametrize("robot", ["lwr4plus", "lwr4", "wam7"])
def test_a_standard_table_comes_back(robot):
    table = dh_table(lwr_dyn.load(robot), Convention.STANDARD)
    for row, printed in zip(table.rows, dh_rows(open_paper(robot)), strict=True):
        assert astuple(row) == pytest.approx(astuple(printed), abs=1e-15)
    assert table.base.is_identity()
    assert table.flange.is_identity()


def test_the_panda_has_its_makers_table_and_the_ur10_no_d_between_parallel_axes():
    """Franka Emika, FCI documentation, Denavit-Hartenberg parameters (Craig's convention)."""
    rows = dh_table(lwr_dyn.load(ROBOTS / "panda_description/urdf/panda.urdf", **PANDA), Convention.MODIFIED).rows
    quarter = math.pi / 2
    assert [row.a for row in rows] == pytest.approx([0, 0, 0, 0.0825, -0.0825, 0, 0.088], abs=1e-12)
    assert [row.d for row in rows] == pytest.approx([0.333, 0, 0.316, 0, 0.384, 0, 0.107], abs=1e-12)
    assert [row.alpha for row in rows] == pytest.approx([0, -quarter, quarter, quarter, -quarter, quarter, quarter])
    assert [row.theta_offset for row in rows] == pytest.approx([0] * 7, abs=1e-12)
    arm = lwr_dyn.load(ROBOTS / "ur_description/urdf/ur10_robot.urdf", tip="tool0")
    rows = dh_table(arm, Convention.STANDARD).rows
    assert [row.d for row in rows] == pytest.approx([0.1273, 0, 0, 0.163941, 0.1157, 0.0922], abs=1e-9)
    assert [row.a for row in rows] == pytest.approx([0, 0.612, 0.5723, 0, 0, 0], abs=1e-9)


def changed(index, **changes):
    """The LWR with another link."""
    arm = lwr_dyn.load("lwr4plus")
    links = list(arm.chain.links)
    links[index] = replace(links[index], **changes)
    return replace(arm, chain=replace(arm.chain, links=tuple(links)))


@pytest.mark.parametrize("convention", Convention)
def test_almost_parallel_axes_take_beta(convention):
    bent = Pose(from_rpy((math.pi - 2.65e-6, 0.0, 0.0)), np.array([0.1, 0.41, 0.1]))
    arm = changed(2, after=bent)
    table = dh_table(arm, convention)
    assert sum(row.beta != 0.0 for row in table.rows) == 1
    assert max(abs(row.d) for row in table.rows) < 1.0
    assert residual(table, arm).metres <= METRES
    assert 1e-8 < residual(table.without_beta(), arm).metres < 1e-5


def test_a_sliding_joint_reads_zero_where_it_did():
    slider = changed(0, kind=JointKind.PRISMATIC)
    for convention in Convention:
        table = dh_table(slider, convention)
        assert table.kinds[0] is JointKind.PRISMATIC
        assert residual(table, slider).metres <= METRES


WHOLE = 2e-14
"""[m and entries of R] 100 m along an axis round at 1.4e-14 m."""


def product(parts):
    left, normal, right = parts
    return left.pose() @ normal.pose() @ right.pose()


def close(a, b):
    return np.abs(a.matrix() - b.matrix()).max() <= WHOLE


@pytest.mark.hypothesis
@given(st.integers(0, 10**6), st.floats(-3.0, 3.0), st.floats(-1.0, 1.0), st.booleans())
def test_the_parts_multiply_to_the_pose(seed, theta, d, keep_left):
    pose = random_pose(np.random.default_rng(seed))
    assert close(product(decomposed(pose, Screw(theta, d), keep_left)), pose)


@pytest.mark.parametrize("tilt", [0.0, 1e-16, 1e-13, 3.7e-6, 1e-4, 0.02, 0.5])
@pytest.mark.parametrize("turn", [0.0, math.pi])
@pytest.mark.parametrize("apart", [0.0, 1e-12, 0.41])
def test_almost_parallel_axes_lose_nothing(tilt, turn, apart):
    pose = Pose(from_rpy((turn + tilt, 0.4 * tilt, 0.3)), np.array([apart, 0.2 * apart, 0.25]))
    left, normal, right = decomposed(pose, Screw(0.2, 0.1))
    assert close(product((left, normal, right)), pose)
    assert max(abs(left.d), abs(right.d)) < FAR + 1.0
    assert (normal.beta != 0.0) == (apart == 0.41 and tilt in (1e-13, 3.7e-6, 1e-4))


def test_rows_of_parallel_axes_of_the_end_of_a_chain_and_with_a_normal_where_theta_is_small():
    left, normal, right = decomposed(Pose(np.eye(3), np.array([0.3, 0.4, 0.5])), Screw(0.0, 0.2))
    assert (left.d, right.d, normal.a, normal.alpha) == (-0.2, pytest.approx(0.7, abs=1e-15), 0.5, 0.0)
    left, normal, right = decomposed(Pose(from_rpy((0, 0, 0.3)), np.array([0.0, 0.0, 0.5])), keep_left=True)
    assert (left, normal) == (Screw(0.3, 0.5), Normal())
    assert abs(right.theta) < 1e-15
    left, normal, right = decomposed(Pose(from_rpy((0, 0, 0.3)), np.array([0.0, 0.0, 0.5])))
    assert (left, normal, right) == (Screw(), Normal(), Screw(pytest.approx(0.3, abs=1e-15), 0.5))
    pose = Pose(from_rpy((math.pi / 2, 0, 0)), np.array([-0.1, 0.0, 0.0]))
    for screw, wanted in ((Screw(), (0.0, -0.1)), (Screw(math.pi), (math.pi, 0.1))):
        left, normal, _ = decomposed(pose, screw)
        assert (abs(left.theta), normal.a) == wanted


def test_what_counts_as_parallel_as_one_line_and_as_far():
    """Each bound of the module from both sides; z' stands for the second axis."""
    leaning = from_rpy((0.5, 0.2, 0.0))
    for off, whole in ((0.9e-14, False), (1.1e-14, True)):
        tilted, shifted = Pose(from_rpy((off, 0.0, 0.3)), np.array([0.0, 0.41, 0.0])), np.array([off, 0.0, 0.0])
        assert (decomposed(tilted)[1].beta != 0.0) == whole
        line = from_rpy((1e-5, 0.0, 0.0))
        for pose in (
            Pose(rot_x(math.pi / 2), shifted),
            Pose(np.eye(3), shifted),
            Pose(line, shifted + 150 * line[:, 2]),
        ):
            assert abs(decomposed(pose)[1].a) == (off if whole else 0.0)
        assert _cleaned(Pose(np.eye(3), shifted)).is_identity() != whole
        assert _is_screw(Pose(np.eye(3), shifted)) != whole
        assert _is_screw(Pose(rot_x(off), np.zeros(3))) != whole
    assert not _is_screw(Pose(rot_x(math.pi), np.zeros(3)))
    for along in (99.9, 100.1, -99.9, -100.1):
        for place in (along * leaning[:, 2], np.array([0.0, 0.0, along])):
            assert (decomposed(Pose(leaning, place))[1].beta != 0.0) == (abs(along) > 100.0)
    for past, theta in ((0.9e-9, 0.0), (1.1e-9, math.pi)):  # a right angle up to rounding keeps the direction
        assert abs(decomposed(Pose(rot_x(math.pi / 2), np.zeros(3)), Screw(math.pi / 2 + past))[0].theta) == theta
