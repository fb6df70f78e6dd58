"""Ranks the readings of a table that states no conventions: by frames, published numbers, bodies, repeated links.

Two questions are kept apart, since their answers may differ: which reading did the authors compute with (it gives their
numbers), and which reading is the arm (bodies that can exist, second tensors, mirror images that agree)?
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.checks.conventions.candidates import Candidate, best_mirror_miss, candidates, ranked
from lwr_dyn.checks.conventions.cell_corrections import CellCorrection, cell_corrections
from lwr_dyn.checks.conventions.evidence import Evidence
from lwr_dyn.checks.conventions.frames import FramesFinding, frames_findings, with_rows_moved
from lwr_dyn.checks.conventions.hypotheses import TableHypothesis, table_hypotheses
from lwr_dyn.checks.conventions.printed_table import PrintedTable
from lwr_dyn.checks.conventions.search import OptionSets, SearchResult, fit_numbers
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.dh import Convention

MOST_SETS = 300
"""Sets of options per hypothesis that are turned into readings."""


@dataclass(frozen=True, slots=True, eq=False)
class RankedReadings:
    """Two rankings of readings, the hypotheses and searches that led to them, and whether they agree."""

    table: PrintedTable
    """With rows moved; cells as printed."""
    evidence: Evidence
    frames: tuple[FramesFinding, ...]
    as_printed: tuple[TableHypothesis, ...]
    """Hypotheses about the cells as printed."""
    searches: tuple[SearchResult, ...]
    """Of the cells as printed, per hypothesis."""
    corrections: tuple[CellCorrection, ...]
    computed: tuple[Candidate, ...]
    """Readings that give every published number, the plainest first; empty without numbers, or when none does."""
    physical: tuple[Candidate, ...]
    """Readings whose links can be bodies, whose repeated links agree, and that give the second tensors."""
    both: tuple[Candidate, ...]
    """Readings that are both."""
    bounded: bool
    """Radii of gyration were held to the links' lengths; False where no reading keeps to them."""
    hypotheses: tuple[TableHypothesis, ...]
    """Those that were read in the end: with cells corrected where that is needed."""

    @property
    def agree(self) -> bool:
        """A reading that gives the numbers has bodies as good as any."""
        return bool(self.both) and self.both[0].is_mirrored(best_mirror_miss(self.physical))

    @property
    def best(self) -> Candidate | None:
        """The reading to take for the arm: one that satisfies everything, else the physical one."""
        ranking = self.both if self.agree else self.physical or self.computed
        return ranking[0] if ranking else None


def rank_readings(table: PrintedTable, evidence: Evidence) -> RankedReadings:
    """Every reading of a table judged by every criterion.

    Parameters
    ----------
    table : PrintedTable
        See `printed_table`.
    evidence : Evidence
        What is published beside it; feasibility and repeated links need none.

    Raises
    ------
    EvidenceError, UnknownNameError
        Evidence about another arm.
    MissingDataError
        A centre of mass is blank, and no move of rows fills it.
    """
    evidence.check(table)
    findings = frames_findings(table, evidence)
    shift = findings[0].shift
    moved = with_rows_moved(table, shift)
    if np.isnan(moved.com).any():
        rows = ", ".join(f"link_{i + 1}" for i in np.flatnonzero(np.isnan(moved.com).any(axis=-1)))
        raise MissingDataError(table.name, f"centre of mass of {rows}", "a reading of its inertial table")
    as_printed = hypotheses = table_hypotheses(moved, evidence, _conventions(findings), shift)
    searches = tuple(fit_numbers(h.rows, h.options, h.everything) for h in as_printed)
    corrections: tuple[CellCorrection, ...] = ()
    if evidence.numbers and not any(s.sets for s in searches):
        corrections = cell_corrections(evidence, as_printed, searches)
    if corrections:
        hypotheses = tuple(h.with_cell(c.cell, evidence) for c in equally_plain(corrections) for h in as_printed)
    bounded = any(all(h.sound) for h in hypotheses)
    if not bounded:
        hypotheses = tuple(h.of_any_size() for h in hypotheses)
    sound = [(h, h.sound) for h in hypotheses if all(h.sound)]
    free = [(h, h.everything) for h in hypotheses]
    return RankedReadings(
        table=moved, evidence=evidence, frames=findings, as_printed=as_printed, searches=searches,
        corrections=corrections, computed=_fitting(free, mirrored=False) if evidence.numbers else (),
        physical=ranked([c for h, left in sound for c in candidates(h, left)]),
        both=_fitting(sound, mirrored=True), bounded=bounded, hypotheses=hypotheses,
    )  # fmt: skip


def equally_plain(corrections: Sequence[CellCorrection]) -> tuple[CellCorrection, ...]:
    """Corrections of the first one's cell with as few exceptions: they differ in a sign that no number shows."""
    first = corrections[0]
    return tuple(c for c in corrections if c.cell.name == first.cell.name and c.exceptions == first.exceptions)


def _conventions(findings: Sequence[FramesFinding]) -> list[Convention]:
    """DH conventions that the frames leave: those with as few misses as the best."""
    least = min(f.rows_missed + f.places_missed for f in findings)
    left = {f.convention for f in findings if f.rows_missed + f.places_missed == least and f.shift == findings[0].shift}
    return [c for c in Convention if c in left]


def _fitting(cases: Iterable[tuple[TableHypothesis, OptionSets]], mirrored: bool) -> tuple[Candidate, ...]:
    """Candidates of all sets of options that give the published numbers."""
    readings: list[Candidate] = []
    for hypothesis, left in cases:
        for sets in fit_numbers(hypothesis.rows, hypothesis.options, left).sets[:MOST_SETS]:
            readings += candidates(hypothesis, sets, mirrored)
    return ranked(readings)
