"""Inputs and outputs of the controller: what an element of `$IN`, `$OUT`, `$FLAG` ... is, given, assumed or set."""

from __future__ import annotations

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.running.clock import ProgramClock
from lwr_dyn.krl.running.controller import INPUTS, ControllerState
from lwr_dyn.krl.running.values import ArrayValue, Value, value_text

AT_START: dict[str, Value] = {
    "$OUT": False, "$FLAG": False, "$CYCFLAG": False, "$TIMER_STOP": True, "$TIMER": 0, "$ANOUT": 0,
}  # fmt: skip
"""Arrays of the controller -> the value of each element at the start."""


def element_value(c: ControllerState, clock: ProgramClock, name: str, index: tuple[int, ...]) -> Value | None:
    """An element of an input or output, a flag; None for an ordinary array; raises `ExecutionError`."""
    key = name.upper()
    text = f"{key}[{','.join(map(str, index))}]"
    if key in ("$TIMER", "$TIMER_FLAG") and len(index) == 1:
        clock.timers_read.add(index[0])
        return round(clock.timer(index[0])) if key == "$TIMER" else clock.timer(index[0]) > 0.0
    if text in c.inputs:
        c.assumptions.note(text, value_text(c.inputs[text]), "given")
        return c.inputs[text]
    if key == "$IN" and index in ((1025,), (1026,)):
        return index == (1025,)
    if key in INPUTS:
        given = c.variables[key].value if key in c.variables else None
        value = given.items.get(index) if isinstance(given, ArrayValue) else None
        return _other_input(c, key, text) if value is None else value
    if key not in AT_START:
        return None
    variable = c.variable(key)
    array = None if variable is None else variable.value
    value = array.items.get(index) if isinstance(array, ArrayValue) else None
    if value is None:
        c.assumptions.note(f"{key}[]", value_text(AT_START[key]), "at the start")
    return AT_START[key] if value is None else value


def _other_input(c: ControllerState, key: str, text: str) -> Value:
    """An input that nothing gives; raises `ExecutionError` unless the cell file says what others are."""
    others = c.cell.other_inputs
    if others is None:
        hint = f"give one: --set '{text}=TRUE', or in a cell file"
        raise ExecutionError("unknown-input", f"the input {text} has no value", hint)
    value: Value = others if key == "$IN" else 0.0 if key == "$ANIN" else 0
    c.assumptions.note(text, value_text(value), "inputs.others of the cell file")
    return value
