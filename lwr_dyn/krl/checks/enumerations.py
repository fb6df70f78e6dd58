"""Constants of enumerations, `#NAME`: whether the enumeration that is expected has such a constant."""

from __future__ import annotations

from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.names.types import SIMPLE, Type
from lwr_dyn.krl.project.scope import Scope
from lwr_dyn.krl.project.unknown_names import near_name, slip_of


def check_constant(scope: Scope, x: e.EnumLiteral, target: Type) -> None:
    """Report a constant where none is expected, or one that its enumeration does not have.

    A warning for KUKA's own enumerations: their constants differ between versions of KSS.
    """
    if target.name == "?":
        _check_anywhere(scope, x)
        return
    members = scope.enum(target.name)
    if members is None:
        if target.name in SIMPLE or scope.structure(target.name) is not None:
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
    enums = [*scope.own.enums.values(), *scope.program.names.enums.values(), *scope.known.enums.values()]
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
            check_constant(scope, x, other)
