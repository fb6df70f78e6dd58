"""Conditions of interrupts and of the cell's answers: whether one is true, and when it becomes true.

One on what moves (`$POS_ACT`, `$AXIS_ACT`, `$TIMER`) may become true while the arm is on its way: each interpolation
cycle is looked at, and the time within it is found by bisection. What is true for less than a cycle may be missed, as
by the robot's own controller.
"""

from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.unparse import expression_text
from lwr_dyn.krl.running.controller import OF_MOTION
from lwr_dyn.krl.running.evaluate import truth_of
from lwr_dyn.krl.running.running_program import RunningProgram, Watch
from lwr_dyn.krl.running.triggers import SAME, TICK

MOVING = OF_MOTION | {"$TIMER", "$TIMER_FLAG"}
"""Variables whose value changes while no statement is executed."""


def is_true(m: RunningProgram, condition: e.Expression) -> bool:
    """Whether it is true now; looking does not stop the advance run. FALSE where a value is missing."""
    advance = m.motions.advance
    try:
        return truth_of(m, condition, "a condition")
    except ExecutionError as fault:
        m.controller.assume(expression_text(condition), "FALSE", str(fault))
        return False
    finally:
        m.motions.advance = advance


def follows_motion(x: Any) -> bool:
    """Whether an expression, or one in it, names a variable of `MOVING`.

    >>> from lwr_dyn.krl.language.line_parser import statement_of
    >>> [follows_motion(statement_of(text).value) for text in ("X = $TIMER[1] > 5", "X = $IN[1]")]
    [True, False]
    """
    if isinstance(x, e.Name):
        return x.name.upper() in MOVING
    parts = x if isinstance(x, tuple) else [getattr(x, f.name) for f in fields(x)] if is_dataclass(x) else []
    return any(map(follows_motion, parts))


def next_rise(m: RunningProgram, watches: Sequence[Watch], until: float) -> tuple[float, Watch] | None:
    """The first of the conditions that becomes true up to a time [s], and when [s]; None where none does.

    It goes on where the last call has ended; of two at one time the one that stands first is meant.
    """
    begin, time = m.clock.looked, m.clock.looked
    while watches:
        rises = [x for x in watches if time > x.since - SAME and _rises(m, x, time)]
        if rises:
            found = [(_bisected(m, x, begin, time), i) for i, x in enumerate(rises)]
            m.clock.looked, first = min(found)
            return m.clock.looked, rises[first]
        if time >= until:
            break
        begin, time = time, min(time + TICK, until)
    m.clock.looked = max(until, m.clock.looked)
    return None


def _rises(m: RunningProgram, x: Watch, time: float) -> bool:
    now = _is_true_at(m, x, time)
    rises, x.last = now and not x.last, now and x.last
    return rises


def _bisected(m: RunningProgram, x: Watch, begin: float, end: float) -> float:
    """The time at which a condition becomes true that is false at the beginning and true at the end."""
    begin = max(begin, x.since)
    while end - begin > SAME:
        middle = 0.5 * (begin + end)
        begin, end = (begin, middle) if _is_true_at(m, x, middle) else (middle, end)
    return end


def _is_true_at(m: RunningProgram, x: Watch, time: float) -> bool:
    before, m.clock.at = m.clock.at, time
    try:
        return is_true(m, x.condition)
    finally:
        m.clock.at = before
