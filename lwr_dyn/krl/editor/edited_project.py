"""The KRL files of a folder as an editor has them: texts that are open stand in the place of those on disk."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.krl.checks.static_checks import static_diagnostics
from lwr_dyn.krl.diagnostics import Diagnostic, SourcePosition, sorted_diagnostics
from lwr_dyn.krl.editor.referents import (
    LineContext,
    Referent,
    line_context,
    name_column,
    named_in,
    referent_at,
)
from lwr_dyn.krl.language.lexer import Token
from lwr_dyn.krl.language.source import is_krl_file, krl_files, parse_text
from lwr_dyn.krl.names.known_names import KnownNames, known_names
from lwr_dyn.krl.project.program import Program, Scope, program_in, read_file
from lwr_dyn.krl.project.project import ModuleFile, Project, module_file, project_of

LOST = "\ufffd"
"""Stands in a text where bytes could not be decoded."""
LOOKED_AT = 4096
"""[bytes] Of a file that is not open: with a zero among them it is no text, so nothing more of it is read."""


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
            try:
                paths = krl_files(self.folder) if self.whole else sorted(filter(is_krl_file, self.folder.iterdir()))
            except OSError:  # no KRL file yet, or no folder
                paths = []
            files = {x.file.name: x for x in _read(paths, self.folder)}
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
        belongs = is_krl_file(path) and (self.whole or path.parent == self.folder)
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

    def undeclared(self, name: str) -> Iterator[SourcePosition]:
        """The places where a name is used that nothing declares, neither the project nor the controller."""
        for file, context in self._lines_with(name, self.project.files):
            for token, found in named_in(context, name):
                if found is None or (found.position is None and context.scope.known.text(found.owner or name) is None):
                    yield file.file.position(context.line, name_column(token))

    def uses(self, wanted: Referent, within: str | None = None) -> list[SourcePosition]:
        """All places of the project, or of one file, that mean the same, with its declaration: where the name begins.

        The # of a constant stands before its place.
        """
        out: list[SourcePosition] = []
        files = self.project.files if within is None else (self.project.file(within),)
        for file, context in self._lines_with(wanted.name, files):
            same = (token for token, x in named_in(context, wanted.name) if x is not None and x.key == wanted.key)
            out += [file.file.position(context.line, name_column(token)) for token in same]
        return out

    def _lines_with(self, name: str, files: Iterable[ModuleFile]) -> Iterator[tuple[ModuleFile, LineContext]]:
        """The lines of files in which a text stands, with the names that they see."""
        pattern = re.compile(re.escape(name), re.IGNORECASE)
        for file in files:
            scopes: dict[int, Scope] = {}
            for i, line in enumerate(file.file.lines):
                if line.layout is not None and pattern.search(line.layout) is not None:
                    yield file, line_context(self.program(file.file.name), file, i, scopes)

    def with_texts(self, texts: Mapping[str, str]) -> EditedProject:
        """The project as it would be with other texts of some files; this one stays as it is."""
        out = EditedProject(self.folder, self.whole, self.known, {**self.texts, **texts})
        kept = (x for x in self.project.files if x.file.name not in texts)
        out._keep(project_of([*kept, *(_parsed(name, text) for name, text in texts.items())], self.folder))
        return out

    def _keep(self, project: Project) -> None:
        self._project = project.with_known(self.known)
        self._programs.clear()

    def _others(self, name: str) -> Iterable[ModuleFile]:
        return (x for x in self.project.files if x.file.name != name)


def _read(paths: Iterable[Path], folder: Path) -> list[ModuleFile]:
    out = []
    for path in paths:
        try:
            with path.open("rb") as file:
                is_text = b"\0" not in file.read(LOOKED_AT)
            if is_text:
                out.append(read_file(path, folder))
        except (FileAccessError, OSError):  # gone meanwhile, or not ours to read
            continue
    return out


def _parsed(name: str, text: str) -> ModuleFile:
    return module_file(*parse_text(text, name))


def _lost(name: str, text: str) -> tuple[Diagnostic, ...]:
    line = text[: text.index(LOST)].count("\n") + 1
    message = "characters were lost when the editor read the file"
    hint = "KRL files are latin-1: open it again as Windows-1252, before you save"
    return (Diagnostic(SourcePosition(name, line), "warning", "encoding", message, hint),)
