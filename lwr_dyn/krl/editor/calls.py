"""Calls: that in which the cursor stands with its parameters, who calls a routine, and whom it calls."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from lwr_dyn.krl.checks.type_check import taken_by
from lwr_dyn.krl.diagnostics import SourcePosition
from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.referents import LineContext, Referent, line_context, named_in
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.declarations import Parameter
from lwr_dyn.krl.language.lexer import LineError, Token, tokens_of
from lwr_dyn.krl.names.known_names import Type
from lwr_dyn.krl.project.program import Scope

_OPENING, _CLOSING = ("_LPAR", "_LSQB", "BRACE"), ("_RPAR", "_RSQB", "_RBRACE")


@dataclass(frozen=True, slots=True)
class OpenCall:
    """A call that is being written: its parameters as text, and which of them comes next (from 0)."""

    name: str
    parameters: tuple[str, ...]
    at: int
    types: tuple[Type, ...] = ()

    @property
    def label(self) -> str:
        """`NAME(INT A:IN, REAL B:OUT)`."""
        return f"{self.name}({', '.join(self.parameters)})"

    @property
    def type(self) -> Type | None:
        """Of the parameter that comes next, where it is known."""
        return self.types[self.at] if self.at < len(self.types) else None


def open_call(context: LineContext, column: int) -> OpenCall | None:
    """The innermost call whose bracket is open before a column (from 0) of a line; None where there is none."""
    try:
        tokens, comment = tokens_of(context.text[:column])
    except LineError:
        return None
    return None if comment is not None else called_at(context.scope, tokens)


def called_at(scope: Scope, tokens: Sequence[Token]) -> OpenCall | None:
    """The innermost call whose bracket is open after these words; None where there is none."""
    closed = commas = 0
    for i in range(len(tokens) - 1, 0, -1):
        kind = tokens[i].kind
        if kind in _CLOSING:
            closed += 1
        elif kind in _OPENING and closed:
            closed -= 1
        elif kind in _OPENING:
            return _call(scope, tokens, i, commas)
        elif kind == "_COMMA" and not closed:
            commas += 1
    return None


def _call(scope: Scope, tokens: Sequence[Token], i: int, at: int) -> OpenCall | None:
    name = tokens[i - 1]
    if tokens[i].kind != "_LPAR" or name.kind != "NAME":
        return called_at(scope, tokens[:i])
    found = _parameters(scope, name.text)
    if found is None:
        return None
    texts, types = found
    return OpenCall(name.text, texts, at, types)


def _parameters(scope: Scope, name: str) -> tuple[tuple[str, ...], tuple[Type, ...]] | None:
    """The parameters of a subprogram as text, and their types."""
    routine, external = scope.program.routine(name), scope.external(name)
    if routine is not None:
        types = tuple(x.type for x in taken_by(routine))
        return tuple(map(_text, types, routine.head.parameters)), types
    if external is not None:
        return tuple(external.parameters), tuple(Type(x.partition(":")[0].upper()) for x in external.parameters)
    known = scope.known.functions.get(name.upper())
    if known is None:
        return None
    more = ("...",) if known.open else ()
    return (*map(str, known.parameters), *more), tuple(x.type for x in known.parameters)


def _text(kind: Type, parameter: Parameter) -> str:
    """`INT N:IN`; without a mode a parameter is OUT, and before it is declared it has no type."""
    declared = "" if kind.name == "?" else f"{kind} "
    return f"{declared}{parameter.name}:{parameter.mode or 'OUT'}"


@dataclass(frozen=True, slots=True, eq=False)
class RoutineCalls:
    """A routine, the file in which it is defined, and places of calls: by it, or of it."""

    routine: Routine
    file: str
    places: tuple[SourcePosition, ...]


def callers(project: EditedProject, called: Referent) -> list[RoutineCalls]:
    """The routines that call one, with the places."""
    found: dict[tuple[str, int], tuple[Routine, list[SourcePosition]]] = {}
    for place in project.uses(called):
        around = _routine_at(project, place)
        if around is not None:  # the head of a routine stands before its body
            found.setdefault((place.file, around.first), (around, []))[1].append(place)
    return [RoutineCalls(routine, file, tuple(places)) for (file, _), (routine, places) in found.items()]


def callees(project: EditedProject, file: str, routine: Routine) -> list[RoutineCalls]:
    """The routines of the project that one calls, with the places in it."""
    found: dict[tuple[object, ...], tuple[Referent, list[SourcePosition]]] = {}
    for place, referent in _named_in(project, file, routine):
        if isinstance(referent.declared, Routine):
            found.setdefault(referent.key, (referent, []))[1].append(place)
    out = []
    for referent, places in found.values():
        assert isinstance(referent.declared, Routine)
        assert referent.position is not None
        out.append(RoutineCalls(referent.declared, referent.position.file, tuple(places)))
    return out


def _named_in(project: EditedProject, file: str, routine: Routine) -> Iterator[tuple[SourcePosition, Referent]]:
    program, read = project.program(file), project.project.file(file)
    scopes: dict[int, Scope] = {}
    for i, _ in routine.lines():
        for token, referent in named_in(line_context(program, read, i, scopes)):
            if referent is not None:
                yield read.file.position(i, token.column), referent


def _routine_at(project: EditedProject, place: SourcePosition) -> Routine | None:
    """The routine in whose body a place stands."""
    routines = project.project.file(place.file).outline.routines
    return next((x for x in routines if x.first <= place.line - 1 < max(x.last, x.first)), None)
