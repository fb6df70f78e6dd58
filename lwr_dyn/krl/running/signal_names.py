"""SIGNAL names: a name for one input or output, or for a group of them, which is a whole number."""

from __future__ import annotations

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.declarations import Signal
from lwr_dyn.krl.names.types import BOOL, INT, REAL
from lwr_dyn.krl.running.evaluate import Environment, element_reference, value_of
from lwr_dyn.krl.running.values import Value, VariableReference


def signal_reference(env: Environment, signal: Signal) -> VariableReference:
    """Reads and writes what a SIGNAL names; raises `ExecutionError`."""
    places = signal_places(signal)
    if signal.last is None:
        kind = REAL if places[0].of in (e.Name("$ANIN"), e.Name("$ANOUT")) else BOOL
        return VariableReference(
            lambda: value_of(env, places[0]), lambda v: element_reference(env, places[0]).write(v), kind
        )

    def read() -> Value:
        return sum(1 << i for i, place in enumerate(places) if value_of(env, place) is True)

    def write(value: Value) -> None:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ExecutionError("type", f"{signal.name} is a group of outputs", "a whole number")
        for i, place in enumerate(places):
            element_reference(env, place).write(bool(int(value) >> i & 1))

    return VariableReference(read, write, INT)


def signal_places(signal: Signal) -> list[e.Index]:
    """The inputs or outputs of a SIGNAL, the lowest first; raises `ExecutionError` for another form."""
    first, last = signal.first, signal.first if signal.last is None else signal.last
    if not (isinstance(first, e.Index) and isinstance(last, e.Index) and first.of == last.of):
        raise ExecutionError("type", f"the SIGNAL {signal.name}", "$IN[1] or $OUT[1] TO $OUT[8]")
    numbers = [x.indices[0] if x.indices else None for x in (first, last)]
    low, high = numbers
    if not (isinstance(low, e.Integer) and isinstance(high, e.Integer)) or high.value - low.value not in range(32):
        raise ExecutionError("index-range", f"the SIGNAL {signal.name}", "from 1 to 32 inputs or outputs")
    return [e.Index(first.of, (e.Integer(n),)) for n in range(low.value, high.value + 1)]
