"""Which routine a call enters, and the values of calls that enter none: stubs, the functions of the controller."""

from __future__ import annotations

from typing import Protocol

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.running.controller import ControllerState
from lwr_dyn.krl.running.evaluate import Environment, reference_to
from lwr_dyn.krl.running.functions import function_value, is_computed
from lwr_dyn.krl.running.values import Value, value_text


class Caller(Environment, Protocol):
    """Where a call stands."""

    controller: ControllerState

    def routine(self, name: str) -> Routine | None:
        """A routine that the module of the current routine sees."""


def called_routine(m: Caller, name: str) -> Routine | None:
    """The routine that a call enters; None for a stub, and for what `bas.src` defines and the model computes."""
    if name in m.controller.cell.stubs:
        return None
    routine = m.routine(name)
    if routine is not None and routine.file.name.lower().endswith("bas.src") and (name == "BAS" or is_computed(name)):
        return None
    return routine


def value_of_call(m: Caller, x: e.FunctionCall) -> Value | None:
    """The value of a stub or of a function of the controller; None where there is none; raises `ExecutionError`."""
    return _stub_value(m, x) if x.name.upper() in m.controller.cell.stubs else function_value(m, m.controller, x)


def _stub_value(m: Caller, x: e.FunctionCall) -> Value | None:
    """What the cell file gives for a call, its OUT arguments set."""
    name = x.name.upper()
    stub = m.controller.cell.stubs[name]
    m.controller.assumptions.note(f"{name}( )", "nothing" if stub.returns is None else value_text(stub.returns), "stub")
    for i, value in stub.out.items():
        target = x.arguments[i - 1] if i <= len(x.arguments) else None
        if not isinstance(target, e.Name | e.Index | e.Component):
            raise ExecutionError("arguments", f"the stub of {name} sets argument {i}, which is no variable", "")
        reference_to(m, target).write(value)
    return stub.returns
