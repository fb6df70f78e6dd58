"""Which papers can be reproduced: each folder of this package with a `results.toml`, described by its `STUDY`."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module, resources
from typing import Any, Literal

from lwr_dyn.foundation.errors import OptionError, UnknownNameError, needs_extra

ALL = "all"
"""In place of a paper's name: every paper."""


@dataclass(frozen=True, slots=True)
class StudyOption:
    """An option of `lwr-dyn reproduce` that a study takes: one of `values`, or a flag where there are none."""

    name: str
    about: str
    values: tuple[str, ...] = ()
    for_all: bool = False
    """Whether `reproduce all` takes it too, for the papers that have it."""

    @property
    def keyword(self) -> str:
        """Its name as an argument of a function."""
        return self.name.replace("-", "_")


SENSITIVITY = StudyOption("sensitivity", "also the task under all readings (a minute more)", for_all=True)
"""For papers whose readings are readings of one arm, with masses in print."""


@dataclass(frozen=True, slots=True)
class Study:
    """How a paper is reproduced; `run`, `formulas`, `proofs` are "module:attribute", imported when they are used."""

    order: int
    """Place among the papers."""
    run: str
    """(place, arm, progress, **options) -> `Reproduction`: computes, and writes its files into the folder `place`."""
    formulas: str
    """Name in `results.toml` -> `PaperFormula`."""
    proofs: str = ""
    """Id of an erratum -> its proof; empty for a paper without errata."""
    options: tuple[StudyOption, ...] = ()
    conventions: Literal["", "tensors", "zero"] = ""
    """What the tables leave open: conventions of the inertia tensors, or zero and signs of the joints."""
    failing_readings: tuple[str, ...] = ()
    """Readings whose models fail some checks, as errata of the paper explain."""

    def load(self, part: str) -> Any:
        """The object that `part` ("run", "formulas", "proofs") names; raises `MissingPackageError`."""
        module, _, attribute = getattr(self, part).partition(":")
        with needs_extra("all"):
            return getattr(import_module(module), attribute)


@cache
def studies() -> Mapping[str, Study]:
    """Paper -> study, in their order; adding a paper is adding a folder."""
    folders = [f for f in resources.files(__package__).iterdir() if f.joinpath("results.toml").is_file()]
    known = {f.name: import_module(f"{__package__}.{f.name}").STUDY for f in folders}
    return dict(sorted(known.items(), key=lambda item: item[1].order))


def study_of(paper: str) -> Study:
    """The study of a paper; raises `UnknownNameError` for a paper that is not reproduced."""
    if paper not in studies():
        raise UnknownNameError("paper to reproduce", paper, (*studies(), ALL))
    return studies()[paper]


def takers(keyword: str) -> dict[str, StudyOption]:
    """Paper -> option of that keyword, for the papers that take it."""
    return {paper: o for paper, study in studies().items() for o in study.options if o.keyword == keyword}


def check_options(paper: str, options: Mapping[str, Any]) -> None:
    """Raise `OptionError` for options that a paper (or "all") does not take, or for a value that is not allowed."""
    for keyword, value in options.items():
        by_paper = takers(keyword)
        if not by_paper:
            raise OptionError("option", repr(keyword), ", ".join(sorted(option_keywords())))
        option = by_paper.get(paper, next(iter(by_paper.values())))
        allowed = [*by_paper, ALL] if option.for_all else [*by_paper]
        if paper not in allowed:
            raise OptionError(f"--{option.name}", f"given for {paper}", f"only for {', '.join(allowed)}")
        if option.values and value not in option.values:
            raise OptionError(f"--{option.name}", repr(value), ", ".join(option.values))


def option_keywords() -> tuple[str, ...]:
    """Keywords of all options, in the order of the papers."""
    return tuple(dict.fromkeys(o.keyword for study in studies().values() for o in study.options))
