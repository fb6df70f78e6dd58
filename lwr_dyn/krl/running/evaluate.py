"""Evaluation: expressions -> values, and references -> the variables, elements and components they name."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from lwr_dyn.errors import OptionError
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.lexer import LineError
from lwr_dyn.krl.language.line_parser import parse_line
from lwr_dyn.krl.language.statements import Assign
from lwr_dyn.krl.language.unparse import expression_text
from lwr_dyn.krl.names.predefined import FUNCTIONS
from lwr_dyn.krl.names.types import LARGEST, UNKNOWN, Type
from lwr_dyn.krl.running.operators import binary_value, ranged, unary_value
from lwr_dyn.krl.running.values import (
    ArrayValue,
    EnumValue,
    StructValue,
    Value,
    Variable,
    VariableReference,
    converted,
    copied,
    pose_matrix,
    pose_value,
    value_text,
)


class Environment(Protocol):
    """Looks up names and calls the program's functions."""

    def variable(self, name: str) -> Variable:
        """The variable; raises `ExecutionError`."""

    def element(self, name: str, index: tuple[int, ...]) -> Value | None:
        """An input set from outside (`$IN[3]`); None for an ordinary array; raises `ExecutionError` if not set."""

    def call(self, x: e.FunctionCall) -> Value:
        """The value a function returns; raises `ExecutionError`."""

    def component_type(self, struct: str, name: str) -> Type:
        """The type of a component."""


def value_of(env: Environment, x: e.Expression) -> Value:
    """The value of an expression; raises `ExecutionError`."""
    return _VALUES[type(x)](env, x)


def number_of(env: Environment, x: e.Expression, what: str) -> float:
    """A finite number; raises `ExecutionError`."""
    value = value_of(env, x)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ExecutionError("type", f"{what} is {value_text(value)}", "a number")
    return float(value)


def truth_of(env: Environment, x: e.Expression, what: str) -> bool:
    """TRUE or FALSE; raises `ExecutionError`."""
    value = value_of(env, x)
    if not isinstance(value, bool):
        raise ExecutionError("type", f"{what} is {value_text(value)}", "TRUE or FALSE")
    return value


def reference_to(env: Environment, x: e.Reference) -> VariableReference:
    """The variable, element or component that a reference names; raises `ExecutionError`."""
    if isinstance(x, e.Name):
        variable = env.variable(x.name)

        def write(value: Value) -> None:
            variable.value = converted(value, variable.type)

        return VariableReference(lambda: variable.value, write, variable.type)
    return _element(env, x) if isinstance(x, e.Index) else _component(env, x)


def _indices(env: Environment, x: e.Index | e.Item) -> tuple[int, ...]:
    return tuple(int(number_of(env, i, "an index")) for i in x.indices or ())


def _element(env: Environment, x: e.Index) -> VariableReference:
    of = reference_to(env, x.of)
    if not x.indices:
        return of
    at = _indices(env, x)

    def array() -> ArrayValue:
        value = of.read()
        if value is None:
            of.write(ArrayValue(of.type.name, ()))
        elif isinstance(value, str):
            of.write(ArrayValue("CHAR", (), {(i + 1,): letter for i, letter in enumerate(value)}))
        value = of.read()
        if not isinstance(value, ArrayValue):
            raise ExecutionError("no-array", f"{expression_text(x.of)} is no array", "declare it with brackets")
        return value

    def items() -> dict[tuple[int, ...], Value]:
        value = array()
        sizes = value.sizes or (LARGEST,) * len(at)
        if len(sizes) != len(at) or any(not 1 <= i <= size for i, size in zip(at, sizes, strict=False)):
            allowed = ", ".join(f"1 to {size}" for size in sizes)
            message = f"the index {', '.join(map(str, at))} of {expression_text(x.of)}"
            raise ExecutionError("index-range", message, allowed)
        return value.items

    kind = of.type.element
    return VariableReference(lambda: items().get(at), lambda value: items().update({at: converted(value, kind)}), kind)


def _component(env: Environment, x: e.Component) -> VariableReference:
    of, name = reference_to(env, x.of), x.name.upper()

    def parts() -> dict[str, Value]:
        value = of.read()
        if value is None:
            of.write(StructValue(of.type.name))
            value = of.read()
        if not isinstance(value, StructValue):
            raise ExecutionError("no-component", f"{expression_text(x.of)} has no component {x.name}", "a structure")
        return value.parts

    kind = env.component_type(of.type.name, name)
    return VariableReference(
        lambda: parts().get(name), lambda value: parts().update({name: converted(value, kind)}), kind
    )


