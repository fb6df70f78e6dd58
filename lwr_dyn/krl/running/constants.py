"""Constants written in KRL's own form, from the command line and from cell files: `3`, `TRUE`, `#EX`, `{X 1, Y 2}`."""

from __future__ import annotations

import re
from collections.abc import Sequence

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.lexer import LineError
from lwr_dyn.krl.language.line_parser import parse_line
from lwr_dyn.krl.language.statements import Assign
from lwr_dyn.krl.names.predefined import SYSTEM
from lwr_dyn.krl.names.types import SIMPLE, UNKNOWN, Type
from lwr_dyn.krl.running.evaluate import value_of
from lwr_dyn.krl.running.values import Value, Variable, VariableReference, converted

PLACE = re.compile(r"\$?[A-Z_][A-Z0-9_$]*(\[\d{1,6}(,\d{1,6})*\])?(\.[A-Z_][A-Z0-9_]*)*")
"""What can be given from outside, in capitals."""


def constant_value(text: str) -> Value:
    """The value of a constant; raises `ExecutionError` where the text is none.

    >>> constant_value("{X 1.5}").parts["X"]
    1.5
    """
    return _assigned(f"X={text}")[1]


def input_values(texts: Sequence[str]) -> dict[str, Value]:
    """Inputs and variables set from outside, written as `$IN[3]=TRUE`: name -> value; raises `OptionError`.

    >>> input_values(["$IN[3]=TRUE", "n=2"])
    {'$IN[3]': True, 'N': 2}
    """
    values = {}
    for text in texts:
        try:
            name, value = _assigned(text)
        except ExecutionError:
            raise OptionError("--set", repr(text), "NAME=VALUE with a constant, such as $IN[3]=TRUE") from None
        try:
            refuse_place(name, value)
        except ExecutionError as fault:
            raise OptionError("--set", repr(text), fault.hint or fault.message) from None
        values[name] = value
    return values


def refuse_place(name: str, value: Value) -> None:
    """Raises `ExecutionError` where nothing is called so, or where an input or state is of another type.

    >>> refuse_place("$IN[0]", True)
    Traceback (most recent call last):
    ...
    lwr_dyn.krl.diagnostics.ExecutionError: $IN[0]
    """
    if not PLACE.fullmatch(name) or not _can_be_set(name):
        raise ExecutionError("name", name, "a name such as $IN[3], $T1, $ERR.NUMBER, PART, P[3]")
    root, indices, parts = re.match(r"([^\[.]*)(\[.*\])?(.*)", name).groups()  # type: ignore[union-attr]
    kind = SYSTEM.get(root, UNKNOWN)
    numbers = () if indices is None else tuple(map(int, indices[1:-1].split(",")))
    if kind.name == "?" or (kind.dimensions and kind.name not in SIMPLE):
        return
    if len(numbers) != kind.dimensions or not all(1 <= n <= m for n, m in zip(numbers, kind.sizes, strict=False)):
        most = f"{root}[1] to {root}[{kind.sizes[0]}]" if kind.sizes else f"{root} with its indices, from 1"
        raise ExecutionError("index-range", name, most if kind.dimensions else f"{root} without an index")
    if not parts:
        converted(value, kind.element)


def _can_be_set(name: str) -> bool:
    try:
        return isinstance(parse_line(f"{name}=0")[0], Assign)
    except LineError:
        return False


def _assigned(text: str) -> tuple[str, Value]:
    name, _, _ = text.partition("=")
    try:
        statement, _ = parse_line(text)
    except LineError as fault:
        raise ExecutionError("syntax", str(fault)) from None
    if not isinstance(statement, Assign):
        raise ExecutionError("syntax", text)
    return name.replace(" ", "").upper(), value_of(_NoNames(), statement.value)


class _NoNames:
    """An environment without names: only constants have a value."""

    def variable(self, name: str) -> Variable:
        raise ExecutionError("undeclared", name)

    def element(self, name: str, index: tuple[int, ...]) -> Value | None:
        raise ExecutionError("undeclared", name)

    def call(self, x: e.FunctionCall) -> Value:
        raise ExecutionError("undeclared", x.name)

    def signal_reference(self, name: str) -> VariableReference | None:
        return None

    def note_read(self, name: str) -> None:
        raise ExecutionError("undeclared", name)

    def component_type(self, struct: str, name: str) -> Type:
        return UNKNOWN
