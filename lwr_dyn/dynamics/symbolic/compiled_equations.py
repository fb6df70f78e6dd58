"""Equations of motion in numbers: compiled once, then an engine for any masses, lengths and gravity."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from lwr_dyn.dynamics.gate import Gated
from lwr_dyn.dynamics.symbolic.lagrangian import EquationsOfMotion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError

Entries = Callable[..., Sequence[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class CompiledEquations:
    """Functions of (q, dq, ddq, parameters), scalars or batches, whose values are the entries in order."""

    equations: EquationsOfMotion
    B: Entries
    C: Entries
    g: Entries
    tau: Entries
    U: Entries

    def at(self, values: Mapping[str, float]) -> Gated[LagrangianCalls]:
        """The engine at `values`, one for every parameter of the equations; further names are ignored.

        Raises `OptionError` for a parameter without a value.
        """
        names = [s.name for s in self.equations.parameters]
        missing = [name for name in names if name not in values]
        if missing:
            raise OptionError("values", f"none for {', '.join(missing)}", f"a number for each of {', '.join(names)}")
        calls = LagrangianCalls(self, tuple(float(values[name]) for name in names))
        return Gated("euler-lagrange", self.equations.n, calls, batched=calls)


def compile_equations(equations: EquationsOfMotion) -> CompiledEquations:
    """The equations as functions of NumPy arrays, common factors computed once."""
    x = equations.variables
    symbols = [*x.q, *x.dq, *x.ddq, *equations.parameters]

    def function(entries: Any) -> Entries:
        compiled: Entries = sp.lambdify(symbols, list(entries), modules="numpy", cse=True)
        return compiled

    e = equations
    return CompiledEquations(e, function(e.B), function(e.C), function(e.g), function(e.tau), function([e.potential]))


@dataclass(frozen=True, slots=True, eq=False)
class LagrangianCalls:
    """The compiled equations with numbers for their parameters: functions of states (..., n), nothing checked."""

    compiled: CompiledEquations
    values: tuple[float, ...]

    def _entries(self, entries: Entries, axes: int, q: Any, dq: Any = None, ddq: Any = None) -> Array:
        batch, n = q.shape[:-1], q.shape[-1]
        states = [np.zeros(n) if x is None else x for x in (q, dq, ddq)]
        scalars = [x[..., i] for x in states for i in range(n)]
        rows = [np.broadcast_to(np.asarray(v, dtype=np.float64), batch) for v in entries(*scalars, *self.values)]
        return np.stack(rows, axis=-1).reshape((*batch, *(n,) * axes))

    def mass_matrix(self, q: Any) -> Array:
        """B(q), (..., n, n)."""
        return self._entries(self.compiled.B, 2, q)

    def coriolis_matrix(self, q: Any, dq: Any) -> Array:
        """C(q, dq), (..., n, n), Christoffel form."""
        return self._entries(self.compiled.C, 2, q, dq)

    def gravity_vector(self, q: Any) -> Array:
        """g(q), (..., n)."""
        return self._entries(self.compiled.g, 1, q)

    def bias_torque(self, q: Any, dq: Any) -> Array:
        """C(q, dq) dq + g(q), (..., n): the Lagrange equations without acceleration."""
        return self._entries(self.compiled.tau, 1, q, dq)

    def inverse_dynamics(self, q: Any, dq: Any, ddq: Any) -> Array:
        """tau, (..., n): the Lagrange equations."""
        return self._entries(self.compiled.tau, 1, q, dq, ddq)

    def forward_dynamics(self, q: Any, dq: Any, tau: Any) -> Any:
        """ddq = B^-1 (tau - C dq - g), (..., n)."""
        return np.linalg.solve(self.mass_matrix(q), (tau - self.bias_torque(q, dq))[..., None])[..., 0]

    def potential_energy(self, q: Any) -> Array:
        """U(q), (...)."""
        return self._entries(self.compiled.U, 0, q)
