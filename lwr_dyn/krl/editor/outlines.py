"""A file as a tree for an editor: routines, their blocks and folds; of a `.dat` what it declares."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Literal

from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import FileOutline
from lwr_dyn.krl.language.declarations import Declaration, EnumType, Signal, StructType
from lwr_dyn.krl.language.source import SourceFile
from lwr_dyn.krl.language.unparse import statement_text

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
