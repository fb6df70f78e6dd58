"""Ranks the readings of a table that states no conventions: by frames, published numbers, bodies, repeated links.

Two questions are kept apart, since their answers may differ: which reading did the authors compute with (it gives their
numbers), and which reading is the arm (bodies that can exist, second tensors, mirror images that agree)? `decisions`
says which choice is decided by which criterion, each alone and all together, and which stays open.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, TypedDict

import numpy as np

from lwr_dyn.checks.conventions.candidates import SIGNIFICANT, Candidate, best_mirror_miss, candidates, ranked
from lwr_dyn.checks.conventions.cell_corrections import CellCorrection, cell_corrections
from lwr_dyn.checks.conventions.evidence import Evidence
from lwr_dyn.checks.conventions.hypotheses import (
    FramesFinding,
    TableHypothesis,
    frames_findings,
    table_hypotheses,
    with_rows_moved,
)
from lwr_dyn.checks.conventions.printed_table import LinkChoice, PrintedTable
from lwr_dyn.checks.conventions.search import OptionSets, SearchResult, fit_numbers
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.chain import Convention

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
    """Every reading of a table judged by every criterion; feasibility and repeated links need no evidence.

    Raises `EvidenceError` or `UnknownNameError` for evidence about another arm, `MissingDataError` for a blank centre
    of mass that no move of rows fills.
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
    best = findings[0]
    left = {f.convention for f in findings if (f.missed, f.shift) == (best.missed, best.shift)}
    return [c for c in Convention if c in left]


def _fitting(cases: Iterable[tuple[TableHypothesis, OptionSets]], mirrored: bool) -> tuple[Candidate, ...]:
    """Candidates of all sets of options that give the published numbers."""
    readings: list[Candidate] = []
    for hypothesis, left in cases:
        for sets in fit_numbers(hypothesis.rows, hypothesis.options, left).sets[:MOST_SETS]:
            readings += candidates(hypothesis, sets, mirrored)
    return ranked(readings)


TABLE = ("convention", "about", "com_from")
LINK = ("products", "axes")
NO_DIFFERENCE = "no difference"
"""Answer where all choices give the same body to the printed digits."""


class DecisionRecord(TypedDict):
    """A choice as JSON values."""

    question: Annotated[str, "What is chosen: convention, about, com_from, products or axes."]
    link: Annotated[int | None, "From 1; null for the whole table."]
    answer: Annotated[str, "Of the first reading."]
    decided: Annotated[bool, "Whether no other answer is left."]
    others: Annotated[list[str], "Answers that no criterion excludes."]
    by: Annotated[list[str], "Criteria that alone leave this answer only; where others are left, what prefers it."]


@dataclass(frozen=True, slots=True)
class Decision:
    """One choice: its answer, the answers left beside it, and what decides or prefers it."""

    question: str
    """"convention", "about", "com_from", "products" or "axes"."""
    link: int | None
    """Counted from 0; none for the whole table."""
    answer: str
    others: tuple[str, ...]
    """Answers that no criterion excludes; empty when it is decided."""
    by: tuple[str, ...]
    """Criteria that alone leave this answer only; where others are left, what prefers it."""

    @property
    def decided(self) -> bool:
        """No other answer is left."""
        return not self.others

    def record(self) -> DecisionRecord:
        """As JSON values, links counted from 1."""
        link = None if self.link is None else self.link + 1
        return {
            "question": self.question, "link": link, "answer": self.answer, "decided": self.decided,
            "others": [*self.others], "by": [*self.by],
        }  # fmt: skip


def decisions(result: RankedReadings, ranking: Sequence[Candidate], criteria: Sequence[str]) -> tuple[Decision, ...]:
    """Every choice of the first reading of a ranking, judged by the criteria that ranking obeys.

    `criteria` are some of "feasibility", "second tensors", "published numbers", "repeated links".
    """
    if not ranking:
        return ()
    best_miss = best_mirror_miss(ranking)
    top = [c for c in ranking if c.is_mirrored(best_miss)]
    alone = {name: list(CRITERIA[name](result)) for name in criteria}
    out = [_of_table(question, top, alone) for question in TABLE]
    if len({h.choice.convention for h in result.as_printed}) == 1:
        by = "source" if result.evidence.convention else "frames"
        out[0] = Decision("convention", None, out[0].answer, (), (by,))
    for question in LINK:
        out += [_of_link(question, i, top, alone) for i in range(result.table.n)]
    return tuple(out)


