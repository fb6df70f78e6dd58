"""A small symmetric system solved in symbols, unrolled: no loop, no pivot, no square root."""

from __future__ import annotations

from typing import Any

import casadi


def factor_of(B: Any) -> tuple[Any, Any]:
    """Unit lower triangle L and reciprocal diagonal of B = L D L^T, unrolled."""
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


def solved(factor: tuple[Any, Any], right: Any) -> Any:
    """B^-1 right, for a column or several."""
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
