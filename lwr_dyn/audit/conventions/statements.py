"""A resolution in sentences: each criterion with its figures, what it decides, and what nothing decides."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lwr_dyn.audit.conventions.candidates import Candidate, as_mirrored, best_mirror_miss
from lwr_dyn.audit.conventions.decisions import Decision, decisions
from lwr_dyn.audit.conventions.figures import (
    confirmed_figures,
    frames_figures,
    lattice_figures,
    numbers_figures,
    repair_figures,
)
from lwr_dyn.audit.conventions.resolve import Resolution
from lwr_dyn.model.spatial import principal_moments

_SAYS = {
    "convention": "DH convention", "about": "tensors are about", "com_from": "centres of mass are measured from",
    "products": "products of inertia", "axes": "order of the axes",
}  # fmt: skip
_WORDS = {
    "com": "the centre of mass", "origin": "the frame's origin", "integral": "+integral", "tensor": "tensor entries",
    "xyz": "as printed", "own frame": "the link's own frame", "other end": "the link's other end",
}  # fmt: skip


MOST_PATTERNS = 4
"""Sign patterns that are listed."""
SHOWN = 2
"""Open answers that are listed one by one."""


def statements(found: Resolution) -> list[str]:
    """What was found, line by line."""
    bound = "no reading keeps every radius of gyration within its link's length: that bound is dropped"
    lines = [
        *frames_figures(found),
        *lattice_figures(found),
        *numbers_figures(found),
        *repair_figures(found),
        *([] if found.bounded else [bound]),
    ]
    if found.computed:
        lines += ["", "what the authors computed with (reading that gives every published number):"]
        lines += [*_reading(found, found.computed, ("published numbers",)), *confirmed_figures(found)]
    if found.agree and found.evidence.numbers:
        lines += ["", "what the arm is (the same numbers, and bodies that can exist):"]
        lines += _reading(found, found.both, criteria_of(found, numbers=True))
    elif found.physical:
        lines += ["", "what the arm is (bodies that can exist, whatever was computed with them):"]
        lines += _reading(found, found.physical, criteria_of(found, numbers=False))
        lines += _conflict(found)
    else:
        lines += ["", "no reading lets every link be a body" + _second_words(found)]
    return lines


def rankings(found: Resolution) -> dict[str, tuple[tuple[Candidate, ...], list[str]]]:
    """What the authors computed with and what the arm is: each ranking with the criteria that it obeys."""
    arm = (found.both, criteria_of(found, numbers=True)) if found.agree else (found.physical, criteria_of(found, False))
    return {"computed": (found.computed, ["published numbers"]), "arm": arm}


def criteria_of(found: Resolution, numbers: bool) -> list[str]:
    """The criteria that can be asked of this table."""
    every = {
        "feasibility": True, "second tensors": found.evidence.tensors is not None,
        "repeated links": any(w.alike for _, _, w in found.cases), "published numbers": numbers,
    }  # fmt: skip
    return [name for name, asked in every.items() if asked]


def _reading(found: Resolution, ranking: Sequence[Candidate], criteria: Sequence[str]) -> list[str]:
    """The first reading, choice by choice."""
    best = ranking[0]
    made = decisions(found, ranking, criteria)
    out = [f"  {_decision(d, 'the table')}" for d in made if d.link is None]
    for question in ("products", "axes"):
        groups: dict[tuple[object, ...], list[Decision]] = {}
        for d in (d for d in made if d.link is not None and d.question == question):
            groups.setdefault((d.answer, d.others, d.by), []).append(d)
        for members in groups.values():
            links = ", ".join(str((d.link or 0) + 1) for d in members)
            out.append(f"  {_decision(members[0], f'link {links}')}")
    figures = [f"{best.exceptions} links read apart from the rest"]
    if np.isfinite(best.mirror_miss):
        figures.append(f"repeated links differ by {best.mirror_miss:.2%} of their tensors")
    if best.infeasible:
        figures.append(f"not bodies: {', '.join(best.infeasible)}")
    out.append(f"  figures: {'; '.join(figures)}")
    return [*out, *_patterns(ranking), *_principal(best)]


def _patterns(ranking: Sequence[Candidate]) -> list[str]:
    """Signs that hold together: where links are bound to one another, fewer patterns are left than link by link."""
    top = [c for c in ranking if np.isfinite(c.mirror_miss) and as_mirrored(c, best_mirror_miss(ranking))]
    found: dict[str, None] = {}
    for c in top:
        cells = "".join(f" with {x.name} = {x.value:g}" for x in c.reading.cells)
        found.setdefault("".join(x.products[0] for x in c.reading.links) + cells)
    if len(found) < 2:
        return []
    shown = ", ".join(list(found)[:MOST_PATTERNS])
    return [f"  signs hold together (t tensor, i +integral, link by link); the patterns left, best first: {shown}"]


def _principal(best: Candidate) -> list[str]:
    if not np.isfinite(best.mirror_miss):
        return []
    words = []
    for i in sorted(i for group in best.alike for i in group):
        moments = " ".join(f"{x:.5g}" for x in principal_moments(best.bodies[i].inertia_com))
        words.append(f"link {i + 1} {moments}")
    return [f"  principal moments of the repeated links [kg m^2]: {'; '.join(words)}"]


def _decision(d: Decision, what: str) -> str:
    head = f"{what}: {_SAYS[d.question]} {_WORDS.get(d.answer, d.answer)}"
    if d.answer == "no difference":
        return f"{what}: {_SAYS[d.question]}: no choice makes a difference to the printed digits"
    if d.decided:
        how = "likely, by" if d.by == ("repeated links",) else "decided by"
        return f"{head} ({how} {', '.join(d.by)})"
    many = len(d.others) > SHOWN
    others = f"any of {len(d.others)} other orders" if many else " or ".join(_WORDS.get(x, x) for x in d.others)
    prefers = f"{d.by[0]} prefer the first" if d.by else "nothing prefers one"
    return f"{head} (UNDECIDED, or {others}; {prefers})"


def _conflict(found: Resolution) -> list[str]:
    if not found.computed:
        return []
    a, b = found.computed[0].reading.table, found.physical[0].reading.table
    if not found.both:
        return ["the authors' reading is not one of bodies that can exist"]
    figures = [best_mirror_miss(found.both), best_mirror_miss(found.physical)]
    out = [
        f"the two readings differ: repeated links differ by {figures[0]:.2%} in the best reading that gives the "
        f"numbers, by {figures[1]:.2%} in this one"
    ]
    if (a.about, b.about) == ("com", "origin"):
        out.append(
            "if this one is right, the authors took tensors about the frames' origins as central ones: "
            "m c^2 is counted twice"
        )
    return out


def _second_words(found: Resolution) -> str:
    return " and gives the second tensors" if found.evidence.tensors is not None else ""


def ranking_rows(ranking: Sequence[Candidate], most: int = 6) -> list[tuple[str, ...]]:
    """The first readings of a ranking as rows of a table: signs as t(ensor) and i(ntegral), link by link."""
    rows: list[tuple[str, ...]] = []
    for k, c in enumerate(ranking[:most]):
        links = [(i + 1, x) for i, x in enumerate(c.reading.links) if x.moved]
        moved = [f"{i}:{x.axes}{'+com' if x.moves == 'row' else ''}" for i, x in links]
        rows.append((
            str(k + 1), c.reading.table.convention.value, c.reading.table.about, c.reading.table.com_from,
            "".join(x.products[0] for x in c.reading.links), " ".join(moved) or "none",
            " ".join(f"{x.name}={x.value:g}" for x in c.reading.cells) or "none", str(c.exceptions),
            f"{c.mirror_miss:.2%}" if np.isfinite(c.mirror_miss) else "-", f"{c.fullness:.1f}",
        ))  # fmt: skip
    return rows
