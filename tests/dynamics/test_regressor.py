"""The regressor times the parameters is the recursion's torque."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.dynamics.regressor import Regressor, chain_parameters
from tests.random_arms import random_arm
from tests.tolerances import RANDOM_ARM


@given(st.integers(0, 10**6))
def test_the_regressor_times_the_parameters_is_the_recursion(seed):
    arm = random_arm(seed)
    q, dq, ddq = np.random.default_rng(seed).uniform(-2, 2, (3, 4, arm.n))
    expected = lwr_dyn.dynamics_of(arm, "newton-euler").inverse_dynamics(q, dq, ddq)
    friction_free = Regressor(arm.chain)(q, dq, ddq) @ chain_parameters(arm.chain)
    assert np.abs(friction_free - expected).max() <= RANDOM_ARM * max(1.0, np.abs(expected).max())
