"""Expressions of xacro files, read node by node: a foreign file is expanded and none of its code runs.

xacro hands `${...}` to Python's `eval` and forbids some names there, which can be walked around. Here only the nodes of
`_NODES` have a meaning. A value is a number, a string, a list, a tuple or a dictionary, never a function; functions are
called by names in lists; attributes are read of xacro's own dictionaries alone. What grows without bound is refused.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

LONGEST = 1_000_000
"""Characters and members of one value."""
MOST_IN_ALL = 20 * LONGEST
"""Characters and members of all values of a file, and macro calls times a thousand."""
_MOST_BITS = 10_000
_MOST_DIGITS = 400
_DEEPEST = 50
_CALL = 1000


class ExpressionError(ValueError):
    """An expression that holds more than is read here; says what."""


def _counted(count: float, what: str = "value") -> None:
    if count > LONGEST:
        raise ExpressionError(f"a {what} longer than {LONGEST} characters or members")


def _size(value: Any, depth: int = 0) -> int:
    """Characters and members of a value, those of its members included."""
    if isinstance(value, str):
        _counted(len(value))
        return len(value) + 1
    members = [*value, *value.values()] if isinstance(value, dict) else value
    if not isinstance(members, list | tuple | set | range):
        return 1
    if depth > _DEEPEST:
        raise ExpressionError(f"a value of more than {_DEEPEST} levels")
    total = 1
    for member in members:
        total += _size(member, depth + 1)
        _counted(total)
    return total


def _range(*bounds: int) -> range:
    out = range(*bounds)
    _counted((out.stop - out.start) / out.step, "range")
    return out


def _round(x: Any, digits: int | None = None) -> Any:
    if abs(digits or 0) > _MOST_DIGITS:
        raise ExpressionError(f"round to {digits} digits")
    return round(x, digits)


def _replaced(text: str, old: str, new: str) -> str:
    _counted(len(text) + text.count(old) * len(new))
    return text.replace(old, new)


def _joined(between: str, parts: Iterable[str]) -> str:
    members = list(parts)
    _counted(sum(len(part) + len(between) for part in members))
    return between.join(members)


_PYTHON: dict[str, Callable[..., Any]] = {
    **{f.__name__: f for f in (abs, all, any, bool, dict, divmod, float, int, len, list, max, min, ord, repr, set)},
    **{f.__name__: f for f in (sorted, str, tuple)},
    "range": _range, "round": _round, "sum": lambda members: sum(members),
    **{f.__name__: lambda *given, f=f: list(f(*given)) for f in (enumerate, reversed, zip)},
}  # fmt: skip
_UNBOUNDED = ("comb", "factorial", "perm", "prod")
_MATH: dict[str, Callable[..., Any]] = {
    name: f for name, f in vars(math).items() if callable(f) and name[0] != "_" and name not in _UNBOUNDED
}
_XACRO = (
    "abs_filename", "arg", "dotify", "error", "fatal", "load_yaml", "message", "print_location", "tokenize", "warning",
)  # fmt: skip
FUNCTIONS = _MATH | _PYTHON
"""Those that a call may name without `math.` or `python.`, where the file's names have them."""
_METHODS: dict[type, dict[str, Callable[..., Any]]] = {
    str: {
        **{name: getattr(str, name) for name in ("capitalize", "count", "endswith", "find", "isdigit", "lower")},
        **{name: getattr(str, name) for name in ("lstrip", "rsplit", "rstrip", "split", "startswith", "strip")},
        **{name: getattr(str, name) for name in ("title", "upper")},
        "join": _joined, "replace": _replaced,
    },
    dict: {
        "get": dict.get,
        **{f.__name__: lambda given, f=f: list(f(given)) for f in (dict.keys, dict.values, dict.items)},
    },
}  # fmt: skip


def _power(x: Any, y: Any) -> Any:
    if isinstance(x, int) and isinstance(y, int) and x.bit_length() * abs(y) > _MOST_BITS:
        raise ExpressionError(f"a power of more than {_MOST_BITS} bits")
    return x**y


def _product(x: Any, y: Any) -> Any:
    for sequence, times in ((x, y), (y, x)):
        if isinstance(sequence, str | list | tuple) and isinstance(times, int):
            _counted(len(sequence) * times)
    if isinstance(x, int) and isinstance(y, int) and x.bit_length() + y.bit_length() > _MOST_BITS:
        raise ExpressionError(f"a product of more than {_MOST_BITS} bits")
    return x * y


def _sum(x: Any, y: Any) -> Any:
    if isinstance(x, str | list | tuple) and isinstance(y, str | list | tuple):
        _counted(len(x) + len(y))
    return x + y


def _remainder(x: Any, y: Any) -> Any:
    if isinstance(x, str) and re.search(r"\*|\d{4}", x):
        raise ExpressionError("a width of more than three digits in a format")
    return x % y


_OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: _sum, ast.Sub: operator.sub, ast.Mult: _product, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: _remainder, ast.Pow: _power,
    ast.UAdd: operator.pos, ast.USub: operator.neg, ast.Not: operator.not_,
    ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt,
    ast.GtE: operator.ge, ast.Is: operator.is_, ast.IsNot: operator.is_not,
    ast.In: lambda x, y: x in y, ast.NotIn: lambda x, y: x not in y,
}  # fmt: skip


