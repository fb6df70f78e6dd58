"""Routines and blocks: which lines belong together, and what is missing or in the wrong place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from lwr_dyn.krl import statements as s
from lwr_dyn.krl.declarations import Declaration, Def, DefDat, EnumType, External, Header, Signal, StructType
from lwr_dyn.krl.diagnosis import Diagnosis, Severity
from lwr_dyn.krl.source import SourceFile

OPENERS = {"IF": "ENDIF", "WHILE": "ENDWHILE", "SWITCH": "ENDSWITCH", "FOR": "ENDFOR", "LOOP": "ENDLOOP",
           "REPEAT": "UNTIL", "SPLINE": "ENDSPLINE", "PTP_SPLINE": "ENDSPLINE"}  # fmt: skip
CLOSERS = frozenset(OPENERS.values())
LOOPS = frozenset({"WHILE", "FOR", "LOOP", "REPEAT"})
DECLARATIONS = (Declaration, EnumType, StructType, Signal, External)
NESTED = 200
"""Blocks inside one another."""


@dataclass(slots=True)
class Block:
    """Lines from `first` (IF, LOOP ...) to `last` (ENDIF, ENDLOOP ...), `parts` its ELSE, CASE and DEFAULT lines."""

    kind: str
    first: int
    last: int = -1
    parts: list[int] = field(default_factory=list)


@dataclass(slots=True)
class Routine:
    """A DEF or DEFFCT: its head's line, its body up to (not with) its END, and the block of each line of a block."""

    file: SourceFile
    head: Def
    first: int
    last: int = -1
    blocks: dict[int, Block] = field(default_factory=dict)
    labels: dict[str, int] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """In capitals."""
        return self.head.name.upper()

    def lines(self) -> Iterator[tuple[int, s.Statement]]:
        """Index and statement of each line of the body that says something."""
        for i in range(self.first, self.last):
            statement = self.file.lines[i].statement
            if statement is not None:
                yield i, statement


@dataclass(slots=True)
class Structure:
    """The routines of a file, in order, and the declarations of a `.dat`."""

    routines: list[Routine]
    data: list[tuple[int, s.Statement]]
    found: list[Diagnosis]


def keyword_of(statement: s.Statement | None) -> str:
    """The keyword by which a line opens, splits or closes a block; empty for other lines."""
    if isinstance(statement, s.Plain | s.Condition):
        return statement.keyword
    if isinstance(statement, s.SplineBlock):
        return statement.kind
    return {s.For: "FOR", s.Case: "CASE", s.EndSpline: "ENDSPLINE"}.get(type(statement), "")


def structure_of(file: SourceFile) -> Structure:
    """Routines, blocks and what is wrong with them; of a `.dat` its declarations."""
    return _Reader(file).data() if file.is_data else _Reader(file).routines()


