"""URDF and xacro files that an editor has open: judged in a thread, since meshes are read and an editor must not wait.

A URDF is judged as it is written, a xacro file as it is saved: it is expanded from the disk.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from lsprotocol import types as lsp
from pygls.lsp.server import LanguageServer

from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.krl.editor.protocol.assistance import fix_action
from lwr_dyn.krl.editor.protocol.open_files import path_of
from lwr_dyn.krl.editor.protocol.places import places_of
from lwr_dyn.krl.editor.urdf_files import UrdfJudge, UrdfRemark, quick_fix, tag_at

_SEVERITY = {"error": lsp.DiagnosticSeverity.Error, "warning": lsp.DiagnosticSeverity.Warning,
             "note": lsp.DiagnosticSeverity.Information}  # fmt: skip
QUIET = 0.3
"""[s] Without a change, until a URDF is judged again."""


@dataclass(slots=True, eq=False)
class UrdfDocuments:
    """Those that are open, and what was found in them."""

    server: LanguageServer
    judge: UrdfJudge
    asked: dict[str, int] = field(default_factory=dict)
    """How often each file was asked for: an answer to an older question is dropped."""
    found: dict[str, dict[str, list[UrdfRemark]]] = field(default_factory=dict)
    """By open file: the findings by address. Those of a xacro also stand in the files that it includes."""
    tasks: set[asyncio.Task[None]] = field(default_factory=set)
    one: asyncio.Lock = field(default_factory=asyncio.Lock)

    def ask(self, uri: str, wait: float = 0.0) -> None:
        """Judge a file soon."""
        self.asked[uri] = self.asked.get(uri, 0) + 1
        task = asyncio.get_running_loop().create_task(self._judge(uri, self.asked[uri], wait))
        self.tasks.add(task)
        task.add_done_callback(self.tasks.discard)

    def changed(self, uri: str) -> None:
        """The text in the editor has changed."""
        if not uri.lower().endswith(".xacro"):
            self.ask(uri, QUIET)

    def closed(self, uri: str) -> None:
        """Nothing is shown of a file that is not open."""
        self.asked[uri] = self.asked.get(uri, 0) + 1
        self._keep(uri, {})

    async def _judge(self, uri: str, number: int, wait: float) -> None:
        await asyncio.sleep(wait)
        async with self.one:
            if self.asked[uri] != number:
                return
            path, text = path_of(uri), None
            if not uri.lower().endswith(".xacro"):
                text = self.server.workspace.get_text_document(uri).source
            try:
                remarks = await asyncio.to_thread(self.judge, path, text)
            except LwrDynError as fault:
                remarks = [UrdfRemark(str(path), 1, 1, "warning", "not-judged", str(fault))]
        if self.asked[uri] == number:
            found: dict[str, list[UrdfRemark]] = {uri: []}
            for x in remarks:
                found.setdefault(uri if Path(x.file) == path else Path(x.file).as_uri(), []).append(x)
            self._keep(uri, found)

    def _keep(self, uri: str, found: dict[str, list[UrdfRemark]]) -> None:
        places = {*self.found.pop(uri, {}), *found}
        if found:
            self.found[uri] = found
        for at in places:
            shown = [self._diagnostic(at, x) for x in self._remarks(at)]
            self.server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(at, shown))

    def _remarks(self, uri: str) -> Iterator[UrdfRemark]:
        """The findings in a file, each once."""
        yield from dict.fromkeys(x for found in self.found.values() for x in found.get(uri, ()))

    def _diagnostic(self, uri: str, x: UrdfRemark) -> lsp.Diagnostic:
        severity = _SEVERITY[x.severity]
        return lsp.Diagnostic(self._range(self._text(uri), x), x.message, severity, x.code, source="lwr-dyn")

    def _range(self, text: str, x: UrdfRemark) -> lsp.Range:
        """The tag that a finding is about, else its first character."""
        tag, start = tag_at(text, x.line, x.column), lsp.Position(x.line - 1, x.column - 1)
        return lsp.Range(start, lsp.Position(x.line - 1, x.column)) if tag is None else self._span(text, *tag.span())

    def _span(self, text: str, first: int, last: int) -> lsp.Range:
        return places_of(self.server).within(text, first, last)

    def _text(self, uri: str) -> str:
        """Of a file, in the editor or on the disk."""
        if uri in self.server.workspace.text_documents:
            return self.server.workspace.get_text_document(uri).source
        try:
            return path_of(uri).read_text(encoding="utf-8", errors="replace")
        except OSError:
            return ""

    def actions(self, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        """What the linter would write instead."""
        uri, text, out = params.text_document.uri, self._text(params.text_document.uri), []
        for x in self._remarks(uri):
            here, pieces = self._range(text, x), quick_fix(text, x)
            if pieces and here.start.line <= params.range.end.line and params.range.start.line <= here.end.line:
                edits = [lsp.TextEdit(self._span(text, first, last), new) for first, last, new in pieces]
                given: Sequence[lsp.Diagnostic] = params.context.diagnostics
                same = [d for d in given if d.code == x.code and d.range.start == here.start]
                out.append(fix_action(f"Write {x.instead}", uri, edits, same))
        return out