Left = tuple[object, tuple[tuple[tuple[LinkChoice, ...], ...], ...]]
"""A table choice that a criterion leaves, with the choices for each body of every link."""


def _left(hypothesis: TableHypothesis, sets: OptionSets) -> Left:
    options = hypothesis.options
    return hypothesis.choice, tuple(tuple(o.choices[x] for x in s) for o, s in zip(options, sets, strict=True))


def _numbers(result: RankedReadings) -> Iterator[Left]:
    for h in result.hypotheses:
        yield from (_left(h, sets) for sets in fit_numbers(h.rows, h.options, h.everything).sets)


def _repeated(result: RankedReadings) -> Iterator[Left]:
    """Among readings whose links can be bodies: impossible ones may agree with one another too."""
    every = [c for h in result.hypotheses if all(h.feasible) for c in candidates(h, h.feasible)]
    best = best_mirror_miss(every)
    return ((c.reading.table, c.remaining) for c in every if c.is_mirrored(best))


CRITERIA: dict[str, Callable[[RankedReadings], Iterator[Left]]] = {
    "feasibility": lambda result: (_left(h, h.feasible) for h in result.hypotheses if all(h.feasible)),
    "second tensors": lambda result: (_left(h, h.second) for h in result.hypotheses if all(h.second)),
    "published numbers": _numbers,
    "repeated links": _repeated,
}
"""Criterion -> what it leaves when it is the only one."""


def _answer(question: str, choice: object) -> str:
    value = getattr(choice, question)
    if question == "axes" and isinstance(choice, LinkChoice):
        return choice.axes + (" (com too)" if choice.moved and choice.moves == "row" else "")
    return str(getattr(value, "value", value))


def _answers(question: str, choices: Iterable[object]) -> set[str]:
    return {_answer(question, choice) for choice in choices}


def _of_table(question: str, top: Sequence[Candidate], alone: dict[str, list[Left]]) -> Decision:
    answer = _answer(question, top[0].reading.table)
    rivals = [c for c in top if _answer(question, c.reading.table) != answer]
    if rivals:
        others = sorted(_answers(question, (c.reading.table for c in rivals)))
        return Decision(question, None, answer, tuple(others), _preferred(top[0], rivals))
    by = [name for name, left in alone.items() if _answers(question, (table for table, _ in left)) == {answer}]
    return Decision(question, None, answer, (), tuple(by) or ("all together",))


def _of_link(question: str, link: int, top: Sequence[Candidate], alone: dict[str, list[Left]]) -> Decision:
    answer = _answer(question, top[0].reading.links[link])
    bodies = [equal for c in top for equal in c.remaining[link]]
    if all(len(_answers(question, equal)) > 1 for equal in bodies):
        return Decision(question, link, NO_DIFFERENCE, (), ("equal to the printed digits",))
    others = sorted({_answer(question, equal[0]) for equal in bodies if answer not in _answers(question, equal)})
    if others:
        rivals = [c for c in top if answer not in _answers(question, c.remaining[link][0])]
        return Decision(question, link, answer, tuple(others), _preferred(top[0], rivals))
    by = [
        name for name, left in alone.items()
        if left and all(answer in _answers(question, equal) for _, links in left for equal in links[link])
    ]  # fmt: skip
    return Decision(question, link, answer, (), tuple(by) or ("all together",))


def _preferred(best: Candidate, rivals: Sequence[Candidate]) -> tuple[str, ...]:
    """What prefers the best to others that no criterion excludes."""
    if not rivals or min(c.exceptions for c in rivals) > best.exceptions:
        return ("fewest exceptions",)
    equal = [c for c in rivals if c.price - best.price < SIGNIFICANT]
    if not equal:
        return ("nearest numbers",)
    return ("fullest bodies",) if max(c.volume_level for c in equal) < best.volume_level else ()
