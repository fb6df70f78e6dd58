"""Blocks of a routine: which ENDIF closes which IF, and what is missing or closes nothing.

Where an end is missing or left over, the lines are paired once more by their indentation, and the pairing with the
fewest faults is taken (of equal ones that by indentation): then the block is named that really lost its end.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from lwr_dyn.krl.diagnostics import Diagnostic
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.source import SourceFile

OPENERS = {"IF": "ENDIF", "WHILE": "ENDWHILE", "SWITCH": "ENDSWITCH", "FOR": "ENDFOR", "LOOP": "ENDLOOP",
           "REPEAT": "UNTIL", "SPLINE": "ENDSPLINE", "PTP_SPLINE": "ENDSPLINE"}  # fmt: skip
CLOSERS = frozenset(OPENERS.values())
LOOPS = frozenset({"WHILE", "FOR", "LOOP", "REPEAT"})
PARTS = {"ELSE": "IF", "CASE": "SWITCH", "DEFAULT": "SWITCH"}
NESTED = 200
"""Most blocks inside one another; those inside are not paired."""
_OPENERS_OF = {ender: tuple(o for o, other in OPENERS.items() if other == ender) for ender in CLOSERS}
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


@dataclass(slots=True, eq=False)
class PairedBlocks:
    """The blocks of a routine, by each line that opens, splits, leaves or closes one, and their faults."""

    blocks: dict[int, CodeBlock] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)


def keyword_of(statement: s.Statement | None) -> str:
    """The keyword by which a line opens, splits or closes a block; empty for other lines."""
    if isinstance(statement, s.Plain | s.Condition):
        return statement.keyword
    if isinstance(statement, s.SplineBlock):
        return statement.kind
    return {s.For: "FOR", s.CaseBranch: "CASE", s.EndSpline: "ENDSPLINE"}.get(type(statement), "")


def paired_blocks(file: SourceFile, words: Sequence[tuple[int, str]], last: int) -> PairedBlocks:
    """The blocks of lines (index and keyword) of one routine whose body ends before line `last`."""
    in_order = _Pairing(file, "order").read(words, last)
    if not in_order.diagnostics:
        return in_order
    ways: tuple[Way, ...] = ("strict", "indentation")
    pairings = [*(_Pairing(file, way).read(words, last) for way in ways), in_order]
    return min(pairings, key=lambda pairing: len(pairing.diagnostics))


class _Pairing:
    """Pairs the block lines of one routine, in order."""

    def __init__(self, file: SourceFile, way: Way) -> None:
        self.file, self.way = file, way
        self.out = PairedBlocks()
        self.open: list[CodeBlock] = []
        self.indentations: dict[int, int] = {}
        self.deeper = 0

    def read(self, words: Sequence[tuple[int, str]], last: int) -> PairedBlocks:
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
        return self.out

    def _report(self, i: int, code: str, message: str, hint: str) -> None:
        column = getattr(self.file.lines[i].statement, "column", 1)
        self.out.diagnostics.append(Diagnostic(self.file.position(i, column), "error", code, message, hint))

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
            self.out.blocks[i] = block
        # a line that closes several blocks (an inner one has no end) belongs to the outermost
        self.out.blocks[last] = block

    def _left(self, i: int) -> None:
        loop = next((block for block in reversed(self.open) if block.kind in LOOPS), None)
        if loop is not None:
            self.out.blocks[i] = loop
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
