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
from types import MappingProxyType
from typing import Any

LONGEST = 1_000_000
"""Characters and members of one value."""
MOST_IN_ALL = 10 * LONGEST
"""Characters and members of all values of a file, those on the way to a value too; `xacro_bounds` adds its own."""
_MOST_BITS = 10_000
_MOST_DIGITS = 400
_DEEPEST = 50
_LONGEST_TEXT = 10_000
_MOST_KEYS = 300
"""Members of a set or keys of a dictionary that are no text: numbers can be chosen so that their hashes are equal."""
_PLAIN = (int, float, complex, str, list, tuple, dict, set, range, type(None))
_FLAT = (int, float, bool, str, type(None))
_TABLES = ("NameSpace", "Table")


class ExpressionError(ValueError):
    """An expression that holds more than is read here; says what."""


def _counted(count: float, what: str = "value") -> None:
    if count > LONGEST:
        raise ExpressionError(f"a {what} longer than {LONGEST} characters or members")


def _size(value: Any, depth: int = 0) -> int:
    """Characters and members of a value, those of its members included; a list in a list counts as ten."""
    if isinstance(value, str):
        _counted(len(value))
        return len(value) + 1
    members = [*value, *value.values()] if isinstance(value, dict) else value
    if not isinstance(members, list | tuple | set | range) or type(value).__name__ in _TABLES:
        _checked_numbers([value])
        return 1
    if isinstance(value, dict | set):
        _checked_keys(value)
    if depth > _DEEPEST:
        raise ExpressionError(f"a value of more than {_DEEPEST} levels")
    _counted(len(members))
    texts = [x for x in members if type(x) is str]
    total = 10 + len(members) + sum(map(len, texts))
    _counted(total - 10)
    if len(texts) < len(members):
        _checked_numbers(members)
    for member in members if len(texts) < len(members) else ():
        if type(member) not in _FLAT:
            total += _size(member, depth + 1)
            _counted(total)
    return total


def _checked_numbers(members: Iterable[Any]) -> None:
    whole = [x for x in members if isinstance(x, int)]
    if whole and max(max(whole), -min(whole)).bit_length() > 2 * _MOST_BITS:
        raise ExpressionError(f"a number of more than {_MOST_BITS} bits")


def _checked_keys(keys: Iterable[Any]) -> list[Any]:
    """Members of a set or keys of a dictionary; raises for many that could be made to collide."""
    members = list(keys)
    if len(members) > _MOST_KEYS and sum(not isinstance(key, str) for key in members) > _MOST_KEYS:
        raise ExpressionError(f"a set or dictionary of more than {_MOST_KEYS} numbers")
    return members


def _set(members: Iterable[Any] = ()) -> set[Any]:
    return set(_checked_keys(members))


def _dict(members: Any = (), **named: Any) -> dict[Any, Any]:
    pairs = list(members.items() if isinstance(members, dict) else members)
    _checked_keys(pair[0] for pair in pairs)
    return dict(pairs, **named)


