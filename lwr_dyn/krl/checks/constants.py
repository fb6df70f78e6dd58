"""Constants that cannot be meant: an index outside of its array, a speed in mm/s, over 100 %, a `#NAME` of no ENUM."""

from __future__ import annotations

from lwr_dyn.krl.diagnostics import Severity
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.names.known_names import SIMPLE, Type
from lwr_dyn.krl.project.scope import Scope, near_name, slip_of

FASTEST = 3.0
"""[m/s] $VEL_MA.CP, the largest path speed, as the robots are delivered."""
_SPEEDS = frozenset({"$VEL.CP", "LDAT.VEL", "BAS.VEL_CP", "BAS.CP_PARAMS", "SVEL_CP.1"})

_PERCENTS = frozenset({
    "$VEL_AXIS", "$ACC_AXIS", "$OV_PRO", "$OV_ROB", "$APO.CPTP", "$APO.CVEL", "PDAT.VEL", "PDAT.ACC", "LDAT.ACC",
    "BAS.VEL_PTP", "BAS.ACC_PTP", "BAS.PTP_PARAMS", "SVEL_JOINT.1",
})  # fmt: skip


def check_indices(scope: Scope, of: Type, x: e.Index) -> None:
    """Report constant indices before the first or after the last element."""
    for i, index in enumerate(x.indices):
        value = e.number_of(index)
        last = of.sizes[i] if i < len(of.sizes) else 0
        if value is not None and (value < 1 or (last and value > last)):
            name = _place(scope, x.of, of)
            message = f"index {value:g} of {name}"
            scope.report(index.column or x.column, "index-range", message, f"1 to {last}" if last else "from 1")


def check_setting(scope: Scope, target: e.Reference, of: Type, value: e.Expression) -> None:
    """Report a constant that is too large for what is assigned: of a structure, each component."""
    check_value(scope, _place(scope, target, of), value)


def check_arguments(scope: Scope, x: e.FunctionCall) -> None:
    """Report constants that are too large as arguments: `BAS(#VEL_PTP, 150)`."""
    key = x.name.upper()
    if key == "BAS" and len(x.arguments) == 2 and isinstance(x.arguments[0], e.EnumLiteral):
        check_value(scope, f"BAS.{x.arguments[0].name.upper()}", x.arguments[1])
    elif x.arguments:
        check_value(scope, f"{key}.1", x.arguments[0])


def _place(scope: Scope, x: e.Reference, of: Type) -> str:
    """`$VEL.CP` for a component of a system variable, `LDAT.VEL` for one of another structure, else the name."""
    if isinstance(x, e.Index):
        return _place(scope, x.of, of)
    if isinstance(x, e.Name):
        return x.name.upper()
    if isinstance(x.of, e.Name) and x.of.name.startswith("$"):
        return f"{x.of.name}.{x.name}".upper()
    whole = scope.variable(x.of.name) if isinstance(x.of, e.Name) else None
    return f"{'?' if whole is None else whole.name}.{x.name}".upper()


def check_value(scope: Scope, place: str, x: e.Expression | None) -> None:
    """Report a constant that is too large for a place such as `$VEL.CP`; of a structure, each component."""
    if isinstance(x, e.Aggregate):
        for item in x.items:
            check_value(scope, f"{place}.{item.name.upper()}", item.value)
        return
    value = e.number_of(x)
    if value is None or x is None:
        return
    name = place.removesuffix(".1")
    if place in _PERCENTS and value > 100.0:
        # bas.src multiplies what stands in PDAT and LDAT: more than 100 may work
        severity: Severity = "warning" if "DAT." in place else "error"
        scope.report(x.column, "percent-range", f"{name} = {value:g} %", "at most 100", severity)
    elif place in _SPEEDS and value > FASTEST:
        hint = f"in m/s, at most {FASTEST:g} as delivered"
        if value >= 10.0:
            hint += f"; {value:g} mm/s is {value / 1e3:g}"
        scope.report(x.column, "speed-unit", f"{name} = {value:g} m/s", hint, "warning")


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
            check_constant(scope, x, other)
