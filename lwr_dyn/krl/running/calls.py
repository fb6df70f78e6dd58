"""Which routine a call enters, and the values of calls that enter none: stubs, the functions of the controller."""

from __future__ import annotations

from typing import Protocol

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.names.types import UNKNOWN, Type
from lwr_dyn.krl.project.program import Program
from lwr_dyn.krl.running.controller import ControllerState
from lwr_dyn.krl.running.evaluate import Environment, reference_to
from lwr_dyn.krl.running.functions import function_value, is_computed
from lwr_dyn.krl.running.values import StructValue, Value, value_text

_EMPTY: dict[str, Value] = {"BOOL": False, "INT": 0, "REAL": 0.0, "CHAR": " "}


class Caller(Environment, Protocol):
    """Where a call stands."""

    controller: ControllerState

    @property
    def here(self) -> Program:
        """The program of the module of the current routine."""

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


def empty_value(m: Caller, x: e.FunctionCall) -> Value | None:
    """With `stubs.others` of the cell the value of a function that is not there; else None."""
    if not m.controller.cell.other_stubs:
        return None
    name = x.name.upper()
    function, external = m.here.project.known.functions.get(name), m.here.names.externals.get(name)
    kind = function.returns if function is not None else None
    if external is not None and external.returns is not None:
        kind = Type(external.returns.upper())
    value = _empty(m, UNKNOWN if kind is None else kind)
    m.controller.assumptions.note(f"{name}( )", value_text(value), "stubs.others of the cell file")
    return value


def _empty(m: Caller, kind: Type) -> Value:
    if kind.name in _EMPTY:
        return _EMPTY[kind.name]
    parts = m.here.names.structures.get(kind.name) or m.here.project.known.structures.get(kind.name)
    if parts is None:
        return 0
    return StructValue(
        kind.name, {k: _EMPTY[v.name] for k, v in parts.items() if v.name in _EMPTY and not v.dimensions}
    )


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
