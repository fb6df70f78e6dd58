"""The solid ellipsoid of one density that has a body's mass, centre of mass and inertia.

    I_1 = m (b^2 + c^2) / 5  and so on;  with the second moments S = tr(I) / 2 E - I:  a^2 = 5 S_1 / m

a, b, c are its semi-axes along the principal axes (Landau and Lifshitz, Mechanics, section 32, problem 2). A body of
which one principal moment is larger than the sum of the other two has no such ellipsoid, as no mass can have it: its S
has a negative eigenvalue.
"""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.model.chain import ROUNDING, Body, is_physical
from lwr_dyn.model.spatial import Pose

PLATE = 1e-9
"""Of the largest second moment: one this far below 0 counts as 0, as of a plate or a rod."""


@dataclass(frozen=True, slots=True, eq=False)
class SolidEllipsoid:
    """Semi-axes (3,) [m], the longest first, along the columns of `axes` (3, 3), a rotation; mass [kg], centre [m]."""

    mass: float
    centre: Array
    semi_axes: Array
    axes: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "centre", "semi_axes", "axes")

    @property
    def moments(self) -> Array:
        """Principal moments about the centre (3,) [kg m^2], ascending."""
        squares = self.semi_axes**2
        return np.asarray(self.mass / 5.0 * (squares.sum() - squares))

    @property
    def image(self) -> Pose:
        """What the unit sphere is mapped by: the axes times their lengths, and the centre."""
        return Pose(self.axes * self.semi_axes, self.centre)


def solid_ellipsoid(mass: float, centre: Array, second_moments: Array) -> SolidEllipsoid | None:
    """The ellipsoid of a mass [kg] with second moments S (3, 3) [kg m^2] about its centre (3,) [m].

    None for what no body can be: without mass, not finite, or with an S that has a negative eigenvalue.

    >>> solid_ellipsoid(5.0, np.zeros(3), np.diag([1.0, 4.0, 9.0])).semi_axes
    array([3., 2., 1.])
    """
    if not (mass > 0.0 and np.isfinite(second_moments).all()):
        return None
    squares, axes = np.linalg.eigh(second_moments)
    if squares[0] < -PLATE * abs(squares[2]):
        return None
    axes = axes[:, ::-1]
    axes = axes * np.where(np.linalg.det(axes) < 0.0, -1.0, 1.0)  # of either sign: a rotation is taken
    return SolidEllipsoid(mass, centre, np.sqrt(5.0 / mass * np.maximum(squares[::-1], 0.0)), axes)


def inertia_ellipsoid(body: Body) -> SolidEllipsoid | None:
    """The ellipsoid of a body in the axes of its frame; None for a body without one, which `no_ellipsoid` explains.

    >>> inertia_ellipsoid(Body(5.0, np.zeros(3), np.diag([13.0, 10.0, 5.0]))).semi_axes
    array([3., 2., 1.])
    """
    if no_ellipsoid(body):
        return None
    second = 0.5 * np.trace(body.inertia_com) * np.eye(3) - body.inertia_com
    return solid_ellipsoid(body.mass, body.com, second)


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
