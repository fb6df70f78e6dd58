"""Expressions -> values, references -> the places that hold them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol

from lwr_dyn.krl import expressions as e
from lwr_dyn.krl.emit import expression_text
from lwr_dyn.krl.operators import binary_value, unary_value
from lwr_dyn.krl.types import LARGEST, Type
from lwr_dyn.krl.values import Constant, HaltError, Many, Slot, Struct, Target, Value, converted, copied, said


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
            raise HaltError("no-array", f"{expression_text(x.of)} is no array", "declare it with brackets")
        return value

    def checked() -> Many:
        many = array()
        sizes = many.sizes or (LARGEST,) * len(at)
        if len(sizes) != len(at) or any(not 1 <= i <= size for i, size in zip(at, sizes, strict=False)):
            allowed = ", ".join(f"1 to {size}" for size in sizes)
            raise HaltError("index-range", f"the index {', '.join(map(str, at))} of {expression_text(x.of)}", allowed)
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
            raise HaltError("no-component", f"{expression_text(x.of)} has no component {x.name}", "a structure")
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
        raise HaltError("no-value", f"{expression_text(x)} has no value", "assign it first, or give it in the .dat")
    return value


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
    e.Unary: lambda env, x: unary_value(x.operator, value_of(env, x.operand)),
    e.Binary: lambda env, x: binary_value(x.operator, value_of(env, x.left), value_of(env, x.right)),
}
