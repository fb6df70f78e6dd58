"""What can be said of a program without running it: names, types, declarations, initialisers, jumps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from lwr_dyn.krl import expressions as e
from lwr_dyn.krl import statements as s
from lwr_dyn.krl.declarations import Declaration
from lwr_dyn.krl.diagnosis import Diagnosis
from lwr_dyn.krl.program import Names, Program
from lwr_dyn.krl.scope import Scope, scope_of, signature
from lwr_dyn.krl.source import SourceFile
from lwr_dyn.krl.structure import Routine
from lwr_dyn.krl.types import AXES, BOOL, CARTESIAN, INT, REAL, UNKNOWN, Type
from lwr_dyn.krl.typing import fits, shape_of, type_in

LONGEST_NAME = 24
"""Characters of a name that the controller tells apart."""


def static_diagnoses(program: Program) -> tuple[Diagnosis, ...]:
    """Names and types of all routines of the `.src` and of the `.dat`."""
    found: list[Diagnosis] = []
    if program.data is not None:
        _data(program, program.data, found)
    for routine in program.routines:
        _routine(program, routine, found)
    return tuple(found)


def _routine(program: Program, routine: Routine, found: list[Diagnosis]) -> None:
    scope = scope_of(program, routine, found)
    for i, x in routine.lines():
        scope.line = i
        check = _CHECKS.get(type(x))
        if check is not None:
            check(scope, x)
        if isinstance(x, s.Jump) and x.label.upper() not in routine.labels:
            scope.say(x.column, "undeclared", f"there is no label {x.label}", f"put {x.label}: where it should go on")
        if isinstance(x, s.Return) and (x.value is None) != (routine.head.returns is None):
            wanted = "no value" if routine.head.returns is None else f"a value of type {routine.head.returns}"
            scope.say(x.column, "type", f"RETURN {'without' if x.value is None else 'with'} a value", wanted)


def _data(program: Program, file: SourceFile, found: list[Diagnosis]) -> None:
    scope = Scope(program, Names(), file, found)
    for i, x in program.structures[file.name].data:
        scope.line = i
        if isinstance(x, Declaration):
            _declared_types(scope, x)
            for d in x.names:
                if d.value is not None:
                    kind = Type((x.type or "?").upper(), 0 if d.sizes is None else max(len(d.sizes), 1))
                    fits(scope, kind, d.value, d.name)
        elif isinstance(x, s.Assign):
            _assign(scope, x)


def _declaration(scope: Scope, x: Declaration) -> None:
    _declared_types(scope, x)
    for d in x.names:
        if d.value is not None:
            said = f"{d.name} is given a value in its declaration"
            scope.say(d.column, "initialiser-in-src", said, "values go into the .dat, or into an assignment")
            kind = UNKNOWN if x.type is None else Type(x.type.upper(), 0 if d.sizes is None else max(len(d.sizes), 1))
            fits(scope, kind, d.value, d.name)
        for size in d.sizes or ():
            type_in(scope, size)


def _declared_types(scope: Scope, x: Declaration) -> None:
    if x.type is None:
        shape = next((shape_of(d.value) for d in x.names if isinstance(d.value, e.Aggregate)), UNKNOWN)
        example = "E6POS" if shape.name in CARTESIAN else "E6AXIS" if shape.name in AXES else "INT"
        scope.say(x.column, "missing-type", "a declaration without a type", f"DECL {example} {x.names[0].name}")
    elif not scope.is_type(x.type.upper()):
        said = f"{x.type} is no type" if x.decl else f"{x.type} {x.names[0].name}: neither a statement nor a type"
        scope.say(
            x.column,
            "unknown-type",
            said,
            "INT, REAL, BOOL, CHAR, E6POS ..., or one that is declared or lent with --with",
        )
    for d in x.names:
        if len(d.name) > LONGEST_NAME:
            said = f"the name has {len(d.name)} characters"
            scope.say(d.column, "long-name", said, f"at most {LONGEST_NAME}", "warning")


def _assign(scope: Scope, x: s.Assign) -> None:
    fits(scope, type_in(scope, x.target), x.value, _said(x.target))


def _invoke(scope: Scope, x: s.Invoke) -> None:
    type_in(scope, x.call)
    known: list[Diagnosis] = []
    returned, _, _ = signature(Scope(scope.program, scope.own, scope.file, known, scope.line), x.call)
    if returned is not None and returned is not UNKNOWN and scope.program.routine(x.call.name) is not None:
        said = f"{x.call.name} returns a value that nobody takes"
        scope.say(x.column, "unused-value", said, f"assign it: X = {x.call.name}(...)", "warning")


def _move(scope: Scope, x: s.Move) -> None:
    points = [x.target, *([x.auxiliary] if x.auxiliary is not None else [])]
    for point in points:
        kind = type_in(scope, point)
        allowed = CARTESIAN if x.kind.startswith(("LIN", "CIRC", "SLIN", "SCIRC")) else (*CARTESIAN, *AXES)
        if kind.name != "?" and (kind.name not in allowed or kind.dimensions):
            scope.say(point.column, "type", f"{x.kind} to a {kind}", f"one of {', '.join(allowed)}")
    if x.angle is not None:
        _is(scope, x.angle, REAL, "CA")
    for setting in x.settings:
        _assign(scope, setting)
    _blends(scope, x)


def _blends(scope: Scope, x: s.Move) -> None:
    spline = x.kind.startswith(("SPTP", "SLIN", "SCIRC", "SPL"))
    for i, blend in enumerate(x.blends):
        wrong = (blend == "C_SPL") != spline or (blend == "C_PTP" and not x.kind.startswith("PTP"))
        if wrong or (x.kind.startswith("PTP") and i == 0 and blend != "C_PTP"):
            fit = "C_SPL" if spline else "C_PTP" if x.kind.startswith("PTP") else "C_DIS, C_ORI or C_VEL"
            scope.say(x.column, "blend", f"{blend} on {x.kind}", fit)


def _wait(scope: Scope, x: s.Wait) -> None:
    _is(scope, x.value, REAL if x.kind == "SEC" else BOOL, f"WAIT {x.kind}")


def _condition(scope: Scope, x: s.Condition) -> None:
    if x.keyword == "SWITCH":
        type_in(scope, x.value)
    else:
        _is(scope, x.value, BOOL, x.keyword)


def _for(scope: Scope, x: s.For) -> None:
    _is(scope, x.variable, INT, "the variable of FOR")
    for value in (x.first, x.last, x.step):
        if value is not None:
            _is(scope, value, INT, "FOR")


def _is(scope: Scope, x: e.Expression, wanted: Type, what: str) -> None:
    fits(scope, wanted, x, what)


def _interrupt(scope: Scope, x: s.InterruptDeclaration) -> None:
    _is(scope, x.priority, INT, "the priority")
    _is(scope, x.condition, BOOL, "WHEN")
    _CHECKS[type(x.action)](scope, x.action)


def _trigger(scope: Scope, x: s.Trigger) -> None:
    for value in (x.value, x.delay):
        _is(scope, value, REAL, "TRIGGER")
    _CHECKS[type(x.action)](scope, x.action)


def _spline(scope: Scope, x: s.SplineBlock) -> None:
    for setting in x.settings:
        _assign(scope, setting)


def _values(values: Sequence[e.Expression | None]) -> Callable[[Scope, Any], None]:
    def check(scope: Scope, _: Any) -> None:
        for value in values:
            if value is not None:
                type_in(scope, value)

    return check


def _said(target: e.Reference) -> str:
    while isinstance(target, e.Index):
        target = target.of
    return target.name


_CHECKS: dict[type, Callable[[Scope, Any], None]] = {
    Declaration: _declaration,
    s.Assign: _assign,
    s.Invoke: _invoke,
    s.Move: _move,
    s.Wait: _wait,
    s.Condition: _condition,
    s.For: _for,
    s.Case: lambda scope, x: _values(x.values)(scope, x),
    s.Return: lambda scope, x: _values([x.value])(scope, x),
    s.InterruptDeclaration: _interrupt,
    s.InterruptSwitch: lambda scope, x: _values([x.priority])(scope, x),
    s.Trigger: _trigger,
    s.Analog: lambda scope, x: _values([x.target, x.value])(scope, x),
    s.SplineBlock: _spline,
}
