"""LDL^T factorisation and solution of a small symmetric system in symbols, unrolled: no pivot, no square root."""

from typing import Any

import casadi


def ldl_factor(B: Any) -> tuple[Any, Any]:
    """The unit lower triangle L and the reciprocal diagonal of D, with B = L D L^T."""
    n = B.shape[0]
    L = casadi.SX.eye(n)
    D: list[Any] = []
    inverse = casadi.SX.zeros(n)
    for j in range(n):
        d = B[j, j] - sum(L[j, k] ** 2 * D[k] for k in range(j))
        D.append(d)
        inverse[j] = 1.0 / d
        for i in range(j + 1, n):
            L[i, j] = (B[i, j] - sum(L[i, k] * L[j, k] * D[k] for k in range(j))) * inverse[j]
    return L, inverse


def ldl_solve(factor: tuple[Any, Any], right: Any) -> Any:
    """B^-1 right, for one or several columns."""
    L, inverse = factor
    n, columns = right.shape
    out = casadi.SX.zeros(n, columns)
    for c in range(columns):
        y: list[Any] = []
        for i in range(n):
            y.append(right[i, c] - sum(L[i, k] * y[k] for k in range(i)))
        z: list[Any] = [None] * n
        for i in reversed(range(n)):
            z[i] = y[i] * inverse[i] - sum(L[k, i] * z[k] for k in range(i + 1, n))
        out[:, c] = casadi.vertcat(*z)
    return out
