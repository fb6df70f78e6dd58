"""A project: modules that see one another, as a KUKA controller sees them, and the names that they declare.

A module is a `.src` or `.sub` and the `.dat` of its name. It sees its own names, the GLOBAL names of other modules'
PUBLIC `.dat` files, all of the controller's `.dat` files, and of other modules' routines the first and the GLOBAL ones.
STEU, R1 and a second robot do not see one another.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath

from lwr_dyn.krl.diagnostics import Diagnostic, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import FileOutline, Routine, outline_of
from lwr_dyn.krl.language.declarations import Declaration, Declarator, DefDat, EnumType, External, Signal, StructType
from lwr_dyn.krl.language.source import SourceFile
from lwr_dyn.krl.names.known_names import KnownNames, Type, known_names


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
    analogue = not isinstance(x.first, e.Bool) and e.root_name(x.first) in ("$ANIN", "$ANOUT")
    return Type("INT" if x.last is not None else "REAL" if analogue else "BOOL")


def type_of(kind: str | None, declarator: Declarator) -> Type:
    """The type of a declared name; unknown where the declaration has no type."""
    dimensions = 0 if declarator.sizes is None else max(len(declarator.sizes), 1 + declarator.commas)
    sizes = tuple(x.value if isinstance(x, e.Integer) else 0 for x in declarator.sizes or ())
    return Type("?" if kind is None else kind.upper(), dimensions, sizes)


CONTROLLER_FILES = ("$", "operate")
"""A `.dat` whose name begins so belongs to the controller ($config, $machine, $custom ...): all its names are seen."""


@dataclass(frozen=True, slots=True, eq=False)
class ModuleFile:
    """A file that has been read: its routines and blocks, its names, and the faults of its lines, blocks and names."""

    file: SourceFile
    outline: FileOutline
    names: SymbolTable
    """Of a `.dat` all its names; of a `.src` its routines, and what is declared before the first."""
    shared: SymbolTable
    """Of these the ones that other modules see."""
    faults: tuple[Diagnostic, ...]
    """Of lines: the text cannot be read."""
    diagnostics: tuple[Diagnostic, ...]
    """All: of lines, of blocks, of names declared twice, and of hidden names."""


@dataclass(frozen=True, slots=True, eq=False)
class Module:
    """A `.src` or `.sub` with its `.dat`; a `.dat` may stand alone."""

    source: ModuleFile | None
    data: ModuleFile | None

    @property
    def files(self) -> tuple[ModuleFile, ...]:
        """Those that it has, the `.src` first."""
        return tuple(x for x in (self.source, self.data) if x is not None)

    @property
    def path(self) -> PurePosixPath:
        """Of its first file."""
        return PurePosixPath(self.files[0].file.name)

    @property
    def name(self) -> str:
        """In capitals."""
        return self.path.stem.upper()

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Of its files."""
        return tuple(d for x in self.files for d in x.diagnostics)


def module_file(file: SourceFile, faults: Sequence[Diagnostic] = ()) -> ModuleFile:
    """A file with its outline and names; `faults` are those of its lines."""
    outline = outline_of(file)
    of_names: list[Diagnostic] = []
    names = SymbolTable()
    for i, statement in _declared_in(outline, file):
        names.declare(statement, file, i, of_names)
    for routine in outline.routines:
        names.routines.setdefault(routine.name, routine)
    shared = _shared_data(file, names, of_names) if file.is_data else _shared_routines(outline)
    diagnostics = (*faults, *outline.diagnostics, *of_names)
    return ModuleFile(file, outline, names, shared, tuple(faults), diagnostics)


def _declared_in(outline: FileOutline, file: SourceFile) -> Iterable[tuple[int, s.Statement]]:
    """The declarations of a `.dat`; of a `.src` the statements before its first DEF."""
    if file.is_data:
        return outline.data
    inside = outline.routines[0].first - 1 if outline.routines else len(file.lines)
    pairs = ((i, line.statement) for i, line in enumerate(file.lines[:inside]))
    return [(i, x) for i, x in pairs if x is not None]


