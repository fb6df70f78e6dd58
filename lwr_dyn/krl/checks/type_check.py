"""An expression where it stands: its type, those of a call's arguments, and the `#NAME` of no ENUM.

An unknown type fits every type.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import replace
from typing import Any

from lwr_dyn.krl.checks.constant_values import check_indices, check_value
from lwr_dyn.krl.checks.system_names import check_system_name
from lwr_dyn.krl.checks.written_places import check_written
from lwr_dyn.krl.diagnostics import Severity
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.blocks import DECLARATIONS, Routine
from lwr_dyn.krl.language.declarations import Declaration
from lwr_dyn.krl.names import known_names as k
from lwr_dyn.krl.names.known_names import BOOL, INT, REAL, UNKNOWN, FunctionParameter, Type
from lwr_dyn.krl.project.program import Scope, near_name, signature, slip_of
from lwr_dyn.krl.project.project import type_of

KERNEL = "KSS"
"""The package of the controller's own functions."""


def check_types(scope: Scope, x: e.FunctionCall, given: Sequence[Type]) -> None:
    """Report arguments that do not fit the parameter; `given` are the types of the arguments.

    A warning for functions of option packages: their signatures are known from use only.
    """
    key = x.name.upper()
    origin = scope.known.origins.get(key)
    severity: Severity = "error"
    routine, external = scope.program.routine(x.name), scope.external(x.name)
    if routine is not None:
        taken = taken_by(routine)
    elif external is not None:
        taken = tuple(_declared(i, text) for i, text in enumerate(external.parameters))
    elif key in scope.known.functions:
        taken = scope.known.functions[key].parameters
        severity = "error" if origin is not None and origin.package == KERNEL else "warning"
    else:
        taken = ()
    rest = [FunctionParameter("", UNKNOWN)] * (len(x.arguments) - len(taken))
    for parameter, argument, kind in zip((*taken, *rest), x.arguments, given, strict=False):
        if argument is not None:
            if routine is not None and isinstance(argument, e.Text):
                parameter = replace(parameter, mode="IN")  # programs hand over texts for OUT
            _check(scope, x.name, parameter, argument, kind, severity)


def _check(
    scope: Scope, name: str, parameter: FunctionParameter, argument: e.Expression, kind: Type, severity: Severity
) -> None:
    taken = scope.type_seen(parameter.type)
    own = scope.program.routine(name) is not None
    constant = parameter.mode == "OUT" and not isinstance(argument, e.Name | e.Index | e.Component)
    message = f"{parameter.name} of {name} is OUT, the argument is no variable"
    if constant and not own:
        scope.report(argument.column, "arguments", message, f"a variable of type {taken}", severity)
        return
    if parameter.mode == "OUT" and not own:
        check_written(scope, argument)  # a subprogram with OUT may be given an input that it only reads
    if isinstance(argument, e.EnumLiteral):
        _check_constant(scope, argument, taken)
    elif not _fits(taken, kind):
        wrong = f"{parameter.name} of {name} is {taken}, the argument is {kind}"
        scope.report(argument.column, "type", wrong, f"a value of type {taken}", severity)
        return
    if constant:
        # a warning: public programs hand constants over to subprograms that only read them
        hint = f"a variable of type {taken}, or {parameter.name}:IN"
        scope.report(argument.column, "arguments", message, hint, "warning")


def taken_by(routine: Routine) -> tuple[FunctionParameter, ...]:
    """The parameters of a routine with the types that its first lines declare.

    Those without a mode count as IN.
    """
    kinds: dict[str, Type] = {}
    for _, x in routine.lines():
        if not isinstance(x, DECLARATIONS):
            break
        if isinstance(x, Declaration):
            kinds |= {d.name.upper(): type_of(x.type, d) for d in x.names}
    parameters = routine.head.parameters
    return tuple(FunctionParameter(p.name, kinds.get(p.name.upper(), UNKNOWN), p.mode or "IN") for p in parameters)


