"""A KRL file as lines: read from bytes, written back byte for byte where nothing was changed.

A line carries what it says, its comment, and the text it was read from; when the text still says the same, it is
what is written, so layout survives and an edit changes its own lines only.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from lwr_dyn.errors import FileAccessError, OptionError
from lwr_dyn.files import write_file
from lwr_dyn.krl.diagnosis import Diagnosis, Place
from lwr_dyn.krl.emit import statement_text
from lwr_dyn.krl.lexer import LineError
from lwr_dyn.krl.line_parser import parse_line
from lwr_dyn.krl.statements import Statement

NEWLINE = "\r\n"
"""What KUKA's controllers, which run Windows, end lines with."""
LARGEST = 200_000_000
"""[bytes] A bigger file is no program."""
_ENDS = re.compile(r"\r\n|\n|\r")


@dataclass(frozen=True, slots=True)
class Line:
    """One line: a statement (None where there is none), a comment without its semicolon, and how it was laid out."""

    statement: Statement | None = None
    comment: str | None = None
    layout: str | None = field(default=None, compare=False)
    """The text it was read from."""
    end: str = field(default=NEWLINE, compare=False)
    readable: bool = field(default=True, compare=False)
    """False for a line with a syntax fault, which is kept as it stands."""

    def text(self) -> str:
        """The line as it is written, without its end."""
        if self.layout is not None and (not self.readable or _says(self.layout, self)):
            return self.layout
        said = "" if self.statement is None else statement_text(self.statement)
        if self.comment is None:
            return said
        if "\n" in self.comment or "\r" in self.comment:
            raise OptionError("comment", repr(self.comment), "one line of text")
        return f"{said} ;{self.comment}" if said else f";{self.comment}"


@dataclass(frozen=True, slots=True)
class SourceFile:
    """A `.src` or `.dat` file: its lines, and the encoding of its bytes (latin-1 unless it is valid UTF-8)."""

    name: str
    lines: tuple[Line, ...]
    encoding: str = field(default="latin-1", compare=False)
    mark: bytes = field(default=b"", compare=False)
    """A byte order mark the file began with."""

    @property
    def is_data(self) -> bool:
        """Whether it is a `.dat`."""
        return self.name.lower().endswith(".dat")

    def text(self) -> str:
        """The whole file as text."""
        return "".join(line.text() + line.end for line in self.lines)

    def to_bytes(self) -> bytes:
        """The whole file as bytes; raises `OptionError` for characters that the encoding does not have."""
        try:
            return self.mark + self.text().encode(self.encoding)
        except UnicodeEncodeError as fault:
            sign = fault.object[fault.start]
            raise OptionError(self.name, f"the character {sign!r}", "characters of latin-1") from None

    def save(self, path: str | Path) -> None:
        """Write the file; raises `FileAccessError`."""
        write_file(path, self.to_bytes())

    def place(self, index: int, column: int = 1) -> Place:
        """Where line `index` (from 0) stands."""
        return Place(self.name, index + 1, column)


def lines_of(statements: Iterable[Statement | Line]) -> tuple[Line, ...]:
    """Statements as lines of a new file."""
    return tuple(x if isinstance(x, Line) else Line(x) for x in statements)


def parse_text(text: str, name: str = "program.src") -> tuple[SourceFile, tuple[Diagnosis, ...]]:
    """A file's text as lines, with a diagnosis for each line that cannot be read.

    >>> file, found = parse_text("DEF a( )\\nPTP {A1 0\\nEND\\n", "a.src")
    >>> print(found[0])
    a.src:2:5: error open-bracket: { is not closed (close it with })
    """
    lines, found = [], []
    for i, (raw, end) in enumerate(_split(text)):
        try:
            statement, comment = parse_line(raw)
            lines.append(Line(statement, comment, raw, end))
        except LineError as fault:
            lines.append(Line(None, None, raw, end, readable=False))
            found.append(Diagnosis(Place(name, i + 1, fault.column), "error", fault.code, fault.message, fault.hint))
    return SourceFile(name, tuple(lines)), tuple(found)


def parse_bytes(data: bytes, name: str = "program.src") -> tuple[SourceFile, tuple[Diagnosis, ...]]:
    """A file's bytes as lines, with diagnoses of lines and of the encoding; no input raises."""
    found: list[Diagnosis] = []
    mark = b"\xef\xbb\xbf" if data.startswith(b"\xef\xbb\xbf") else b""
    encoding = _encoding(data[len(mark) :])
    if data.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\x00" in data:
        hint = "save it as latin-1 (Windows-1252)"
        found.append(Diagnosis(Place(name, 1), "error", "encoding", "the file is not 8-bit text (UTF-16?)", hint))
    elif mark or encoding == "utf-8":
        what = "begins with a UTF-8 byte order mark" if mark else "has characters in UTF-8"
        hint = "KRL files are latin-1: save it as Windows-1252"
        found.append(Diagnosis(Place(name, 1), "warning", "encoding", f"the file {what}", hint))
    file, faults = parse_text(data[len(mark) :].decode(encoding), name)
    return SourceFile(name, file.lines, encoding, mark), (*found, *faults)


def read_source(path: str | Path) -> tuple[SourceFile, tuple[Diagnosis, ...]]:
    """A file from disk; raises `FileAccessError` when it cannot be read or is larger than any program."""
    target = Path(path)
    try:
        if target.stat().st_size > LARGEST:
            raise FileAccessError(str(path), f"larger than {LARGEST} bytes", "a KRL program")
        return parse_bytes(target.read_bytes(), target.name)
    except OSError as fault:
        if isinstance(fault, FileAccessError):
            raise
        reason = (fault.strerror or str(fault)).lower()
        raise FileAccessError(str(path), reason, "a KRL file, .src or .dat") from None


def _says(layout: str, line: Line) -> bool:
    try:
        return parse_line(layout) == (line.statement, line.comment)
    except LineError:
        return False


def _split(text: str) -> Iterable[tuple[str, str]]:
    at = 0
    for end in _ENDS.finditer(text):
        yield text[at : end.start()], end[0]
        at = end.end()
    if at < len(text):
        yield text[at:], ""


def _encoding(data: bytes) -> str:
    """latin-1, which has a character for every byte, unless bytes beyond ASCII are valid UTF-8."""
    if data.isascii():
        return "latin-1"
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"
