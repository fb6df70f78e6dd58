"""A program: a `.src` with its `.dat`, other files that lend names, and the tables of what they declare."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from lwr_dyn.errors import FileAccessError
from lwr_dyn.krl import statements as s
from lwr_dyn.krl.declarations import Declaration, Declarator, EnumType, External, Signal, StructType
from lwr_dyn.krl.diagnosis import Diagnosis, Place
from lwr_dyn.krl.source import SourceFile, parse_bytes, read_source
from lwr_dyn.krl.structure import Routine, Structure, structure_of
from lwr_dyn.krl.types import STRUCTURES, Type


@dataclass(frozen=True, slots=True)
class Variable:
    """A declared name: what it is, where, and the declarator with its sizes and first value."""

    name: str
    type: Type
    place: Place
    declarator: Declarator | None = None
    const: bool = False


@dataclass(slots=True)
class Names:
    """What a place declares: variables, structures, enumerations, externals; names in capitals."""

    variables: dict[str, Variable] = field(default_factory=dict)
    structures: dict[str, Mapping[str, Type]] = field(default_factory=dict)
    enums: dict[str, frozenset[str]] = field(default_factory=dict)
    externals: dict[str, External] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """A `.src`, its `.dat` where there is one, and files that lend names (`$config.dat`, other programs)."""

    source: SourceFile
    data: SourceFile | None
    lent: tuple[SourceFile, ...]
    structures: Mapping[str, Structure]
    """Of each file, by its name."""
    names: Names
    """Of the `.dat` and of what is lent."""
    found: tuple[Diagnosis, ...]
    """Faults of lines and blocks."""

    @property
    def routines(self) -> list[Routine]:
        """Those of the `.src`, the main one first."""
        return self.structures[self.source.name].routines

    def routine(self, name: str) -> Routine | None:
        """A routine by name in any case: first of the `.src`, then the main ones and globals of lent files."""
        for routine in self.routines:
            if routine.name == name.upper():
                return routine
        for file in self.lent:
            for i, routine in enumerate(self.structures[file.name].routines):
                if routine.name == name.upper() and (i == 0 or routine.head.is_global):
                    return routine
        return None


def program_of(source: SourceFile, data: SourceFile | None = None, lent: Sequence[SourceFile] = (),
               found: Sequence[Diagnosis] = ()) -> Program:  # fmt: skip
    """A program of files that are already read; `found` are the faults of their lines."""
    files = [source, *([data] if data is not None else []), *lent]
    structures = {file.name: structure_of(file) for file in files}
    said = [d for file in files[: 2 if data is not None else 1] for d in structures[file.name].found]
    names = Names()
    for file in reversed(files):
        for i, statement in _declared_in(structures[file.name], file):
            declare(names, statement, file, i, said if file in files[:2] else [])
    return Program(source, data, tuple(lent), structures, names, (*found, *said))


def parse_program(source: str | bytes, data: str | bytes | None = None, name: str = "program") -> Program:
    """A program from the texts of its `.src` and `.dat`; no input raises."""
    src, found = parse_bytes(_bytes(source), f"{name}.src")
    if data is None:
        return program_of(src, None, (), found)
    dat, more = parse_bytes(_bytes(data), f"{name}.dat")
    return program_of(src, dat, (), (*found, *more))


def load_program(path: str | Path, also: Iterable[str | Path] = ()) -> Program:
    """A `.src` with the `.dat` of its name beside it; `also` are files that lend names, of lines that can be read.

    Raises `FileAccessError`.
    """
    target = Path(path)
    if target.suffix.lower() != ".src":
        raise FileAccessError(str(path), f"ends in {target.suffix or 'nothing'!r}", "a .src file")
    source, found = read_source(target)
    beside = _beside(target)
    data, more = read_source(beside) if beside is not None else (None, ())
    for other in also:
        if Path(other).suffix.lower() not in (".src", ".dat"):
            raise FileAccessError(str(other), f"ends in {Path(other).suffix or 'nothing'!r}", "a .src or .dat file")
    lent = [read_source(other)[0] for other in also]
    return program_of(source, data, lent, (*found, *more))


def declare(names: Names, x: s.Statement, file: SourceFile, i: int, found: list[Diagnosis]) -> None:
    """Enter what a declaration declares; a name that is there already is diagnosed."""
    if isinstance(x, StructType):
        members = {d.name.upper(): type_of(kind, d) for kind, declarators in x.members for d in declarators}
        names.structures[x.name.upper()] = members
    elif isinstance(x, EnumType):
        names.enums[x.name.upper()] = frozenset(member.upper() for member in x.members)
    elif isinstance(x, External):
        names.externals[x.name.upper()] = x
    elif isinstance(x, Signal):
        kind = Type("BOOL" if x.last is None else "INT")
        _enter(names, Variable(x.name, kind, file.place(i, x.column)), found)
    elif isinstance(x, Declaration):
        for d in x.names:
            _enter(names, Variable(d.name, type_of(x.type, d), file.place(i, d.column), d, x.const), found)


def type_of(kind: str | None, declarator: Declarator) -> Type:
    """The type of a declared name; where the type is forgotten, what its first value shows."""
    dimensions = 0 if declarator.sizes is None else max(len(declarator.sizes), 1)
    return Type("?" if kind is None else kind.upper(), dimensions)


def known_structure(names: Names, name: str) -> Mapping[str, Type] | None:
    """The components of a structure that is built in or declared."""
    return names.structures.get(name) or STRUCTURES.get(name)


def _enter(names: Names, variable: Variable, found: list[Diagnosis]) -> None:
    key = variable.name.upper()
    before = names.variables.get(key)
    if before is not None and before.declarator is None and before.type.name == "?":
        # a parameter: DECL gives it its type
        kind = Type(variable.type.name, max(before.type.dimensions, variable.type.dimensions))
        names.variables[key] = Variable(before.name, kind, before.place)
        return
    if before is not None and before.place.file == variable.place.file:
        message = f"{variable.name} is declared twice, before in line {before.place.line}"
        found.append(Diagnosis(variable.place, "error", "duplicate-name", message, "rename or remove one"))
    names.variables[key] = variable


def _declared_in(structure: Structure, file: SourceFile) -> Iterable[tuple[int, s.Statement]]:
    """Declarations of a `.dat`; of a `.src` what stands before its first DEF."""
    if file.is_data:
        return structure.data
    inside = structure.routines[0].first - 1 if structure.routines else len(file.lines)
    pairs = ((i, line.statement) for i, line in enumerate(file.lines[:inside]))
    return [(i, x) for i, x in pairs if x is not None]


def _beside(path: Path) -> Path | None:
    """The `.dat` beside a `.src`, its name in any case."""
    try:
        siblings = sorted(path.parent.iterdir())
    except OSError:
        return None
    wanted = path.with_suffix(".dat").name.lower()
    return next((p for p in siblings if p.name.lower() == wanted and p.is_file()), None)


def _bytes(text: str | bytes) -> bytes:
    if isinstance(text, bytes):
        return text
    try:
        return text.encode("latin-1")
    except UnicodeEncodeError:
        return text.encode("utf-8", "replace")
