"""A log of the LWR 4+, of an arm near its table."""

import numpy as np
import pytest

from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.plants import perturbed_plant, random_motion, simulated_log


@pytest.fixture(scope="module")
def plant(lwr):
    return perturbed_plant(TorqueColumns(lwr.chain), lwr, np.random.default_rng(4))


@pytest.fixture(scope="module")
def motion(lwr):
    return random_motion(lwr, 10.0, np.random.default_rng(5))


@pytest.fixture(scope="module")
def log(plant, motion):
    return simulated_log(plant, motion, 0.1, np.random.default_rng(6), encoder=1e-5)
