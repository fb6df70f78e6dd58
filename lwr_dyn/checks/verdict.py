"""A verdict: what was looked at, what came out, what is allowed, and whether it holds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Bound = Literal["at most", "above"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """One law or agreement: `value` against `tolerance`, in `unit`."""

    name: str
    value: float
    tolerance: float
    unit: str
    bound: Bound = "at most"

    @property
    def holds(self) -> bool:
        """A value that is not a number never holds.

        >>> Verdict("x", float("nan"), 1.0, "").holds
        False
        """
        return self.value <= self.tolerance if self.bound == "at most" else self.value > self.tolerance

    @property
    def word(self) -> str:
        """The verdict in a word."""
        return "holds" if self.holds else "FAILS"


@dataclass(frozen=True, slots=True)
class Report:
    """All verdicts on an arm, and what could not be looked at and why."""

    robot: str
    reading: str
    verdicts: tuple[Verdict, ...]
    notes: tuple[str, ...] = ()

    @property
    def holds(self) -> bool:
        """Every verdict holds."""
        return all(v.holds for v in self.verdicts)