def _declared(i: int, text: str) -> FunctionParameter:
    """A parameter as EXT declares it: `CHAR[]:OUT`, or with a name, `CHAR TEXT[]:OUT`."""
    kind, _, brackets = text.partition(":")[0].partition("[")
    return FunctionParameter(f"argument {i + 1}", Type(kind.split()[0].upper(), brackets.count(",") + bool(brackets)))


def _fits(taken: Type, given: Type) -> bool:
    """Whether an argument may be handed over: text of any length, numbers for numbers."""
    if "?" in (taken.name, given.name) or taken.name == given.name == "CHAR":
        return True
    if taken.name in k.NUMBERS and given.name in k.NUMBERS:
        return taken.dimensions == given.dimensions
    return taken.accepts(given)


_BRACKETS = "; comparisons bind weaker than AND and OR: put each in brackets"


def type_in(scope: Scope, x: e.Expression) -> Type:
    """The type of an expression; its type errors are reported in the scope."""
    return _TYPES[type(x)](scope, x)


def check_assignable(scope: Scope, target: Type, x: e.Expression, what: str) -> None:
    """Report a value that cannot be assigned to `target`, and components that `target` does not have."""
    if isinstance(x, e.Aggregate) and x.type is None and target.name != "?":
        _check_components(scope, x, target)
        return
    if isinstance(x, e.EnumLiteral):
        _check_constant(scope, x, target)
        return
    value = type_in(scope, x)
    if target.name == "CHAR" and value.name == "CHAR":
        return
    if not target.accepts(value):
        scope.report(x.column, "type", f"{what} is {target}, the value is {value}", f"a value of type {target}")


def shape_of(x: e.Aggregate) -> Type:
    """The first geometric type that has these components, else unknown.

    >>> str(shape_of(e.Aggregate((e.Item("X", e.Integer(1)), e.Item("S", e.Integer(2))))))
    'POS'
    """
    names = {item.name.upper() for item in x.items}
    return next((Type(kind) for kind, parts in k.GEOMETRY.items() if names <= parts.keys()), UNKNOWN)


def _integer(scope: Scope, x: e.Integer) -> Type:
    if x.value > k.LARGEST and not (x.base != 10 and x.value <= 2 * k.LARGEST + 1):
        scope.report(
            x.column, "number-range", f"{x.value} is no INT", f"from {-k.LARGEST - 1} to {k.LARGEST}, or a REAL"
        )
    return INT


def _real(scope: Scope, x: e.Real) -> Type:
    if abs(x.value) > 3.4e38:
        scope.report(x.column, "number-range", f"{x.value:g} is no REAL", "up to 3.4E38")
    return REAL


def _name(scope: Scope, x: e.Name) -> Type:
    kind = scope.variable(x.name)
    if kind is None:
        scope.report_variable(x.column, x.name)
        return UNKNOWN
    check_system_name(scope, x)
    return kind


def _index(scope: Scope, x: e.Index) -> Type:
    of = type_in(scope, x.of)
    for i in x.indices:
        if not INT.accepts(type_in(scope, i)):
            scope.report(i.column, "type", "an index must be INT", "a whole number from 1")
    check_indices(scope, of, x)
    if of.name == "?" or not x.indices:
        return of
    if of.dimensions == 0:
        scope.report(x.column, "no-array", "an index on what is no array", "declare it with brackets")
        return of
    if len(x.indices) + x.row != of.dimensions:
        message = f"{len(x.indices) + x.row} indices on an array of {of.dimensions}"
        scope.report(x.column, "no-array", message, f"{of.dimensions} indices")
    if x.row:
        return Type(of.name, 1)
    return of.element


