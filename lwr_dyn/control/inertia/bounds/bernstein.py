"""One joint's factor of B_ii as control values: a convex combination of them gives the function, so they bound it.

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

from math import comb
from typing import Any

import numpy as np
from numpy.typing import NDArray

Precise = NDArray[np.floating[Any]]
"""Of extended precision where the machine has it."""
WAVES, PARABOLA = 5, 3
"""Control values along a joint that turns, and along one that slides."""
_INNER = np.array([1.0, 2.0, 1.0])


def nodes(is_turning: bool, lower: float, upper: float) -> Precise:
    """Joint positions [rad or m] whose values determine B_ii along a joint: 5 around the turn, or 3 over the range."""
    if is_turning:
        return np.asarray(2 * _pi() * np.arange(WAVES) / WAVES, dtype=np.longdouble)
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


def _pi() -> Any:
    """To extended precision."""
    return 4 * np.arctan(np.longdouble(1))
