"""A program: one module of a project, with all the names that it sees; and how files and folders become one."""

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.krl.diagnostics import Diagnostic
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.source import SourceFile, data_beside, krl_files, parse_bytes, read_source
from lwr_dyn.krl.project.project import Module, ModuleFile, Project, SymbolTable, module_file, project_of


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
