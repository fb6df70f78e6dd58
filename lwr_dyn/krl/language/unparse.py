"""Expressions and statements -> their text, as KUKA's own editor writes it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.language import declarations as d
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s

UNARY = 9
"""Priority of + - NOT with one operand."""


def expression_text(x: e.Expression, weakest: int = 0) -> str:
    """An expression as text, in brackets when it binds weaker than `weakest`.

    >>> expression_text(e.Binary("*", e.Binary("+", e.Name("A"), e.Integer(1)), e.Real(2.0)))
    '(A + 1) * 2.0'
    """
    return _EXPRESSIONS[type(x)](x, weakest)


def statement_text(x: s.Statement) -> str:
    """A statement as one line of text without indentation and comment.

    >>> statement_text(s.Wait("SEC", e.Real(0.5)))
    'WAIT SEC 0.5'
    """
    return _STATEMENTS[type(x)](x)


def number_text(value: float) -> str:
    """A real number that reads back as the same double.

    >>> number_text(1e-7), number_text(91.0)
    ('1E-07', '91.0')
    """
    if not math.isfinite(value):
        raise OptionError("number", value, "a finite number: KRL has no sign for others")
    return repr(value).upper()


def _integer(x: e.Integer, _: int) -> str:
    if x.base == 2:
        return f"'B{x.value:0{x.digits}b}'"
    return f"'H{x.value:0{x.digits}X}'" if x.base == 16 else str(x.value)


def _call(x: e.FunctionCall, _: int = 0) -> str:
    arguments = ", ".join("" if a is None else expression_text(a) for a in x.arguments)
    return f"{x.name}({arguments})"


def _aggregate(x: e.Aggregate, _: int) -> str:
    items = (f"{item.name}{_brackets(item.indices)} {expression_text(item.value)}" for item in x.items)
    return "{" + ("" if x.type is None else f"{x.type}: ") + ", ".join(items) + "}"


def _unary(x: e.Unary, weakest: int) -> str:
    space = " " if x.operator.isalpha() or "_" in x.operator else ""
    text = f"{x.operator}{space}{expression_text(x.operand, UNARY)}"
    return f"({text})" if weakest > UNARY else text


def _binary(x: e.Binary, weakest: int) -> str:
    own = e.PRIORITY[x.operator]
    # operators of one priority read from the left, so the right one needs brackets
    text = f"{expression_text(x.left, own)} {x.operator} {expression_text(x.right, own + 1)}"
    return f"({text})" if own < weakest else text


_EXPRESSIONS: dict[type, Callable[[Any, int], str]] = {
    e.Integer: _integer,
    e.Real: lambda x, _: number_text(x.value),
    e.Bool: lambda x, _: "TRUE" if x.value else "FALSE",
    e.Text: lambda x, _: f'"{x.value}"',
    e.EnumLiteral: lambda x, _: f"#{x.name}",
    e.Name: lambda x, _: x.name,
    e.Index: lambda x, _: f"{expression_text(x.of)}[{_list(x.indices)}{',' if x.row else ''}]",
    e.Component: lambda x, _: f"{expression_text(x.of)}.{x.name}",
    e.FunctionCall: _call,
    e.ChannelName: lambda x, _: f":{x.name}",
    e.Aggregate: _aggregate,
    e.Unary: _unary,
    e.Binary: _binary,
}


def _list(values: Sequence[e.Expression]) -> str:
    return ", ".join(expression_text(v) for v in values)


def _after(words: str, value: e.Expression | None) -> str:
    """A value behind its words; nothing where it is left out."""
    return "" if value is None else words + expression_text(value)


def _brackets(sizes: tuple[e.Expression, ...] | None) -> str:
    return "" if sizes is None else f"[{_list(sizes)}]"


def _words(*words: str | None) -> str:
    return " ".join(word for word in words if word)


def _global(
    x: d.Def | d.Declaration | d.EnumType | d.StructType | d.Signal | d.Channel | s.InterruptDeclaration,
) -> str | None:
    return "GLOBAL" if x.is_global else None


def _declarator(x: d.Declarator) -> str:
    brackets = f"[{',' * x.commas}]" if x.commas else _brackets(x.sizes)
    return f"{x.name}{brackets}{_after(' = ', x.value)}"


def _parameter(x: d.Parameter) -> str:
    brackets = _brackets(x.sizes) if x.sizes else f"[{',' * (x.dimensions - 1)}]" if x.dimensions else ""
    return f"{x.name}{brackets}" + (f":{x.mode}" if x.mode else "")


def _def(x: d.Def) -> str:
    parameters = ", ".join(map(_parameter, x.parameters)) or " "
    head = "DEF" if x.returns is None else f"DEFFCT {x.returns}{_brackets(x.returns_sizes)}"
    return _words(_global(x), head, f"{x.name}({parameters})")


def _declaration(x: d.Declaration) -> str:
    decl, const = "DECL" if x.decl else None, "CONST" if x.const else None
    return _words(decl, _global(x), const, x.type, ", ".join(map(_declarator, x.names)))


def _external(x: d.External) -> str:
    own = "P" if x.of_controller else ""
    head = f"EXT{own}" if x.returns is None else f"EXTFCT{own} {x.returns}{_brackets(x.returns_sizes)}"
    return f"{head} {x.name}({', '.join(x.parameters) or ' '})"


def _settings(settings: tuple[s.Assign, ...]) -> str | None:
    return f"WITH {', '.join(map(statement_text, settings))}" if settings else None


def _move(x: s.Move) -> str:
    points = ", ".join(expression_text(p) for p in (x.auxiliary, x.target) if p is not None) + _after(", CA ", x.angle)
    frame = None if x.frame is None else f"#{x.frame}"
    return _words(x.kind, points, _settings(x.settings), *x.blends, frame)


def _for(x: s.For) -> str:
    ends = f"{expression_text(x.variable)} = {expression_text(x.first)} TO {expression_text(x.last)}"
    return _words("FOR", ends, _after("STEP ", x.step))


def _interrupt(x: s.InterruptDeclaration) -> str:
    head = _words(_global(x), f"INTERRUPT{' WITH BRAKE' * x.with_brake} DECL", expression_text(x.priority))
    return f"{head} WHEN {expression_text(x.condition)} DO {statement_text(x.action)}"


def _trigger(x: s.Trigger) -> str:
    place = f"TRIGGER WHEN {x.place} = {expression_text(x.value)}{' ONSTART' * x.on_start}"
    action = f"DELAY = {expression_text(x.delay)} DO {statement_text(x.action)}"
    return _words(place, action, _after("PRIO = ", x.priority))


def _conditional_stop(x: s.ConditionalStop) -> str:
    place = f"STOP WHEN PATH = {expression_text(x.distance)}{' ONSTART' * x.on_start}"
    return f"{place} IF {expression_text(x.condition)}"


def _analog(x: s.Analog) -> str:
    target, options = expression_text(x.target), map(statement_text, x.options)
    return _words(x.keyword, x.mode, target, _after("= ", x.value), *options)


_STATEMENTS: dict[type, Callable[[Any], str]] = {
    d.Header: lambda x: x.text,
    d.Def: _def,
    d.DefDat: lambda x: _words("DEFDAT", x.name, "PUBLIC" if x.public else None),
    s.Plain: lambda x: x.keyword,
    s.Confirm: lambda x: f"CONFIRM {expression_text(x.value)}",
    d.Declaration: _declaration,
    d.EnumType: lambda x: _words(_global(x), "ENUM", x.name, ", ".join(x.members)),
    d.StructType: lambda x: _words(
        _global(x), "STRUC", x.name, ", ".join(f"{kind} {', '.join(map(_declarator, of))}" for kind, of in x.members)
    ),
    d.Signal: lambda x: _words(_global(x), "SIGNAL", x.name, expression_text(x.first), _after("TO ", x.last)),
    d.Channel: lambda x: _words(_global(x), f"CHANNEL :{x.name} :{x.channel}", expression_text(x.structure)),
    d.External: _external,
    s.Assign: lambda x: f"{expression_text(x.target)} = {expression_text(x.value)}",
    s.Invoke: lambda x: _call(x.call),
    s.Move: _move,
    s.SplineBlock: lambda x: _words(x.kind, _settings(x.settings)),
    s.EndSpline: lambda x: _words("ENDSPLINE", *x.blends),
    s.Wait: lambda x: f"WAIT {x.kind} {expression_text(x.value)}",
    s.Condition: lambda x: _words(x.keyword, expression_text(x.value), "THEN" if x.keyword == "IF" else None),
    s.CaseBranch: lambda x: f"CASE {_list(x.values)}",
    s.For: _for,
    s.Jump: lambda x: f"GOTO {x.label}",
    s.Label: lambda x: f"{x.name}:",
    s.Return: lambda x: _words("RETURN", _after("", x.value)),
    s.InterruptDeclaration: _interrupt,
    s.InterruptSwitch: lambda x: _words("INTERRUPT", x.mode, _after("", x.priority)),
    s.Trigger: _trigger,
    s.ConstantSpeed: lambda x: _words("CONST_VEL", x.bound, _after("= ", x.offset), "ONSTART" if x.on_start else None),
    s.TimeBlock: lambda x: _words("TIME_BLOCK", x.bound, _after("= ", x.value)),
    s.ConditionalStop: _conditional_stop,
    s.Analog: _analog,
}
