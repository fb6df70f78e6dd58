"""Which choice is decided by which criterion, and which stays open: each criterion asked alone, then all together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lwr_dyn.audit.conventions.candidates import (
    TOLD_APART,
    Candidate,
    as_mirrored,
    best_mirror_miss,
    candidates,
    fullness_step,
    price,
)
from lwr_dyn.audit.conventions.choices import LinkChoice
from lwr_dyn.audit.conventions.resolve import Resolution
from lwr_dyn.audit.conventions.search import Box, fit_numbers

TABLE = ("convention", "about", "com_from")
LINK = ("products", "axes")


@dataclass(frozen=True, slots=True)
class Decision:
    """One choice: its answer, what is left beside it, and by what it was made."""

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


def decisions(found: Resolution, ranking: Sequence[Candidate], criteria: Sequence[str]) -> tuple[Decision, ...]:
    """Every choice of the first reading of a ranking, judged by the criteria that ranking obeys.

    `criteria` are some of "feasibility", "second tensors", "published numbers", "repeated links".
    """
    if not ranking:
        return ()
    best_miss = best_mirror_miss(ranking)
    top = [c for c in ranking if as_mirrored(c, best_miss)]
    alone = {name: _left_by(found, name) for name in criteria}
    out = [_of_table(question, top, alone) for question in TABLE]
    if len({w.choice.convention for w in found.worlds}) == 1:
        out[0] = Decision("convention", None, out[0].answer, (), ("source" if found.evidence.convention else "frames",))
    for question in LINK:
        out += [_of_link(question, i, top, alone) for i in range(found.table.n)]
    return tuple(out)


Left = list[tuple[object, tuple[tuple[tuple[LinkChoice, ...], ...], ...]]]
"""Table choices that a criterion leaves, each with the bodies of every link."""


def _left_by(found: Resolution, criterion: str) -> Left:
    ask = {"feasibility": _feasible, "second tensors": _second, "published numbers": _numbers}
    return ask.get(criterion, _repeated)(found)


def _as_left(found: Resolution, boxes: Sequence[tuple[int, Box]]) -> Left:
    out: Left = []
    for k, box in boxes:
        world = found.cases[k][2]
        links = tuple(tuple(o.choices[x] for x in left) for o, left in zip(world.options, box, strict=True))
        out.append((world.choice, links))
    return out


def _feasible(found: Resolution) -> Left:
    return _as_left(found, [(k, c[2].feasible) for k, c in enumerate(found.cases) if all(c[2].feasible)])


def _second(found: Resolution) -> Left:
    return _as_left(found, [(k, c[2].second) for k, c in enumerate(found.cases) if all(c[2].second)])


def _numbers(found: Resolution) -> Left:
    boxes: list[tuple[int, Box]] = []
    for k, (_, _, world) in enumerate(found.cases):
        boxes += [(k, box) for box in fit_numbers(world.rows, world.options, world.everything).boxes]
    return _as_left(found, boxes)


def _repeated(found: Resolution) -> Left:
    """Among readings whose links can be bodies: impossible ones may agree with one another too."""
    every = [c for t, m, w in found.cases if all(w.feasible) for c in candidates(t, w, w.feasible, m)]
    best = best_mirror_miss(every)
    return [(c.reading.table, c.remaining) for c in every if as_mirrored(c, best)]


def _answers(question: str, choice: object) -> str:
    value = getattr(choice, question)
    if question == "axes" and isinstance(choice, LinkChoice):
        return choice.axes + (" (com too)" if choice.moved and choice.moves == "row" else "")
    return str(getattr(value, "value", value))


def _of_table(question: str, top: Sequence[Candidate], alone: dict[str, Left]) -> Decision:
    answer = _answers(question, top[0].reading.table)
    others = sorted({_answers(question, c.reading.table) for c in top} - {answer})
    if others:
        rivals = [c for c in top if _answers(question, c.reading.table) != answer]
        return Decision(question, None, answer, tuple(others), _preferred(top[0], rivals))
    by = [name for name, left in alone.items() if {_answers(question, t) for t, _ in left} == {answer}]
    return Decision(question, None, answer, (), tuple(by) or ("all together",))


def _of_link(question: str, link: int, top: Sequence[Candidate], alone: dict[str, Left]) -> Decision:
    answer = _answers(question, top[0].reading.links[link])
    bodies = [equal for c in top for equal in c.remaining[link]]
    first = {_answers(question, x) for x in top[0].remaining[link][0]}
    if len(first) > 1:
        answer = "no difference" if all(len({_answers(question, x) for x in b}) > 1 for b in bodies) else answer
    others = sorted({_answers(question, b[0]) for b in bodies if answer not in {_answers(question, x) for x in b}})
    if answer == "no difference":
        return Decision(question, link, answer, (), ("equal to the printed digits",))
    if others:
        rivals = [c for c in top if answer not in {_answers(question, x) for x in c.remaining[link][0]}]
        return Decision(question, link, answer, tuple(others), _preferred(top[0], rivals))
    by = [
        name for name, left in alone.items()
        if left and all(answer in {_answers(question, x) for x in b} for _, links in left for b in links[link])
    ]  # fmt: skip
    return Decision(question, link, answer, (), tuple(by) or ("all together",))


def _preferred(best: Candidate, rivals: Sequence[Candidate]) -> tuple[str, ...]:
    """What prefers the best to others that no criterion excludes."""
    if not rivals or min(c.exceptions for c in rivals) > best.exceptions:
        return ("fewest exceptions",)
    equal = [c for c in rivals if price(c) - price(best) < TOLD_APART]
    if not equal:
        return ("nearest numbers",)
    if max(fullness_step(c) for c in equal) < fullness_step(best):
        return ("fullest bodies",)
    return ()
