"""What a rule found: where, what is printed, what is suspected, how sure, and the numbers that show it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

Severity = Literal["error", "warning", "note"]
Sure = Literal["certain", "likely", "possible"]


@dataclass(frozen=True, slots=True)
class Finding:
    """An error cannot be right, a warning is most likely not, a note only says how a table was read."""

    rule: str
    severity: Severity
    sure: Sure
    file: str
    place: str
    """Table, row (from 1), column."""
    cells: tuple[str, ...]
    """All the places it is about."""
    printed: str
    suspected: str
    sentence: str
    numbers: Mapping[str, Any] = field(default_factory=dict)
    known: tuple[str, ...] = ()
    """Errata of the file that are about these cells."""

    @property
    def counts(self) -> bool:
        """It makes the file fail."""
        return self.severity != "note"

    def line(self) -> str:
        """For people: file:place: severity rule: sentence."""
        known = f" [erratum {', '.join(self.known)}]" if self.known else ""
        return f"{self.file}:{self.place}: {self.severity} {self.rule}: {self.sentence}{known}"

    def record(self) -> dict[str, Any]:
        """For programs."""
        return {
            "rule": self.rule, "severity": self.severity, "sure": self.sure, "file": self.file, "place": self.place,
            "cells": list(self.cells), "printed": self.printed, "suspected": self.suspected, "sentence": self.sentence,
            "numbers": dict(self.numbers), "known": list(self.known),
        }  # fmt: skip
