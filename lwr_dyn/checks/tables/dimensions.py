"""Units as text, their dimensions, and the dimension of a formula."""

import ast
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from lwr_dyn.checks.tables.arithmetic import GIVES_ANGLE, name_of

Powers = tuple[float, float, float, float]
"""Of metre, kilogram, second, radian."""
NUMBER: Powers = (0.0, 0.0, 0.0, 0.0)
_BASE: dict[str, tuple[Powers, float]] = {
    "m": ((1, 0, 0, 0), 1.0), "mm": ((1, 0, 0, 0), 1e-3), "cm": ((1, 0, 0, 0), 1e-2), "um": ((1, 0, 0, 0), 1e-6),
    "km": ((1, 0, 0, 0), 1e3), "kg": ((0, 1, 0, 0), 1.0), "g": ((0, 1, 0, 0), 1e-3), "t": ((0, 1, 0, 0), 1e3),
    "s": ((0, 0, 1, 0), 1.0), "ms": ((0, 0, 1, 0), 1e-3), "min": ((0, 0, 1, 0), 60.0), "h": ((0, 0, 1, 0), 3600.0),
    "rad": ((0, 0, 0, 1), 1.0), "mrad": ((0, 0, 0, 1), 1e-3), "deg": ((0, 0, 0, 1), math.pi / 180),
    "rev": ((0, 0, 0, 1), 2 * math.pi), "rpm": ((0, 0, -1, 1), math.pi / 30), "Hz": ((0, 0, -1, 0), 1.0),
    "N": ((1, 1, -2, 0), 1.0), "mN": ((1, 1, -2, 0), 1e-3), "kN": ((1, 1, -2, 0), 1e3), "Nm": ((2, 1, -2, 0), 1.0),
    "J": ((2, 1, -2, 0), 1.0), "W": ((2, 1, -3, 0), 1.0), "1": (NUMBER, 1.0), "": (NUMBER, 1.0), "%": (NUMBER, 1e-2),
}  # fmt: skip
_OTHER = str.maketrans({"\N{MIDDLE DOT}": " ", "*": " ", "\N{SUPERSCRIPT TWO}": "2", "\N{SUPERSCRIPT THREE}": "3",
                        "\N{DEGREE SIGN}": "deg", "[": "", "]": ""})  # fmt: skip


@dataclass(frozen=True, slots=True)
class Unit:
    """Powers of the base units, and the factor to SI."""

    powers: Powers
    factor: float

    @property
    def without_angle(self) -> Powers:
        """The powers with the radian as a number: N m/rad is N m."""
        return (*self.powers[:3], 0.0)


def unit_of(text: str) -> Unit | None:
    """The unit that a text names; None for an unknown one.

    >>> unit_of("N m/(rad s)").powers, unit_of("kg mm^2").factor.__round__(9), unit_of("furlong") is None
    ((2.0, 1.0, -3.0, -1.0), 1e-06, True)
    """
    if len(text) > 40:
        return None
    over, *under = re.sub(r"[()]", " ", text.translate(_OTHER)).split("/")
    powers, factor = list(NUMBER), 1.0
    for sign, part in [(1.0, over), *((-1.0, u) for u in under)]:
        for word in part.split():
            factors = _word(word)
            if factors is None:
                return None
            (base, size), power = factors
            powers = [p + sign * power * b for p, b in zip(powers, base, strict=True)]
            factor *= size ** (sign * power)
    return Unit((powers[0], powers[1], powers[2], powers[3]), factor)


def _word(word: str) -> tuple[tuple[Powers, float], float] | None:
    """A base unit and its power: "mm^2", "s-1", "m2", "rad"."""
    match = re.fullmatch(r"([A-Za-z%]+|1)\^?(-?\d)?", word)
    if not match or match.group(1) not in _BASE:
        return None
    return _BASE[match.group(1)], float(match.group(2) or 1)


class UnlikeError(Exception):
    """Incompatible dimensions in a formula; used inside this package only."""


def dimension_of(node: ast.expr, names: Mapping[str, Powers]) -> Powers | None:
    """The dimension of a formula with radians as numbers; None where a power is not a plain number.

    Raises `UnlikeError` for a sum, or a function, of incompatible dimensions.
    """
    if isinstance(node, ast.Constant):
        return NUMBER
    if isinstance(node, ast.UnaryOp):
        return dimension_of(node.operand, names)
    if isinstance(node, ast.BinOp):
        return _binary(node, names)
    if isinstance(node, ast.Call):
        return _called(node, names)
    return names.get(name_of(node) or "")


def _binary(node: ast.BinOp, names: Mapping[str, Powers]) -> Powers | None:
    a, b = dimension_of(node.left, names), dimension_of(node.right, names)
    if isinstance(node.op, ast.Pow):
        power = node.right.value if isinstance(node.right, ast.Constant) else None
        return None if a is None or not isinstance(power, int | float) else _times(NUMBER, a, float(power))
    if a is None or b is None:
        return None
    if isinstance(node.op, ast.Add | ast.Sub):
        if a != b:
            raise UnlikeError(f"{in_words(a)} and {in_words(b)} are added")
        return a
    return _times(a, b, 1.0 if isinstance(node.op, ast.Mult) else -1.0)


def _called(node: ast.Call, names: Mapping[str, Powers]) -> Powers | None:
    name = name_of(node.func)
    inner = [dimension_of(a, names) for a in node.args]
    if None in inner or not inner:
        return None
    first = inner[0] or NUMBER
    if name in ("hypot", "atan2") and any(i != first for i in inner):
        raise UnlikeError(f"{name} of {' and '.join(in_words(i or NUMBER) for i in inner)}")
    if name == "sqrt":
        return _times(NUMBER, first, 0.5)
    if name in ("abs", "hypot"):
        return first
    if name not in GIVES_ANGLE[-1:] and first != NUMBER:
        raise UnlikeError(f"{name} of {in_words(first)}")
    return NUMBER


def _times(a: Powers, b: Powers, power: float) -> Powers:
    x = [p + power * q for p, q in zip(a, b, strict=True)]
    return (x[0], x[1], x[2], x[3])


def in_words(powers: Powers) -> str:
    """Powers as a unit.

    >>> in_words((2.0, 1.0, -2.0, 0.0))
    'm^2 kg s^-2'
    """
    parts = [n if p == 1 else f"{n}^{p:g}" for n, p in zip(("m", "kg", "s", "rad"), powers, strict=True) if p]
    return " ".join(parts) or "1"
