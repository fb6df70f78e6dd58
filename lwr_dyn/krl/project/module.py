"""A module: a `.src` or `.sub` and the `.dat` of its name, what they declare, and what of it other modules see."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

from lwr_dyn.krl.diagnostics import Diagnostic
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import FileOutline, outline_of
from lwr_dyn.krl.language.declarations import DefDat
from lwr_dyn.krl.language.source import SourceFile
from lwr_dyn.krl.project.symbols import SymbolTable

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
    at = next((i for i, line in enumerate(file.lines) if isinstance(line.statement, DefDat)), None)
    head = None if at is None else file.lines[at].statement
    if at is None or not isinstance(head, DefDat):
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
