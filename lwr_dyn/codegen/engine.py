"""The engine "kernels": generated code behind the same gate and the same protocol as the other engines."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, joint_array, same_batch
from lwr_dyn.codegen.batch import BatchDynamics, batch_dynamics
from lwr_dyn.codegen.functions import function_shape
from lwr_dyn.codegen.rows import nearer
from lwr_dyn.model.arm import Arm


class SingleStates:
    """The kernels called with single states, float64 (n,), nothing checked: for loops."""

    __slots__ = ("_batch",)

    def __init__(self, batch: BatchDynamics) -> None:
        self._batch = batch

    def _of(self, function: str, *states: Any) -> Any:
        kernel = self._batch.kernel(function)
        arrays = [np.ascontiguousarray(x, dtype=np.float64) for x in states]
        out = np.empty(function_shape(function).result(self._batch.n))
        place = out.__array_interface__["data"][0]
        if kernel.run([(x.__array_interface__["data"][0], 0) for x in arrays], place, 1):
            with np.errstate(invalid="ignore"):  # a state that is not finite gives NaN, as in the other engines
                arrays[0] = nearer(self._batch.form.chain, arrays[0])
            kernel.run([(x.__array_interface__["data"][0], 0) for x in arrays], place, 1)
        return out

    def mass_matrix(self, q: Any) -> Any:
        """B(q), (n, n)."""
        return self._of("mass_matrix", q)

    def coriolis_matrix(self, q: Any, dq: Any) -> Any:
        """C(q, dq), (n, n)."""
        return self._of("coriolis_matrix", q, dq)

    def gravity_vector(self, q: Any) -> Any:
        """g(q), (n,)."""
        return self._of("gravity_vector", q)

    def bias_torque(self, q: Any, dq: Any) -> Any:
        """C(q, dq) dq + g(q), (n,)."""
        return self._of("bias_torque", q, dq)

    def inverse_dynamics(self, q: Any, dq: Any, ddq: Any) -> Any:
        """tau, (n,)."""
        return self._of("inverse_dynamics", q, dq, ddq)

    def forward_dynamics(self, q: Any, dq: Any, tau: Any) -> Any:
        """ddq, (n,)."""
        return self._of("forward_dynamics", q, dq, tau)

    def potential_energy(self, q: Any) -> Any:
        """U(q) [J]."""
        return self._of("potential_energy", q)[()]

    def mechanical_energy(self, q: Any, dq: Any) -> Any:
        """Kinetic plus potential energy [J]."""
        return (self._of("kinetic_energy", q, dq) + self._of("potential_energy", q))[()]


class Kernels:
    """The engine "kernels"; implements the `Dynamics` protocol. Its kernels are compiled when first used."""

    __slots__ = ("batch", "n", "ungated")

    def __init__(self, arm: Arm, rotors: str = "armature") -> None:
        self.batch = batch_dynamics(arm, rotors=rotors)
        self.n: int = arm.n
        self.ungated = SingleStates(self.batch)

    def mass_matrix(self, q: ArrayLike) -> Array:
        """B(q), (..., n, n)."""
        return self._each("mass_matrix", q=q)

    def coriolis_matrix(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """C(q, dq), (..., n, n), Christoffel form."""
        return self._each("coriolis_matrix", q=q, dq=dq)

    def gravity_vector(self, q: ArrayLike) -> Array:
        """g(q), (..., n)."""
        return self._each("gravity_vector", q=q)

    def bias_torque(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """C(q, dq) dq + g(q), (..., n)."""
        return self._each("bias_torque", q=q, dq=dq)

    def inverse_dynamics(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike) -> Array:
        """tau, (..., n)."""
        return self._each("inverse_dynamics", q=q, dq=dq, ddq=ddq)

    def forward_dynamics(self, q: ArrayLike, dq: ArrayLike, tau: ArrayLike) -> Array:
        """ddq, (..., n)."""
        return self._each("forward_dynamics", q=q, dq=dq, tau=tau)

    def potential_energy(self, q: ArrayLike) -> Array:
        """U(q), (...)."""
        return self._each("potential_energy", q=q)

    def _each(self, function: str, **arrays: ArrayLike) -> Array:
        checked = {name: joint_array(name, value, self.n) for name, value in arrays.items()}
        batch = same_batch(**checked)
        rows = [np.broadcast_to(a, (*batch, self.n)).reshape(-1, self.n) for a in checked.values()]
        out: Array = getattr(self.batch, function)(*rows)
        return out.reshape((*batch, *out.shape[1:]))
