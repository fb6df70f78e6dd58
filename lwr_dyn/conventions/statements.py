"""A resolution in sentences: each criterion with its figures, what it decides, and what nothing decides."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lwr_dyn.conventions.candidates import Candidate, best_mirror_miss, candidates
from lwr_dyn.conventions.decisions import Decision, decisions
from lwr_dyn.conventions.resolve import Resolution, equally_plain

_SAYS = {
    "convention": "DH convention", "about": "tensors are about", "com_from": "centres of mass are measured from",
    "products": "products of inertia", "axes": "order of the axes",
}  # fmt: skip
_WORDS = {
    "com": "the centre of mass", "origin": "the frame's origin", "integral": "+integral", "tensor": "tensor entries",
    "xyz": "as printed", "own frame": "the link's own frame", "other end": "the link's other end",
}  # fmt: skip


SHOWN = 2
"""Open answers that are listed one by one."""


def statements(found: Resolution) -> list[str]:
    """What was found, line by line."""
    lines = [*_frames(found), *_numbers(found), *_repairs(found)]
    if found.computed:
        lines += ["", "what the authors computed with (reading that gives every published number):"]
        lines += _reading(found, found.computed, ("published numbers",))
    if found.agree and found.evidence.numbers:
        lines += ["", "what the arm is (the same numbers, and bodies that can exist):"]
        lines += _reading(found, found.both, _criteria(found, numbers=True))
    elif found.physical:
        lines += ["", "what the arm is (bodies that can exist, whatever was computed with them):"]
        lines += _reading(found, found.physical, _criteria(found, numbers=False))
        lines += _conflict(found)
    else:
        lines += ["", "no reading lets every link be a body" + _second_words(found)]
    return lines


def _criteria(found: Resolution, numbers: bool) -> list[str]:
    every = {
        "feasibility": True, "second tensors": found.evidence.tensors is not None,
        "repeated links": any(w.alike for _, _, w in found.cases), "published numbers": numbers,
    }  # fmt: skip
    return [name for name, asked in every.items() if asked]


def _frames(found: Resolution) -> list[str]:
    out = []
    for f in found.frames[:4]:
        words = []
        if found.table.origin is not None:
            rows = "as printed" if f.shift == 0 else f"{abs(f.shift)} row{'s' * (abs(f.shift) > 1)} {_down(f.shift)}"
            words.append(f"vectors between frames {rows}: {f.rows_missed} rows miss the DH table (by {f.miss:.3g} m)")
        if found.evidence.places:
            words.append(f"{f.places_missed} flange places missed (by {f.place_miss:.2g} m)")
        if words:
            out.append(f"frames, {f.convention.value} DH: {'; '.join(words)}")
    if found.frames[0].shift:
        out.append("the row that falls out below is the centre of mass that is blank beside it")
    return out


def _down(shift: int) -> str:
    return "lower" if shift > 0 else "higher"


def _numbers(found: Resolution) -> list[str]:
    """How far every table choice comes with the cells as printed."""
    out = []
    total, ordered = len(found.evidence.numbers), sorted(found.evidence.numbers, key=lambda x: -x.joint)
    for w, fit in zip(found.worlds, found.fits, strict=True):
        words = []
        impossible = [str(i + 1) for i, options in enumerate(w.feasible) if not options]
        words.append(f"links {', '.join(impossible)} cannot be bodies" if impossible else "every link can be a body")
        if found.evidence.tensors is not None:
            words.append(f"second tensors of {sum(bool(x) for x in w.second)} of {found.table.n} links come out")
        if total:
            rest = "" if fit.boxes else f", then {ordered[fit.failed[0]].name} misses by {_times(fit.nearest)}"
            words.append(f"{fit.matched} of {total} published numbers come out{rest}")
        if w.alike and not impossible:
            words.append(f"repeated links ({_groups(w.alike)}) differ by {_mirror(found, k_of(found, w)):.2%}")
        c = w.choice
        out.append(f"{c.convention.value} DH, about {c.about}, com from {c.com_from}: {'; '.join(words)}")
    return out


def k_of(found: Resolution, world: object) -> int:
    """Index of a world among the worlds of the cells as printed."""
    return next(i for i, w in enumerate(found.worlds) if w is world)


def _mirror(found: Resolution, k: int) -> float:
    w = found.worlds[k]
    return best_mirror_miss(candidates(found.table, w, w.feasible))


def _groups(alike: Sequence[Sequence[int]]) -> str:
    return "; ".join(", ".join(str(i + 1) for i in group) for group in alike)


def _times(x: float) -> str:
    return "infinitely many half digits" if not np.isfinite(x) else f"{x:.3g} times its room"


def _repairs(found: Resolution) -> list[str]:
    if not found.repairs:
        return ["no single cell mends it"] if _stuck(found) else []
    kept, out = equally_plain(found.repairs), []
    first = kept[0]
    values = " or ".join(f"{r.cell.value:g}" for r in kept)
    repeats = f"; the printed one repeats {first.repeats}" if first.repeats else ""
    out.append(
        f"one cell mends it: {first.cell.name}, printed {first.cell.printed:g}, fitted to {first.fitted_to} alone: {values} "
        f"(between {first.low:.5g} and {first.high:.5g}); the other {first.followed} numbers then follow{repeats}"
    )
    if len(kept) > 1:
        out.append(f"the sign of {first.cell.name} is undecided: no published number shows it; the printed one is kept")
    rest = [r for r in found.repairs if r not in kept]
    if rest:
        others = sorted({(r.exceptions, r.cell.name, f"{abs(r.cell.value):g}") for r in rest})
        words = ", ".join(f"|{name}| = {value} ({exceptions} links read apart)" for exceptions, name, value in others)
        out.append(f"other cells would do with more links read apart than {first.exceptions}: {words}")
    return out


def _stuck(found: Resolution) -> bool:
    return bool(found.evidence.numbers) and not found.computed


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
    return [*out, f"  figures: {'; '.join(figures)}"]


def _decision(d: Decision, what: str) -> str:
    head = f"{what}: {_SAYS[d.question]} {_WORDS.get(d.answer, d.answer)}"
    if d.answer == "no difference":
        return f"{what}: {_SAYS[d.question]}: no choice makes a difference to the printed digits"
    if d.decided:
        return f"{head} (decided by {', '.join(d.by)})"
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
        f"the two readings differ: repeated links differ by {figures[0]:.2%} in the best reading that gives the numbers, "
        f"by {figures[1]:.2%} in this one"
    ]
    if (a.about, b.about) == ("com", "origin"):
        out.append("so the authors took tensors about the frames' origins as central ones: m c^2 is counted twice")
    return out


def _second_words(found: Resolution) -> str:
    return " and gives the second tensors" if found.evidence.tensors is not None else ""


def ranking_rows(ranking: Sequence[Candidate], most: int = 6) -> list[tuple[str, ...]]:
    """The first readings of a ranking as rows of a table: signs as t(ensor) and i(ntegral), link by link."""
    rows = []
    for k, c in enumerate(ranking[:most]):
        moved = [f"{i + 1}:{x.axes}{'+com' if x.moves == 'row' else ''}" for i, x in enumerate(c.reading.links) if x.moved]
        rows.append((
            str(k + 1), c.reading.table.about, c.reading.table.com_from,
            "".join(x.products[0] for x in c.reading.links), " ".join(moved) or "none",
            " ".join(f"{x.name}={x.value:g}" for x in c.reading.cells) or "none", str(c.exceptions),
            f"{c.mirror_miss:.2%}" if np.isfinite(c.mirror_miss) else "-", f"{c.fullness:.1f}",
        ))  # fmt: skip
    return rows
