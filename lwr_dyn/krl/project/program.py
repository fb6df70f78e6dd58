"""A program: a `.src`, its `.dat`, included files, and the symbol table of their declarations."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lwr_dyn.errors import FileAccessError
from lwr_dyn.krl.diagnostics import Diagnostic
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import FileOutline, Routine, outline_of
from lwr_dyn.krl.language.source import SourceFile, parse_bytes, read_source
from lwr_dyn.krl.project.symbols import SymbolTable


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """A `.src`, its `.dat` if it has one, and included files (`$config.dat`, other programs)."""

    source: SourceFile
    data: SourceFile | None
    included: tuple[SourceFile, ...]
    outlines: Mapping[str, FileOutline]
    """Of each file, by its name."""
    names: SymbolTable
    """Of the `.dat` and of the included files."""
    diagnostics: tuple[Diagnostic, ...]
    """Faults of lines and blocks."""

    @property
    def routines(self) -> list[Routine]:
        """Those of the `.src`, the main one first."""
        return self.outlines[self.source.name].routines

    def routine(self, name: str) -> Routine | None:
        """A routine by its name in any case: of the `.src`, else the main or a global one of an included file."""
        for routine in self.routines:
            if routine.name == name.upper():
                return routine
        for file in self.included:
            for i, routine in enumerate(self.outlines[file.name].routines):
                if routine.name == name.upper() and (i == 0 or routine.head.is_global):
                    return routine
        return None


def program_of(source: SourceFile, data: SourceFile | None = None, included: Sequence[SourceFile] = (),
               diagnostics: Sequence[Diagnostic] = ()) -> Program:  # fmt: skip
    """A program of files that are already read, with the diagnostics of their lines."""
    own = [source, *([data] if data is not None else [])]
    files = [*own, *included]
    outlines = {file.name: outline_of(file) for file in files}
    of_blocks = [d for file in own for d in outlines[file.name].diagnostics]
    names = SymbolTable()
    for file in reversed(files):
        for i, statement in _declared_in(outlines[file.name], file):
            names.declare(statement, file, i, of_blocks if file in own else [])
    return Program(source, data, tuple(included), outlines, names, (*diagnostics, *of_blocks))


def parse_program(source: str | bytes, data: str | bytes | None = None, name: str = "program") -> Program:
    """A program from the texts of its `.src` and `.dat`; no input raises."""
    src, diagnostics = parse_bytes(_bytes(source), f"{name}.src")
    if data is None:
        return program_of(src, None, (), diagnostics)
    dat, more = parse_bytes(_bytes(data), f"{name}.dat")
    return program_of(src, dat, (), (*diagnostics, *more))


def load_program(path: str | Path, include: Iterable[str | Path] = ()) -> Program:
    """A `.src` with the `.dat` of its name beside it; faults in the files to `include` are not diagnosed.

    Raises `FileAccessError`.
    """
    target = Path(path)
    if target.suffix.lower() != ".src":
        raise FileAccessError(str(path), f"ends in {target.suffix or 'nothing'!r}", "a .src file")
    source, diagnostics = read_source(target)
    beside = _beside(target)
    data, more = read_source(beside) if beside is not None else (None, ())
    for other in include:
        if Path(other).suffix.lower() not in (".src", ".dat"):
            raise FileAccessError(str(other), f"ends in {Path(other).suffix or 'nothing'!r}", "a .src or .dat file")
    included = [read_source(other)[0] for other in include]
    return program_of(source, data, included, (*diagnostics, *more))


def _declared_in(outline: FileOutline, file: SourceFile) -> Iterable[tuple[int, s.Statement]]:
    """The declarations of a `.dat`; of a `.src` the statements before its first DEF."""
    if file.is_data:
        return outline.data
    inside = outline.routines[0].first - 1 if outline.routines else len(file.lines)
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
