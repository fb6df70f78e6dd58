"""Brings a cell to a program: its names for the checks, its values for a run."""

from __future__ import annotations

import re
from difflib import get_close_matches

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.diagnostics import ExecutionError, SourcePosition
from lwr_dyn.krl.language.declarations import External
from lwr_dyn.krl.language.line_parser import parse_line
from lwr_dyn.krl.language.statements import Assign
from lwr_dyn.krl.names.known_names import CONFIG, SYSTEM, UNKNOWN, Type
from lwr_dyn.krl.project.program import Program
from lwr_dyn.krl.project.symbols import DeclaredName
from lwr_dyn.krl.running.cell import RobotCell
from lwr_dyn.krl.running.controller import INPUTS, ControllerState
from lwr_dyn.krl.running.evaluate import reference_to
from lwr_dyn.krl.running.running_program import RunningProgram
from lwr_dyn.krl.running.values import StructValue, Value, converted, value_text

SPEEDS = ("$VEL", "$ACC", "$VEL_AXIS", "$ACC_AXIS", "$OV_PRO")

MOST_ARGUMENTS = 40
"""Of a stub: any number up to this."""


def with_cell(program: Program, cell: RobotCell) -> Program:
    """The program with the variables and stubs of a cell among its names; those it declares itself stay."""
    names = program.names
    for name, value in cell.values.items():
        root, rest = re.match(r"([^\[.]*)(.*)", name).groups()  # type: ignore[union-attr]
        if not root.startswith("$") and root not in CONFIG:
            dimensions = rest.partition("]")[0].count(",") + 1 if rest.startswith("[") else 0
            kind = Type("?", dimensions) if rest else _type_of(value)
            names.variables.setdefault(root, DeclaredName(root, kind, SourcePosition(cell.file, 1)))
    for name, stub in cell.stubs.items():
        returns = None if stub.returns is None else _type_of(stub.returns).name
        names.externals.setdefault(name, External(name, returns, ("?",) * MOST_ARGUMENTS))
    return program


def give_cell(m: RunningProgram) -> None:
    """Set the variables and states of the cell; raises `OptionError` for a wrong type, or a $ name that nothing has."""
    c = m.controller
    for root, values in c.given.items():
        if root.startswith("$") and not _is_known(m.program, root):
            near = get_close_matches(root, m.program.project.known.variables, n=1)
            meant = f" (did you mean {near[0]}?)" if near else ""
            wanted = f"a $ variable of KUKA's, or one that a file names{meant}"
            raise OptionError("the name given", next(iter(values)), wanted)
        for name, value in values.items():
            try:
                give_value(m, name, value)
                if root in SPEEDS:
                    c.speeds()
            except ExecutionError as fault:
                raise OptionError(f"the given {name}", value_text(value), fault.hint or str(fault)) from None
        c.unread[root] = "given"


def _is_known(program: Program, root: str) -> bool:
    """Whether a name is KUKA's, declared in a file that the program sees, or written in one of its files."""
    if root in program.project.known.variables or root in program.names.variables:
        return True
    word = re.compile(re.escape(root) + r"(?![A-Z0-9_$])", re.IGNORECASE)
    return any(word.search(line.text()) for x in program.module.files for line in x.file.lines)


def note_unread(c: ControllerState) -> None:
    """List the variables that are given and that the run neither reads nor sets."""
    for root, why in c.unread.items():
        if why == "given" and root not in SYSTEM and root not in CONFIG:
            c.assumptions.note(root, "", "given, but nothing reads it")


def give_arguments(m: RunningProgram) -> None:
    """Set the parameters of the routine that is run; those without a value are noted; raises `OptionError`."""
    c, frame, missing = m.controller, m.stack[0], []
    for p in frame.routine.head.parameters:
        key, variable = p.name.upper(), frame.variables[p.name.upper()]
        if key not in c.cell.arguments:
            missing.append(p.name)
            continue
        value = c.cell.arguments[key]
        try:
            variable.value = converted(value, variable.type)
        except ExecutionError as fault:
            raise OptionError(f"the cell's arguments.{key}", value_text(value), fault.hint or str(fault)) from None
        c.assumptions.note(f"the argument {p.name}", value_text(value), "given")
    if missing:
        name = frame.routine.head.name
        message = f"{name} is run without its argument{'s' * (len(missing) > 1)} {', '.join(missing)}"
        m.log.report("note", "arguments", message, "give them in a cell file under [arguments]")


def give_value(m: RunningProgram, name: str, value: Value) -> str:
    """Set an input, a state or a variable from outside; the text says what is set. Raises `ExecutionError`."""
    if name.partition("[")[0] in INPUTS:
        m.controller.inputs[name] = value
    else:
        statement, _ = parse_line(f"{name}=0")
        assert isinstance(statement, Assign)
        reference_to(m, statement.target).write(value)
    return f"{name} = {value_text(value)}"


def _type_of(value: Value) -> Type:
    for kind, name in ((bool, "BOOL"), (int, "INT"), (float, "REAL")):
        if isinstance(value, kind):
            return Type(name)
    return Type(value.type) if isinstance(value, StructValue) and value.type != "?" else UNKNOWN
