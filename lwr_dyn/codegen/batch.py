"""Batch dynamics: an arm's functions over rows of states at the speed of the machine.

Results come as new arrays, or in `out`. A state with a value that is not finite gives a row of NaN and a
`NotFiniteWarning` that carries its index; all other states are computed.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.form import Form, form_of
from lwr_dyn.codegen.functions import function_shape
from lwr_dyn.codegen.kernel import Kernel, kernel_of, require_packages, thread_count
from lwr_dyn.codegen.rows import address_and_step, input_rows, nearer, result_array
from lwr_dyn.errors import OptionError
from lwr_dyn.model.arm import Arm

Numbers = NDArray[Any]
"""An array of the batch's number type."""


class NotFiniteWarning(UserWarning):
    """States of a batch hold a value that is not finite; their results are NaN, all others are computed."""

    def __init__(self, function: str, indices: Iterable[int], count: int) -> None:
        self.function, self.indices = function, tuple(int(i) for i in indices)
        shown = ", ".join(str(i) for i in self.indices[:5]) + (", ..." if len(self.indices) > 5 else "")
        super().__init__(
            f"{function}: {len(self.indices)} of {count} states are not finite (index {shown}): their results are NaN"
        )


@dataclass(frozen=True, slots=True, eq=False)
class TorqueDerivatives:
    """Inverse dynamics' derivatives, (N, n, n) each: row is the torque, column the joint."""

    by_q: Numbers
    by_dq: Numbers
    by_ddq: Numbers
    """B itself."""


@dataclass(frozen=True, slots=True, eq=False)
class AccelerationDerivatives:
    """Forward dynamics' derivatives, (N, n, n) each: row is the acceleration, column the joint."""

    by_q: Numbers
    by_dq: Numbers
    by_tau: Numbers
    """B^-1."""


