"""The names of inputs and outputs: beside `$IN[3]` stands the SIGNAL that names it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from lwr_dyn.krl.editor.referents import line_context
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.declarations import Signal
from lwr_dyn.krl.language.lexer import LineError, tokens_of
from lwr_dyn.krl.project.program import Program, Scope
from lwr_dyn.krl.project.project import DeclaredName, ModuleFile

PORTS = frozenset({"$IN", "$OUT", "$ANIN", "$ANOUT"})
WIDEST = 1024
"""Inputs of one SIGNAL at most: the controller takes 32."""


def signal_hints(program: Program, file: ModuleFile, first: int, last: int) -> Iterator[tuple[int, int, str]]:
    """Line and column (from 0) behind each `$IN[3]` of lines (from 0, both included), and the names of that input."""
    scopes: dict[int, Scope] = {}
    shared: Mapping[tuple[str, int], list[str]] | None = None
    for i in range(max(first, 0), min(last + 1, len(file.file.lines))):
        line = file.file.lines[i]
        if line.statement is None or isinstance(line.statement, Signal) or "$" not in line.shown:
            continue
        shared = _named(program.names.variables.values()) if shared is None else shared
        own = line_context(program, file, i, scopes).scope.own.variables
        named = {**shared, **_named(own.values())} if any(x.signal for x in own.values()) else shared
        for column, port in _ports(line.shown):
            if port in named:
                yield i, column, ", ".join(named[port])


def _ports(text: str) -> Iterator[tuple[int, tuple[str, int]]]:
    """The inputs and outputs with a constant index in a line, and the column (from 0) behind each."""
    try:
        tokens, _ = tokens_of(text)
    except LineError:
        return
    for k in range(len(tokens) - 3):
        name, *index = tokens[k : k + 4]
        kinds = tuple(x.kind for x in index)
        if name.text.upper() in PORTS and kinds == ("_LSQB", "INTEGER", "_RSQB"):
            yield index[2].column, (name.text.upper(), int(index[1].text))


def _named(declared: Iterable[DeclaredName]) -> dict[tuple[str, int], list[str]]:
    """The names of each input and output; of one of a group with its place in it."""
    out: dict[tuple[str, int], list[str]] = {}
    for x in declared:
        for port, name in () if x.signal is None else _ports_of(x.signal):
            out.setdefault(port, []).append(name)
    return out


def _ports_of(x: Signal) -> Iterator[tuple[tuple[str, int], str]]:
    first, last = _port(x.first), _port(x.last)
    if first is None:
        return
    if last is None:
        yield first, x.name
        return
    for n in range(first[1], min(last[1], first[1] + WIDEST) + 1):
        yield (first[0], n), f"{x.name} bit {n - first[1]}"


def _port(x: e.Reference | e.Bool | None) -> tuple[str, int] | None:
    if not (isinstance(x, e.Index) and isinstance(x.of, e.Name) and len(x.indices) == 1):
        return None
    number, root = x.indices[0], x.of.name.upper()
    return (root, number.value) if root in PORTS and isinstance(number, e.Integer) else None
