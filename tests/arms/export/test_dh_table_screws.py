"""A pose is the product of its three parts, near every special case; the parts are the ones that a table wants."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.arms.export.dh_table import FAR, Normal, Screw, decomposed
from lwr_dyn.model.spatial import Pose, from_rpy
from tests.random_arms import random_pose

WHOLE = 2e-14
"""[m and entries of R] 100 m along an axis round at 1.4e-14 m."""


def product(parts):
    left, normal, right = parts
    return left.pose() @ normal.pose() @ right.pose()


def close(a, b):
    return np.abs(a.matrix() - b.matrix()).max() <= WHOLE


@pytest.mark.hypothesis
@given(
    st.integers(0, 10**6),
    st.floats(-3.0, 3.0),
    st.floats(-1.0, 1.0),
    st.booleans(),
)
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


def test_between_parallel_axes_the_row_has_no_d():
    left, normal, right = decomposed(Pose(np.eye(3), np.array([0.3, 0.4, 0.5])), Screw(0.0, 0.2))
    assert left.d == -0.2
    assert right.d == pytest.approx(0.7, abs=1e-15)
    assert (normal.a, normal.alpha) == (0.5, 0.0)


def test_the_end_of_a_chain_is_kept_in_the_row():
    left, normal, right = decomposed(Pose(from_rpy((0, 0, 0.3)), np.array([0.0, 0.0, 0.5])), keep_left=True)
    assert (left, normal) == (Screw(0.3, 0.5), Normal())
    assert abs(right.theta) < 1e-15


def test_the_normal_points_where_theta_is_small():
    pose = Pose(from_rpy((math.pi / 2, 0, 0)), np.array([-0.1, 0.0, 0.0]))
    left, normal, _ = decomposed(pose)
    assert (left.theta, normal.a) == (0.0, -0.1)
    left, normal, _ = decomposed(pose, Screw(math.pi))
    assert (abs(left.theta), normal.a) == (math.pi, 0.1)
