"""Help in writing KRL: completion, signatures, rename, layout, colours by meaning, names of signals, quick fixes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException

from lwr_dyn.krl.editor.calls import open_call
from lwr_dyn.krl.editor.coloring import colored
from lwr_dyn.krl.editor.completions import Completion, completions
from lwr_dyn.krl.editor.protocol.open_files import OpenFiles
from lwr_dyn.krl.editor.protocol.places import characters, text_of
from lwr_dyn.krl.editor.quick_fixes import quick_fix
from lwr_dyn.krl.editor.renaming import KeptNameError, renamable, renamed
from lwr_dyn.krl.editor.signal_hints import signal_hints
from lwr_dyn.krl.language.layout import changed_lines, formatted

_KINDS = {"variable": lsp.CompletionItemKind.Variable, "routine": lsp.CompletionItemKind.Function,
          "type": lsp.CompletionItemKind.Struct, "component": lsp.CompletionItemKind.Field,
          "constant": lsp.CompletionItemKind.EnumMember, "keyword": lsp.CompletionItemKind.Keyword,
          "system": lsp.CompletionItemKind.Constant, "label": lsp.CompletionItemKind.Reference}  # fmt: skip
_LAST = ("keyword", "type", "system")
"""Kinds that stand below the names of the program."""


@dataclass(slots=True, eq=False)
class Assistance:
    """The answers."""

    files: OpenFiles

    def completion(self, params: lsp.CompletionParams) -> lsp.CompletionList | None:
        """What can be written at a place."""
        place = self.files.line(params.text_document.uri, params.position)
        if place is None:
            return None
        context, column = place
        start, found = completions(context, column)
        where = self.files.places.range(context.text, params.position.line, start, column)
        is_open = start == column  # `$` names come once $ is written, so the editor has to ask again
        if self._takes_defaults:
            defaults = lsp.CompletionItemDefaults(edit_range=where)
            return lsp.CompletionList(is_open, [_item(x, None) for x in found], defaults)
        return lsp.CompletionList(is_open, [_item(x, lsp.TextEdit(where, x.text)) for x in found])

    @property
    def _takes_defaults(self) -> bool:
        """Whether the editor takes one range for all proposals: the answer is half as long."""
        document = self.files.server.client_capabilities.text_document
        able = None if document is None else document.completion
        listed = None if able is None else able.completion_list
        return "editRange" in ((listed.item_defaults if listed is not None else None) or ())

    def signature(self, params: lsp.SignatureHelpParams) -> lsp.SignatureHelp | None:
        """The parameters of the call in which the cursor stands."""
        place = self.files.line(params.text_document.uri, params.position)
        call = None if place is None else open_call(*place)
        if call is None:
            return None
        parameters = [lsp.ParameterInformation(x) for x in call.parameters]
        shown = lsp.SignatureInformation(call.label, parameters=parameters)
        return lsp.SignatureHelp([shown], 0, min(call.at, max(len(parameters) - 1, 0)))

    def prepare_rename(self, params: lsp.PrepareRenameParams) -> lsp.PrepareRenamePlaceholder | None:
        """What is renamed; the sentence that says why it is not, as an error."""
        place = self.files.column(params.text_document.uri, params.position)
        if place is None:
            return None
        project, name, column = place
        try:
            found = renamable(project, name, params.position.line, column + 1)
        except KeptNameError as why:
            raise _refusal(why) from None
        text, ends = found.context.text, (found.start - 1, found.start - 1 + len(found.referent.name))
        where = self.files.places.range(text, params.position.line, *ends)
        return lsp.PrepareRenamePlaceholder(where, text[slice(*ends)])

    def rename(self, params: lsp.RenameParams) -> lsp.WorkspaceEdit | None:
        """The new name at all places of the old one."""
        place = self.files.column(params.text_document.uri, params.position)
        if place is None:
            return None
        project, name, column = place
        try:
            found = renamable(project, name, params.position.line, column + 1)
            uses = renamed(project, found, params.new_name)
        except KeptNameError as why:
            raise _refusal(why) from None
        changes: dict[str, list[lsp.TextEdit]] = {}
        for use in uses:
            there = self.files.location(project, use, len(found.referent.name))
            changes.setdefault(there.uri, []).append(lsp.TextEdit(there.range, params.new_name))
        return lsp.WorkspaceEdit(changes)

    def formatting(self, params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
        """The layout of `lwr-dyn krl format`, whose indentation counts and not the editor's: two never differ."""
        return self._layout(params.text_document.uri)

    def range_formatting(self, params: lsp.DocumentRangeFormattingParams) -> list[lsp.TextEdit]:
        """The same for the lines of a range; one that ends before its last line's first character leaves that out."""
        end = params.range.end
        return self._layout(params.text_document.uri, params.range.start.line, end.line - (end.character == 0))

    def _layout(self, uri: str, first: int = 0, last: int | None = None) -> list[lsp.TextEdit]:
        found = self.files.file(uri)
        if found is None:
            return []
        before, after = found.file, formatted(found.file)
        changed = (number - 1 for number in changed_lines(before, after))
        lines = (i for i in changed if first <= i and (last is None or i <= last))
        return [lsp.TextEdit(self.files.places.line(before, i), after.lines[i].text()) for i in lines]

    def colors(self, params: lsp.SemanticTokensParams) -> lsp.SemanticTokens:
        """What each name of a file means."""
        return self._colors(params.text_document.uri, 0, None)

    def colors_of_range(self, params: lsp.SemanticTokensRangeParams) -> lsp.SemanticTokens:
        """The same for the lines of a range."""
        return self._colors(params.text_document.uri, params.range.start.line, params.range.end.line)

    def _colors(self, uri: str, first: int, last: int | None) -> lsp.SemanticTokens:
        """Five numbers a name: lines and units from the one before, length, meaning, marks."""
        found, data, line, at = self.files.fresh(uri), list[int](), 0, 0
        if found is None:
            return lsp.SemanticTokens([])
        project, name = found
        file, encoding = project.project.file(name), self.files.places.encoding
        for i, column, length, meaning, marks in colored(project.program(name), file, first, last):
            start = characters(text_of(file.file, i), column, encoding)
            data += [i - line, start - at if i == line else start, length, meaning, marks]
            line, at = i, start
        return lsp.SemanticTokens(data)

    def hints(self, params: lsp.InlayHintParams) -> list[lsp.InlayHint]:
        """The names of inputs and outputs beside their numbers."""
        found = self.files.fresh(params.text_document.uri)
        if found is None:
            return []
        project, name = found
        file, ends = project.project.file(name), (params.range.start.line, params.range.end.line)
        out = []
        for line, column, text in signal_hints(project.program(name), file, *ends):
            where = self.files.places.range(text_of(file.file, line), line, column, column).start
            out.append(lsp.InlayHint(where, text, padding_left=True))
        return out

    def actions(self, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        """The words that the diagnoses in a range mean."""
        uri, found = params.text_document.uri, self.files.file(params.text_document.uri)
        if found is None:
            return []
        out = []
        for diagnostic in self.files.shown.get(uri, ()):
            line = diagnostic.position.line - 1
            fix = quick_fix(text_of(found.file, line), diagnostic)
            if fix is None or not params.range.start.line <= line <= params.range.end.line:
                continue
            edit = lsp.TextEdit(self.files.places.range(text_of(found.file, line), line, *fix[:2]), fix[2])
            out.append(
                fix_action(f"Write {fix[2]}", uri, [edit], _same(params.context.diagnostics, diagnostic.code, line))
            )
        return out


def fix_action(title: str, uri: str, edits: list[lsp.TextEdit], diagnostics: list[lsp.Diagnostic]) -> lsp.CodeAction:
    """A quick fix of one file."""
    edit = lsp.WorkspaceEdit({uri: edits})
    return lsp.CodeAction(title, lsp.CodeActionKind.QuickFix, diagnostics, True, edit=edit)


def _same(given: Iterable[lsp.Diagnostic], code: str, line: int) -> list[lsp.Diagnostic]:
    """The editor's own record of a diagnosis."""
    return [x for x in given if x.code == code and x.range.start.line == line]


def _item(x: Completion, edit: lsp.TextEdit | None) -> lsp.CompletionItem:
    rank = 0 if x.near else 2 if x.kind in _LAST else 1
    return lsp.CompletionItem(x.text, kind=_KINDS[x.kind], detail=x.detail or None, text_edit=edit,
                              sort_text=f"{rank}{x.text}")  # fmt: skip


def _refusal(why: KeptNameError) -> JsonRpcException:
    return JsonRpcException(str(why), lsp.LSPErrorCodes.RequestFailed.value)