def _component(scope: Scope, x: e.Component) -> Type:
    of = type_in(scope, x.of)
    if of.name == "?" or not scope.is_type(of.name):  # a type that nothing declares is told where it is named
        return UNKNOWN
    components = None if of.dimensions else scope.structure(of.name)
    kind = None if components is None else components.get(x.name.upper())
    if kind is None:
        _report_component(scope, x.column, of, x.name, components)
        return UNKNOWN
    return scope.type_seen(kind)


def _report_component(scope: Scope, column: int, of: Type, name: str, components: Mapping[str, Type] | None) -> None:
    """A component that a structure does not have: a warning for KUKA's own, which differ between versions of KSS.

    Of a structure whose components are not all listed, only one that is a slip away from a listed one.
    """
    near = slip_of(name, components) if components else None
    if components is not None and scope.is_open(of.name) and near is None:
        return
    listed = ", ".join(components) if components else "a structure before the point"
    allowed = f"did you mean {near}?" if near else listed
    severity: Severity = "warning" if components and scope.is_foreign(of.name) else "error"
    scope.report(column, "no-component", f"{of} has no component {name}", allowed, severity)


def _call(scope: Scope, x: e.FunctionCall) -> Type:
    returned, least, most = signature(scope, x)
    count = len(x.arguments)
    given = [UNKNOWN if argument is None else type_in(scope, argument) for argument in x.arguments]
    check_types(scope, x, given)
    if x.name.upper() == "BAS" and count == 2 and isinstance(x.arguments[0], e.EnumLiteral):
        check_value(scope, f"BAS.{x.arguments[0].name.upper()}", x.arguments[1])
    elif x.arguments:
        check_value(scope, f"{x.name.upper()}.1", x.arguments[0])
    if not least <= count <= most:
        allowed = str(least) if least == most else f"{least} to {most}"
        scope.report(x.column, "arguments", f"{x.name} is given {count} arguments", f"it takes {allowed}")
    return UNKNOWN if returned is None else returned


def _aggregate(scope: Scope, x: e.Aggregate) -> Type:
    if x.type is not None:
        target = Type(x.type.upper())
        if not scope.is_type(target.name):
            scope.report(x.column, "unknown-type", f"{x.type} is no type", "a structure that is declared or built in")
            return UNKNOWN
        _check_components(scope, x, target)
        return target
    for item in x.items:
        type_in(scope, item.value)
    return shape_of(x)


def _check_components(scope: Scope, x: e.Aggregate, target: Type) -> None:
    components = scope.structure(target.name)
    if components is None or target.dimensions:
        if target.name != "?" and scope.is_type(target.name):
            scope.report(x.column, "type", f"a structure where {target} is expected", f"a value of type {target}")
        return
    check_value(scope, target.name, x)
    seen: set[str] = set()
    for item in x.items:
        name = item.name.upper()
        if name not in components:
            _report_component(scope, item.column, target, item.name, components)
            type_in(scope, item.value)
        else:
            kind = components[name].element if item.indices else components[name]
            check_assignable(scope, kind, item.value, f"component {item.name}")
        if name in seen and item.indices is None:
            scope.report(item.column, "duplicate-name", f"the component {item.name} is given twice", "remove one")
        seen.add(name)


def _unary(scope: Scope, x: e.Unary) -> Type:
    of = type_in(scope, x.operand)
    wanted = {"NOT": {"BOOL"}, "B_NOT": {"INT", "CHAR"}}.get(x.operator, k.NUMBERS)
    return _checked(scope, x, of, of, wanted)


def _binary(scope: Scope, x: e.Binary) -> Type:
    left, right = type_in(scope, x.left), type_in(scope, x.right)
    if x.operator == ":":
        _checked(scope, x, left, right, set(k.CARTESIAN))
        return right
    if x.operator in ("AND", "OR", "EXOR"):
        return _checked(scope, x, left, right, {"BOOL"}, BOOL)
    if x.operator.startswith("B_"):
        return _checked(scope, x, left, right, {"INT", "CHAR"}, INT)
    if x.operator in ("+", "-", "*", "/"):
        result = INT if left.name == right.name == "INT" else REAL
        return _checked(scope, x, left, right, k.NUMBERS, result)
    return _comparison(scope, x, left, right)


