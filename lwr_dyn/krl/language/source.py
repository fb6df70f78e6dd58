"""A KRL file as lines: read from bytes, and written back byte for byte where nothing was changed.

A line keeps its statement, its comment, and the text it was read from. That text is written again as long as it still
means the same, so the layout stays and an edit changes its own lines only.
"""

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.foundation.files import read_bytes, write_file
from lwr_dyn.krl.diagnostics import Diagnostic, SourcePosition
from lwr_dyn.krl.language.lexer import LineError
from lwr_dyn.krl.language.line_parser import LINES, LONGEST_KEPT, parse_line
from lwr_dyn.krl.language.statements import Statement
from lwr_dyn.krl.language.unparse import statement_text

ENDINGS = (".src", ".sub", ".dat")


def is_krl_file(path: Path) -> bool:
    """Whether it is a regular file with the ending of a KRL file; a pipe would never end."""
    return path.suffix.lower() in ENDINGS and path.is_file()


def krl_files(path: str | Path) -> list[Path]:
    """The file itself, or all .src, .sub and .dat files in a folder and below, in order of their paths.

    Links to folders are not followed, folders whose names begin with a point are left out. Raises `FileAccessError` for
    another ending and a folder without such a file.
    """
    target = Path(path)
    if not target.is_dir():
        if target.suffix.lower() not in ENDINGS:
            fault = f"ends in {target.suffix or 'nothing'!r}"
            raise FileAccessError(str(path), fault, "a .src, .sub or .dat file, a folder")
        return [target]
    found: list[Path] = []
    for root, folders, names in os.walk(target):
        folders[:] = [x for x in folders if not x.startswith(".")]
        found += filter(is_krl_file, (Path(root, name) for name in names))
    if not found:
        raise FileAccessError(str(path), "a folder without KRL files", "a folder of .src, .sub and .dat files")
    return sorted(found)


def data_beside(path: Path) -> Path | None:
    """The `.dat` beside a `.src` or `.sub`, its name in any case."""
    if path.suffix.lower() == ".dat":
        return None
    try:
        siblings = sorted(path.parent.iterdir())
    except OSError:
        return None
    wanted = path.with_suffix(".dat").name.lower()
    return next((p for p in siblings if p.name.lower() == wanted and p.is_file()), None)


NEWLINE = "\r\n"
"""KUKA's controllers run Windows."""
LARGEST = 200_000_000
"""[bytes] A larger file is refused."""
_ENDS = re.compile(r"\r\n|\n|\r")


@dataclass(frozen=True, slots=True)
class SourceLine:
    """One line: a statement (None without one), a comment without its semicolon, and its layout."""

    statement: Statement | None = None
    comment: str | None = None
    layout: str | None = field(default=None, compare=False)
    """The text it was read from."""
    end: str = field(default=NEWLINE, compare=False)
    readable: bool = field(default=True, compare=False)
    """False for a line with a syntax error, which is kept as it stands."""

    @property
    def shown(self) -> str:
        """The line as it was read, else as it is written."""
        return self.text() if self.layout is None else self.layout

    def text(self) -> str:
        """The line as it is written, without its end."""
        if self.layout is not None and (not self.readable or self.means(self.layout)):
            return self.layout
        text = "" if self.statement is None else statement_text(self.statement)
        if self.comment is None:
            return text
        if "\n" in self.comment or "\r" in self.comment:
            raise OptionError("comment", repr(self.comment), "one line of text")
        return f"{text} ;{self.comment}" if text else f";{self.comment}"

    def means(self, layout: str) -> bool:
        """Whether a text has the statement and comment of the line."""
        try:
            return parse_line(layout) == (self.statement, self.comment)
        except LineError:
            return False


@dataclass(frozen=True, slots=True)
class SourceFile:
    """A `.src` or `.dat` file: its lines, and the encoding of its bytes (latin-1 unless it is valid UTF-8)."""

    name: str
    lines: tuple[SourceLine, ...]
    encoding: str = field(default="latin-1", compare=False)
    mark: bytes = field(default=b"", compare=False)
    """The byte order mark at its beginning, if any."""

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

    def position(self, index: int, column: int = 1) -> SourcePosition:
        """The position of line `index` (from 0)."""
        return SourcePosition(self.name, index + 1, column)

    def place(self, index: int) -> SourcePosition:
        """The position of the statement in line `index` (from 0), which may be behind the last one."""
        statement = self.lines[index].statement if index < len(self.lines) else None
        return self.position(index, getattr(statement, "column", 1))


def lines_of(statements: Iterable[Statement | SourceLine]) -> tuple[SourceLine, ...]:
    """Statements as lines of a new file."""
    return tuple(x if isinstance(x, SourceLine) else SourceLine(x) for x in statements)


def parse_text(text: str, name: str = "program.src") -> tuple[SourceFile, tuple[Diagnostic, ...]]:
    """A file's text as lines, with a diagnostic for each line that cannot be read.

    >>> file, diagnostics = parse_text("DEF a( )\\nPTP {A1 0\\nEND\\n", "a.src")
    >>> print(diagnostics[0])
    a.src:2:5: error open-bracket: { is not closed (close it with })
    """
    lines, diagnostics = [], []
    for i, (raw, end) in enumerate(_split(text)):
        line, fault = _kept_line(raw, end) if len(raw) <= LONGEST_KEPT else _line(raw, end)
        lines.append(line)
        if fault is not None:
            position = SourcePosition(name, i + 1, fault.column)
            diagnostics.append(Diagnostic(position, "error", fault.code, fault.message, fault.hint))
    return SourceFile(name, tuple(lines)), tuple(diagnostics)


def _line(raw: str, end: str) -> tuple[SourceLine, LineError | None]:
    try:
        statement, comment = parse_line(raw)
        return SourceLine(statement, comment, raw, end), None
    except LineError as fault:
        return SourceLine(None, None, raw, end, readable=False), fault.with_traceback(None)


_kept_line = lru_cache(maxsize=LINES)(_line)


def parse_bytes(data: bytes, name: str = "program.src") -> tuple[SourceFile, tuple[Diagnostic, ...]]:
    """A file's bytes as lines, with diagnostics of lines and of the encoding; no input raises."""
    diagnostics: list[Diagnostic] = []
    start = SourcePosition(name, 1)
    mark = b"\xef\xbb\xbf" if data.startswith(b"\xef\xbb\xbf") else b""
    encoding = _encoding(data[len(mark) :])
    if data.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\x00" in data:
        hint = "save it as latin-1 (Windows-1252)"
        diagnostics.append(Diagnostic(start, "error", "encoding", "the file is not 8-bit text (UTF-16?)", hint))
    elif mark or encoding == "utf-8":
        what = "begins with a UTF-8 byte order mark" if mark else "has characters in UTF-8"
        hint = "KRL files are latin-1: save it as Windows-1252"
        diagnostics.append(Diagnostic(start, "warning", "encoding", f"the file {what}", hint))
    file, of_lines = parse_text(data[len(mark) :].decode(encoding), name)
    return SourceFile(name, file.lines, encoding, mark), (*diagnostics, *of_lines)


def read_source(path: str | Path, name: str | None = None) -> tuple[SourceFile, tuple[Diagnostic, ...]]:
    """A file from disk, with the name of its path unless another is given.

    Raises `FileAccessError` when it cannot be read or is larger than any program.
    """
    return parse_bytes(read_bytes(path, "a KRL file, .src or .dat", LARGEST), name or Path(path).name)


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
