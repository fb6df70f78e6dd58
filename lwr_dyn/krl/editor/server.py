"""`lwr-dyn krl server`: the Language Server Protocol for KRL over stdin and stdout, by pygls."""

import asyncio
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from lsprotocol import types as lsp
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path

from lwr_dyn.foundation.version import VERSION
from lwr_dyn.krl.diagnostics import Diagnostic, SourcePosition
from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.outlines import OutlineItem, folds_of, outline_items
from lwr_dyn.krl.editor.referents import LineContext, Referent, hover_text
from lwr_dyn.krl.editor.session import Session
from lwr_dyn.krl.language.lexer import Token
from lwr_dyn.krl.language.source import SourceFile
from lwr_dyn.krl.names.known_names import known_names
from lwr_dyn.krl.project.project import ModuleFile

_WORD = re.compile(r"#?[\w$.]+|\S?")


def characters(text: str, at: int, encoding: str) -> int:
    """The editor's units before a character (from 0) of a line; beyond its end one a character.

    >>> [characters("a\\U0001f916b", 2, encoding) for encoding in ("utf-8", "utf-16", "utf-32")]
    [5, 3, 2]
    """
    if text.isascii() or encoding == "utf-32":
        return at
    size, codec = (2, "utf-16-le") if encoding == "utf-16" else (1, "utf-8")
    return len(text[:at].encode(codec, "surrogatepass")) // size + max(0, at - len(text))


def column_at(text: str, units: int, encoding: str) -> int:
    """The character (from 0) of a line before which so many units stand.

    >>> column_at("a\\U0001f916b", 3, "utf-16")
    2
    """
    if text.isascii():
        return units
    sizes: Sequence[int] = [characters(text, at, encoding) for at in range(len(text) + 1)]
    return next((at for at, size in enumerate(sizes) if size >= units), len(text))


DEBOUNCE = 0.1
"""[s] After the last change, until the file is checked again."""

_SEVERITY = {"error": lsp.DiagnosticSeverity.Error, "warning": lsp.DiagnosticSeverity.Warning,
             "note": lsp.DiagnosticSeverity.Information}  # fmt: skip

_KINDS = {"routine": lsp.SymbolKind.Function, "block": lsp.SymbolKind.Namespace, "fold": lsp.SymbolKind.String,
          "variable": lsp.SymbolKind.Variable, "type": lsp.SymbolKind.Struct}  # fmt: skip


def serve(names: Sequence[str] = ()) -> None:
    """Answer an editor until it closes stdin or asks to exit; `names` are files as of `known_names`, which raises."""
    language_server(Session(known=known_names(names))).start_io()


def language_server(session: Session) -> LanguageServer:
    """The server with all that it offers."""
    # whole texts: pygls counts lines at more signs than the protocol does, such as a form feed
    server = LanguageServer("lwr-dyn krl", VERSION, text_document_sync_kind=lsp.TextDocumentSyncKind.Full)
    editor = _Editor(server, session)
    for method, answer in (
        (lsp.INITIALIZED, editor.initialized),
        (lsp.TEXT_DOCUMENT_DID_OPEN, editor.opened),
        (lsp.TEXT_DOCUMENT_DID_CHANGE, editor.changed),
        (lsp.TEXT_DOCUMENT_DID_CLOSE, editor.closed),
        (lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES, editor.changed_on_disk),
        (lsp.WORKSPACE_DID_CHANGE_WORKSPACE_FOLDERS, editor.changed_folders),
        (lsp.TEXT_DOCUMENT_HOVER, editor.hover),
        (lsp.TEXT_DOCUMENT_DEFINITION, editor.definition),
        (lsp.TEXT_DOCUMENT_REFERENCES, editor.references),
        (lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL, editor.symbols),
        (lsp.TEXT_DOCUMENT_FOLDING_RANGE, editor.folding),
    ):
        server.feature(method)(partial(answer))
    return server


