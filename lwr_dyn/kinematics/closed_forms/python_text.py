"""The texts as Python: plain functions on lists of floats, short loops written out, for where nothing is compiled.

Sums and products keep their order, and x // 1.0 is the floor of C, so each result has the bits that C gives.
"""

import keyword
import re
from collections.abc import Iterable, Mapping

from lwr_dyn.kinematics.closed_forms.inlining import inlined
from lwr_dyn.kinematics.closed_forms.text_parser import (
    CBinary,
    CCall,
    CChoice,
    CDo,
    CExpression,
    CFor,
    CFunction,
    CIf,
    CItem,
    CName,
    CNumber,
    CReturn,
    CRoom,
    CSet,
    CStatement,
    CText,
    CUnary,
    CWhile,
)

MOST_WRITTEN_OUT = 240
"""Statements that a loop may become; a longer one stays a loop."""

MOST_MERGED = 1000
"""Characters of a line."""

_SIGNS = {"&&": "and", "||": "or"}

_IMPORTS = "from math import copysign, nan as NAN, sqrt"

Wholes = Mapping[str, int | float]
"""The loops' variables that are written out, and numbers known beforehand -> number."""


class _Known(CNumber):
    """A number of an array, known beforehand."""


def python_text(text: CText, known: Mapping[str, int | float] | None = None) -> str:
    """The functions; constants are names from outside, an array's number behind a known place is NAME_PLACE.

    Those that are `known` are put in. Products with a known 0 or 1 are left out, and sums with a known 0: the sign of a
    zero may differ then, and what is not finite.
    """
    numbers, lines = {**text.constants, **(known or {})}, [_IMPORTS]
    for function in inlined(text).functions:
        names = ", ".join(_name(name) for _, name in function.arguments)
        lines += ["", "", f"def {function.name}({names}):", *_PythonWriter(function).block(function.body, numbers)]
    return "\n".join(lines) + "\n"


def _name(name: str) -> str:
    return f"{name}_" if keyword.iskeyword(name) else name


def _size(statements: Iterable[CStatement]) -> int:
    """Statements inside, loops counted once."""
    total = 0
    for x in statements:
        inner = x.body if isinstance(x, CFor | CWhile) else (*x.yes, *x.no) if isinstance(x, CIf) else ()
        total += 1 + _size(inner)
    return total


_SET = re.compile(r"(\w+) = (.*)")


def _merged(lines: Iterable[str]) -> list[str]:
    """A variable that is set twice in succession, and read once in between, is set once."""
    out: list[str] = []
    for line in lines:
        before, now = _SET.fullmatch(out[-1]) if out else None, _SET.fullmatch(line)
        if before and now and before[1] == now[1] and len(line) + len(out[-1]) < MOST_MERGED:
            used = re.findall(rf"\b{now[1]}\b", now[2])
            if len(used) == 1:
                out[-1] = f"{now[1]} = " + re.sub(rf"\b{now[1]}\b", lambda _, x=before[2]: f"({x})", now[2])
                continue
        out.append(line)
    return out