class Expressions:
    """The expressions of one file that is expanded, with the count of what they gave so far.

    >>> Expressions()("2 * pi if name == 'arm' else len(name)", {"name": "arm", "pi": 3.0})
    6.0
    """

    def __init__(self) -> None:
        self.given = 0

    def __call__(self, text: str, names: Mapping[str, Any], _: Any = None) -> Any:
        """The value of an expression, in place of `xacro.safe_eval`; raises `ExpressionError` and what Python would."""
        value = _Reader(names).value(ast.parse(text.strip(), "<expression>", "eval").body)
        self.count(_size(value))
        return value

    def count(self, size: int) -> None:
        """Add what an expression or a macro call gave; raises `ExpressionError` beyond `MOST_IN_ALL`."""
        self.given += size
        if self.given > MOST_IN_ALL:
            raise ExpressionError("a file whose expressions and macros grow without end")

    def counting(self, call: Callable[..., Any]) -> Callable[..., Any]:
        """A handler of elements that counts those that were macro calls."""

        def counted(*arguments: Any) -> Any:
            was_a_call = call(*arguments)
            self.count(_CALL if was_a_call else 0)
            return was_a_call

        return counted


class _Reader:
    """Gives each node its value."""

    def __init__(self, names: Mapping[str, Any]) -> None:
        self.names = names

    def value(self, node: ast.AST) -> Any:
        if type(node) not in _NODES:
            raise ExpressionError(f"{type(node).__name__} in an expression")
        out = _NODES[type(node)](self, node)
        if callable(out):
            raise ExpressionError(f"the function {ast.unparse(node)}, which is not called")
        if not isinstance(node, ast.Name | ast.Attribute | ast.Subscript):  # what these give was counted before
            _size(out)
        return out

    def values(self, nodes: Iterable[ast.AST]) -> list[Any]:
        return [self.value(node) for node in nodes]

    def constant(self, node: Any) -> Any:
        if not isinstance(node.value, int | float | str | None):
            raise ExpressionError(f"{node.value!r} in an expression")
        return node.value

    def name(self, node: Any) -> Any:
        try:
            return self.names[node.id]
        except KeyError:
            raise NameError(f"name '{node.id}' is not defined") from None

    def attribute(self, node: Any) -> Any:
        base = self.value(node.value)
        if type(base).__module__ != "xacro" or not isinstance(base, dict) or node.attr.startswith("_"):
            raise ExpressionError(f"the attribute {node.attr}")
        return base[node.attr]

    def subscript(self, node: Any) -> Any:
        base = self.value(node.value)
        if not isinstance(base, str | list | tuple | dict | range):
            raise ExpressionError(f"an index of {ast.unparse(node.value)}")
        return base[self.value(node.slice)]

    def slice(self, node: Any) -> slice:
        return slice(*(None if x is None else self.value(x) for x in (node.lower, node.upper, node.step)))

    def operation(self, node: Any) -> Any:
        operands = [node.operand] if isinstance(node, ast.UnaryOp) else [node.left, node.right]
        if type(node.op) not in _OPERATORS:
            raise ExpressionError(f"{type(node.op).__name__} in an expression")
        return _OPERATORS[type(node.op)](*self.values(operands))

    def logic(self, node: Any) -> Any:
        stops = isinstance(node.op, ast.Or)
        value = self.value(node.values[0])
        for other in node.values[1:]:
            value = value if bool(value) is stops else self.value(other)
        return value

    def comparison(self, node: Any) -> bool:
        left = self.value(node.left)
        for kind, other in zip(node.ops, node.comparators, strict=True):
            right = self.value(other)
            if not _OPERATORS[type(kind)](left, right):
                return False
            left = right
        return True

    def call(self, node: Any) -> Any:
        function = self.function(node.func)
        named = {each.arg: self.value(each.value) for each in node.keywords}
        if None in named:
            raise ExpressionError("** in an expression")
        return function(*self.values(node.args), **named)

    def function(self, node: Any) -> Callable[..., Any]:
        """What a call names: a listed function, one of `math.`, `python.`, `xacro.`, a listed method of a value."""
        name = ast.unparse(node)
        if isinstance(node, ast.Name):
            own = self.name(node)
            if not callable(own):
                raise TypeError(f"{name} is no function")
            found = self._xacro(own, node.id) or FUNCTIONS.get(node.id)
        elif not isinstance(node, ast.Attribute):
            found = None
        elif isinstance(node.value, ast.Name) and node.value.id in ("math", "python"):
            found = (_MATH if node.value.id == "math" else _PYTHON).get(node.attr)
        else:
            found = self._method(self.value(node.value), node.attr)
        if found is None:
            raise ExpressionError(f"a call of {name}")
        return found

    def _xacro(self, own: Any, name: str) -> Callable[..., Any] | None:
        return own if callable(own) and name in _XACRO else None

    def _method(self, base: Any, name: str) -> Callable[..., Any] | None:
        if type(base).__name__ == "NameSpace":
            return self._xacro(base[name], name) if name in base else None
        methods = next((kept for kind, kept in _METHODS.items() if isinstance(base, kind)), {})
        return partial(methods[name], base) if name in methods else None


_NODES: dict[type[ast.AST], Callable[[_Reader, Any], Any]] = {
    ast.Constant: _Reader.constant,
    ast.Name: _Reader.name,
    ast.Attribute: _Reader.attribute,
    ast.Subscript: _Reader.subscript,
    ast.Slice: _Reader.slice,
    ast.BinOp: _Reader.operation,
    ast.UnaryOp: _Reader.operation,
    ast.BoolOp: _Reader.logic,
    ast.Compare: _Reader.comparison,
    ast.IfExp: lambda reader, node: reader.value(node.body if reader.value(node.test) else node.orelse),
    ast.List: lambda reader, node: reader.values(node.elts),
    ast.Tuple: lambda reader, node: tuple(reader.values(node.elts)),
    ast.Set: lambda reader, node: set(reader.values(node.elts)),
    ast.Dict: lambda reader, node: dict(zip(reader.values(node.keys), reader.values(node.values), strict=True)),
    ast.Call: _Reader.call,
}