def _read(env: Environment, x: e.Reference) -> Value:
    if isinstance(x, e.Index) and isinstance(x.of, e.Name) and x.indices:
        outside = env.element(x.of.name, _indices(env, x))
        if outside is not None:
            return outside
    value: Value | None = reference_to(env, x).read()
    if value is None:
        hint = "assign it first, or give it in the .dat"
        raise ExecutionError("no-value", f"{expression_text(x)} has no value", hint)
    return value


def aggregate_value(env: Environment, x: e.Aggregate, type_name: str = "?") -> StructValue:
    """A structure of the components in the braces; raises `ExecutionError`."""
    name = type_name if x.type is None else x.type.upper()
    out = StructValue(name)
    for item in x.items:
        key = item.name.upper()
        kind = env.component_type(name, key)
        value = value_of(env, item.value)
        if item.indices:
            at = _indices(env, item)
            array = out.parts.setdefault(key, ArrayValue(kind.name, ()))
            if isinstance(array, ArrayValue):
                array.items[at] = copied(value)
        else:
            out.parts[key] = copied(value) if isinstance(value, str) else converted(value, kind)
    return out


def function_value(env: Environment, x: e.FunctionCall) -> Value | None:
    """The value of a predefined function; None where the model does not compute it; raises `ExecutionError`."""
    name = x.name.upper()
    arguments = [a for a in x.arguments if a is not None]
    if name == "ABS" and len(arguments) == 1:
        value = value_of(env, arguments[0])
        if isinstance(value, int | float) and not isinstance(value, bool):
            return ranged(abs(value))
        return abs(number_of(env, arguments[0], "ABS"))
    if name == "INV_POS" and len(arguments) == 1:
        inverse = np.linalg.inv(pose_matrix(value_of(env, arguments[0]), "INV_POS"))
        return pose_value(np.asarray(inverse, dtype=np.float64))
    compute = FUNCTIONS[name].compute if name in FUNCTIONS else None
    if compute is None:
        return None
    numbers = [number_of(env, a, f"an argument of {name}") for a in arguments]
    try:
        return ranged(compute(*numbers))
    except (ValueError, TypeError):
        hint = "from -1 to 1" if name == "ACOS" else "not negative" if name == "SQRT" else "the right arguments"
        raise ExecutionError("number-range", f"{name} of {', '.join(map(str, numbers))}", hint) from None


_VALUES: dict[type, Callable[[Environment, Any], Value]] = {
    e.Integer: lambda env, x: x.value - 2**32 if x.base != 10 and x.value > LARGEST else x.value,
    e.Real: lambda env, x: x.value,
    e.Bool: lambda env, x: x.value,
    e.Text: lambda env, x: x.value,
    e.EnumLiteral: lambda env, x: EnumValue(x.name.upper()),
    e.Name: _read,
    e.Index: _read,
    e.Component: _read,
    e.FunctionCall: lambda env, x: env.call(x),
    e.ChannelName: lambda env, x: f":{x.name}",
    e.Aggregate: aggregate_value,
    e.Unary: lambda env, x: unary_value(x.operator, value_of(env, x.operand)),
    e.Binary: lambda env, x: binary_value(x.operator, value_of(env, x.left), value_of(env, x.right)),
}


def input_values(texts: Sequence[str]) -> dict[str, Value]:
    """Inputs and variables set from outside, written as `$IN[3]=TRUE`: name -> value; raises `OptionError`.

    >>> input_values(["$IN[3]=TRUE", "n=2"])
    {'$IN[3]': True, 'N': 2}
    """
    return dict(_input_value(text) for text in texts)


def _input_value(text: str) -> tuple[str, Value]:
    name, _, _ = text.partition("=")
    try:
        statement, _ = parse_line(text)
        if not isinstance(statement, Assign):
            raise ExecutionError("syntax", text)
        return name.replace(" ", "").upper(), value_of(_NoNames(), statement.value)
    except (LineError, ExecutionError):
        raise OptionError("--set", repr(text), "NAME=VALUE with a constant, such as $IN[3]=TRUE") from None


class _NoNames:
    """An environment without names: only constants have a value."""

    def variable(self, name: str) -> Variable:
        raise ExecutionError("undeclared", name)

    def element(self, name: str, index: tuple[int, ...]) -> Value | None:
        raise ExecutionError("undeclared", name)

    def call(self, x: e.FunctionCall) -> Value:
        raise ExecutionError("undeclared", x.name)

    def component_type(self, struct: str, name: str) -> Type:
        return UNKNOWN
