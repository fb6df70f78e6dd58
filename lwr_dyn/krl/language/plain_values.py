"""The plain value of a constant expression, without a running program: `-3`, `TRUE`, `#EX`, `"text"`, `{X 1, Y 2}`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.declarations import Declaration
from lwr_dyn.krl.language.statements import Assign


def plain_value(x: e.Expression | None) -> Any:
    """A number, text, truth value, the name of an enumeration's constant, a dict of components; None for another.

    >>> plain_value(e.Aggregate((e.Item("X", e.Unary("-", e.Real(1.5))),)))
    {'X': -1.5}
    """
    if isinstance(x, e.Unary) and x.operator in ("-", "+"):
        value = plain_value(x.operand)
        return (-value if x.operator == "-" else value) if isinstance(value, int | float) else None
    if isinstance(x, e.Aggregate):
        return {item.name.upper(): plain_value(item.value) for item in x.items}
    if isinstance(x, e.EnumLiteral):
        return x.name.upper()
    return x.value if isinstance(x, e.Integer | e.Real | e.Bool | e.Text) else None


def given_values(x: object) -> Iterator[tuple[str, int | None, Any]]:
    """Name in capitals, index (None for the whole) and plain value of what a line of a `.dat` gives."""
    if isinstance(x, Declaration):
        yield from ((d.name.upper(), None, plain_value(d.value)) for d in x.names if d.value is not None)
    if not isinstance(x, Assign):
        return
    target, index = x.target, None
    if isinstance(target, e.Index):
        only = target.indices[0] if len(target.indices) == 1 else None
        index, target = (only.value if isinstance(only, e.Integer) else None), target.of
        if index is None and not isinstance(x.value, e.Text):
            return
    if isinstance(target, e.Name):
        yield target.name.upper(), index, plain_value(x.value)
