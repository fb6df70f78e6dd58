"""Diagnoses: what is wrong or doubtful in a program, where, and what to do about it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

Severity = Literal["error", "warning", "note"]
ORDER: tuple[Severity, ...] = ("error", "warning", "note")


@dataclass(frozen=True, slots=True)
class Place:
    """A place in a file: line and column from 1."""

    file: str
    line: int
    column: int = 1

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """One sentence about one place; `code` is stable, for programs and for looking up; `hint` says what helps.

    An error stops the program or the robot; a warning runs, perhaps not as meant; a note says what was not looked at.
    """

    place: Place
    severity: Severity
    code: str
    message: str
    hint: str = ""

    def __str__(self) -> str:
        hint = f" ({self.hint})" if self.hint else ""
        return f"{self.place}: {self.severity} {self.code}: {self.message}{hint}"

    def to_json(self) -> dict[str, Any]:
        """The same for programs."""
        return {**asdict(self.place), **{key: getattr(self, key) for key in ("severity", "code", "message", "hint")}}


def in_order(found: Iterable[Diagnosis]) -> tuple[Diagnosis, ...]:
    """Each diagnosis once, by file, line and column."""
    return tuple(sorted(dict.fromkeys(found), key=lambda d: (d.place.file, d.place.line, d.place.column, d.code)))


def summary(found: Sequence[Diagnosis]) -> str:
    """How many of each.

    >>> summary([])
    'nothing to say'
    """
    counts = {severity: sum(d.severity == severity for d in found) for severity in ORDER}
    said = [f"{n} {severity}{'s' if n > 1 else ''}" for severity, n in counts.items() if n]
    return ", ".join(said) or "nothing to say"


def holds(found: Sequence[Diagnosis]) -> bool:
    """Whether none of them is an error."""
    return all(d.severity != "error" for d in found)
