"""Compares two files, or two folders file by file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.krl.comparing.file_logic import RoutineChange, routine_changes
from lwr_dyn.krl.comparing.file_values import (
    SAME_DEG,
    SAME_MM,
    FileValue,
    PointChange,
    file_values,
    point_change,
    same_value,
)
from lwr_dyn.krl.language.folders import krl_files
from lwr_dyn.krl.language.source import SourceFile, read_source

_SETTINGS = frozenset({"MADA", "SYSTEM", "STEU"})
"""Folders of a backup that hold its configuration."""


@dataclass(frozen=True, slots=True)
class ValueChange:
    """A name with another value; None where it is not there."""

    name: str
    before: str | None
    after: str | None


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
    beside = [_data_beside(path) for path in (a, b)]
    if beside != [None, None]:
        yield next(x.name for x in reversed(beside) if x is not None), beside[0], beside[1]


def _data_beside(path: Path) -> Path | None:
    """The `.dat` of a `.src`, its ending in capitals or not."""
    if path.suffix.lower() == ".dat":
        return None
    return next((x for x in (path.with_suffix(".dat"), path.with_suffix(".DAT")) if x.is_file()), None)


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
        elif not same_value(a, b):
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