class _PythonWriter:
    """Of one function."""

    def __init__(self, function: CFunction) -> None:
        self.local = {name for _, name in function.arguments}
        self._find(function.body)

    def _find(self, statements: Iterable[CStatement]) -> None:
        """Local arrays."""
        for x in statements:
            if isinstance(x, CRoom):
                self.local.add(x.name)

    def block(self, statements: Iterable[CStatement], known: Wholes) -> list[str]:
        """Its lines, one step in."""
        lines = [line for x in statements for line in self._statement(x, known)]
        return ["    " + line for line in _merged(lines)] or ["    pass"]

    def _statement(self, x: CStatement, known: Wholes) -> list[str]:
        match x:
            case CRoom(name, size):
                return [f"{_name(name)} = [0.0] * {size}"]
            case CSet(_, target, value):
                return [f"{self.expression(target, known)} = {self._bare(value, known)}"]
            case CDo(call):
                return [self.expression(call, known)]
            case CReturn(value):
                return ["return" if value is None else f"return {self._bare(value, known)}"]
            case CFor():
                return self._for(x, known)
            case CWhile(test, body):
                return [f"while {self._bare(test, known)}:", *self.block(body, known)]
            case CIf():
                return self._if(x, known)

    def _if(self, x: CIf, known: Wholes) -> list[str]:
        test = folded(x.test, known)
        if isinstance(test, CNumber):
            return [line for y in (x.yes if test.value else x.no) for line in self._statement(y, known)]
        lines = [f"if {self._bare(test, known)}:", *self.block(x.yes, known)]
        return [*lines, "else:", *self.block(x.no, known)] if x.no else lines

    def _for(self, x: CFor, known: Wholes) -> list[str]:
        first, end = folded(x.first, known), folded(x.end, known)
        if isinstance(first, CNumber) and isinstance(end, CNumber):
            turns = range(int(first.value), int(end.value), x.step)
            lines = [line for i in turns[:1] for line in self._written_out(x, i, known)]
            if len(lines) * len(turns) <= MOST_WRITTEN_OUT:
                return lines + [line for i in turns[1:] for line in self._written_out(x, i, known)]
        bounds = ", ".join(self._bare(y, known) for y in (first, end, CNumber(x.step)))
        return [f"for {_name(x.name)} in range({bounds}):", *self.block(x.body, known)]

    def _written_out(self, x: CFor, i: int, known: Wholes) -> list[str]:
        return [line for y in x.body for line in self._statement(y, {**known, x.name: i})]

    def _bare(self, x: CExpression, known: Wholes) -> str:
        """Without brackets around the whole."""
        text = self.expression(x, known)
        return text[1:-1] if isinstance(folded(x, known), CBinary | CChoice) else text

    def expression(self, x: CExpression, known: Wholes) -> str:
        """As Python."""
        x = folded(x, known)
        match x:
            case CNumber(value):
                return repr(value)
            case CName(name):
                return _name(name)
            case CItem():
                return self._item(x, known)
            case CCall(function, arguments):
                return self._call(function, [self._bare(y, known) for y in arguments])
            case CUnary(sign, of):
                return f"{'not ' if sign == '!' else sign}{self.expression(of, known)}"
            case CBinary(sign, left, right):
                return f"({self.expression(left, known)} {_SIGNS.get(sign, sign)} {self.expression(right, known)})"
            case CChoice(test, yes, no):
                parts = (self.expression(y, known) for y in (yes, test, no))
                return "({} if {} else {})".format(*parts)

    def _item(self, x: CItem, known: Wholes) -> str:
        if isinstance(x.place, CNumber) and x.array not in self.local:
            return f"{x.array}_{x.place.value}"
        return f"{_name(x.array)}[{self._bare(x.place, known)}]"

    def _call(self, function: str, arguments: list[str]) -> str:
        if function == "floor":
            return f"(({arguments[0]}) // 1.0)"
        return f"{'abs' if function == 'fabs' else function}({', '.join(arguments)})"


def folded(x: CExpression, known: Wholes) -> CExpression:
    """With what follows from whole numbers put in; arithmetic of doubles is left as it is."""
    match x:
        case CName(name) if name in known:
            return CNumber(known[name])
        case CItem(array, place):
            place = folded(place, known)
            name = f"{array}_{place.value}" if isinstance(place, CNumber) else ""
            return _Known(known[name]) if name in known else CItem(array, place)
        case CBinary(sign, left, right):
            left, right = folded(left, known), folded(right, known)
            if _is_whole(left) and _is_whole(right):
                return _worked_out(sign, int(left.value), int(right.value))  # type: ignore[union-attr]
            return _with_known(sign, left, right)
        case CChoice(test, yes, no):
            test = folded(test, known)
            if isinstance(test, CNumber):
                return folded(yes if test.value else no, known)
            return CChoice(test, folded(yes, known), folded(no, known))
    return x


def _with_known(sign: str, left: CExpression, right: CExpression) -> CExpression:
    """Without what a known 0, 1 or -1 leaves out."""
    if sign == ">" and isinstance(left, _Known) and isinstance(right, CNumber):
        return CNumber(int(left.value > right.value))
    for one, other in ((left, right), (right, left)):
        value = one.value if isinstance(one, _Known) else None
        if sign == "*" and value in (0.0, 1.0, -1.0):
            return _Known(0.0) if value == 0.0 else other if value == 1.0 else CUnary("-", other)
        if sign == "+" and value == 0.0:
            return other
    if sign == "+" and isinstance(right, CUnary) and right.sign == "-":
        return CBinary("-", left, right.of)
    return CBinary(sign, left, right)


def _is_whole(x: CExpression) -> bool:
    return isinstance(x, CNumber) and isinstance(x.value, int)


def _worked_out(sign: str, a: int, b: int) -> CExpression:
    values = {
        "+": a + b, "-": a - b, "*": a * b, "<": a < b, ">": a > b, "<=": a <= b, ">=": a >= b, "==": a == b,
        "!=": a != b,
    }  # fmt: skip
    if sign == "%" and b > 0:
        return CNumber(a % b)
    return CNumber(int(values[sign])) if sign in values else CBinary(sign, CNumber(a), CNumber(b))
