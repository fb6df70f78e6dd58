"""Builds the records of a line: one method for each rule of `grammar.lark`, its children in order."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lwr_dyn.krl import declarations as d
from lwr_dyn.krl import expressions as e
from lwr_dyn.krl import statements as s
from lwr_dyn.krl.lexer import Word

Nodes = list[Any]


class LineTree:
    """Rule -> record; a child that was left out is None."""

    # --- expressions
    def name(self, c: Nodes) -> Word:  # noqa: D102
        return c[0]  # type: ignore[no-any-return]

    def variable(self, c: Nodes) -> e.Name:  # noqa: D102
        return e.Name(c[0].text, c[0].column)

    def literal(self, c: Nodes) -> e.Literal:  # noqa: D102
        return _LITERALS[c[0].kind](c[0])

    def index(self, c: Nodes) -> e.Index:  # noqa: D102
        return e.Index(c[0], c[1], c[0].column)

    def indices(self, c: Nodes) -> tuple[e.Expression, ...]:  # noqa: D102
        return () if c == [None] else tuple(c)

    def no_indices(self, c: Nodes) -> tuple[e.Expression, ...]:  # noqa: D102
        return ()

    def component(self, c: Nodes) -> e.Component:  # noqa: D102
        return e.Component(c[0], c[1].text, c[1].column)

    def call(self, c: Nodes) -> e.Call:  # noqa: D102
        return e.Call(c[0].text, c[1], c[0].column)

    def arguments(self, c: Nodes) -> tuple[e.Expression | None, ...]:  # noqa: D102
        return () if c == [None] else tuple(c)

    def aggregate(self, c: Nodes) -> e.Aggregate:  # noqa: D102
        return e.Aggregate(tuple(c[2:]), None if c[1] is None else c[1].text, c[0].column)

    def item(self, c: Nodes) -> e.Item:  # noqa: D102
        return e.Item(c[0].text, c[2], c[1], c[0].column)

    def sizes(self, c: Nodes) -> tuple[e.Expression, ...]:  # noqa: D102
        return () if c == [None] else tuple(c)

    def primary(self, c: Nodes) -> e.Expression:  # noqa: D102
        out: e.Expression = c[0]
        return out

    def binary(self, c: Nodes) -> e.Binary:  # noqa: D102
        return e.Binary(c[1].text.upper(), c[0], c[2], c[1].column)

    def composed(self, c: Nodes) -> e.Binary:  # noqa: D102
        return e.Binary(":", c[0], c[1], c[1].column)

    def negated(self, c: Nodes) -> e.Unary:  # noqa: D102
        return e.Unary(c[0].text.upper(), c[1], c[0].column)

    # --- routines and files
    def def_(self, c: Nodes) -> d.Def:  # noqa: D102
        return d.Def(c[2].text, c[3] or (), is_global=c[0] is not None, column=c[2].column)

    def deffct(self, c: Nodes) -> d.Def:  # noqa: D102
        return d.Def(c[4].text, c[5] or (), c[2], c[3] is not None, c[0] is not None, c[4].column)

    def defdat(self, c: Nodes) -> d.DefDat:  # noqa: D102
        return d.DefDat(c[1].text, c[2] is not None, c[1].column)

    def parameters(self, c: Nodes) -> tuple[d.Parameter, ...]:  # noqa: D102
        return tuple(c)

    def parameter(self, c: Nodes) -> d.Parameter:  # noqa: D102
        return d.Parameter(c[0].text, c[2], c[1] or 0, c[0].column)

    def brackets(self, c: Nodes) -> int:  # noqa: D102
        return len(c) - 1

    def mode(self, c: Nodes) -> str:  # noqa: D102
        return str(c[0].text.upper())

    # --- declarations
    def typed(self, c: Nodes) -> d.Declaration:  # noqa: D102
        return _declaration(c[4], c[5:], c[0] or c[2], c[3], c[1])

    def untyped(self, c: Nodes) -> d.Declaration:  # noqa: D102
        return _declaration(None, c[4:], c[0] or c[2], c[3], c[1])

    def bare(self, c: Nodes) -> d.Declaration:  # noqa: D102
        return d.Declaration(c[2].text.upper(), tuple(c[3:]), False, c[0] is not None, c[1] is not None, c[2].column)

    def bare_named(self, c: Nodes) -> d.Declaration:  # noqa: D102
        return d.Declaration(c[2].text, tuple(c[3:]), False, c[0] is not None, c[1] is not None, c[2].column)

    def type(self, c: Nodes) -> str:  # noqa: D102
        return str(c[0].text.upper() if c[0].kind == "SIMPLE" else c[0].text)

    def declarator(self, c: Nodes) -> d.Declarator:  # noqa: D102
        return d.Declarator(c[0].text, c[1], c[2], c[0].column)

    def enum_(self, c: Nodes) -> d.EnumType:  # noqa: D102
        return d.EnumType(c[2].text, tuple(x.text for x in c[3:]), c[0] is not None, c[2].column)

    def struc(self, c: Nodes) -> d.StructType:  # noqa: D102
        members: list[tuple[str, tuple[d.Declarator, ...]]] = []
        for kind, declarator in c[3:]:
            if kind is None:
                members[-1] = (members[-1][0], (*members[-1][1], declarator))
            else:
                members.append((kind, (declarator,)))
        return d.StructType(c[2].text, tuple(members), c[0] is not None, c[2].column)

    def member(self, c: Nodes) -> tuple[str, d.Declarator]:  # noqa: D102
        return c[0], d.Declarator(c[1].text, c[2], None, c[1].column)

    def also(self, c: Nodes) -> tuple[None, d.Declarator]:  # noqa: D102
        return None, d.Declarator(c[0].text, c[1], None, c[0].column)

    def signal(self, c: Nodes) -> d.Signal:  # noqa: D102
        return d.Signal(c[2].text, c[3], c[5], c[0] is not None, c[2].column)

    def ext(self, c: Nodes) -> d.External:  # noqa: D102
        return d.External(c[1].text, None, c[2] or (), c[1].column)

    def extfct(self, c: Nodes) -> d.External:  # noqa: D102
        return d.External(c[2].text, c[1], c[3] or (), c[2].column)

    def ext_types(self, c: Nodes) -> tuple[str, ...]:  # noqa: D102
        return tuple(c)

    def ext_type(self, c: Nodes) -> str:  # noqa: D102
        brackets = "" if c[1] is None else f"[{',' * (c[1] - 1)}]"
        return str(c[0]) + brackets + ("" if c[2] is None else f":{c[2]}")

    # --- statements
    def assign(self, c: Nodes) -> s.Assign:  # noqa: D102
        return s.Assign(c[0], c[1], c[0].column)

    def invoke(self, c: Nodes) -> s.Invoke:  # noqa: D102
        return s.Invoke(c[0], c[0].column)

    def move(self, c: Nodes) -> s.Move:  # noqa: D102
        return s.Move(c[0].text.upper(), c[1], column=c[0].column, **_motion_options(c[2:]))

    def circ(self, c: Nodes) -> s.Move:  # noqa: D102
        # children: CIRC auxiliary end [CA angle] options...; CA is None where it is left out
        return s.Move(c[0].text.upper(), c[2], auxiliary=c[1], angle=c[4], column=c[0].column, **_motion_options(c[5:]))

    def with_(self, c: Nodes) -> tuple[s.Assign, ...]:  # noqa: D102
        return tuple(c[1:])

    def spline(self, c: Nodes) -> s.SplineBlock:  # noqa: D102
        return s.SplineBlock(c[0].text.upper(), c[1] or (), c[0].column)

    def endspline(self, c: Nodes) -> s.EndSpline:  # noqa: D102
        return s.EndSpline(tuple(x.text.upper() for x in c[1:]), c[0].column)

    def wait(self, c: Nodes) -> s.Wait:  # noqa: D102
        return s.Wait(c[1].text.upper(), c[2], c[0].column)

    def condition(self, c: Nodes) -> s.Condition:  # noqa: D102
        return s.Condition(c[0].text.upper(), c[1], c[0].column)

    def case(self, c: Nodes) -> s.Case:  # noqa: D102
        return s.Case(tuple(c[1:]), c[0].column)

    def for_(self, c: Nodes) -> s.For:  # noqa: D102
        return s.For(c[1], c[2], c[4], c[6], c[0].column)

    def jump(self, c: Nodes) -> s.Jump:  # noqa: D102
        return s.Jump(c[1].text, c[0].column)

    def label(self, c: Nodes) -> s.Label:  # noqa: D102
        return s.Label(c[0].text, c[0].column)

    def return_(self, c: Nodes) -> s.Return:  # noqa: D102
        return s.Return(c[1], c[0].column)

    def interrupt_declaration(self, c: Nodes) -> s.InterruptDeclaration:  # noqa: D102
        return s.InterruptDeclaration(c[3], c[5], c[7], c[0] is not None, c[1].column)

    def interrupt_switch(self, c: Nodes) -> s.InterruptSwitch:  # noqa: D102
        return s.InterruptSwitch(c[1].text.upper(), c[2], c[0].column)

    def trigger(self, c: Nodes) -> s.Trigger:  # noqa: D102
        # TRIGGER WHEN place value [ONSTART] DELAY delay DO action [PRIO priority]
        return s.Trigger(c[2].text.upper(), c[3], c[6], c[8], c[10], c[4] is not None, c[0].column)

    def analog(self, c: Nodes) -> s.Analog:  # noqa: D102
        return s.Analog(c[0].text.upper(), c[1].text.upper(), c[2], c[3], c[4] or (), c[0].column)

    def options(self, c: Nodes) -> tuple[s.Assign, ...]:  # noqa: D102
        return (s.Assign(e.Name(c[0].text.upper(), c[0].column), c[1], c[0].column), *(c[2] or ()))

    def plain(self, c: Nodes) -> s.Plain:  # noqa: D102
        return s.Plain(c[0].text.upper(), c[0].column)


def _declaration(kind: str | None, names: Nodes, is_global: Any, const: Any, first: Word) -> d.Declaration:
    return d.Declaration(kind, tuple(names), True, is_global is not None, const is not None, first.column)


def _motion_options(c: Nodes) -> dict[str, Any]:
    blends = tuple(x.text.upper() for x in c if isinstance(x, Word) and x.kind == "BLEND")
    frames = [x.text[1:] for x in c if isinstance(x, Word) and x.kind == "ENUMERATION"]
    settings = tuple(a for x in c if isinstance(x, tuple) for a in x)
    return {"blends": blends, "frame": frames[-1] if frames else None, "settings": settings}


def _integer(token: Word) -> e.Integer:
    return e.Integer(int(token.text), column=token.column)


def _bits(token: Word) -> e.Integer:
    digits, base = token.text[2:-1], 2 if token.text[1] in "Bb" else 16
    return e.Integer(int(digits, base), base, len(digits), token.column)


_LITERALS: dict[str, Callable[[Word], e.Literal]] = {
    "INTEGER": _integer,
    "BITS": _bits,
    "DECIMAL": lambda token: e.Real(float(token.text), token.column),
    "STRING": lambda token: e.Text(token.text[1:-1], token.column),
    "TRUTH": lambda token: e.Bool(token.text.upper() == "TRUE", token.column),
    "ENUMERATION": lambda token: e.EnumConstant(token.text[1:], token.column),
}
