"""What stands where in KRL files: hover, definition, uses, outline, folding, symbols of the folder, calls."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from lsprotocol import types as lsp

from lwr_dyn.krl.diagnostics import SourcePosition
from lwr_dyn.krl.editor.calls import RoutineCalls, callees, callers
from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.outlines import OutlineItem, folds_of, outline_items
from lwr_dyn.krl.editor.protocol.open_files import OpenFiles
from lwr_dyn.krl.editor.referents import Referent, hover_text
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.source import SourceFile
from lwr_dyn.krl.language.statements import Assign
from lwr_dyn.krl.project.project import SymbolTable

MOST_SYMBOLS = 300
"""In one answer to a search over the folder."""
_KINDS = {"routine": lsp.SymbolKind.Function, "block": lsp.SymbolKind.Namespace, "fold": lsp.SymbolKind.String,
          "variable": lsp.SymbolKind.Variable, "type": lsp.SymbolKind.Struct}  # fmt: skip


@dataclass(slots=True, eq=False)
class Navigation:
    """The answers."""

    files: OpenFiles

    def hover(self, params: lsp.HoverParams) -> lsp.Hover | None:
        """Declaration, type and value of a name."""
        found = self.files.at(params.text_document.uri, params.position)
        if found is None:
            return None
        _, context, token, referent = found
        text = lsp.MarkupContent(lsp.MarkupKind.Markdown, hover_text(context, referent))
        place = SourcePosition(context.file.file.name, context.line + 1, token.column)
        return lsp.Hover(text, self.files.places.at(context.file.file, place, len(token.text)))

    def definition(self, params: lsp.DefinitionParams) -> lsp.Location | None:
        """Where a name is declared."""
        found = self.files.at(params.text_document.uri, params.position)
        if found is None or found[3].position is None:
            return None
        return self.files.location(found[0], found[3].position, len(found[3].name))

    def references(self, params: lsp.ReferenceParams) -> list[lsp.Location]:
        """All places that mean the same."""
        found = self.files.at(params.text_document.uri, params.position)
        if found is None:
            return []
        project, _, _, referent = found
        uses = project.uses(referent)
        if not params.context.include_declaration:
            uses = [x for x in uses if x != referent.position]
        return [self.files.location(project, x, len(referent.name)) for x in uses]

    def highlights(self, params: lsp.DocumentHighlightParams) -> list[lsp.DocumentHighlight]:
        """The same within the file, with those that write to it marked."""
        found = self.files.at(params.text_document.uri, params.position)
        if found is None:
            return []
        project, context, _, referent = found
        file, kinds = context.file.file, lsp.DocumentHighlightKind
        out = []
        for place in project.uses(referent, file.name):
            kind = kinds.Write if _is_written(file, place, referent) else kinds.Read
            out.append(lsp.DocumentHighlight(self.files.places.at(file, place, len(referent.name)), kind))
        return out

    def symbols(self, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        """The outline of a file."""
        found = self.files.file(params.text_document.uri)
        if found is None:
            return []
        return [self._symbol(found.file, item) for item in outline_items(found.file, found.outline)]

    def folding(self, params: lsp.FoldingRangeParams) -> list[lsp.FoldingRange]:
        """Routines, blocks and folds."""
        found, kinds = self.files.file(params.text_document.uri), {"fold": lsp.FoldingRangeKind.Region}
        folds = [] if found is None else folds_of(found.file, found.outline)
        return [lsp.FoldingRange(x.first, x.last, kind=kinds.get(x.kind)) for x in folds]

    def workspace_symbols(self, params: lsp.WorkspaceSymbolParams) -> list[lsp.WorkspaceSymbol]:
        """Routines, variables and types of all files with a text in their names, those that begin with it first."""
        wanted, found = params.query.upper(), []
        for project in self.files.session.projects():
            for file in project.project.files:
                found += [(project, *x) for x in _declared(file.file, file.names) if wanted in x[1].upper()]
        found.sort(key=lambda x: (not x[2].upper().startswith(wanted), x[2].upper()))
        return [
            lsp.WorkspaceSymbol(self.files.location(project, place, len(name)), name, _KINDS[kind],
                                container_name=place.file)
            for project, kind, name, place in found[:MOST_SYMBOLS]
        ]  # fmt: skip

    def prepare_calls(self, params: lsp.CallHierarchyPrepareParams) -> list[lsp.CallHierarchyItem] | None:
        """The routine at a place, of which callers can be asked for."""
        found = self.files.at(params.text_document.uri, params.position)
        if found is None or not isinstance(found[3].declared, Routine):
            return None
        routine = found[3].declared
        return [self._item(found[0], routine, routine.file.name)]

    def incoming(self, params: lsp.CallHierarchyIncomingCallsParams) -> list[lsp.CallHierarchyIncomingCall]:
        """Who calls a routine."""
        found = self.files.at(params.item.uri, params.item.selection_range.start)
        if found is None:
            return []
        project, _, _, referent = found
        return [
            lsp.CallHierarchyIncomingCall(
                self._item(project, x.routine, x.file), self._ranges(project, x, referent.name)
            )
            for x in callers(project, referent)
        ]

    def outgoing(self, params: lsp.CallHierarchyOutgoingCallsParams) -> list[lsp.CallHierarchyOutgoingCall]:
        """Whom a routine calls."""
        found = self.files.at(params.item.uri, params.item.selection_range.start)
        if found is None or not isinstance(found[3].declared, Routine):
            return []
        project, routine = found[0], found[3].declared
        return [
            lsp.CallHierarchyOutgoingCall(
                self._item(project, x.routine, x.file), self._ranges(project, x, x.routine.head.name)
            )
            for x in callees(project, routine.file.name, routine)
        ]

    def _item(self, project: EditedProject, routine: Routine, file: str) -> lsp.CallHierarchyItem:
        head, text = routine.head, project.project.file(file).file
        whole = self.files.places.lines(text, routine.first - 1, min(routine.last, len(text.lines) - 1))
        name = self.files.places.at(text, text.position(routine.first - 1, head.column), len(head.name))
        uri = self.files.uri(project, file)
        return lsp.CallHierarchyItem(head.name, lsp.SymbolKind.Function, uri, whole, name, detail=file)

    def _ranges(self, project: EditedProject, calls: RoutineCalls, name: str) -> Sequence[lsp.Range]:
        return [self.files.location(project, x, len(name)).range for x in calls.places]

    def _symbol(self, file: SourceFile, x: OutlineItem) -> lsp.DocumentSymbol:
        places = self.files.places
        head = places.line(file, x.first)
        inner = [self._symbol(file, item) for item in x.items]
        whole = places.lines(file, x.first, x.last)
        return lsp.DocumentSymbol(x.name, _KINDS[x.kind], whole, head, detail=x.detail or None, children=inner)


def _declared(file: SourceFile, names: SymbolTable) -> Iterator[tuple[str, str, SourcePosition]]:
    """Kind, name and place of what a file declares for the whole module or for all."""
    for routine in names.routines.values():
        yield "routine", routine.head.name, file.position(routine.first - 1, routine.head.column)
    for kind, table in (("variable", names.variables), ("type", names.types)):
        for x in table.values():
            yield kind, x.name, x.position


def _is_written(file: SourceFile, place: SourcePosition, referent: Referent) -> bool:
    """Whether a place is the declaration, or what an assignment in its line begins with."""
    if place == referent.position:
        return True
    x = file.lines[place.line - 1].statement
    target: e.Reference | None = x.target if isinstance(x, Assign) else None
    while isinstance(target, e.Index | e.Component) and target.column != place.column:
        target = target.of
    return target is not None and target.column == place.column
