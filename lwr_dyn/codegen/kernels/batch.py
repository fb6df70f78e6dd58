"""Batch dynamics: an arm's functions over rows of states, by compiled kernels.

Arguments become rows that a kernel can step through, if possible uncopied. Results are new arrays, or written to `out`.
A state with a value that is not finite gives a row of NaN and a `NotFiniteWarning` with its index; all other states are
computed.
"""

import os
import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels.kernel import Kernel, kernel_of, require_packages
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec, function_shape, kernel_spec, parameter_shape
from lwr_dyn.codegen.kernels.result_form import MatrixEntries, ResultForm, matrix_entries
from lwr_dyn.foundation.arrays import arm_argument
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain

Numbers = NDArray[Any]
"""An array of the batch's number type."""


def input_rows(
    spec: KernelSpec, function: str, states: dict[str, Any], inputs: dict[str, Any]
) -> tuple[list[Numbers], int]:
    """Joint vectors and inputs as arrays (N or 1, width), and N.

    Raises `ShapeError`: another number type, last axes that are not the arm's, different numbers of rows;
    `OptionError`: an input is missing, or is not one of this batch.
    """
    wanted = spec.parameters_of(function)
    for name in inputs.keys() - set(wanted):
        raise OptionError(name, f"given to {function}", f"inputs of this family: {', '.join(wanted) or 'none'}")
    for name in wanted:
        if name not in inputs:
            raise OptionError(name, "missing", f"one set for all states or one for each, to {function}")
    rows = {name: _rows(name, value, (spec.n,), spec.dtype) for name, value in states.items()}
    rows |= {name: _rows(name, inputs[name], parameter_shape(name, spec.n), spec.dtype) for name in wanted}
    counts = {len(row) for row, whole in rows.values() if whole}
    if len(counts - {1}) > 1:
        lengths = ", ".join(f"{name} {len(row)}" for name, (row, whole) in rows.items() if whole)
        raise ShapeError(", ".join(rows), f"rows: {lengths}", "one number of rows")
    count = max(counts - {1}, default=1) if counts != {0} else 0
    return [row for row, _ in rows.values()], count


def _rows(name: str, value: Any, shape: tuple[int, ...], dtype: str) -> tuple[Numbers, bool]:
    """The array as (N, width), and whether it has an axis of rows."""
    try:
        array = np.asarray(value)
    except ValueError:
        raise ShapeError(name, "not an array of numbers", f"{dtype} numbers") from None
    if array.dtype != dtype:
        raise ShapeError(name, f"number type {array.dtype}", f"{dtype}, as this batch was made (astype converts)")
    if array.shape == shape:
        return array.reshape(1, -1), False
    if array.ndim != len(shape) + 1 or array.shape[1:] != shape:
        each = ", ".join(map(str, shape))
        one = f"({each},)" if len(shape) == 1 else f"({each})"
        raise ShapeError(name, f"shape {array.shape}", f"(N, {each}) or {one}")
    flat = array.reshape(len(array), prod(shape))
    size = flat.dtype.itemsize
    regular = flat.strides[1] == size and flat.strides[0] % size == 0 and flat.strides[0] >= flat.shape[1] * size
    in_place = (regular and flat.flags.aligned) or len(flat) == 0
    return (flat if in_place else np.ascontiguousarray(flat)), True


def address_and_step(row: Numbers, count: int) -> tuple[int, int]:
    """The address of the first row and the step to the next, in numbers; 0 when one row is used for all."""
    step = 0 if len(row) == 1 and count > 1 else row.strides[0] // row.dtype.itemsize
    return int(row.__array_interface__["data"][0]), step


def result_array(out: Numbers | None, form: ResultForm, count: int, rows: list[Numbers]) -> Numbers:
    """A new array for that many states, or `out` if it fits; raises `ShapeError`."""
    if out is None:
        return form.empty(count)
    shape, dtype = form.shape_of(count), form.dtype
    if not isinstance(out, np.ndarray) or out.shape != shape or out.dtype != dtype:
        kind = f"shape {out.shape}, {out.dtype}" if isinstance(out, np.ndarray) else "not an array"
        raise ShapeError("out", kind, f"an array of shape {shape}, {dtype}")
    if not (form.holds(out) and out.flags.writeable and out.flags.aligned):
        maker = "numpy.empty" if form.layout == "rows" else "the batch's empty"
        raise ShapeError("out", "not contiguous, aligned and writeable", f"an array as {maker} makes it")
    if any(np.may_share_memory(out, row) for row in rows):
        raise ShapeError("out", "lies over an input", "memory of its own")
    return out


def wrap_angles(chain: Chain, q: Numbers) -> Numbers:
    """The same positions with every angle within +-pi."""
    exact = q.astype(np.float64)
    return np.where(chain.turning, np.arctan2(np.sin(exact), np.cos(exact)), exact).astype(q.dtype)


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

    def __reduce__(self) -> tuple[type["BatchDynamics"], tuple[KernelSpec, int]]:
        return BatchDynamics, (self.spec, self.threads)

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
        "padded" begins every result on a whole vector; "blocks" gives `(blocks, ..., W)`: W states side by side.
    structure : {"dense", "compact"}
        "compact" stores the distinct values of a matrix once, constants never: (N, count), read by `entries`.

    Raises
    ------
    OptionError
        A choice that does not exist, or the arm's friction has a Stribeck curve, which kernels do not support.
    MissingDataError
        The arm has no inertias.
    MissingPackageError
        The extra `batch` (llvmlite, CasADi, mpmath) is not installed.
    """
    spec = kernel_spec(arm_argument(arm), inputs, friction, rotors, dtype, layout, structure)
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, int) or threads < 1):
        raise OptionError("threads", repr(threads), "a whole number above 0, or None for all processors")
    require_packages()
    return BatchDynamics(spec, (os.cpu_count() or 1) if threads is None else threads)
