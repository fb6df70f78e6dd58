"""Expressions of KRL as data. Two expressions are equal when they say the same; `column` (from 1) does not count."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class Integer:
    """A whole number; `base` is 10, 2 (`'B010'`) or 16 (`'H1F'`), `digits` how many of them are written."""

    value: int
    base: int = 10
    digits: int = 0
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Real:
    """A number with a decimal point or an exponent."""

    value: float
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Bool:
    """TRUE or FALSE."""

    value: bool
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Text:
    """One or several characters in double quotes."""

    value: str
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class EnumConstant:
    """`#NAME`, without the hash."""

    name: str
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Name:
    """A variable; system variables begin with $."""

    name: str
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Index:
    """`of[i, j]`; without indices (`of[]`) the whole array."""

    of: Reference
    indices: tuple[Expression, ...]
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Component:
    """`of.name`."""

    of: Reference
    name: str
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Call:
    """`name(arguments)`; an argument that is left out is None."""

    name: str
    arguments: tuple[Expression | None, ...] = ()
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Item:
    """One component of an aggregate: `X 10`, `POINT[] "P1"`, `J[2] 5`."""

    name: str
    value: Expression
    indices: tuple[Expression, ...] | None = None
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Aggregate:
    """`{type: X 1, Y 2}`; the type may be left out."""

    items: tuple[Item, ...]
    type: str | None = None
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Unary:
    """`+ - NOT B_NOT`."""

    operator: str
    operand: Expression
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Binary:
    """`: * / + - AND B_AND EXOR B_EXOR OR B_OR == <> < > <= >=`; the column is the operator's."""

    operator: str
    left: Expression
    right: Expression
    column: int = field(default=0, compare=False)


Reference: TypeAlias = "Name | Index | Component"
Literal: TypeAlias = "Integer | Real | Bool | Text | EnumConstant"
Expression: TypeAlias = "Literal | Reference | Call | Aggregate | Unary | Binary"

PRIORITY = {
    ":": 8, "*": 7, "/": 7, "+": 6, "-": 6, "AND": 5, "B_AND": 5, "EXOR": 4, "B_EXOR": 4, "OR": 3, "B_OR": 3,
    "==": 2, "<>": 2, "<": 2, ">": 2, "<=": 2, ">=": 2,
}  # fmt: skip
"""Operators of two operands: the larger binds first; comparisons bind last, as KUKA's table of priorities has it."""
