"""Equations of motion as numbers: symbols compiled once, then an engine for any masses, lengths and gravity."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, joint_array, same_batch
from lwr_dyn.errors import OptionError
from lwr_dyn.symbolic.lagrangian import EquationsOfMotion

Entries = Callable[..., Sequence[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Compiled:
    """Functions of (q, dq, ddq, parameters), scalars or batches, that give entries in order; no symbol is left."""

    equations: EquationsOfMotion
    B: Entries
    C: Entries
    g: Entries
    tau: Entries
    U: Entries

    def at(self, values: Mapping[str, float]) -> LagrangianDynamics:
        """The engine at `values`, one for every parameter of the equations; further names are ignored.

        Raises `OptionError` for a parameter without a value.
        """
        names = [s.name for s in self.equations.parameters]
        missing = [name for name in names if name not in values]
        if missing:
            raise OptionError("values", f"none for {', '.join(missing)}", f"a number for each of {', '.join(names)}")
        return LagrangianDynamics(self, tuple(float(values[name]) for name in names))


def compile_equations(equations: EquationsOfMotion) -> Compiled:
    """The equations as functions of NumPy arrays, common factors computed once."""
    x = equations.variables
    symbols = [*x.q, *x.dq, *x.ddq, *equations.parameters]

    def function(entries: Any) -> Entries:
        compiled: Entries = sp.lambdify(symbols, list(entries), modules="numpy", cse=True)
        return compiled

    e = equations
    return Compiled(e, function(e.B), function(e.C), function(e.g), function(e.tau), function([e.potential]))


@dataclass(frozen=True, slots=True, eq=False)
class LagrangianDynamics:
    """Symbolic equations with numbers in them, behind the shape gate; implements the `Dynamics` protocol."""

    compiled: Compiled
    values: tuple[float, ...]

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.compiled.equations.n

    def _entries(self, entries: Entries, shape: tuple[int, ...], **arrays: ArrayLike) -> Array:
        checked = {name: joint_array(name, value, self.n) for name, value in arrays.items()}
        batch = same_batch(**checked)
        rest = np.zeros(self.n)
        states = [checked.get(name, rest) for name in ("q", "dq", "ddq")]
        scalars = [x[..., i] for x in states for i in range(self.n)]
        found = [np.broadcast_to(np.asarray(v, dtype=np.float64), batch) for v in entries(*scalars, *self.values)]
        return np.stack(found, axis=-1).reshape(*batch, *shape)

    def mass_matrix(self, q: ArrayLike) -> Array:
        """B(q), (..., n, n)."""
        return self._entries(self.compiled.B, (self.n, self.n), q=q)

    def coriolis_matrix(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """C(q, dq), (..., n, n), Christoffel form."""
        return self._entries(self.compiled.C, (self.n, self.n), q=q, dq=dq)

    def gravity_vector(self, q: ArrayLike) -> Array:
        """g(q), (..., n)."""
        return self._entries(self.compiled.g, (self.n,), q=q)

    def bias_torque(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """C(q, dq) dq + g(q), (..., n): the Lagrange equations without acceleration."""
        return self._entries(self.compiled.tau, (self.n,), q=q, dq=dq)

    def inverse_dynamics(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike) -> Array:
        """tau, (..., n): the Lagrange equations."""
        return self._entries(self.compiled.tau, (self.n,), q=q, dq=dq, ddq=ddq)

    def forward_dynamics(self, q: ArrayLike, dq: ArrayLike, tau: ArrayLike) -> Array:
        """ddq = B^-1 (tau - C dq - g), (..., n)."""
        torque = joint_array("tau", tau, self.n)
        rest = torque - self.bias_torque(q, dq)
        return np.asarray(np.linalg.solve(self.mass_matrix(q), rest[..., None])[..., 0])

    def potential_energy(self, q: ArrayLike) -> Array:
        """U(q), (...)."""
        return self._entries(self.compiled.U, (), q=q)
