"""Arguments of calls: whether each fits the parameter that takes it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lwr_dyn.krl.checks.enumerations import check_constant
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.blocks import DECLARATIONS, Routine
from lwr_dyn.krl.language.declarations import Declaration
from lwr_dyn.krl.names.types import NUMBERS, UNKNOWN, Type
from lwr_dyn.krl.project.symbols import Scope, type_of


@dataclass(frozen=True, slots=True)
class TakenArgument:
    """What a parameter takes: its type, unknown where it is not declared."""

    name: str
    type: Type


def check_types(scope: Scope, x: e.FunctionCall, given: Sequence[Type]) -> None:
    """Report arguments whose type is not that of the parameter; `given` are the types of the arguments."""
    routine = scope.program.routine(x.name)
    taken = () if routine is None else taken_by(routine)
    for parameter, argument, kind in zip(taken, x.arguments, given, strict=False):
        if isinstance(argument, e.EnumLiteral):
            check_constant(scope, argument, parameter.type)
        elif argument is not None and not _fits(parameter.type, kind):
            message = f"{parameter.name} of {x.name} is {parameter.type}, the argument is {kind}"
            scope.report(argument.column, "type", message, f"a value of type {parameter.type}")


def taken_by(routine: Routine) -> tuple[TakenArgument, ...]:
    """The parameters of a routine with the types that its first lines declare."""
    kinds: dict[str, Type] = {}
    for _, x in routine.lines():
        if not isinstance(x, DECLARATIONS):
            break
        if isinstance(x, Declaration):
            kinds |= {d.name.upper(): type_of(x.type, d) for d in x.names}
    return tuple(TakenArgument(p.name, kinds.get(p.name.upper(), UNKNOWN)) for p in routine.head.parameters)


def _fits(taken: Type, given: Type) -> bool:
    """Whether an argument may be handed over: text of any length, numbers for numbers."""
    if "?" in (taken.name, given.name) or taken.name == given.name == "CHAR":
        return True
    if taken.name in NUMBERS and given.name in NUMBERS:
        return taken.dimensions == given.dimensions
    return taken.accepts(given)
