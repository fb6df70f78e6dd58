"""Expressions of KRL as records; the parser builds them with `RULES`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from lwr_dyn.krl.language.lexer import LineError, Token

Nodes = list[Any]
"""The parts of a rule of `grammar.lark` in order: tokens and records; None for an optional part that is left out."""
Rules: TypeAlias = dict[str, Callable[[Nodes], Any]]
"""Rule of `grammar.lark` -> the function that builds its record."""


@dataclass(frozen=True, slots=True)
class Placed:
    """What stands at a column (from 1); 0 where it was not read. It is left out of equality."""

    column: int = field(default=0, compare=False, repr=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Integer(Placed):
    """A whole number; `base` is 10, 2 (`'B010'`) or 16 (`'H1F'`), `digits` the number of digits written."""

    value: int
    base: int = 10
    digits: int = 0


@dataclass(frozen=True, slots=True)
class Real(Placed):
    """A number with a decimal point or an exponent."""

    value: float


@dataclass(frozen=True, slots=True)
class Bool(Placed):
    """TRUE or FALSE."""

    value: bool


@dataclass(frozen=True, slots=True)
class Text(Placed):
    """One or several characters in double quotes."""

    value: str


@dataclass(frozen=True, slots=True)
class EnumLiteral(Placed):
    """`#NAME`, without the hash."""

    name: str


@dataclass(frozen=True, slots=True)
class Name(Placed):
    """A variable; system variables begin with $."""

    name: str


@dataclass(frozen=True, slots=True)
class Index(Placed):
    """`of[i, j]`; without indices (`of[]`) the whole array; with `row` (`of[i,]`) a whole row of it."""

    of: Reference
    indices: tuple[Expression, ...]
    row: bool = False


@dataclass(frozen=True, slots=True)
class Component(Placed):
    """`of.name`."""

    of: Reference
    name: str


@dataclass(frozen=True, slots=True)
class FunctionCall(Placed):
    """`name(arguments)`; None for an argument that is left out."""

    name: str
    arguments: tuple[Expression | None, ...] = ()


@dataclass(frozen=True, slots=True)
class ChannelName(Placed):
    """`:name`, a serial line as the argument of COPEN."""

    name: str


@dataclass(frozen=True, slots=True)
class Item(Placed):
    """One component of an aggregate: `X 10`, `POINT[] "P1"`, `J[2] 5`."""

    name: str
    value: Expression
    indices: tuple[Expression, ...] | None = None


@dataclass(frozen=True, slots=True)
class Aggregate(Placed):
    """`{type: X 1, Y 2}`; the type may be left out."""

    items: tuple[Item, ...]
    type: str | None = None


@dataclass(frozen=True, slots=True)
class Unary(Placed):
    """`+ - NOT B_NOT`."""

    operator: str
    operand: Expression


@dataclass(frozen=True, slots=True)
class Binary(Placed):
    """`: * / + - AND B_AND EXOR B_EXOR OR B_OR == <> < > <= >=`; the column is the operator's."""

    operator: str
    left: Expression
    right: Expression


Reference: TypeAlias = "Name | Index | Component"
Literal: TypeAlias = "Integer | Real | Bool | Text | EnumLiteral"
Expression: TypeAlias = "Literal | Reference | FunctionCall | ChannelName | Aggregate | Unary | Binary"

PRIORITY = {
    ":": 8, "*": 7, "/": 7, "+": 6, "-": 6, "AND": 5, "B_AND": 5, "EXOR": 4, "B_EXOR": 4, "OR": 3, "B_OR": 3,
    "==": 2, "<>": 2, "<": 2, ">": 2, "<=": 2, ">=": 2,
}  # fmt: skip
"""Operators of two operands: the larger binds first; comparisons bind last, as KUKA's table of priorities has it."""


def root_name(x: Reference) -> str:
    """The name with which a reference begins, in capitals."""
    while not isinstance(x, Name):
        x = x.of
    return x.name.upper()


def number_of(x: Expression | None) -> int | float | None:
    """The value of a number with its sign; None for anything else.

    >>> number_of(Unary("-", Integer(3)))
    -3
    """
    if isinstance(x, Unary) and x.operator in ("+", "-"):
        value = number_of(x.operand)
        return -value if value is not None and x.operator == "-" else value
    return x.value if isinstance(x, Integer | Real) else None


def _optional_list(c: Nodes) -> tuple[Any, ...]:
    return () if c == [None] else tuple(c)


MOST_DIGITS = 40
"""Of an integer: far above any of KUKA's, far below what a float holds."""


def _integer(token: Token, digits: str, base: int, width: int = 0) -> Integer:
    if len(digits) > MOST_DIGITS:
        raise LineError(
            token.column, "number-range", f"{len(digits)} digits are no INT", f"at most {MOST_DIGITS} digits"
        )
    return Integer(int(digits, base), base, width, column=token.column)


def _bits(token: Token) -> Integer:
    digits, base = token.text[2:-1], 2 if token.text[1] in "Bb" else 16
    return _integer(token, digits, base, len(digits))


_LITERALS: dict[str, Callable[[Token], Literal]] = {
    "INTEGER": lambda token: _integer(token, token.text, 10),
    "BITS": _bits,
    "DECIMAL": lambda token: Real(float(token.text), column=token.column),
    "STRING": lambda token: Text(token.text[1:-1], column=token.column),
    "TRUTH": lambda token: Bool(token.text.upper() == "TRUE", column=token.column),
    "ENUMERATION": lambda token: EnumLiteral(token.text[1:].lstrip(), column=token.column),
}
RULES: Rules = {
    "name": lambda c: c[0],
    "variable": lambda c: Name(c[0].text, column=c[0].column),
    "literal": lambda c: _LITERALS[c[0].kind](c[0]),
    "index": lambda c: Index(c[0], c[1], column=c[0].column),
    "row_of": lambda c: Index(c[0], c[1], True, column=c[0].column),
    "row": tuple,
    "indices": _optional_list,
    "no_indices": lambda c: (),
    "component": lambda c: Component(c[0], c[1].text, column=c[1].column),
    "call": lambda c: FunctionCall(c[0].text, c[1], column=c[0].column),
    "arguments": _optional_list,
    "channel_name": lambda c: ChannelName(c[0].text, column=c[0].column),
    "aggregate": lambda c: Aggregate(tuple(c[2:]), None if c[1] is None else c[1].text, column=c[0].column),
    "item": lambda c: Item(c[0].text, c[2], c[1], column=c[0].column),
    "sizes": _optional_list,
    "binary": lambda c: Binary(c[1].text.upper(), c[0], c[2], column=c[1].column),
    "composed": lambda c: Binary(":", c[0], c[1], column=c[1].column),
    "negated": lambda c: Unary(c[0].text.upper(), c[1], column=c[0].column),
}
