import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.kinematics.forward import jacobian, jacobian_at, joint_axes, velocity_product_at
from lwr_dyn.model.chain import link_frames
from tests.random_arms import arms, random_arm

STEP = 1e-30
"""A complex step has no cancellation: it is exact to rounding."""
ROUNDING = 1e-12
"""Relative, products of up to seven frames."""


def flange(chain, q):
    *_, pose = link_frames(chain, q)
    return pose


@given(arms, st.integers(0, 1000))
def test_columns_are_the_derivative_of_the_pose(arm, seed):
    q = np.random.default_rng(seed).uniform(-2, 2, (3, arm.n))
    J, T = jacobian(arm.chain, q), flange(arm.chain, q)
    for i in range(arm.n):
        dT = flange(arm.chain, q + 1j * STEP * np.eye(arm.n)[i]).imag / STEP
        spin = dT[:, :3, :3] @ np.swapaxes(T[:, :3, :3], 1, 2)
        assert np.allclose(J[:, :3, i], dT[:, :3, 3], rtol=0, atol=ROUNDING * 10)
        assert np.allclose(J[:, 3:, i], np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], 1), atol=ROUNDING)


@given(arms, st.integers(0, 1000))
def test_velocity_product_is_the_rate_of_the_jacobian_times_dq(arm, seed):
    rng = np.random.default_rng(seed)
    q, dq = rng.uniform(-2, 2, (4, arm.n)), rng.uniform(-2, 2, (4, arm.n))
    axes = joint_axes(arm.chain, q + 1j * STEP * dq)
    rate = jacobian_at(axes, axes.flange[:, :3, 3]).imag / STEP
    expected, axes = np.einsum("kij,kj->ki", rate, dq), joint_axes(arm.chain, q)
    product = velocity_product_at(axes, axes.flange[:, :3, 3], dq)
    assert np.allclose(product, expected, rtol=0, atol=ROUNDING * 100)


def test_batches_broadcast_wrong_shapes_are_named_and_a_sliding_joint_turns_nothing():
    chain = lwr_dyn.load("lwr4plus").chain
    assert jacobian(chain, np.zeros((2, 5, 7))).shape == (2, 5, 6, 7)
    with pytest.raises(ShapeError, match="q: 6 numbers; allowed: 7 numbers"):
        jacobian(chain, np.zeros(6))
    arm = random_arm(3, "RPRP")
    J = jacobian(arm.chain, [0.1, 0.2, 0.3, 0.4])
    assert (J[3:, [1, 3]] == 0).all()
    assert np.linalg.norm(J[:3, [1, 3]], axis=0) == pytest.approx(1.0)
