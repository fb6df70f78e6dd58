"""The readings of a table whose conventions nobody states, ranked by frames, numbers, bodies and repeated links.

Two questions are kept apart, since their answers may differ: what did the authors compute with (the reading that gives
their numbers), and what is the arm (bodies that can exist, second tensors, mirror images that agree)?
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.audit.conventions.candidates import Candidate, Moved, as_mirrored, best_mirror_miss, candidates, ranked
from lwr_dyn.audit.conventions.choices import CellChange
from lwr_dyn.audit.conventions.evidence import Evidence
from lwr_dyn.audit.conventions.frames import FramesFinding, frames_findings, with_rows_moved
from lwr_dyn.audit.conventions.printed import PrintedTable
from lwr_dyn.audit.conventions.repair import Repair, repairs
from lwr_dyn.audit.conventions.search import Fits, fit_numbers
from lwr_dyn.audit.conventions.worlds import Allowed, World, changed_world, worlds
from lwr_dyn.errors import MissingDataError
from lwr_dyn.model.dh import Convention

MOST_BOXES = 300
"""Boxes per table choice that are turned into readings."""


Case = tuple[PrintedTable, Moved, World]
"""A table, what was changed in it, and one way to read it."""


@dataclass(frozen=True, slots=True, eq=False)
class Resolution:
    """What was found: two rankings, how they were come by, and whether they agree."""

    table: PrintedTable
    """With rows moved; cells as printed."""
    evidence: Evidence
    frames: tuple[FramesFinding, ...]
    worlds: tuple[World, ...]
    fits: tuple[Fits, ...]
    """Of the cells as printed, per world."""
    repairs: tuple[Repair, ...]
    computed: tuple[Candidate, ...]
    """Readings that give every published number, the plainest first; empty without numbers, or when none does."""
    physical: tuple[Candidate, ...]
    """Readings whose links can be bodies, whose repeated links agree, and that give the second tensors."""
    both: tuple[Candidate, ...]
    """Readings that are both."""
    bounded: bool
    """Radii of gyration were held to the links' lengths; False where no reading keeps to them."""
    cases: tuple[Case, ...]
    """What was read in the end: with cells changed where that is needed."""

    @property
    def agree(self) -> bool:
        """A reading that gives the numbers is as good a body as any."""
        return bool(self.both) and as_mirrored(self.both[0], best_mirror_miss(self.physical))

    @property
    def best(self) -> Candidate | None:
        """The reading to take for the arm: one that satisfies everything, or else the physical one."""
        if self.agree:
            return self.both[0]
        found = self.physical or self.computed
        return found[0] if found else None


def resolve(table: PrintedTable, evidence: Evidence) -> Resolution:
    """Every reading of a table against every criterion.

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
    ways = worlds(moved, evidence, _conventions(findings))
    fits = tuple(fit_numbers(w.rows, w.options, w.everything) for w in ways)
    mended: tuple[Repair, ...] = ()
    if evidence.numbers and not any(f.boxes for f in fits):
        mended = repairs(moved, evidence, ways, fits)
    cases: list[Case] = [(moved, (shift, ()), w) for w in ways]
    if mended:
        cases = [case for r in equally_plain(mended) for case in _mended(moved, evidence, r.cell, ways, shift)]
    bounded = any(all(w.sound) for _, _, w in cases)
    if not bounded:
        cases = [(t, m, replace(w, feasible=w.possible)) for t, m, w in cases]
    sound = [(case, case[2].sound) for case in cases if all(case[2].sound)]
    free = [(case, case[2].everything) for case in cases]
    return Resolution(
        table=moved, evidence=evidence, frames=findings, worlds=ways, fits=fits, repairs=mended,
        computed=_fitting(free, mirrored=False) if evidence.numbers else (),
        physical=ranked([c for (t, m, w), left in sound for c in candidates(t, w, left, m)]),
        both=_fitting(sound, mirrored=True), bounded=bounded, cases=tuple(cases),
    )  # fmt: skip


def equally_plain(found: Sequence[Repair]) -> tuple[Repair, ...]:
    """Repairs of the same cell with as few exceptions as the first: they differ in a sign that no number shows."""
    first = found[0]
    return tuple(r for r in found if r.cell.name == first.cell.name and r.exceptions == first.exceptions)


def _conventions(findings: Sequence[FramesFinding]) -> list[Convention]:
    """DH conventions that the frames leave: those that miss as little as the best."""
    least = min(f.rows_missed + f.places_missed for f in findings)
    left = {f.convention for f in findings if f.rows_missed + f.places_missed == least and f.shift == findings[0].shift}
    return [c for c in Convention if c in left]


def _mended(
    table: PrintedTable, evidence: Evidence, cell: CellChange, ways: Sequence[World], shift: int
) -> Iterator[Case]:
    changed = table.with_cell(cell.column, cell.link, cell.entry, cell.value)
    for w in ways:
        yield changed, (shift, (cell,)), changed_world(w, changed, evidence, cell.link)


def _fitting(cases: Sequence[tuple[Case, Allowed]], mirrored: bool) -> tuple[Candidate, ...]:
    """Candidates of every box that gives the published numbers."""
    found: list[Candidate] = []
    for (table, moved, w), left in cases:
        fits = fit_numbers(w.rows, w.options, left)
        for box in fits.boxes[:MOST_BOXES]:
            found += candidates(table, w, box, moved, mirrored)
    return ranked(found)
