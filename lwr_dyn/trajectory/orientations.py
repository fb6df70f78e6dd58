"""Orientations along a path: constant, or turning about one axis in proportion to the length travelled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, fixed_array, freeze_arrays
from lwr_dyn.errors import OptionError
from lwr_dyn.model.spatial import skew
from lwr_dyn.trajectory.motion_profile import positive_number

ORTHONORMAL = 1e-6
"""How far R R^T may be from the identity: what six printed digits leave."""


@dataclass(frozen=True, slots=True, eq=False)
class Rotation:
    """Orientation at k lengths s: R (k, 3, 3), rate (k, 3) [rad/m] and its derivative (k, 3) [rad/m^2], base axes."""

    R: Array
    rate: Array
    d_rate: Array


class Orientation(Protocol):
    """A rotation as a function of the length on a path."""

    def at(self, s: Array) -> Rotation:
        """At lengths s (k,) [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class ConstantOrientation:
    """The same orientation all along: `R` (3, 3)."""

    R: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "R")

    def at(self, s: Array) -> Rotation:
        """At lengths s (k,) [m]."""
        still = np.zeros((len(s), 3))
        return Rotation(np.broadcast_to(self.R, (len(s), 3, 3)), still, still)


@dataclass(frozen=True, slots=True, eq=False)
class Slerp:
    """A turn about one axis: R(s) = exp(rate s [axis]) R, `axis` (3,) a unit vector in the base, `rate` [rad/m]."""

    R: Array
    axis: Array
    rate: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "R", "axis")

    def at(self, s: Array) -> Rotation:
        """At lengths s (k,) [m]."""
        angle = (self.rate * s)[:, None, None]
        K = skew(self.axis)
        R = (np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * (K @ K)) @ self.R
        rate = np.broadcast_to(self.rate * self.axis, (len(s), 3))
        return Rotation(R, rate, np.zeros((len(s), 3)))


def constant(R: ArrayLike) -> ConstantOrientation:
    """One orientation R (3, 3) for the whole path; raises `ShapeError`, or `OptionError` when R is no rotation."""
    return ConstantOrientation(rotation("R", R))


def slerp(R_start: ArrayLike, R_end: ArrayLike, length: float) -> Slerp:
    """The shortest turn from one orientation to another over a path of `length` [m].

    Raises
    ------
    ShapeError
        Not (3, 3) matrices.
    OptionError
        Not rotations, length not positive, or half a turn (no shortest way).

    References
    ----------
    Siciliano et al., Robotics, sec. 4.3, orientation by angle and axis.

    >>> from lwr_dyn.model.spatial import rot_z
    >>> slerp(np.eye(3), rot_z(1.0), 2.0).rate
    0.5
    """
    start, end = rotation("R_start", R_start), rotation("R_end", R_end)
    length = positive_number("length", length)
    D = end @ start.T
    twice_sin = np.array([D[2, 1] - D[1, 2], D[0, 2] - D[2, 0], D[1, 0] - D[0, 1]])
    sine = float(np.linalg.norm(twice_sin))
    angle = math.atan2(sine, float(np.trace(D)) - 1.0)
    if angle > math.pi - 1e-6:
        raise OptionError("R_end", "half a turn from R_start", "less than 180 deg; put an orientation in between")
    axis = twice_sin / sine if sine > 0.0 else np.array([0.0, 0.0, 1.0])
    return Slerp(start, axis, angle / length)


def rotation(name: str, value: ArrayLike) -> Array:
    """A rotation matrix (3, 3); raises `ShapeError`, or `OptionError` when it is not orthonormal and right-handed."""
    R = fixed_array(name, value, (3, 3))
    error = float(np.max(np.abs(R @ R.T - np.eye(3))))
    if error > ORTHONORMAL or np.linalg.det(R) < 0.0:
        kind = "left-handed" if error <= ORTHONORMAL else f"R R^T differs from 1 by {error:.2g}"
        raise OptionError(name, kind, "a rotation matrix")
    return R
