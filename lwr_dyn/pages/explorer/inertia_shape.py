"""The solid ellipsoid of one density that has a body's mass, centre of mass and inertia.

    I_1 = m (b^2 + c^2) / 5  and so on, so  a^2 = 5 (I_2 + I_3 - I_1) / (2 m)

a, b, c are its semi-axes along the principal axes (Landau and Lifshitz, Mechanics, section 32, problem 2). A body of
which one principal moment is larger than the sum of the other two has no such ellipsoid, as no mass can have it.
"""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.model.chain import Body
from lwr_dyn.model.feasibility import ROUNDING, is_physical


@dataclass(frozen=True, slots=True, eq=False)
class InertiaEllipsoid:
    """Semi-axes (3,) [m] along the columns of `axes` (3, 3), a rotation; `moments` (3,) [kg m^2], ascending."""

    semi_axes: Array
    axes: Array
    moments: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "semi_axes", "axes", "moments")


def inertia_ellipsoid(body: Body) -> InertiaEllipsoid | None:
    """The ellipsoid of a body in the axes of its frame; None for a body without one, which `no_ellipsoid` explains.

    >>> inertia_ellipsoid(Body(5.0, np.zeros(3), np.diag([13.0, 10.0, 5.0]))).semi_axes
    array([3., 2., 1.])
    """
    if no_ellipsoid(body):
        return None
    moments, axes = np.linalg.eigh(body.inertia_com)
    axes = axes * np.where(np.linalg.det(axes) < 0.0, -1.0, 1.0)  # of either sign: a rotation is taken
    squares = 2.5 / body.mass * (moments.sum() - 2.0 * moments)
    return InertiaEllipsoid(np.sqrt(np.maximum(squares, 0.0)), axes, moments)


def no_ellipsoid(body: Body | None) -> str:
    """Why a body has no ellipsoid, in words; empty if it has one."""
    if body is None:
        return "no mass and inertia given"
    if body.unknown:
        return "a part of mass and inertia is unknown"
    if not is_physical(body):
        return "no mass can have this inertia"
    if body.mass == 0.0:
        return "no mass"
    return "a point" if np.abs(body.inertia_com).max() <= ROUNDING * body.mass else ""
