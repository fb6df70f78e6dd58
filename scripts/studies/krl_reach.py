"""Which statements of a program some way leads to, whatever its conditions are.

Those behind a GOTO, a RETURN or a LOOP without EXIT are left out; past a SWITCH a way always leads.
Taught points are often kept in a program behind a jump over them, to be touched up there: no controller moves to them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import CodeBlock, Routine
from lwr_dyn.krl.project.program import Program

CALL = re.compile(r"([A-Z_$][A-Z0-9_$]*)\s*\(")


def reachable_lines(program: Program) -> set[int]:
    """Lines from 1 of the `.src`, in its first routine and in those that it calls, one through another."""
    mine = {x.name: x for x in program.routines}
    waiting, seen = program.routines[:1], set[str]()
    found: set[int] = set()
    while waiting:
        routine = waiting.pop()
        if routine.name in seen:
            continue
        seen.add(routine.name)
        lines = lines_of(routine)
        found |= {i + 1 for i in lines}
        for i in lines:
            waiting += [mine[name] for name in CALL.findall(routine.file.lines[i].text().upper()) if name in mine]
    return found


def lines_of(routine: Routine) -> set[int]:
    """Indices of the lines of one routine that some way leads to."""
    found, waiting = set[int](), [routine.first]
    while waiting:
        i = waiting.pop()
        if i in found or not routine.first <= i < routine.last:
            continue
        found.add(i)
        waiting += _next(routine, i)
    return found


def _next(routine: Routine, i: int) -> Iterator[int]:
    """The lines that may come after line `i`."""
    x, block = routine.file.lines[i].statement, routine.blocks.get(i)
    if isinstance(x, s.Return):
        return
    if isinstance(x, s.Jump):
        yield from (routine.labels[name] for name in [x.label.upper()] if name in routine.labels)
    elif block is None:
        yield i + 1
    else:
        yield from _within(x, block, i)


def _within(x: s.Statement | None, block: CodeBlock, i: int) -> Iterator[int]:
    """The same for a line that opens, splits, leaves or closes a block."""
    word = x.keyword if isinstance(x, s.Plain | s.Condition) else ""
    if isinstance(x, s.CaseBranch) or word in ("ELSE", "DEFAULT", "EXIT"):
        # of SWITCH and IF the line is passed when the part before it ends; the head leads into the part itself
        yield block.last + 1
    elif word in ("ENDLOOP", "ENDFOR", "ENDWHILE", "UNTIL"):
        yield block.first + 1
        if word != "ENDLOOP":
            yield i + 1
    else:
        yield i + 1
        if word in ("IF", "SWITCH"):
            yield from (part + 1 for part in block.parts)
        if word in ("SWITCH", "WHILE") or isinstance(x, s.For) or (word == "IF" and not block.parts):
            yield block.last + 1
