"""What reproducing a paper comes to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from lwr_dyn.reproduction.report.content import Check, Replay, Section
from lwr_dyn.viewer.figures import Figure


@dataclass(frozen=True, slots=True, eq=False)
class PageExtras:
    """What a report page shows beside numbers and errata: figures in the form of the paper's, runs, checks."""

    figures: tuple[Figure, ...] = ()
    replay: Replay | None = None
    checks: tuple[Check, ...] = ()
    audit: tuple[Check, ...] = ()
    sections: tuple[Section, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Reproduction:
    """Whether everything printed is reproduced or explained, the text for people, the record for programs."""

    holds: bool
    text: str
    record: dict[str, Any]
    known: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """ResultBlock of `results.toml` -> columns of values that the work came by."""
    shown: PageExtras = field(default_factory=PageExtras)
    """For the report page."""
