"""Ranked readings as sentences and tables: what each criterion decides, and what nothing decides."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.checks.conventions.candidates import Candidate, best_mirror_miss
from lwr_dyn.checks.conventions.criteria_text import criteria_text, global_maxima_text
from lwr_dyn.checks.conventions.decisions import NO_DIFFERENCE, Decision, decisions
from lwr_dyn.checks.conventions.ranking import RankedReadings
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.spatial import principal_moments

_QUESTIONS = {
    "convention": "DH convention", "about": "tensors are about", "com_from": "centres of mass are measured from",
    "products": "products of inertia", "axes": "order of the axes",
}  # fmt: skip
_ANSWERS = {
    "com": "the centre of mass", "origin": "the frame's origin", "integral": "+integral", "tensor": "tensor entries",
    "xyz": "as printed", "own frame": "the link's own frame", "other end": "the link's other end",
}  # fmt: skip
MOST_PATTERNS = 4
"""Sign patterns that are listed."""
SHOWN = 2
"""Open answers that are listed one by one."""
ROWS = 6
"""Readings of a ranking that are listed."""


@dataclass(frozen=True, slots=True, eq=False)
class JudgedRanking:
    """A ranking with the decisions about its first reading by the criteria that it obeys."""

    title: str
    ranking: tuple[Candidate, ...]
    decisions: tuple[Decision, ...]

    def table(self) -> Table:
        """The first readings: signs as t(ensor) and i(ntegral), link by link."""
        title = f"readings, best first: {self.title} (t tensor entries, i +integral, link by link)"
        headings = (
            "#", "DH", "about", "com from", "products", "axes moved", "cells", "apart", "repeated differ",
            Heading("fullness", format=".1f"),
        )  # fmt: skip
        return Table(title, headings, [_row(k + 1, c) for k, c in enumerate(self.ranking[:ROWS])])


def judged_rankings(result: RankedReadings) -> dict[str, JudgedRanking]:
    """The readings that the authors computed with, and those that are the arm."""
    computed, arm = result.computed, result.both if result.agree else result.physical
    numbers = ["published numbers"]
    criteria = ["feasibility"]
    if result.evidence.tensors is not None:
        criteria.append("second tensors")
    if any(h.alike for h in result.hypotheses):
        criteria.append("repeated links")
    with_numbers = [*criteria, *numbers] if result.agree and result.evidence.numbers else criteria
    return {
        "computed": JudgedRanking("what the authors computed with", computed, decisions(result, computed, numbers)),
        "arm": JudgedRanking("what the arm is", arm, decisions(result, arm, with_numbers)),
    }


def ranking_text(result: RankedReadings) -> list[str]:
    """The result, line by line."""
    computed, arm = judged_rankings(result).values()
    lines = criteria_text(result)
    if computed.ranking:
        lines += ["", "what the authors computed with (reading that gives every published number):"]
        lines += [*_first_reading(computed), *global_maxima_text(result)]
    if not arm.ranking:
        second = " and gives the second tensors" if result.evidence.tensors is not None else ""
        return [*lines, "", f"no reading lets every link be a body{second}"]
    same = result.agree and result.evidence.numbers
    also = "the same numbers, and bodies that can exist"
    other = "bodies that can exist, whatever was computed with them"
    lines += ["", f"what the arm is ({also if same else other}):", *_first_reading(arm)]
    return lines if same else [*lines, *_conflict(result)]


def _first_reading(judged: JudgedRanking) -> Iterator[str]:
    """The first reading of a ranking, choice by choice."""
    best = judged.ranking[0]
    groups: dict[tuple[object, ...], list[Decision]] = {}
    for d in judged.decisions:
        groups.setdefault((d.question, d.answer, d.others, d.by), []).append(d)
    for d, *others in groups.values():
        links = ", ".join(str(x.link + 1) for x in (d, *others) if x.link is not None)
        yield f"  {_decision(d, f'link {links}' if links else 'the table')}"
    figures = [f"{best.exceptions} links read apart from the rest"]
    if np.isfinite(best.mirror_miss):
        figures.append(f"repeated links differ by {best.mirror_miss:.2%} of their tensors")
    if best.infeasible:
        figures.append(f"not bodies: {', '.join(best.infeasible)}")
    yield f"  figures: {'; '.join(figures)}"
    yield from _patterns(judged.ranking)
    if np.isfinite(best.mirror_miss):
        bodies = [(i + 1, best.bodies[i]) for i in sorted(i for group in best.alike for i in group)]
        moments = [(i, " ".join(f"{x:.5g}" for x in principal_moments(body.inertia_com))) for i, body in bodies]
        each = "; ".join(f"link {i} {x}" for i, x in moments)
        yield f"  principal moments of the repeated links [kg m^2]: {each}"


def _patterns(ranking: Sequence[Candidate]) -> Iterator[str]:
    """Signs that hold together: where links are bound to one another, fewer patterns are left than link by link."""
    best = best_mirror_miss(ranking)
    patterns: dict[str, None] = {}
    for c in (c for c in ranking if np.isfinite(c.mirror_miss) and c.is_mirrored(best)):
        cells = "".join(f" with {x.name} = {x.value:g}" for x in c.reading.cells)
        patterns.setdefault(_signs(c) + cells)
    if len(patterns) > 1:
        shown = ", ".join(list(patterns)[:MOST_PATTERNS])
        yield f"  signs hold together (t tensor, i +integral, link by link); the patterns left, best first: {shown}"


def _signs(c: Candidate) -> str:
    return "".join(x.products[0] for x in c.reading.links)


def _decision(d: Decision, what: str) -> str:
    question = f"{what}: {_QUESTIONS[d.question]}"
    if d.answer == NO_DIFFERENCE:
        return f"{question}: no choice makes a difference to the printed digits"
    head = f"{question} {_ANSWERS.get(d.answer, d.answer)}"
    if d.decided:
        decided = "likely, by" if d.by == ("repeated links",) else "decided by"
        return f"{head} ({decided} {', '.join(d.by)})"
    many = len(d.others) > SHOWN
    others = f"any of {len(d.others)} other orders" if many else " or ".join(_ANSWERS.get(x, x) for x in d.others)
    prefers = f"{d.by[0]} prefer the first" if d.by else "nothing prefers one"
    return f"{head} (UNDECIDED, or {others}; {prefers})"


def _conflict(result: RankedReadings) -> Iterator[str]:
    if not result.computed:
        return
    if not result.both:
        yield "the authors' reading is not one of bodies that can exist"
        return
    yield (
        f"the two readings differ: repeated links differ by {best_mirror_miss(result.both):.2%} in the best reading"
        f" that gives the numbers, by {best_mirror_miss(result.physical):.2%} in this one"
    )
    if (result.computed[0].reading.table.about, result.physical[0].reading.table.about) == ("com", "origin"):
        yield (
            "if this one is right, the authors took tensors about the frames' origins as central ones: "
            "m c^2 is counted twice"
        )


def _row(number: int, c: Candidate) -> tuple[Any, ...]:
    moved = [f"{i + 1}:{x.axes}{'+com' if x.moves == 'row' else ''}" for i, x in enumerate(c.reading.links) if x.moved]
    cells = [f"{x.name}={x.value:g}" for x in c.reading.cells]
    table = c.reading.table
    return (
        str(number), table.convention.value, table.about, table.com_from, _signs(c), " ".join(moved) or "none",
        " ".join(cells) or "none", str(c.exceptions), f"{c.mirror_miss:.2%}" if np.isfinite(c.mirror_miss) else "-",
        c.log_inertia_volume,
    )  # fmt: skip
