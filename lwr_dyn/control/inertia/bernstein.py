"""B_ii as control values on boxes of the joints: a convex combination of them gives the function, so they bound it.

Along a turning joint B_ii is a trigonometric polynomial of degree 2. On an interval of half-width w, with
S = sin((w - t)/2) / sin w and R = sin((w + t)/2) / sin w for t from -w to w, it is homogeneous of degree 4:

    f = sum_k C(4, k) f_k S^(4-k) R^k,    1 = (S^2 + 2 S R cos w + R^2)^2

The control values f_k / c_k, c = (1, cos w, (1 + 2 cos^2 w)/3, cos w, 1), multiply non-negative weights whose sum is 1
as long as w is below 90 deg. Along a sliding joint B_ii is a parabola: ordinary Bernstein polynomials of degree 2.

References
----------
Pena, "Shape preserving representations for trigonometric curves", CAGD 14 (1997); Garloff, "The Bernstein algorithm",
Interval Computations 2 (1993), for bounds by boxes.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import comb
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.control.inertia.worst_case import JointInertia
from lwr_dyn.dynamics.recursion import inverse_dynamics
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.spatial import ZERO

Precise = NDArray[np.floating[Any]]
"""Of extended precision where the machine has it."""

WAVES, PARABOLA = 5, 3
"""Control values along a joint that turns, and along one that slides."""

_INNER = np.array([1.0, 2.0, 1.0])


def nodes(is_turning: bool, lower: float, upper: float) -> Precise:
    """Joint positions [rad or m] whose values determine B_ii along a joint: 5 around the turn, or 3 over the range."""
    if is_turning:
        pi = 4 * np.arctan(np.longdouble(1))  # to extended precision
        return np.asarray(2 * pi * np.arange(WAVES) / WAVES, dtype=np.longdouble)
    low, up = np.longdouble(lower), np.longdouble(upper)
    return np.array([low, (low + up) / 2, up])


def control_matrix(is_turning: bool, lower: float, upper: float) -> Precise:
    """Values at the `nodes` -> control values on the interval; for a sliding joint that is its whole range."""
    if not is_turning:
        return np.array([[1, 0, 0], [-0.5, 2, -0.5], [0, 0, 1]], dtype=np.longdouble)
    low, up = np.longdouble(lower), np.longdouble(upper)
    middle, w = (low + up) / 2, (up - low) / 2
    one = np.array([np.longdouble(1), np.cos(w), np.longdouble(1)])
    cosine, sine = (wave(np.array([low, middle, up])) for wave in (np.cos, np.sin))
    waves = (
        _product(one, one), _product(cosine, one), _product(sine, one),
        _product(cosine, cosine) - _product(sine, sine), 2 * _product(sine, cosine),
    )  # fmt: skip
    return np.stack(waves, axis=-1) @ harmonics() / _weights(w)[:, None]


def halves(is_turning: bool, w: float) -> tuple[Precise, Precise]:
    """Control values on an interval of half-width w -> those on its left and its right half.

    Every entry is at least 0 and every row has the sum 1, so that halving never widens the bounds.

    >>> left, right = halves(True, 0.5)
    >>> bool((left >= 0).all()), bool(abs(right.sum(axis=1) - 1).max() < 1e-15)
    (True, True)
    """
    half = np.longdouble(w) / 2
    share = 1 / (2 * np.cos(half)) if is_turning else np.longdouble(0.5)
    degree = WAVES - 1 if is_turning else PARABOLA - 1
    left = np.array([[share**m * comb(m, k) for k in range(degree + 1)] for m in range(degree + 1)])
    if is_turning:
        left = left * _weights(2 * half) / _weights(half)[:, None]
    return left, left[::-1, ::-1]


def harmonics() -> Precise:
    """Values at the nodes -> amplitudes of 1, cos, sin, cos 2, sin 2: the discrete Fourier transform of 5 values."""
    x = nodes(True, 0.0, 0.0)
    rows = np.array([np.ones(WAVES), 2 * np.cos(x), 2 * np.sin(x), 2 * np.cos(2 * x), 2 * np.sin(2 * x)])
    return np.asarray(rows, dtype=np.longdouble) / WAVES


def _product(p: Precise, q: Precise) -> Precise:
    """Coefficients of degree 4 of the product of two forms of degree 2, binomials taken off."""
    full = np.zeros(WAVES, dtype=np.longdouble)
    for i, j in np.ndindex(3, 3):
        full[i + j] += _INNER[i] * p[i] * _INNER[j] * q[j]
    return np.asarray(full / np.array([comb(WAVES - 1, k) for k in range(WAVES)]), dtype=np.longdouble)


def _weights(w: Any) -> Precise:
    """The coefficients c of 1."""
    one = np.array([np.longdouble(1), np.cos(w), np.longdouble(1)])
    return _product(one, one)


MOST_VALUES = WAVES**7
"""Size of the largest table that is made."""

WIDEST = np.radians(100.0)
"""First boxes are no wider than this along a turning joint; below 180 deg all weights are positive."""

TURN = 2.0 * np.pi + 1e-9
"""No more of a joint's range is looked at, as all repeats after a turn; rounded up."""

