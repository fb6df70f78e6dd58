"""`lwr-dyn krl diff`: what two states of a program or a backup differ in."""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Annotated, Any, TypedDict

import click

from lwr_dyn.cli.options import show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.progress import progress
from lwr_dyn.krl.comparing import CodeLine, FileComparison, PointChange, ValueChange, compare


@click.command("diff")
@click.argument("before")
@click.argument("after")
@with_shared("--json as_json")
def diff(before: str, after: str, as_json: bool) -> None:
    """Compare two files (a .src with its .dat) or two backups: points moved, values, logic; exit 1 where they differ.

    Layout, comments and the case of names do not count, 1.50 is 1.5. Files are paired by their paths, moved ones by
    their names.
    """
    with progress("comparing"):
        files = compare(before, after)
    same = not any(file.kind in ("changed", "added", "removed") for file in files)
    show(_document(files, same), as_json)
    sys.exit(0 if same else 1)


class RoutineRecord(TypedDict):
    """A routine whose logic changed."""

    routine: str
    kind: Annotated[str, "changed, added or removed."]
    removed: list[CodeLine]
    added: list[CodeLine]


class ChangedFileRecord(TypedDict):
    """A file of either state."""

    file: str
    kind: Annotated[str, "changed, added, removed, or layout: only comments and layout differ."]
    configuration: Annotated[bool, "Whether it is no program."]
    points: list[PointChange]
    values: list[ValueChange]
    routines: list[RoutineRecord]


def _document(files: Sequence[FileComparison], same: bool) -> Document:
    counts = _summary(files)
    return Document("", "", [Section("", [
        Fact("same", same, "Whether nothing but layout and comments differs; the exit code is 0 then."),
        Note([line for file in files for line in _lines(file)]),
        Note(", ".join(f"{what} {count}" for what, count in counts.items() if count) or "no file differs"),
        Fact("summary", counts, "How many of each kind."),
        Fact(
            "files", [_record(x) for x in files if x.kind != "same"], "Those that differ.", kind=list[ChangedFileRecord]
        ),
    ])], "lwr-dyn krl diff")  # fmt: skip


def _summary(files: Sequence[FileComparison]) -> dict[str, int]:
    def count(kind: str) -> int:
        return sum(file.kind == kind for file in files)

    programs = [file for file in files if not file.configuration]
    return {
        "files changed": count("changed"), "files added": count("added"), "files removed": count("removed"),
        "in layout only": count("layout"), "points moved": sum(len(x.points) for x in programs),
        "values changed": sum(len(x.values) for x in programs), "routines changed": sum(len(x.routines) for x in files),
        "of the configuration": sum(len(x.points) + len(x.values) for x in files if x.configuration),
        "same": count("same"),
    }  # fmt: skip


def _lines(file: FileComparison) -> Iterator[str]:
    if file.kind == "same":
        return
    what = {"layout": "only comments and layout differ"}.get(file.kind, file.kind)
    yield f"{file.name}: {what}{' (configuration)' if file.configuration else ''}"
    for point in file.points:
        yield f"  {point.name}, line {point.line}: {point.text}"
    for value in file.values:
        if value.before is None or value.after is None:
            verb, text = ("added", value.after) if value.before is None else ("removed", value.before)
            yield f"  {value.name} {verb}: {text}"
        else:
            yield f"  {value.name}: {value.before} -> {value.after}"
    for routine in file.routines:
        yield f"  {routine.routine}: {routine.kind}"
        if routine.kind == "changed":
            for old, new in routine.pieces:
                yield from (f"    - {x.line}: {x.text}" for x in old)
                yield from (f"    + {x.line}: {x.text}" for x in new)


def _record(file: FileComparison) -> dict[str, Any]:
    routines = [
        {"routine": r.routine, "kind": r.kind, "removed": [asdict(x) for old, _ in r.pieces for x in old],
         "added": [asdict(x) for _, new in r.pieces for x in new]}
        for r in file.routines
    ]  # fmt: skip
    points, values = (list(map(asdict, found)) for found in (file.points, file.values))
    return {
        "file": file.name, "kind": file.kind, "configuration": file.configuration, "points": points,
        "values": values, "routines": routines,
    }  # fmt: skip
