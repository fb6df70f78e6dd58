"""A whole row of an array, `T[1,]`: read and written as an array of the indices that are left open."""

from __future__ import annotations

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.running.values import ArrayValue, Value, VariableReference, text_array, value_text


def row_reference(of: VariableReference, at: tuple[int, ...], name: str) -> VariableReference:
    """The row at the first indices `at`; reading or writing it raises `ExecutionError` where there is none."""

    def read() -> Value | None:
        whole = _whole(of, at, name)
        inside = {k[len(at) :]: v for k, v in whole.items.items() if k[: len(at)] == at}
        return ArrayValue(whole.type, whole.sizes[len(at) :], inside) if inside else None

    def write(value: Value) -> None:
        whole = _whole(of, at, name)
        row = _row(value, whole.sizes[-1] if whole.sizes else None, name)
        for k in [k for k in whole.items if k[: len(at)] == at]:
            del whole.items[k]
        whole.items.update({(*at, *k): v for k, v in row.items.items()})

    return VariableReference(read, write, of.type)


def _whole(of: VariableReference, at: tuple[int, ...], name: str) -> ArrayValue:
    """The array, which has such a row."""
    if of.read() is None:
        of.write(ArrayValue(of.type.name, ()))
    value = of.read()
    if not isinstance(value, ArrayValue):
        raise ExecutionError("no-array", f"{name} is no row of an array", "an array of two indices")
    if value.sizes and any(not 1 <= i <= size for i, size in zip(at, value.sizes, strict=False)):
        raise ExecutionError("index-range", f"the row {name}", ", ".join(f"1 to {size}" for size in value.sizes))
    return value


def _row(value: Value, longest: int | None, name: str) -> ArrayValue:
    row = text_array(value) if isinstance(value, str) else value
    if not isinstance(row, ArrayValue):
        raise ExecutionError("type", f"the row {name} is given {value_text(value)}", "a text, or an array")
    if longest is not None and any(k[-1] > longest for k in row.items):
        raise ExecutionError("index-range", f"the row {name} is given {len(row.items)} values", f"up to {longest}")
    return row
