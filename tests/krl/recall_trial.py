"""Names of a project drawn by a seed, hidden and asked for: which of them are offered where they stand."""

from __future__ import annotations

import contextlib
import random
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

from lwr_dyn.krl.editor.completions import completions
from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.referents import line_context
from lwr_dyn.krl.language import declarations as d
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.lexer import LineError, Token, tokens_of
from lwr_dyn.krl.language.statements import Statement


@dataclass
class RecallTrial:
    """How many names of each kind were asked for and offered, those that were not, and processor seconds of each."""

    asked: Counter[str] = field(default_factory=Counter)
    offered: Counter[str] = field(default_factory=Counter)
    missed: Counter[str] = field(default_factory=Counter)
    seconds: list[float] = field(default_factory=list)

    @property
    def share(self) -> float:
        """Of the names that were offered."""
        return self.offered.total() / max(self.asked.total(), 1)


def words_in_code(project: EditedProject) -> Iterator[tuple[str, int, Statement, list[Token], int]]:
    """File, line from 0, statement and words of each line of code, and which of the words is a name."""
    for file in project.project.files:
        for i, line in enumerate(file.file.lines):
            if line.statement is None or line.shown.lstrip().startswith("&"):
                continue
            with contextlib.suppress(LineError):
                tokens = tokens_of(line.shown)[0]
                names = [k for k, token in enumerate(tokens) if token.kind in ("NAME", "ENUMERATION")]
                yield from ((file.file.name, i, line.statement, tokens, k) for k in names)


def hidden_names(project: EditedProject) -> list[tuple[str, int, int, str, str]]:
    """File, line from 0, column from 0 where one asks, kind and text of each name that is used in code.

    Where a name is declared it is new, so it is not asked for there. A name is asked for after its first letter, one
    of `$` after two signs, a constant after #, a component and an item of an aggregate before it.
    """
    out = []
    for file, i, statement, tokens, k in words_in_code(project):
        token = tokens[k]
        if not is_new(statement, token, k):
            kind, text = _kind(tokens, k), token.text.lstrip("# \t")
            first = token.column - 1 + len(token.text) - len(text)
            out.append((file, i, first + {"name": 1, "system": 2}.get(kind, 0), kind, text.upper()))
    return out


def is_new(x, token: Token, k: int) -> bool:
    """Whether a statement declares the name that stands there."""
    at = token.column
    match x:
        case d.Declaration():
            return any(each.column == at for each in x.names)
        case d.StructType():
            return x.column == at or any(each.column == at for _, names in x.members for each in names)
        case d.EnumType():
            return at >= x.column
        case d.Def():
            return x.column == at or any(each.column == at for each in x.parameters)
        case d.DefDat() | d.Signal() | d.External() | d.Channel():
            return x.column == at
    return isinstance(x, s.Label) and k == 0


def _kind(tokens: list[Token], k: int) -> str:
    token, before = tokens[k], tokens[k - 1].kind if k else ""
    if token.kind == "ENUMERATION":
        return "constant"
    if before == "_DOT":
        return "component"
    if before in ("BRACE", "_COMMA"):
        depth = sum((t.kind == "BRACE") - (t.kind == "_RBRACE") for t in tokens[:k])
        inner = sum((t.kind in ("_LPAR", "_LSQB")) - (t.kind in ("_RPAR", "_RSQB")) for t in tokens[:k])
        if depth > 0 and inner == 0:
            return "item"
    return "system" if token.text.startswith("$") else "name"


def recall_trial(project: EditedProject, rng: random.Random, wanted: int) -> RecallTrial:
    """Ask for so many names drawn by the seed, each in the line as it would be while it is written."""
    out, names = RecallTrial(), hidden_names(project)
    for file, line, column, kind, text in rng.choices(names, k=wanted):
        context = line_context(project.program(file), project.project.file(file), line)
        begun = time.process_time()
        found = completions(context, column)[1]
        out.seconds.append(time.process_time() - begun)
        out.asked[kind] += 1
        if any(x.text.upper() == text for x in found):
            out.offered[kind] += 1
        else:
            out.missed[f"{kind} {text}"] += 1
    return out
