"""Types that operators take and make, with a diagnosis where operands do not fit."""

from __future__ import annotations

from collections.abc import Set

from lwr_dyn.krl import expressions as e
from lwr_dyn.krl.scope import Scope
from lwr_dyn.krl.types import BOOL, CARTESIAN, INT, NUMBERS, REAL, UNKNOWN, Type, assignable


def unary_type(scope: Scope, x: e.Unary, of: Type) -> Type:
    """What an operator makes of an operand of a type."""
    wanted = {"NOT": {"BOOL"}, "B_NOT": {"INT", "CHAR"}}.get(x.operator, NUMBERS)
    return _checked(scope, x, of, of, wanted)


def binary_type(scope: Scope, x: e.Binary, left: Type, right: Type) -> Type:
    """What an operator makes of operands of two types."""
    if x.operator == ":":
        _checked(scope, x, left, right, set(CARTESIAN))
        return right
    if x.operator in ("AND", "OR", "EXOR"):
        return _checked(scope, x, left, right, {"BOOL"}, BOOL)
    if x.operator.startswith("B_"):
        return _checked(scope, x, left, right, {"INT", "CHAR"}, INT)
    if x.operator in ("+", "-", "*", "/"):
        result = INT if left.name == right.name == "INT" else REAL
        return _checked(scope, x, left, right, NUMBERS, result)
    return _comparison(scope, x, left, right)


def _comparison(scope: Scope, x: e.Binary, left: Type, right: Type) -> Type:
    ordered = x.operator not in ("==", "<>")
    if not assignable(left, right) or (ordered and left.name not in (NUMBERS | {"?"})):
        hint = "numbers" if ordered else "two values of one type"
        if "BOOL" in (left.name, right.name):
            hint += "; comparisons bind weaker than AND and OR: put each in brackets"
        scope.say(x.column, "type", f"{left} {x.operator} {right} has no meaning", hint)
    return BOOL


def _checked(
    scope: Scope, x: e.Unary | e.Binary, left: Type, right: Type, wanted: Set[str], result: Type | None = None
) -> Type:
    for side in (left, right):
        if side.name not in wanted and side.name != "?":
            hint = f"{' or '.join(sorted(wanted))} on both sides" if isinstance(x, e.Binary) else "another operator"
            if wanted == {"BOOL"} and side.name in NUMBERS:
                hint += "; comparisons bind weaker than AND and OR: put each in brackets"
            scope.say(x.column, "type", f"{x.operator} on {side}", hint)
            return result or UNKNOWN
    return result or left
