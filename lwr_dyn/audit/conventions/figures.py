"""The criteria in figures: what each table choice gives of frames, bodies, second tensors and published numbers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from lwr_dyn.audit.conventions.candidates import best_mirror_miss, candidates
from lwr_dyn.audit.conventions.confirm import confirmed, off_lattice
from lwr_dyn.audit.conventions.repair import Repair
from lwr_dyn.audit.conventions.resolve import Resolution, equally_plain
from lwr_dyn.audit.conventions.worlds import World

FRAMES_SHOWN = 4
"""Pairs of DH convention and row shift that are listed, the best first."""


def frames_figures(found: Resolution) -> list[str]:
    """Row shifts and DH conventions against what is printed of the frames."""
    out = []
    for f in found.frames[:FRAMES_SHOWN]:
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


def numbers_figures(found: Resolution) -> list[str]:
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
            words.append(f"repeated links ({_groups(w.alike)}) differ by {_mirror(found, w):.2%}")
        c = w.choice
        out.append(f"{c.convention.value} DH, about {c.about}, com from {c.com_from}: {'; '.join(words)}")
    return out


def _mirror(found: Resolution, w: World) -> float:
    return best_mirror_miss(candidates(found.table, w, w.feasible))


def _groups(alike: Sequence[Sequence[int]]) -> str:
    return "; ".join(", ".join(str(i + 1) for i in group) for group in alike)


def _times(x: float) -> str:
    return "infinitely many half digits" if not np.isfinite(x) else f"{x:.3g} times its room"


def repair_figures(found: Resolution) -> list[str]:
    """Which single cell mends the table, to what, and what else would."""
    if not found.repairs:
        return ["no single cell mends it"] if _stuck(found) else []
    kept, out = equally_plain(found.repairs), []
    first = kept[0]
    values = " or ".join(f"{r.cell.value:g}" for r in kept)
    repeats = f"; the printed one repeats {first.repeats}" if first.repeats else ""
    out.append(
        f"one cell mends it: {first.cell.name}, printed {first.cell.printed:g}, fitted to {first.fitted_to} alone: "
        f"{values} (between {first.low:.5g} and {first.high:.5g}); "
        f"the other {first.followed} numbers then follow{repeats}"
    )
    if len(kept) > 1:
        out.append(f"the sign of {first.cell.name} is undecided: no published number shows it; the printed one is kept")
    equal = _cells(r for r in found.repairs if r.cell.name != first.cell.name and r.exceptions == first.exceptions)
    if equal:
        why = "nothing prefers one"
        if first.repeats:
            why = f"{first.cell.name} is taken because the printed one repeats {first.repeats}"
        out.append(f"the numbers alone do not single it out: {equal} would do as well; {why}")
    more = _cells(r for r in found.repairs if r.exceptions > first.exceptions)
    if more:
        out.append(f"with more links read apart from the rest than {first.exceptions} also: {more}")
    return out


def _cells(found: Iterable[Repair]) -> str:
    return ", ".join(dict.fromkeys(f"|{r.cell.name}| = {abs(r.cell.value):g}" for r in found))


def confirmed_figures(found: Resolution) -> list[str]:
    """The largest B_ii by the global search, since the readings were sought on a lattice."""
    if not found.computed:
        return []
    rows = confirmed(found.table, found.evidence, found.computed[0])
    if not rows:
        return []
    each = ", ".join(f"{x.number.name} {x.value:.6g} ({x.number.printed.text})" for x in rows)
    verdict = "all to the printed digits" if all(x.holds for x in rows) else "NOT all to the printed digits"
    return [f"  largest B_ii by a global search over the joint box [kg m^2], printed in brackets: {each}: {verdict}"]


def lattice_figures(found: Resolution) -> list[str]:
    """Largest B_ii that the search cannot see, since they lie between quarter turns."""
    missed = off_lattice(found.table, found.evidence, found.worlds[0])
    if not missed:
        return []
    each = ", ".join(f"{name} by {share:.2g}" for name, share in missed)
    return [f"largest B_ii are sought at quarter turns, and here they are larger in between ({each} of their value): "
            "they cannot judge a reading; give B_ii at stated poses"]  # fmt: skip


def _stuck(found: Resolution) -> bool:
    return bool(found.evidence.numbers) and not found.computed
