"""Expressions -> values. Angles of SIN, COS ... are degrees; a whole number divided by one stays whole, as in KRL."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from lwr_dyn.krl import expressions as e
from lwr_dyn.krl.types import STRUCTURES, Type
from lwr_dyn.krl.values import (
    LARGEST,
    Constant,
    HaltError,
    Many,
    Slot,
    Struct,
    Target,
    Value,
    converted,
    copied,
    pose_matrix,
    pose_value,
    said,
)


class Environment(Protocol):
    """Where names are looked up, and functions of the program are called."""

    def slot(self, name: str) -> Slot:
        """The variable; raises `HaltError`."""

    def element(self, name: str, index: tuple[int, ...]) -> Value | None:
        """An input that the world sets (`$IN[3]`), None for an ordinary variable; raises `HaltError` without one."""

    def call(self, x: e.Call) -> Value:
        """What a function returns; raises `HaltError`."""

    def component_type(self, struct: str, name: str) -> Type:
        """The type of a component."""


def value_of(env: Environment, x: e.Expression) -> Value:
    """The value of an expression; raises `HaltError`."""
    return _VALUES[type(x)](env, x)


def number_of(env: Environment, x: e.Expression, what: str) -> float:
    """A finite number; raises `HaltError`."""
    value = value_of(env, x)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise HaltError("type", f"{what} is {said(value)}", "a number")
    return float(value)


def truth_of(env: Environment, x: e.Expression, what: str) -> bool:
    """TRUE or FALSE; raises `HaltError`."""
    value = value_of(env, x)
    if not isinstance(value, bool):
        raise HaltError("type", f"{what} is {said(value)}", "TRUE or FALSE")
    return value


def target_of(env: Environment, x: e.Reference) -> Target:
    """The place that a reference names; raises `HaltError`."""
    if isinstance(x, e.Name):
        slot = env.slot(x.name)
        return Target(lambda: slot.value, lambda value: setattr(slot, "value", converted(value, slot.type)), slot.type)
    return _element(env, x) if isinstance(x, e.Index) else _component(env, x)


def _element(env: Environment, x: e.Index) -> Target:
    of = target_of(env, x.of)
    if not x.indices:
        return of
    at = tuple(int(number_of(env, i, "an index")) for i in x.indices)

    def array() -> Many:
        value = of.read()
        if value is None:
            value = Many(of.type.name, ())
            of.write(value)
            value = of.read()
        if isinstance(value, str):
            value = Many("CHAR", (), {(i + 1,): letter for i, letter in enumerate(value)})
            of.write(value)
            value = of.read()
        if not isinstance(value, Many):
            raise HaltError("no-array", f"{_text(x.of)} is no array", "declare it with brackets")
        return value

    def checked() -> Many:
        many = array()
        sizes = many.sizes or (LARGEST,) * len(at)
        if len(sizes) != len(at) or any(not 1 <= i <= size for i, size in zip(at, sizes, strict=False)):
            allowed = ", ".join(f"1 to {size}" for size in sizes)
            raise HaltError("index-range", f"the index {', '.join(map(str, at))} of {_text(x.of)}", allowed)
        return many

    element = of.type.element
    return Target(
        lambda: checked().items.get(at), lambda value: checked().items.update({at: converted(value, element)}), element
    )


def _component(env: Environment, x: e.Component) -> Target:
    of, name = target_of(env, x.of), x.name.upper()

    def whole() -> Struct:
        value = of.read()
        if value is None:
            of.write(Struct(of.type.name))
            value = of.read()
        if not isinstance(value, Struct):
            raise HaltError("no-component", f"{_text(x.of)} has no component {x.name}", "a structure")
        return value

    kind = env.component_type(of.type.name, name)
    return Target(
        lambda: whole().parts.get(name), lambda value: whole().parts.update({name: converted(value, kind)}), kind
    )


def _read(env: Environment, x: e.Reference) -> Value:
    if isinstance(x, e.Index) and isinstance(x.of, e.Name) and x.indices:
        at = tuple(int(number_of(env, i, "an index")) for i in x.indices)
        outside = env.element(x.of.name, at)
        if outside is not None:
            return outside
    value: Value | None = target_of(env, x).read()
    if value is None:
        raise HaltError("no-value", f"{_text(x)} has no value", "assign it first, or give it in the .dat")
    return value


def _text(x: e.Reference) -> str:
    from lwr_dyn.krl.emit import expression_text

    return expression_text(x)


def aggregate_value(env: Environment, x: e.Aggregate, type_name: str = "?") -> Struct:
    """A structure of the components that are given; those left out stay as they were."""
    name = type_name if x.type is None else x.type.upper()
    out = Struct(name)
    for item in x.items:
        key = item.name.upper()
        kind = env.component_type(name, key)
        value = value_of(env, item.value)
        if item.indices:
            at = tuple(int(number_of(env, i, "an index")) for i in item.indices)
            many = out.parts.setdefault(key, Many(kind.name, ()))
            if isinstance(many, Many):
                many.items[at] = copied(value)
        else:
            out.parts[key] = copied(value) if isinstance(value, str) else converted(value, kind)
    return out


def _unary(env: Environment, x: e.Unary) -> Value:
    value = value_of(env, x.operand)
    if x.operator == "NOT":
        if isinstance(value, bool):
            return not value
    elif not isinstance(value, bool) and isinstance(value, int | float):
        if x.operator == "B_NOT":
            return ~int(value)
        return _ranged(-value if x.operator == "-" else value)
    raise HaltError("type", f"{x.operator} on {said(value)}", "TRUE or FALSE" if x.operator == "NOT" else "a number")


def _binary(env: Environment, x: e.Binary) -> Value:
    left, right = value_of(env, x.left), value_of(env, x.right)
    if x.operator == ":":
        return _composed(left, right)
    if x.operator in _LOGIC:
        if not (isinstance(left, bool) and isinstance(right, bool)):
            raise HaltError("type", f"{said(left)} {x.operator} {said(right)}", "TRUE or FALSE on both sides")
        return bool(_LOGIC[x.operator](left, right))
    if x.operator in ("==", "<>"):
        return bool(_plain(left) == _plain(right)) == (x.operator == "==")
    return _arithmetic(x.operator, _plain(left), _plain(right))


def _plain(value: Value) -> Any:
    return ord(value) if isinstance(value, str) and len(value) == 1 else value


def _arithmetic(sign: str, left: Any, right: Any) -> Value:
    for side in (left, right):
        if isinstance(side, bool) or not isinstance(side, int | float):
            raise HaltError("type", f"{said(left)} {sign} {said(right)}", "numbers on both sides")
    if sign == "/":
        return _quotient(left, right)
    if sign in _BITS:
        return int(_BITS[sign](int(left), int(right)))
    result: int | float = _NUMBERS[sign](left, right)
    return result if isinstance(result, bool) else _ranged(result)


def _quotient(left: int | float, right: int | float) -> Value:
    if right == 0:
        raise HaltError("division-by-zero", f"{left} / {right}", "test the divisor first")
    if isinstance(left, int) and isinstance(right, int):
        return _ranged(abs(left) // abs(right) * (1 if (left < 0) == (right < 0) else -1))
    return _ranged(left / right)


def _ranged(value: int | float) -> int | float:
    largest = LARGEST + 1 if isinstance(value, int) else 3.5e38
    if not abs(value) <= largest:
        raise HaltError(
            "number-range", f"{value} is beyond what {'INT' if isinstance(value, int) else 'REAL'} holds", ""
        )
    return value


def _composed(left: Value, right: Value) -> Value:
    T = pose_matrix(left, "the left of :") @ pose_matrix(right, "the right of :")
    assert isinstance(right, Struct)
    rest = {name: v for name, v in right.parts.items() if name not in STRUCTURES["FRAME"]}
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
_VALUES: dict[type, Callable[[Environment, Any], Value]] = {
    e.Integer: lambda env, x: x.value - 2**32 if x.base != 10 and x.value > LARGEST else x.value,
    e.Real: lambda env, x: x.value,
    e.Bool: lambda env, x: x.value,
    e.Text: lambda env, x: x.value,
    e.EnumConstant: lambda env, x: Constant(x.name.upper()),
    e.Name: _read,
    e.Index: _read,
    e.Component: _read,
    e.Call: lambda env, x: env.call(x),
    e.Aggregate: aggregate_value,
    e.Unary: _unary,
    e.Binary: _binary,
}
MATHEMATICS: dict[str, Callable[..., float]] = {
    "SQRT": math.sqrt,
    "SIN": lambda x: math.sin(math.radians(x)),
    "COS": lambda x: math.cos(math.radians(x)),
    "TAN": lambda x: math.tan(math.radians(x)),
    "ACOS": lambda x: math.degrees(math.acos(x)),
    "ATAN2": lambda y, x: math.degrees(math.atan2(y, x)),
}


def function_value(env: Environment, x: e.Call) -> Value | None:
    """The value of a built-in function; None when there is none of that name here."""
    name = x.name.upper()
    arguments = [a for a in x.arguments if a is not None]
    if name == "ABS" and len(arguments) == 1:
        value = value_of(env, arguments[0])
        return abs(value) if isinstance(value, int | float) else number_of(env, arguments[0], "ABS")
    if name == "INV_POS" and len(arguments) == 1:
        return pose_value(
            np.asarray(np.linalg.inv(pose_matrix(value_of(env, arguments[0]), "INV_POS")), dtype=np.float64)
        )
    function = MATHEMATICS.get(name)
    if function is None:
        return None
    numbers = [number_of(env, a, f"an argument of {name}") for a in arguments]
    try:
        return _ranged(function(*numbers))
    except (ValueError, TypeError):
        hint = "from -1 to 1" if name == "ACOS" else "not negative" if name == "SQRT" else "the right arguments"
        raise HaltError("number-range", f"{name} of {', '.join(map(str, numbers))}", hint) from None
