"""What each name of a file means, for an editor that colours by meaning; keywords and numbers are the grammar's."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from lwr_dyn.krl.editor.referents import LineContext, line_context
from lwr_dyn.krl.language.lexer import Token, tokens_of
from lwr_dyn.krl.project.program import Program, Scope
from lwr_dyn.krl.project.project import ModuleFile

MEANINGS = ("variable", "parameter", "property", "function", "type", "enumMember")
MARKS = ("readonly", "defaultLibrary")
READ_ONLY, OF_CONTROLLER = 1, 2
"""Bits of the marks."""


def colored(
    program: Program, file: ModuleFile, first: int = 0, last: int | None = None
) -> Iterator[tuple[int, int, int, int, int]]:
    """Line and column (from 0), length, index of the meaning and bits of the marks of each name, line by line."""
    scopes: dict[int, Scope] = {}
    end = len(file.file.lines) if last is None else min(last + 1, len(file.file.lines))
    for i in range(first, end):
        line = file.file.lines[i]
        if line.statement is None or line.shown.lstrip().startswith("&"):
            continue
        tokens, _ = tokens_of(line.shown)
        context = line_context(program, file, i, scopes)
        for k, token in enumerate(tokens):
            if token.kind in ("NAME", "ENUMERATION"):
                meaning, marks = _meaning(context, tokens, k)
                yield i, token.column - 1, len(token.text), MEANINGS.index(meaning), marks


def _meaning(context: LineContext, tokens: Sequence[Token], k: int) -> tuple[str, int]:
    token, scope = tokens[k], context.scope
    key = token.text.upper()
    if token.kind == "ENUMERATION":
        return "enumMember", 0
    if _is_member(tokens, k):
        return "property", 0
    if key in scope.own.variables:
        parameters = () if scope.routine is None else scope.routine.head.parameters
        return ("parameter" if any(p.name.upper() == key for p in parameters) else "variable"), 0
    routine = key in scope.program.names.routines
    called = k + 1 < len(tokens) and tokens[k + 1].kind == "_LPAR"
    if called or (routine and key not in scope.program.names.variables):
        return "function", OF_CONTROLLER if key in scope.known.functions and not routine else 0
    return _of_name(scope, key)


def _of_name(scope: Scope, key: str) -> tuple[str, int]:
    declared, known = scope.program.names.variables.get(key), scope.known
    if declared is None and scope.is_type(key):
        return "type", OF_CONTROLLER if scope.is_foreign(key) else 0
    read_only = READ_ONLY if key in known.read_only or (declared is not None and declared.const) else 0
    of_controller = OF_CONTROLLER if key.startswith("$") or (declared is None and key in known.variables) else 0
    return "variable", read_only | of_controller


def _is_member(tokens: Sequence[Token], k: int) -> bool:
    """Whether a word names a component: after a point, or before its value in an aggregate."""
    before = tokens[k - 1].kind if k else ""
    if before == "_DOT":
        return True
    after = tokens[k + 1].kind if k + 1 < len(tokens) else ""
    return before in ("BRACE", "_COMMA") and after not in ("", "_COMMA", "_COLON", "_DOT") and _in_brace(tokens, k)


def _in_brace(tokens: Sequence[Token], k: int) -> bool:
    """Whether the innermost bracket around a word is that of an aggregate."""
    closed = 0
    for token in reversed(tokens[:k]):
        if token.kind in ("_RPAR", "_RSQB", "_RBRACE"):
            closed += 1
        elif token.kind in ("_LPAR", "_LSQB", "BRACE"):
            if not closed:
                return token.kind == "BRACE"
            closed -= 1
    return False
