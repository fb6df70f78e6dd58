"""The small part of C of the texts, parsed into a tree.

A name of a whole number known beforehand is put in as that number; so loops have ends, and arrays places, that are
known before anything runs.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.closed_forms import tree

_TOKEN = re.compile(
    r"\s*(?:(?P<number>\d+\.?\d*(?:e[+-]?\d+)?)|(?P<name>\w+)|(?P<sign>&&|\|\||[-+*/<>=!]=|\+\+|--|[-+*/%<>=!?:;,(){}\[\]]))"
)

_LEVELS = (("||",), ("&&",), ("==", "!="), ("<", ">", "<=", ">="), ("+", "-"), ("*", "/", "%"))


@dataclass(slots=True)
class _CReader:
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


def parsed(text: str, wholes: Mapping[str, int]) -> tree.CText:
    """The tree of a text, with those whole numbers put in; raises `OptionError` for what is not of this part of C."""
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    tokens, at = [], 0
    while text[at:].strip():
        match = _TOKEN.match(text, at)
        if match is None:
            raise OptionError("a text", text[at : at + 20], "numbers, names and signs of C")
        tokens.append(match[0].strip())
        at = match.end()
    reader, functions = _CReader([*tokens, ""], wholes), []
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
    return tree.CText(tuple(functions), reader.constants)


def _function(reader: _CReader) -> tree.CFunction:
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
    return tree.CFunction(name, kind, tuple(arguments), _block(reader))


def _block(reader: _CReader) -> tuple[tree.CStatement, ...]:
    reader.take("{")
    statements: list[tree.CStatement] = []
    while not reader.passes("}"):
        statements.append(_statement(reader))
    return tuple(statements)


def _statement(reader: _CReader) -> tree.CStatement:
    if reader.passes("for"):
        return _for(reader)
    if reader.passes("while"):
        return tree.CWhile(_in_brackets(reader), _block(reader))
    if reader.passes("if"):
        return _if(reader)
    if reader.passes("return"):
        value = None if reader.next == ";" else _expression(reader)
        reader.take(";")
        return tree.CReturn(value)
    return _simple(reader)


def _in_brackets(reader: _CReader) -> tree.CExpression:
    reader.take("(")
    inner = _expression(reader)
    reader.take(")")
    return inner


def _for(reader: _CReader) -> tree.CFor:
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
    step = 1
    if reader.take("++", "+=") == "+=":
        token = reader.take()
        step = int(reader.wholes.get(token, token))
    reader.take(")")
    return tree.CFor(name, first, end, step, _block(reader))


def _if(reader: _CReader) -> tree.CIf:
    test, yes = _in_brackets(reader), _block(reader)
    if reader.passes("else", "if"):
        return tree.CIf(test, yes, (_if(reader),))
    return tree.CIf(test, yes, _block(reader) if reader.passes("else") else ())


def _simple(reader: _CReader) -> tree.CStatement:
    """A declaration, an assignment or a call."""
    reader.passes("const")
    declared = reader.take() if reader.next in ("double", "int") else ""
    target = _primary(reader)
    if declared and isinstance(target, tree.CItem):
        assert isinstance(target.place, tree.CNumber)
        reader.take(";")
        return tree.CRoom(target.array, int(target.place.value))
    if isinstance(target, tree.CCall):
        reader.take(";")
        return tree.CDo(target)
    assert isinstance(target, tree.CName | tree.CItem)
    sign = reader.take("=", "+=", "-=", "*=", "++", "--")
    value: tree.CExpression = tree.CNumber(1) if sign in ("++", "--") else _expression(reader)
    reader.take(";")
    return tree.CSet(declared, target, value if sign == "=" else tree.CBinary(sign[0], target, value))


def _expression(reader: _CReader) -> tree.CExpression:
    test = _binary(reader, 0)
    if not reader.passes("?"):
        return test
    yes = _expression(reader)
    reader.take(":")
    return tree.CChoice(test, yes, _expression(reader))


def _binary(reader: _CReader, level: int) -> tree.CExpression:
    """From the left to the right, signs of a higher level first."""
    if level == len(_LEVELS):
        return _unary(reader)
    left = _binary(reader, level + 1)
    while reader.next in _LEVELS[level]:
        left = tree.CBinary(reader.take(), left, _binary(reader, level + 1))
    return left


def _unary(reader: _CReader) -> tree.CExpression:
    if reader.next in ("-", "!"):
        return tree.CUnary(reader.take(), _unary(reader))
    return _primary(reader)


def _primary(reader: _CReader) -> tree.CExpression:
    if reader.passes("("):
        if reader.passes("double", ")"):
            return _primary(reader)
        if reader.passes("int", ")"):
            return tree.CCall("int", (_primary(reader),))
        inner = _expression(reader)
        reader.take(")")
        return inner
    token = reader.take()
    if token[0].isdigit():
        return tree.CNumber(int(token) if token.isdigit() else float(token))
    if reader.passes("["):
        place = _expression(reader)
        reader.take("]")
        return tree.CItem(token, place)
    if reader.passes("("):
        arguments = []
        while not reader.passes(")"):
            arguments.append(_expression(reader))
            reader.passes(",")
        return tree.CCall(token, tuple(arguments))
    return tree.CNumber(reader.wholes[token]) if token in reader.wholes else tree.CName(token)
