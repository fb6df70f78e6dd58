"""The KRL files that an editor has open, and places in them from the editor's words to ours."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from lsprotocol import types as lsp
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path

from lwr_dyn.krl.diagnostics import Diagnostic, SourcePosition
from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.protocol.places import Places, places_of
from lwr_dyn.krl.editor.referents import LineContext, Referent, line_context
from lwr_dyn.krl.editor.session import Session
from lwr_dyn.krl.language.lexer import Token
from lwr_dyn.krl.project.project import ModuleFile


@dataclass(slots=True, eq=False)
class OpenFiles:
    """What is open, by the editor's addresses."""

    server: LanguageServer
    session: Session
    paths: dict[str, Path] = field(default_factory=dict)
    shown: dict[str, tuple[Diagnostic, ...]] = field(default_factory=dict)
    """The diagnoses that the editor has been sent last."""

    @property
    def places(self) -> Places:
        """In the encoding that the editor has chosen."""
        return places_of(self.server)

    def fresh(self, uri: str) -> tuple[EditedProject, str] | None:
        """The project of a file and its name there, with the editor's present text; of a closed one with the disk's.

        None for a closed file that is not there.
        """
        project, name = self.session.place(self.paths.get(uri) or path_of(uri))
        if uri in self.paths:
            project.set_text(name, self.server.workspace.get_text_document(uri).source)
        return (project, name) if name in project.project.homes else None

    def file(self, uri: str) -> ModuleFile | None:
        """A file as it is now."""
        fresh = self.fresh(uri)
        return None if fresh is None else fresh[0].project.file(fresh[1])

    def column(self, uri: str, position: lsp.Position) -> tuple[EditedProject, str, int] | None:
        """The project of a file, its name there, the character (from 0) at a position; None beyond the last line."""
        fresh = self.fresh(uri)
        if fresh is None:
            return None
        project, name = fresh
        file = project.project.file(name).file
        return (project, name, self.places.column(file, position)) if position.line < len(file.lines) else None

    def line(self, uri: str, position: lsp.Position) -> tuple[LineContext, int] | None:
        """The line at a position with the names that it sees, and the character (from 0) there."""
        found = self.column(uri, position)
        if found is None:
            return None
        project, name, column = found
        return line_context(project.program(name), project.project.file(name), position.line), column

    def at(self, uri: str, position: lsp.Position) -> tuple[EditedProject, LineContext, Token, Referent] | None:
        """The name at a position and what it refers to."""
        found = self.column(uri, position)
        if found is None:
            return None
        project, name, column = found
        meant = project.at(name, position.line, column + 1)
        return None if meant is None else (project, *meant)

    def location(self, project: EditedProject, position: SourcePosition, length: int) -> lsp.Location:
        """A place over so many characters."""
        file = project.project.file(position.file).file
        return lsp.Location(self.uri(project, position.file), self.places.at(file, position, length))

    def uri(self, project: EditedProject, name: str) -> str:
        """The address of a file; of an open one as the editor writes it."""
        path = project.folder / name
        return next((x for x, y in self.paths.items() if y == path), from_fs_path(str(path)) or "")


def path_of(uri: str) -> Path:
    """The path of an address."""
    return Path(to_fs_path(uri) or uri)
