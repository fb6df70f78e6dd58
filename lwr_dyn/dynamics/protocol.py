"""What an engine of rigid-body dynamics offers: `Dynamics` behind the shape gate, `UngatedDynamics` for loops.

Every engine passes the same identities and agreement tests.
"""

from typing import Any, Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array


@runtime_checkable
class Dynamics(Protocol):
    """B(q) ddq + C(q, dq) dq + g(q) = tau, in SI units; batches are (..., n).

    Every method raises `ShapeError`: wrong last axis, batches that do not broadcast, a value that is not finite.
    """

    @property
    def n(self) -> int:
        """Number of joints."""

    def mass_matrix(self, q: ArrayLike, /) -> Array:
        """B(q), (..., n, n) [kg m^2 for turning joints], rotors included as `armature`."""

    def coriolis_matrix(self, q: ArrayLike, dq: ArrayLike, /) -> Array:
        """C(q, dq), (..., n, n), in Christoffel form: dB/dt = C + C^T (Siciliano eqs. 7.44, 7.45)."""

    def gravity_vector(self, q: ArrayLike, /) -> Array:
        """g(q), (..., n) [N m]: the torque that holds the arm at rest."""

    def bias_torque(self, q: ArrayLike, dq: ArrayLike, /) -> Array:
        """C(q, dq) dq + g(q), (..., n) [N m]."""

    def inverse_dynamics(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike, /) -> Array:
        """tau, (..., n) [N m]."""

    def forward_dynamics(self, q: ArrayLike, dq: ArrayLike, tau: ArrayLike, /) -> Array:
        """ddq, (..., n) [rad/s^2]."""

    def potential_energy(self, q: ArrayLike, /) -> Array:
        """U(q), (...) [J]; only differences have a meaning."""


class UngatedDynamics(Protocol):
    """The same functions without the shape gate: single states, float64 arrays (n,), nothing checked."""

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
    """The engine's functions without the gate; the engine itself where it has no attribute `ungated`."""
    return cast(UngatedDynamics, getattr(dynamics, "ungated", dynamics))


def mechanical_energy(dynamics: Dynamics, q: Array, dq: Array) -> Array:
    """Kinetic plus potential energy E = dq^T B(q) dq / 2 + U(q), (k,) [J], for k states (k, n).

    Calls the ungated `mechanical_energy(q, dq)` of single states where the engine has one.
    """
    single = getattr(ungated(dynamics), "mechanical_energy", None)
    if single is not None:
        return np.array([single(x, v) for x, v in zip(q, dq, strict=True)])
    B = dynamics.mass_matrix(q)
    return np.asarray(np.einsum("ki,kij,kj->k", dq, B, dq) / 2 + dynamics.potential_energy(q))


def singular_joint(B: Array) -> int | None:
    """The joint (0-based) at which a mass matrix of the batch (k, n, n) has no inverse; None where all have one.

    Each matrix is scaled to a diagonal of ones, so that a light finger on a heavy base is no fault: its smallest
    eigenvalue is then at most `n` roundings, or an entry of the diagonal is not above 0, or one is not finite.
    """
    diagonal = np.diagonal(B, axis1=-2, axis2=-1)
    bad = ~((diagonal > 0.0) & np.isfinite(B).all(axis=-1))
    if bad.any():
        return int(np.argmax(bad.any(axis=0)))
    size = np.sqrt(diagonal)
    values, vectors = np.linalg.eigh(B / (size[..., :, None] * size[..., None, :]))
    worst = int(np.argmin(values[:, 0]))
    if values[worst, 0] > B.shape[-1] * np.finfo(np.float64).eps:
        return None
    return int(np.argmax(np.abs(vectors[worst, :, 0])))
