"""The texts as Python: plain functions on lists of floats, short loops written out, for where nothing is compiled.

Sums and products keep their order, and x // 1.0 is the floor of C, so each result has the bits that C gives.
"""

import keyword
import re
from collections.abc import Iterable, Mapping

from lwr_dyn.kinematics.closed_forms import tree
from lwr_dyn.kinematics.closed_forms.inlining import inlined

MOST_WRITTEN_OUT = 240
"""Statements that a loop may become; a longer one stays a loop."""

MOST_MERGED = 1000
"""Characters of a line."""

_SIGNS = {"&&": "and", "||": "or"}

_IMPORTS = "from math import copysign, nan as NAN, sqrt"

Wholes = Mapping[str, int | float]
"""The loops' variables that are written out, and numbers known beforehand -> number."""


class _Known(tree.CNumber):
    """A number of an array, known beforehand."""


def python_text(text: tree.CText, known: Mapping[str, int | float] | None = None) -> str:
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

    def __init__(self, function: tree.CFunction) -> None:
        self.local = {name for _, name in function.arguments}
        self._find(function.body)

    def _find(self, statements: Iterable[tree.CStatement]) -> None:
        """Local arrays."""
        for x in statements:
            if isinstance(x, tree.CRoom):
                self.local.add(x.name)

    def block(self, statements: Iterable[tree.CStatement], known: Wholes) -> list[str]:
        """Its lines, one step in."""
        lines = [line for x in statements for line in self._statement(x, known)]
        return ["    " + line for line in _merged(lines)] or ["    pass"]

    def _statement(self, x: tree.CStatement, known: Wholes) -> list[str]:
        match x:
            case tree.CRoom(name, size):
                return [f"{_name(name)} = [0.0] * {size}"]
            case tree.CSet(_, target, value):
                return [f"{self.expression(target, known)} = {self._bare(value, known)}"]
            case tree.CDo(call):
                return [self.expression(call, known)]
            case tree.CReturn(value):
                return ["return" if value is None else f"return {self._bare(value, known)}"]
            case tree.CFor():
                return self._for(x, known)
            case tree.CWhile(test, body):
                return [f"while {self._bare(test, known)}:", *self.block(body, known)]
            case tree.CIf():
                return self._if(x, known)

    def _if(self, x: tree.CIf, known: Wholes) -> list[str]:
        test = folded(x.test, known)
        if isinstance(test, tree.CNumber):
            return [line for y in (x.yes if test.value else x.no) for line in self._statement(y, known)]
        lines = [f"if {self._bare(test, known)}:", *self.block(x.yes, known)]
        return [*lines, "else:", *self.block(x.no, known)] if x.no else lines

    def _for(self, x: tree.CFor, known: Wholes) -> list[str]:
        first, end = folded(x.first, known), folded(x.end, known)
        if isinstance(first, tree.CNumber) and isinstance(end, tree.CNumber):
            turns = range(int(first.value), int(end.value), x.step)
            lines = [line for i in turns[:1] for line in self._written_out(x, i, known)]
            if len(lines) * len(turns) <= MOST_WRITTEN_OUT:
                return lines + [line for i in turns[1:] for line in self._written_out(x, i, known)]
        bounds = ", ".join(self._bare(y, known) for y in (first, end, tree.CNumber(x.step)))
        return [f"for {_name(x.name)} in range({bounds}):", *self.block(x.body, known)]

    def _written_out(self, x: tree.CFor, i: int, known: Wholes) -> list[str]:
        return [line for y in x.body for line in self._statement(y, {**known, x.name: i})]

    def _bare(self, x: tree.CExpression, known: Wholes) -> str:
        """Without brackets around the whole."""
        text = self.expression(x, known)
        return text[1:-1] if isinstance(folded(x, known), tree.CBinary | tree.CChoice) else text

    def expression(self, x: tree.CExpression, known: Wholes) -> str:
        """As Python."""
        x = folded(x, known)
        match x:
            case tree.CNumber(value):
                return repr(value)
            case tree.CName(name):
                return _name(name)
            case tree.CItem():
                return self._item(x, known)
            case tree.CCall(function, arguments):
                return self._call(function, [self._bare(y, known) for y in arguments])
            case tree.CUnary(sign, of):
                return f"{'not ' if sign == '!' else sign}{self.expression(of, known)}"
            case tree.CBinary(sign, left, right):
                return f"({self.expression(left, known)} {_SIGNS.get(sign, sign)} {self.expression(right, known)})"
            case tree.CChoice(test, yes, no):
                parts = (self.expression(y, known) for y in (yes, test, no))
                return "({} if {} else {})".format(*parts)

    def _item(self, x: tree.CItem, known: Wholes) -> str:
        if isinstance(x.place, tree.CNumber) and x.array not in self.local:
            return f"{x.array}_{x.place.value}"
        return f"{_name(x.array)}[{self._bare(x.place, known)}]"

    def _call(self, function: str, arguments: list[str]) -> str:
        if function == "floor":
            return f"(({arguments[0]}) // 1.0)"
        return f"{'abs' if function == 'fabs' else function}({', '.join(arguments)})"


def folded(x: tree.CExpression, known: Wholes) -> tree.CExpression:
    """With what follows from whole numbers put in; arithmetic of doubles is left as it is."""
    match x:
        case tree.CName(name) if name in known:
            return tree.CNumber(known[name])
        case tree.CItem(array, place):
            place = folded(place, known)
            name = f"{array}_{place.value}" if isinstance(place, tree.CNumber) else ""
            return _Known(known[name]) if name in known else tree.CItem(array, place)
        case tree.CBinary(sign, left, right):
            left, right = folded(left, known), folded(right, known)
            if _is_whole(left) and _is_whole(right):
                return _worked_out(sign, int(left.value), int(right.value))  # type: ignore[union-attr]
            return _with_known(sign, left, right)
        case tree.CChoice(test, yes, no):
            test = folded(test, known)
            if isinstance(test, tree.CNumber):
                return folded(yes if test.value else no, known)
            return tree.CChoice(test, folded(yes, known), folded(no, known))
    return x


def _with_known(sign: str, left: tree.CExpression, right: tree.CExpression) -> tree.CExpression:
    """Without what a known 0, 1 or -1 leaves out."""
    if sign == ">" and isinstance(left, _Known) and isinstance(right, tree.CNumber):
        return tree.CNumber(int(left.value > right.value))
    for one, other in ((left, right), (right, left)):
        value = one.value if isinstance(one, _Known) else None
        if sign == "*" and value in (0.0, 1.0, -1.0):
            return _Known(0.0) if value == 0.0 else other if value == 1.0 else tree.CUnary("-", other)
        if sign == "+" and value == 0.0:
            return other
    if sign == "+" and isinstance(right, tree.CUnary) and right.sign == "-":
        return tree.CBinary("-", left, right.of)
    return tree.CBinary(sign, left, right)


def _is_whole(x: tree.CExpression) -> bool:
    return isinstance(x, tree.CNumber) and isinstance(x.value, int)


def _worked_out(sign: str, a: int, b: int) -> tree.CExpression:
    values = {
        "+": a + b, "-": a - b, "*": a * b, "<": a < b, ">": a > b, "<=": a <= b, ">=": a >= b, "==": a == b,
        "!=": a != b,
    }  # fmt: skip
    if sign == "%" and b > 0:
        return tree.CNumber(a % b)
    return tree.CNumber(int(values[sign])) if sign in values else tree.CBinary(sign, tree.CNumber(a), tree.CNumber(b))
