"""What an engine of rigid-body dynamics offers; every engine passes the same laws and agreement tests."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array


@runtime_checkable
class Dynamics(Protocol):
    """B(q) ddq + C(q, dq) dq + g(q) = tau, in SI units; batches are (..., n).

    Every method raises `ShapeError`: wrong last axis, batches that do not broadcast, a value that is not finite.
    """

    @property
    def n(self) -> int:
        """Number of joints."""

    def mass_matrix(self, q: ArrayLike) -> Array:
        """B(q), (..., n, n) [kg m^2 for turning joints], rotors included as `armature`."""

    def coriolis_matrix(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """C(q, dq), (..., n, n), in Christoffel form: dB/dt = C + C^T (Siciliano eqs. 7.44, 7.45)."""

    def gravity_vector(self, q: ArrayLike) -> Array:
        """g(q), (..., n) [N m]: the torque that holds the arm at rest."""

    def bias_torque(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """C(q, dq) dq + g(q), (..., n) [N m]."""

    def inverse_dynamics(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike) -> Array:
        """tau, (..., n) [N m]."""

    def forward_dynamics(self, q: ArrayLike, dq: ArrayLike, tau: ArrayLike) -> Array:
        """ddq, (..., n) [rad/s^2]."""

    def potential_energy(self, q: ArrayLike) -> Array:
        """U(q), (...) [J]; only differences mean something."""
