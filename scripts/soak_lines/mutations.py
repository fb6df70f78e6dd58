"""Small changes of Python source, one at a time: comparison, sign, constant, boundary, arguments, statement."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

COMPARISONS = {
    ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "==", ast.Is: "is not",
    ast.IsNot: "is", ast.In: "not in", ast.NotIn: "in",
}  # fmt: skip
TURNED = {ast.Lt: ">", ast.LtE: ">", ast.Gt: "<=", ast.GtE: "<"}
SIGNS = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.MatMult: "*", ast.FloorDiv: "/", ast.Pow: "*"}
WORDS = {"min": "max", "max": "min", "any": "all", "all": "any", "argmin": "argmax", "argmax": "argmin"}
EITHER_WAY = {
    "max", "min", "maximum", "minimum", "fmax", "fmin", "hypot", "array_equal", "gcd", "mul", "fmul", "fadd",
}  # fmt: skip
"""Functions of two arguments whose order says nothing."""
LEFT_OUT = (ast.Raise, ast.Assert, ast.Import, ast.ImportFrom, ast.JoinedStr)
"""Messages, assertions and what is not run: their changes say nothing."""


TEXT_OR_NUMBER = (ast.Constant, ast.JoinedStr)
Change = tuple[ast.expr | ast.stmt, str, ast.AST, ast.AST, str]
"""Node, kind, first and last node of the text that is replaced, and the new text."""


@dataclass(frozen=True, slots=True)
class Mutant:
    """A change of a module: the text from `begin` to `end` becomes `new`."""

    module: str
    line: int
    kind: str
    begin: int
    end: int
    old: str
    new: str
    text: str
    """The line where it begins; of a single word also the line before."""

    @property
    def name(self) -> str:
        """Such as "simulation/record.py:90 comparison: > 0.0 -> >= 0.0"."""
        return f"{self.module}:{self.line} {self.kind}: {' '.join(self.old.split())} -> {self.new}"

    @property
    def key(self) -> str:
        """The name with the line's text instead of its number, which moves."""
        return f"{self.module} {self.kind}: {' '.join(self.old.split())} -> {self.new} in: {self.text}"

    def applied(self, source: str) -> str:
        """The changed source."""
        return source[: self.begin] + self.new + source[self.end :]


def mutants_of(path: Path, module: str) -> list[Mutant]:
    """All changes of a module, in the order of its text."""
    source = path.read_text(encoding="utf-8")
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    lines = source.splitlines()

    def place(line: int, column: int) -> int:
        return starts[line - 1] + len(lines[line - 1].encode()[:column].decode())

    found = []
    for node, kind, first, last, new in _changes(ast.parse(source)):
        begin = place(first.lineno, first.col_offset)
        end = place(last.end_lineno, last.end_col_offset)
        text = lines[first.lineno - 1].strip()
        text = text if "(" in text or "=" in text else f"{lines[first.lineno - 2].strip()} {text}"
        found.append(Mutant(module, node.lineno, kind, begin, end, source[begin:end], new, text))
    return [x for x in found if x.old != x.new]


def _changes(node: ast.AST) -> Iterator[Change]:
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "bases", "type_params"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and not isinstance(child, LEFT_OUT) and not _is_strict(child):
                yield from _of(child)
                yield from _changes(child)


def _of(node: ast.AST) -> Iterator[Change]:
    if isinstance(node, ast.Constant):
        for value in _other_values(node.value):
            yield node, "constant", node, node, repr(value)
    elif isinstance(node, ast.Call):
        yield from _of_call(node)
    elif isinstance(node, ast.stmt):
        yield from _of_statement(node)
    elif isinstance(node, ast.expr):
        yield from _of_operation(node)


def _of_operation(node: ast.expr) -> Iterator[Change]:
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        left, right = ast.unparse(node.left), ast.unparse(node.comparators[0])
        for table in (COMPARISONS, TURNED):
            if type(node.ops[0]) in table:
                yield node, "comparison", node, node, f"{left} {table[type(node.ops[0])]} {right}"
    elif isinstance(node, ast.BinOp) and type(node.op) in SIGNS and not isinstance(node.left, TEXT_OR_NUMBER):
        new = f"({ast.unparse(node.left)}) {SIGNS[type(node.op)]} ({ast.unparse(node.right)})"
        yield node, "sign", node, node, f"({new})"
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
        yield node, "sign", node, node, f"({ast.unparse(node.operand)})"
    elif isinstance(node, ast.BoolOp):
        word = " or " if isinstance(node.op, ast.And) else " and "
        yield node, "logic", node, node, f"({word.join(f'({ast.unparse(x)})' for x in node.values)})"


def _other_values(value: object) -> tuple[object, ...]:
    if isinstance(value, bool):
        return (not value,)
    if isinstance(value, int):
        return (value + 1, value - 1) if value else (1,)
    if isinstance(value, float):
        return (value * 2.0, value * 0.5) if value else (1.0,)
    return ()


def _of_call(node: ast.Call) -> Iterator[Change]:
    word = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    ordered = (word not in EITHER_WAY or node.keywords) and word != "cast"  # which names a type, as annotations do
    if ordered and len(node.args) >= 2 and not any(isinstance(x, ast.Starred) for x in node.args[:2]):
        first, second = node.args[:2]
        if ast.unparse(first) != ast.unparse(second):
            yield node, "arguments", first, second, f"{ast.unparse(second)}, {ast.unparse(first)}"
    if word in WORDS:
        new = ast.unparse(node.func)
        yield node, "function", node.func, node.func, new[: len(new) - len(word)] + WORDS[word]


def _of_statement(node: ast.stmt) -> Iterator[Change]:
    documented = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    if isinstance(node, ast.Expr | ast.AugAssign | ast.Continue | ast.Break) and not documented:
        yield node, "statement", node, node, "pass"
    elif isinstance(node, ast.If) and not node.orelse and not _is_for_types(node):
        yield node, "condition", node.test, node.test, "False"
    elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Subscript | ast.Attribute):
        yield node, "statement", node, node, "pass"


def _is_strict(node: ast.AST) -> bool:
    """`strict=True` of a `zip`: an assertion, as `assert` is."""
    return isinstance(node, ast.keyword) and node.arg == "strict"


def _is_for_types(node: ast.If) -> bool:
    return "TYPE_CHECKING" in ast.unparse(node.test)
