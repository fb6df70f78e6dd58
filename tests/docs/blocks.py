"""The blocks of a Markdown page that are run: commands, Python, and files that they read."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

FENCE = re.compile(r"^(?P<indent> *)(?P<ticks>`{3,})(?P<info>[^`]*)$")
NO_RUN = re.compile(r"no-run(?: +(?P<reason>.*))?$")
FILE = re.compile(r"file=(?P<name>\S+)$")
EXIT_CODE = re.compile(r"^\[(\d+)\]$")
MARK = "..."
FIXED_PER_MARK = 9
"""Characters that a line must have beside each `...` inside it."""
ROUNDING = re.compile(r"(?<![\d.])\d(?:\.\d+)?e-(?:09|[123]\d)(?!\d)")
"""A number of the size of rounding errors, which differ between processors: below 1e-8."""


class PageError(AssertionError):
    """A page that cannot be read, or that says what does not come true."""


@dataclass(slots=True)
class Command:
    """One command of a console block: its text, the output it promises, its exit code, and where it stands."""

    text: str
    line: int
    """Number of its first line in the page, from 1."""
    output: list[str] = field(default_factory=list)
    first: int = 0
    """Index of the first output line in the page, from 0."""
    indent: str = ""
    code: int = 0


@dataclass(slots=True)
class Block:
    """A fenced block: language, the rest of its first line, its lines without indent, and where it stands."""

    language: str
    rest: str
    lines: list[str]
    line: int
    """Number of its first line of content, from 1."""
    indent: str = ""

    @property
    def file(self) -> str:
        """Name of the file that the block is, or nothing."""
        found = FILE.match(self.rest)
        return found["name"] if found else ""

    @property
    def reason(self) -> str | None:
        """Why it is not run; None if it is."""
        found = NO_RUN.match(self.rest)
        return (found["reason"] or "").strip() if found else None

    def commands(self) -> list[Command]:
        """The commands of a console block; raises `PageError` for output without a command."""
        found: list[Command] = []
        lines = iter(enumerate(self.lines))
        for i, line in lines:
            if line.startswith("$ "):
                text, last = line[2:], i
                while text.endswith("\\"):
                    last, more = next(lines)
                    text = f"{text}\n{more}"
                found.append(Command(text, self.line + i, first=self.line + last, indent=self.indent))
            elif not found:
                raise PageError(f"line {self.line + i}: output before the first `$ command`: {line!r}")
            else:
                found[-1].output.append(line)
        return [with_exit_code(command) for command in found]


def with_exit_code(command: Command) -> Command:
    """The command with `[2]` taken from the end of its output; blank lines at the end do not count."""
    while command.output and not command.output[-1].strip():
        command.output.pop()
    if command.output and (found := EXIT_CODE.match(command.output[-1])):
        command.code = int(found[1])
        command.output.pop()
    return command


def blocks(text: str) -> Iterator[Block]:
    """All fenced blocks of a page in order; raises `PageError` for one that is not closed."""
    lines = iter(enumerate(text.splitlines(), 1))
    for number, line in lines:
        opening = FENCE.match(line)
        if not opening:
            continue
        indent, ticks = opening["indent"], opening["ticks"]
        language, _, rest = opening["info"].strip().partition(" ")
        content = []
        for _, inner in lines:
            if re.match(rf"^ *{ticks}`* *$", inner):
                break
            content.append(inner.removeprefix(indent))
        else:
            raise PageError(f"line {number}: the block is not closed")
        yield Block(language, rest.strip(), content, number + 1, indent)


def check_marks(command: Command) -> None:
    """At most a quarter of the lines is `...`, and a line with `...` inside has enough else; raises `PageError`."""
    whole = sum(line.strip() == MARK for line in command.output)
    if whole * 4 > len(command.output):
        raise PageError(
            f"line {command.line}: {whole} of {len(command.output)} output lines are `...`; allowed: a quarter"
        )
    for line in command.output:
        marks = line.count(MARK)
        if line.strip() != MARK and len("".join(line.replace(MARK, "").split())) < FIXED_PER_MARK * marks:
            raise PageError(f"line {command.line}: {line!r} says too little beside `...`")


def line_pattern(line: str) -> re.Pattern[str]:
    """What a line of promised output matches, spaces at its end apart."""
    return re.compile(".*".join(_literal(part) for part in line.rstrip().split(MARK)) + r"\s*")


def _literal(text: str) -> str:
    """A pattern of the text; a number of the size of rounding errors stands for any other, whatever its width."""
    first, *others = ROUNDING.split(text)
    return re.escape(first) + "".join(ROUNDING.pattern + " *" + re.escape(other.lstrip(" ")) for other in others)


def matches(promised: list[str], actual: list[str]) -> bool:
    """Whether output is as promised: `...` on a line of its own matches any lines, inside a line any text."""
    reachable = {0}
    for line in promised:
        if line.strip() == MARK:
            reachable = set(range(min(reachable), len(actual) + 1)) if reachable else set()
            continue
        pattern = line_pattern(line)
        reachable = {i + 1 for i in reachable if i < len(actual) and pattern.fullmatch(actual[i])}
    return len(actual) in reachable


def updated(promised: list[str], actual: list[str]) -> list[str]:
    """Actual output as a page shows it: `...` stays where what stands about it in `promised` is still there."""
    shown: list[str] = []
    at = 0
    for place, line in enumerate(promised):
        if line.strip() == MARK:
            after = next((other for other in promised[place + 1 :] if other.strip() != MARK), None)
            to = len(actual) if after is None else _found(after, actual, at)
            if to is not None and to > at and _stands(promised[:place], shown):
                shown.append(line)
                at = to
        elif (to := _found(line, actual, at)) is not None:
            shown += [*actual[at:to], line if MARK in line else actual[to]]
            at = to + 1
    return shown + actual[at:]


def _found(line: str, actual: list[str], start: int) -> int | None:
    pattern = line_pattern(line)
    return next((i for i in range(start, len(actual)) if pattern.fullmatch(actual[i])), None)


def _stands(before: list[str], shown: list[str]) -> bool:
    """Whether the line before a mark is the last one shown."""
    return not before or bool(shown and line_pattern(before[-1]).fullmatch(shown[-1]))
