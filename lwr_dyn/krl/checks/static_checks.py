"""What can be diagnosed without running a program or a project: names, types, declarations, initial values, jumps."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from lwr_dyn.krl.checks.constant_values import check_value, place_of
from lwr_dyn.krl.checks.global_names import repeated_globals
from lwr_dyn.krl.checks.statement_places import TRIGGER, check_interrupt_declared, check_places, check_priority
from lwr_dyn.krl.checks.type_check import check_assignable, check_compared, shape_of, type_in
from lwr_dyn.krl.checks.written_places import check_text, check_written
from lwr_dyn.krl.diagnostics import SEVERITIES, Diagnostic, has_no_error, sorted_diagnostics
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.declarations import Declaration, Signal, StructType
from lwr_dyn.krl.names.known_names import AXES, BOOL, CARTESIAN, INT, REAL, UNKNOWN
from lwr_dyn.krl.project.program import Program, Scope, UnknownNames, program_in, scope_of, signature, slip_of
from lwr_dyn.krl.project.project import Project, SymbolTable, type_of

BEFORE_BRACKETS = ("RETURN", "WHILE", "UNTIL", "SWITCH")
"""Keywords before an expression: one that is misspelt before a bracket reads as a call."""
LONGEST_NAME = 24
"""Characters of a name that the controller distinguishes."""


def static_diagnostics(program: Program) -> tuple[Diagnostic, ...]:
    """Names and types of all routines of the `.src` and of the `.dat`."""
    diagnostics: list[Diagnostic] = []
    in_data, in_source = UnknownNames(), UnknownNames()
    data = program.module.data
    if data is not None:
        _check_lines(Scope(program, SymbolTable(), data.file, diagnostics, unknown=in_data), data.outline.data)
    for routine in program.routines:
        scope = scope_of(program, routine, diagnostics, in_source)
        _check_lines(scope, routine.lines())
        check_places(scope)
    return (*diagnostics, *repeated_globals(program), *in_data.diagnostics(), *in_source.diagnostics())


def _check_lines(scope: Scope, lines: Iterable[tuple[int, s.Statement]]) -> None:
    for i, x in lines:
        scope.line = i
        check = _CHECKS.get(type(x))
        if check is not None:
            check(scope, x)


def _declaration(scope: Scope, x: Declaration) -> None:
    _check_declared_type(scope, x)
    for d in x.names:
        if d.value is not None and not scope.file.is_data:
            message = f"{d.name} is given a value in its declaration"
            hint = "values go into the .dat, or into an assignment"
            scope.report(d.column, "initialiser-in-src", message, hint)
        if d.value is not None:
            check_assignable(scope, type_of(x.type, d), d.value, d.name)
        for size in d.sizes or ():
            type_in(scope, size)


def _check_declared_type(scope: Scope, x: Declaration) -> None:
    if x.type is None:
        shape = next((shape_of(d.value) for d in x.names if isinstance(d.value, e.Aggregate)), UNKNOWN)
        example = "E6POS" if shape.name in CARTESIAN else "E6AXIS" if shape.name in AXES else "INT"
        scope.report(x.column, "missing-type", "a declaration without a type", f"DECL {example} {x.names[0].name}")
    elif not scope.is_type(x.type.upper()):
        message = f"{x.type} is no type" if x.decl else f"{x.type} {x.names[0].name}: neither a statement nor a type"
        hint = "INT, REAL, BOOL, CHAR, E6POS ..., or one that is declared or lent with --with"
        scope.report_unknown(x.column, "unknown-type", message, x.type, scope.known.structures, hint)
    for d in x.names:
        if len(d.name) > LONGEST_NAME:
            message = f"the name has {len(d.name)} characters"
            scope.report(d.column, "long-name", message, f"at most {LONGEST_NAME}", "warning")


def _structure(scope: Scope, x: StructType) -> None:
    for kind, declarators in x.members:
        if not scope.is_type(kind.upper()):
            message, hint = f"{kind} is no type", "a structure that is declared or built in"
            scope.report_unknown(declarators[0].column, "unknown-type", message, kind, scope.known.structures, hint)
    if _contains(scope, x.name.upper()):
        scope.report(x.column, "recursive-type", f"{x.name} contains itself", "components of other types only")


def _contains(scope: Scope, name: str) -> bool:
    """Whether a structure contains itself, in its components or theirs."""
    seen: set[str] = set()
    ahead = [name]
    while ahead:
        inside = {kind.name for kind in (scope.structure(ahead.pop()) or {}).values()}
        if name in inside:
            return True
        ahead += inside - seen
        seen |= inside
    return False


def _assign(scope: Scope, x: s.Assign) -> None:
    target = x.target
    while isinstance(target, e.Index):
        target = target.of
    kind = type_in(scope, x.target)
    check_written(scope, x.target)
    check_text(scope, x.target, kind, x.value)
    check_assignable(scope, kind, x.value, target.name)
    check_value(scope, place_of(scope, x.target), x.value)


def _invoke(scope: Scope, x: s.Invoke) -> None:
    name = x.call.name
    keyword = slip_of(name, BEFORE_BRACKETS)
    is_known = scope.program.routine(name) or scope.external(name) or name.upper() in scope.known.functions
    if keyword is not None and not is_known:
        scope.report(x.column, "unknown-keyword", f"{x.call.name} is no keyword", f"did you mean {keyword}?")
        return
    type_in(scope, x.call)
    returned, _, _ = signature(scope.silent(), x.call)
    if returned is not None and returned is not UNKNOWN and scope.program.routine(x.call.name) is not None:
        message = f"{x.call.name} returns a value that nobody takes"
        scope.report(x.column, "unused-value", message, f"assign it: X = {x.call.name}(...)", "warning")


def _move(scope: Scope, x: s.Move) -> None:
    points = [x.target, *([x.auxiliary] if x.auxiliary is not None else [])]
    for point in points:
        kind = type_in(scope, point)
        allowed = CARTESIAN if x.kind.startswith(("LIN", "CIRC", "SLIN", "SCIRC")) else (*CARTESIAN, *AXES)
        if kind.name != "?" and (kind.name not in allowed or kind.dimensions):
            scope.report(point.column, "type", f"{x.kind} to a {kind}", f"one of {', '.join(allowed)}")
    if x.angle is not None:
        check_assignable(scope, REAL, x.angle, "CA")
    for setting in x.settings:
        _assign(scope, setting)
    _check_blends(scope, x)


def _check_blends(scope: Scope, x: s.Move) -> None:
    spline = x.kind.startswith(("SPTP", "SLIN", "SCIRC", "SPL"))
    for blend in x.blends:
        allowed = "C_SPL or C_DIS" if spline else "C_DIS, C_ORI or C_VEL"
        if x.kind.startswith("PTP"):
            allowed = "C_PTP, C_DIS, C_ORI or C_VEL"
        if blend not in allowed:
            scope.report(x.column, "blend", f"{blend} on {x.kind}", allowed)


def _condition(scope: Scope, x: s.Condition) -> None:
    if x.keyword == "SWITCH":
        type_in(scope, x.value)
    else:
        check_assignable(scope, BOOL, x.value, x.keyword)


def _for(scope: Scope, x: s.For) -> None:
    check_assignable(scope, INT, x.variable, "the variable of FOR")
    check_written(scope, x.variable)
    for value in (x.first, x.last, x.step):
        if value is not None:
            check_assignable(scope, INT, value, "FOR")


def _case(scope: Scope, x: s.CaseBranch) -> None:
    _values(scope, *x.values)
    block = None if scope.routine is None else scope.routine.blocks.get(scope.line)
    switch = None if block is None else scope.file.lines[block.first].statement
    if isinstance(switch, s.Condition):
        kind = type_in(scope.silent(), switch.value)
        for value in x.values:
            check_compared(scope, value, UNKNOWN, switch.value, kind)


def _interrupt(scope: Scope, x: s.InterruptDeclaration) -> None:
    check_assignable(scope, INT, x.priority, "the priority")
    check_priority(scope, x.priority)
    check_assignable(scope, BOOL, x.condition, "WHEN")
    _CHECKS[type(x.action)](scope, x.action)


def _interrupt_switch(scope: Scope, x: s.InterruptSwitch) -> None:
    _values(scope, x.priority)
    check_interrupt_declared(scope, x)


def _trigger(scope: Scope, x: s.Trigger) -> None:
    for value in (x.value, x.delay):
        check_assignable(scope, REAL, value, "TRIGGER")
    if x.priority is not None:
        check_assignable(scope, INT, x.priority, "PRIO")
        check_priority(scope, x.priority, TRIGGER)
    _CHECKS[type(x.action)](scope, x.action)


def _time_block(scope: Scope, x: s.TimeBlock) -> None:
    if x.value is not None:
        check_assignable(scope, REAL, x.value, f"TIME_BLOCK {x.bound}")


def _stop_when(scope: Scope, x: s.ConditionalStop) -> None:
    check_assignable(scope, REAL, x.distance, "STOP WHEN PATH")
    check_assignable(scope, BOOL, x.condition, "IF")


def _jump(scope: Scope, x: s.Jump) -> None:
    if scope.routine is not None and x.label.upper() not in scope.routine.labels:
        hint = f"put {x.label}: where it should go on"
        scope.report(x.column, "undeclared", f"there is no label {x.label}", hint)


def _return(scope: Scope, x: s.Return) -> None:
    _values(scope, x.value)
    returns = None if scope.routine is None else scope.routine.head.returns
    if (x.value is None) != (returns is None):
        wanted = "no value" if returns is None else f"a value of type {returns}"
        scope.report(x.column, "type", f"RETURN {'without' if x.value is None else 'with'} a value", wanted)


def _spline(scope: Scope, x: s.SplineBlock) -> None:
    for setting in x.settings:
        _assign(scope, setting)


def _values(scope: Scope, *values: e.Expression | None) -> None:
    """Check expressions of any type; None for one that is left out."""
    for value in values:
        if value is not None:
            type_in(scope, value)


_CHECKS: dict[type, Callable[[Scope, Any], None]] = {
    Declaration: _declaration,
    StructType: _structure,
    Signal: lambda scope, x: _values(scope, x.first, x.last),
    s.Assign: _assign,
    s.Invoke: _invoke,
    s.Move: _move,
    s.Wait: lambda scope, x: check_assignable(scope, REAL if x.kind == "SEC" else BOOL, x.value, f"WAIT {x.kind}"),
    s.Condition: _condition,
    s.Confirm: lambda scope, x: check_assignable(scope, INT, x.value, "CONFIRM"),
    s.For: _for,
    s.CaseBranch: _case,
    s.Jump: _jump,
    s.Return: _return,
    s.InterruptDeclaration: _interrupt,
    s.InterruptSwitch: _interrupt_switch,
    s.Trigger: _trigger,
    s.ConstantSpeed: lambda scope, x: check_assignable(scope, REAL, x.offset, f"CONST_VEL {x.bound}"),
    s.TimeBlock: _time_block,
    s.ConditionalStop: _stop_when,
    s.Analog: lambda scope, x: _values(scope, x.target, x.value),
    s.SplineBlock: _spline,
}


@dataclass(frozen=True, slots=True, eq=False)
class CheckedFile:
    """A file of a project: its path within the folder, its number of lines, and its diagnostics."""

    name: str
    lines: int
    diagnostics: tuple[Diagnostic, ...]

    @property
    def counts(self) -> dict[str, int]:
        """The number of its errors, warnings and notes."""
        return {f"{x}s": sum(d.severity == x for d in self.diagnostics) for x in SEVERITIES}


def check_project(project: Project) -> tuple[CheckedFile, ...]:
    """Each file of a project with its diagnostics, module by module."""
    found: dict[str, list[Diagnostic]] = {x.file.name: [] for x in project.files}
    for diagnostic in project.twins():
        found[diagnostic.position.file].append(diagnostic)
    for module in project.modules:
        program = program_in(project, module)
        for diagnostic in (*program.diagnostics, *static_diagnostics(program)):
            found[diagnostic.position.file].append(diagnostic)
    files = {x.file.name: x.file for x in project.files}
    return tuple(CheckedFile(k, len(x.lines), sorted_diagnostics(found[k])) for k, x in files.items())


def totals(files: Sequence[CheckedFile]) -> dict[str, int]:
    """Files, lines, programs (`.src` and `.sub`), those of them without an error, and the diagnostics by severity."""
    programs = [x for x in files if not x.name.lower().endswith(".dat")]
    clean = sum(has_no_error(x.diagnostics) for x in programs)
    counts = {f"{x}s": sum(y.counts[f"{x}s"] for y in files) for x in SEVERITIES}
    lines = sum(x.lines for x in files)
    return {"files": len(files), "lines": lines, "programs": len(programs), "without_error": clean, **counts}
