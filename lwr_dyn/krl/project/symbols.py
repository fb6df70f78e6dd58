"""Symbol tables: the declared names of a routine and of a program, and which of them a routine sees."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import TYPE_CHECKING

from lwr_dyn.krl.diagnostics import Diagnostic, Severity, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.declarations import Declaration, Declarator, EnumType, External, Signal, StructType
from lwr_dyn.krl.language.source import SourceFile
from lwr_dyn.krl.names.predefined import CONFIG, FUNCTIONS, SYSTEM
from lwr_dyn.krl.names.types import ENUMS, LARGEST, SIMPLE, STRUCTURES, UNKNOWN, Type

if TYPE_CHECKING:
    from lwr_dyn.krl.project.program import Program


@dataclass(frozen=True, slots=True)
class DeclaredName:
    """A declared variable: its type and position, and the declarator with its sizes and initial value."""

    name: str
    type: Type
    position: SourcePosition
    declarator: Declarator | None = None
    const: bool = False


@dataclass(slots=True)
class SymbolTable:
    """The declarations of a routine, or of a program's files; keys in capitals."""

    variables: dict[str, DeclaredName] = field(default_factory=dict)
    structures: dict[str, Mapping[str, Type]] = field(default_factory=dict)
    enums: dict[str, frozenset[str]] = field(default_factory=dict)
    externals: dict[str, External] = field(default_factory=dict)

    def declare(self, x: s.Statement, file: SourceFile, i: int, diagnostics: list[Diagnostic]) -> None:
        """Add the names that the statement in line `i` declares; a name declared twice is diagnosed."""
        if isinstance(x, StructType):
            members = {d.name.upper(): type_of(kind, d) for kind, declarators in x.members for d in declarators}
            self.structures[x.name.upper()] = members
        elif isinstance(x, EnumType):
            self.enums[x.name.upper()] = frozenset(member.upper() for member in x.members)
        elif isinstance(x, External):
            self.externals[x.name.upper()] = x
        elif isinstance(x, Signal):
            kind = Type("BOOL" if x.last is None else "INT")
            self._enter(DeclaredName(x.name, kind, file.position(i, x.column)), diagnostics)
        elif isinstance(x, Declaration):
            for d in x.names:
                name = DeclaredName(d.name, type_of(x.type, d), file.position(i, d.column), d, x.const)
                self._enter(name, diagnostics)

    def _enter(self, new: DeclaredName, diagnostics: list[Diagnostic]) -> None:
        key = new.name.upper()
        before = self.variables.get(key)
        if before is not None and before.declarator is None and before.type.name == "?":
            # a parameter: DECL gives it its type
            kind = Type(new.type.name, max(before.type.dimensions, new.type.dimensions))
            self.variables[key] = DeclaredName(before.name, kind, before.position)
            return
        if before is not None and before.position.file == new.position.file:
            message = f"{new.name} is declared twice, before in line {before.position.line}"
            diagnostics.append(Diagnostic(new.position, "error", "duplicate-name", message, "rename or remove one"))
        self.variables[key] = new

    def structure(self, name: str) -> Mapping[str, Type] | None:
        """The components of a structure, declared or predefined; None for another name."""
        return self.structures.get(name) or STRUCTURES.get(name)


def type_of(kind: str | None, declarator: Declarator) -> Type:
    """The type of a declared name; unknown where the declaration has no type."""
    dimensions = 0 if declarator.sizes is None else max(len(declarator.sizes), 1)
    return Type("?" if kind is None else kind.upper(), dimensions)


@dataclass(slots=True)
class Scope:
    """The names that one routine sees: its own, then the program's, then the controller's."""

    program: Program
    own: SymbolTable
    file: SourceFile
    diagnostics: list[Diagnostic]
    routine: Routine | None = None
    """None for a `.dat`."""
    line: int = 0

    def report(self, column: int, code: str, message: str, hint: str = "", severity: Severity = "error") -> None:
        """Add a diagnostic in the current line."""
        position = self.file.position(self.line, max(column, 1))
        self.diagnostics.append(Diagnostic(position, severity, code, message, hint))

    def variable(self, name: str) -> Type | None:
        """The type of a variable; None where it is not declared."""
        key = name.upper()
        for names in (self.own, self.program.names):
            if key in names.variables:
                return names.variables[key].type
        if key.startswith("$"):
            return SYSTEM.get(key, UNKNOWN)
        return CONFIG.get(key)

    def structure(self, name: str) -> Mapping[str, Type] | None:
        """The components of a structure; None for another name."""
        return self.own.structure(name) or self.program.names.structure(name)

    def enum(self, name: str) -> frozenset[str] | None:
        """The members of an enumeration; None for another name."""
        return self.own.enums.get(name) or self.program.names.enums.get(name) or ENUMS.get(name)

    def is_type(self, name: str) -> bool:
        """Whether a type of that name exists."""
        return name in SIMPLE or name == "?" or self.structure(name) is not None or self.enum(name) is not None

    def near(self, name: str) -> str:
        """A hint for a name that is not declared: a similar one, or where to declare it."""
        known = {v.name for names in (self.own, self.program.names) for v in names.variables.values()}
        near = get_close_matches(name, sorted(known), n=1, cutoff=0.5)
        if near:
            return f"did you mean {near[0]}?"
        where = "" if self.program.data is not None else "; no .dat is there"
        return f"declare it in the .dat or with DECL{where}"


def scope_of(program: Program, routine: Routine, diagnostics: list[Diagnostic]) -> Scope:
    """The names that a routine sees: its parameters and declarations, anywhere in its body, and the program's."""
    own = SymbolTable()
    for p in routine.head.parameters:
        position = routine.file.position(routine.first - 1, p.column)
        own.variables[p.name.upper()] = DeclaredName(p.name, Type("?", p.dimensions), position)
    for i, x in routine.lines():
        own.declare(x, routine.file, i, diagnostics)
    return Scope(program, own, routine.file, diagnostics, routine)


def signature(scope: Scope, x: e.FunctionCall) -> tuple[Type | None, int, int]:
    """The type that a call returns (None: no value), and the least and most arguments it takes."""
    key = x.name.upper()
    routine = scope.program.routine(x.name)
    if routine is not None:
        kind = routine.head.returns
        returned = None if kind is None else Type(kind.upper(), int(routine.head.returns_array))
        return returned, 0, len(routine.head.parameters)
    external = scope.own.externals.get(key) or scope.program.names.externals.get(key)
    if external is not None:
        return (None if external.returns is None else Type(external.returns.upper())), 0, len(external.parameters)
    if key in FUNCTIONS:
        function = FUNCTIONS[key]
        return function.returns, function.least, function.most
    if scope.variable(x.name) is None:
        near = get_close_matches(key, [r.name for r in scope.program.routines] + list(FUNCTIONS), n=1)
        hint = f"did you mean {near[0]}?" if near else "define it, declare it with EXT, or name its file with --with"
        scope.report(x.column, "undeclared", f"the subprogram {x.name} is not known", hint)
    else:
        scope.report(x.column, "type", f"{x.name} is a variable, no subprogram", "an array takes square brackets")
    return UNKNOWN, 0, LARGEST
