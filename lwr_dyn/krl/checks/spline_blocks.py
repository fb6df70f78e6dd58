"""The lines of a spline block: its motions, and what belongs into such a block only."""

from __future__ import annotations

from collections.abc import Iterator

from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import OPENERS, CodeBlock, keyword_of
from lwr_dyn.krl.project.program import Scope

SPLINES = {"SPLINE": ("SPL", "SLIN", "SCIRC"), "PTP_SPLINE": ("SPTP",)}
"""The motions of each spline block; each has a form _REL."""
IN_SPLINE = (s.Move, s.Trigger, s.ConstantSpeed, s.TimeBlock, s.ConditionalStop)
_ONLY = "motions, TRIGGER, CONST_VEL, TIME_BLOCK and STOP WHEN only"
_INSTEAD = "TRIGGER WHEN PATH = 0 DELAY = 0 DO ... before a motion, or WITH for its speed"


def line_of(scope: Scope, i: int) -> s.Statement | None:
    """The statement in a line of the file; None without one."""
    return scope.file.lines[i].statement if i < len(scope.file.lines) else None


def inside(scope: Scope, first: int, last: int) -> Iterator[tuple[int, s.Statement]]:
    """The statements between two lines."""
    return ((i, x) for i in range(first + 1, last) if (x := line_of(scope, i)) is not None)


def blocks_of(scope: Scope) -> list[CodeBlock]:
    """The blocks of the routine; one whose end is missing is left out, as that is reported."""
    blocks = {} if scope.routine is None else {id(x): x for x in scope.routine.blocks.values()}
    return [x for x in blocks.values() if keyword_of(line_of(scope, x.last)) == OPENERS[x.kind]]


def check_spline(scope: Scope, block: CodeBlock) -> None:
    """Report motions of other kinds and statements that a spline block does not take."""
    motions = SPLINES[block.kind]
    for i, x in inside(scope, block.first, block.last):
        scope.line = i
        if isinstance(x, s.Move) and x.kind.removesuffix("_REL") not in motions:
            hint = f"{', '.join(motions)}, or end the block before"
            scope.report(x.column, "in-spline", f"{x.kind} inside {block.kind}", hint)
        elif not isinstance(x, IN_SPLINE):
            sets = isinstance(x, s.Assign | s.Invoke)
            what = keyword_of(x) or ("an assignment" if isinstance(x, s.Assign) else "this statement")
            column = getattr(x, "column", 1)
            scope.report(column, "in-spline", f"{what} inside {block.kind}", _INSTEAD if sets else _ONLY)


def check_within_spline(scope: Scope, x: s.ConstantSpeed | s.TimeBlock, i: int) -> None:
    """Report CONST_VEL outside of SPLINE, and TIME_BLOCK outside of both kinds of blocks or without its partner."""
    word, kinds = ("TIME_BLOCK", tuple(SPLINES)) if isinstance(x, s.TimeBlock) else ("CONST_VEL", ("SPLINE",))
    block = next((b for b in blocks_of(scope) if b.kind in kinds and b.first < i < b.last), None)
    if block is None:
        hint = f"between {kinds[0]} and ENDSPLINE"
        scope.report(x.column, "in-spline", f"{word} outside of {' and '.join(kinds)}", hint)
    elif isinstance(x, s.TimeBlock):
        before = [y.bound for _, y in inside(scope, block.first, i) if isinstance(y, s.TimeBlock)]
        after = [y.bound for _, y in inside(scope, i, block.last) if isinstance(y, s.TimeBlock)]
        if x.bound == "START" and "END" not in after:
            message, hint = "TIME_BLOCK START without its end", "TIME_BLOCK END = seconds in the block"
            scope.report(x.column, "in-spline", message, hint)
        elif x.bound != "START" and (not before or before[-1] == "END"):
            message, hint = f"TIME_BLOCK {x.bound} without a start", "TIME_BLOCK START before it in the block"
            scope.report(x.column, "in-spline", message, hint)
