"""The rooms of the four papers: their recomputing functions and proofs, looked up by name."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module, resources
from typing import Any

from lwr_dyn.errors import UnknownNameError
from lwr_dyn.reproduction.case import PaperData, PaperFormula
from lwr_dyn.reproduction.proof import Prove
from lwr_dyn.reproduction.results import Results, read_results, results_text

PAPERS = ("lwr4plus", "lwr4", "wam7", "kr30ha")


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """A paper with its printed results, and the functions by name."""

    paper: str
    tables: Mapping[str, Any]
    """Its data file as parsed."""
    results: Results
    functions: Mapping[str, PaperFormula]
    proofs: Mapping[str, Prove]
    """Erratum -> proof."""

    @property
    def file(self) -> str:
        """Name of its data file, for messages."""
        return f"{self.paper}.toml"

    @property
    def evidence(self) -> PaperData:
        """What its proofs are given."""
        return PaperData(self.tables, self.results, self.file)


@cache
def room(paper: str) -> Room:
    """The room of a paper; raises `UnknownNameError` for a paper that is not reproduced, `PaperError` for bad data."""
    if paper not in PAPERS:
        raise UnknownNameError("paper to reproduce", paper, PAPERS)
    text = resources.files("lwr_dyn.papers").joinpath(f"{paper}.toml").read_text(encoding="utf-8")
    functions = import_module(f"lwr_dyn.reproduction.{paper}.formulas").FORMULAS
    proofs = import_module(f"lwr_dyn.reproduction.{paper}.proofs").PROOFS
    results = read_results(results_text(paper), f"reproduction/{paper}/results.toml")
    return Room(paper, tomllib.loads(text), results, functions, proofs)
