"""The names that a `.dat` gives a value, and how two values of one name differ."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import DECLARATIONS
from lwr_dyn.krl.language.declarations import Declaration
from lwr_dyn.krl.language.lexer import LineError, tokens_of
from lwr_dyn.krl.language.source import SourceFile
from lwr_dyn.krl.language.unparse import expression_text, statement_text
from lwr_dyn.krl.robot.kuka_pose import rotation_of_abc

SAME_MM, SAME_DEG = 1e-6, 1e-6
"""A smaller change is none."""
_AXES = tuple(f"{letter}{i}" for letter in "AE" for i in range(1, 7))


@dataclass(frozen=True, slots=True)
class FileValue:
    """A declared name or a target of an assignment: its line (from 1), its declared type and its value, if any."""

    name: str
    line: int
    type: str | None
    value: e.Expression | None

    @property
    def text(self) -> str:
        """The value, or the type where there is none."""
        return (self.type or "") if self.value is None else expression_text(self.value)


@dataclass(frozen=True, slots=True)
class PointChange:
    """A pose or axes that changed: by how much [mm], [deg]; `others` are components such as S with both values."""

    name: str
    line: int
    """In the later file."""
    moved_mm: float | None
    """None where it is not a pose."""
    turned_deg: float | None
    axes_deg: Mapping[str, float]
    """Axis -> later minus earlier [deg, mm]."""
    others: tuple[str, ...]

    @property
    def text(self) -> str:
        """In one line."""
        parts = [] if self.moved_mm is None else [f"moved {self.moved_mm:.3f} mm"]
        parts += [] if self.turned_deg is None else [f"turned {self.turned_deg:.3f} deg"]
        parts += [f"{axis} by {change:+.3f}" for axis, change in self.axes_deg.items()]
        return ", ".join([*parts, *self.others])


def file_values(file: SourceFile) -> dict[str, FileValue]:
    """By name in capitals; where a name has several values, the last one, as the controller reads them."""
    found: dict[str, FileValue] = {}
    for i, line in enumerate(file.lines, 1):
        x = line.statement
        if isinstance(x, Declaration):
            for d in x.names:
                found[d.name.upper()] = FileValue(d.name, i, None if x.type is None else x.type.upper(), d.value)
        elif isinstance(x, s.Assign):
            name = expression_text(x.target)
            found[name.upper()] = FileValue(name, i, None, x.value)
        elif isinstance(x, DECLARATIONS):
            text = statement_text(x)
            found[f"{type(x).__name__} {x.name}".upper()] = FileValue(x.name, i, text, None)
    return found


def same_value(a: FileValue, b: FileValue) -> bool:
    """Whether both mean the same: 1.50 is 1.5, and case counts in strings only."""
    return meaning_of(a.text) == meaning_of(b.text) and meaning_of(a.type or "") == meaning_of(b.type or "")


def meaning_of(code: str) -> str:
    """Code in a form in which lines that mean the same are equal."""
    try:
        tokens = tokens_of(code)[0]
    except LineError:
        return code.strip()
    words = []
    for token in tokens:
        number = token.kind in ("INTEGER", "DECIMAL")
        words.append(
            repr(float(token.text)) if number else token.text if token.kind == "STRING" else token.text.upper()
        )
    return " ".join(words)


def point_change(a: FileValue, b: FileValue) -> PointChange | None:
    """How a pose or a position of axes changed; None for other values."""
    before, after = _numbers(a.value), _numbers(b.value)
    if before is None or after is None or not _is_place(before) or not _is_place(after):
        return None
    moved, turned = _movement(before, after, "XYZ"), None
    if all(name in x for name in "ABC" for x in (before, after)):
        turned = _turn([before[n] for n in "ABC"], [after[n] for n in "ABC"])  # type: ignore[misc]
    axes: dict[str, float] = {}
    others: list[str] = []
    for name in dict.fromkeys([*before, *after]):
        x, y = before.get(name), after.get(name)
        if x == y or (name in "XYZ" and moved is not None) or (name in "ABC" and turned is not None):
            continue
        if name in _AXES and isinstance(x, float) and isinstance(y, float):
            axes[name] = y - x
        else:
            others.append(f"{name} {_shown(x)} -> {_shown(y)}")
    return PointChange(b.name, b.line, moved, turned, axes, tuple(others))


def _is_place(parts: Mapping[str, float | str]) -> bool:
    return all(x in parts for x in "XYZ") or any(x in parts for x in _AXES[:6])


def _numbers(value: e.Expression | None) -> dict[str, float | str] | None:
    """The components of an aggregate, numbers where they are numbers."""
    if not isinstance(value, e.Aggregate):
        return None
    return {item.name.upper(): _number(item.value) for item in value.items if item.indices is None}


def _number(x: e.Expression) -> float | str:
    if isinstance(x, e.Unary) and x.operator in "+-":
        inner = _number(x.operand)
        return inner if isinstance(inner, str) else -inner if x.operator == "-" else inner
    if isinstance(x, e.Integer) and x.base != 10:
        return expression_text(x)
    return float(x.value) if isinstance(x, e.Real | e.Integer) else expression_text(x)


def _movement(a: Mapping[str, float | str], b: Mapping[str, float | str], names: str) -> float | None:
    pairs = [(a.get(n), b.get(n)) for n in names]
    if not all(isinstance(x, float) and isinstance(y, float) for x, y in pairs):
        return None
    return float(np.linalg.norm([y - x for x, y in pairs]))  # type: ignore[operator]


def _turn(a: list[float], b: list[float]) -> float | None:
    """The angle [deg] between two orientations A, B, C [deg]."""
    if not all(isinstance(x, float) for x in (*a, *b)):
        return None
    between = np.linalg.norm(rotation_of_abc(a) - rotation_of_abc(b))
    return float(np.degrees(2.0 * np.arcsin(min(between / np.sqrt(8.0), 1.0))))


def _shown(x: float | str | None) -> str:
    return "nothing" if x is None else x if isinstance(x, str) else f"{x:g}"
