"""Radau IIA of order 5, one or several steps an interval: the second road of elastic joints, and their events.

Stiffly accurate and L-stable, so stiff springs and dampers cost nothing. Its slopes are differences of the rates, so it
follows any contact mode. Work that the motion does not feel is summed with the stages' weights.

References
----------
E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., section IV.5, Table 5.6.
"""

from collections.abc import Callable

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.simulation.integrators import Integrator, Rates

_R = np.sqrt(6.0)
STAGES = np.array(
    [
        [(88 - 7 * _R) / 360, (296 - 169 * _R) / 1800, (-2 + 3 * _R) / 225],
        [(296 + 169 * _R) / 1800, (88 + 7 * _R) / 360, (-2 - 3 * _R) / 225],
        [(16 - _R) / 36, (16 + _R) / 36, 1 / 9],
    ]
)
TIMES = STAGES.sum(axis=1)
MOST_ITERATIONS = 100
"""Steep friction, whose slope changes within a step, takes 40; smooth motion takes 5."""
CHANGE = 1e-14
"""Of the largest entry of the state: smaller changes of the stages are rounding."""
SLOPE_STEP = 1e-7
"""[rad, rad/s] of the differences for the slopes, which only speed Newton's iteration up."""


def radau(motion: int, substeps: int = 1) -> Integrator:
    """The method, for states whose first `motion` entries decide about the rates; a failed step gives NaN.

    >>> x = radau(1, 4)(lambda t, x: -1e6 * (x - 1.0), 0.0, np.zeros(1), 1.0)
    >>> bool(abs(x[0] - 1.0) < 1e-12)
    True
    """
    slopes_at = _remembered(motion)

    def advance(rates: Rates, t: float, x: Array, h: float) -> Array:
        d = h / substeps
        for i in range(substeps):
            s = t + i * d
            f0, J = slopes_at(rates, s, x)
            x = _step(rates, s, x, d, f0, J, motion)
        return x

    return advance


def _step(rates: Rates, t: float, x: Array, d: float, f0: Array, J: Array, m: int) -> Array:
    if not np.isfinite(J).all():
        return np.full_like(x, np.nan)
    newton = np.linalg.inv(np.eye(3 * m) - d * np.kron(STAGES, J))
    scale = CHANGE * max(1.0, float(np.abs(x[:m]).max()))
    z, best = np.outer(TIMES * d, f0), np.inf
    for _ in range(MOST_ITERATIONS):
        f = np.array([rates(t + c * d, x + part) for c, part in zip(TIMES, z, strict=True)])
        rest = d * STAGES @ f - z
        change = (newton @ rest[:, :m].ravel()).reshape(3, m)
        z[:, :m] += change
        z[:, m:] += rest[:, m:]
        z[:, (f == 0.0).all(axis=0)] = 0.0  # what rests stays to the last bit: Newton's matrix leaves roundings
        size = float(np.abs(change).max())
        if not np.isfinite(size):
            break
        if size <= scale or (size >= best and size <= 1e3 * scale):
            return np.asarray(x + z[2])
        best = min(best, size)
    return np.full_like(x, np.nan)


def _remembered(m: int) -> Callable[[Rates, float, Array], tuple[Array, Array]]:
    """Rates and slopes (m, m) at a state; those of the last one are kept, since events ask for them again."""
    known: tuple[float, bytes, Array, Array] | None = None

    def slopes_at(rates: Rates, t: float, x: Array) -> tuple[Array, Array]:
        nonlocal known
        key = x.tobytes()
        if known is None or known[0] != t or known[1] != key:
            f0 = rates(t, x)
            J = np.empty((m, m))
            for j in range(m):
                moved = x.copy()
                moved[j] += SLOPE_STEP
                J[:, j] = (rates(t, moved)[:m] - f0[:m]) / SLOPE_STEP
            known = t, key, f0, J
        return known[2], known[3]

    return slopes_at
