"""How variables begin: with the arguments of a call, and with the initial values of declarations."""

from __future__ import annotations

from lwr_dyn.krl.checks.type_check import shape_of
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.declarations import Declarator, Parameter
from lwr_dyn.krl.names.types import Type
from lwr_dyn.krl.project.symbols import DeclaredName
from lwr_dyn.krl.running.evaluate import Environment, aggregate_value, number_of, value_of
from lwr_dyn.krl.running.values import ArrayValue, Value, Variable, converted, text_array

LARGEST_ARRAY = 100_000
"""Most elements along one dimension of an array."""


def argument_variable(env: Environment, x: e.Expression | None, p: Parameter, kind: Type) -> Variable:
    """The variable of a parameter: the caller's own for OUT, where the argument is one; else a new one."""
    if x is None:
        return Variable(kind)
    if p.mode != "IN" and isinstance(x, e.Name):
        return env.variable(x.name)
    if p.mode != "IN" and isinstance(x, e.Index) and not x.indices and isinstance(x.of, e.Name):
        return env.variable(x.of.name)
    return Variable(kind, converted(value_of(env, x), kind))


def initialised(env: Environment, name: DeclaredName) -> Variable:
    """The variable as declared, with its initial value; raises `ExecutionError`."""
    d, kind = name.declarator, name.type
    if d is None:
        return Variable(kind)
    if d.sizes is not None:
        return Variable(kind, _initial_array(env, d, kind))
    if kind.name == "?" and isinstance(d.value, e.Aggregate):
        kind = shape_of(d.value)
    if d.value is None:
        return Variable(kind)
    if isinstance(d.value, e.Aggregate):
        return Variable(kind, aggregate_value(env, d.value, kind.name))
    return Variable(kind, converted(value_of(env, d.value), kind))


def _initial_array(env: Environment, d: Declarator, kind: Type) -> Value:
    sizes = tuple(int(number_of(env, x, "a size")) for x in d.sizes or ())
    if any(not 1 <= n <= LARGEST_ARRAY for n in sizes):
        message = f"{d.name} has the size {', '.join(map(str, sizes))}"
        raise ExecutionError("index-range", message, f"from 1 to {LARGEST_ARRAY}")
    return text_array(d.value.value, sizes) if isinstance(d.value, e.Text) else ArrayValue(kind.name, sizes)