class _Reader:
    """One pass over the lines of a file."""

    def __init__(self, file: SourceFile) -> None:
        self.file = file
        self.out = Structure([], [], [])
        self.routine: Routine | None = None
        self.open: list[Block] = []
        self.began = False

    def say(self, i: int, code: str, message: str, hint: str = "", severity: Severity = "error") -> None:
        statement = self.file.lines[i].statement if i < len(self.file.lines) else None
        column = getattr(statement, "column", 1)
        self.out.found.append(Diagnosis(self.file.place(i, column), severity, code, message, hint))

    def data(self) -> Structure:
        said = [line.statement for line in self.file.lines]
        inside = any(isinstance(x, DefDat) for x in said)
        ended = any(isinstance(x, s.Plain) and x.keyword == "ENDDAT" for x in said)
        for i, x in enumerate(said):
            if isinstance(x, (*DECLARATIONS, s.Assign)):
                self.out.data.append((i, x))
            elif x is not None and not isinstance(x, Header | DefDat) and keyword_of(x) != "ENDDAT":
                self.say(i, "statement-in-dat", "a .dat holds declarations only", "move it into the .src")
        if self._unread():
            return self.out
        last = max(len(self.file.lines) - 1, 0)
        if not inside:
            self.say(0, "missing-def", "the file has no DEFDAT", "begin with DEFDAT name")
        elif not ended:
            self.say(last, "missing-end", "DEFDAT is not closed", "end with ENDDAT")
        return self.out

    def routines(self) -> Structure:
        for i, line in enumerate(self.file.lines):
            x = line.statement
            if x is None or isinstance(x, Header):
                continue
            if isinstance(x, Def):
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
            self.say(0, "missing-def", "the file has no DEF", "begin with DEF name( ), end with END")
        return self.out

    def _unread(self) -> bool:
        """A file with unreadable lines may have lost its DEF there: one fault is enough."""
        return any(not line.readable for line in self.file.lines)

    def _open(self, i: int, head: Def) -> None:
        self.routine, self.open, self.began = Routine(self.file, head, i + 1), [], False
        if any(r.name == self.routine.name for r in self.out.routines):
            self.say(i, "duplicate-name", f"{head.name} is defined twice", "rename one of them")

    def _close(self, i: int, missing: bool) -> None:
        routine = self.routine
        if routine is None:
            return
        for block in self.open:
            ender = OPENERS[block.kind]
            self.say(block.first, "missing-end", f"{block.kind} has no {ender}", f"close it with {ender}")
            self._pair(block, i)
        routine.last = i
        if missing:
            ender = "END" if routine.head.returns is None else "ENDFCT"
            self.say(routine.first - 1, "missing-end", f"{routine.head.name} has no {ender}", f"end it with {ender}")
        self.out.routines.append(routine)
        self.routine = None

    def _end(self, i: int, keyword: str) -> None:
        if self.routine is None:
            self.say(i, "stray-end", f"{keyword} closes nothing", "remove it, or begin with DEF")
            return
        wanted = "END" if self.routine.head.returns is None else "ENDFCT"
        if keyword != wanted:
            self.say(i, "wrong-end", f"{self.routine.head.name} ends with {keyword}", f"end it with {wanted}")
        self._close(i, missing=False)

    def _outside(self, i: int, x: s.Statement) -> None:
        if not isinstance(x, DECLARATIONS):
            self.say(i, "outside-routine", "a statement outside of DEF ... END", "move it into a routine")

    def _body(self, i: int, x: s.Statement) -> None:
        self._order(i, x)
        keyword = keyword_of(x)
        if keyword in OPENERS:
            self._opened(i, keyword)
        elif keyword in CLOSERS:
            self._closed(i, keyword)
        elif keyword in ("ELSE", "CASE", "DEFAULT"):
            self._part(i, keyword)
        elif keyword == "EXIT" and not any(block.kind in LOOPS for block in self.open):
            self.say(i, "stray-exit", "EXIT outside of a loop", "EXIT leaves LOOP, FOR, WHILE and REPEAT")
        elif keyword == "EXIT":
            assert self.routine is not None
            self.routine.blocks[i] = next(b for b in reversed(self.open) if b.kind in LOOPS)
        elif isinstance(x, s.Label):
            self._label(i, x)

    def _label(self, i: int, x: s.Label) -> None:
        assert self.routine is not None
        if x.name.upper() in self.routine.labels:
            self.say(i, "duplicate-name", f"the label {x.name} is there twice", "rename one of them")
        self.routine.labels.setdefault(x.name.upper(), i)

    def _order(self, i: int, x: s.Statement) -> None:
        if isinstance(x, DECLARATIONS):
            if self.began:
                said = "a declaration after the first statement"
                self.say(i, "late-declaration", said, "declarations stand first, right after DEF")
        else:
            self.began = True

    def _opened(self, i: int, keyword: str) -> None:
        if len(self.open) >= NESTED:
            self.say(i, "deep-nesting", f"more than {NESTED} blocks inside one another", "use subprograms")
        self.open.append(Block(keyword, i))

    def _closed(self, i: int, keyword: str) -> None:
        at = next((k for k in range(len(self.open) - 1, -1, -1) if OPENERS[self.open[k].kind] == keyword), None)
        if at is None:
            opener = next(o for o, ender in OPENERS.items() if ender == keyword)
            self.say(i, "stray-end", f"{keyword} closes nothing", f"remove it, or open with {opener}")
            return
        for block in self.open[at + 1 :]:
            ender = OPENERS[block.kind]
            self.say(block.first, "missing-end", f"{block.kind} has no {ender}", f"close it with {ender}")
            self._pair(block, i)
        self._pair(self.open[at], i)
        del self.open[at:]

    def _pair(self, block: Block, last: int) -> None:
        assert self.routine is not None
        block.last = last
        for i in (block.first, *block.parts):
            self.routine.blocks[i] = block
        # a line that closes several blocks (one is missing its own end) belongs to the outermost
        self.routine.blocks[last] = block

    def _part(self, i: int, keyword: str) -> None:
        wanted = "IF" if keyword == "ELSE" else "SWITCH"
        if not self.open or self.open[-1].kind != wanted:
            self.say(i, "stray-end", f"{keyword} outside of {wanted}", f"it belongs between {wanted} and END{wanted}")
        elif keyword == "ELSE" and self.open[-1].parts:
            self.say(i, "stray-end", "a second ELSE in one IF", "nest another IF")
        else:
            self.open[-1].parts.append(i)
