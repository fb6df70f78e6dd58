"""What may stand where: the lines of SWITCH, the target of GOTO; parameters without a type; interrupts."""

from __future__ import annotations

from functools import lru_cache

from lwr_dyn.krl.checks.spline_blocks import SPLINES, blocks_of, check_spline, check_within_spline, inside, line_of
from lwr_dyn.krl.checks.type_check import type_in
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import LOOPS, CodeBlock, keyword_of
from lwr_dyn.krl.language.declarations import Declaration
from lwr_dyn.krl.names.known_names import UNKNOWN, Type
from lwr_dyn.krl.project.program import Scope
from lwr_dyn.krl.project.project import Project

SELECTORS = frozenset({"INT", "CHAR", "BOOL", UNKNOWN.name})
"""Types after SWITCH beside enumerations. BOOL is not in KUKA's list, but may work."""
MOST_INTERRUPTS = 128
TRIGGER = "a trigger"
"""It may leave its priority to the controller, with -1."""
AUTOMATIC = range(40, 81)
"""Priorities that the controller gives to triggers by itself."""


def check_places(scope: Scope) -> None:
    """Report what stands in a wrong place in a routine; raises nothing."""
    routine = scope.routine
    if routine is None:
        return
    _check_parameters(scope)
    for block in blocks_of(scope):
        if block.kind in SPLINES:
            check_spline(scope, block)
        elif block.kind == "SWITCH":
            _check_switch(scope, block)
    for i, x in routine.lines():
        scope.line = i
        if isinstance(x, s.Jump):
            _check_jump(scope, x, i)
        elif isinstance(x, s.ConstantSpeed | s.TimeBlock):
            check_within_spline(scope, x, i)


def _check_parameters(scope: Scope) -> None:
    """Report a parameter whose type no declaration of the routine gives; an empty routine is a stub."""
    routine = scope.routine
    if routine is None or next(routine.lines(), None) is None:
        return
    if any(not line.readable for line in scope.file.lines[routine.first : routine.last]):
        return
    scope.line = routine.first - 1
    for p in routine.head.parameters:
        declared = scope.own.variables.get(p.name.upper())
        if declared is not None and declared.type.name == UNKNOWN.name:
            message = f"the parameter {p.name} of {routine.head.name} has no type"
            brackets = f"[{',' * (p.dimensions - 1)}]" if p.dimensions else ""
            scope.report(
                p.column, "parameter-type", message, f"declare it below DEF: INT {p.name}{brackets}, or its type"
            )


def _check_switch(scope: Scope, block: CodeBlock) -> None:
    switch = line_of(scope, block.first)
    scope.line = block.first
    if isinstance(switch, s.Condition):
        kind = _silent_type(scope, switch.value)
        if not _selects(scope, kind):
            scope.report(switch.value.column, "switch", f"SWITCH on {kind}", "INT, CHAR or an enumeration; or IF")
    first = min([*block.parts, block.last])
    before = next(inside(scope, block.first, first), None)
    if before is not None:
        scope.line, column = before[0], getattr(before[1], "column", 1)
        hint = "put it before SWITCH, or below a CASE"
        scope.report(column, "switch", "a statement before the first CASE", hint)
    default = [i for i in block.parts if keyword_of(line_of(scope, i)) == "DEFAULT"]
    for i in block.parts:
        if default and i > default[0]:
            scope.line = i
            word = keyword_of(line_of(scope, i))
            scope.report(1, "switch", f"{word} after DEFAULT", "DEFAULT stands once and last")


def _selects(scope: Scope, kind: Type) -> bool:
    return not kind.dimensions and (kind.name in SELECTORS or scope.enum(kind.name) is not None)


def _silent_type(scope: Scope, x: e.Expression) -> Type:
    return type_in(scope.silent(), x)


def _check_jump(scope: Scope, x: s.Jump, i: int) -> None:
    """Report a jump from outside into a loop, an IF or a CASE."""
    routine = scope.routine
    at = None if routine is None else routine.labels.get(x.label.upper())
    if routine is None or at is None:
        return
    for block in {id(b): b for b in routine.blocks.values()}.values():
        if not block.first < at < block.last:
            continue
        outside = not block.first < i < block.last
        other_case = block.kind == "SWITCH" and _part(block, at) != _part(block, i)
        if block.kind in (*LOOPS, "IF", "SWITCH", *SPLINES) and (outside or other_case):
            what = f"into {block.kind} of line {block.first + 1}" if outside else "from one CASE into another"
            scope.report(x.column, "goto", f"GOTO {x.label} jumps {what}", "put the label before or after the block")
            return


def _part(block: CodeBlock, i: int) -> int:
    """The number of CASE and DEFAULT lines of a SWITCH before a line."""
    return sum(part < i for part in block.parts)


@lru_cache(maxsize=4)
def declared_interrupts(project: Project) -> tuple[set[int], bool]:
    """The priorities that INTERRUPT DECL gives anywhere in the project, and whether one of them is not known.

    A variable counts as its first value where no line assigns another.
    """
    numbers: set[int] = set()
    others = False
    for file in project.files:
        for line in file.file.lines:
            if isinstance(line.statement, s.InterruptDeclaration):
                x = line.statement.priority
                found = _first_values(project, x.name.upper()) if isinstance(x, e.Name) else [e.number_of(x)]
                others = others or not found or None in found
                numbers |= {int(number) for number in found if number is not None}
    return numbers, others


def _first_values(project: Project, name: str) -> list[int | float | None]:
    """What the declarations of a variable give it; None where one gives no number, or where a line assigns to it."""
    out: list[int | float | None] = []
    for x in (line.statement for file in project.files for line in file.file.lines):
        if isinstance(x, Declaration):
            out += [e.number_of(y.value) for y in x.names if y.name.upper() == name]
        elif isinstance(x, s.Assign) and e.root_name(x.target) == name:
            out.append(None)
    return out


def check_priority(scope: Scope, x: e.Expression, of: str = "an interrupt") -> None:
    """Report the priority of an interrupt or a trigger that the controller does not take, or gives by itself."""
    number = e.number_of(x)
    allowed = f"1 to {AUTOMATIC[0] - 1}, or {AUTOMATIC[-1] + 1} to {MOST_INTERRUPTS}"
    if number is None or (number == -1 and of == TRIGGER):
        return
    if not 1 <= number <= MOST_INTERRUPTS:
        scope.report(x.column, "interrupt", f"the priority {number:g} of {of}", allowed)
    elif number in AUTOMATIC:
        message = f"the priority {number:g} is one of those that the controller gives to triggers"
        scope.report(x.column, "interrupt", message, allowed, "warning")


def check_interrupt_declared(scope: Scope, x: s.InterruptSwitch) -> None:
    """Report an interrupt that is switched on and declared nowhere; a warning, as a caller may declare it."""
    number = e.number_of(x.priority)
    if number is None or x.mode != "ON":
        return
    declared, others = declared_interrupts(scope.program.project)
    if not others and number not in declared:
        message = f"the interrupt {number:g} is switched on and declared nowhere in the files that are read"
        hint = f"INTERRUPT DECL {number:g} WHEN ... DO ...() before it"
        scope.report(x.column, "interrupt", message, hint, "warning")
