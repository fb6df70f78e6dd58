"""Ranked readings as sentences and tables: what each criterion gives and decides, and what nothing decides.

The largest B_ii of the authors' reading is also sought by the global search of `control.inertia.worst_case`.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lwr_dyn.checks.conventions.candidates import Candidate, best_mirror_miss, candidates
from lwr_dyn.checks.conventions.cell_corrections import CellCorrection
from lwr_dyn.checks.conventions.evidence import DerivedNumber, Evidence
from lwr_dyn.checks.conventions.hypotheses import TableHypothesis
from lwr_dyn.checks.conventions.printed_table import PrintedTable
from lwr_dyn.checks.conventions.ranking import NO_DIFFERENCE, Decision, RankedReadings, decisions, equally_plain
from lwr_dyn.checks.conventions.search import SearchResult, values
from lwr_dyn.control.inertia.worst_case import worst_case_inertia
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Body, Convention, Rotor, with_bodies
from lwr_dyn.model.spatial import principal_moments


@dataclass(frozen=True, slots=True)
class GlobalMaximum:
    """A published largest B_ii beside the one that the global search finds [kg m^2]."""

    number: DerivedNumber
    value: float

    @property
    def holds(self) -> bool:
        """The value has the printed digits."""
        return abs(self.value - self.number.printed.value) <= self.number.printed.half * (1.0 + 1e-6)


def global_maxima(table: PrintedTable, evidence: Evidence, candidate: Candidate) -> tuple[GlobalMaximum, ...]:
    """Every published largest B_ii under a reading, the base's first."""
    arm = arm_of(table, candidate.reading.table.convention, candidate.bodies)
    numbers = [x for x in evidence.numbers if x.quantity == "worst inertia"]
    return tuple(
        GlobalMaximum(x, worst_case_inertia(arm, x.joint).value) for x in sorted(numbers, key=lambda x: x.joint)
    )


def off_lattice(evidence: Evidence, hypothesis: TableHypothesis) -> tuple[tuple[str, float], ...]:
    """Numbers whose largest B_ii lies off the lattice of quarter turns in the plainest reading, by which share.

    The readings are sought on the lattice: for such numbers the search misses the truth, and they should be given
    with their poses instead.
    """
    table, options = hypothesis.table, hypothesis.options
    arm = arm_of(table, hypothesis.choice.convention, [o.body(0) for o in options])
    on_lattice = values(hypothesis.rows, options, [0] * table.n)
    out = []
    for lattice, number in zip(on_lattice, evidence.outermost_first, strict=True):
        if number.quantity == "worst inertia":
            exact = worst_case_inertia(arm, number.joint).value - float(arm.armature[number.joint])
            if exact - lattice > number.printed.half:
                out.append((number.name, float(exact / lattice - 1.0)))
    return tuple(out)


def arm_of(table: PrintedTable, convention: Convention, bodies: Sequence[Body]) -> Arm:
    """The arm of a table with these bodies, its joint box, and its rotors as armature."""
    chain = with_bodies(table.chain(convention), bodies)
    if table.armature is not None:
        rotors = [Rotor(1.0, float(x), reflected=True) for x in table.armature]
        chain = replace(chain, links=tuple(replace(link, rotor=r) for link, r in zip(chain.links, rotors, strict=True)))
    sides = [[None] * table.n if side is None else side.tolist() for side in (table.lower, table.upper)]
    limits = tuple(JointLimits(low, up) for low, up in zip(*sides, strict=True))
    return Arm(table.name, "resolved", table.name, chain, limits)


FRAMES_SHOWN = 4
"""Pairs of DH convention and row shift that are listed, the best first."""


def criteria_text(result: RankedReadings) -> list[str]:
    """All sentences about the criteria."""
    bound = "no reading keeps every radius of gyration within its link's length: that bound is dropped"
    return [
        *_frames(result),
        *lattice_warning(result),
        *(_hypothesis(result, h, s) for h, s in zip(result.as_printed, result.searches, strict=True)),
        *_corrections(result),
        *([] if result.bounded else [bound]),
    ]


