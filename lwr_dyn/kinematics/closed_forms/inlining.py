"""A text with its shortest functions put in where they are called, for Python, where a call takes as long as they do.

A short function sets a few numbers and gives one. What it is given is worked out once, before the statement; not where
it might not be worked out at all, as there it could divide by zero.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from lwr_dyn.kinematics.closed_forms import tree

MOST_SET = 4
"""Numbers that a short function may set before its end."""


def inlined(text: tree.CText) -> tree.CText:
    """The same functions; a function stands behind those that it calls, as in C."""
    done: dict[str, tree.CFunction] = {}
    for function in text.functions:
        writer = _Inliner(done)
        done[function.name] = replace(function, body=tuple(writer.block(function.body)))
    return replace(text, functions=tuple(done.values()))


def is_short(function: tree.CFunction) -> bool:
    """Whether it only sets a few numbers of its own and gives one."""
    *before, last = function.body
    return (
        function.kind == "double"
        and isinstance(last, tree.CReturn)
        and len(before) <= MOST_SET
        and all(isinstance(x, tree.CSet) and x.declared and isinstance(x.target, tree.CName) for x in before)
    )


@dataclass(slots=True)
class _Inliner:
    """Of one function."""

    known: Mapping[str, tree.CFunction]
    count: int = 0
    before: list[tree.CStatement] = field(default_factory=list)
    """What is worked out before the statement at hand."""

    def block(self, statements: Iterable[tree.CStatement]) -> Iterator[tree.CStatement]:
        for x in statements:
            made = self._statement(x)
            yield from self.before
            self.before.clear()
            yield made

    def _statement(self, x: tree.CStatement) -> tree.CStatement:
        match x:
            case tree.CSet(declared, target, value):
                return tree.CSet(declared, target, self._expression(value))
            case tree.CReturn(value) if value is not None:
                return tree.CReturn(self._expression(value))
            case tree.CDo(call):
                return tree.CDo(replace(call, arguments=tuple(self._expression(y) for y in call.arguments)))
            case tree.CIf(test, yes, no):
                made = self._expression(test)
                inside = _Inliner(self.known, self.count)
                made_if = tree.CIf(made, tuple(inside.block(yes)), tuple(inside.block(no)))
                self.count = inside.count
                return made_if
            case tree.CFor() | tree.CWhile():
                inside = _Inliner(self.known, self.count)
                made_loop = replace(x, body=tuple(inside.block(x.body)))
                self.count = inside.count
                return made_loop
        return x

    def _expression(self, x: tree.CExpression) -> tree.CExpression:
        """With short functions put in where it is certain that they are worked out."""
        match x:
            case tree.CItem(array, place):
                return tree.CItem(array, self._expression(place))
            case tree.CUnary(sign, of):
                return tree.CUnary(sign, self._expression(of))
            case tree.CBinary(sign, left, right):
                is_certain = sign not in ("&&", "||")
                return tree.CBinary(sign, self._expression(left), self._expression(right) if is_certain else right)
            case tree.CChoice(test, yes, no):
                return tree.CChoice(self._expression(test), yes, no)
            case tree.CCall(name, arguments):
                given = tuple(self._expression(y) for y in arguments)
                function = self.known.get(name)
                return self._put_in(function, given) if function and is_short(function) else tree.CCall(name, given)
        return x

    def _put_in(self, function: tree.CFunction, given: tuple[tree.CExpression, ...]) -> tree.CExpression:
        names = {name: self._kept(y) for (_, name), y in zip(function.arguments, given, strict=True)}
        *before, last = function.body
        for x in before:
            if isinstance(x, tree.CSet) and isinstance(x.target, tree.CName):
                names[x.target.name] = self._kept(_renamed(x.value, names))
        assert isinstance(last, tree.CReturn)
        return _renamed(last.value or tree.CNumber(0), names)

    def _kept(self, x: tree.CExpression) -> tree.CExpression:
        """A name or a number as it is, else a new name that is set to it."""
        if isinstance(x, tree.CName | tree.CNumber):
            return x
        self.count += 1
        name = tree.CName(f"kept_{self.count}")
        self.before.append(tree.CSet("double", name, x))
        return name


def _renamed(x: tree.CExpression, names: Mapping[str, tree.CExpression]) -> tree.CExpression:
    """With other expressions in the place of names."""
    match x:
        case tree.CName(name):
            return names.get(name, x)
        case tree.CItem(array, place):
            other = names.get(array)
            return tree.CItem(other.name if isinstance(other, tree.CName) else array, _renamed(place, names))
        case tree.CUnary(sign, of):
            return tree.CUnary(sign, _renamed(of, names))
        case tree.CBinary(sign, left, right):
            return tree.CBinary(sign, _renamed(left, names), _renamed(right, names))
        case tree.CChoice(test, yes, no):
            return tree.CChoice(_renamed(test, names), _renamed(yes, names), _renamed(no, names))
        case tree.CCall(name, arguments):
            return tree.CCall(name, tuple(_renamed(y, names) for y in arguments))
    return x
