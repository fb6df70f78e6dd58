"""A program: one module of a project, with all the names that it sees; and how files and folders become one.

A scope is what one of its routines sees. A name that nothing declares is reported once a file, where it stands first,
with its number of places.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from pathlib import Path

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.krl.diagnostics import Diagnostic, Severity, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.declarations import External
from lwr_dyn.krl.language.source import SourceFile, data_beside, krl_files, parse_bytes, read_source
from lwr_dyn.krl.names.known_names import GEOMETRY, LARGEST, SIMPLE, UNKNOWN, KnownNames, Type
from lwr_dyn.krl.project.project import DeclaredName, Module, ModuleFile, Project, SymbolTable, module_file, project_of


def load_project(folder: str | Path) -> Project:
    """All `.src`, `.sub` and `.dat` files of a folder and its folders.

    Raises
    ------
    FileAccessError
        It is no folder that can be read, or holds no such file.
    """
    path = Path(folder)
    if not path.is_dir():
        raise FileAccessError(str(folder), "no folder", "a folder of .src, .sub and .dat files")
    return project_of((read_file(x, path) for x in krl_files(path)), path)


def read_file(path: Path, folder: Path) -> ModuleFile:
    """A KRL file, named by its path from a folder, with /; raises `FileAccessError`."""
    return module_file(*read_source(path, os.path.relpath(path, folder).replace(os.sep, "/")))


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """A module of a project: a `.src` or `.sub` with its `.dat`, or a `.dat` alone; made by `program_in`."""

    project: Project
    module: Module
    names: SymbolTable
    """All that the module sees, its own names before those of others."""
    diagnostics: tuple[Diagnostic, ...]
    """Faults of its lines, blocks and names, and of the files that are lent to it."""

    @property
    def source(self) -> SourceFile:
        """The `.src` or `.sub`; where the module has none, the `.dat`."""
        return self.module.files[0].file

    @property
    def data(self) -> SourceFile | None:
        """The `.dat`."""
        return None if self.module.data is None else self.module.data.file

    @property
    def included(self) -> tuple[SourceFile, ...]:
        """The files of the other modules."""
        own = {x.file.name for x in self.module.files}
        return tuple(x.file for x in self.project.files if x.file.name not in own)

    @property
    def routines(self) -> list[Routine]:
        """Those of the `.src`, the main one first."""
        return [] if self.module.source is None else self.module.source.outline.routines

    def routine(self, name: str) -> Routine | None:
        """A routine by its name in any case: one of its own, else the main or a global one of another module."""
        return self.names.routines.get(name.upper())


def program_in(project: Project, module: Module, diagnostics: Iterable[Diagnostic] = ()) -> Program:
    """The program of a module of a project; `diagnostics` are added to those of the module."""
    return Program(project, module, project.seen_from(module), (*module.diagnostics, *diagnostics))


def program_of(source: SourceFile, data: SourceFile | None = None, included: Sequence[SourceFile] = (),
               diagnostics: Sequence[Diagnostic] = ()) -> Program:  # fmt: skip
    """A program of files that are already read, with the diagnostics of their lines."""
    own = [module_file(x) for x in (source, data) if x is not None]
    return _program([*own, *map(module_file, included)], source.name, diagnostics)


def parse_program(source: str | bytes, data: str | bytes | None = None, name: str = "program") -> Program:
    """A program from the texts of its `.src` and `.dat`; no input raises."""
    texts = [(source, f"{name}.src"), *([(data, f"{name}.dat")] if data is not None else [])]
    files = [module_file(*parse_bytes(_bytes(text), path)) for text, path in texts]
    return _program(files, f"{name}.src")


def load_program(path: str | Path, include: Iterable[str | Path] = ()) -> Program:
    """A `.src` or `.sub` with the `.dat` of its name beside it, and files to include, or folders of them.

    A file to include brings the `.dat` beside it; of its faults only that it cannot be read is diagnosed.
    Raises `FileAccessError`.
    """
    target = Path(path)
    if target.suffix.lower() not in (".src", ".sub"):
        raise FileAccessError(str(path), f"ends in {target.suffix or 'nothing'!r}", "a .src or .sub file")
    files = {x.file.name: x for x in _with_data([target], target.parent)}
    own = set(files)
    for other in map(Path, include):
        for x in _with_data(krl_files(other), target.parent):
            files.setdefault(x.file.name, x)
    faults = [d for name, x in files.items() if name not in own for d in _unreadable(x)]
    return _program(list(files.values()), target.name, faults, target.parent)


def _program(
    files: Sequence[ModuleFile], name: str, diagnostics: Sequence[Diagnostic] = (), folder: Path | None = None
) -> Program:
    project = project_of(files, folder)
    module = project.homes[name]
    of_name = (d for d in project.twins() if d.position.file == str(module.path))
    return program_in(project, module, (*diagnostics, *of_name))


def _with_data(paths: Sequence[Path], folder: Path) -> list[ModuleFile]:
    """The files; of a single `.src` or `.sub` also the `.dat` beside it."""
    beside = data_beside(paths[0]) if len(paths) == 1 else None
    return [read_file(x, folder) for x in (*paths, *([] if beside is None else [beside]))]


def _unreadable(x: ModuleFile) -> list[Diagnostic]:
    """A warning at the first line of a lent file that cannot be read: its names may be missing."""
    if not x.faults:
        return []
    first = x.faults[0]
    message = f"{len(x.faults)} fault{'s' * (len(x.faults) > 1)} in a lent file, names may be missing: {first.message}"
    return [Diagnostic(first.position, "warning", "lent-file", message, "check that file by itself")]


def _bytes(text: str | bytes) -> bytes:
    if isinstance(text, bytes):
        return text
    try:
        return text.encode("latin-1")
    except UnicodeEncodeError:
        return text.encode("utf-8", "replace")


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


def slip_of(name: str, known: Iterable[str], shortest: int = 4) -> str | None:
    """The known name from which one differs by one slip: a letter left out, added or replaced, or two swapped.

    Digits do not count, and known names of fewer than `shortest` characters are too short to say.

    >>> slip_of("INITMVO", ["INITMOV", "TOOL"]), slip_of("TOOL1", ["TOOL2"])
    ('INITMOV', None)
    >>> slip_of("TIMERSTOP", ["TIMER_STOP"])
    'TIMER_STOP'
    """
    upper = name.upper()
    return next((word for word in known if len(word) >= shortest and _is_slip(upper, word.upper())), None)


def _is_slip(one: str, other: str) -> bool:
    if abs(len(one) - len(other)) > 1 or one == other:
        return False
    begin = next((i for i, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), min(len(one), len(other)))
    one, other = one[begin:], other[begin:]
    while one and other and one[-1] == other[-1]:
        one, other = one[:-1], other[:-1]
    swapped = len(one) == 2 and one == other[::-1]
    return (one + other).replace("_", "A").isalpha() and (swapped or max(len(one), len(other)) == 1)


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
