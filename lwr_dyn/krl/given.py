"""What the world sets before a program runs: inputs and variables with their values, as a user writes them."""

from __future__ import annotations

from collections.abc import Sequence

from lwr_dyn.errors import OptionError
from lwr_dyn.krl.evaluate import value_of
from lwr_dyn.krl.expressions import Call
from lwr_dyn.krl.lexer import LineError
from lwr_dyn.krl.line_parser import parse_line
from lwr_dyn.krl.statements import Assign
from lwr_dyn.krl.types import UNKNOWN, Type
from lwr_dyn.krl.values import HaltError, Slot, Value


def given_values(texts: Sequence[str]) -> dict[str, Value]:
    """`$IN[3]=TRUE` ... as values by name; raises `OptionError`.

    >>> given_values(["$IN[3]=TRUE", "n=2"])
    {'$IN[3]': True, 'N': 2}
    """
    return dict(_given(text) for text in texts)


def _given(text: str) -> tuple[str, Value]:
    name, _, _ = text.partition("=")
    try:
        statement, _ = parse_line(text)
        if not isinstance(statement, Assign):
            raise HaltError("", "")
        return name.replace(" ", "").upper(), value_of(_Nowhere(), statement.value)
    except (LineError, HaltError):
        raise OptionError("--set", repr(text), "NAME=VALUE with a constant, such as $IN[3]=TRUE") from None


class _Nowhere:
    """Where no name is known: only constants have a value."""

    def slot(self, name: str) -> Slot:
        raise HaltError("undeclared", name, "")

    def element(self, name: str, index: tuple[int, ...]) -> Value | None:
        raise HaltError("undeclared", name, "")

    def call(self, x: Call) -> Value:
        raise HaltError("undeclared", x.name, "")

    def component_type(self, struct: str, name: str) -> Type:
        return UNKNOWN
