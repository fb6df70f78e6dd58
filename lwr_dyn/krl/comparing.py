"""Compares two files, or two folders file by file: the values of a `.dat`, the statements of a `.src` by routine.

Comments and layout do not count.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from difflib import SequenceMatcher
from pathlib import Path
from typing import Annotated

import numpy as np

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import DECLARATIONS
from lwr_dyn.krl.language.declarations import Declaration, Def, Header
from lwr_dyn.krl.language.lexer import LineError, tokens_of
from lwr_dyn.krl.language.source import SourceFile, data_beside, krl_files, read_source
from lwr_dyn.krl.language.unparse import expression_text, statement_text
from lwr_dyn.krl.robot.kuka_pose import rotation_angle, rotation_of_abc

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
class AxisChange:
    """An axis of a point that moved."""

    axis: str
    change: Annotated[float, "Later minus earlier [deg, mm]."]


@dataclass(frozen=True, slots=True)
class PointChange:
    """A pose or axes that changed: by how much, its line in the later file."""

    name: str
    line: int
    moved_mm: Annotated[float | None, "[mm] null where it is not a pose."]
    turned_deg: Annotated[float | None, "[deg]"]
    axes_deg: Annotated[tuple[AxisChange, ...], "Axes that changed."]
    others: Annotated[tuple[str, ...], "What else of it changed, such as Status and Turn."]

    @property
    def text(self) -> str:
        """In one line."""
        parts = [] if self.moved_mm is None else [f"moved {self.moved_mm:.3f} mm"]
        parts += [] if self.turned_deg is None else [f"turned {self.turned_deg:.3f} deg"]
        parts += [f"{x.axis} by {x.change:+.3f}" for x in self.axes_deg]
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


def meaning_of(code: str) -> str:
    """Code in a form in which lines that mean the same are equal: 1.50 is 1.5, and case counts in strings only."""
    try:
        tokens = tokens_of(code)[0]
    except LineError:
        return code.strip()
    return " ".join(
        repr(float(x.text)) if x.kind in ("INTEGER", "DECIMAL") else x.text if x.kind == "STRING" else x.text.upper()
        for x in tokens
    )


def point_change(a: FileValue, b: FileValue) -> PointChange | None:
    """How a pose or a position of axes changed; None for other values."""
    before, after = _numbers(a.value), _numbers(b.value)
    if before is None or after is None or not _is_place(before) or not _is_place(after):
        return None
    (x0, x1), (abc0, abc1) = ([_floats(parts, names) for parts in (before, after)] for names in ("XYZ", "ABC"))
    moved = None if x0 is None or x1 is None else float(np.linalg.norm(np.subtract(x1, x0)))
    rotations = None if abc0 is None or abc1 is None else (rotation_of_abc(abc0), rotation_of_abc(abc1))
    turned = None if rotations is None else float(np.degrees(rotation_angle(*rotations)))
    axes: list[AxisChange] = []
    others: list[str] = []
    for name in dict.fromkeys([*before, *after]):
        x, y = before.get(name), after.get(name)
        if x == y or (name in "XYZ" and moved is not None) or (name in "ABC" and turned is not None):
            continue
        if name in _AXES and isinstance(x, float) and isinstance(y, float):
            axes.append(AxisChange(name, y - x))
        else:
            others.append(f"{name} {_shown(x)} -> {_shown(y)}")
    return PointChange(b.name, b.line, moved, turned, tuple(axes), tuple(others))


def _is_place(parts: Mapping[str, float | str]) -> bool:
    return all(x in parts for x in "XYZ") or any(x in parts for x in _AXES[:6])


def _numbers(value: e.Expression | None) -> dict[str, float | str] | None:
    """The components of an aggregate, numbers where they are numbers."""
    if not isinstance(value, e.Aggregate):
        return None
    return {item.name.upper(): _number(item.value) for item in value.items if item.indices is None}


def _number(x: e.Expression) -> float | str:
    value = None if isinstance(x, e.Integer) and x.base != 10 else e.number_of(x)
    return expression_text(x) if value is None else float(value)


def _floats(parts: Mapping[str, float | str], names: str) -> list[float] | None:
    """The components of these names; None where one is missing or no number."""
    found = [x for x in map(parts.get, names) if isinstance(x, float)]
    return found if len(found) == len(names) else None


def _shown(x: float | str | None) -> str:
    return "nothing" if x is None else x if isinstance(x, str) else f"{x:g}"


BEFORE_ROUTINES = "(before the first routine)"


@dataclass(frozen=True, slots=True)
class CodeLine:
    """A statement: its line (from 1) and its text."""

    line: int
    text: str


@dataclass(frozen=True, slots=True)
class RoutineChange:
    """Pieces of a routine, the lines removed and those added in each; `kind` is changed, added or removed."""

    routine: str
    kind: str
    pieces: tuple[tuple[tuple[CodeLine, ...], tuple[CodeLine, ...]], ...]


def routine_changes(before: SourceFile, after: SourceFile) -> list[RoutineChange]:
    """What differs, in the order of the later file; removed routines last."""
    old, new = code_of(before), code_of(after)
    out = []
    for name, lines in new.items():
        if name not in old:
            out.append(RoutineChange(name, "added", (((), tuple(lines)),)))
        elif pieces := _pieces(old[name], lines):
            out.append(RoutineChange(name, "changed", pieces))
    return out + [RoutineChange(name, "removed", ((tuple(old[name]), ()),)) for name in old if name not in new]


def code_of(file: SourceFile) -> dict[str, list[CodeLine]]:
    """The statements of each routine, by its name in capitals."""
    routines: dict[str, list[CodeLine]] = {}
    name = BEFORE_ROUTINES
    for i, line in enumerate(file.lines, 1):
        if isinstance(line.statement, Header) or (line.statement is None and line.readable):
            continue
        if isinstance(line.statement, Def):
            name = line.statement.name.upper()
        text = line.text().strip() if line.statement is None else statement_text(line.statement)
        routines.setdefault(name, []).append(CodeLine(i, text))
    return routines


def _pieces(a: list[CodeLine], b: list[CodeLine]) -> tuple[tuple[tuple[CodeLine, ...], tuple[CodeLine, ...]], ...]:
    matcher = SequenceMatcher(None, [meaning_of(x.text) for x in a], [meaning_of(x.text) for x in b])
    differing = [op for op in matcher.get_opcodes() if op[0] != "equal"]
    return tuple((tuple(a[i:j]), tuple(b[k:m])) for _, i, j, k, m in differing)


_SETTINGS = frozenset({"MADA", "SYSTEM", "STEU"})
"""Folders of a backup that hold its configuration."""


@dataclass(frozen=True, slots=True)
class ValueChange:
    """A name with another value."""

    name: str
    before: Annotated[str | None, "Null where it was added."]
    after: Annotated[str | None, "Null where it was removed."]


@dataclass(frozen=True, slots=True)
class FileComparison:
    """How a file differs; `kind` is changed, added, removed, layout (comments and spaces only) or same."""

    name: str
    kind: str
    configuration: bool
    points: tuple[PointChange, ...] = ()
    values: tuple[ValueChange, ...] = ()
    routines: tuple[RoutineChange, ...] = ()


def compare(before: str | Path, after: str | Path) -> list[FileComparison]:
    """Of two files (a `.src` with the `.dat` beside it) or two folders, all their files that are in either.

    Raises `FileAccessError`.
    """
    return [_compared(name, a, b) for name, a, b in _pairs(Path(before), Path(after))]


def _pairs(before: Path, after: Path) -> Iterator[tuple[str, Path | None, Path | None]]:
    if before.is_dir() and after.is_dir():
        yield from _pairs_of_folders(before, after)
        return
    for path in (before, after):
        if path.is_dir():
            raise FileAccessError(str(path), "a folder beside a file", "two files, or two folders")
    (a,), (b,) = krl_files(before), krl_files(after)
    yield b.name, a, b
    beside = [data_beside(path) for path in (a, b)]
    if beside != [None, None]:
        yield next(x.name for x in reversed(beside) if x is not None), beside[0], beside[1]


def _pairs_of_folders(before: Path, after: Path) -> Iterator[tuple[str, Path | None, Path | None]]:
    """By path in any case; files that moved by their name, where only one of that name is left on each side."""
    old, new = ({str(p.relative_to(top)).lower(): p for p in krl_files(top)} for top in (before, after))
    alone_old = [p for key, p in old.items() if key not in new]
    alone_new = [p for key, p in new.items() if key not in old]
    moved: dict[Path, Path] = {}
    for path in alone_new:
        same = [x for x in alone_old if x.name.lower() == path.name.lower()]
        if len(same) == 1 and sum(x.name.lower() == path.name.lower() for x in alone_new) == 1:
            moved[path] = same[0]
    for key, path in new.items():
        yield str(path.relative_to(after)), old.get(key) or moved.get(path), path
    for path in alone_old:
        if path not in moved.values():
            yield str(path.relative_to(before)), path, None


def _compared(name: str, a: Path | None, b: Path | None) -> FileComparison:
    configuration = name.rpartition("/")[2].startswith("$") or not _SETTINGS.isdisjoint(Path(name.upper()).parts)
    if a is None or b is None:
        return FileComparison(name, "added" if a is None else "removed", configuration)
    before, after = read_source(a)[0], read_source(b)[0]
    if before.to_bytes() == after.to_bytes():
        return FileComparison(name, "same", configuration)
    points, values = _value_changes(before, after) if after.is_data else ([], [])
    routines = [] if after.is_data else routine_changes(before, after)
    kind = "changed" if points or values or routines else "layout"
    return FileComparison(name, kind, configuration, tuple(points), tuple(values), tuple(routines))


def _value_changes(before: SourceFile, after: SourceFile) -> tuple[list[PointChange], list[ValueChange]]:
    old, new = file_values(before), file_values(after)
    points: list[PointChange] = []
    values: list[ValueChange] = []
    for key, b in new.items():
        a = old.get(key)
        if a is None:
            values.append(ValueChange(b.name, None, b.text))
        elif [meaning_of(a.text), meaning_of(a.type or "")] != [meaning_of(b.text), meaning_of(b.type or "")]:
            _add_change(a, b, points, values)
    gone = [ValueChange(a.name, a.text, None) for key, a in old.items() if key not in new]
    return points, values + gone


def _add_change(a: FileValue, b: FileValue, points: list[PointChange], values: list[ValueChange]) -> None:
    change = point_change(a, b) if a.type == b.type else None
    if change is None:
        typed = a.type != b.type and a.value is not None
        values.append(
            ValueChange(b.name, f"{a.type} {a.text}" if typed else a.text, f"{b.type} {b.text}" if typed else b.text)
        )
    elif change.others or change.axes_deg or (change.moved_mm or 0) > SAME_MM or (change.turned_deg or 0) > SAME_DEG:
        points.append(change)
