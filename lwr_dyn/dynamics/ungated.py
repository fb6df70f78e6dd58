"""The maths of an engine without the shape gate, for loops that call it a million times.

An engine may carry an `ungated` object; one that does not is called through its public methods.
"""

from __future__ import annotations

from typing import Any, Protocol, cast

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.dynamics.protocol import Dynamics


class UngatedDynamics(Protocol):
    """What a loop calls: single states, float64 arrays (n,), nothing checked."""

    def mass_matrix(self, q: Any, /) -> Any:
        """B(q), (n, n)."""

    def coriolis_matrix(self, q: Any, dq: Any, /) -> Any:
        """C(q, dq), (n, n)."""

    def gravity_vector(self, q: Any, /) -> Any:
        """g(q), (n,)."""

    def bias_torque(self, q: Any, dq: Any, /) -> Any:
        """C(q, dq) dq + g(q), (n,)."""

    def inverse_dynamics(self, q: Any, dq: Any, ddq: Any, /) -> Any:
        """tau, (n,)."""

    def forward_dynamics(self, q: Any, dq: Any, tau: Any, /) -> Any:
        """ddq, (n,)."""

    def potential_energy(self, q: Any, /) -> Any:
        """U(q) [J]."""


def ungated(dynamics: Dynamics) -> UngatedDynamics:
    """The engine's ungated functions, or the engine itself where it offers none."""
    return cast(UngatedDynamics, getattr(dynamics, "ungated", dynamics))


def mechanical_energy(dynamics: Dynamics, q: Array, dq: Array) -> Array:
    """Kinetic plus potential energy E = dq^T B(q) dq / 2 + U(q), (k,) [J], for k states (k, n).

    An engine whose ungated object has a `mechanical_energy(q, dq)` of single states is asked for that.
    """
    single = getattr(ungated(dynamics), "mechanical_energy", None)
    if single is not None:
        return np.array([single(x, v) for x, v in zip(q, dq, strict=True)])
    B = dynamics.mass_matrix(q)
    return np.asarray(np.einsum("ki,kij,kj->k", dq, B, dq) / 2 + dynamics.potential_energy(q))
