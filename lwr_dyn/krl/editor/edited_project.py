"""The KRL files of a folder as an editor has them: texts that are open stand in the place of those on disk."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.krl.checks.static_checks import static_diagnostics
from lwr_dyn.krl.diagnostics import Diagnostic, SourcePosition, sorted_diagnostics
from lwr_dyn.krl.editor.referents import LineContext, Referent, line_context, referent_at, referents_in
from lwr_dyn.krl.language.lexer import Token
from lwr_dyn.krl.language.source import parse_text, read_source
from lwr_dyn.krl.names.known import KnownNames
from lwr_dyn.krl.names.names_file import known_names
from lwr_dyn.krl.project.folder import is_program_file, read_files
from lwr_dyn.krl.project.module import ModuleFile, module_file
from lwr_dyn.krl.project.program import Program, program_in
from lwr_dyn.krl.project.project import Project, project_of
from lwr_dyn.krl.project.scope import Scope

LOST = "\ufffd"
"""Stands in a text where bytes could not be decoded."""


@dataclass(slots=True, eq=False)
class EditedProject:
    """A folder's files, read when they are first asked for; `whole` is whether its folders belong to it."""

    folder: Path
    whole: bool = True
    known: KnownNames = field(default_factory=known_names)
    """Names that need no declaration."""
    texts: dict[str, str] = field(default_factory=dict)
    """Of the files that are open, by their names: paths within the folder, with /."""
    _project: Project | None = None
    _programs: dict[str, Program] = field(default_factory=dict)

    @property
    def project(self) -> Project:
        """All files as they are now."""
        if self._project is None:
            files = {x.file.name: x for x in self._on_disk()}
            files.update((name, _parsed(name, text)) for name, text in self.texts.items())
            self._keep(project_of(files.values(), self.folder))
        assert self._project is not None
        return self._project

    def set_text(self, name: str, text: str) -> None:
        """Put the editor's text in the place of a file."""
        if self.texts.get(name) == text:
            return
        self.texts[name] = text
        if self._project is not None:
            self._keep(project_of([*self._others(name), _parsed(name, text)], self.folder))

    def reread(self, name: str) -> None:
        """Take a file from the disk again, or leave it out where it is gone; an open one stays as it is."""
        if name in self.texts or self._project is None:
            return
        path = self.folder / name
        belongs = is_program_file(path) and path.is_file() and (self.whole or path.parent == self.folder)
        self._keep(project_of([*self._others(name), *(_read([path], self.folder) if belongs else ())], self.folder))

    def close(self, name: str) -> None:
        """The editor has closed a file: what is on disk counts again."""
        self.texts.pop(name, None)
        self.reread(name)

    def program(self, name: str) -> Program:
        """The program of a file's module."""
        module = self.project.homes[name]
        key = str(module.path)
        if key not in self._programs:
            self._programs[key] = program_in(self.project, module)
        return self._programs[key]

    def diagnostics(self, name: str) -> dict[str, tuple[Diagnostic, ...]]:
        """The diagnostics of a file and of the others of its module, by name."""
        program = self.program(name)
        names = [x.file.name for x in program.module.files]
        twins = [d for d in self.project.twins() if d.position.file in names]
        found = sorted_diagnostics([*program.diagnostics, *static_diagnostics(program), *twins])
        lost = {x: _lost(x, self.texts[x]) for x in names if LOST in self.texts.get(x, "")}
        return {x: (*lost.get(x, ()), *(d for d in found if d.position.file == x)) for x in names}

    def at(self, name: str, line: int, column: int) -> tuple[LineContext, Token, Referent] | None:
        """What stands at a line (from 0) and column (from 1) of a file, and what it refers to."""
        program, file = self.program(name), self.project.file(name)
        if not 0 <= line < len(file.file.lines):
            return None
        context = line_context(program, file, line)
        found = referent_at(context, column)
        return None if found is None else (context, *found)

    def uses(self, wanted: Referent) -> list[SourcePosition]:
        """All places of the project that mean the same, with its declaration."""
        out: list[SourcePosition] = []
        pattern = re.compile(re.escape(wanted.name), re.IGNORECASE)
        for file in self.project.files:
            scopes: dict[int, Scope] = {}
            for i, line in enumerate(file.file.lines):
                if line.layout is None or pattern.search(line.layout) is None:
                    continue
                context = line_context(self.program(file.file.name), file, i, scopes)
                same = (token for token, found in referents_in(context, wanted.name) if found.key == wanted.key)
                out += [file.file.position(i, token.column) for token in same]
        return out

    def _keep(self, project: Project) -> None:
        self._project = project.with_known(self.known)
        self._programs.clear()

    def _others(self, name: str) -> Iterable[ModuleFile]:
        return (x for x in self.project.files if x.file.name != name)

    def _on_disk(self) -> list[ModuleFile]:
        if self.whole:
            try:
                return read_files(self.folder, self.folder)
            except FileAccessError:  # no KRL file yet
                return []
        try:
            paths = sorted(x for x in self.folder.iterdir() if is_program_file(x) and x.is_file())
        except OSError:
            return []
        return _read(paths, self.folder)


@dataclass(slots=True, eq=False)
class Session:
    """The folders that an editor has open; a file outside of them sees those beside it."""

    folders: dict[Path, EditedProject] = field(default_factory=dict)
    known: KnownNames = field(default_factory=known_names)

    def add_folder(self, folder: Path) -> None:
        """Take a folder as a project."""
        self.folders.setdefault(folder, EditedProject(folder, known=self.known))

    def place(self, path: Path) -> tuple[EditedProject, str]:
        """The project of a file, and its name there."""
        above = [x for x, project in self.folders.items() if project.whole and x in path.parents]
        folder = max(above, key=lambda x: len(x.parts), default=path.parent)
        project = self.folders.setdefault(folder, EditedProject(folder, bool(above), self.known))
        return project, os.path.relpath(path, folder).replace(os.sep, "/")


def _read(paths: Iterable[Path], folder: Path) -> list[ModuleFile]:
    out = []
    for path in paths:
        try:
            out.append(module_file(*read_source(path, os.path.relpath(path, folder).replace(os.sep, "/"))))
        except FileAccessError:  # gone meanwhile, or not ours to read
            continue
    return out


def _parsed(name: str, text: str) -> ModuleFile:
    return module_file(*parse_text(text, name))


def _lost(name: str, text: str) -> tuple[Diagnostic, ...]:
    line = text[: text.index(LOST)].count("\n") + 1
    message = "characters were lost when the editor read the file"
    hint = "KRL files are latin-1: open it again as Windows-1252, before you save"
    return (Diagnostic(SourcePosition(name, line), "warning", "encoding", message, hint),)
