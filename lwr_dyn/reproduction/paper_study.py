"""A paper with its formulas and proofs, and the result of reproducing it.

`figures.json`: what the figures of a paper show, written once; PNG, SVG and page are drawn from what is read back.

A curve of numbers stands there with its numbers (null is a gap), a curve of a run with the run's place in the list of
run files, its quantity and joint.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, fields, replace
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.document import Document, Fact, Part, Section
from lwr_dyn.foundation.files import make_folder, read_text, write_file, write_folder
from lwr_dyn.foundation.tables import Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run, short_repr
from lwr_dyn.pages.document import notebook_html
from lwr_dyn.pages.figures.figure import Curve, Figure, Level, Panel, Series
from lwr_dyn.pages.plotting.plots import save_figure
from lwr_dyn.pages.replay.replay_page import write_replay
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun
from lwr_dyn.reproduction.case import PaperData, PaperFormula, Prove
from lwr_dyn.reproduction.papers import Study, read_results, results_of_tables, results_text, study_of
from lwr_dyn.reproduction.report.content import ReportSection, Still

FIGURES = "figures.json"

Figures = Mapping[str, Sequence[Figure]]
"""Name of a drawn file -> its figures side by side; one without an id is not on the page."""


def written_figures(folder: Path, figures: Figures, run_files: Sequence[str]) -> dict[str, tuple[Figure, ...]]:
    """Write `figures.json` and return what it says; raises `FileAccessError`.

    Series refer to runs by their place among `run_files`.
    """
    drawn = {file: [_plain(figure) for figure in side_by_side] for file, side_by_side in figures.items()}
    record = {"runs": list(run_files), "figures": drawn}
    write_folder(folder, {FIGURES: json.dumps(record, allow_nan=False) + "\n"})
    return read_figures(folder / FIGURES)


def read_figures(path: Path) -> dict[str, tuple[Figure, ...]]:
    """The figures of a `figures.json`; raises `FileAccessError`."""
    record = json.loads(read_text(path, "figures of a reproduced paper"))
    return {file: tuple(map(_figure, drawn)) for file, drawn in record["figures"].items()}


def _plain(value: Any) -> Any:
    """A record of `pages.figures.figure` as JSON values; floats keep every digit."""
    if isinstance(value, np.ndarray):
        return [x if np.isfinite(x) else None for x in value.tolist()]
    if isinstance(value, tuple):
        return [_plain(one) for one in value]
    if isinstance(value, Figure | Panel | Curve | Series | Level):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    return value.item() if isinstance(value, np.generic) else value


def _figure(record: Mapping[str, Any]) -> Figure:
    return Figure(**{**record, "panels": tuple(map(_panel, record["panels"]))})


def _panel(record: Mapping[str, Any]) -> Panel:
    curves = tuple(
        Curve(**{**curve, **{axis: _source(curve[axis]) for axis in "xy"}, "text": tuple(curve["text"])})
        for curve in record["curves"]
    )
    return Panel(**{**record, "curves": curves, "levels": tuple(Level(**level) for level in record["levels"])})


def _source(value: Any) -> Array | Series | None:
    """Numbers with NaN for a gap, or a series."""
    if isinstance(value, list):
        return np.array([np.nan if x is None else x for x in value], dtype=np.float64)
    return None if value is None else Series(**value)


Progress = Callable[[str], None]
"""Called with the name of each step as it begins."""


@dataclass(frozen=True, slots=True, eq=False)
class OwnFile:
    """A user's own data file: its path, and in place of `Study.run` what it computes."""

    path: str
    run: Callable[[Path, Arm, Progress], Reproduction]


@dataclass(frozen=True, slots=True, eq=False)
class PaperStudy:
    """A paper's data, and by name the formulas of its numbers and the proofs of its errata."""

    name: str
    study: Study
    data: PaperData
    formulas: Mapping[str, PaperFormula]
    proofs: Mapping[str, Prove]
    own: OwnFile | None = None
    """Of a user's own data file; None for a paper of the package."""

    @property
    def robot(self) -> str:
        """What opens the paper's tables: its name, or the path of its file."""
        return self.own.path if self.own else self.name

    def run(self, place: Path, arm: Arm, progress: Progress, **options: Any) -> Reproduction:
        """What the study finds beyond its numbers, see `Study.run`; raises `MissingPackageError`."""
        run = self.own.run if self.own else self.study.load("run")
        found: Reproduction = run(place, arm, progress, **options)
        return found

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
    text = resources.files("lwr_dyn.arms.papers").joinpath(f"{paper}.toml").read_text(encoding="utf-8")
    results = read_results(results_text(paper), f"reproduction/{paper}/results.toml")
    data = PaperData(tomllib.loads(text), results, f"{paper}.toml")
    return PaperStudy(paper, study, data, study.load("formulas"), study.load("proofs") if study.proofs else {})


