"""Climbing B_ii(q), the inertia a joint feels: its value, its exact maximum along one joint, a maximum near a place."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import minimize

from lwr_dyn.arrays import Array
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.recursion import inverse_dynamics
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.vectors import ZERO

_LINE = 181
"""Points on which a line's maximum is looked for before Newton's method sharpens it."""
_STEP = 1e-5
"""[rad or m] Of the central differences of `local_maximum`."""


def diagonal(recursion: Recursion, i: int, q: Array) -> Array:
    """B_ii(q), (...), for q (..., n): the torque at joint i of a unit acceleration of joint i."""
    n = len(recursion.links)
    unit = [1.0 if j == i else 0.0 for j in range(n)]
    split = [q[..., j] for j in range(n)]
    tau: Any = inverse_dynamics(recursion.links, ZERO, split, [0.0] * n, unit, recursion.rotors)[i]
    return np.broadcast_to(np.asarray(tau, dtype=np.float64), q.shape[:-1])


def best_on_line(
    recursion: Recursion, i: int, q: Array, j: int, kind: JointKind, span: tuple[float, float], sign: float
) -> Array:
    """The q_j in its range that makes sign B_ii largest, all else held, for every row of q."""
    low, up = span
    if kind is JointKind.PRISMATIC:
        return _best_on_parabola(recursion, i, q, j, span, sign)
    nodes = 2 * np.pi * np.arange(5) / 5
    samples = sign * diagonal(recursion, i, moved(q, j, nodes))
    wave = np.array([np.ones(5), np.cos(nodes), np.sin(nodes), np.cos(2 * nodes), np.sin(2 * nodes)])
    a0, a1, b1, a2, b2 = np.linalg.solve(wave.T, samples.T)
    x = np.linspace(low, up, _LINE)
    line = a0[:, None] + np.outer(a1, np.cos(x)) + np.outer(b1, np.sin(x)) + np.outer(a2, np.cos(2 * x))
    line += np.outer(b2, np.sin(2 * x))
    best = x[np.argmax(line, axis=-1)]
    for _ in range(6):
        c, s, c2, s2 = np.cos(best), np.sin(best), np.cos(2 * best), np.sin(2 * best)
        slope = -a1 * s + b1 * c - 2 * a2 * s2 + 2 * b2 * c2
        curve = -a1 * c - b1 * s - 4 * a2 * c2 - 4 * b2 * s2
        step = np.where(curve < 0.0, -slope / np.where(curve < 0.0, curve, -1.0), 0.0)
        best = np.clip(best + np.clip(step, -0.05, 0.05), low, up)
    flat = np.ptp(samples, axis=-1) <= 1e-13 * np.abs(a0)
    return np.where(flat, q[:, j], best)


def _best_on_parabola(recursion: Recursion, i: int, q: Array, j: int, span: tuple[float, float], sign: float) -> Array:
    """The same along a sliding joint: three values give the parabola; its ends or its vertex are best."""
    low, up = span
    half = (up - low) / 2
    left, middle, right = (sign * diagonal(recursion, i, moved(q, j, np.array([low, low + half, up])))).T
    bend, slope = left - 2 * middle + right, (right - left) / 2
    vertex = np.where(bend < 0.0, -slope / np.where(bend < 0.0, bend, -1.0), np.where(right > left, 1.0, -1.0))
    places = np.stack([np.full(len(q), -1.0), np.clip(vertex, -1.0, 1.0), np.full(len(q), 1.0)], axis=-1)
    values = middle[:, None] + slope[:, None] * places + bend[:, None] / 2 * places**2
    best = low + half * (1.0 + places[np.arange(len(q)), np.argmax(values, axis=-1)])
    flat = np.abs(bend) + np.abs(slope) <= 1e-13 * np.abs(middle)
    return np.where(flat, q[:, j], best)


def moved(q: Array, j: int, values: Array) -> Array:
    """Every row of q with q_j at each of the values, (rows, len(values), n)."""
    out = np.repeat(q[:, None, :], len(values), axis=1)
    out[:, :, j] = values
    return out


def local_maximum(
    recursion: Recursion, i: int, q: Array, lower: Array, upper: Array, sign: float
) -> tuple[Array, float]:
    """The local maximum of sign B_ii above q (n,) [rad] in the box, and sign B_ii there, by L-BFGS-B."""
    n = len(q)
    steps = _STEP * np.eye(n)

    def descent(x: Array) -> tuple[float, Array]:
        values = -sign * diagonal(recursion, i, np.vstack([x, x + steps, x - steps]))
        return float(values[0]), (values[1 : n + 1] - values[n + 1 :]) / (2 * _STEP)

    found = minimize(
        descent, q, jac=True, method="L-BFGS-B", bounds=list(zip(lower, upper, strict=True)),
        options={"ftol": 1e-15, "gtol": 1e-12, "maxiter": 500},
    )  # fmt: skip
    return np.clip(found.x, lower, upper), -float(found.fun)
