"""Ellipsoids of links: those of known bodies, and none where no body can be."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.identification.report.charts import central_moments, link_ellipsoid
from lwr_dyn.model.chain import Body
from lwr_dyn.model.spatial import from_rpy

SIZES = st.tuples(*[st.floats(0.01, 0.5)] * 3)
PLACES = st.tuples(*[st.floats(-0.5, 0.5)] * 3)


def solid(mass, sizes, rpy, com):
    """A solid ellipsoid as a body: I_1 = m (b^2 + c^2) / 5 about its own axes."""
    squares, R = np.square(sizes), from_rpy(rpy)
    return Body(mass, np.array(com), R @ np.diag(mass / 5.0 * (squares.sum() - squares)) @ R.T)


@given(st.floats(0.1, 20.0), SIZES, PLACES, PLACES)
def test_an_ellipsoid_comes_back(mass, sizes, rpy, com):
    parameters = body_parameters(solid(mass, sizes, rpy, com))
    found = link_ellipsoid(parameters)
    np.testing.assert_allclose(found.semi_axes, np.sort(sizes)[::-1], rtol=1e-6, atol=1e-9)
    assert np.linalg.det(found.axes) == pytest.approx(1.0)
    matrix = found.image.matrix()
    np.testing.assert_allclose(matrix[:3, 3], com, atol=1e-12)
    R = from_rpy(rpy)
    shape, wanted = matrix[:3, :3] @ matrix[:3, :3].T, R @ np.diag(np.square(sizes)) @ R.T
    np.testing.assert_allclose(shape, wanted, atol=1e-9)


def test_the_moments_agree_with_the_tensor():
    parameters = body_parameters(solid(3.0, (0.1, 0.2, 0.3), (0.3, -0.2, 1.0), (0.1, 0.0, -0.2)))
    mass, com, moments = central_moments(parameters)
    tensor = solid(3.0, (0.1, 0.2, 0.3), (0.3, -0.2, 1.0), (0.1, 0.0, -0.2)).inertia_com
    np.testing.assert_allclose(np.trace(moments) * np.eye(3) - moments, tensor, atol=1e-15)
    assert mass == 3.0
    np.testing.assert_allclose(com, (0.1, 0.0, -0.2), atol=1e-15)


@pytest.mark.parametrize(
    "changed", [{0: -1.0}, {0: 0.0}, {4: 1.0}, {9: np.nan}], ids=["mass below 0", "no mass", "triangle", "nan"]
)
def test_what_no_body_can_be_has_none(changed):
    parameters = body_parameters(solid(3.0, (0.1, 0.2, 0.3), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    assert link_ellipsoid(parameters) is not None
    for place, value in changed.items():
        parameters[place] = value
    assert link_ellipsoid(parameters) is None


def test_a_plate_is_a_body():
    assert link_ellipsoid(np.array([2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 2.0])).semi_axes[2] == 0.0
