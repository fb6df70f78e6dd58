"""The arm whose load is looked for."""

import numpy as np
import pytest

from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.payload.loaded import ARM
from tests.identification.plants import perturbed_plant


@pytest.fixture(scope="module")
def known():
    """The arm as its table says, with friction that nothing knows."""
    return perturbed_plant(TorqueColumns(ARM.chain), ARM, np.random.default_rng(1), 0.0)
