"""The names that a routine sees.

One that nothing declares is reported once a file, where it stands first, with its number of places.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches

from lwr_dyn.krl.diagnostics import Diagnostic, Severity, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.declarations import External
from lwr_dyn.krl.language.source import SourceFile
from lwr_dyn.krl.names.known_names import GEOMETRY, LARGEST, SIMPLE, UNKNOWN, KnownNames, Type
from lwr_dyn.krl.project.program import Program
from lwr_dyn.krl.project.project import DeclaredName, SymbolTable

NEAR_NAMES = 20
"""Names of a file for which a similar known one is looked for: that takes milliseconds each."""
COMPARED = 300
"""Known names that are compared letter by letter with an unknown one."""
SAME_LETTERS = 0.6
"""Share of the letters of an unknown name that a similar one has."""


@dataclass(slots=True, eq=False)
class UnknownNames:
    """The unknown names of one file, in the order in which they were met."""

    found: dict[str, Diagnostic] = field(default_factory=dict)
    """By message in capitals: at the first place."""
    places: dict[str, int] = field(default_factory=dict)

    def note(
        self, position: SourcePosition, code: str, message: str, name: str, known: Iterable[str], hint: str
    ) -> None:
        """Count a place; at the first one, look for a similar name among those that are known."""
        key = message.upper()
        self.places[key] = self.places.get(key, 0) + 1
        if key in self.found:
            return
        near = near_name(name, known) if len(self.found) < NEAR_NAMES else None
        hint = hint if near is None else f"did you mean {near}?"
        self.found[key] = Diagnostic(position, "error", code, message, hint)

    def diagnostics(self) -> Iterator[Diagnostic]:
        """One of each name."""
        for key, diagnostic in self.found.items():
            n = self.places[key]
            yield diagnostic if n == 1 else replace(diagnostic, message=f"{diagnostic.message} ({n} places)")


def near_name(name: str, known: Iterable[str]) -> str | None:
    """The most similar of the known names in any case; None where none is similar.

    >>> near_name("hight", ["HEIGHT", "WIDTH"])
    'HEIGHT'
    """
    upper = name.upper()
    letters, reach = set(upper), 1 + len(upper) // 4
    by_capitals = {
        key: word for word in known if abs(len(word) - len(upper)) <= reach
        and len(letters.intersection(key := word.upper())) >= SAME_LETTERS * len(letters)
    }  # fmt: skip
    by_length = sorted(by_capitals, key=lambda key: (abs(len(key) - len(upper)), key))
    near = get_close_matches(upper, by_length[:COMPARED], n=1, cutoff=0.6)
    return by_capitals[near[0]] if near else None


def slip_of(name: str, known: Iterable[str]) -> str | None:
    """The known name from which one differs by one slip: a letter left out, added or replaced, or two swapped.

    Digits do not count, and names of three letters are too short to tell.

    >>> slip_of("INITMVO", ["INITMOV", "TOOL"]), slip_of("TOOL1", ["TOOL2"])
    ('INITMOV', None)
    """
    upper = name.upper()
    return next((word for word in known if len(word) > 3 and _is_slip(upper, word.upper())), None)


def _is_slip(one: str, other: str) -> bool:
    if abs(len(one) - len(other)) > 1 or one == other:
        return False
    begin = next((i for i, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), min(len(one), len(other)))
    one, other = one[begin:], other[begin:]
    while one and other and one[-1] == other[-1]:
        one, other = one[:-1], other[:-1]
    swapped = len(one) == 2 and one == other[::-1]
    return (one + other).isalpha() and (swapped or max(len(one), len(other)) == 1)


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
    unknown: UnknownNames = field(default_factory=UnknownNames)
    """Of the file."""

    @property
    def known(self) -> KnownNames:
        """The names that need no declaration."""
        return self.program.project.known

    @property
    def tables(self) -> tuple[SymbolTable, SymbolTable]:
        """What is declared, the own names first."""
        return self.own, self.program.names

    def silent(self) -> Scope:
        """The same names; what is reported in it is not kept."""
        return Scope(self.program, self.own, self.file, [], self.routine, self.line)

    def report_unknown(self, column: int, code: str, message: str, name: str, known: Iterable[str], hint: str) -> None:
        """Note an unknown name; the hint is the file that hides it, or for the first ones of a file a similar name."""
        hidden = self.program.project.declaring(self.program.module, name)
        if hidden is not None:
            known, hint = (), f"{hidden} declares it, but not for other modules: GLOBAL, and PUBLIC in a .dat"
        self.unknown.note(self.file.position(self.line, max(column, 1)), code, message, name, known, hint)

    def report(self, column: int, code: str, message: str, hint: str = "", severity: Severity = "error") -> None:
        """Add a diagnostic in the current line."""
        position = self.file.position(self.line, max(column, 1))
        self.diagnostics.append(Diagnostic(position, severity, code, message, hint))

    def variable(self, name: str) -> Type | None:
        """The type of a variable; None where it is not declared."""
        key = name.upper()
        for names in self.tables:
            if key in names.variables:
                return self.type_seen(names.variables[key].type)
        return self.known.variables.get(key, UNKNOWN if key.startswith("$") else None)

    def type_seen(self, kind: Type) -> Type:
        """A type as declared; unknown if nothing declares that type: then nothing more can be said of its values."""
        return kind if self.is_type(kind.name) else Type(UNKNOWN.name, kind.dimensions, kind.sizes)

    def structure(self, name: str) -> Mapping[str, Type] | None:
        """The components of a structure; None for another name."""
        own = next((x.structures[name] for x in self.tables if name in x.structures), None)
        return own or self.known.structures.get(name)

    def enum(self, name: str) -> frozenset[str] | None:
        """The members of an enumeration; None for another name."""
        return self.own.enums.get(name) or self.program.names.enums.get(name) or self.known.enums.get(name)

    def is_foreign(self, name: str) -> bool:
        """Whether a type is one of the controller's or of an option's, whose members differ between versions."""
        return name not in GEOMETRY and not any(name in x.structures or name in x.enums for x in self.tables)

    def is_open(self, name: str) -> bool:
        """Whether a type of the controller or of an option has members that are not listed here."""
        return name in self.known.open and self.is_foreign(name)

    def external(self, name: str) -> External | None:
        """The declaration with EXT of a subprogram; None where there is none."""
        return self.own.externals.get(name.upper()) or self.program.names.externals.get(name.upper())

    def is_type(self, name: str) -> bool:
        """Whether a type of that name exists."""
        return name in SIMPLE or name == "?" or self.structure(name) is not None or self.enum(name) is not None

    def report_variable(self, column: int, name: str) -> None:
        """Note a variable that nothing declares."""
        known = (v.name for names in self.tables for v in names.variables.values())
        where = "" if self.program.data is not None else "; no .dat is there"
        hint = f"declare it in the .dat or with DECL{where}"
        self.report_unknown(column, "undeclared", f"{name} is not declared", name, known, hint)


def scope_of(
    program: Program, routine: Routine, diagnostics: list[Diagnostic], unknown: UnknownNames | None = None
) -> Scope:
    """The names that a routine sees: its parameters and declarations, anywhere in its body, and the program's."""
    own = SymbolTable()
    for p in routine.head.parameters:
        position = routine.file.position(routine.first - 1, p.column)
        own.variables[p.name.upper()] = DeclaredName(p.name, Type("?", p.dimensions), position)
    for i, x in routine.lines():
        own.declare(x, routine.file, i, diagnostics)
    return Scope(program, own, routine.file, diagnostics, routine, unknown=unknown or UnknownNames())


def signature(scope: Scope, x: e.FunctionCall) -> tuple[Type | None, int, int]:
    """The type that a call returns (None: no value), and the least and most arguments it takes."""
    key = x.name.upper()
    routine = scope.program.routine(x.name)
    if routine is not None:
        kind = routine.head.returns
        dimensions = int(routine.head.returns_sizes is not None)
        returned = None if kind is None else scope.type_seen(Type(kind.upper(), dimensions))
        return returned, 0, len(routine.head.parameters)
    external = scope.external(x.name)
    if external is not None:
        return (None if external.returns is None else Type(external.returns.upper())), 0, len(external.parameters)
    if key in scope.known.functions:
        function = scope.known.functions[key]
        return function.returns, function.least, function.most
    if scope.variable(x.name) in (None, UNKNOWN):
        hint = "define it, declare it with EXT, or lend its file with --with, its names with --names"
        known = (*scope.program.names.routines, *scope.known.functions)
        scope.report_unknown(x.column, "unknown-call", f"the subprogram {x.name} is not known", x.name, known, hint)
    else:
        scope.report(x.column, "type", f"{x.name} is a variable, no subprogram", "an array takes square brackets")
    return UNKNOWN, 0, LARGEST
