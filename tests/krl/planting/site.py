"""Where a fault can be planted: a line of a program without errors, its words, and the edits of them."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.lexer import KEYWORDS, LineError, Token, tokens_of
from lwr_dyn.krl.language.source import SourceFile
from lwr_dyn.krl.names.known_names import known_names
from lwr_dyn.krl.project.project import Module, Project

_HEAD = re.compile(r"\s*(?:GLOBAL\s+)?(?:DEF|DEFFCT\s+\w+(?:\s*\[[\d, ]*\])?)\s+(\w+)\s*\(([^)]*)\)", re.IGNORECASE)
_WORD = re.compile(r"[A-Za-z_$][A-Za-z0-9_$]*")
EXECUTABLE = (s.Assign, s.Invoke, s.Move, s.Wait, s.Condition, s.For, s.Return, s.CaseBranch)
STEPS = (s.Assign, s.Invoke, s.Move, s.Wait)


@dataclass(frozen=True, slots=True, eq=False)
class SeededProject:
    """A project, the words that it uses, and the sizes of the arrays with one dimension that it declares."""

    name: str
    project: Project
    words: frozenset[str]
    sizes: Mapping[str, int]
    """0 for a name that is declared with several sizes."""
    arguments: Mapping[str, int]
    """Of a subprogram that it defines, how many arguments it takes; -1 for one that is defined differently twice."""


@dataclass(frozen=True, slots=True, eq=False)
class PlantSite:
    """A line of a file."""

    of: SeededProject
    module: Module
    file: SourceFile
    at: int

    @property
    def statement(self) -> s.Statement | None:
        return self.file.lines[self.at].statement

    @property
    def text(self) -> str:
        return self.file.lines[self.at].layout or ""

    @property
    def tokens(self) -> tuple[Token, ...]:
        return words_of(self.text)

    @property
    def routine(self) -> Routine | None:
        """The subprogram of the line, its DEF included."""
        of = next((x for x in self.module.files if x.file is self.file), None)
        routines = () if of is None else of.outline.routines
        return next((r for r in routines if r.first - 1 <= self.at <= r.last), None)

    @property
    def in_spline(self) -> bool:
        """Whether the line stands in a spline block, where few others may stand."""
        blocks = () if self.routine is None else self.routine.blocks.values()
        return any(b.kind.endswith("SPLINE") and b.first <= self.at < b.last for b in blocks)

    @property
    def end(self) -> int:
        """Where its last word ends."""
        return self.tokens[-1].column - 1 + len(self.tokens[-1].text)

    def without_line(self) -> list[str]:
        """The other lines of the file."""
        return [x for i, x in enumerate(texts_of(self.file)) if i != self.at]

    def replaced(self, token: Token, new: str) -> str:
        """The line with another text in place of a token."""
        begin = token.column - 1
        return self.text[:begin] + new + self.text[begin + len(token.text) :]

    def typo(self, word: str, rng: random.Random) -> str | None:
        """The word with two letters swapped, one left out or one doubled, so that it is no word of the project."""
        ways = []
        for i in range(len(word) - 1):
            ways.append(word[:i] + word[i + 1] + word[i] + word[i + 2 :])
            ways.append(word[: i + 1] + word[i + 2 :])
            ways.append(word[: i + 1] + word[i] + word[i + 1 :])
        rng.shuffle(ways)
        used = self.of.words | set(KEYWORDS) | set(known_names().functions)
        return next((w for w in ways if w.upper() not in used and re.fullmatch(r"[A-Za-z_]\w*", w)), None)


@dataclass(frozen=True, slots=True)
class PlantedFault:
    """The lines of a file with a fault, and the places (file, line from 1) at which it must be told."""

    file: str
    lines: tuple[str, ...]
    places: frozenset[tuple[str, int]]
    others: tuple[tuple[str, tuple[str, ...]], ...] = ()
    """Other files (name, lines) that must change with it."""


@dataclass(frozen=True, slots=True)
class FaultKind:
    """A kind of fault: how it is planted in a line (None where it cannot be), and the codes that name it rightly."""

    name: str
    plant: Callable[[PlantSite, random.Random], PlantedFault | None]
    codes: frozenset[str]


def kind_of(plant: Callable[[PlantSite, random.Random], PlantedFault | None], codes: str, name: str = "") -> FaultKind:
    """A kind, named as its function is."""
    return FaultKind(name or plant.__name__.replace("_", " "), plant, frozenset(codes.split()))


def told_at(file: SourceFile, lines: list[str], *places: tuple[str, int]) -> PlantedFault:
    """Other lines of a file, with a fault that must be told at one of these places (file, line from 1)."""
    return PlantedFault(file.name, tuple(lines), frozenset(places))


def changed(site: PlantSite, new: str, *more: int) -> PlantedFault:
    """The line of the site replaced; it must be told there, or at one of the lines (from 1) in `more`."""
    lines = texts_of(site.file)
    lines[site.at] = new
    return told_at(site.file, lines, *((site.file.name, line) for line in (site.at + 1, *more)))


def inserted(site: PlantSite, new: str) -> PlantedFault:
    """A line after that of the site; it must be told there."""
    lines = texts_of(site.file)
    lines.insert(site.at + 1, new)
    return told_at(site.file, lines, (site.file.name, site.at + 2))


def texts_of(file: SourceFile) -> list[str]:
    """The text of each line."""
    return [line.layout or "" for line in file.lines]


@lru_cache(maxsize=300_000)
def words_of(text: str) -> tuple[Token, ...]:
    """The tokens of a line; none if it cannot be read or is a header."""
    if text.lstrip().startswith("&"):
        return ()
    try:
        return tuple(tokens_of(text)[0])
    except LineError:
        return ()


def seeded(name: str, project: Project) -> SeededProject:
    """A project with its words and array sizes."""
    words: set[str] = set()
    sizes: dict[str, int] = {}
    arguments: dict[str, int] = {}
    for of in project.files:
        for line in of.file.lines:
            words.update(word.upper() for word in _WORD.findall(line.layout or ""))
            head = _HEAD.match(line.layout or "")
            if head:
                count = head[2].count(",") + bool(head[2].strip())
                same = arguments.setdefault(head[1].upper(), count) == count
                arguments[head[1].upper()] = count if same else -1
            if re.match(r"\s*(DECL|GLOBAL|INT|REAL|BOOL|CHAR)\b", line.layout or "", re.IGNORECASE):
                for array, size in re.findall(r"(\w+)\[(\d+)\]", (line.layout or "").split("=")[0]):
                    same = sizes.setdefault(array.upper(), int(size)) == int(size)
                    sizes[array.upper()] = int(size) if same else 0
    return SeededProject(name, project, frozenset(words), sizes, arguments)