def _shared_routines(outline: FileOutline) -> SymbolTable:
    """The first routine of a `.src`, and its global ones."""
    out = SymbolTable()
    for i, routine in enumerate(outline.routines):
        if i == 0 or routine.head.is_global:
            out.routines.setdefault(routine.name, routine)
    return out


def _shared_data(file: SourceFile, names: SymbolTable, diagnostics: list[Diagnostic]) -> SymbolTable:
    """The GLOBAL names of a PUBLIC `.dat`, all names of one of the controller's; hidden names are diagnosed."""
    stem = PurePosixPath(file.name).stem
    if stem.lower().startswith(CONTROLLER_FILES):
        return names
    heads = ((i, line.statement) for i, line in enumerate(file.lines) if isinstance(line.statement, DefDat))
    at, head = next(heads, (0, None))
    if head is None:
        return SymbolTable()
    position = file.position(at, head.column)
    if head.name.upper() != stem.upper():
        message = f"DEFDAT {head.name} in the file of {stem}"
        diagnostics.append(
            Diagnostic(position, "warning", "module-name", message, f"DEFDAT {stem}, or rename the file")
        )
    shared = names.globals()
    if head.public:
        return shared
    hidden = [*(x.name for x in shared.variables.values()), *(x.name for x in shared.types.values())]
    if hidden:
        first = ", ".join(hidden[:3]) + (" ..." if len(hidden) > 3 else "")
        message = f"{len(hidden)} GLOBAL name{'s' * (len(hidden) > 1)} ({first}) that no other module sees"
        diagnostics.append(Diagnostic(position, "warning", "hidden-global", message, f"DEFDAT {head.name} PUBLIC"))
    return SymbolTable()


_PART = re.compile(r"STEU|R\d+", re.IGNORECASE)


@dataclass(frozen=True, slots=True, eq=False)
class Project:
    """Modules by the paths of their files, relative to `folder`; make one with `project_of`."""

    modules: tuple[Module, ...]
    """In the order of their paths."""
    folder: Path
    homes: Mapping[str, Module]
    """Of each file, by its name: the path within the folder."""
    parts: Mapping[Module, tuple[str, ...]]
    """Of each module, the folder up to STEU, R1, R2 ...; modules of different parts do not see each other."""
    known: KnownNames = field(default_factory=known_names)
    """Names that need no declaration."""
    _shared: dict[tuple[str, ...], SymbolTable] = field(default_factory=dict)
    _places: dict[tuple[tuple[str, ...], str], str] = field(default_factory=dict)

    def file(self, name: str) -> ModuleFile:
        """A file by its path within the folder."""
        return next(x for x in self.homes[name].files if x.file.name == name)

    @property
    def files(self) -> tuple[ModuleFile, ...]:
        """All files, module by module."""
        return tuple(x for module in self.modules for x in module.files)

    def seen_from(self, module: Module) -> SymbolTable:
        """The names that a module sees: those of the nearest folder where several modules share one, then its own."""
        folder = module.path.parent.parts
        if folder not in self._shared:
            self._shared[folder] = self._shared_with(module)
        out = self._shared[folder].copy()
        for file in reversed(module.files):
            out.update(file.names)
        return out

    def _shared_with(self, module: Module) -> SymbolTable:
        out, here = SymbolTable(), module.path.parent
        others = [x for x in self.modules if self.parts[x] == self.parts[module]]
        for other in sorted(reversed(others), key=lambda x: -_steps(here, x.path.parent)):
            for file in other.files:
                out.update(file.shared)
        return out

    def declaring(self, module: Module, name: str) -> str | None:
        """The first file of the same robot that declares a variable, routine or type, seen from the module or not."""
        if not self._places:
            for m in reversed(self.modules):
                for x in reversed(m.files):
                    keys = (*x.names.variables, *x.names.routines, *x.names.structures, *x.names.enums)
                    self._places.update(dict.fromkeys(((self.parts[m], key) for key in keys), x.file.name))
        return self._places.get((self.parts[module], name.upper()))

    def nearest(self, module: Module, name: str) -> Path | None:
        """The path of the nearest file of that name, in any case, of the same robot as the module."""
        own = (m for m in self.modules if self.parts[m] == self.parts[module])
        paths = [PurePosixPath(x.file.name) for m in own for x in m.files]
        same = [x for x in paths if x.name.upper() == name.upper()]
        here = module.path.parent
        return self.folder / min(same, key=lambda x: _steps(here, x.parent)) if same else None

    def twins(self) -> tuple[Diagnostic, ...]:
        """A warning at each module whose name another one of the same robot has."""
        named: dict[tuple[tuple[str, ...], str], list[Module]] = {}
        for module in self.modules:
            named.setdefault((self.parts[module], module.name), []).append(module)
        out = []
        for (_, name), same in named.items():
            for module in same if len(same) > 1 else ():
                other = next(x for x in same if x is not module)
                message = f"the module {name} is there {len(same)} times, also as {other.path}"
                hint = "rename or remove it: the one in the nearest folder is taken"
                out.append(Diagnostic(SourcePosition(str(module.path), 1), "warning", "module-twice", message, hint))
        return tuple(out)

    def with_known(self, known: KnownNames) -> Project:
        """The project with other names that need no declaration: those of `known_names(files)`."""
        return replace(self, known=known)


