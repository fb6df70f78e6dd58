"""Road B: B, C and g from the recursion, as in the LWR 4+ paper.

g(q) = NE(q, 0, 0); column j of B = NE(q, 0, e_j) without gravity; C e_j = [h(dq + e_j) - h(dq) - h(e_j)] / 2 with
h(dq) = NE(q, dq, 0) without gravity, which is quadratic in dq: its polar form is the Christoffel matrix.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from lwr_dyn.dynamics.protocol import Gated
from lwr_dyn.dynamics.recursion import LinkConstants, Rotors, inverse_dynamics, link_constants, potential_energy
from lwr_dyn.dynamics.regressor import chain_with_dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.spatial import ZERO, Scalar, Vector

_ZERO = 0.0  # a literal zero, whose terms the recursion drops


@dataclass(frozen=True, slots=True, eq=False)
class Recursion:
    """The functions of a chain without the gate: arrays (..., n) of any scalar NumPy can hold, symbols too."""

    links: tuple[LinkConstants, ...]
    gravity: Vector
    rotors: Rotors = "armature"

    @classmethod
    def of(cls, chain: Chain, rotors: Rotors = "armature") -> Self:
        """The recursion of a chain."""
        return cls(link_constants(chain), Vector.of(chain.gravity), rotors)

    def _torque(self, gravity: Vector, q: Any, dq: Any, ddq: Any) -> Any:
        n = len(self.links)
        zeros = [_ZERO] * n
        q_i, dq_i, ddq_i = (zeros if x is None else [x[..., i] for i in range(n)] for x in (q, dq, ddq))
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
        return _matrix(columns, q)

    def mass_and_bias(self, q: Array, dq: Array) -> tuple[Array, Array]:
        """B (k, n, n) and C dq + g (k, n) of states (k, n): both in one pass, which gives the bits of two."""
        n = len(self.links)
        first = np.eye(n + 1, 1)  # of the pass: the bias; then the unit accelerations, at rest and without gravity
        torque = self._torque(self.gravity.times(first), q, first[..., None] * dq, np.eye(n + 1, n, -1)[:, None])
        torque = np.broadcast_to(torque, (n + 1, *q.shape))
        return np.moveaxis(torque[1:], 0, -1), torque[0]

    def forward_dynamics(self, q: Any, dq: Any, tau: Any) -> Any:
        """ddq = B^-1 (tau - C dq - g), for numbers."""
        net = tau - self.bias_torque(q, dq)
        return np.linalg.solve(self.mass_matrix(q), net[..., None])[..., 0]

    def coriolis_matrix(self, q: Any, dq: Any) -> Any:
        """C(q, dq): column j is the polar form of h at (dq, e_j)."""
        unit = np.eye(len(self.links))
        q_row = q[..., None, :]
        both = self.velocity_torque(q_row, dq[..., None, :] + unit)
        columns = (both - self.velocity_torque(q, dq)[..., None, :] - self.velocity_torque(q_row, unit)) / 2
        return _matrix(columns, q)

    def potential_energy(self, q: Any) -> Any:
        """U(q)."""
        return potential_energy(self.links, self.gravity, [q[..., i] for i in range(len(self.links))])


def _matrix(columns: Any, q: Any) -> Any:
    """Columns as matrices (..., n, n), one for each q and each chain of a batch.

    Of a single point mass on its axis no entry depends on q.
    """
    n = q.shape[-1]
    batch = np.broadcast_shapes(columns.shape[:-2], q.shape[:-1])
    return np.swapaxes(columns if columns.shape[:-2] == batch else np.broadcast_to(columns, (*batch, n, n)), -1, -2)


def _joined(scalars: Sequence[Scalar]) -> Any:
    """n scalars or batches as one array with the joints last."""
    numeric = all(isinstance(s, float | complex | np.ndarray | np.generic) for s in scalars)
    if not numeric:
        out = np.empty(len(scalars), dtype=object)
        out[:] = list(scalars)
        return out
    return np.stack(np.broadcast_arrays(*scalars), axis=-1)


def newton_euler_dynamics(chain: Chain, rotors: Rotors = "armature") -> Gated[Recursion]:
    """The recursion of a chain behind the shape gate; implements the `Dynamics` protocol."""
    recursion = Recursion.of(chain, rotors)
    return Gated("newton-euler", chain.n, recursion, recursion, maker=(newton_euler_dynamics, (chain, rotors)))


def newton_euler_of_arm(arm: Any, rotors: Rotors) -> Gated[Recursion]:
    """The engine "newton-euler"; raises `MissingDataError` for an arm without inertias."""
    return newton_euler_dynamics(chain_with_dynamics(arm), rotors)