def _comparison(scope: Scope, x: e.Binary, left: Type, right: Type) -> Type:
    ordered = x.operator not in ("==", "<>")
    check_compared(scope, x.left, left, x.right, right)
    if not left.accepts(right) or (ordered and left.name not in (k.NUMBERS | {"?"})):
        hint = "numbers" if ordered else "two values of one type"
        if "BOOL" in (left.name, right.name):
            hint += _BRACKETS
        scope.report(x.column, "type", f"{left} {x.operator} {right} has no meaning", hint)
    return BOOL


def _checked(
    scope: Scope, x: e.Unary | e.Binary, left: Type, right: Type, wanted: Set[str], result: Type | None = None
) -> Type:
    """The type of the result; reports the first operand whose type is not wanted."""
    for side in (left, right):
        if side.name not in wanted and side.name != "?":
            hint = f"{' or '.join(sorted(wanted))} on both sides" if isinstance(x, e.Binary) else "another operator"
            if wanted == {"BOOL"} and side.name in k.NUMBERS:
                hint += _BRACKETS
            scope.report(x.column, "type", f"{x.operator} on {side}", hint)
            return result or UNKNOWN
    return result or left


_TYPES: dict[type, Callable[[Scope, Any], Type]] = {
    e.Integer: _integer,
    e.Real: _real,
    e.Bool: lambda scope, x: BOOL,
    e.Text: lambda scope, x: Type("CHAR", 0 if len(x.value) == 1 else 1),
    e.EnumLiteral: lambda scope, x: UNKNOWN,
    e.Name: _name,
    e.Index: _index,
    e.Component: _component,
    e.FunctionCall: _call,
    e.ChannelName: lambda scope, x: UNKNOWN,
    e.Aggregate: _aggregate,
    e.Unary: _unary,
    e.Binary: _binary,
}


def _check_constant(scope: Scope, x: e.EnumLiteral, target: Type) -> None:
    """Report a constant where none is expected, or one that its enumeration does not have.

    A warning for KUKA's own enumerations: their constants differ between versions of KSS.
    """
    if target.name == "?":
        _check_anywhere(scope, x)
        return
    members = scope.enum(target.name)
    if members is None:
        if target.name in k.SIMPLE or scope.structure(target.name) is not None:
            scope.report(x.column, "type", f"#{x.name} where {target} is expected", f"a value of type {target}")
    elif x.name.upper() not in members:
        is_open = scope.is_open(target.name)
        near = slip_of(x.name, sorted(members)) if is_open else near_name(x.name, members)
        if near is None and is_open:
            return
        hint = ", ".join(sorted(members)) if near is None else f"did you mean #{near}?"
        message = f"{target} has no constant #{x.name}"
        scope.report(x.column, "no-constant", message, hint, "warning" if scope.is_foreign(target.name) else "error")


def _check_anywhere(scope: Scope, x: e.EnumLiteral) -> None:
    """Where no enumeration is expected: a constant that none has, one slip away from one of a known enumeration."""
    tables = (*(names.enums for names in scope.tables), scope.known.enums)
    enums = [members for table in tables for members in table.values()]
    if any(x.name.upper() in members for members in enums):
        return
    near = slip_of(x.name, (member for members in enums for member in sorted(members)))
    if near is not None:
        message, hint = f"no enumeration that is known has the constant #{x.name}", f"did you mean #{near}?"
        scope.report(x.column, "no-constant", message, hint, "warning")


def check_compared(scope: Scope, left: e.Expression, left_type: Type, right: e.Expression, right_type: Type) -> None:
    """Report a constant that is compared with a number, or with a value of an enumeration that does not have it."""
    for x, other in ((left, right_type), (right, left_type)):
        if isinstance(x, e.EnumLiteral):
            _check_constant(scope, x, other)
