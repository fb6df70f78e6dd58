"""The small part of C of the texts, parsed into a tree: functions, statements, expressions, each with its place.

A name of a whole number known beforehand is put in as that number; so loops have ends, and arrays places, that are
known before anything runs.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from lwr_dyn.foundation.errors import OptionError


@dataclass(frozen=True, slots=True)
class Number:
    """A whole number or a double."""

    value: int | float


@dataclass(frozen=True, slots=True)
class Name:
    """A variable, an argument or a constant."""

    name: str


@dataclass(frozen=True, slots=True)
class Item:
    """One number of an array."""

    array: str
    place: "Expression"


@dataclass(frozen=True, slots=True)
class Call:
    """A call of a function."""

    function: str
    arguments: tuple["Expression", ...]


@dataclass(frozen=True, slots=True)
class Unary:
    """- or !"""

    sign: str
    of: "Expression"


@dataclass(frozen=True, slots=True)
class Binary:
    """Arithmetic, comparison, && or ||."""

    sign: str
    left: "Expression"
    right: "Expression"


@dataclass(frozen=True, slots=True)
class Choice:
    """test ? yes : no."""

    test: "Expression"
    yes: "Expression"
    no: "Expression"


Expression = Number | Name | Item | Call | Unary | Binary | Choice


@dataclass(frozen=True, slots=True)
class Room:
    """A local array, its numbers not set."""

    name: str
    size: int


@dataclass(frozen=True, slots=True)
class Set:
    """target = value; `declared` is "double" or "int" where the variable begins here."""

    declared: str
    target: Name | Item
    value: Expression


@dataclass(frozen=True, slots=True)
class For:
    """`name` from `first` up to `end` (excluded) by `step`."""

    name: str
    first: Expression
    end: Expression
    step: int
    body: tuple["Statement", ...]


@dataclass(frozen=True, slots=True)
class While:
    """A loop."""

    test: Expression
    body: tuple["Statement", ...]


@dataclass(frozen=True, slots=True)
class If:
    """A branch."""

    test: Expression
    yes: tuple["Statement", ...]
    no: tuple["Statement", ...]


@dataclass(frozen=True, slots=True)
class Return:
    """The end of a function."""

    value: Expression | None


@dataclass(frozen=True, slots=True)
class Do:
    """A call whose result, if any, does not count."""

    call: Call


Statement = Room | Set | For | While | If | Return | Do


@dataclass(frozen=True, slots=True)
class Function:
    """A function; its kind and those of its arguments are "double", "int", "void", "double*"."""

    name: str
    kind: str
    arguments: tuple[tuple[str, str], ...]
    """(kind, name)."""
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Text:
    """A whole text."""

    functions: tuple[Function, ...]
    constants: Mapping[str, float]
    """Those that the text itself defines."""


_TOKEN = re.compile(
    r"\s*(?:(?P<number>\d+\.?\d*(?:e[+-]?\d+)?)|(?P<name>\w+)|(?P<sign>&&|\|\||[-+*/<>=!]=|\+\+|--|[-+*/%<>=!?:;,(){}\[\]]))"
)

_LEVELS = (("||",), ("&&",), ("==", "!="), ("<", ">", "<=", ">="), ("+", "-"), ("*", "/", "%"))


@dataclass(slots=True)
class _Reader:
    """What is left of a text."""

    tokens: Sequence[str]
    wholes: Mapping[str, int]
    at: int = 0
    constants: dict[str, float] = field(default_factory=dict)

    @property
    def next(self) -> str:
        return self.tokens[self.at]

    def take(self, *wanted: str) -> str:
        """The next token; raises `OptionError` unless it is one of those wanted, if any are."""
        token = self.next
        if wanted and token not in wanted:
            raise OptionError("a text", " ".join(self.tokens[max(self.at - 8, 0) : self.at + 1]), " or ".join(wanted))
        self.at += 1
        return token

    def passes(self, *wanted: str) -> bool:
        """Whether the next tokens are these; if so they are taken."""
        if tuple(self.tokens[self.at : self.at + len(wanted)]) != wanted:
            return False
        self.at += len(wanted)
        return True


def parsed(text: str, wholes: Mapping[str, int]) -> Text:
    """The tree of a text, with those whole numbers put in; raises `OptionError` for what is not of this part of C."""
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    tokens, at = [], 0
    while text[at:].strip():
        match = _TOKEN.match(text, at)
        if match is None:
            raise OptionError("a text", text[at : at + 20], "numbers, names and signs of C")
        tokens.append(match[0].strip())
        at = match.end()
    reader, functions = _Reader([*tokens, ""], wholes), []
    while reader.next:
        reader.passes("static")
        if reader.passes("const"):
            reader.take("double")
            name = reader.take()
            reader.take("=")
            reader.constants[name] = float(reader.take())
            reader.take(";")
        else:
            functions.append(_function(reader))
    return Text(tuple(functions), reader.constants)


def _function(reader: _Reader) -> Function:
    kind, name, arguments = reader.take("double", "int", "void"), reader.take(), []
    reader.take("(")
    while not reader.passes(")"):
        reader.passes("const")
        argument = reader.take("double", "int") + ("*" if reader.passes("*") else "")
        arguments.append((argument, reader.take()))
        if reader.passes("["):
            reader.take()
            reader.take("]")
            arguments[-1] = (argument + "*", arguments[-1][1])
        reader.passes(",")
    return Function(name, kind, tuple(arguments), _block(reader))


def _block(reader: _Reader) -> tuple[Statement, ...]:
    reader.take("{")
    statements: list[Statement] = []
    while not reader.passes("}"):
        statements.append(_statement(reader))
    return tuple(statements)


def _statement(reader: _Reader) -> Statement:
    if reader.passes("for"):
        return _for(reader)
    if reader.passes("while"):
        return While(_in_brackets(reader), _block(reader))
    if reader.passes("if"):
        return _if(reader)
    if reader.passes("return"):
        value = None if reader.next == ";" else _expression(reader)
        reader.take(";")
        return Return(value)
    return _simple(reader)


def _in_brackets(reader: _Reader) -> Expression:
    reader.take("(")
    inner = _expression(reader)
    reader.take(")")
    return inner


def _for(reader: _Reader) -> For:
    for token in ("(", "int"):
        reader.take(token)
    name = reader.take()
    reader.take("=")
    first = _expression(reader)
    for token in (";", name, "<"):
        reader.take(token)
    end = _expression(reader)
    reader.take(";")
    reader.take(name)
    step = 1 if reader.take("++", "+=") == "++" else int(reader.take())
    reader.take(")")
    return For(name, first, end, step, _block(reader))


def _if(reader: _Reader) -> If:
    test, yes = _in_brackets(reader), _block(reader)
    if reader.passes("else", "if"):
        return If(test, yes, (_if(reader),))
    return If(test, yes, _block(reader) if reader.passes("else") else ())


def _simple(reader: _Reader) -> Statement:
    """A declaration, an assignment or a call."""
    reader.passes("const")
    declared = reader.take() if reader.next in ("double", "int") else ""
    target = _primary(reader)
    if declared and isinstance(target, Item):
        assert isinstance(target.place, Number)
        reader.take(";")
        return Room(target.array, int(target.place.value))
    if isinstance(target, Call):
        reader.take(";")
        return Do(target)
    assert isinstance(target, Name | Item)
    sign = reader.take("=", "+=", "-=", "*=", "++", "--")
    value: Expression = Number(1) if sign in ("++", "--") else _expression(reader)
    reader.take(";")
    return Set(declared, target, value if sign == "=" else Binary(sign[0], target, value))


def _expression(reader: _Reader) -> Expression:
    test = _binary(reader, 0)
    if not reader.passes("?"):
        return test
    yes = _expression(reader)
    reader.take(":")
    return Choice(test, yes, _expression(reader))


def _binary(reader: _Reader, level: int) -> Expression:
    """From the left to the right, signs of a higher level first."""
    if level == len(_LEVELS):
        return _unary(reader)
    left = _binary(reader, level + 1)
    while reader.next in _LEVELS[level]:
        left = Binary(reader.take(), left, _binary(reader, level + 1))
    return left


def _unary(reader: _Reader) -> Expression:
    if reader.next in ("-", "!"):
        return Unary(reader.take(), _unary(reader))
    return _primary(reader)


def _primary(reader: _Reader) -> Expression:
    if reader.passes("("):
        if reader.passes("double", ")"):
            return _primary(reader)
        inner = _expression(reader)
        reader.take(")")
        return inner
    token = reader.take()
    if token[0].isdigit():
        return Number(int(token) if token.isdigit() else float(token))
    if reader.passes("["):
        place = _expression(reader)
        reader.take("]")
        return Item(token, place)
    if reader.passes("("):
        arguments = []
        while not reader.passes(")"):
            arguments.append(_expression(reader))
            reader.passes(",")
        return Call(token, tuple(arguments))
    return Number(reader.wholes[token]) if token in reader.wholes else Name(token)
