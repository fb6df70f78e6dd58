"""WAIT, HALT: the program stands until a time has passed or until something beside it makes a condition true."""

from __future__ import annotations

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.unparse import expression_text
from lwr_dyn.krl.running.context import ExecutionContext
from lwr_dyn.krl.running.evaluate import number_of, truth_of

MOST_LOOKS = 10_000
"""Times that a waiting program looks again while only timers or submit programs run."""


def wait(m: ExecutionContext, x: s.Wait) -> None:
    """WAIT SEC or WAIT FOR; raises `ExecutionError` where nothing can end it."""
    if x.kind == "SEC":
        m.motions.wait(number_of(m, x.value, "WAIT SEC"), m.log.position)
    else:
        _wait_for(m, x)


def _wait_for(m: ExecutionContext, x: s.Wait) -> None:
    looks = 0
    while not (met := truth_of(m, x.value, "WAIT FOR")) and looks < MOST_LOOKS:
        time = m.background.next_time()
        if time is None or m.motions.now > m.machine.seconds:
            break
        m.motions.wait(max(time - m.motions.now, 0.0), m.log.position, "WAIT FOR")
        m.background.run_submits()
        m.background.settle()
        looks += 1
    m.motions.stop_advance()
    if not met:
        _unmet(m, expression_text(x.value))


def _unmet(m: ExecutionContext, text: str) -> None:
    after = m.controller.cell.unmet_wait
    if after is None:
        message = "the condition is FALSE and nothing here can change it"
        raise ExecutionError(
            "waits-forever", message, "set its input: --set, or a reply or unmet_wait_s in a cell file"
        )
    m.controller.assumptions.note(f"WAIT FOR {text}", f"met after {after:g} s", "unmet_wait_s of the cell file")
    m.motions.wait(after, m.log.position, "WAIT FOR")


def halt(m: ExecutionContext) -> None:
    """HALT: the program is started again at once."""
    m.motions.stop_advance()
    m.background.clock.record(m.log.position, "halt", "HALT")
    m.controller.assumptions.note("HALT", "", "the program is started again at once")
