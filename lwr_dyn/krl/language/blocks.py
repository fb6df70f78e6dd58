"""Routines and blocks of a file: the lines that belong together, and what is missing or in the wrong place."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from lwr_dyn.krl.diagnostics import Diagnostic, Severity
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.declarations import (
    Channel,
    Declaration,
    Def,
    DefDat,
    EnumType,
    External,
    Header,
    Signal,
    StructType,
)
from lwr_dyn.krl.language.pairing import BLOCK_WORDS, CodeBlock, keyword_of, paired_blocks
from lwr_dyn.krl.language.source import SourceFile

_WORD = re.compile(r"[A-Z_$][A-Z0-9_$]*")
DECLARATIONS = (Declaration, EnumType, StructType, Signal, Channel, External)


@dataclass(slots=True)
class Routine:
    """A DEF or DEFFCT: its head, the lines `first` to `last` (exclusive) of its body, its blocks and labels."""

    file: SourceFile
    head: Def
    first: int
    last: int = -1
    blocks: dict[int, CodeBlock] = field(default_factory=dict)
    """Line that opens, splits, leaves or closes a block -> the block."""
    labels: dict[str, int] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """In capitals."""
        return self.head.name.upper()

    def lines(self) -> Iterator[tuple[int, s.Statement]]:
        """Index and statement of each line of the body that has a statement."""
        for i in range(self.first, self.last):
            statement = self.file.lines[i].statement
            if statement is not None:
                yield i, statement


@dataclass(slots=True)
class FileOutline:
    """The routines of a file, in order, and the declarations of a `.dat`."""

    routines: list[Routine]
    data: list[tuple[int, s.Statement]]
    diagnostics: list[Diagnostic]


def outline_of(file: SourceFile) -> FileOutline:
    """Routines and blocks with their faults; of a `.dat` its declarations."""
    return _OutlineReader(file).data() if file.is_data else _OutlineReader(file).routines()


class _OutlineReader:
    """Reads the lines of a file once."""

    def __init__(self, file: SourceFile) -> None:
        self.file = file
        self.out = FileOutline([], [], [])
        self.routine: Routine | None = None
        self.names: set[str] = set()
        self.words: list[tuple[int, str]] = []
        self.began = False
        self.lost = False
        """Whether the lines belong to a routine whose DEF has a syntax error."""
        self.outside = False

    def report(self, i: int, code: str, message: str, hint: str = "", severity: Severity = "error") -> None:
        statement = self.file.lines[i].statement if i < len(self.file.lines) else None
        column = getattr(statement, "column", 1)
        self.out.diagnostics.append(Diagnostic(self.file.position(i, column), severity, code, message, hint))

    def data(self) -> FileOutline:
        statements = [line.statement for line in self.file.lines]
        inside = any(isinstance(x, DefDat) for x in statements)
        ended = any(isinstance(x, s.Plain) and x.keyword == "ENDDAT" for x in statements)
        for i, x in enumerate(statements):
            if isinstance(x, (*DECLARATIONS, s.Assign)):
                self.out.data.append((i, x))
            elif x is not None and not isinstance(x, Header | DefDat) and keyword_of(x) != "ENDDAT":
                self.report(i, "statement-in-dat", "a .dat holds declarations only", "move it into the .src")
        if self._unread():
            return self.out
        last = max(len(self.file.lines) - 1, 0)
        if not inside:
            self.report(0, "missing-def", "the file has no DEFDAT", "begin with DEFDAT name")
        elif not ended:
            self.report(last, "missing-end", "DEFDAT is not closed", "end with ENDDAT")
        return self.out

    def routines(self) -> FileOutline:
        for i, line in enumerate(self.file.lines):
            x = line.statement
            if not line.readable:
                self._unreadable(i, line.layout or "")
            elif x is None or isinstance(x, Header):
                continue
            elif isinstance(x, Def):
                self._close(i, missing=True)
                self._open(i, x)
            elif isinstance(x, s.Plain) and x.keyword in ("END", "ENDFCT"):
                self._end(i, x.keyword)
            elif self.routine is None:
                self._outside(i, x)
            else:
                self._body(i, x)
        self._close(len(self.file.lines), missing=True)
        if not self.out.routines and not self._unread():
            self.report(0, "missing-def", "the file has no DEF", "begin with DEF name( ), end with END")
        return self.out

    def _unreadable(self, i: int, text: str) -> None:
        """A line with a syntax error still opens or closes what its first word says."""
        words = _WORD.findall(text.upper())[:2]
        if words and words[words[0] == "GLOBAL" and len(words) > 1] in ("DEF", "DEFFCT"):
            self._close(i, missing=True)
            self.lost = True
        elif words and words[0] in BLOCK_WORDS and self.routine is not None:
            self.words.append((i, words[0]))

    def _unread(self) -> bool:
        """Whether a line has a syntax error: the DEF or END may be that line, so it is not reported as missing."""
        return any(not line.readable for line in self.file.lines)

    def _open(self, i: int, head: Def) -> None:
        self.routine, self.words, self.began = Routine(self.file, head, i + 1), [], False
        self.lost = self.outside = False
        if self.routine.name in self.names:
            self.report(i, "duplicate-name", f"{head.name} is defined twice", "rename one of them")
        self.names.add(self.routine.name)

    def _close(self, i: int, missing: bool) -> None:
        routine = self.routine
        if routine is None:
            return
        paired = paired_blocks(self.file, self.words, i)
        routine.blocks = paired.blocks
        self.out.diagnostics += paired.diagnostics
        routine.last = i
        if missing:
            ender = "END" if routine.head.returns is None else "ENDFCT"
            self.report(routine.first - 1, "missing-end", f"{routine.head.name} has no {ender}", f"end it with {ender}")
        self.out.routines.append(routine)
        self.routine = None

    def _end(self, i: int, keyword: str) -> None:
        if self.routine is None:
            if not self.lost:
                self.report(i, "stray-end", f"{keyword} closes nothing", "remove it, or begin with DEF")
            self.lost = self.outside = False
            return
        wanted = "END" if self.routine.head.returns is None else "ENDFCT"
        if keyword != wanted:
            self.report(i, "wrong-end", f"{self.routine.head.name} ends with {keyword}", f"end it with {wanted}")
        self._close(i, missing=False)

    def _outside(self, i: int, x: s.Statement) -> None:
        """Report the first of several statements outside of all routines."""
        if not isinstance(x, DECLARATIONS) and not self.lost and not self.outside:
            self.report(i, "outside-routine", "a statement outside of DEF ... END", "move it into a routine")
            self.outside = True

    def _body(self, i: int, x: s.Statement) -> None:
        self._order(i, x)
        keyword = keyword_of(x)
        if keyword in BLOCK_WORDS:
            self.words.append((i, keyword))
        elif isinstance(x, s.Label):
            self._label(i, x)

    def _label(self, i: int, x: s.Label) -> None:
        assert self.routine is not None
        if x.name.upper() in self.routine.labels:
            self.report(i, "duplicate-name", f"the label {x.name} is there twice", "rename one of them")
        self.routine.labels.setdefault(x.name.upper(), i)

    def _order(self, i: int, x: s.Statement) -> None:
        if isinstance(x, DECLARATIONS):
            if self.began:
                message = "a declaration after the first statement"
                self.report(i, "late-declaration", message, "declarations stand first, right after DEF")
        else:
            self.began = True
