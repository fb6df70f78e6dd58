"""Maxima of B_ii(q), the inertia seen at a joint: along one joint, and local."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize

from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.recursion import inverse_dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.vectors import ZERO

_LINE = 181
"""Points of a line among which Newton's method starts at the best."""
_STEP = 1e-5
"""[rad or m] Of the central differences of `local_maximum`."""


def diagonal(recursion: Recursion, i: int, q: Array) -> Array:
    """B_ii(q), (...), for q (..., n): the torque at joint i of a unit acceleration of joint i; links before it rest."""
    links = recursion.links[i:]
    unit = [1.0] + [0.0] * (len(links) - 1)
    split = [q[..., i + j] for j in range(len(links))]
    tau: Any = inverse_dynamics(links, ZERO, split, [0.0] * len(links), unit, recursion.rotors)[0]
    return np.broadcast_to(np.asarray(tau, dtype=np.float64), q.shape[:-1])


@dataclass(frozen=True, slots=True, eq=False)
class JointInertia:
    """sign B_ii(q) of joint i over the box from `lower` to `upper` (n,); with sign -1 its maxima are minima of B_ii."""

    recursion: Recursion
    kinds: tuple[JointKind, ...]
    joint: int
    lower: Array
    upper: Array
    sign: float = 1.0

    @property
    def moving(self) -> list[int]:
        """Joints that can change the value: those behind joint i that are not held."""
        return [j for j in range(self.joint + 1, len(self.kinds)) if self.upper[j] > self.lower[j]]

    @property
    def content(self) -> str:
        """Everything that the values depend on, apart from the joint and the sign."""
        return repr((self.recursion, self.kinds, self.lower.tolist(), self.upper.tolist()))

    def at(self, q: Array) -> Array:
        """The values (...) [kg m^2; kg for a sliding joint] at q (..., n)."""
        return self.sign * diagonal(self.recursion, self.joint, q)

    def line_maximum(self, q: Array, j: int) -> Array:
        """The q_j (rows,) in its range with the largest value, all else held, for every row of q (rows, n)."""
        if self.kinds[j] is JointKind.PRISMATIC:
            return self._parabola_maximum(q, j)
        nodes = 2 * np.pi * np.arange(5) / 5
        samples = self.at(with_joint_values(q, j, nodes))
        wave = np.array([np.ones(5), np.cos(nodes), np.sin(nodes), np.cos(2 * nodes), np.sin(2 * nodes)])
        a0, a1, b1, a2, b2 = np.linalg.solve(wave.T, samples.T)
        x = np.linspace(self.lower[j], self.upper[j], _LINE)
        line = a0[:, None] + np.outer(a1, np.cos(x)) + np.outer(b1, np.sin(x)) + np.outer(a2, np.cos(2 * x))
        line += np.outer(b2, np.sin(2 * x))
        best = x[np.argmax(line, axis=-1)]
        for _ in range(6):
            c, s, c2, s2 = np.cos(best), np.sin(best), np.cos(2 * best), np.sin(2 * best)
            slope = -a1 * s + b1 * c - 2 * a2 * s2 + 2 * b2 * c2
            curve = -a1 * c - b1 * s - 4 * a2 * c2 - 4 * b2 * s2
            step = np.where(curve < 0.0, -slope / np.where(curve < 0.0, curve, -1.0), 0.0)
            best = np.clip(best + np.clip(step, -0.05, 0.05), self.lower[j], self.upper[j])
        flat = np.ptp(samples, axis=-1) <= 1e-13 * np.abs(a0)
        return np.where(flat, q[:, j], best)

    def _parabola_maximum(self, q: Array, j: int) -> Array:
        """The same along a sliding joint: three values give the parabola; its ends or its vertex are best."""
        low, up = self.lower[j], self.upper[j]
        half = (up - low) / 2
        left, middle, right = self.at(with_joint_values(q, j, np.array([low, low + half, up]))).T
        bend, slope = left - 2 * middle + right, (right - left) / 2
        vertex = np.where(bend < 0.0, -slope / np.where(bend < 0.0, bend, -1.0), np.where(right > left, 1.0, -1.0))
        places = np.stack([np.full(len(q), -1.0), np.clip(vertex, -1.0, 1.0), np.full(len(q), 1.0)], axis=-1)
        values = middle[:, None] + slope[:, None] * places + bend[:, None] / 2 * places**2
        best = low + half * (1.0 + places[np.arange(len(q)), np.argmax(values, axis=-1)])
        flat = np.abs(bend) + np.abs(slope) <= 1e-13 * np.abs(middle)
        return np.where(flat, q[:, j], best)

    def local_maximum(self, q: Array) -> tuple[Array, float]:
        """The local maximum that L-BFGS-B reaches from q (n,), and the value there."""
        n = len(q)
        steps = _STEP * np.eye(n)

        def descent(x: Array) -> tuple[float, Array]:
            values = -self.at(np.vstack([x, x + steps, x - steps]))
            return float(values[0]), (values[1 : n + 1] - values[n + 1 :]) / (2 * _STEP)

        solution = minimize(
            descent, q, jac=True, method="L-BFGS-B", bounds=list(zip(self.lower, self.upper, strict=True)),
            options={"ftol": 1e-15, "gtol": 1e-12, "maxiter": 500},
        )  # fmt: skip
        return np.clip(solution.x, self.lower, self.upper), -float(solution.fun)


def with_joint_values(q: Array, j: int, values: Array) -> Array:
    """Every row of q (rows, n) with q_j at each of the values, (rows, len(values), n)."""
    out = np.repeat(q[:, None, :], len(values), axis=1)
    out[:, :, j] = values
    return out