def _frames(result: RankedReadings) -> Iterator[str]:
    """Row shifts and DH conventions against what is printed of the frames."""
    for f in result.frames[:FRAMES_SHOWN]:
        words = []
        if result.table.origin is not None:
            rows = "as printed"
            if f.shift:
                rows = f"{abs(f.shift)} row{'s' * (abs(f.shift) > 1)} {'lower' if f.shift > 0 else 'higher'}"
            words.append(f"vectors between frames {rows}: {f.rows_missed} rows miss the DH table (by {f.miss:.3g} m)")
        if result.evidence.places:
            words.append(f"{f.places_missed} flange places missed (by {f.place_miss:.2g} m)")
        if words:
            yield f"frames, {f.convention.value} DH: {'; '.join(words)}"
    if result.frames[0].shift:
        yield "the row that falls out below is the centre of mass that is blank beside it"


def _hypothesis(result: RankedReadings, h: TableHypothesis, search: SearchResult) -> str:
    """What a hypothesis gives with the cells as printed."""
    impossible = [str(i + 1) for i, options in enumerate(h.feasible) if not options]
    words = [f"links {', '.join(impossible)} cannot be bodies" if impossible else "every link can be a body"]
    if result.evidence.tensors is not None:
        words.append(f"second tensors of {sum(bool(x) for x in h.second)} of {result.table.n} links come out")
    if result.evidence.numbers:
        rest = ""
        if not search.sets:
            known = np.isfinite(search.nearest)
            far = f"{search.nearest:.3g} times its room" if known else "infinitely many half digits"
            rest = f", then {result.evidence.outermost_first[search.failed[0]].name} misses by {far}"
        words.append(f"{search.matched} of {len(result.evidence.numbers)} published numbers come out{rest}")
    if h.alike and not impossible:
        groups = "; ".join(", ".join(str(i + 1) for i in group) for group in h.alike)
        words.append(f"repeated links ({groups}) differ by {best_mirror_miss(candidates(h, h.feasible)):.2%}")
    c = h.choice
    return f"{c.convention.value} DH, about {c.about}, com from {c.com_from}: {'; '.join(words)}"


def _corrections(result: RankedReadings) -> Iterator[str]:
    """The single cell that corrects the table, its values, and other cells that would correct it too."""
    if not result.corrections:
        if result.evidence.numbers and not result.computed:
            yield "no single cell mends it"
        return
    kept = equally_plain(result.corrections)
    first = kept[0]
    name, repeats = first.cell.name, f"the printed one repeats {first.repeats}"
    values = " or ".join(f"{c.cell.value:g}" for c in kept)
    yield (
        f"one cell mends it: {name}, printed {first.cell.printed:g}, fitted to {first.fitted_to} alone: "
        f"{values} (between {first.low:.5g} and {first.high:.5g}); "
        f"the other {first.followed} numbers then follow{'; ' + repeats if first.repeats else ''}"
    )
    if len(kept) > 1:
        yield f"the sign of {name} is undecided: no published number shows it; the printed one is kept"
    equal = _cells(c for c in result.corrections if c.cell.name != name and c.exceptions == first.exceptions)
    if equal:
        why = f"{name} is taken because {repeats}" if first.repeats else "nothing prefers one"
        yield f"the numbers alone do not single it out: {equal} would do as well; {why}"
    more = _cells(c for c in result.corrections if c.exceptions > first.exceptions)
    if more:
        yield f"with more links read apart from the rest than {first.exceptions} also: {more}"


def _cells(corrections: Iterable[CellCorrection]) -> str:
    return ", ".join(dict.fromkeys(f"|{c.cell.name}| = {abs(c.cell.value):g}" for c in corrections))


def global_maxima_text(result: RankedReadings) -> list[str]:
    """The largest B_ii of the authors' reading by the global search."""
    maxima = global_maxima(result.table, result.evidence, result.computed[0])
    if not maxima:
        return []
    each = ", ".join(f"{x.number.name} {x.value:.6g} ({x.number.printed.text})" for x in maxima)
    verdict = "all to the printed digits" if all(x.holds for x in maxima) else "NOT all to the printed digits"
    return [f"  largest B_ii by a global search over the joint box [kg m^2], printed in brackets: {each}: {verdict}"]


def lattice_warning(result: RankedReadings) -> list[str]:
    """Largest B_ii that the search misses, since they lie between quarter turns."""
    missed = off_lattice(result.evidence, result.as_printed[0])
    if not missed:
        return []
    each = ", ".join(f"{name} by {share:.2g}" for name, share in missed)
    return [f"largest B_ii are sought at quarter turns, and here they are larger in between ({each} of their value): "
            "they cannot judge a reading; give B_ii at stated poses"]  # fmt: skip


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
