"""Where a routine goes on: branches, loops and jumps. A statement acts on the routine's next line and loop counts."""

from __future__ import annotations

from dataclasses import dataclass, field

from lwr_dyn.krl import statements as s
from lwr_dyn.krl.evaluate import Environment, number_of, target_of, truth_of, value_of
from lwr_dyn.krl.structure import Block, Routine
from lwr_dyn.krl.values import HaltError, Slot


@dataclass(slots=True, eq=False)
class Call:
    """A routine that is being carried out: its next line and its variables."""

    routine: Routine
    at: int
    slots: dict[str, Slot]
    loops: dict[int, tuple[int, int]] = field(default_factory=dict)
    """FOR line -> last value, step."""


def keyword(env: Environment, word: str, now: Call, at: int) -> None:
    """ELSE, CASE, DEFAULT and EXIT leave their block; ENDLOOP, ENDWHILE and ENDFOR go back to its beginning."""
    block = now.routine.blocks.get(at)
    if block is None:
        return
    if word in ("ELSE", "CASE", "DEFAULT", "EXIT"):
        now.at = block.last + 1
        return
    # an end line that also closes blocks whose own end is missing ends them all
    back = {"ENDLOOP": block.first + 1, "ENDWHILE": block.first}
    if word in back:
        now.at = back[word]
    elif word == "ENDFOR":
        _next(env, block, now)


def condition(env: Environment, x: s.Condition, now: Call, at: int) -> None:
    """IF, WHILE, UNTIL, SWITCH: into the block, to one of its parts, or past it; raises `HaltError`."""
    block = now.routine.blocks.get(at)
    if block is None:
        return
    if x.keyword == "SWITCH":
        _switch(env, x, block, now)
    elif x.keyword == "UNTIL":
        if not truth_of(env, x.value, "UNTIL"):
            now.at = block.first + 1
    elif not truth_of(env, x.value, x.keyword):
        now.at = (block.parts[0] if block.parts else block.last) + 1


def _switch(env: Environment, x: s.Condition, block: Block, now: Call) -> None:
    value = value_of(env, x.value)
    for at in block.parts:
        case = now.routine.file.lines[at].statement
        if not isinstance(case, s.Case) or any(value_of(env, v) == value for v in case.values):
            now.at = at + 1
            return
    now.at = block.last + 1


def begin_for(env: Environment, x: s.For, now: Call, at: int) -> None:
    """FOR: the variable takes its first value, or the loop is passed; raises `HaltError`."""
    block = now.routine.blocks.get(at)
    if block is None:
        return
    first, last = (round(number_of(env, v, "FOR")) for v in (x.first, x.last))
    step = 1 if x.step is None else round(number_of(env, x.step, "STEP"))
    if step == 0:
        raise HaltError("endless", "STEP 0 never ends", "a step that is not 0")
    target_of(env, x.variable).write(first)
    now.loops[at] = (last, step)
    if (first - last) * step > 0:
        now.at = block.last + 1


def _next(env: Environment, block: Block, now: Call) -> None:
    x = now.routine.file.lines[block.first].statement
    if not isinstance(x, s.For) or block.first not in now.loops:
        return
    last, step = now.loops[block.first]
    target = target_of(env, x.variable)
    value = target.read()
    if not isinstance(value, int):
        raise HaltError("no-value", "the variable of FOR has lost its value", "do not assign it in the loop")
    if (value + step - last) * step <= 0:
        target.write(value + step)
        now.at = block.first + 1


def goto(x: s.Jump, now: Call) -> None:
    """GOTO: on at the label; raises `HaltError`."""
    if x.label.upper() not in now.routine.labels:
        raise HaltError("undeclared", f"there is no label {x.label}", "")
    now.at = now.routine.labels[x.label.upper()]
