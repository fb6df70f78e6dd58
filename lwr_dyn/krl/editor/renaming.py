"""Another name for what the program declares: all its places, or the sentence that says why it keeps its name.

A rename is only made where it is proven: with the new texts, the places that mean the same are the old ones.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import PurePosixPath

from lwr_dyn.krl.checks.global_names import repeated_globals
from lwr_dyn.krl.diagnostics import SourcePosition
from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.referents import LineContext, Referent, line_context, unresolved
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.layout import inline_forms
from lwr_dyn.krl.language.lexer import KEYWORDS
from lwr_dyn.krl.names.known_names import GEOMETRY, SIMPLE
from lwr_dyn.krl.project.program import Scope

LONGEST = 24
"""Characters of a name on the controller."""
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_$]*")
_TYPES = frozenset({*SIMPLE, *GEOMETRY})


class KeptNameError(Exception):
    """A name cannot be changed: the sentence says why. Used inside this package only."""


@dataclass(frozen=True, slots=True, eq=False)
class RenamableName:
    """What stands at a place and may have another name; `start` is the column (from 1) at which its name begins."""

    context: LineContext
    referent: Referent
    start: int


def renamable(project: EditedProject, file: str, line: int, column: int) -> RenamableName:
    """What stands at a line (from 0) and column (from 1).

    Raises `KeptNameError` where it cannot have another name.
    """
    found = project.at(file, line, column)
    if found is None:
        raise KeptNameError("no name that the program declares stands here")
    context, token, referent = found
    if referent.position is None:
        raise KeptNameError(f"{referent.name} comes with the controller or an option, and keeps its name")
    routine = referent.declared
    if isinstance(routine, Routine) and routine.name == PurePosixPath(routine.file.name).stem.upper():
        raise KeptNameError(f"{referent.name} is the name of {routine.file.name}: rename the .src, its .dat and DEFDAT")
    if referent.meaning == "constant" and len(_owners(context.scope, referent.name)) > 1:
        raise KeptNameError(f"#{referent.name} belongs to several ENUMs; which one is meant is not written here")
    return RenamableName(context, referent, token.column + len(token.text) - len(referent.name))


def renamed(project: EditedProject, name: RenamableName, new: str) -> list[SourcePosition]:
    """The places where the new name is written in the place of the old one.

    Raises `KeptNameError` where a name is none, is taken, or one of the places must not be changed.
    """
    context, found = name.context, name.referent
    _check_spelling(new)
    uses = project.uses(found)
    if new.upper() != found.name.upper():
        _check_taken(project, found, new, uses)
        _check_uses(project, found)
    _check_inline_forms(project, found, uses)
    after = project.with_texts(_texts(project, found.name, new, uses))
    shift = len(new) - len(found.name)
    here = context.file.file.position(context.line, name.start)
    moved = _moved([here], uses, shift)[0]
    meant = after.at(moved.file, context.line, moved.column)
    if meant is None or set(after.uses(meant[2])) != set(_moved(uses, uses, shift)):
        raise KeptNameError(f"with the name {new}, some places would mean something else than {found.name} does")
    return uses


def _check_spelling(new: str) -> None:
    if _NAME.fullmatch(new) is None:
        raise KeptNameError(f"{new!r} is no name: letters, digits and _, no digit first, $ is the controller's")
    if len(new) > LONGEST:
        raise KeptNameError(f"{new} has {len(new)} characters; at most {LONGEST} are allowed")
    if new.upper() in KEYWORDS:
        raise KeptNameError(f"{new} is a keyword")


def _check_taken(project: EditedProject, found: Referent, new: str, uses: Iterable[SourcePosition]) -> None:
    for place in uses:
        scope = _context(project, place).scope
        if _is_taken(scope, found, new.upper()):
            raise KeptNameError(f"{new} is taken, as {place.file} sees it in line {place.line}")
    if not found.owner:
        for at in project.undeclared(new):
            raise KeptNameError(f"{new} is used in {at.file}, line {at.line}, where nothing declares it")


def _check_uses(project: EditedProject, found: Referent) -> None:
    """Whether it is certain which places mean the name."""
    assert found.position is not None
    for twice in repeated_globals(project.program(found.position.file)):
        if twice.position == found.position:
            raise KeptNameError(f"{twice.message}: which of them a use means is not certain, rename by hand")
    if found.owner:
        for file in project.project.files:
            for i in unresolved(project.program(file.file.name), file, found):
                where = f"{file.file.name}, line {i + 1}"
                raise KeptNameError(f"{where} may mean this {found.name} or another: its type is not known here")


def _is_taken(scope: Scope, found: Referent, key: str) -> bool:
    """Whether a name in capitals means something already, beside what is renamed."""
    if found.meaning == "component":
        return key in (scope.structure(found.owner) or {})
    if found.meaning == "constant":
        return bool(_owners(scope, key))
    if found.meaning == "label":
        return scope.routine is not None and key in scope.routine.labels
    known = scope.known
    of_controller = (known.variables, known.functions, known.structures, known.enums, _TYPES)
    declared = (getattr(x, kind) for x in scope.tables for kind in ("variables", "routines", "types", "externals"))
    return any(key in x for x in (*of_controller, *declared))


def _owners(scope: Scope, name: str) -> set[str]:
    """The enumerations that have a constant."""
    tables = (*(x.enums for x in scope.tables), scope.known.enums)
    return {enum for table in tables for enum, members in table.items() if name.upper() in members}


def _check_inline_forms(project: EditedProject, found: Referent, uses: Iterable[SourcePosition]) -> None:
    kept: dict[str, list[bool]] = {}
    for place in uses:
        if place.file not in kept:
            kept[place.file] = list(inline_forms(project.project.file(place.file).file))
        if kept[place.file][place.line - 1]:
            where = f"{place.file}, line {place.line}"
            raise KeptNameError(f"an inline form holds {found.name} ({where}): change it on the teach pendant")


def _context(project: EditedProject, place: SourcePosition) -> LineContext:
    return line_context(project.program(place.file), project.project.file(place.file), place.line - 1)


def _texts(project: EditedProject, old: str, new: str, uses: Iterable[SourcePosition]) -> dict[str, str]:
    """The changed files, as text."""
    by_file: dict[str, dict[int, list[int]]] = {}
    for place in uses:
        by_file.setdefault(place.file, {}).setdefault(place.line - 1, []).append(place.column - 1)
    out = {}
    for name, changed in by_file.items():
        lines = project.project.file(name).file.lines
        texts = (_line(x.shown, changed.get(i, ()), len(old), new) + x.end for i, x in enumerate(lines))
        out[name] = "".join(texts)
    return out


def _line(text: str, columns: Iterable[int], length: int, new: str) -> str:
    for at in sorted(columns, reverse=True):
        text = text[:at] + new + text[at + length :]
    return text


def _moved(places: Iterable[SourcePosition], uses: Iterable[SourcePosition], shift: int) -> list[SourcePosition]:
    """Where places stand after the change: names before them on their line are `shift` characters longer."""
    columns: dict[tuple[str, int], list[int]] = {}
    for x in uses:
        columns.setdefault((x.file, x.line), []).append(x.column)
    out = []
    for x in places:
        before = sum(column < x.column for column in columns.get((x.file, x.line), ()))
        out.append(SourcePosition(x.file, x.line, x.column + shift * before))
    return out