def project_of(files: Iterable[ModuleFile], folder: Path | None = None) -> Project:
    """A project of files that are already read; their names are paths within `folder`, with /."""
    by_key: dict[tuple[str, str], list[ModuleFile]] = {}
    for x in files:
        path = PurePosixPath(x.file.name)
        by_key.setdefault((str(path.parent).upper(), path.stem.upper()), []).append(x)
    modules = [m for group in by_key.values() for m in _modules(group)]
    modules = sorted(_joined(modules), key=lambda m: (str(m.path).upper(), str(m.path)))
    homes = {x.file.name: m for m in modules for x in m.files}
    return Project(tuple(modules), folder or Path(), homes, _parts(modules))


def _modules(group: Sequence[ModuleFile]) -> list[Module]:
    """The modules of the files of one name, in any case, in one folder; a `.dat` goes with the name written alike."""
    data = [x for x in group if x.file.is_data]
    sources = [x for x in group if not x.file.is_data]
    alike = {PurePosixPath(x.file.name).stem: x for x in reversed(data)}
    pairs = [Module(x, alike.get(PurePosixPath(x.file.name).stem, data[0] if data else None)) for x in sources]
    used = {id(m.data) for m in pairs}
    return [*pairs, *(Module(None, x) for x in data if id(x) not in used)]


def _joined(modules: list[Module]) -> list[Module]:
    """A `.src` without a `.dat` gets the one of its name that stands alone in another folder, if there is one only."""
    alone: dict[tuple[tuple[str, ...], str], list[Module]] = {}
    for m in modules:
        if m.source is None or m.data is None:
            alone.setdefault((_part(m.path), m.name), []).append(m)
    pairs = [x for x in alone.values() if len(x) == 2 and (x[0].source is None) != (x[1].source is None)]
    joined = [Module(a.source or b.source, a.data or b.data) for a, b in pairs]
    gone = {id(m) for pair in pairs for m in pair}
    return [m for m in modules if id(m) not in gone] + joined


def _parts(modules: Sequence[Module]) -> dict[Module, tuple[str, ...]]:
    """The part of each module; one outside of all belongs to the robot's if there is one only."""
    found = {m: _part(m.path) for m in modules}
    robots = {part for part in found.values() if part and part[-1] != "STEU"}
    rest = next(iter(robots)) if len(robots) == 1 else ()
    return {m: part or rest for m, part in found.items()}


def _part(path: PurePosixPath) -> tuple[str, ...]:
    parts = path.parent.as_posix().upper().split("/")
    at = next((i for i, x in enumerate(parts) if _PART.fullmatch(x)), None)
    return () if at is None else tuple(parts[: at + 1])


def _steps(a: PurePosixPath, b: PurePosixPath) -> int:
    """The folders on the way from one to another."""
    same = 0
    for x, y in zip(a.parts, b.parts, strict=False):
        if x.upper() != y.upper():
            break
        same += 1
    return len(a.parts) + len(b.parts) - 2 * same
