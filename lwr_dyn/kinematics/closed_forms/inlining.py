"""A text with its shortest functions put in where they are called, for Python, where a call takes as long as they do.

A short function sets a few numbers and gives one. What it is given is worked out once, before the statement; not where
it might not be worked out at all, as there it could divide by zero.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

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
    CSet,
    CStatement,
    CText,
    CUnary,
    CWhile,
)

MOST_SET = 4
"""Numbers that a short function may set before its end."""


def inlined(text: CText) -> CText:
    """The same functions; a function stands behind those that it calls, as in C."""
    done: dict[str, CFunction] = {}
    for function in text.functions:
        writer = _Inliner(done)
        done[function.name] = replace(function, body=tuple(writer.block(function.body)))
    return replace(text, functions=tuple(done.values()))


def is_short(function: CFunction) -> bool:
    """Whether it only sets a few numbers of its own and gives one."""
    *before, last = function.body
    return (
        function.kind == "double"
        and isinstance(last, CReturn)
        and len(before) <= MOST_SET
        and all(isinstance(x, CSet) and x.declared and isinstance(x.target, CName) for x in before)
    )


@dataclass(slots=True)
class _Inliner:
    """Of one function."""

    known: Mapping[str, CFunction]
    count: int = 0
    before: list[CStatement] = field(default_factory=list)
    """What is worked out before the statement at hand."""

    def block(self, statements: Iterable[CStatement]) -> Iterator[CStatement]:
        for x in statements:
            made = self._statement(x)
            yield from self.before
            self.before.clear()
            yield made

    def _statement(self, x: CStatement) -> CStatement:
        match x:
            case CSet(declared, target, value):
                return CSet(declared, target, self._expression(value))
            case CReturn(value) if value is not None:
                return CReturn(self._expression(value))
            case CDo(call):
                return CDo(replace(call, arguments=tuple(self._expression(y) for y in call.arguments)))
            case CIf(test, yes, no):
                made = self._expression(test)
                inside = _Inliner(self.known, self.count)
                made_if = CIf(made, tuple(inside.block(yes)), tuple(inside.block(no)))
                self.count = inside.count
                return made_if
            case CFor() | CWhile():
                inside = _Inliner(self.known, self.count)
                made_loop = replace(x, body=tuple(inside.block(x.body)))
                self.count = inside.count
                return made_loop
        return x

    def _expression(self, x: CExpression) -> CExpression:
        """With short functions put in where it is certain that they are worked out."""
        match x:
            case CItem(array, place):
                return CItem(array, self._expression(place))
            case CUnary(sign, of):
                return CUnary(sign, self._expression(of))
            case CBinary(sign, left, right):
                return CBinary(sign, self._expression(left), right if sign in ("&&", "||") else self._expression(right))
            case CChoice(test, yes, no):
                return CChoice(self._expression(test), yes, no)
            case CCall(name, arguments):
                given = tuple(self._expression(y) for y in arguments)
                function = self.known.get(name)
                return (
                    CCall(name, given) if function is None or not is_short(function) else self._put_in(function, given)
                )
        return x

    def _put_in(self, function: CFunction, given: tuple[CExpression, ...]) -> CExpression:
        names = {name: self._kept(y) for (_, name), y in zip(function.arguments, given, strict=True)}
        *before, last = function.body
        for x in before:
            if isinstance(x, CSet) and isinstance(x.target, CName):
                names[x.target.name] = self._kept(_renamed(x.value, names))
        assert isinstance(last, CReturn)
        return _renamed(last.value or CNumber(0), names)

    def _kept(self, x: CExpression) -> CExpression:
        """A name or a number as it is, else a new name that is set to it."""
        if isinstance(x, CName | CNumber):
            return x
        self.count += 1
        name = CName(f"kept_{self.count}")
        self.before.append(CSet("double", name, x))
        return name


def _renamed(x: CExpression, names: Mapping[str, CExpression]) -> CExpression:
    """With other expressions in the place of names."""
    match x:
        case CName(name):
            return names.get(name, x)
        case CItem(array, place):
            other = names.get(array)
            return CItem(other.name if isinstance(other, CName) else array, _renamed(place, names))
        case CUnary(sign, of):
            return CUnary(sign, _renamed(of, names))
        case CBinary(sign, left, right):
            return CBinary(sign, _renamed(left, names), _renamed(right, names))
        case CChoice(test, yes, no):
            return CChoice(_renamed(test, names), _renamed(yes, names), _renamed(no, names))
        case CCall(name, arguments):
            return CCall(name, tuple(_renamed(y, names) for y in arguments))
    return x
