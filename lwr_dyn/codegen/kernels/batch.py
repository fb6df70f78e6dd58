"""Batch dynamics: an arm's functions over rows of states, by compiled kernels.

Results are new arrays, or written to `out`. A state with a value that is not finite gives a row of NaN and a
`NotFiniteWarning` with its index; all other states are computed.
"""

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels.batch_arguments import address_and_step, input_rows, result_array, wrap_angles
from lwr_dyn.codegen.kernels.kernel import Kernel, kernel_of, require_packages, thread_count
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec, function_shape, kernel_spec
from lwr_dyn.codegen.kernels.result_form import MatrixEntries, ResultForm, matrix_entries
from lwr_dyn.foundation.arrays import arm_argument
from lwr_dyn.foundation.errors import OptionError
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

    The inputs of `batch_dynamics` are keywords here: inertia (n, 10), payload (10,), gravity (3,), friction (5, n); one
    set for all states, or N sets. Every method raises `ShapeError` (shape or number type) and `OptionError` (an input
    missing, or not one of this batch). Kernels are compiled when they are first used.
    """

    spec: KernelSpec
    threads: int = 1
    _kernels: dict[str, Kernel] = field(default_factory=dict, repr=False)

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.spec.n

    @property
    def dtype(self) -> str:
        """Number type of arguments and results."""
        return self.spec.dtype

    def inverse_dynamics(self, q: Any, dq: Any, ddq: Any, *, out: Numbers | None = None, **inputs: Any) -> Numbers:
        """tau (N, n) [N m]: B ddq + C dq + g, plus friction where the batch has it."""
        return self._evaluate("inverse_dynamics", (q, dq, ddq), out, inputs)

    def mass_matrix(self, q: Any, *, out: Numbers | None = None, **inputs: Any) -> Numbers:
        """B(q), (N, n, n) [kg m^2], with rotors as chosen."""
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

        Without rotors and friction.
        """
        return self._evaluate("torque_regressor", (q, dq, ddq), out, inputs)

    def inverse_dynamics_derivatives(self, q: Any, dq: Any, ddq: Any, **inputs: Any) -> TorqueDerivatives:
        """d tau / d(q, dq, ddq)."""
        derivatives = self._evaluate("inverse_dynamics_derivatives", (q, dq, ddq), None, inputs)
        return TorqueDerivatives(*np.moveaxis(derivatives, 1, 0))

    def forward_dynamics_derivatives(self, q: Any, dq: Any, tau: Any, **inputs: Any) -> AccelerationDerivatives:
        """d ddq / d(q, dq, tau)."""
        derivatives = self._evaluate("forward_dynamics_derivatives", (q, dq, tau), None, inputs)
        return AccelerationDerivatives(*np.moveaxis(derivatives, 1, 0))

    def kernel(self, function: str) -> Kernel:
        """The compiled function of that name; raises `UnknownNameError` and `MissingPackageError`."""
        if function not in self._kernels:
            self._kernels[function] = kernel_of(self.spec, function)
        return self._kernels[function]

    def form(self, function: str) -> ResultForm:
        """How its results lie in memory: `form(f).empty(N)` is what `out` takes, `states_first` reads blocks."""
        spec = self.spec
        is_compact, lanes = spec.structure == "compact", 1
        if is_compact and function.endswith("_derivatives"):
            raise OptionError("structure", f"'compact' for {function}", "'dense'")
        if is_compact or spec.layout != "rows":
            lanes = self.kernel(function).interface.lanes
        shape = (self.kernel(function).interface.width,) if is_compact else function_shape(function).result(spec.n)
        return ResultForm(spec.layout, shape, lanes, spec.dtype)

    def entries(self, function: str) -> MatrixEntries:
        """Which stored value every entry of a result is, with structure="compact"; raises `OptionError` without."""
        if self.spec.structure != "compact":
            raise OptionError("entries", "of a dense batch", "structure='compact'")
        known = self.kernel(function).interface
        return matrix_entries(known.entries, known.constants, function_shape(function).result(self.spec.n))

    def _evaluate(self, function: str, states: tuple[Any, ...], out: Numbers | None, inputs: dict[str, Any]) -> Numbers:
        shape, spec = function_shape(function), self.spec
        rows, count = input_rows(spec, function, dict(zip(shape.states, states, strict=True)), inputs)
        form = self.form(function)
        result = result_array(out, form, count, rows)
        if count:
            kernel = self.kernel(function)
            places = [address_and_step(row, count) for row in rows]
            if kernel.run(places, result.__array_interface__["data"][0], count, self.threads):
                self._repair(kernel, function, rows, result, form)
        return result

    def _repair(self, kernel: Kernel, function: str, rows: list[Numbers], result: Numbers, form: ResultForm) -> None:
        """NaN and a warning for states that are not finite; very large angles are wrapped and computed again."""
        count = max(len(row) for row in rows)
        whole = [np.broadcast_to(row, (count, row.shape[1])) for row in rows]
        bad = ~np.logical_and.reduce([np.isfinite(row).all(axis=1) for row in whole])
        far = ~bad & (np.abs(whole[0]) > kernel.interface.limit).any(axis=1)
        if far.any():
            wrapped = [np.ascontiguousarray(row[far]) for row in whole]
            wrapped[0] = wrap_angles(self.spec.chain, wrapped[0])
            some = len(wrapped[0])
            part = form.empty(some)
            kernel.run([address_and_step(row, some) for row in wrapped], part.__array_interface__["data"][0], some)
            result[form.place_of(np.flatnonzero(far))] = part[form.place_of(np.arange(some))]
        if bad.any():
            result[form.place_of(np.flatnonzero(bad))] = np.nan
            warnings.warn(NotFiniteWarning(function, np.flatnonzero(bad), count), stacklevel=4)


def batch_dynamics(
    arm: Arm,
    dtype: str = "float64",
    threads: int | None = 1,
    inputs: Iterable[str] = (),
    friction: str = "none",
    rotors: str = "armature",
    layout: str = "rows",
    structure: str = "dense",
) -> BatchDynamics:
    """An arm's dynamics over rows of states, by generated kernels.

    Parameters
    ----------
    arm : Arm
    dtype : {"float64", "float32"}
    threads : int or None
        None for all processors.
    inputs : names out of inertia, payload, gravity, friction
        The quantities that kernels take as inputs instead of the arm's constants.
    friction : {"none", "arm"}
        "arm" adds the arm's friction (Coulomb and viscous per direction, offset) to inverse and subtracts it in
        forward dynamics.
    rotors : {"armature", "full", "none"}
    layout : {"rows", "padded", "blocks"}
        "padded" begins every result on a whole vector; "blocks" gives (blocks, *shape, W): W states side by side.
    structure : {"dense", "compact"}
        "compact" stores the distinct values of a matrix once, constants never: (N, count), read by `entries`.

    Raises
    ------
    OptionError
        A choice that does not exist, or the arm's friction has a Stribeck curve, which kernels do not support.
    MissingDataError
        The arm has no inertias.
    MissingPackageError
        The extra `batch` (numba, casadi) is not installed.
    """
    spec = kernel_spec(arm_argument(arm), inputs, friction, rotors, dtype, layout, structure)
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, int) or threads < 1):
        raise OptionError("threads", repr(threads), "a whole number above 0, or None for all processors")
    require_packages()
    return BatchDynamics(spec, thread_count(threads))
