"""What can be written at a place: components after a point, items of an aggregate, constants after #, names, keywords.

The line is read up to the cursor as words, since what is being written is no statement yet.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from lwr_dyn.krl.editor.calls import called_at
from lwr_dyn.krl.editor.referents import LineContext
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.lexer import KEYWORDS, LineError, Token, tokens_of
from lwr_dyn.krl.language.unparse import statement_text
from lwr_dyn.krl.names.known_names import AXES, CARTESIAN, GEOMETRY, SIMPLE, UNKNOWN, KnownNames, Type
from lwr_dyn.krl.project.program import Scope

CompletionKind = Literal["variable", "routine", "type", "component", "constant", "keyword", "system", "label"]
_WRITTEN = re.compile(r"(?<![\w$])(#[ \t]*[\w$]*|[A-Za-z_$][\w$]*)?$")
_POSES = (*CARTESIAN[::-1], *AXES[::-1])
"""What the target of a motion may be, the largest first: its components are those of all."""


@dataclass(frozen=True, slots=True)
class Completion:
    """One proposal; `detail` is its type or declaration, `near` puts it above the others."""

    text: str
    kind: CompletionKind
    detail: str = ""
    near: bool = False


def completions(context: LineContext, column: int) -> tuple[int, list[Completion]]:
    """The column (from 0) from which a proposal replaces the text, and the proposals, at a column (from 0) of a line.

    Names are those that begin with the first letter that is written; without one all but those of `$`.
    """
    before = context.text[:column]
    match = _WRITTEN.search(before)
    written = "" if match is None else match[1] or ""
    start = len(before) - len(written)
    try:
        tokens, comment = tokens_of(before[:start])
    except LineError:  # inside a text
        return column, []
    number = bool(tokens) and tokens[-1].kind in ("INTEGER", "DECIMAL") and not before[:start].endswith((" ", "\t"))
    if comment is not None or number or before.lstrip().startswith("&"):
        return column, []
    if written.startswith("#"):
        name = start + len(written) - len(written[1:].lstrip())
        return name, list(_constants(context, tokens))
    members = _members(context.scope, tokens)
    if members is not None:
        return start, members
    if tokens and tokens[-1].kind == "GOTO":
        return start, list(_labels(context))
    return start, [x for x in _names(context.scope) if _begins(x.text, written)]


def _begins(text: str, written: str) -> bool:
    letters = 2 if written.startswith("$") else 1
    return text[:letters].upper().startswith(written[:letters].upper()) if written else text[0] != "$"


def _members(scope: Scope, tokens: Sequence[Token]) -> list[Completion] | None:
    """Components where one is named next, none where a number stands before; None where it is no place for one."""
    if not tokens:
        return None
    if tokens[-1].kind == "_DOT":
        of = type_before(scope, tokens[:-1])
        return _components(scope, [of])
    owners = _owners(scope, tokens)
    return _components(scope, owners) if owners else None


def _components(scope: Scope, owners: Iterable[Type]) -> list[Completion]:
    found: dict[str, Completion] = {}
    for owner in owners:
        for name, kind in (scope.structure(owner.name) or {}).items():
            found.setdefault(name, Completion(name, "component", f"{kind} of {owner.name}", True))
    return list(found.values())


def type_before(scope: Scope, tokens: Sequence[Token]) -> Type:
    """The type of an element of the reference with which the words end: `A[1].B`; unknown for anything else."""
    names: list[str] = []
    at = len(tokens) - 1
    while at >= 0:
        if tokens[at].kind == "_RSQB":
            at = _opening(tokens, at) - 1
        if at < 0 or tokens[at].kind != "NAME":
            return UNKNOWN
        names.append(tokens[at].text.upper())
        if at == 0 or tokens[at - 1].kind != "_DOT":
            break
        at -= 2
    if not names:
        return UNKNOWN
    kind = (scope.variable(names.pop()) or UNKNOWN).element
    while names:
        kind = (scope.structure(kind.name) or {}).get(names.pop(), UNKNOWN).element
    return kind


def _opening(tokens: Sequence[Token], at: int) -> int:
    """The index of the bracket that the one at `at` closes; 0 where there is none."""
    depth = 0
    for k in range(at, -1, -1):
        depth += (tokens[k].kind in ("_RSQB", "_RPAR", "_RBRACE")) - (tokens[k].kind in ("_LSQB", "_LPAR", "BRACE"))
        if depth == 0:
            return k
    return 0


def _owners(scope: Scope, tokens: Sequence[Token]) -> list[Type]:
    """The types of which a component is named next in an aggregate: `{X 1, `; none elsewhere."""
    opened: list[tuple[str, list[Type]]] = []
    for k, token in enumerate(tokens):
        if token.kind == "BRACE":
            opened.append(("BRACE", _of_aggregate(scope, tokens, k, opened[-1][1] if opened else [])))
        elif token.kind in ("_LPAR", "_LSQB"):
            opened.append((token.kind, []))
        elif token.kind in ("_RPAR", "_RSQB", "_RBRACE") and opened:
            opened.pop()
    if not opened or opened[-1][0] != "BRACE":
        return []
    typed = tokens[-1].kind == "_COLON" and len(tokens) > 2 and tokens[-3].kind == "BRACE"
    return opened[-1][1] if typed or tokens[-1].kind in ("BRACE", "_COMMA") else []


def _of_aggregate(scope: Scope, tokens: Sequence[Token], at: int, around: list[Type]) -> list[Type]:
    """The types that an aggregate may have whose brace stands at `at`, inside one of the types `around`."""
    if at + 2 < len(tokens) and tokens[at + 2].kind == "_COLON":
        return [Type(tokens[at + 1].text.upper())]
    before = tokens[at - 1] if at else None
    if around and before is not None:
        name = at - 1 if before.kind != "_RSQB" else _opening(tokens, at - 1) - 1
        inner = ((scope.structure(x.name) or {}).get(tokens[name].text.upper()) for x in around)
        return [x.element for x in inner if x is not None]
    if before is not None and before.kind in ("_EQUALS", "COMPARE"):
        declared = _declared_type(tokens)
        return [declared or type_before(scope, tokens[: at - 1])]
    called = called_at(scope, tokens[:at])
    if called is not None:
        return [called.type.element] if called.type is not None else []
    return [Type(x) for x in _POSES]


def _declared_type(tokens: Sequence[Token]) -> Type | None:
    """The type of a declaration: `DECL E6POS P={`, `INT I=`."""
    words = [t for t in tokens if t.kind not in ("GLOBAL", "DECL", "CONST")]
    if len(words) > 1 and words[0].kind in ("NAME", "SIMPLE") and words[1].kind == "NAME":
        return Type(words[0].text.upper())
    return None


def _constants(context: LineContext, tokens: Sequence[Token]) -> Iterator[Completion]:
    """Those of the enumeration that is expected here; of all, where none is known or it has more than are listed."""
    scope, seen = context.scope, set[str]()
    wanted = _expected(context, tokens)
    for member in sorted(scope.enum(wanted.name) or ()):
        seen.add(member)
        yield Completion(member, "constant", wanted.name, True)
    if seen and not scope.is_open(wanted.name):
        return
    for enums in (*(x.enums for x in scope.tables), scope.known.enums):
        for name, members in enums.items():
            for member in sorted(members - seen):
                seen.add(member)
                yield Completion(member, "constant", name)


def _expected(context: LineContext, tokens: Sequence[Token]) -> Type:
    """The type of the value that is written next."""
    scope = context.scope
    last = tokens[-1].kind if tokens else ""
    if last in ("_EQUALS", "COMPARE"):
        return _declared_type(tokens) or type_before(scope, tokens[:-1])
    if tokens and tokens[0].kind == "CASE":
        return _of_switch(context)
    called = called_at(scope, tokens)
    if called is not None and last in ("_LPAR", "_COMMA"):
        return called.type or UNKNOWN
    if last in ("NAME", "_RSQB"):  # the value of an item of an aggregate
        name = len(tokens) - 1 if last == "NAME" else _opening(tokens, len(tokens) - 1) - 1
        kinds = ((scope.structure(x.name) or {}).get(tokens[name].text.upper()) for x in _owners(scope, tokens[:name]))
        return next((x.element for x in kinds if x is not None), UNKNOWN)
    return UNKNOWN


def _of_switch(context: LineContext) -> Type:
    """The type of the value of the SWITCH around a CASE."""
    routine, lines = context.scope.routine, context.file.file.lines
    found = None if routine is None else routine.blocks.get(context.line)
    at = range(context.line - 1, -1, -1) if found is None else (found.first,)
    for i in at:
        x = lines[i].statement
        if isinstance(x, s.Condition) and x.keyword == "SWITCH":
            tokens, _ = tokens_of(lines[i].shown)
            return type_before(context.scope, tokens)
    return UNKNOWN


def _labels(context: LineContext) -> Iterator[Completion]:
    routine = context.scope.routine
    for i in () if routine is None else routine.labels.values():
        label = context.file.file.lines[i].statement
        if isinstance(label, s.Label):
            yield Completion(label.name, "label")


def _names(scope: Scope) -> Iterator[Completion]:
    """All names that are seen, the nearest of each first, and the keywords."""
    seen = set[str]()
    for x in (*_declared(scope), *_known(scope.known)):
        key = x.text.upper()
        if key not in seen:
            seen.add(key)
            yield x


def _declared(scope: Scope) -> Iterator[Completion]:
    own = {*(scope.own.variables), *(y for f in scope.program.module.files for y in f.names.variables)}
    for table in scope.tables:
        for key, x in table.variables.items():
            yield Completion(x.name, "system" if key[0] == "$" else "variable", str(x.type), key in own)
        for routine in table.routines.values():
            yield Completion(routine.head.name, "routine", statement_text(routine.head), True)
        for external in table.externals.values():
            yield Completion(external.name, "routine", statement_text(external), True)
        for x in table.types.values():
            yield Completion(x.name, "type", x.type.name)


@lru_cache(maxsize=4)
def _known(known: KnownNames) -> tuple[Completion, ...]:
    """What needs no declaration."""
    variables = (Completion(x, "system" if x[0] == "$" else "variable", str(of)) for x, of in known.variables.items())
    functions = (Completion(x, "routine", known.text(x) or "") for x in known.functions)
    types = (Completion(x, "type") for x in (*SIMPLE, *GEOMETRY, *known.structures, *known.enums))
    return (*variables, *functions, *types, *(Completion(x, "keyword") for x in KEYWORDS))
