"""From a state to the state after a step: Runge-Kutta of order 4 in fixed steps, and an adaptive reference."""

from collections.abc import Callable

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.simulation.arm_friction import FrictionTorque
from lwr_dyn.simulation.plant import ExternalTorque

Rates = Callable[[float, Array], Array]
"""dx/dt of (t, x)."""
Integrator = Callable[[Rates, float, Array, float], Array]
"""x(t + h) of (rates, t, x, h)."""
Accelerate = Callable[[Array, Array, Array], Array]
"""(q, dq, torque without the friction of moving joints) -> ddq, (n,) each."""
HeldStep = Callable[[float, Array, Array, Array], tuple[float, ...]]
"""`step(t, now, tau, after)` writes the state `after` (2, n) that follows `now` (2, n) under the torque tau (n,); it
returns 0, the work of friction and, where they act, of external torques [J]."""
BoundedStep = Callable[[Array, Array, Array], bool | None]
"""`step(now, tau, after)` as `HeldStep`; it gives None, or False for an end outside its bounds: `after` is invalid."""

NODES = (0.5, 0.5, 1.0)
WEIGHTS = np.array([1, 2, 2, 1])
"""Tableau of the classical method: each stage uses the rates of the one before, k_i at x + NODES h k_{i-1}, and
x(h) = x + h WEIGHTS k / 6."""
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
            k = [rates(s, x)]
            for c in NODES:
                k.append(rates(s + c * d, x + (c * d) * k[-1]))
            x = x + (d / 6) * (k[0] + 2 * (k[1] + k[2]) + k[3])
        return x

    return advance


def dop853(rtol: float = 1e-12, atol: float = 1e-13) -> Integrator:
    """Dormand and Prince's method of order 8 with its step adapted to the error; a failed step gives NaN."""

    from scipy.integrate import DOP853  # a third of a second that most commands do not need

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


def held_rk4(
    forward: Accelerate,
    n: int,
    h: float,
    substeps: int = 1,
    friction: FrictionTorque | None = None,
    external: ExternalTorque | None = None,
) -> tuple[HeldStep, Callable[[], Array]]:
    """RK4 over h [s] under a held torque, written for speed, for ddq = forward(q, dq, tau - friction + external).

    For a second-order system the stages are combinations of q, dq and the accelerations k1..k4, so each is one small
    matrix product: q4 = q + h dq + h^2/2 k2, and so on. It is the method of `rk4`, to rounding.

    Returns
    -------
    step : callable
        See `HeldStep`, states (2, n) = (q, dq).
    tangent : callable
        The speeds (n,) at the end of the last substep if the first acceleration in it had stayed.
    """
    d, brake = h / substeps, friction or np.zeros_like
    *stages, end = second_order_tables(d)
    table, stage, dot, repeats = np.zeros((6, n)), np.zeros((2, n)), np.dot, range(substeps)
    start, k1, (q0, dq0), (q, dq) = table[:2], table[2], table[:2], stage
    later = [(c, table[:i], table[i]) for i, c in enumerate(stages, start=3)]
    every = [(0.0, 1.0, np.eye(2), start, k1)]
    every += [(c * d, float(w), *stage_of) for c, w, stage_of in zip(NODES, WEIGHTS[1:], later, strict=True)]

    def frictionless(t: float, now: Array, tau: Array, after: Array) -> tuple[float, ...]:
        state = now
        for _ in repeats:
            start[:] = state
            k1[:] = forward(q0, dq0, tau)
            for coefficients, known, k in later:
                dot(coefficients, known, out=stage)
                k[:] = forward(q, dq, tau)
            dot(end, table, out=after)
            state = after
        return 0.0, 0.0

    def loaded(t: float, now: Array, tau: Array, after: Array) -> tuple[float, ...]:
        state, lost, gained = now, 0.0, 0.0
        for i in repeats:
            start[:] = state
            for node, weight, coefficients, known, k in every:
                dot(coefficients, known, out=stage)
                f, net = brake(dq), tau
                if external is not None:
                    push = external(t + i * d + node, q, dq)
                    gained, net = gained + weight * push.dot(dq), tau + push
                lost += weight * f.dot(dq)
                k[:] = forward(q, dq, net - f)
            dot(end, table, out=after)
            state = after
        return (0.0, -lost * d / 6) if external is None else (0.0, -lost * d / 6, gained * d / 6)

    return (frictionless if friction is None and external is None else loaded), lambda: dq0 + d * k1


def second_order_tables(h: float) -> list[Array]:
    """From (q, dq, k1, ..) to (q, dq) of the stages 2, 3 and 4, and of the end of a step: the tableau applied twice."""
    stages = np.diag(NODES, -1)
    tables = []
    for i, c in enumerate(NODES, start=1):
        twice = h * h * (stages @ stages)[i, :i]
        tables.append(np.array([[1.0, c * h, *twice], [0.0, 1.0, *(h * stages[i, :i])]]))
    end = np.array([[1.0, h, *(h * h * (WEIGHTS @ stages) / 6)], [0.0, 1.0, *(h * WEIGHTS / 6)]])
    return [*tables, end]
