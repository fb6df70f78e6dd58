"""A paper with all that reproduces it, and what its reproduction comes to."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import resources
from typing import Any

from lwr_dyn.reproduction.case import PaperData, PaperFormula
from lwr_dyn.reproduction.ledger import Prove
from lwr_dyn.reproduction.report.content import Check, Replay, Section
from lwr_dyn.reproduction.results import read_results, results_of_tables, results_text
from lwr_dyn.reproduction.study import Study, study_of
from lwr_dyn.tables import Table
from lwr_dyn.viewer.figures import Figure

Progress = Callable[[str], None]
"""Called with the name of each step as it begins."""


@dataclass(frozen=True, slots=True, eq=False)
class PaperStudy:
    """A paper's data, and by name the formulas of its numbers and the proofs of its errata."""

    name: str
    study: Study
    data: PaperData
    formulas: Mapping[str, PaperFormula]
    proofs: Mapping[str, Prove]

    def with_data(
        self, tables: Mapping[str, Any] | None = None, results: Mapping[str, Any] | None = None
    ) -> PaperStudy:
        """The same study of other tables or printed results, both as parsed TOML; raises `PaperError`."""
        own = self.data
        printed = own.results if results is None else results_of_tables(results, own.results.file)
        return replace(self, data=PaperData(own.tables if tables is None else tables, printed, own.file))


@cache
def paper_study(paper: str) -> PaperStudy:
    """The study of a paper; raises `UnknownNameError` for one that is not reproduced, `PaperError` for bad data."""
    study = study_of(paper)
    text = resources.files("lwr_dyn.papers").joinpath(f"{paper}.toml").read_text(encoding="utf-8")
    results = read_results(results_text(paper), f"reproduction/{paper}/results.toml")
    data = PaperData(tomllib.loads(text), results, f"{paper}.toml")
    return PaperStudy(paper, study, data, study.load("formulas"), study.load("proofs") if study.proofs else {})


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
    """Whether everything printed is reproduced or explained, tables and sentences for people, a record for programs."""

    holds: bool
    tables: Sequence[Table | str]
    record: dict[str, Any]
    known: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """Block of `results.toml` -> columns of values that the study has computed already."""
    extras: PageExtras = field(default_factory=PageExtras)

    @property
    def text(self) -> str:
        """The tables one below the other."""
        return "\n\n".join(table if isinstance(table, str) else table.text() for table in self.tables)
