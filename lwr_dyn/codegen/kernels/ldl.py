"""L D L^T factorisation and solution of a small symmetric system in symbols, unrolled: no pivot, no square root.

The last row is eliminated first: of a mass matrix it is the first to be known.
"""

from typing import Any

import casadi


def ldl_factor(B: Any) -> tuple[Any, Any]:
    """The unit upper triangle U and the reciprocal diagonal of D, with B = U D U^T."""
    n = B.shape[0]
    U, scaled, inverse = casadi.SX.eye(n), casadi.SX.zeros(n, n), casadi.SX.zeros(n)  # scaled = U D
    for j in reversed(range(n)):
        later = range(j + 1, n)
        inverse[j] = 1.0 / _less(B[j, j], ((scaled[j, k], U[j, k]) for k in later))
        for i in range(j):
            scaled[i, j] = _less(B[i, j], ((scaled[i, k], U[j, k]) for k in later))
            U[i, j] = scaled[i, j] * inverse[j]
    return U, inverse


def ldl_solve(factor: tuple[Any, Any], right: Any) -> Any:
    """B^-1 right, for one or several columns."""
    U, inverse = factor
    n, columns = right.shape
    out = casadi.SX.zeros(n, columns)
    for c in range(columns):
        y: list[Any] = [None] * n
        for i in reversed(range(n)):
            y[i] = _less(right[i, c], ((U[i, k], y[k]) for k in range(i + 1, n)))
        z: list[Any] = []
        for i in range(n):
            z.append(_less(y[i] * inverse[i], ((U[k, i], z[k]) for k in range(i))))
        out[:, c] = casadi.vertcat(*z)
    return out


def _less(start: Any, products: Any) -> Any:
    """start - a b - c d - ..."""
    for a, b in products:
        start = start - a * b
    return start
