"""Formulas and units as text, evaluated safely: numbers, names, + - * / ^ and some functions; dimensions.

A rule beside them finds units that do not fit the quantity of a column: a joint's error in millimetres, a mass in
metres.
"""

import ast
import math
import operator
import re
import warnings
from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass

from lwr_dyn.checks.tables.sheet import Finding, Sheet, SheetColumn, SheetTable, words_of

LONGEST = 200
"""Characters of a formula."""
LARGEST_POWER = 20.0

FUNCTIONS: dict[str, Callable[..., float]] = {
    "sqrt": math.sqrt, "hypot": math.hypot, "abs": abs, "exp": math.exp, "log": math.log,
    "sin": math.sin, "cos": math.cos, "tan": math.tan,
    "asin": math.asin, "acos": math.acos, "atan": math.atan, "atan2": math.atan2,
}  # fmt: skip
"""What may be called, angles in radians."""

TAKES_ANGLE = ("sin", "cos", "tan")
GIVES_ANGLE = ("asin", "acos", "atan", "atan2")

_OPERATORS: dict[type, Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}

_SIGNS = str.maketrans({"\N{MINUS SIGN}": "-", "\N{MULTIPLICATION SIGN}": "*", "\N{MIDDLE DOT}": "*"})


def parsed(
    text: str, longest: int = LONGEST, functions: Container[str] = FUNCTIONS, indexed: bool = False
) -> ast.expr | None:
    """The formula as a syntax tree; None where the text is no formula or is too long.

    With `indexed` a name may have indices, whole numbers in square brackets: "inertial.com[2,1]".

    >>> value_of(parsed("1/2 x 0.0106 x 0.05^2"), {})
    1.3250000000000002e-05
    >>> parsed("__import__('os')") is None
    True
    """
    bare = re.sub(r"(?<=[\d)\s])[xX](?=[\d(\s])", "*", text.translate(_SIGNS)).replace("^", "**").strip()
    if not bare or len(bare) > longest:
        return None
    try:
        with warnings.catch_warnings():  # "2or 3" makes the parser complain on stderr
            warnings.simplefilter("ignore")
            tree = ast.parse(bare, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    return tree if _known(tree, functions, indexed) else None


def _known(node: ast.expr, functions: Container[str], indexed: bool) -> bool:
    """Only what `value_of` can compute."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int | float) and not isinstance(node.value, bool)
    if isinstance(node, ast.BinOp):
        known = isinstance(node.op, ast.Add | ast.Sub | ast.Mult | ast.Div | ast.Pow)
        return known and _known(node.left, functions, indexed) and _known(node.right, functions, indexed)
    if isinstance(node, ast.UnaryOp):
        return isinstance(node.op, ast.UAdd | ast.USub) and _known(node.operand, functions, indexed)
    if isinstance(node, ast.Call):
        named = isinstance(node.func, ast.Name) and node.func.id in functions and not node.keywords
        return named and all(_known(a, functions, indexed) for a in node.args)
    name = name_of(node)
    return name is not None and (indexed or "[" not in name)


def name_of(node: ast.expr) -> str | None:
    """The dotted name that a node is, such as "table_iv.b", with its indices: "mass_matrix[1,2]"."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Subscript):
        left = name_of(node.value)
        index = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        whole = [x.value for x in index if isinstance(x, ast.Constant) and type(x.value) is int]
        plain = left is not None and "[" not in left and index and len(whole) == len(index)
        return f"{left}[{','.join(map(str, whole))}]" if plain else None
    if isinstance(node, ast.Attribute):
        left = name_of(node.value)
        return None if left is None else f"{left}.{node.attr}"
    return None


def names_in(node: ast.expr) -> Iterator[str]:
    """The names a formula needs, functions left out."""
    name = name_of(node)
    if name is not None:
        yield name
        return
    for part in node.args if isinstance(node, ast.Call) else ast.iter_child_nodes(node):
        if isinstance(part, ast.expr):
            yield from names_in(part)


def value_of(node: ast.expr | None, names: Mapping[str, float], degrees: bool = False) -> float:
    """The value of a formula; NaN for a division by zero, the root of a negative number or an unknown name."""
    try:
        value = _value(node, names, degrees)
        return value if isinstance(value, float | int) and math.isfinite(value) else math.nan
    except (ArithmeticError, ValueError, TypeError, RecursionError, KeyError):
        return math.nan


def _value(node: ast.expr | None, names: Mapping[str, float], degrees: bool) -> float:
    if isinstance(node, ast.Constant):
        return float(node.value)  # type: ignore[arg-type] # `_known` let only numbers pass
    if isinstance(node, ast.UnaryOp):
        inner = _value(node.operand, names, degrees)
        return -inner if isinstance(node.op, ast.USub) else inner
    if isinstance(node, ast.BinOp):
        left, right = _value(node.left, names, degrees), _value(node.right, names, degrees)
        if isinstance(node.op, ast.Pow):
            return float(left**right) if abs(right) <= LARGEST_POWER else math.nan
        return _OPERATORS[type(node.op)](left, right)
    if isinstance(node, ast.Call):
        return _call(node, names, degrees)
    return names[name_of(node) or ""] if node is not None else math.nan


def _call(node: ast.Call, names: Mapping[str, float], degrees: bool) -> float:
    name = name_of(node.func) or ""
    values = [_value(a, names, degrees) for a in node.args]
    if degrees and name in TAKES_ANGLE:
        values = [math.radians(v) for v in values]
    out = FUNCTIONS[name](*values)
    return math.degrees(out) if degrees and name in GIVES_ANGLE else float(out)


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

_WORD = re.compile(r"([A-Za-z%]+|1)\^?(-?\d)?")
"""A base unit and its power: "mm^2", "s-1", "m2", "rad"."""

_OTHER = str.maketrans({"\N{MIDDLE DOT}": " ", "*": " ", "\N{SUPERSCRIPT TWO}": "2", "\N{SUPERSCRIPT THREE}": "3",
                        "\N{DEGREE SIGN}": "deg", "[": "", "]": ""})  # fmt: skip


@dataclass(frozen=True, slots=True)
class Unit:
    """Powers of the base units, and the factor to SI."""

    powers: Powers
    factor: float


def unit_of(text: str) -> Unit | None:
    """The unit that a text names; None for an unknown one.

    >>> unit_of("N m/(rad s)").powers, unit_of("kg mm^2").factor.__round__(9), unit_of("furlong") is None
    ((2.0, 1.0, -3.0, -1.0), 1e-06, True)
    """
    if len(text) > 40:
        return None
    over, *under = re.sub(r"[()]", " ", text.translate(_OTHER)).split("/")
    powers, factor = NUMBER, 1.0
    for sign, part in [(1.0, over), *((-1.0, u) for u in under)]:
        for word in part.split():
            match = _WORD.fullmatch(word)
            if not match or match[1] not in _BASE:
                return None
            (base, size), power = _BASE[match[1]], sign * float(match[2] or 1)
            powers, factor = _times(powers, base, power), factor * size**power
    return Unit(powers, factor)


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


QUANTITIES: dict[str, tuple[str, ...]] = {
    "mass": ("kg",), "masses": ("kg",), "weight": ("kg", "N"), "payload": ("kg",),
    "inertia": ("kg m^2",), "armature": ("kg m^2", "kg"), "torque": ("N m",), "effort": ("N m", "N"), "force": ("N",),
    "length": ("m",), "distance": ("m",), "radius": ("m",), "height": ("m",), "reach": ("m",),
    "com": ("m",), "angle": ("rad",), "alpha": ("rad",), "theta": ("rad",), "roll": ("rad",), "yaw": ("rad",),
    "time": ("s",), "duration": ("s",), "gravity": ("m/s^2",), "ratio": ("1",),
    "velocity": ("m/s", "rad/s"), "speed": ("m/s", "rad/s"), "acceleration": ("m/s^2", "rad/s^2"),
    "stiffness": ("N/m", "N m/rad"), "damping": ("N s/m", "N m s/rad"),
}  # fmt: skip
"""Word of a heading -> the units of what it names; the last such word of a heading counts."""

ERRORS = ("error", "errors", "err", "deviation")
_ALONG, _AROUND = (1.0, 0.0), (0.0, 1.0)
"""Powers of metre and radian of an error along and around a joint."""
ANGULAR_ALONE = {"rad", "rad/s", "rad/s^2"}
"""Units that differ from a number by the radian alone."""


def unit_sense(sheet: Sheet) -> Iterator[Finding]:
    """Rule 9: a column whose unit is not one of its quantity."""
    for table in sheet.tables:
        errors: dict[str, list[SheetColumn]] = {}
        for column in (*table.columns, *table.values.values()):
            if column.unit and _is_error_of_joints(table, column):
                errors.setdefault(column.unit, []).append(column)
            elif column.unit:
                yield from _quantity(table, column)
        for unit, columns in errors.items():
            yield from _joint_errors(table, unit, columns)


def _is_error_of_joints(table: SheetTable, column: SheetColumn) -> bool:
    """The heading or the table's title contains a word for errors, and the rows are joints."""
    words = {*words_of(column.group or column.name), *words_of(table.where)}
    labelled = any({"joint", "joints"} & set(words_of(c.name)) for c in table.columns if c is not column)
    return bool(words & set(ERRORS)) and (bool(table.declared.joints) or labelled) and column.numeric


def _joint_errors(table: SheetTable, text: str, columns: list[SheetColumn]) -> Iterator[Finding]:
    unit, sliding, known = unit_of(text), table.declared.joints == "prismatic", bool(table.declared.joints)
    if unit is None or unit.powers[1] or (unit.powers[0], unit.powers[3]) not in (_ALONG, _AROUND):
        return
    if (unit.powers[0], unit.powers[3]) == (_ALONG if sliding else _AROUND):
        return
    right = text.replace("rad", "m") if sliding else text.replace("mm", "mrad") if "mm" in text else "rad or deg"
    why = "these joints slide" if sliding else "these joints turn" if known else "right for joints that slide only"
    cells = tuple(f"{table.name}, {column.name}" for column in columns)
    yield Finding(
        "unit", "error" if known else "warning", "certain" if known else "likely", cells, text, right,
        f"errors of joints are given in {text}: {why}, so {right} is expected",
        {"powers": list(unit.powers)}, f"{table.name}, {', '.join(c.name for c in columns)}",
    )  # fmt: skip


def _quantity(table: SheetTable, column: SheetColumn) -> Iterator[Finding]:
    words = [w for w in words_of(column.group or column.name) if w in QUANTITIES]
    unit = unit_of(column.unit)
    if not words or unit is None or unit.powers == NUMBER:  # a share or a count of anything has the unit 1
        return
    allowed = QUANTITIES[words[-1]]
    if any(_fits(unit.powers, text) for text in allowed):
        return
    yield Finding(
        "unit", "error", "likely", (f"{table.name}, {column.name}",), column.unit, " or ".join(allowed),
        f"{column.name} is given in {column.unit} ({in_words(unit.powers)}); {words[-1]}: {' or '.join(allowed)}",
        {"powers": list(unit.powers)},
    )  # fmt: skip


def _fits(powers: Powers, text: str) -> bool:
    wanted = unit_of(text)
    if wanted is None:
        return False
    if text in ANGULAR_ALONE or (powers[3] and not any(powers[:2])):
        return powers == wanted.powers
    return powers[:3] == wanted.powers[:3]
