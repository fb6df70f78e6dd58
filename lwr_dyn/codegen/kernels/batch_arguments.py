"""Checks the arguments of a batch and turns them into rows that a kernel can step through, if possible uncopied."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec
from lwr_dyn.codegen.kernels.parameters import parameter_shape
from lwr_dyn.codegen.kernels.result_form import ResultForm
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.dh import JointKind

Rows = NDArray[Any]


def input_rows(
    spec: KernelSpec, function: str, states: dict[str, Any], inputs: dict[str, Any]
) -> tuple[list[Rows], int]:
    """Joint vectors and inputs as arrays (N or 1, width), and N.

    Raises
    ------
    ShapeError
        Another number type, last axes that are not the arm's, different numbers of rows.
    OptionError
        An input is missing, or is not one of this batch.
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


def _rows(name: str, value: Any, shape: tuple[int, ...], dtype: str) -> tuple[Rows, bool]:
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
    flat = array.reshape(len(array), int(np.prod(shape)))
    size = flat.dtype.itemsize
    regular = flat.strides[1] == size and flat.strides[0] % size == 0 and flat.strides[0] >= flat.shape[1] * size
    in_place = (regular and flat.flags.aligned) or len(flat) == 0
    return (flat if in_place else np.ascontiguousarray(flat)), True


def address_and_step(row: Rows, count: int) -> tuple[int, int]:
    """The address of the first row and the step to the next, in numbers; 0 when one row is used for all."""
    step = 0 if len(row) == 1 and count > 1 else row.strides[0] // row.dtype.itemsize
    return int(row.__array_interface__["data"][0]), step


def result_array(out: Rows | None, form: ResultForm, count: int, rows: list[Rows]) -> Rows:
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


def wrap_angles(chain: Chain, q: Rows) -> Rows:
    """The same positions with every angle within +-pi."""
    turning = np.array([link.kind is JointKind.REVOLUTE for link in chain.links])
    exact = q.astype(np.float64)
    return np.where(turning, np.arctan2(np.sin(exact), np.cos(exact)), exact).astype(q.dtype)
