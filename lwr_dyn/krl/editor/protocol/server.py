"""`lwr-dyn lsp`: the language server for KRL, URDF and xacro files over stdin and stdout, by pygls."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp
from pygls.lsp.server import LanguageServer

from lwr_dyn.foundation.version import VERSION
from lwr_dyn.krl.diagnostics import Diagnostic
from lwr_dyn.krl.editor.coloring import MARKS, MEANINGS
from lwr_dyn.krl.editor.protocol.assistance import Assistance
from lwr_dyn.krl.editor.protocol.navigation import Navigation
from lwr_dyn.krl.editor.protocol.open_files import OpenFiles, path_of
from lwr_dyn.krl.editor.protocol.urdf_documents import UrdfDocuments
from lwr_dyn.krl.editor.session import Session
from lwr_dyn.krl.editor.urdf_files import UrdfJudge, is_urdf
from lwr_dyn.krl.language.source import ENDINGS, SourceFile
from lwr_dyn.krl.names.known_names import known_names

LANGUAGE = "krl"
"""What an editor calls KRL; a file of another ending that it calls so is read as KRL too."""
DEBOUNCE = 0.1
"""[s] After the last change, until the file is checked again."""

_SEVERITY = {"error": lsp.DiagnosticSeverity.Error, "warning": lsp.DiagnosticSeverity.Warning,
             "note": lsp.DiagnosticSeverity.Information}  # fmt: skip


def _no_judge(_: Path, __: str | None) -> Sequence[Any]:
    return ()


def serve(names: Sequence[str] = (), judge: UrdfJudge = _no_judge) -> None:
    """Answer an editor until it closes stdin or asks to exit; `judge` is the linter of URDFs.

    `names` are files as of `known_names`, which raises.
    """
    language_server(Session(known=known_names(names)), judge).start_io()


def language_server(session: Session, judge: UrdfJudge = _no_judge) -> LanguageServer:
    """The server with all that it offers."""
    # whole texts: pygls counts lines at more signs than the protocol does, such as a form feed
    server = LanguageServer("lwr-dyn", VERSION, text_document_sync_kind=lsp.TextDocumentSyncKind.Full)
    files = OpenFiles(server, session)
    editor = _Editor(server, files, UrdfDocuments(server, judge))
    for method, answer in editor.events().items():
        server.feature(method)(partial(answer))
    find, write = Navigation(files), Assistance(files)
    questions: dict[str, tuple[Callable[[Any], Any], Any]] = {
        lsp.TEXT_DOCUMENT_HOVER: (find.hover, None),
        lsp.TEXT_DOCUMENT_DEFINITION: (find.definition, None),
        lsp.TEXT_DOCUMENT_REFERENCES: (find.references, None),
        lsp.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT: (find.highlights, None),
        lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL: (find.symbols, None),
        lsp.TEXT_DOCUMENT_FOLDING_RANGE: (find.folding, None),
        lsp.WORKSPACE_SYMBOL: (find.workspace_symbols, None),
        lsp.TEXT_DOCUMENT_PREPARE_CALL_HIERARCHY: (find.prepare_calls, None),
        lsp.CALL_HIERARCHY_INCOMING_CALLS: (find.incoming, None),
        lsp.CALL_HIERARCHY_OUTGOING_CALLS: (find.outgoing, None),
        lsp.TEXT_DOCUMENT_COMPLETION: (write.completion, lsp.CompletionOptions([".", "#", "$", "{"])),
        lsp.TEXT_DOCUMENT_SIGNATURE_HELP: (write.signature, lsp.SignatureHelpOptions(["(", ","])),
        lsp.TEXT_DOCUMENT_PREPARE_RENAME: (write.prepare_rename, None),
        lsp.TEXT_DOCUMENT_RENAME: (write.rename, lsp.RenameOptions(prepare_provider=True)),
        lsp.TEXT_DOCUMENT_FORMATTING: (write.formatting, None),
        lsp.TEXT_DOCUMENT_RANGE_FORMATTING: (write.range_formatting, None),
        lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL: (write.colors, _LEGEND),
        lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_RANGE: (write.colors_of_range, _LEGEND),
        lsp.TEXT_DOCUMENT_INLAY_HINT: (write.hints, None),
    }
    for method, (answer, options) in questions.items():
        server.feature(method, options)(partial(_of_krl, answer))
    fixes = lsp.CodeActionOptions([lsp.CodeActionKind.QuickFix])
    server.feature(lsp.TEXT_DOCUMENT_CODE_ACTION, fixes)(partial(editor.actions, write))
    return server


_LEGEND = lsp.SemanticTokensLegend(list(MEANINGS), list(MARKS))


def _of_krl(answer: Callable[[Any], Any], params: Any) -> Any:
    """The answer of a question about a KRL file; of a URDF there is none."""
    document = getattr(params, "text_document", None)
    return None if document is not None and is_urdf(path_of(document.uri)) else answer(params)


@dataclass(slots=True, eq=False)
class _Editor:
    """What the editor opens, changes and closes, and the diagnoses that it gets."""

    server: LanguageServer
    files: OpenFiles
    urdf: UrdfDocuments
    waiting: dict[str, asyncio.TimerHandle] = field(default_factory=dict)
    """By the address of a file that has changed: when it is checked."""

    def events(self) -> dict[str, Callable[[Any], None]]:
        """What the editor tells, and what follows."""
        return {
            lsp.INITIALIZED: self.initialized,
            lsp.TEXT_DOCUMENT_DID_OPEN: self.opened,
            lsp.TEXT_DOCUMENT_DID_CHANGE: self.changed,
            lsp.TEXT_DOCUMENT_DID_SAVE: self.saved,
            lsp.TEXT_DOCUMENT_DID_CLOSE: self.closed,
            lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES: self.changed_on_disk,
            lsp.WORKSPACE_DID_CHANGE_WORKSPACE_FOLDERS: self.changed_folders,
        }

    def initialized(self, _: lsp.InitializedParams) -> None:
        for folder in self.server.workspace.folders.values():
            self.files.session.add_folder(path_of(folder.uri))
        if not self.server.workspace.folders and self.server.workspace.root_path:
            self.files.session.add_folder(Path(self.server.workspace.root_path))
        workspace = self.server.client_capabilities.workspace
        watched = None if workspace is None else workspace.did_change_watched_files
        if watched is not None and watched.dynamic_registration:
            watchers = [lsp.FileSystemWatcher("**/*.{src,dat,sub,SRC,DAT,SUB}")]
            options = lsp.DidChangeWatchedFilesRegistrationOptions(watchers)
            wish = lsp.Registration("krl-files", lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES, options)
            self.server.client_register_capability(lsp.RegistrationParams([wish]))

    def opened(self, params: lsp.DidOpenTextDocumentParams) -> None:
        uri = params.text_document.uri
        if is_urdf(path_of(uri)):
            self.urdf.ask(uri)
        elif path_of(uri).suffix.lower() in ENDINGS or params.text_document.language_id == LANGUAGE:
            self.files.paths[uri] = path_of(uri)
            self._check(uri)

    def changed(self, params: lsp.DidChangeTextDocumentParams) -> None:
        uri = params.text_document.uri
        if is_urdf(path_of(uri)):
            self.urdf.changed(uri)
        if uri not in self.files.paths:
            return
        self._cancel(uri)
        self.waiting[uri] = asyncio.get_running_loop().call_later(DEBOUNCE, self._check, uri)

    def saved(self, params: lsp.DidSaveTextDocumentParams) -> None:
        if is_urdf(path_of(params.text_document.uri)):
            self.urdf.ask(params.text_document.uri)

    def closed(self, params: lsp.DidCloseTextDocumentParams) -> None:
        uri = params.text_document.uri
        if is_urdf(path_of(uri)):
            self.urdf.closed(uri)
        if uri not in self.files.paths:
            return
        self._cancel(uri)
        self.files.shown.pop(uri, None)
        project, name = self.files.session.place(self.files.paths.pop(uri))
        project.close(name)
        self.server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))

    def changed_on_disk(self, params: lsp.DidChangeWatchedFilesParams) -> None:
        for change in params.changes:
            project, name = self.files.session.place(path_of(change.uri))
            project.reread(name)
        self._check_others("")

    def changed_folders(self, params: lsp.DidChangeWorkspaceFoldersParams) -> None:
        for removed in params.event.removed:
            self.files.session.remove_folder(path_of(removed.uri))
        for added in params.event.added:
            self.files.session.add_folder(path_of(added.uri))
        self._check_others("")

    def actions(self, write: Assistance, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        """Quick fixes of what is wrong in the text as it is now."""
        uri = params.text_document.uri
        if is_urdf(path_of(uri)):
            return self.urdf.actions(params)
        if uri in self.waiting:
            self._publish(uri)
        return write.actions(params)

    def _cancel(self, uri: str) -> None:
        handle = self.waiting.pop(uri, None)
        if handle is not None:
            handle.cancel()

    def _check(self, uri: str) -> None:
        """Check a file and its module now, and the other open files soon: they may use what it declares."""
        self._publish(uri)
        self._check_others(uri)

    def _check_others(self, uri: str) -> None:
        for other in self.files.paths:
            if other != uri and other not in self.waiting:
                self.waiting[other] = asyncio.get_running_loop().call_later(2 * DEBOUNCE, self._publish, other)

    def _publish(self, uri: str) -> None:
        self._cancel(uri)
        fresh = self.files.fresh(uri)
        if fresh is None:
            return
        project, name = fresh
        file = project.project.file(name).file
        self.files.shown[uri] = project.diagnostics(name)[name]
        shown = [self._diagnostic(file, d) for d in self.files.shown[uri]]
        self.server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, shown))

    def _diagnostic(self, file: SourceFile, d: Diagnostic) -> lsp.Diagnostic:
        message = f"{d.message} ({d.hint})" if d.hint else d.message
        where = self.files.places.at(file, d.position)
        return lsp.Diagnostic(where, message, severity=_SEVERITY[d.severity], code=d.code, source="lwr-dyn")
