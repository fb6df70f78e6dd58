"""Operators on values. INT / INT is an INT, as in KRL; a result outside the range of INT or REAL is an error."""

import operator
from collections.abc import Callable
from typing import Any

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.names.types import GEOMETRY, LARGEST
from lwr_dyn.krl.running.values import ArrayValue, StructValue, Value, pose_matrix, pose_value, text_of, value_text


def unary_value(sign: str, value: Value) -> Value:
    """The value of an operator with one operand; raises `ExecutionError`."""
    if sign == "NOT":
        if isinstance(value, bool):
            return not value
    elif not isinstance(value, bool) and isinstance(value, int | float):
        if sign == "B_NOT":
            return ~int(value)
        return ranged(-value if sign == "-" else value)
    raise ExecutionError("type", f"{sign} on {value_text(value)}", "TRUE or FALSE" if sign == "NOT" else "a number")


def binary_value(sign: str, left: Value, right: Value) -> Value:
    """The value of an operator with two operands; raises `ExecutionError`."""
    if sign == ":":
        return _composed(left, right)
    if sign in _LOGIC:
        if not (isinstance(left, bool) and isinstance(right, bool)):
            message = f"{value_text(left)} {sign} {value_text(right)}"
            raise ExecutionError("type", message, "TRUE or FALSE on both sides")
        return bool(_LOGIC[sign](left, right))
    if sign in ("==", "<>"):
        return bool(_plain(left) == _plain(right)) == (sign == "==")
    return _arithmetic(sign, _plain(left), _plain(right))


def _plain(value: Value) -> Any:
    if isinstance(value, ArrayValue) and value.type == "CHAR":
        value = text_of(value)
    return ord(value) if isinstance(value, str) and len(value) == 1 else value


def _arithmetic(sign: str, left: Any, right: Any) -> Value:
    for side in (left, right):
        if isinstance(side, bool) or not isinstance(side, int | float):
            raise ExecutionError("type", f"{value_text(left)} {sign} {value_text(right)}", "numbers on both sides")
    if sign == "/":
        return _quotient(left, right)
    if sign in _BITS:
        return int(_BITS[sign](int(left), int(right)))
    result: int | float = _NUMBERS[sign](left, right)
    return result if isinstance(result, bool) else ranged(result)


def _quotient(left: int | float, right: int | float) -> Value:
    if right == 0:
        raise ExecutionError("division-by-zero", f"{left} / {right}", "test the divisor first")
    if isinstance(left, int) and isinstance(right, int):
        return ranged(abs(left) // abs(right) * (1 if (left < 0) == (right < 0) else -1))
    return ranged(left / right)


def ranged(value: int | float) -> int | float:
    """The number, if INT or REAL can hold it; raises `ExecutionError`."""
    least, most = (-LARGEST - 1, LARGEST) if isinstance(value, int) else (-3.5e38, 3.5e38)
    if not least <= value <= most:
        kind = "INT" if isinstance(value, int) else "REAL"
        raise ExecutionError("number-range", f"{value} is beyond what {kind} holds")
    return value


def _composed(left: Value, right: Value) -> Value:
    T = pose_matrix(left, "the left of :") @ pose_matrix(right, "the right of :")
    assert isinstance(right, StructValue)
    rest = {name: v for name, v in right.parts.items() if name not in GEOMETRY["FRAME"]}
    return pose_value(T, "FRAME" if right.type == "?" and not rest else right.type, rest)


_LOGIC: dict[str, Callable[[bool, bool], bool]] = {
    "AND": lambda a, b: a and b,
    "OR": lambda a, b: a or b,
    "EXOR": lambda a, b: a != b,
}
_BITS: dict[str, Callable[[int, int], int]] = {"B_AND": operator.and_, "B_OR": operator.or_, "B_EXOR": operator.xor}
_NUMBERS: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "<": operator.lt, ">": operator.gt, "<=": operator.le,
    ">=": operator.ge,
}  # fmt: skip
