"""Arithmetic in sentences, such as "1/2 x 0.0106 x 0.05^2 = 1.325e-7", computed again."""

import ast
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass

from lwr_dyn.checks.tables.arithmetic import FUNCTIONS, LONGEST, parsed, value_of
from lwr_dyn.checks.tables.fault_search import scale_or_sign
from lwr_dyn.checks.tables.sheet import Finding, Sheet
from lwr_dyn.model.printed_number import PrintedNumber, printed_number

_NUM = r"(?>\d+\.?\d*|\.\d+)(?>[eE][+-]?\d+)?"
_TOKEN = rf"(?>{_NUM}|\b(?:{'|'.join(sorted(FUNCTIONS, key=len, reverse=True))})(?=\s*\()|[-+*/^(),]|\bx\b|\bdeg\b|\s)"
_LEFT = re.compile(rf"(?<![\w.]){_TOKEN}+$")
_RIGHT = re.compile(rf"\s*([-+]?{_NUM})((?:\s+or\s+[-+]?{_NUM})*)\s*([^\s\d].{{0,3}})?")
_INNER = re.compile(rf"(?<![\w.]){_NUM}")


@dataclass(frozen=True, slots=True)
class Equality:
    """An equation left = right in a sentence."""

    left: str
    tree: ast.expr
    right: tuple[PrintedNumber, ...]
    """All alternatives that the sentence gives ("= -90 or 11.01")."""

    @property
    def slack(self) -> float:
        """How much the rounding of the decimals on the left may change the result."""
        exact = value_of(self.tree, {})
        changes = []
        for match in _INNER.finditer(self.left):
            number = printed_number(match.group())
            if number is not None and not number.is_whole:
                rounded = self.left[: match.start()] + repr(number.value + number.half) + self.left[match.end() :]
                changes.append(abs(value_of(parsed(rounded), {}) - exact))
        return sum(x for x in changes if math.isfinite(x))


def equalities(text: str) -> Iterator[Equality]:
    """Every "= number" of a sentence whose left side is arithmetic on numbers.

    >>> [(e.left, e.right[0].text) for e in equalities("the shoulder: 350 + 820 = 1170, and a = 3")]
    [('350 + 820', '1170')]
    """
    for sign in re.finditer(r"(?<![=<>!])=(?!=)", text):
        begin = max(0, sign.start() - 2 * LONGEST)  # a longer left side is no formula, and costs no time
        before = _LEFT.search(text[begin : sign.start()].rstrip())
        after = _RIGHT.match(text[sign.end() :])
        if before is None or after is None:
            continue
        left = _balanced(before.group().replace("deg", "").strip(" ,"))
        tree = parsed(left) if left else None
        rest = (after.group(3) or " ").lstrip()
        if tree is None or not _is_computation(tree) or rest[:1] in tuple("+*/^-x("):
            continue
        texts = [after.group(1), *re.findall(rf"or\s+([-+]?{_NUM})", after.group(2))]
        numbers = tuple(n for t in texts if (n := printed_number(t)) is not None)
        if numbers and math.isfinite(value_of(tree, {})):
            yield Equality(left, tree, numbers)


def _balanced(text: str) -> str:
    """The longest end of the text whose brackets close and that begins with a number, a function or a bracket."""
    depth, start = 0, len(text)
    for k in range(len(text) - 1, -1, -1):
        depth += {")": 1, "(": -1}.get(text[k], 0)
        if depth < 0:
            break
        if depth == 0 and text[k] == ",":
            break
        start = k
    out = text[start:].strip()
    return "" if out[:1] in tuple("+*/^,x)") else out


def _is_computation(tree: ast.expr) -> bool:
    """The formula is more than a number."""
    return any(isinstance(node, ast.BinOp | ast.Call) for node in ast.walk(tree))


def sentences(sheet: Sheet) -> Iterator[Finding]:
    """Rule 4 on sentences: the left side does not give the number on the right."""
    for sentence in sheet.sentences:
        for equality in equalities(sentence.text):
            values = [value_of(equality.tree, {}, degrees) for degrees in (False, True)]
            if not any(n.meets(v, equality.slack) for v in values for n in equality.right):
                yield _wrong(sentence.place, equality, values[-1])


def _wrong(place: str, equality: Equality, value: float) -> Finding:
    printed = " or ".join(n.text for n in equality.right)
    off = "arithmetic", f"off by {value - equality.right[0].value:.3g}"
    rule, how = scale_or_sign(value, equality.right, equality.slack) or off
    return Finding(
        rule, "error", "certain", (place,), printed, f"{value:.8g}",
        f"{equality.left} = {value:.8g}, printed as {printed}: {how}", {"value": value, "formula": equality.left},
    )  # fmt: skip