@dataclass(slots=True, eq=False)
class _Editor:
    """What is open in the editor, and the answers to its questions."""

    server: LanguageServer
    session: Session
    waiting: dict[str, asyncio.TimerHandle] = field(default_factory=dict)
    """By the address of a file that has changed: when it is checked."""
    open: dict[str, Path] = field(default_factory=dict)

    def initialized(self, _: lsp.InitializedParams) -> None:
        for folder in self.server.workspace.folders.values():
            self.session.add_folder(_path(folder.uri))
        if not self.server.workspace.folders and self.server.workspace.root_path:
            self.session.add_folder(Path(self.server.workspace.root_path))
        workspace = self.server.client_capabilities.workspace
        watched = None if workspace is None else workspace.did_change_watched_files
        if watched is not None and watched.dynamic_registration:
            watchers = [lsp.FileSystemWatcher("**/*.{src,dat,sub,SRC,DAT,SUB}")]
            options = lsp.DidChangeWatchedFilesRegistrationOptions(watchers)
            wish = lsp.Registration("krl-files", lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES, options)
            self.server.client_register_capability(lsp.RegistrationParams([wish]))

    def opened(self, params: lsp.DidOpenTextDocumentParams) -> None:
        uri = params.text_document.uri
        self.open[uri] = _path(uri)
        self._check(uri)

    def changed(self, params: lsp.DidChangeTextDocumentParams) -> None:
        uri = params.text_document.uri
        self._cancel(uri)
        self.waiting[uri] = asyncio.get_running_loop().call_later(DEBOUNCE, self._check, uri)

    def closed(self, params: lsp.DidCloseTextDocumentParams) -> None:
        uri = params.text_document.uri
        self._cancel(uri)
        project, name = self.session.place(self.open.pop(uri, _path(uri)))
        project.close(name)
        self.server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))

    def changed_on_disk(self, params: lsp.DidChangeWatchedFilesParams) -> None:
        for change in params.changes:
            project, name = self.session.place(_path(change.uri))
            project.reread(name)
        self._check_others("")

    def changed_folders(self, params: lsp.DidChangeWorkspaceFoldersParams) -> None:
        for removed in params.event.removed:
            self.session.remove_folder(_path(removed.uri))
        for added in params.event.added:
            self.session.add_folder(_path(added.uri))
        self._check_others("")

    def hover(self, params: lsp.HoverParams) -> lsp.Hover | None:
        found = self._at(params.text_document.uri, params.position)
        if found is None:
            return None
        _, context, token, referent = found
        text = lsp.MarkupContent(lsp.MarkupKind.Markdown, hover_text(context, referent))
        place = SourcePosition(context.file.file.name, context.line + 1, token.column)
        return lsp.Hover(text, self._range(context.file.file, place, len(token.text)))

    def definition(self, params: lsp.DefinitionParams) -> lsp.Location | None:
        found = self._at(params.text_document.uri, params.position)
        if found is None or found[3].position is None:
            return None
        return self._location(found[0], found[3].position, len(found[3].name))

    def references(self, params: lsp.ReferenceParams) -> list[lsp.Location]:
        found = self._at(params.text_document.uri, params.position)
        if found is None:
            return []
        project, _, token, referent = found
        uses = project.uses(referent)
        if not params.context.include_declaration:
            uses = [x for x in uses if x != referent.position]
        return [self._location(project, x, len(token.text)) for x in uses]

    def symbols(self, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        found = self._file(params.text_document.uri)
        if found is None:
            return []
        return [self._symbol(found.file, item) for item in outline_items(found.file, found.outline)]

    def folding(self, params: lsp.FoldingRangeParams) -> list[lsp.FoldingRange]:
        found, kinds = self._file(params.text_document.uri), {"fold": lsp.FoldingRangeKind.Region}
        folds = [] if found is None else folds_of(found.file, found.outline)
        return [lsp.FoldingRange(x.first, x.last, kind=kinds.get(x.kind)) for x in folds]

    def _cancel(self, uri: str) -> None:
        handle = self.waiting.pop(uri, None)
        if handle is not None:
            handle.cancel()

    def _fresh(self, uri: str) -> tuple[EditedProject, str] | None:
        """The project of a file and its name there, with the editor's present text; of a closed one with the disk's.

        None for a closed file that is not there.
        """
        project, name = self.session.place(self.open.get(uri) or _path(uri))
        if uri in self.open:
            project.set_text(name, self.server.workspace.get_text_document(uri).source)
        return (project, name) if name in project.project.homes else None

    def _file(self, uri: str) -> ModuleFile | None:
        """A file as it is now."""
        fresh = self._fresh(uri)
        return None if fresh is None else fresh[0].project.file(fresh[1])

    def _check(self, uri: str) -> None:
        """Check a file and its module now, and the other open files soon: they may use what it declares."""
        self._publish(uri)
        self._check_others(uri)

    def _check_others(self, uri: str) -> None:
        for other in self.open:
            if other != uri and other not in self.waiting:
                self.waiting[other] = asyncio.get_running_loop().call_later(2 * DEBOUNCE, self._publish, other)

    def _publish(self, uri: str) -> None:
        self._cancel(uri)
        fresh = self._fresh(uri)
        if fresh is None:
            return
        project, name = fresh
        file = project.project.file(name).file
        shown = [self._diagnostic(file, d) for d in project.diagnostics(name)[name]]
        self.server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, shown))

    def _at(self, uri: str, position: lsp.Position) -> tuple[EditedProject, LineContext, Token, Referent] | None:
        fresh = self._fresh(uri)
        if fresh is None:
            return None
        project, name = fresh
        lines = project.project.file(name).file.lines
        if position.line >= len(lines):
            return None
        column = column_at(lines[position.line].layout or "", position.character, self._encoding) + 1
        found = project.at(name, position.line, column)
        return None if found is None else (project, *found)

    def _diagnostic(self, file: SourceFile, d: Diagnostic) -> lsp.Diagnostic:
        message = f"{d.message} ({d.hint})" if d.hint else d.message
        where = self._range(file, d.position)
        return lsp.Diagnostic(where, message, severity=_SEVERITY[d.severity], code=d.code, source="lwr-dyn")

    def _location(self, project: EditedProject, position: SourcePosition, length: int) -> lsp.Location:
        uri = from_fs_path(str(project.folder / position.file)) or ""
        shown = next((x for x, path in self.open.items() if path == project.folder / position.file), uri)
        return lsp.Location(shown, self._range(project.project.file(position.file).file, position, length))

    def _symbol(self, file: SourceFile, x: OutlineItem) -> lsp.DocumentSymbol:
        whole = lsp.Range(lsp.Position(x.first, 0), lsp.Position(x.last, self._units(file, x.last)))
        head = lsp.Range(lsp.Position(x.first, 0), lsp.Position(x.first, self._units(file, x.first)))
        inner = [self._symbol(file, item) for item in x.items]
        return lsp.DocumentSymbol(x.name, _KINDS[x.kind], whole, head, detail=x.detail or None, children=inner)

    def _range(self, file: SourceFile, position: SourcePosition, length: int | None = None) -> lsp.Range:
        """From a position to the end of its word, or over `length` characters."""
        line, first = position.line - 1, position.column - 1
        text = (file.lines[line].layout or "") if line < len(file.lines) else ""
        if length is None:
            word = _WORD.match(text, min(first, len(text)))
            length = max(1, 0 if word is None else len(word[0]))
        ends = (characters(text, at, self._encoding) for at in (first, first + length))
        return lsp.Range(*(lsp.Position(line, at) for at in ends))

    def _units(self, file: SourceFile, line: int) -> int:
        text = (file.lines[line].layout or "") if line < len(file.lines) else ""
        return characters(text, len(text), self._encoding)

    @property
    def _encoding(self) -> str:
        chosen = self.server.workspace.position_encoding
        return str(getattr(chosen, "value", chosen) or "utf-16")


def _path(uri: str) -> Path:
    return Path(to_fs_path(uri) or uri)
