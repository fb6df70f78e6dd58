"""Where a routine goes on: IF, SWITCH, WHILE, UNTIL, FOR, GOTO and the keywords that end or leave their blocks."""

from __future__ import annotations

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import CodeBlock
from lwr_dyn.krl.running.evaluate import number_of, reference_to, truth_of, value_of
from lwr_dyn.krl.running.running_program import RunningProgram, StackFrame


def block_keyword(m: RunningProgram, keyword: str, frame: StackFrame, at: int) -> None:
    """ELSE, CASE, DEFAULT and EXIT leave their block; ENDLOOP, ENDWHILE and ENDFOR return to its beginning."""
    block = frame.routine.blocks.get(at)
    if block is None:
        return
    if keyword in ("ELSE", "CASE", "DEFAULT", "EXIT"):
        frame.at = block.last + 1
        return
    # the block of this line is the outermost one that it closes
    back = {"ENDLOOP": block.first + 1, "ENDWHILE": block.first}
    if keyword in back:
        frame.at = back[keyword]
    elif keyword == "ENDFOR":
        _next_for(m, block, frame)


def branch(m: RunningProgram, x: s.Condition, frame: StackFrame, at: int) -> None:
    """IF, WHILE, UNTIL, SWITCH: into the block, to one of its parts, or past it."""
    block = frame.routine.blocks.get(at)
    if block is None:
        return
    if x.keyword == "SWITCH":
        _switch(m, x, block, frame)
    elif x.keyword == "UNTIL":
        if not truth_of(m, x.value, "UNTIL"):
            frame.at = block.first + 1
    elif not truth_of(m, x.value, x.keyword):
        frame.at = (block.parts[0] if block.parts else block.last) + 1


def _switch(m: RunningProgram, x: s.Condition, block: CodeBlock, frame: StackFrame) -> None:
    value = value_of(m, x.value)
    for at in block.parts:
        case = frame.routine.file.lines[at].statement
        if not isinstance(case, s.CaseBranch) or any(value_of(m, v) == value for v in case.values):
            frame.at = at + 1
            return
    frame.at = block.last + 1


def begin_for(m: RunningProgram, x: s.For, frame: StackFrame, at: int) -> None:
    """FOR: into the block, or past it; raises `ExecutionError`."""
    block = frame.routine.blocks.get(at)
    if block is None:
        return
    first, last = (round(number_of(m, v, "FOR")) for v in (x.first, x.last))
    step = 1 if x.step is None else round(number_of(m, x.step, "STEP"))
    if step == 0:
        raise ExecutionError("endless", "STEP 0 never ends", "a step that is not 0")
    reference_to(m, x.variable).write(first)
    frame.loops[at] = (last, step)
    if (first - last) * step > 0:
        frame.at = block.last + 1


def _next_for(m: RunningProgram, block: CodeBlock, frame: StackFrame) -> None:
    x = frame.routine.file.lines[block.first].statement
    if not isinstance(x, s.For) or block.first not in frame.loops:
        return
    last, step = frame.loops[block.first]
    variable = reference_to(m, x.variable)
    value = variable.read()
    if not isinstance(value, int):
        raise ExecutionError("no-value", "the variable of FOR has lost its value", "do not assign it in the loop")
    if (value + step - last) * step <= 0:
        variable.write(value + step)
        frame.at = block.first + 1


def goto(x: s.Jump, frame: StackFrame) -> None:
    """GOTO; raises `ExecutionError` where there is no such label."""
    if x.label.upper() not in frame.routine.labels:
        raise ExecutionError("undeclared", f"there is no label {x.label}")
    frame.at = frame.routine.labels[x.label.upper()]
