"""Routines and blocks of a file: which ENDIF closes which IF, and what is missing or in the wrong place.

Where an end is missing or left over, the lines are paired once more by their indentation, and the pairing with the
fewest faults is taken (of equal ones that by indentation): then the block is named that really lost its end.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal

from lwr_dyn.krl.diagnostics import Diagnostic, Severity
from lwr_dyn.krl.language import declarations as d
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.source import SourceFile

OPENERS = {"IF": "ENDIF", "WHILE": "ENDWHILE", "SWITCH": "ENDSWITCH", "FOR": "ENDFOR", "LOOP": "ENDLOOP",
           "REPEAT": "UNTIL", "SPLINE": "ENDSPLINE", "PTP_SPLINE": "ENDSPLINE"}  # fmt: skip

CLOSERS = frozenset(OPENERS.values())
LOOPS = frozenset({"WHILE", "FOR", "LOOP", "REPEAT"})
PARTS = {"ELSE": "IF", "CASE": "SWITCH", "DEFAULT": "SWITCH"}
NESTED = 200
"""Most blocks inside one another; those inside are not paired."""
_OPENERS_OF = {ender: tuple(o for o, other in OPENERS.items() if other == ender) for ender in sorted(CLOSERS)}
Way = Literal["order", "indentation", "strict"]
"""An end belongs to the block opened last; to that of its own indentation; and no block is inside one as far in."""
BLOCK_WORDS = frozenset({*OPENERS, *CLOSERS, *PARTS, "EXIT"})


@dataclass(slots=True)
class CodeBlock:
    """Lines from `first` (IF, LOOP ...) to `last` (ENDIF, ENDLOOP ...), `parts` its ELSE, CASE and DEFAULT lines."""

    kind: str
    first: int
    last: int = -1
    parts: list[int] = field(default_factory=list)


def keyword_of(statement: s.Statement | None) -> str:
    """The keyword by which a line opens, splits or closes a block; empty for other lines."""
    if isinstance(statement, s.Plain | s.Condition):
        return statement.keyword
    if isinstance(statement, s.SplineBlock):
        return statement.kind
    return {s.For: "FOR", s.CaseBranch: "CASE", s.EndSpline: "ENDSPLINE"}.get(type(statement), "")


class BlockPairing:
    """Pairs the block lines (index and keyword) of one routine whose body ends before line `last`."""

    def __init__(self, file: SourceFile, way: Way, words: Sequence[tuple[int, str]], last: int) -> None:
        self.file, self.way = file, way
        self.blocks: dict[int, CodeBlock] = {}
        """By each line that opens, splits, leaves or closes one."""
        self.diagnostics: list[Diagnostic] = []
        self.open: list[CodeBlock] = []
        self.indentations: dict[int, int] = {}
        self.deeper = 0
        for i, keyword in words:
            if keyword in OPENERS:
                self._opened(i, keyword)
            elif keyword in CLOSERS:
                self._closed(i, keyword)
            elif keyword == "EXIT":
                self._left(i)
            else:
                self._part(i, keyword)
        self._close_inner(0, last)

    def _report(self, i: int, code: str, message: str, hint: str) -> None:
        self.diagnostics.append(Diagnostic(self.file.place(i), "error", code, message, hint))

    def _indentation(self, i: int) -> int:
        if i not in self.indentations:
            text = (self.file.lines[i].layout or "").expandtabs(4)
            self.indentations[i] = len(text) - len(text.lstrip())
        return self.indentations[i]

    def _opened(self, i: int, keyword: str) -> None:
        if self.way == "strict":
            at = len(self.open)
            while at and self._indentation(self.open[at - 1].first) >= self._indentation(i):
                at -= 1
            self._close_inner(at, i)
        if len(self.open) < NESTED:
            self.open.append(CodeBlock(keyword, i))
            return
        if not self.deeper:
            self._report(i, "deep-nesting", f"more than {NESTED} blocks inside one another", "use subprograms")
        self.deeper += 1

    def _closed(self, i: int, keyword: str) -> None:
        if self.deeper:
            self.deeper -= 1
            return
        at = self._place(i, _OPENERS_OF[keyword])
        if at is None:
            hint = f"remove it, or open with {_OPENERS_OF[keyword][0]}"
            self._report(i, "stray-end", f"{keyword} closes nothing", hint)
            return
        self._close_inner(at + 1, i)
        self._pair(self.open.pop(), i)

    def _place(self, i: int, kinds: tuple[str, ...], ends: bool = True) -> int | None:
        """The open block of one of these kinds to which a line belongs: the inner one, or that of its indentation."""
        inner: int | None = None
        for k in range(len(self.open) - 1, -1, -1):
            if self.open[k].kind not in kinds:
                continue
            depth = self._indentation(self.open[k].first)
            if self.way == "order" or depth == self._indentation(i):
                return k
            inner = k if inner is None else inner
        # CASE may stand further in than SWITCH; an end that stands further in than its opener belongs to a lost one
        further_in = inner is not None and self._indentation(self.open[inner].first) < self._indentation(i)
        return None if ends and further_in else inner

    def _close_inner(self, at: int, i: int) -> None:
        """The blocks from `at` on have no end: line `i` closes what is around them."""
        for block in self.open[at:]:
            ender = OPENERS[block.kind]
            where = f" before line {i + 1}" if i < len(self.file.lines) else ""
            self._report(block.first, "missing-end", f"{block.kind} has no {ender}", f"close it with {ender}{where}")
            self._pair(block, i)
        del self.open[at:]

    def _pair(self, block: CodeBlock, last: int) -> None:
        block.last = last
        for i in (block.first, *block.parts):
            self.blocks[i] = block
        # a line that closes several blocks (an inner one has no end) belongs to the outermost
        self.blocks[last] = block

    def _left(self, i: int) -> None:
        loop = next((block for block in reversed(self.open) if block.kind in LOOPS), None)
        if loop is not None:
            self.blocks[i] = loop
        else:
            self._report(i, "stray-exit", "EXIT outside of a loop", "EXIT leaves LOOP, FOR, WHILE and REPEAT")

    def _part(self, i: int, keyword: str) -> None:
        if self.deeper:
            return
        wanted = PARTS[keyword]
        at = self._place(i, (wanted,), ends=False) if self.way != "order" else len(self.open) - 1
        if at is None or at < 0 or self.open[at].kind != wanted:
            hint = f"it belongs between {wanted} and END{wanted}"
            self._report(i, "stray-end", f"{keyword} outside of {wanted}", hint)
        elif keyword == "ELSE" and self.open[at].parts:
            self._report(i, "stray-end", "a second ELSE in one IF", "nest another IF")
        else:
            self._close_inner(at + 1, i)
            self.open[at].parts.append(i)


def paired_blocks(file: SourceFile, words: Sequence[tuple[int, str]], last: int) -> BlockPairing:
    """The pairing with the fewest faults."""
    in_order = BlockPairing(file, "order", words, last)
    if not in_order.diagnostics:
        return in_order
    ways: tuple[Way, ...] = ("strict", "indentation")
    pairings = [*(BlockPairing(file, way, words, last) for way in ways), in_order]
    return min(pairings, key=lambda pairing: len(pairing.diagnostics))


_WORD = re.compile(r"[A-Z_$][A-Z0-9_$]*")
DECLARATIONS = (d.Declaration, d.EnumType, d.StructType, d.Signal, d.Channel, d.External)


@dataclass(slots=True)
class Routine:
    """A DEF or DEFFCT: its head, the lines `first` to `last` (exclusive) of its body, its blocks and labels."""

    file: SourceFile
    head: d.Def
    first: int
    last: int = -1
    blocks: dict[int, CodeBlock] = field(default_factory=dict)
    """Line that opens, splits, leaves or closes a block -> the block."""
    labels: dict[str, int] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """In capitals."""
        return self.head.name.upper()

    @property
    def ender(self) -> str:
        """The keyword that ends it."""
        return "END" if self.head.returns is None else "ENDFCT"

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
        self.out.diagnostics.append(Diagnostic(self.file.place(i), severity, code, message, hint))

    def data(self) -> FileOutline:
        statements = [line.statement for line in self.file.lines]
        inside = any(isinstance(x, d.DefDat) for x in statements)
        ended = any(isinstance(x, s.Plain) and x.keyword == "ENDDAT" for x in statements)
        for i, x in enumerate(statements):
            if isinstance(x, (*DECLARATIONS, s.Assign)):
                self.out.data.append((i, x))
            elif x is not None and not isinstance(x, d.Header | d.DefDat) and keyword_of(x) != "ENDDAT":
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
            elif x is None or isinstance(x, d.Header):
                continue
            elif isinstance(x, d.Def):
                self._close(i, missing=True)
                self._open(i, x)
            elif isinstance(x, s.Plain) and x.keyword in ("END", "ENDFCT"):
                self._end(i, x.keyword)
            elif self.routine is None:
                self._outside(i, x)
            else:
                self._body(i, x, self.routine.labels)
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

    def _open(self, i: int, head: d.Def) -> None:
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
            name, ender = routine.head.name, routine.ender
            self.report(routine.first - 1, "missing-end", f"{name} has no {ender}", f"end it with {ender}")
        self.out.routines.append(routine)
        self.routine = None

    def _end(self, i: int, keyword: str) -> None:
        if self.routine is None:
            if not self.lost:
                self.report(i, "stray-end", f"{keyword} closes nothing", "remove it, or begin with DEF")
            self.lost = self.outside = False
            return
        wanted = self.routine.ender
        if keyword != wanted:
            self.report(i, "wrong-end", f"{self.routine.head.name} ends with {keyword}", f"end it with {wanted}")
        self._close(i, missing=False)

    def _outside(self, i: int, x: s.Statement) -> None:
        """Report the first of several statements outside of all routines."""
        if not isinstance(x, DECLARATIONS) and not self.lost and not self.outside:
            self.report(i, "outside-routine", "a statement outside of DEF ... END", "move it into a routine")
            self.outside = True

    def _body(self, i: int, x: s.Statement, labels: dict[str, int]) -> None:
        if isinstance(x, DECLARATIONS):
            if self.began:
                message = "a declaration after the first statement"
                self.report(i, "late-declaration", message, "declarations stand first, right after DEF")
            return
        self.began = True
        keyword = keyword_of(x)
        if keyword in BLOCK_WORDS:
            self.words.append((i, keyword))
        elif isinstance(x, s.Label):
            if x.name.upper() in labels:
                self.report(i, "duplicate-name", f"the label {x.name} is there twice", "rename one of them")
            labels.setdefault(x.name.upper(), i)
