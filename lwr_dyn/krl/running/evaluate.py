"""Evaluation: expressions -> values, and references -> the variables, elements and components they name.

A SIGNAL names one input or output, or a group of them, which is a whole number.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.declarations import Signal
from lwr_dyn.krl.language.unparse import expression_text
from lwr_dyn.krl.names.known_names import BOOL, INT, LARGEST, REAL, Type
from lwr_dyn.krl.running import values as v
from lwr_dyn.krl.running.values import ArrayValue, EnumValue, StructValue, Value, Variable, VariableReference


class Environment(Protocol):
    """Looks up names and calls the program's functions."""

    def variable(self, name: str) -> Variable:
        """The variable; raises `ExecutionError`."""

    def element(self, name: str, index: tuple[int, ...]) -> Value | None:
        """An input set from outside (`$IN[3]`); None for an ordinary array; raises `ExecutionError` if not set."""

    def call(self, x: e.FunctionCall) -> Value:
        """The value a function returns; raises `ExecutionError`."""

    def signal_reference(self, name: str) -> VariableReference | None:
        """What a SIGNAL name stands for; None for another name; raises `ExecutionError`."""

    def note_read(self, name: str) -> None:
        """The program reads this variable, or a part of it."""

    def component_type(self, struct: str, name: str) -> Type:
        """The type of a component."""


def value_of(env: Environment, x: e.Expression) -> Value:
    """The value of an expression; raises `ExecutionError`."""
    return _VALUES[type(x)](env, x)


def number_of(env: Environment, x: e.Expression, what: str) -> float:
    """A finite number; raises `ExecutionError`."""
    value = value_of(env, x)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ExecutionError("type", f"{what} is {v.value_text(value)}", "a number")
    return float(value)


def truth_of(env: Environment, x: e.Expression, what: str) -> bool:
    """TRUE or FALSE; raises `ExecutionError`."""
    value = value_of(env, x)
    if not isinstance(value, bool):
        raise ExecutionError("type", f"{what} is {v.value_text(value)}", "TRUE or FALSE")
    return value


def reference_to(env: Environment, x: e.Reference) -> VariableReference:
    """The variable, element or component that a reference names; raises `ExecutionError`."""
    if isinstance(x, e.Name):
        signal = env.signal_reference(x.name)
        if signal is not None:
            return signal
        variable = env.variable(x.name)

        def write(value: Value) -> None:
            variable.value = _in_room(v.converted(value, variable.type), variable.value)

        return VariableReference(lambda: variable.value, write, variable.type)
    if isinstance(x, e.Index) and x.row:
        return v.row_reference(reference_to(env, x.of), _indices(env, x), expression_text(x))
    return element_reference(env, x) if isinstance(x, e.Index) else _component(env, x)


def _indices(env: Environment, x: e.Index | e.Item) -> tuple[int, ...]:
    return tuple(int(number_of(env, i, "an index")) for i in x.indices or ())


def _in_room(value: Value, before: Value | None) -> Value:
    """Text that is put into an array of characters keeps its size; raises `ExecutionError` where it is longer."""
    if not (isinstance(value, str) and isinstance(before, ArrayValue)):
        return value
    if before.sizes and len(value) > before.sizes[-1]:
        raise ExecutionError("index-range", f"a text of {len(value)} characters", f"at most {before.sizes[-1]}")
    return v.text_array(value, before.sizes)


def element_reference(env: Environment, x: e.Index) -> VariableReference:
    """The element, or the whole array without an index; raises `ExecutionError`."""
    of = reference_to(env, x.of)
    if not x.indices:
        return of
    at = _indices(env, x)

    def array() -> ArrayValue:
        value = of.read()
        if value is None:
            of.write(ArrayValue(of.type.name, ()))
        elif isinstance(value, str):
            of.write(v.text_array(value))
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
    return VariableReference(
        lambda: items().get(at), lambda value: items().update({at: v.converted(value, kind)}), kind
    )


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
        lambda: parts().get(name), lambda value: parts().update({name: v.converted(value, kind)}), kind
    )


def _read(env: Environment, x: e.Reference) -> Value:
    if isinstance(x, e.Index) and isinstance(x.of, e.Name) and x.indices:
        outside = env.element(x.of.name, _indices(env, x))
        if outside is not None:
            return outside
    value: Value | None = reference_to(env, x).read()
    env.note_read(e.root_name(x))
    if value is None:
        hint = "assign it first, or give it in the .dat"
        raise ExecutionError("no-value", f"{expression_text(x)} has no value", hint, e.root_name(x))
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
                array.items[at] = v.copied(value)
        else:
            out.parts[key] = v.copied(value) if isinstance(value, str) else v.converted(value, kind)
    return out


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
    e.Unary: lambda env, x: v.unary_value(x.operator, value_of(env, x.operand)),
    e.Binary: lambda env, x: v.binary_value(x.operator, value_of(env, x.left), value_of(env, x.right)),
}


def signal_reference(env: Environment, signal: Signal) -> VariableReference:
    """Reads and writes what a SIGNAL names; raises `ExecutionError`."""
    places = signal_places(signal)
    if signal.last is None:
        kind = REAL if places[0].of in (e.Name("$ANIN"), e.Name("$ANOUT")) else BOOL
        return VariableReference(
            lambda: value_of(env, places[0]), lambda value: element_reference(env, places[0]).write(value), kind
        )

    def read() -> Value:
        return sum(1 << i for i, place in enumerate(places) if value_of(env, place) is True)

    def write(value: Value) -> None:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ExecutionError("type", f"{signal.name} is a group of outputs", "a whole number")
        for i, place in enumerate(places):
            element_reference(env, place).write(bool(int(value) >> i & 1))

    return VariableReference(read, write, INT)


def signal_places(signal: Signal) -> list[e.Index]:
    """The inputs or outputs of a SIGNAL, the lowest first; raises `ExecutionError` for another form."""
    first, last = signal.first, signal.first if signal.last is None else signal.last
    if not (isinstance(first, e.Index) and isinstance(last, e.Index) and first.of == last.of):
        raise ExecutionError("type", f"the SIGNAL {signal.name}", "$IN[1] or $OUT[1] TO $OUT[8]")
    numbers = [x.indices[0] if x.indices else None for x in (first, last)]
    low, high = numbers
    if not (isinstance(low, e.Integer) and isinstance(high, e.Integer)) or high.value - low.value not in range(32):
        raise ExecutionError("index-range", f"the SIGNAL {signal.name}", "from 1 to 32 inputs or outputs")
    return [e.Index(first.of, (e.Integer(n),)) for n in range(low.value, high.value + 1)]
