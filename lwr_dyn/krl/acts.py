"""What each statement does to a running program, as plain functions in a table; RETURN is the machine's own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from lwr_dyn.krl import expressions as e
from lwr_dyn.krl import flow
from lwr_dyn.krl import statements as s
from lwr_dyn.krl.bas import bas
from lwr_dyn.krl.built_in import function_value
from lwr_dyn.krl.controller import Controller
from lwr_dyn.krl.evaluate import Environment, aggregate_value, number_of, target_of, truth_of, value_of
from lwr_dyn.krl.findings import Findings
from lwr_dyn.krl.flow import Call
from lwr_dyn.krl.motions import Motions
from lwr_dyn.krl.program import Program
from lwr_dyn.krl.structure import Routine
from lwr_dyn.krl.values import HaltError, Struct, copied


class Running(Environment, Protocol):
    """A program that is being carried out, as far as its statements change it."""

    program: Program
    controller: Controller
    motions: Motions
    findings: Findings

    def enter(self, routine: Routine, x: e.Call | None) -> None:
        """Begin a routine with the arguments of a call."""


def carry_out(m: Running, x: s.Statement, now: Call, at: int) -> None:
    """Carry out the statement in line `at` of a routine; raises `HaltError`."""
    act = _ACTS.get(type(x))
    if act is not None:
        act(m, x, now, at)
    if not (isinstance(x, s.Plain) and x.keyword == "CONTINUE"):
        m.motions.kept = False


def assign(m: Running, x: s.Assign) -> None:
    """Put a value into its place; an output that is set stops the advance run; raises `HaltError`."""
    target = target_of(m, x.target)
    value = aggregate_value(m, x.value, target.type.name) if isinstance(x.value, e.Aggregate) else value_of(m, x.value)
    name = _root(x.target)
    before = target.read()
    if isinstance(x.value, e.Aggregate) and isinstance(before, Struct) and isinstance(value, Struct):
        # an aggregate sets the components it names, the others stay
        value = Struct(value.type, {**{k: copied(v) for k, v in before.parts.items()}, **value.parts})
    target.write(value)
    m.controller.written(name)
    if name.upper() in ("$OUT", "$ANOUT"):
        m.motions.stop_advance()


def _root(target: e.Reference) -> str:
    while not isinstance(target, e.Name):
        target = target.of
    return target.name


def _invoke(m: Running, x: s.Invoke) -> None:
    name = x.call.name.upper()
    routine = m.program.routine(name)
    if routine is not None:
        m.enter(routine, x.call)
    elif name == "BAS":
        _bas(m, x.call)
    elif function_value(m, x.call) is None:
        m.motions.note_unmodelled(name)


def _bas(m: Running, x: e.Call) -> None:
    arguments = [a for a in x.arguments if a is not None]
    if not arguments or not isinstance(arguments[0], e.EnumConstant):
        raise HaltError("type", "BAS without a command", "BAS(#INITMOV, 0)")
    value = number_of(m, arguments[1], "the value of BAS") if len(arguments) > 1 else 0.0
    bas(m.controller, arguments[0].name.upper(), value)


def _move(m: Running, x: s.Move) -> None:
    for setting in x.settings:
        assign(m, setting)
    m.motions.move(m, x, m.findings.place)


def _wait(m: Running, x: s.Wait) -> None:
    if x.kind == "SEC":
        m.motions.wait(number_of(m, x.value, "WAIT SEC"), m.findings.place)
    elif not truth_of(m, x.value, "WAIT FOR"):
        raise HaltError(
            "waits-forever", "the condition is FALSE and nothing here can change it", "set its input: --set"
        )
    else:
        m.motions.stop_advance()


def _plain(m: Running, x: s.Plain, now: Call, at: int) -> None:
    if x.keyword == "HALT":
        m.motions.stop_advance()
    elif x.keyword == "CONTINUE":
        m.motions.keep_advance()
    else:
        flow.keyword(m, x.keyword, now, at)


def _trigger(m: Running, x: s.Trigger) -> None:
    """A trigger's action is carried out where it is written: its time on the path is not modelled."""
    if isinstance(x.action, s.Assign):
        advance = m.motions.advance
        assign(m, x.action)
        m.motions.advance = advance


def _spline(m: Running, x: s.SplineBlock, now: Call, at: int) -> None:
    raise HaltError("not-modelled", f"{x.kind} ... ENDSPLINE is not modelled", "single SPTP, SLIN, SCIRC are")


_ACTS: dict[type, Callable[[Running, Any, Call, int], None]] = {
    s.Assign: lambda m, x, now, at: assign(m, x),
    s.Invoke: lambda m, x, now, at: _invoke(m, x),
    s.Move: lambda m, x, now, at: _move(m, x),
    s.Wait: lambda m, x, now, at: _wait(m, x),
    s.Plain: _plain,
    s.Condition: flow.condition,
    s.Case: lambda m, x, now, at: flow.keyword(m, "CASE", now, at),
    s.For: flow.begin_for,
    s.Jump: lambda m, x, now, at: flow.goto(x, now),
    s.Trigger: lambda m, x, now, at: _trigger(m, x),
    s.SplineBlock: _spline,
}
