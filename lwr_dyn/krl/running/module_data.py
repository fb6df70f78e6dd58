"""The variables of each file while a program runs: made when one of them is first used."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from lwr_dyn.krl.diagnostics import DiagnosticLog, ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.declarations import Def
from lwr_dyn.krl.names.types import UNKNOWN
from lwr_dyn.krl.project.program import Program, program_in
from lwr_dyn.krl.project.project import Project
from lwr_dyn.krl.project.scope import scope_of
from lwr_dyn.krl.project.symbols import DeclaredName
from lwr_dyn.krl.running.context import ExecutionContext, StackFrame
from lwr_dyn.krl.running.execute import assign
from lwr_dyn.krl.running.initial import argument_variable, initialised
from lwr_dyn.krl.running.values import Variable


@dataclass(slots=True, eq=False)
class ModuleData:
    """The data of the modules of a project."""

    project: Project
    log: DiagnosticLog
    stack: list[StackFrame]
    files: dict[str, dict[str, Variable]] = field(default_factory=dict)
    """The variables of each file, by its name."""
    programs: dict[str, Program] = field(default_factory=dict)
    declared: dict[int, Mapping[str, DeclaredName]] = field(default_factory=dict)

    def program_of(self, file: str) -> Program:
        """The program of the module of a file."""
        if file not in self.programs:
            self.programs[file] = program_in(self.project, self.project.homes[file])
        return self.programs[file]

    def declared_in(self, routine: Routine, home: Program) -> Mapping[str, DeclaredName]:
        """The names that a routine declares."""
        key = id(routine)
        if key not in self.declared:
            self.declared[key] = scope_of(home, routine, []).own.variables
        return self.declared[key]

    def enter(self, m: ExecutionContext, routine: Routine, arguments: Sequence[e.Expression | None]) -> None:
        """Put a call on the stack, with its arguments; OUT parameters are the caller's own variables."""
        variables: dict[str, Variable] = {}
        home = self.program_of(routine.file.name)
        declared = self.declared_in(routine, home)
        for i, p in enumerate(routine.head.parameters):
            key = p.name.upper()
            kind = declared[key].type if key in declared else UNKNOWN
            variables[key] = argument_variable(m, arguments[i] if i < len(arguments) else None, p, kind)
        self.stack.append(StackFrame(home, routine, routine.first, variables))
        for key, name in declared.items():
            if key not in variables:
                variables[key] = self.new_variable(m, name)

    def new_variable(self, m: ExecutionContext, name: DeclaredName) -> Variable:
        """The variable as declared; a fault in its declaration is reported, and it has no value."""
        try:
            return initialised(m, name)
        except ExecutionError as fault:
            self.log.position = name.position
            self.log.report_fault(fault)
            return Variable(name.type)

    def variables_of(self, m: ExecutionContext, file: str) -> dict[str, Variable]:
        """The variables of a file, with their initial values."""
        if file in self.files:
            return self.files[file]
        variables = self.files[file] = {}
        read, position = self.project.file(file), self.log.position
        # the statements of a .dat see the names of its module
        self.stack.append(StackFrame(self.program_of(file), Routine(read.file, Def(""), 0), 0, variables))
        for key, name in read.names.variables.items():
            variables[key] = self.new_variable(m, name)
        for i, x in read.outline.data:
            if isinstance(x, s.Assign):
                self.log.position = read.file.position(i, x.column)
                try:
                    assign(m, x)
                except ExecutionError as fault:
                    self.log.report_fault(fault)
        self.stack.pop()
        self.log.position = position
        return variables
