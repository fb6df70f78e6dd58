"""Which choice is decided by which criterion, and which stays open: each criterion alone, then all together."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from lwr_dyn.checks.conventions.candidates import SIGNIFICANT, Candidate, best_mirror_miss, candidates
from lwr_dyn.checks.conventions.choices import LinkChoice
from lwr_dyn.checks.conventions.hypotheses import TableHypothesis
from lwr_dyn.checks.conventions.ranking import RankedReadings
from lwr_dyn.checks.conventions.search import OptionSets, fit_numbers

TABLE = ("convention", "about", "com_from")
LINK = ("products", "axes")
NO_DIFFERENCE = "no difference"
"""Answer where all choices give the same body to the printed digits."""


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

    def record(self) -> dict[str, Any]:
        """As JSON values, links counted from 1."""
        link = None if self.link is None else self.link + 1
        return {
            "question": self.question, "link": link, "answer": self.answer, "decided": self.decided,
            "others": self.others, "by": self.by,
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


def _feasible(result: RankedReadings) -> Iterator[Left]:
    return (_left(h, h.feasible) for h in result.hypotheses if all(h.feasible))


def _second(result: RankedReadings) -> Iterator[Left]:
    return (_left(h, h.second) for h in result.hypotheses if all(h.second))


def _numbers(result: RankedReadings) -> Iterator[Left]:
    for h in result.hypotheses:
        yield from (_left(h, sets) for sets in fit_numbers(h.rows, h.options, h.everything).sets)


def _repeated(result: RankedReadings) -> Iterator[Left]:
    """Among readings whose links can be bodies: impossible ones may agree with one another too."""
    every = [c for h in result.hypotheses if all(h.feasible) for c in candidates(h, h.feasible)]
    best = best_mirror_miss(every)
    return ((c.reading.table, c.remaining) for c in every if c.is_mirrored(best))


CRITERIA: dict[str, Callable[[RankedReadings], Iterator[Left]]] = {
    "feasibility": _feasible,
    "second tensors": _second,
    "published numbers": _numbers,
    "repeated links": _repeated,
}
"""Criterion -> what it leaves when it is the only one."""


def _answer(question: str, choice: object) -> str:
    value = getattr(choice, question)
    if question == "axes" and isinstance(choice, LinkChoice):
        return choice.axes + (" (com too)" if choice.moved and choice.moves == "row" else "")
    return str(getattr(value, "value", value))


def _answers(question: str, equal: Sequence[LinkChoice]) -> set[str]:
    """The answers of all choices that give one body."""
    return {_answer(question, choice) for choice in equal}


def _of_table(question: str, top: Sequence[Candidate], alone: dict[str, list[Left]]) -> Decision:
    answer = _answer(question, top[0].reading.table)
    rivals = [c for c in top if _answer(question, c.reading.table) != answer]
    if rivals:
        others = sorted({_answer(question, c.reading.table) for c in rivals})
        return Decision(question, None, answer, tuple(others), _preferred(top[0], rivals))
    by = [name for name, left in alone.items() if {_answer(question, table) for table, _ in left} == {answer}]
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
