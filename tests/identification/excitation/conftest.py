"""A random motion of the WAM that fills its limits; an arm with two links that are never far apart."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.identification.excitation.motion_limits import MotionLimits
from lwr_dyn.identification.excitation.objectives import fourier_basis
from tests.public_arms import BODY, urdf_of


@pytest.fixture
def motion(wam):
    basis = fourier_basis(8.0, 5, 60)
    X = np.random.default_rng(5).normal(size=(basis.count, wam.n))
    return basis, MotionLimits.of(wam).fitted(X, basis, fill=True)


@pytest.fixture(scope="session")
def iiwa(tmp_path_factory):
    """The joints of the iiwa 14, with bodies: its links 3 and 5 are never more than 54 mm apart."""
    file = tmp_path_factory.mktemp("iiwa") / "iiwa14.urdf"
    file.write_text(urdf_of("iiwa14", BODY).replace('effort="1"', 'effort="200"'))
    return lwr_dyn.load(file)
