"""Values of a running program (numbers, truth values, text, structures, arrays), their variables and their operators.

INT / INT is an INT, as in KRL; a result outside the range of INT or REAL is an error. A whole row of an array, `T[1,]`,
is read and written as an array of the indices that are left open.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.names.known_names import AXES, CARTESIAN, GEOMETRY, LARGEST, Type
from lwr_dyn.krl.robot.kuka_pose import KukaPose, pose_of_matrix

AXIS_NAMES = ("A1", "A2", "A3", "A4", "A5", "A6")
FARTHEST = 1e9
"""[mm, deg] A coordinate beyond this is no place, and its square need not be a float."""
POSE_NAMES = ("X", "Y", "Z", "A", "B", "C")


@dataclass(frozen=True, slots=True)
class EnumValue:
    """A value of an enumeration, its name in capitals."""

    name: str


@dataclass(slots=True)
class StructValue:
    """A structure: the name of its type ("?" if unknown) and the components that have a value."""

    type: str
    parts: dict[str, Value] = field(default_factory=dict)

    @property
    def is_axes(self) -> bool:
        """Whether it holds axis angles."""
        return self.type in AXES or (self.type == "?" and any(name in self.parts for name in AXIS_NAMES))

    @property
    def is_pose(self) -> bool:
        """Whether it holds a pose."""
        return self.type in CARTESIAN or (self.type == "?" and bool(self.parts) and not self.is_axes)


@dataclass(slots=True)
class ArrayValue:
    """An array: the type of its elements, its sizes (() if open), and the elements that have a value."""

    type: str
    sizes: tuple[int, ...]
    items: dict[tuple[int, ...], Value] = field(default_factory=dict)


Value: TypeAlias = "int | float | bool | str | EnumValue | StructValue | ArrayValue"


@dataclass(slots=True)
class Variable:
    """A variable of a running program; its value is None before the first assignment."""

    type: Type
    value: Value | None = None


@dataclass(frozen=True, slots=True)
class VariableReference:
    """Reads and writes a variable, an element of an array or a component of a structure."""

    read: Callable[[], Value | None]
    write: Callable[[Value], None]
    type: Type


def copied(value: Value) -> Value:
    """A deep copy."""
    if isinstance(value, StructValue):
        return StructValue(value.type, {k: copied(v) for k, v in value.parts.items()})
    if isinstance(value, ArrayValue):
        return ArrayValue(value.type, value.sizes, {k: copied(v) for k, v in value.items.items()})
    return value


def converted(value: Value, to: Type) -> Value:
    """A value converted to the type of a variable: REAL to INT rounds; raises `ExecutionError`."""
    if to.name == "?":
        return copied(value)
    if to.name in ("INT", "REAL") and not to.dimensions:
        return _number(value, to.name)
    if to.name == "BOOL" and not isinstance(value, bool) and not to.dimensions:
        raise ExecutionError("type", f"BOOL is given {value_text(value)}", "TRUE or FALSE")
    out = copied(value)
    if isinstance(out, StructValue) and not to.dimensions:
        out.type = to.name
    return out


def _number(value: Value, name: str) -> int | float:
    if isinstance(value, str) and len(value) == 1:
        value = ord(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ExecutionError("type", f"{name} is given {value_text(value)}", "a number")
    if not math.isfinite(value):
        raise ExecutionError("number-range", f"the value {value} is no number", "")
    if name == "REAL":
        return float(value)
    rounded = math.floor(value + 0.5)
    if abs(rounded) > LARGEST + 1:
        raise ExecutionError("number-range", f"{rounded} is no INT", f"from {-LARGEST - 1} to {LARGEST}")
    return rounded


def value_text(value: Value | None) -> str:
    """A value as text for a message."""
    if value is None:
        return "nothing"
    if isinstance(value, StructValue):
        return "{" + ", ".join(f"{k} {value_text(v)}" for k, v in value.parts.items()) + "}"
    if isinstance(value, EnumValue):
        return f"#{value.name}"
    if isinstance(value, ArrayValue):
        return f"an array of {value.type}"
    return str(value).upper() if isinstance(value, bool) else str(value)


def pose_matrix(value: Value | None, what: str) -> Array:
    """The pose (4, 4) [m] of X, Y, Z, A, B, C; raises `ExecutionError` where one is missing or beyond all places."""
    if not isinstance(value, StructValue) or not value.is_pose:
        raise ExecutionError("type", f"{what} is {value_text(value)}", "a FRAME, POS or E6POS")
    numbers = [value.parts.get(name) for name in POSE_NAMES]
    missing = [name for name, x in zip(POSE_NAMES, numbers, strict=True) if not isinstance(x, int | float)]
    if missing:
        raise ExecutionError("no-value", f"{what} has no {', '.join(missing)}", "a pose needs X, Y, Z, A, B, C")
    pose = [float(x) for x in numbers]  # type: ignore[arg-type]
    for name, x in zip(POSE_NAMES, pose, strict=True):
        if not abs(x) <= FARTHEST:
            raise ExecutionError("number-range", f"{name} {x:g} of {what}", f"at most {FARTHEST:g} mm or deg")
    return KukaPose(*pose).matrix()  # type: ignore[arg-type]


def speed_value(cp: float, ori: float) -> StructValue:
    """A value of `$VEL` or `$ACC` [m/s, deg/s and the same per s]."""
    return StructValue("CP", {"CP": cp, "ORI1": ori, "ORI2": ori})


def pose_value(T: Array, type_name: str = "FRAME", rest: Mapping[str, Value] | None = None) -> StructValue:
    """A pose (4, 4) [m] as a structure [mm, deg]; `rest` adds S, T and external axes."""
    p = pose_of_matrix(T)
    parts = dict(zip(POSE_NAMES, (p.x_mm, p.y_mm, p.z_mm, p.a_deg, p.b_deg, p.c_deg), strict=True))
    return StructValue(type_name, {**parts, **(rest or {})})


def axes_value(q: Array) -> StructValue:
    """Axes [rad] as a structure [deg], external axes at 0."""
    values = dict(zip(AXIS_NAMES, map(float, np.degrees(q)), strict=True))
    return StructValue("E6AXIS", {**values, **{f"E{i}": 0.0 for i in range(1, 7)}})


def reals(values: Iterable[float]) -> ArrayValue:
    """An array of REAL of one dimension."""
    items: dict[tuple[int, ...], Value] = {(i + 1,): v for i, v in enumerate(values)}
    return ArrayValue("REAL", (len(items),), items)


def text_array(text: str, sizes: tuple[int, ...] = ()) -> ArrayValue:
    """Text as an array of characters."""
    return ArrayValue("CHAR", sizes, {(i + 1,): letter for i, letter in enumerate(text)})


def text_of(value: Value) -> str:
    """Text from a constant or from an array of characters, up to the first one that has no value.

    >>> text_of(ArrayValue("CHAR", (4,), {(1,): "a", (2,): "b", (4,): "d"}))
    'ab'
    """
    if isinstance(value, str):
        return value
    if not isinstance(value, ArrayValue):
        raise ExecutionError("type", f"{value_text(value)} is no text", "an array of CHAR or a text in quotes")
    out = ""
    while isinstance(letter := value.items.get((len(out) + 1,)), str) and letter != "\0":
        out += letter
    return out


def null_frame() -> StructValue:
    """The frame with all components zero."""
    return StructValue("FRAME", dict.fromkeys(POSE_NAMES, 0.0))


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
