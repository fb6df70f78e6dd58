"""Arguments of calls: whether each fits the parameter that takes it."""

from __future__ import annotations

from collections.abc import Sequence

from lwr_dyn.krl.checks.enumerations import check_constant
from lwr_dyn.krl.diagnostics import Severity
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.blocks import DECLARATIONS, Routine
from lwr_dyn.krl.language.declarations import Declaration
from lwr_dyn.krl.names.known import FunctionParameter
from lwr_dyn.krl.names.types import NUMBERS, UNKNOWN, Type
from lwr_dyn.krl.project.scope import Scope
from lwr_dyn.krl.project.symbols import type_of

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
            _check(scope, x.name, parameter, argument, kind, severity)


def _check(
    scope: Scope, name: str, parameter: FunctionParameter, argument: e.Expression, kind: Type, severity: Severity
) -> None:
    taken = scope.type_seen(parameter.type)
    if isinstance(argument, e.EnumLiteral):
        check_constant(scope, argument, taken)
    elif parameter.mode == "OUT" and not isinstance(argument, e.Name | e.Index | e.Component):
        message = f"{parameter.name} of {name} is OUT, the argument is no variable"
        scope.report(argument.column, "arguments", message, f"a variable of type {taken}", severity)
    elif not _fits(taken, kind):
        message = f"{parameter.name} of {name} is {taken}, the argument is {kind}"
        scope.report(argument.column, "type", message, f"a value of type {taken}", severity)


def taken_by(routine: Routine) -> tuple[FunctionParameter, ...]:
    """The parameters of a routine with the types that its first lines declare.

    All count as IN: what happens to a constant for OUT is not documented, and programs hand over texts so.
    """
    kinds: dict[str, Type] = {}
    for _, x in routine.lines():
        if not isinstance(x, DECLARATIONS):
            break
        if isinstance(x, Declaration):
            kinds |= {d.name.upper(): type_of(x.type, d) for d in x.names}
    return tuple(FunctionParameter(p.name, kinds.get(p.name.upper(), UNKNOWN)) for p in routine.head.parameters)


def _declared(i: int, text: str) -> FunctionParameter:
    """A parameter as EXT declares it: `CHAR[]:OUT`, or with a name, `CHAR TEXT[]:OUT`."""
    kind, _, brackets = text.partition(":")[0].partition("[")
    return FunctionParameter(f"argument {i + 1}", Type(kind.split()[0].upper(), brackets.count(",") + bool(brackets)))


def _fits(taken: Type, given: Type) -> bool:
    """Whether an argument may be handed over: text of any length, numbers for numbers."""
    if "?" in (taken.name, given.name) or taken.name == given.name == "CHAR":
        return True
    if taken.name in NUMBERS and given.name in NUMBERS:
        return taken.dimensions == given.dimensions
    return taken.accepts(given)
