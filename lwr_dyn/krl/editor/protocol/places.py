"""Places in a file as an editor counts them: lines from 0, and in them units of the encoding that it has chosen."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from lsprotocol import types as lsp
from pygls.lsp.server import LanguageServer

from lwr_dyn.krl.diagnostics import SourcePosition
from lwr_dyn.krl.language.source import SourceFile

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


@dataclass(frozen=True, slots=True)
class Places:
    """From our places to the editor's."""

    encoding: str

    def range(self, text: str, line: int, first: int, last: int) -> lsp.Range:
        """Characters `first` to `last` (exclusive, from 0) of a line whose text is given."""
        ends = (characters(text, at, self.encoding) for at in (first, last))
        return lsp.Range(*(lsp.Position(line, at) for at in ends))

    def line(self, file: SourceFile, line: int) -> lsp.Range:
        """A whole line without its end."""
        text = text_of(file, line)
        return self.range(text, line, 0, len(text))

    def lines(self, file: SourceFile, first: int, last: int) -> lsp.Range:
        """From the begin of one line to the end of another."""
        return lsp.Range(lsp.Position(first, 0), self.line(file, last).end)

    def at(self, file: SourceFile, position: SourcePosition, length: int | None = None) -> lsp.Range:
        """From a position to the end of its word, or over `length` characters."""
        line, first = position.line - 1, position.column - 1
        text = text_of(file, line)
        if length is None:
            word = _WORD.match(text, min(first, len(text)))
            length = max(1, 0 if word is None else len(word[0]))
        return self.range(text, line, first, first + length)

    def column(self, file: SourceFile, position: lsp.Position) -> int:
        """The character (from 0) of a line at which the editor's position is."""
        return column_at(text_of(file, position.line), position.character, self.encoding)

    def within(self, text: str, first: int, last: int) -> lsp.Range:
        """Characters `first` to `last` of a text of several lines, which end in a line feed."""
        return lsp.Range(*(self._in_text(text, at) for at in (first, last)))

    def _in_text(self, text: str, at: int) -> lsp.Position:
        begin = text.rfind("\n", 0, at) + 1
        return lsp.Position(text.count("\n", 0, at), characters(text[begin:at], at - begin, self.encoding))


def text_of(file: SourceFile, line: int) -> str:
    """A line without its end; empty where there is none."""
    return (file.lines[line].layout or "") if line < len(file.lines) else ""


def places_of(server: LanguageServer) -> Places:
    """In the encoding that the editor of a server has chosen."""
    chosen = server.workspace.position_encoding
    return Places(str(getattr(chosen, "value", chosen) or "utf-16"))
