"""Symbol tables: the declared names of a routine and of a program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from lwr_dyn.krl.diagnostics import Diagnostic, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.declarations import Declaration, Declarator, EnumType, External, Signal, StructType
from lwr_dyn.krl.language.source import SourceFile
from lwr_dyn.krl.names.known_names import Type


@dataclass(frozen=True, slots=True, eq=False)
class DeclaredName:
    """A declared variable: its type and position, and the declarator with its sizes and initial value."""

    name: str
    type: Type
    position: SourcePosition
    declarator: Declarator | None = None
    const: bool = False
    is_global: bool = False
    signal: Signal | None = None
    """What a SIGNAL stands for."""


@dataclass(slots=True)
class SymbolTable:
    """The declarations of a routine, of a file, or of all that a module sees; keys in capitals."""

    variables: dict[str, DeclaredName] = field(default_factory=dict)
    structures: dict[str, Mapping[str, Type]] = field(default_factory=dict)
    enums: dict[str, frozenset[str]] = field(default_factory=dict)
    externals: dict[str, External] = field(default_factory=dict)
    routines: dict[str, Routine] = field(default_factory=dict)
    types: dict[str, DeclaredName] = field(default_factory=dict)
    """Where each structure (of type STRUC), enumeration (ENUM) and external subprogram (EXT) is declared."""

    def copy(self) -> SymbolTable:
        """A table of its own with the same names."""
        return SymbolTable(*(dict(getattr(self, name)) for name in self.__slots__))

    def update(self, other: SymbolTable) -> None:
        """Add the names of another table; they hide equal ones."""
        for name in self.__slots__:
            getattr(self, name).update(getattr(other, name))

    def globals(self) -> SymbolTable:
        """The names that are declared GLOBAL, without routines."""
        types = {key: x for key, x in self.types.items() if x.is_global}
        return SymbolTable(
            variables={key: x for key, x in self.variables.items() if x.is_global},
            structures={key: x for key, x in self.structures.items() if key in types},
            enums={key: x for key, x in self.enums.items() if key in types},
            types=types,
        )

    def declare(self, x: s.Statement, file: SourceFile, i: int, diagnostics: list[Diagnostic]) -> None:
        """Add the names that the statement in line `i` declares; a name declared twice is diagnosed."""
        if isinstance(x, StructType):
            members = {d.name.upper(): type_of(kind, d) for kind, declarators in x.members for d in declarators}
            self.structures[x.name.upper()] = members
            self._place(x, "STRUC", file.position(i, x.column), x.is_global)
        elif isinstance(x, EnumType):
            self.enums[x.name.upper()] = frozenset(member.upper() for member in x.members)
            self._place(x, "ENUM", file.position(i, x.column), x.is_global)
        elif isinstance(x, External):
            self.externals[x.name.upper()] = x
            self._place(x, "EXT", file.position(i, x.column), False)
        elif isinstance(x, Signal):
            position = file.position(i, x.column)
            self._enter(DeclaredName(x.name, _signal_type(x), position, is_global=x.is_global, signal=x), diagnostics)
        elif isinstance(x, Declaration):
            for d in x.names:
                position = file.position(i, d.column)
                name = DeclaredName(d.name, type_of(x.type, d), position, d, x.const, x.is_global)
                self._enter(name, diagnostics)

    def _place(self, x: StructType | EnumType | External, kind: str, position: SourcePosition, shared: bool) -> None:
        self.types[x.name.upper()] = DeclaredName(x.name, Type(kind), position, is_global=shared)

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


def _signal_type(x: Signal) -> Type:
    """A group of outputs is a whole number, an analogue one REAL, a single one BOOL."""
    root: e.Expression = x.first
    while isinstance(root, e.Index | e.Component):
        root = root.of
    analogue = isinstance(root, e.Name) and root.name.upper() in ("$ANIN", "$ANOUT")
    return Type("INT" if x.last is not None else "REAL" if analogue else "BOOL")


def type_of(kind: str | None, declarator: Declarator) -> Type:
    """The type of a declared name; unknown where the declaration has no type."""
    dimensions = 0 if declarator.sizes is None else max(len(declarator.sizes), 1 + declarator.commas)
    sizes = tuple(x.value if isinstance(x, e.Integer) else 0 for x in declarator.sizes or ())
    return Type("?" if kind is None else kind.upper(), dimensions, sizes)
