"""The Slotine-Li regressor: by polarisation, by a recursion with both velocities, and against B, C and g of road B."""

import numpy as np
import pinocchio
import pytest

import lwr_dyn
from lwr_dyn.control.laws.adaptive import SlotineLiRegressor
from lwr_dyn.model.arm import arm_with_payload
from tests.control.laws.mixed_recursion import mixed_regressor
from tests.random_arms import random_arm
from tests.slips import uncaught

EXACT = 1e-12
"""Of the largest torque: rounding."""
ARMS = {
    "lwr4plus": lwr_dyn.load("lwr4plus", reading="physical"),
    "wam7": lwr_dyn.load("wam7"),
    "on the wall": lwr_dyn.load("lwr4plus", mount={"on": "wall"}),
    "loaded": arm_with_payload(lwr_dyn.load("lwr4plus"), 3.0, [0.02, -0.05, 0.1], np.diag([0.1, 0.2, 0.25])),
}
RNG = np.random.default_rng(8)
STATES = RNG.uniform(-2.0, 2.0, (20, 4, 7))


def check_against_b_c_and_g(module):
    for arm in ARMS.values():
        regressor, road_b = module.SlotineLiRegressor(arm), lwr_dyn.dynamics_of(arm, "newton-euler")
        for q, u, w, a in STATES:
            expected = road_b.mass_matrix(q) @ a + road_b.coriolis_matrix(q, u) @ w + road_b.gravity_vector(q)
            by_columns = regressor(q, u, w, a) @ regressor.parameters + regressor.armature * a
            size = EXACT * np.abs(expected).max()
            np.testing.assert_allclose(by_columns, expected, rtol=0, atol=size)
            np.testing.assert_allclose(regressor.torque(q, u, w, a), expected, rtol=0, atol=size)


SLIPS = [
    ("half = 0.5 * (dq + dq_r)\n        tau:", "half = dq_r\n        tau:"),
    ("gravity=np.zeros(3)", "gravity=arm.chain.gravity"),
    ("half - dq_r, self._still", "half - dq_r, ddq_r"),
    ("np.array(arm.armature)", "np.zeros(arm.n)"),
    ("- self._torque_0(q, half - dq_r)", ""),
    ("self._columns(q, half, ddq_r)", "self._columns(q, half, self._still)"),
]


@pytest.mark.slow
def test_it_is_b_c_and_g_and_slips_are_caught():
    assert not uncaught("lwr_dyn.control.laws.adaptive", SLIPS, check_against_b_c_and_g)


@pytest.mark.parametrize("name", ARMS)
def test_every_column_is_that_of_the_mixed_recursion(name):
    arm = ARMS[name]
    regressor = SlotineLiRegressor(arm)
    model = lwr_dyn.dynamics_of(arm).ungated.model
    data, turns = model.createData(), [True] * arm.n
    for q, u, w, a in STATES[:8]:
        pinocchio.forwardKinematics(model, data, q)
        frames = np.array([pose.homogeneous for pose in list(data.oMi)[1:]])
        expected = mixed_regressor(frames, turns, arm.chain.gravity, u, w, a)
        np.testing.assert_allclose(regressor(q, u, w, a), expected, rtol=0, atol=EXACT * np.abs(expected).max())


def test_one_joint_has_one_row():
    """Pinocchio gives the regressor of one joint without its axis of joints."""
    arm = random_arm(0, "R")
    regressor = SlotineLiRegressor(arm)
    state = RNG.uniform(-2.0, 2.0, (4, 1))
    Y = regressor(*state)
    assert Y.shape == (1, 10)
    np.testing.assert_allclose(
        Y @ regressor.parameters + regressor.armature * state[3], regressor.torque(*state), rtol=EXACT
    )
