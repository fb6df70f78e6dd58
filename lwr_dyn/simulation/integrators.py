"""From a state to the state after a step: Runge-Kutta of order 4 in fixed steps, and an adaptive reference."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import DOP853

from lwr_dyn.arrays import Array

Rates = Callable[[float, Array], Array]
"""dx/dt of (t, x)."""
Integrator = Callable[[Rates, float, Array, float], Array]
"""x(t + h) of (rates, t, x, h)."""

MOST_STEPS = 2_000
"""Adaptive steps within one interval after which the motion counts as diverged."""


def rk4(substeps: int = 1) -> Integrator:
    """The classical Runge-Kutta method, an interval cut into `substeps` equal steps.

    >>> x = rk4(10)(lambda t, x: -x, 0.0, np.ones(1), 1.0)
    >>> bool(abs(x[0] - np.exp(-1)) < 1e-6)
    True
    """

    def advance(rates: Rates, t: float, x: Array, h: float) -> Array:
        d = h / substeps
        for i in range(substeps):
            s = t + i * d
            k1 = rates(s, x)
            k2 = rates(s + d / 2, x + (d / 2) * k1)
            k3 = rates(s + d / 2, x + (d / 2) * k2)
            k4 = rates(s + d, x + d * k3)
            x = x + (d / 6) * (k1 + 2 * (k2 + k3) + k4)
        return x

    return advance


def dop853(rtol: float = 1e-12, atol: float = 1e-13) -> Integrator:
    """Dormand and Prince's method of order 8 with its step adapted to the error; a failed step gives NaN."""

    def advance(rates: Rates, t: float, x: Array, h: float) -> Array:
        solver = DOP853(lambda s, y: rates(t + s, y), 0.0, x, h, rtol=rtol, atol=atol, first_step=h)
        for _ in range(MOST_STEPS):
            solver.step()
            if solver.status == "finished":
                return np.asarray(solver.y)
            if solver.status == "failed":
                break
        return np.full_like(x, np.nan)

    return advance


def held_rk4(forward: Callable[..., Any], n: int, h: float) -> Callable[[Array, Array, Array], None]:
    """One RK4 step under a held torque, written for speed: `step(now, tau, after)` with states (2, n) = (q, dq).

    For a second-order system the stages are combinations of q, dq and the accelerations k1..k4, so each is one small
    matrix product: q4 = q + h dq + h^2/2 k2, and so on. It is the method of `rk4`, to rounding.
    """
    c2 = np.array([[1.0, h / 2, 0.0], [0.0, 1.0, h / 2]])
    c3 = np.array([[1.0, h / 2, h * h / 4, 0.0], [0.0, 1.0, 0.0, h / 2]])
    c4 = np.array([[1.0, h, 0.0, h * h / 2, 0.0], [0.0, 1.0, 0.0, 0.0, h]])
    c = np.array(
        [[1.0, h, h * h / 6, h * h / 6, h * h / 6, 0.0], [0.0, 1.0, h / 6, h / 3, h / 3, h / 6]],
    )
    table = np.zeros((6, n))
    start, k1, k2, k3, k4 = table[:2], table[2], table[3], table[4], table[5]
    upto1, upto2, upto3 = table[:3], table[:4], table[:5]
    stage = np.zeros((2, n))
    q, dq = stage
    first_q, first_dq = table[0], table[1]
    dot = np.dot

    def step(now: Array, tau: Array, after: Array) -> None:
        start[:] = now
        k1[:] = forward(first_q, first_dq, tau)
        dot(c2, upto1, out=stage)
        k2[:] = forward(q, dq, tau)
        dot(c3, upto2, out=stage)
        k3[:] = forward(q, dq, tau)
        dot(c4, upto3, out=stage)
        k4[:] = forward(q, dq, tau)
        dot(c, table, out=after)

    return step
