"""The KRL files of a folder as an editor has them: texts that are open stand in the place of those on disk.

Each file is also a tree: routines, their blocks and folds; of a `.dat` what it declares.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.krl.checks.static_checks import static_diagnostics
from lwr_dyn.krl.diagnostics import Diagnostic, SourcePosition, sorted_diagnostics
from lwr_dyn.krl.editor.referents import LineContext, Referent, line_context, referent_at, referents_in
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import FileOutline
from lwr_dyn.krl.language.declarations import Declaration, EnumType, Signal, StructType
from lwr_dyn.krl.language.lexer import Token
from lwr_dyn.krl.language.source import SourceFile, is_krl_file, krl_files, parse_text
from lwr_dyn.krl.language.unparse import statement_text
from lwr_dyn.krl.names.known_names import KnownNames, known_names
from lwr_dyn.krl.project.program import Program, Scope, program_in, read_file
from lwr_dyn.krl.project.project import ModuleFile, Project, module_file, project_of

Kind = Literal["routine", "block", "fold", "variable", "type"]
LONGEST = 80
"""Characters of a name."""
_FOLD = re.compile(r"\s*(END)?FOLD\b([^;]*)", re.IGNORECASE)


@dataclass(slots=True)
class OutlineItem:
    """One entry: lines `first` to `last` (from 0, both included), and the entries within."""

    name: str
    kind: Kind
    first: int
    last: int
    detail: str = ""
    items: list[OutlineItem] = field(default_factory=list)


def outline_items(file: SourceFile, outline: FileOutline) -> list[OutlineItem]:
    """The tree of a file; an entry that begins inside another one and ends after it is cut at its end."""
    return _nested([*_routines(file, outline), *_folds(file), *_declared(outline.data)])


def folds_of(file: SourceFile, outline: FileOutline) -> list[OutlineItem]:
    """Routines, blocks and folds of more than one line, each by itself."""
    return [x for x in (*_routines(file, outline), *_folds(file)) if x.last > x.first]


def _routines(file: SourceFile, outline: FileOutline) -> Iterator[OutlineItem]:
    """Routines and their blocks."""
    last = max(len(file.lines) - 1, 0)
    for routine in outline.routines:
        head = routine.head
        yield OutlineItem(head.name, "routine", routine.first - 1, min(routine.last, last), head.returns or "")
        for block in {id(block): block for block in routine.blocks.values()}.values():
            statement = file.lines[block.first].statement
            text = block.kind if statement is None else statement_text(statement)
            yield OutlineItem(_shortened(text), "block", block.first, min(block.last, last))


def _folds(file: SourceFile) -> Iterator[OutlineItem]:
    """`;FOLD name` to `;ENDFOLD`; a fold without its end is left out."""
    opened: list[tuple[int, str]] = []
    for i, line in enumerate(file.lines):
        mark = None if line.comment is None or line.statement is not None else _FOLD.match(line.comment)
        if mark is None:
            continue
        if mark[1] is None:
            opened.append((i, _shortened(mark[2])))
        elif opened:
            first, name = opened.pop()
            yield OutlineItem(name, "fold", first, i)


def _declared(data: Iterable[tuple[int, s.Statement]]) -> Iterator[OutlineItem]:
    for i, x in data:
        if isinstance(x, Declaration):
            for d in x.names:
                brackets = "" if d.sizes is None else "[]"
                yield OutlineItem(d.name, "variable", i, i, f"{x.type or ''}{brackets}")
        elif isinstance(x, Signal):
            yield OutlineItem(x.name, "variable", i, i, "SIGNAL")
        elif isinstance(x, StructType | EnumType):
            yield OutlineItem(x.name, "type", i, i, "STRUC" if isinstance(x, StructType) else "ENUM")


def _nested(found: Iterable[OutlineItem]) -> list[OutlineItem]:
    top: list[OutlineItem] = []
    above: list[OutlineItem] = []
    for item in sorted(found, key=lambda x: (x.first, -x.last)):
        while above and item.first > above[-1].last:
            above.pop()
        if above:
            item.last = min(item.last, above[-1].last)
        (above[-1].items if above else top).append(item)
        if item.last > item.first:  # on one line stands nothing within
            above.append(item)
    return top


def _shortened(text: str) -> str:
    words = " ".join(text.split()) or "fold"
    return words if len(words) <= LONGEST else f"{words[: LONGEST - 1]}…"


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
            out.append(read_file(path, folder))
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