OPERATIONS = 200
"""Rounding errors of one value of B_ii in units of the last place of the largest value: some 100 operations a joint."""


@dataclass(frozen=True, slots=True, eq=False)
class InertiaTable:
    """B_ii [kg m^2; kg for a sliding joint] at the nodes: one axis a joint of `joints`, which has moved it."""

    values: Precise
    joints: tuple[int, ...]
    is_turning: tuple[bool, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    left_out: float = 0.0
    """What joints that were left out can add at most."""

    @classmethod
    def of(cls, inertia: JointInertia) -> "InertiaTable":
        """The table of B_ii over the box of `inertia`, in extended precision where the machine has it.

        Raises `OptionError` for more joints than `MOST_VALUES` allows.
        """
        joints = tuple(inertia.moving)
        is_turning = tuple(inertia.kinds[j] is JointKind.REVOLUTE for j in joints)
        size = int(np.prod([WAVES if turns else PARABOLA for turns in is_turning], dtype=float))
        if size > MOST_VALUES:
            raise OptionError("joints behind", f"{len(joints)}, a table of {size} values", f"at most {MOST_VALUES}")
        lower = tuple(float(inertia.lower[j]) for j in joints)
        most = [low + TURN if turns else np.inf for low, turns in zip(lower, is_turning, strict=True)]
        upper = tuple(min(float(inertia.upper[j]), x) for j, x in zip(joints, most, strict=True))
        axes = [nodes(*each) for each in zip(is_turning, lower, upper, strict=True)]
        grid = np.meshgrid(*axes, indexing="ij")
        q: list[Any] = [np.longdouble(x) for x in inertia.lower]
        for j, places in zip(joints, grid, strict=True):
            q[j] = places
        unit = [1.0 if j == inertia.joint else 0.0 for j in range(len(q))]
        links, rotors = inertia.recursion.links, inertia.recursion.rotors
        tau = inverse_dynamics(links, ZERO, q, [0.0] * len(q), unit, rotors)[inertia.joint]
        shape = tuple(len(axis) for axis in axes)
        return cls(np.array(np.broadcast_to(tau, shape), dtype=np.longdouble), joints, is_turning, lower, upper)

    @property
    def shape(self) -> tuple[int, ...]:
        """Values along each joint."""
        return tuple(WAVES if turns else PARABOLA for turns in self.is_turning)

    def without_idle(self, allowed: float) -> "InertiaTable":
        """The table without turning joints that add, all together, at most `allowed`, which is kept in `left_out`.

        Without a joint there is its mean over the turn; the rest is at most the sum of the sizes of all amplitudes that
        go with its angle.
        """
        table = self
        for place in reversed(range(len(self.joints))):
            if not table.is_turning[place]:
                continue
            added = float(np.abs(np.delete(table._amplitudes(), 0, axis=place)).sum())
            if table.left_out + added <= allowed:
                kept = [x for x in range(len(table.joints)) if x != place]
                table = InertiaTable(
                    table.values.mean(axis=place), tuple(table.joints[x] for x in kept),
                    tuple(table.is_turning[x] for x in kept), tuple(table.lower[x] for x in kept),
                    tuple(table.upper[x] for x in kept), table.left_out + added,
                )  # fmt: skip
        return table

    def _amplitudes(self) -> Precise:
        """Amplitudes of the products of 1, cos, sin, cos 2, sin 2 of all angles; control values of sliding joints."""
        out = self.values
        for place, turns in enumerate(self.is_turning):
            matrix = harmonics() if turns else control_matrix(False, 0.0, 0.0)
            out = np.moveaxis(np.tensordot(matrix, out, axes=(1, place)), 0, place)
        return out

    def boxes(self) -> Iterator[tuple[Precise, float]]:
        """Control values on every first box, and how far errors of the table's values may be multiplied there."""
        yield from self._from(0, self.values, 1.0)

    def half_width(self, place: int) -> float:
        """Half of the width of the first boxes along a joint [rad or m]."""
        return (self.upper[place] - self.lower[place]) / self._count(place) / 2

    def rounding(self, growth: float) -> float:
        """What rounding may have taken from a bound whose table's errors were multiplied by `growth`.

        It allows for double precision once more, without growth: in that B_ii is computed by whoever compares with it.
        """
        units = growth * np.finfo(self.values.dtype).eps + np.finfo(np.float64).eps
        return float(units * OPERATIONS * np.abs(self.values).max(initial=0.0))

    def _count(self, place: int) -> int:
        width = self.upper[place] - self.lower[place]
        return int(np.ceil(width / WIDEST)) if self.is_turning[place] else 1

    def _from(self, place: int, values: Precise, growth: float) -> Iterator[tuple[Precise, float]]:
        if place == len(self.joints):
            yield values, growth
            return
        width = 2 * self.half_width(place)
        for k in range(self._count(place)):
            low = self.lower[place] + k * width
            matrix = control_matrix(self.is_turning[place], low, low + width)
            turned = np.moveaxis(np.tensordot(matrix, values, axes=(1, place)), 0, place)
            yield from self._from(place + 1, turned, growth * float(np.abs(matrix).sum(axis=1).max()))