def _tokenize(text: str, sep: str = ",; ", skip_empty: bool = True) -> list[str]:
    """As xacro's own, of single characters that separate: a `]` would end their class and begin any pattern."""
    if "]" in sep:
        raise ExpressionError("] among the separators of tokenize")
    return [part for part in re.split(f"[{sep}]", text) if part or not skip_empty]


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
    **{f.__name__: f for f in (abs, all, any, bool, divmod, float, int, len, list, max, min, ord, repr, sorted, str)},
    "tuple": tuple, "dict": _dict, "set": _set, "range": _range, "round": _round, "sum": lambda members: sum(members),
    **{f.__name__: lambda *given, f=f: list(f(*given)) for f in (enumerate, reversed, zip)},
}  # fmt: skip
_UNBOUNDED = ("comb", "factorial", "lcm", "perm", "prod", "sumprod")
_MATH: dict[str, Callable[..., Any]] = {
    name: f for name, f in vars(math).items() if callable(f) and name[0] != "_" and name not in _UNBOUNDED
}
_XACRO = (
    "abs_filename", "arg", "dotify", "env", "error", "fatal", "find", "load_yaml", "message", "optenv",
    "print_location", "tokenize", "warning",
)  # fmt: skip
"""Functions of the file's names: those of `xacro.`, and those of `$(eval ...)`."""
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
    if isinstance(x, str):
        if re.search(r"\*|\d{4}", x):
            raise ExpressionError("a width of more than three digits in a format")
        _counted(x.count("%") * (_size(y) + 1000 * bool(re.search(r"%[^a-zA-Z%]*\d\d", x))))
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

    `functions` stand in for xacro's of these names.

    >>> Expressions()("2 * pi if name == 'arm' else len(name)", {"name": "arm", "pi": 3.0})
    6.0
    """

    def __init__(self, functions: Mapping[str, Callable[..., Any]] = MappingProxyType({})) -> None:
        self.given, self.functions = 0, {"tokenize": _tokenize, **functions}

    def __call__(self, text: str, names: Mapping[str, Any], _: Any = None) -> Any:
        """The value of an expression, in place of `xacro.safe_eval`; raises `ExpressionError` and what Python would."""
        if len(text) > _LONGEST_TEXT:
            raise ExpressionError(f"an expression longer than {_LONGEST_TEXT} characters")
        return _Evaluator(names, self).value(ast.parse(text.strip(), "<expression>", "eval").body)

    def count(self, size: int) -> None:
        """Add what an expression or a macro gave or cost; raises `ExpressionError` beyond `MOST_IN_ALL`."""
        self.given += size
        if self.given > MOST_IN_ALL:
            raise ExpressionError("a file whose expressions and macros grow without end")


class _Evaluator:
    """Gives each node its value."""

    def __init__(self, names: Mapping[str, Any], owner: Expressions) -> None:
        self.names, self.count, self.functions = names, owner.count, owner.functions

    def value(self, node: ast.AST) -> Any:
        if type(node) not in _NODES:
            raise ExpressionError(f"{type(node).__name__} in an expression")
        out = _NODES[type(node)](self, node)
        if callable(out):
            raise ExpressionError(f"the function {ast.unparse(node)}, which is not called")
        if isinstance(out, int) or not isinstance(node, ast.Name | ast.Attribute):  # what these give was counted before
            self.count(_size(out))
        return out

    def operands(self, nodes: Iterable[ast.AST]) -> list[Any]:
        """Values to compute with, which takes the longer the larger they are."""
        values = self.values(nodes)
        for value in values:
            if not isinstance(value, _PLAIN):
                raise ExpressionError(f"a value of the kind {type(value).__name__}")
            self.count(_size(value))
        return values

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
        return _OPERATORS[type(node.op)](*self.operands(operands))

    def logic(self, node: Any) -> Any:
        stops = isinstance(node.op, ast.Or)
        value = self.value(node.values[0])
        for other in node.values[1:]:
            value = value if bool(value) is stops else self.value(other)
        return value

    def comparison(self, node: Any) -> bool:
        (left,) = self.operands([node.left])
        for kind, other in zip(node.ops, node.comparators, strict=True):
            (right,) = self.operands([other])
            if not _OPERATORS[type(kind)](left, right):
                return False
            left = right
        return True

    def call(self, node: Any) -> Any:
        function = self.function(node.func)
        named = {each.arg: self.operands([each.value])[0] for each in node.keywords}
        if None in named:
            raise ExpressionError("** in an expression")
        return function(*self.operands(node.args), **named)

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
            base = self.value(node.value)
            self.count(_size(base))
            found = self._method(base, node.attr)
        if found is None:
            raise ExpressionError(f"a call of {name}")
        return found

    def _xacro(self, own: Any, name: str) -> Callable[..., Any] | None:
        return self.functions.get(name, own) if callable(own) and name in _XACRO else None

    def _method(self, base: Any, name: str) -> Callable[..., Any] | None:
        if type(base).__name__ == "NameSpace":
            return self._xacro(base[name], name) if name in base else None
        methods = next((kept for kind, kept in _METHODS.items() if isinstance(base, kind)), {})
        return partial(methods[name], base) if name in methods else None


_NODES: dict[type[ast.AST], Callable[[_Evaluator, Any], Any]] = {
    ast.Constant: _Evaluator.constant,
    ast.Name: _Evaluator.name,
    ast.Attribute: _Evaluator.attribute,
    ast.Subscript: _Evaluator.subscript,
    ast.Slice: _Evaluator.slice,
    ast.BinOp: _Evaluator.operation,
    ast.UnaryOp: _Evaluator.operation,
    ast.BoolOp: _Evaluator.logic,
    ast.Compare: _Evaluator.comparison,
    ast.IfExp: lambda reader, node: reader.value(node.body if reader.value(node.test) else node.orelse),
    ast.List: lambda reader, node: reader.values(node.elts),
    ast.Tuple: lambda reader, node: tuple(reader.values(node.elts)),
    ast.Set: lambda reader, node: _set(reader.values(node.elts)),
    ast.Dict: lambda reader, node: _dict(zip(reader.values(node.keys), reader.values(node.values), strict=True)),
    ast.Call: _Evaluator.call,
}
