"""Variables as they come into being: those that a declaration makes, and the parameters of a call."""

from __future__ import annotations

from lwr_dyn.krl import expressions as e
from lwr_dyn.krl.declarations import Declarator, Parameter
from lwr_dyn.krl.evaluate import Environment, aggregate_value, number_of, value_of
from lwr_dyn.krl.program import Variable
from lwr_dyn.krl.types import Type
from lwr_dyn.krl.typing import shape_of
from lwr_dyn.krl.values import HaltError, Many, Slot, Value, converted

OPEN_ARRAY = 100_000
"""Elements of one array."""


def argument(env: Environment, x: e.Expression | None, p: Parameter, kind: Type) -> Slot:
    """By value for IN; by reference for OUT: the slot itself where the argument is a plain variable."""
    if x is None:
        return Slot(kind)
    if p.mode != "IN" and isinstance(x, e.Name):
        return env.slot(x.name)
    if p.mode != "IN" and isinstance(x, e.Index) and not x.indices and isinstance(x.of, e.Name):
        return env.slot(x.of.name)
    return Slot(kind, converted(value_of(env, x), kind))


def fresh(env: Environment, variable: Variable) -> Slot:
    """The variable as it is declared, with its first value where there is one; raises `HaltError`."""
    d, kind = variable.declarator, variable.type
    if d is None:
        return Slot(kind)
    if d.sizes is not None:
        return Slot(kind, _array(env, d, kind))
    if kind.name == "?" and isinstance(d.value, e.Aggregate):
        kind = shape_of(d.value)
    slot = Slot(kind)
    if d.value is not None:
        slot.value = _initial(env, d.value, kind)
    return slot


def _array(env: Environment, d: Declarator, kind: Type) -> Value | None:
    sizes = tuple(int(number_of(env, x, "a size")) for x in d.sizes or ())
    if any(not 1 <= n <= OPEN_ARRAY for n in sizes):
        raise HaltError("index-range", f"{d.name} has the size {', '.join(map(str, sizes))}", f"from 1 to {OPEN_ARRAY}")
    if isinstance(d.value, e.Text):
        return d.value.value
    return Many(kind.name, sizes)


def _initial(env: Environment, x: e.Expression, kind: Type) -> Value:
    if isinstance(x, e.Aggregate):
        return aggregate_value(env, x, kind.name)
    return converted(value_of(env, x), kind)
