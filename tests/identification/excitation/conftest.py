"""A random motion of the WAM that fills its limits."""

import numpy as np
import pytest

from lwr_dyn.identification.excitation.motion_limits import MotionLimits
from lwr_dyn.identification.excitation.objectives import fourier_basis


@pytest.fixture
def motion(wam):
    basis = fourier_basis(8.0, 5, 60)
    X = np.random.default_rng(5).normal(size=(basis.count, wam.n))
    return basis, MotionLimits.of(wam).fitted(X, basis, fill=True)