@dataclass(frozen=True, slots=True, eq=False)
class Pictures:
    """The runs of a study and what is drawn: figures as files and on the page, the replay, still poses, sections."""

    simulated: tuple[tuple[str, str, Run], ...] = ()
    """The name of a run in tables, the file that keeps it, and the run."""
    shown: tuple[ReplayedRun, ...] = ()
    """Runs that the figures and the page's replay show."""
    figures: Figures = field(default_factory=dict)
    stills: tuple[Still, ...] = ()
    sections: tuple[ReportSection, ...] = ()
    title: str = ""
    """Of `replay.html`."""
    replayed: int = 0
    """How many runs, the first of `shown`, `replay.html` has."""

    def write(self, folder: Path) -> Pictures:
        """Write runs, `figures.json`, PNG, SVG and `replay.html`; raises `FileAccessError`.

        Returns the pictures with the figures as `figures.json` has them, from which PNG and SVG are drawn too.
        """
        runs = self._run_files()
        with ThreadPoolExecutor(1) as second:  # runs are packed while figures are drawn
            packed = {file: second.submit(run.to_npz) for file, run in runs.items()}
            read = self._drawn(folder, {id(run): f"runs/{file}" for file, run in runs.items()})
            for file, content in packed.items():
                write_file(make_folder(folder / "runs") / file, content.result())
        return replace(self, figures=read)

    def _drawn(self, folder: Path, places: Mapping[int, str]) -> Figures:
        """Write `figures.json`, PNG, SVG and `replay.html`; `places` are the files of the runs, by the runs' ids."""
        files = [places[id(one.run)] for one in self.shown]
        read = written_figures(folder, self.figures, files) if self.figures else {}
        for file, figures in read.items():
            save_figure(figures, make_folder(folder / "plots") / file, self.shown)
        first = self.shown[: self.replayed]
        if first:
            runs, arms, labels = ([getattr(one, name) for one in first] for name in ("run", "arm", "label"))
            write_replay(folder / "replay.html", runs, arms, labels=labels, title=self.title)
        return read

    def _run_files(self) -> dict[str, Run]:
        """File -> run: those that were simulated, and what figures show beside them."""
        files = {file: run for _, file, run in self.simulated}
        known = {id(run) for run in files.values()}
        shown = {f"{_file_name(one.label)}.npz": one.run for one in self.shown if id(one.run) not in known}
        return files | shown


def _file_name(label: str) -> str:
    """A label as the name of a file.

    >>> _file_name("KRL program, corrected")
    'krl_program_corrected'
    """
    return "_".join(re.findall("[a-z0-9-]+", label.lower()))


def study_document(*shown: Part, **recorded: Any) -> Document:
    """What a study found: parts that are shown, a paragraph each, and values by the keys of their record."""
    parts = [*shown, *(Fact(key, value) for key, value in recorded.items())]
    says = "What the study of the paper records."
    return Document("", "", [Section("", [part], says=says, own=True) for part in parts], "lwr-dyn reproduce")


@dataclass(frozen=True, slots=True, eq=False)
class Reproduction:
    """Whether everything printed is reproduced or explained, and what was found."""

    holds: bool
    document: Document
    """Of a study its own part, see `study_document`; of a reproduced paper all of it."""
    known: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """Block of `results.toml` -> columns of values that the study has computed already."""
    pictures: Pictures = field(default_factory=Pictures)
    __repr__ = short_repr

    def _repr_html_(self) -> str:
        verdict = "everything printed is reproduced or explained" if self.holds else "printed numbers DIFFER"
        tables = [part for one in self.document.there for part in one.parts if isinstance(part, Table)]
        return notebook_html(Document("", verdict, [Section("", tables[:1], brief=True)]))
