"""The same small changes of the C texts of the package: comparison, sign, logic, constant, condition, statement.

By the text, line by line: these files have one statement a line, as clang-format writes them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from soak_lines.mutations import Mutant

OPERATORS = re.compile(r" (<=|>=|==|!=|<|>|\+|-|\*|/|&&|\|\||\+=|-=) ")
OTHERS = {
    "<": ("<=", ">"), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<="), "==": ("!=",), "!=": ("==",),
    "+": ("-",), "-": ("+",), "*": ("+",), "/": ("*",), "&&": ("||",), "||": ("&&",), "+=": ("-=",), "-=": ("+=",),
}  # fmt: skip
"""A product becomes a sum: a quotient of whole numbers would be a place in an array."""
KINDS = {"&&": "logic", "||": "logic"} | dict.fromkeys(("+", "-", "*", "/", "+=", "-="), "sign")
NUMBERS = re.compile(r"(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+|\d+)(?![\w.])")
CONDITION = re.compile(r"\bif \((.*)\) \{$")
STATEMENT = re.compile(r"^\s*([a-z_]\w*(?:\[.*\])? (?:[-+*/]?=) .*;|[a-z_]\w*\([^?]*\);|break;|continue;)$")
DECLARES_ROOM = re.compile(r"^\s*(?:double|int) \w+\[|^\w.*\(.*\w\[\d+\]")
"""Of an array, or of one that a function is given, where the number changes nothing."""
COMMENT = re.compile(r"/\*.*?\*/", re.S)


def mutants_of_c(path: Path, module: str) -> list[Mutant]:
    """All changes of a text that our part of C can read, in its order; none in comments and of the sizes of arrays."""
    source = path.read_text(encoding="utf-8")
    bare = COMMENT.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), source)
    found, start = [], 0
    for number, line in enumerate(bare.splitlines(keepends=True), 1):
        if not line.startswith("#") and not DECLARES_ROOM.match(line):
            for kind, begin, end, new in _changes(line.rstrip("\n")):
                text = source[start : start + len(line)].strip()
                found.append(Mutant(module, number, kind, start + begin, start + end, line[begin:end], new, text))
        start += len(line)
    return found


def _changes(line: str) -> Iterator[tuple[str, int, int, str]]:
    for match in OPERATORS.finditer(line):
        kind = KINDS.get(match[1], "comparison")
        is_of_loop = " for (" in line and (kind == "comparison" or match[1] == "+=")
        for new in () if is_of_loop else OTHERS[match[1]]:
            yield kind, match.start(1), match.end(1), new
    for match in NUMBERS.finditer(line):
        for new in _other_numbers(match[1]):
            yield "constant", match.start(1), match.end(1), new
    if match := CONDITION.search(line):
        yield "condition", match.start(1), match.end(1), "0"
    if match := STATEMENT.match(line):
        yield "statement", match.start(1), match.end(1), ""


def _other_numbers(text: str) -> tuple[str, ...]:
    if text.isdigit():
        return (str(int(text) + 1), str(int(text) - 1)) if int(text) else ("1",)
    value = float(text)
    return (repr(value * 2.0), repr(value * 0.5)) if value else ("1.0",)
