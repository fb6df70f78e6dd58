"""The statements of a `.src` or `.sub` by routine, and where two of them differ; comments and layout do not count."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import SequenceMatcher

from lwr_dyn.krl.comparing.file_values import meaning_of
from lwr_dyn.krl.language.declarations import Def, Header
from lwr_dyn.krl.language.source import SourceFile
from lwr_dyn.krl.language.unparse import statement_text

BEFORE_ROUTINES = "(before the first routine)"


@dataclass(frozen=True, slots=True)
class CodeLine:
    """A statement: its line (from 1), its text, and what it means."""

    line: int
    text: str
    meaning: str


@dataclass(frozen=True, slots=True)
class RoutineChange:
    """Pieces of a routine, the lines removed and those added in each; `kind` is changed, added or removed."""

    routine: str
    kind: str
    pieces: tuple[tuple[tuple[CodeLine, ...], tuple[CodeLine, ...]], ...]


def routine_changes(before: SourceFile, after: SourceFile) -> list[RoutineChange]:
    """What differs, in the order of the later file; removed routines last."""
    old, new = code_of(before), code_of(after)
    out = []
    for name, lines in new.items():
        if name not in old:
            out.append(RoutineChange(name, "added", (((), tuple(lines)),)))
        else:
            pieces = _pieces(old[name], lines)
            out += [RoutineChange(name, "changed", pieces)] if pieces else []
    return out + [RoutineChange(name, "removed", ((tuple(old[name]), ()),)) for name in old if name not in new]


def code_of(file: SourceFile) -> dict[str, list[CodeLine]]:
    """The statements of each routine, by its name in capitals."""
    routines: dict[str, list[CodeLine]] = {}
    name = BEFORE_ROUTINES
    for i, line in enumerate(file.lines, 1):
        if isinstance(line.statement, Header) or (line.statement is None and line.readable):
            continue
        if isinstance(line.statement, Def):
            name = line.statement.name.upper()
        text = line.text().strip() if line.statement is None else statement_text(line.statement)
        routines.setdefault(name, []).append(CodeLine(i, text, meaning_of(text)))
    return routines


def _pieces(a: list[CodeLine], b: list[CodeLine]) -> tuple[tuple[tuple[CodeLine, ...], tuple[CodeLine, ...]], ...]:
    matcher = SequenceMatcher(None, [x.meaning for x in a], [x.meaning for x in b])
    differing = [op for op in matcher.get_opcodes() if op[0] != "equal"]
    return tuple((tuple(a[i:j]), tuple(b[k:m])) for _, i, j, k, m in differing)
