"""The ellipsoid of a body: its own inertia, computed from its axes, is the body's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.model.chain import Body
from lwr_dyn.model.ellipsoid import inertia_ellipsoid, no_ellipsoid, solid_ellipsoid
from tests.pages.explorer.explored import NAMES, explored_arm
from tests.random_arms import random_body
from tests.tolerances import EXACT


def test_a_thin_rod_is_as_long_as_it_must_be_and_a_plate_may_be_round_to_a_billionth():
    shape = inertia_ellipsoid(Body(3.0, np.ones(3), np.diag([0.0, 0.6, 0.6])))
    np.testing.assert_allclose(shape.semi_axes, [1.0, 0.0, 0.0], atol=1e-15)
    assert shape.centre.tolist() == [1.0] * 3
    np.testing.assert_allclose(shape.image.matrix()[:3], [[*row, 1.0] for row in shape.axes * shape.semi_axes])
    for second, is_one in ((-0.9e-9, True), (-1.1e-9, False), (np.nan, False)):
        for size in (1.0, 0.2, 5.0):
            assert (solid_ellipsoid(1.0, np.zeros(3), size * np.diag([second, 0.5, 1.0])) is not None) == is_one
    assert solid_ellipsoid(0.0, np.zeros(3), np.eye(3)) is None


def assert_same_inertia(shape, body):
    """That of a solid ellipsoid, m/5 (b^2 + c^2) ... about its axes, in the body's axes."""
    squares = shape.semi_axes**2
    solid = shape.axes @ np.diag(body.mass / 5.0 * (squares.sum() - squares)) @ shape.axes.T
    np.testing.assert_allclose(solid, body.inertia_com, rtol=0, atol=EXACT * np.abs(body.inertia_com).max())


@given(st.integers(0, 10**6))
def test_the_ellipsoid_has_the_bodys_inertia(seed):
    body = random_body(np.random.default_rng(seed))
    shape = inertia_ellipsoid(body)
    assert_same_inertia(shape, body)
    assert np.linalg.det(shape.axes) == pytest.approx(1.0)
    assert (np.diff(shape.moments) >= 0.0).all()
    assert (np.diff(shape.semi_axes) <= 0.0).all()  # the least moment is about the longest axis


@pytest.mark.parametrize("name", NAMES)
def test_ellipsoids_of_arms_lie_along_the_eigenvectors(name):
    for body in explored_arm(name).bodies():
        shape = None if body is None else inertia_ellipsoid(body)
        if shape is None:
            assert no_ellipsoid(body) != ""
            continue
        turned = body.inertia_com @ shape.axes - shape.axes * shape.moments
        np.testing.assert_allclose(turned, 0.0, rtol=0, atol=EXACT * np.abs(body.inertia_com).max())
        assert_same_inertia(shape, body)


@pytest.mark.parametrize(
    ("body", "why"),
    [
        (None, "no mass and inertia given"),
        (Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 2.1])), "no mass can have this inertia"),
        (Body(0.0, np.zeros(3), np.zeros((3, 3))), "no mass"),
        (Body(2.0, np.ones(3), np.diag([1e-13, 1e-13, 2e-13]) * 10.0), "a point"),
        (Body(2.0, np.ones(3), np.diag([1e-13, 1e-13, 2e-13]) * 10.1), ""),
        (Body(0.0, np.zeros(3), np.zeros((3, 3)), (0, 1)), "a part of mass and inertia is unknown"),
    ],
)
def test_a_body_without_an_ellipsoid_says_why(body, why):
    assert no_ellipsoid(body) == why
    assert body is None or (inertia_ellipsoid(body) is None) == bool(why)
