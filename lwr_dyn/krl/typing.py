"""Types of expressions in a scope, with a diagnosis where they do not fit; unknown types fit everything."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lwr_dyn.krl import expressions as e
from lwr_dyn.krl.operand_types import binary_type, unary_type
from lwr_dyn.krl.scope import Scope, signature
from lwr_dyn.krl.types import BOOL, ENUMS, INT, LARGEST, REAL, STRUCTURES, UNKNOWN, Type, assignable


def type_in(scope: Scope, x: e.Expression) -> Type:
    """The type of an expression; what does not fit is said in `scope.found`."""
    return _TYPES[type(x)](scope, x)


def fits(scope: Scope, target: Type, x: e.Expression, what: str) -> None:
    """Say so when a value cannot go into `target`; an aggregate must name components that the target has."""
    if isinstance(x, e.Aggregate) and x.type is None and target.name != "?":
        _components(scope, x, target)
        return
    if isinstance(x, e.EnumConstant):
        _member(scope, x, target)
        return
    value = type_in(scope, x)
    if target.name == "CHAR" and value.name == "CHAR":
        return
    if not assignable(target, value):
        scope.say(x.column, "type", f"{what} is {target}, the value is {value}", f"a value of type {target}")


def _integer(scope: Scope, x: e.Integer) -> Type:
    if x.value > LARGEST and not (x.base != 10 and x.value <= 2 * LARGEST + 1):
        scope.say(x.column, "number-range", f"{x.value} is no INT", f"from {-LARGEST - 1} to {LARGEST}, or a REAL")
    return INT


def _real(scope: Scope, x: e.Real) -> Type:
    if abs(x.value) > 3.4e38:
        scope.say(x.column, "number-range", f"{x.value:g} is no REAL", "up to 3.4E38")
    return REAL


def _name(scope: Scope, x: e.Name) -> Type:
    found = scope.variable(x.name)
    if found is None:
        scope.say(x.column, "undeclared", f"{x.name} is not declared", scope.near(x.name))
        return UNKNOWN
    return found


def _index(scope: Scope, x: e.Index) -> Type:
    of = type_in(scope, x.of)
    for i in x.indices:
        if not assignable(INT, type_in(scope, i)):
            scope.say(i.column, "type", "an index must be INT", "a whole number from 1")
    if of.name == "?" or not x.indices:
        return of
    if of.dimensions == 0:
        scope.say(x.column, "no-array", "an index on what is no array", "declare it with brackets")
        return of
    if len(x.indices) != of.dimensions:
        said = f"{len(x.indices)} indices on an array of {of.dimensions}"
        scope.say(x.column, "no-array", said, f"{of.dimensions} indices")
    return of.element


def _component(scope: Scope, x: e.Component) -> Type:
    of = type_in(scope, x.of)
    if of.name == "?":
        return UNKNOWN
    known = scope.structure(of.name)
    found: Type | None = None if known is None or of.dimensions else known.get(x.name.upper())
    if found is None:
        allowed = ", ".join(known) if known and not of.dimensions else "a structure before the point"
        scope.say(x.column, "no-component", f"{of} has no component {x.name}", allowed)
        return UNKNOWN
    return found


def _call(scope: Scope, x: e.Call) -> Type:
    returned, fewest, most = signature(scope, x)
    given = len(x.arguments)
    for argument in x.arguments:
        if argument is not None:
            type_in(scope, argument)
    if not fewest <= given <= most:
        allowed = str(fewest) if fewest == most else f"{fewest} to {most}"
        scope.say(x.column, "arguments", f"{x.name} is given {given} arguments", f"it takes {allowed}")
    return UNKNOWN if returned is None else returned


def _aggregate(scope: Scope, x: e.Aggregate) -> Type:
    if x.type is not None:
        target = Type(x.type.upper())
        if not scope.is_type(target.name):
            scope.say(x.column, "unknown-type", f"{x.type} is no type", "a structure that is declared or built in")
            return UNKNOWN
        _components(scope, x, target)
        return target
    for item in x.items:
        type_in(scope, item.value)
    return shape_of(x)


def shape_of(x: e.Aggregate) -> Type:
    """The geometric type that has these components, else unknown.

    >>> str(shape_of(e.Aggregate((e.Item("X", e.Integer(1)), e.Item("S", e.Integer(2))))))
    'POS'
    """
    names = {item.name.upper() for item in x.items}
    for kind in ("FRAME", "POS", "E3POS", "E6POS", "AXIS", "E3AXIS", "E6AXIS"):
        if names <= set(STRUCTURES[kind]):
            return Type(kind)
    return UNKNOWN


def _components(scope: Scope, x: e.Aggregate, target: Type) -> None:
    known = scope.structure(target.name)
    if known is None or target.dimensions:
        if target.name != "?" and scope.is_type(target.name):
            scope.say(x.column, "type", f"a structure where {target} is expected", f"a value of type {target}")
        return
    seen: set[str] = set()
    for item in x.items:
        name = item.name.upper()
        if name not in known:
            scope.say(item.column, "no-component", f"{target} has no component {item.name}", ", ".join(known))
            type_in(scope, item.value)
        else:
            fits(scope, known[name].element if item.indices else known[name], item.value, f"component {item.name}")
        if name in seen and item.indices is None:
            scope.say(item.column, "duplicate-name", f"the component {item.name} is given twice", "remove one")
        seen.add(name)


def _member(scope: Scope, x: e.EnumConstant, target: Type) -> None:
    if target.name == "?":
        return
    members = scope.enum(target.name)
    if members is None:
        if target.name in ("INT", "REAL", "BOOL", "CHAR") or scope.structure(target.name) is not None:
            scope.say(x.column, "type", f"#{x.name} where {target} is expected", f"a value of type {target}")
    elif x.name.upper() not in members and target.name not in ENUMS:
        scope.say(x.column, "no-component", f"{target} has no constant #{x.name}", ", ".join(sorted(members)))


_TYPES: dict[type, Callable[[Scope, Any], Type]] = {
    e.Integer: _integer,
    e.Real: _real,
    e.Bool: lambda scope, x: BOOL,
    e.Text: lambda scope, x: Type("CHAR", 0 if len(x.value) == 1 else 1),
    e.EnumConstant: lambda scope, x: UNKNOWN,
    e.Name: _name,
    e.Index: _index,
    e.Component: _component,
    e.Call: _call,
    e.Aggregate: _aggregate,
    e.Unary: lambda scope, x: unary_type(scope, x, type_in(scope, x.operand)),
    e.Binary: lambda scope, x: binary_type(scope, x, type_in(scope, x.left), type_in(scope, x.right)),
}
