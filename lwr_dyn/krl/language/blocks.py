"""Routines and blocks of a file: the lines that belong together, and what is missing or in the wrong place."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from lwr_dyn.krl.diagnostics import Diagnostic, Severity
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.declarations import Declaration, Def, DefDat, EnumType, External, Header, Signal, StructType
from lwr_dyn.krl.language.source import SourceFile

OPENERS = {"IF": "ENDIF", "WHILE": "ENDWHILE", "SWITCH": "ENDSWITCH", "FOR": "ENDFOR", "LOOP": "ENDLOOP",
           "REPEAT": "UNTIL", "SPLINE": "ENDSPLINE", "PTP_SPLINE": "ENDSPLINE"}  # fmt: skip
CLOSERS = frozenset(OPENERS.values())
LOOPS = frozenset({"WHILE", "FOR", "LOOP", "REPEAT"})
DECLARATIONS = (Declaration, EnumType, StructType, Signal, External)
NESTED = 200
"""Most blocks inside one another."""


@dataclass(slots=True)
class CodeBlock:
    """Lines from `first` (IF, LOOP ...) to `last` (ENDIF, ENDLOOP ...), `parts` its ELSE, CASE and DEFAULT lines."""

    kind: str
    first: int
    last: int = -1
    parts: list[int] = field(default_factory=list)


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


def keyword_of(statement: s.Statement | None) -> str:
    """The keyword by which a line opens, splits or closes a block; empty for other lines."""
    if isinstance(statement, s.Plain | s.Condition):
        return statement.keyword
    if isinstance(statement, s.SplineBlock):
        return statement.kind
    return {s.For: "FOR", s.CaseBranch: "CASE", s.EndSpline: "ENDSPLINE"}.get(type(statement), "")


def outline_of(file: SourceFile) -> FileOutline:
    """Routines and blocks with their faults; of a `.dat` its declarations."""
    return _OutlineReader(file).data() if file.is_data else _OutlineReader(file).routines()


class _OutlineReader:
    """Reads the lines of a file once."""

    def __init__(self, file: SourceFile) -> None:
        self.file = file
        self.out = FileOutline([], [], [])
        self.routine: Routine | None = None
        self.open: list[CodeBlock] = []
        self.began = False

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
            self.report(0, "missing-def", "the file has no DEF", "begin with DEF name( ), end with END")
        return self.out

    def _unread(self) -> bool:
        """Whether a line has a syntax error: the DEF or END may be that line, so it is not reported as missing."""
        return any(not line.readable for line in self.file.lines)

    def _open(self, i: int, head: Def) -> None:
        self.routine, self.open, self.began = Routine(self.file, head, i + 1), [], False
        if any(r.name == self.routine.name for r in self.out.routines):
            self.report(i, "duplicate-name", f"{head.name} is defined twice", "rename one of them")

    def _close(self, i: int, missing: bool) -> None:
        routine = self.routine
        if routine is None:
            return
        for block in self.open:
            ender = OPENERS[block.kind]
            self.report(block.first, "missing-end", f"{block.kind} has no {ender}", f"close it with {ender}")
            self._pair(block, i)
        routine.last = i
        if missing:
            ender = "END" if routine.head.returns is None else "ENDFCT"
            self.report(routine.first - 1, "missing-end", f"{routine.head.name} has no {ender}", f"end it with {ender}")
        self.out.routines.append(routine)
        self.routine = None

    def _end(self, i: int, keyword: str) -> None:
        if self.routine is None:
            self.report(i, "stray-end", f"{keyword} closes nothing", "remove it, or begin with DEF")
            return
        wanted = "END" if self.routine.head.returns is None else "ENDFCT"
        if keyword != wanted:
            self.report(i, "wrong-end", f"{self.routine.head.name} ends with {keyword}", f"end it with {wanted}")
        self._close(i, missing=False)

    def _outside(self, i: int, x: s.Statement) -> None:
        if not isinstance(x, DECLARATIONS):
            self.report(i, "outside-routine", "a statement outside of DEF ... END", "move it into a routine")

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
            self.report(i, "stray-exit", "EXIT outside of a loop", "EXIT leaves LOOP, FOR, WHILE and REPEAT")
        elif keyword == "EXIT":
            assert self.routine is not None
            self.routine.blocks[i] = next(b for b in reversed(self.open) if b.kind in LOOPS)
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

    def _opened(self, i: int, keyword: str) -> None:
        if len(self.open) >= NESTED:
            self.report(i, "deep-nesting", f"more than {NESTED} blocks inside one another", "use subprograms")
        self.open.append(CodeBlock(keyword, i))

    def _closed(self, i: int, keyword: str) -> None:
        at = next((k for k in range(len(self.open) - 1, -1, -1) if OPENERS[self.open[k].kind] == keyword), None)
        if at is None:
            opener = next(o for o, ender in OPENERS.items() if ender == keyword)
            self.report(i, "stray-end", f"{keyword} closes nothing", f"remove it, or open with {opener}")
            return
        for block in self.open[at + 1 :]:
            ender = OPENERS[block.kind]
            self.report(block.first, "missing-end", f"{block.kind} has no {ender}", f"close it with {ender}")
            self._pair(block, i)
        self._pair(self.open[at], i)
        del self.open[at:]

    def _pair(self, block: CodeBlock, last: int) -> None:
        assert self.routine is not None
        block.last = last
        for i in (block.first, *block.parts):
            self.routine.blocks[i] = block
        # a line that closes several blocks (an inner one has no end) belongs to the outermost
        self.routine.blocks[last] = block

    def _part(self, i: int, keyword: str) -> None:
        wanted = "IF" if keyword == "ELSE" else "SWITCH"
        if not self.open or self.open[-1].kind != wanted:
            hint = f"it belongs between {wanted} and END{wanted}"
            self.report(i, "stray-end", f"{keyword} outside of {wanted}", hint)
        elif keyword == "ELSE" and self.open[-1].parts:
            self.report(i, "stray-end", "a second ELSE in one IF", "nest another IF")
        else:
            self.open[-1].parts.append(i)