@dataclass(frozen=True, slots=True, eq=False)
class BatchDynamics:
    """Functions over (N, n) arrays of q [rad or m], dq, ddq, tau; a single row (n,) stands for all.

    Inputs of the family are keywords: inertia (n, 10), payload (10,), gravity (3,), friction (5, n), one set for all
    states or one for each with N in front. Every method raises `ShapeError` (shape or number type) and `OptionError`
    (an input missing, or not one of this family); kernels are compiled when they are first used.
    """

    form: Form
    threads: int = 1
    _kernels: dict[str, Kernel] = field(default_factory=dict, repr=False)

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.form.n

    @property
    def dtype(self) -> str:
        """Number type of arguments and results."""
        return self.form.dtype

    def inverse_dynamics(self, q: Any, dq: Any, ddq: Any, *, out: Numbers | None = None, **inputs: Any) -> Numbers:
        """tau (N, n) [N m]: B ddq + C dq + g, and friction where the form has it."""
        return self._evaluate("inverse_dynamics", (q, dq, ddq), out, inputs)

    def mass_matrix(self, q: Any, *, out: Numbers | None = None, **inputs: Any) -> Numbers:
        """B(q), (N, n, n) [kg m^2], rotors included as the form has them."""
        return self._evaluate("mass_matrix", (q,), out, inputs)

    def bias_torque(self, q: Any, dq: Any, *, out: Numbers | None = None, **inputs: Any) -> Numbers:
        """C dq + g, (N, n) [N m], without friction."""
        return self._evaluate("bias_torque", (q, dq), out, inputs)

    def gravity_vector(self, q: Any, *, out: Numbers | None = None, **inputs: Any) -> Numbers:
        """g(q), (N, n) [N m]."""
        return self._evaluate("gravity_vector", (q,), out, inputs)

    def coriolis_matrix(self, q: Any, dq: Any, *, out: Numbers | None = None, **inputs: Any) -> Numbers:
        """C(q, dq), (N, n, n), in Christoffel form: dB/dt = C + C^T (Siciliano eqs. 7.44, 7.45)."""
        return self._evaluate("coriolis_matrix", (q, dq), out, inputs)

    def forward_dynamics(self, q: Any, dq: Any, tau: Any, *, out: Numbers | None = None, **inputs: Any) -> Numbers:
        """ddq (N, n) [rad/s^2]: B^-1 (tau - C dq - g - friction)."""
        return self._evaluate("forward_dynamics", (q, dq, tau), out, inputs)

    def flange_pose(self, q: Any, *, out: Numbers | None = None) -> Numbers:
        """Pose of the flange in the base, (N, 4, 4)."""
        return self._evaluate("flange_pose", (q,), out, {})

    def jacobian(self, q: Any, *, out: Numbers | None = None) -> Numbers:
        """Jacobian of the flange, (N, 6, n), linear rows over angular rows, base frame (Siciliano eq. 3.30)."""
        return self._evaluate("jacobian", (q,), out, {})

    def kinetic_energy(self, q: Any, dq: Any, *, out: Numbers | None = None, **inputs: Any) -> Numbers:
        """T = dq^T B dq / 2, (N,) [J]."""
        return self._evaluate("kinetic_energy", (q, dq), out, inputs)

    def potential_energy(self, q: Any, *, out: Numbers | None = None, **inputs: Any) -> Numbers:
        """U(q), (N,) [J]; only differences mean something."""
        return self._evaluate("potential_energy", (q,), out, inputs)

    def torque_regressor(self, q: Any, dq: Any, ddq: Any, *, out: Numbers | None = None, **inputs: Any) -> Numbers:
        """Y, (N, n, 10 n): the bodies' torque is Y pi with pi = `inertial_parameters(chain)` flat (eq. 7.83).

        Rotors and friction are not in it.
        """
        return self._evaluate("torque_regressor", (q, dq, ddq), out, inputs)

    def inverse_dynamics_derivatives(self, q: Any, dq: Any, ddq: Any, **inputs: Any) -> TorqueDerivatives:
        """d tau / d(q, dq, ddq)."""
        found = self._evaluate("inverse_dynamics_derivatives", (q, dq, ddq), None, inputs)
        return TorqueDerivatives(*np.moveaxis(found, 1, 0))

    def forward_dynamics_derivatives(self, q: Any, dq: Any, tau: Any, **inputs: Any) -> AccelerationDerivatives:
        """d ddq / d(q, dq, tau)."""
        found = self._evaluate("forward_dynamics_derivatives", (q, dq, tau), None, inputs)
        return AccelerationDerivatives(*np.moveaxis(found, 1, 0))

    def kernel(self, function: str) -> Kernel:
        """The compiled function of that name; raises `UnknownNameError` and `MissingPackageError`."""
        found = self._kernels.get(function)
        if found is None:
            found = self._kernels[function] = kernel_of(self.form, function)
        return found

    def _evaluate(self, function: str, states: tuple[Any, ...], out: Numbers | None, inputs: dict[str, Any]) -> Numbers:
        shape, form = function_shape(function), self.form
        rows, count = input_rows(form, function, dict(zip(shape.states, states, strict=True)), inputs)
        result = result_array(out, (count, *shape.result(form.n)), form.dtype, rows)
        if count:
            kernel = self.kernel(function)
            places = [address_and_step(row, count) for row in rows]
            if kernel.run(places, result.__array_interface__["data"][0], count, self.threads):
                self._again(kernel, function, rows, result)
        return result

    def _again(self, kernel: Kernel, function: str, rows: list[Numbers], result: Numbers) -> None:
        """NaN and a warning for the states that are not finite; those with very large angles once more, with less."""
        count = len(result)
        whole = [np.broadcast_to(row, (count, row.shape[1])) for row in rows]
        bad = ~np.logical_and.reduce([np.isfinite(row).all(axis=1) for row in whole])
        far = ~bad & (np.abs(whole[0]) > kernel.description.limit).any(axis=1)
        if far.any():
            few = [np.ascontiguousarray(row[far]) for row in whole]
            few[0] = nearer(self.form.chain, few[0])
            part = np.empty((len(few[0]), *result.shape[1:]), dtype=result.dtype)
            kernel.run(
                [address_and_step(row, len(part)) for row in few], part.__array_interface__["data"][0], len(part)
            )
            result[far] = part
        if bad.any():
            result[bad] = np.nan
            warnings.warn(NotFiniteWarning(function, np.flatnonzero(bad), count), stacklevel=4)


def batch_dynamics(
    arm: Arm,
    dtype: str = "float64",
    threads: int | None = 1,
    inputs: Iterable[str] = (),
    friction: str = "none",
    rotors: str = "armature",
) -> BatchDynamics:
    """An arm's dynamics over rows of states, by generated kernels.

    Parameters
    ----------
    arm : Arm
    dtype : {"float64", "float32"}
    threads : int or None
        None for all processors.
    inputs : names out of inertia, payload, gravity, friction
        What the kernels take as inputs instead of the arm's constants.
    friction : {"none", "arm"}
        "arm" adds the arm's friction (Coulomb and viscous per direction, offset) to inverse and takes it from forward
        dynamics.
    rotors : {"armature", "full", "none"}

    Raises
    ------
    OptionError
        A choice that does not exist, or the arm's friction has a Stribeck curve, which kernels do not know.
    MissingDataError
        The arm has no inertias.
    MissingPackageError
        The extra `batch` (numba, casadi) is not installed.
    """
    form = form_of(arm, inputs, friction, rotors, dtype)
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, int) or threads < 1):
        raise OptionError("threads", repr(threads), "a whole number above 0, or None for all processors")
    require_packages()
    return BatchDynamics(form, thread_count(threads))
