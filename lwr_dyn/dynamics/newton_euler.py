"""Road B as an engine: B, C and g drawn from the recursion as the LWR 4+ paper draws them.

g(q) = NE(q, 0, 0); column j of B = NE(q, 0, e_j) without gravity; C e_j = [h(dq + e_j) - h(dq) - h(e_j)] / 2 with
h(dq) = NE(q, dq, 0) without gravity, which is quadratic in dq: its polar form is the Christoffel matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, joint_array, same_batch
from lwr_dyn.dynamics.recursion import LinkConstants, Rotors, inverse_dynamics, link_constants, potential_energy
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.vectors import ZERO, Scalar, Vector

_REST = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Recursion:
    """The ungated maths of a chain: arrays (..., n) of any scalar NumPy can hold, symbols too."""

    links: tuple[LinkConstants, ...]
    gravity: Vector
    rotors: Rotors = "armature"

    @classmethod
    def of(cls, chain: Chain, rotors: Rotors = "armature") -> Recursion:
        """The recursion of a chain."""
        return cls(link_constants(chain), Vector.of(chain.gravity), rotors)

    def _torque(self, gravity: Vector, q: Any, dq: Any, ddq: Any) -> Any:
        n = len(self.links)
        rest = [_REST] * n
        q_i, dq_i, ddq_i = (rest if x is None else [x[..., i] for i in range(n)] for x in (q, dq, ddq))
        return _joined(inverse_dynamics(self.links, gravity, q_i, dq_i, ddq_i, self.rotors))

    def inverse_dynamics(self, q: Any, dq: Any, ddq: Any) -> Any:
        """tau(q, dq, ddq)."""
        return self._torque(self.gravity, q, dq, ddq)

    def gravity_vector(self, q: Any) -> Any:
        """g(q)."""
        return self._torque(self.gravity, q, None, None)

    def bias_torque(self, q: Any, dq: Any) -> Any:
        """C(q, dq) dq + g(q)."""
        return self._torque(self.gravity, q, dq, None)

    def velocity_torque(self, q: Any, dq: Any) -> Any:
        """h(q, dq) = C(q, dq) dq, without gravity."""
        return self._torque(ZERO, q, dq, None)

    def mass_matrix(self, q: Any) -> Any:
        """B(q): all columns in one batch of unit accelerations."""
        columns = self._torque(ZERO, q[..., None, :], None, np.eye(len(self.links)))
        return np.swapaxes(columns, -1, -2)

    def forward_dynamics(self, q: Any, dq: Any, tau: Any) -> Any:
        """ddq = B^-1 (tau - C dq - g), for numbers."""
        rest = tau - self.bias_torque(q, dq)
        return np.linalg.solve(self.mass_matrix(q), rest[..., None])[..., 0]

    def coriolis_matrix(self, q: Any, dq: Any) -> Any:
        """C(q, dq): column j is the polar form of h at (dq, e_j)."""
        unit = np.eye(len(self.links))
        here = q[..., None, :]
        both = self.velocity_torque(here, dq[..., None, :] + unit)
        columns = (both - self.velocity_torque(q, dq)[..., None, :] - self.velocity_torque(here, unit)) / 2
        return np.swapaxes(columns, -1, -2)

    def potential_energy(self, q: Any) -> Any:
        """U(q)."""
        return potential_energy(self.links, self.gravity, [q[..., i] for i in range(len(self.links))])


def _joined(scalars: Sequence[Scalar]) -> Any:
    """n scalars or batches as one array with the joints last."""
    numeric = all(isinstance(s, float | complex | np.ndarray | np.generic) for s in scalars)
    if not numeric:
        out = np.empty(len(scalars), dtype=object)
        out[:] = list(scalars)
        return out
    return np.stack(np.broadcast_arrays(*scalars), axis=-1)


@dataclass(frozen=True, slots=True, eq=False)
class NewtonEuler:
    """The engine "newton-euler": `Recursion` behind the shape gate; implements the `Dynamics` protocol."""

    chain: Chain
    rotors: Rotors = "armature"
    ungated: Recursion = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "ungated", Recursion.of(self.chain, self.rotors))

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.chain.n

    def _gate(self, **arrays: ArrayLike) -> list[Array]:
        checked = {name: joint_array(name, value, self.n) for name, value in arrays.items()}
        batch = same_batch(**checked)
        return [np.broadcast_to(a, (*batch, self.n)) for a in checked.values()]

    def mass_matrix(self, q: ArrayLike) -> Array:
        """B(q), (..., n, n)."""
        (checked,) = self._gate(q=q)
        return _array(np.broadcast_to(self.ungated.mass_matrix(checked), (*checked.shape, self.n)))

    def coriolis_matrix(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """C(q, dq), (..., n, n), Christoffel form."""
        checked, speed = self._gate(q=q, dq=dq)
        return _array(np.broadcast_to(self.ungated.coriolis_matrix(checked, speed), (*checked.shape, self.n)))

    def gravity_vector(self, q: ArrayLike) -> Array:
        """g(q), (..., n)."""
        (checked,) = self._gate(q=q)
        return _array(np.broadcast_to(self.ungated.gravity_vector(checked), checked.shape))

    def bias_torque(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """C(q, dq) dq + g(q), (..., n)."""
        checked, speed = self._gate(q=q, dq=dq)
        return _array(np.broadcast_to(self.ungated.bias_torque(checked, speed), checked.shape))

    def inverse_dynamics(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike) -> Array:
        """tau, (..., n)."""
        return _array(self.ungated.inverse_dynamics(*self._gate(q=q, dq=dq, ddq=ddq)))

    def forward_dynamics(self, q: ArrayLike, dq: ArrayLike, tau: ArrayLike) -> Array:
        """ddq = B^-1 (tau - C dq - g), (..., n)."""
        return _array(self.ungated.forward_dynamics(*self._gate(q=q, dq=dq, tau=tau)))

    def potential_energy(self, q: ArrayLike) -> Array:
        """U(q), (...)."""
        (checked,) = self._gate(q=q)
        return _array(np.broadcast_to(self.ungated.potential_energy(checked), checked.shape[:-1]))


def _array(value: Any) -> Array:
    return np.array(value, dtype=np.float64)


def newton_euler_engine(arm: Any, rotors: Rotors) -> NewtonEuler:
    """The row "newton-euler" of the engines."""
    return NewtonEuler(arm.require_dynamics(), rotors)
