"""Sentences about the criteria: what each hypothesis gives of frames, bodies, second tensors and published numbers."""

from collections.abc import Iterable, Iterator

import numpy as np

from lwr_dyn.checks.conventions.candidates import best_mirror_miss, candidates
from lwr_dyn.checks.conventions.cell_corrections import CellCorrection
from lwr_dyn.checks.conventions.global_maximum_check import global_maxima, off_lattice
from lwr_dyn.checks.conventions.hypotheses import TableHypothesis
from lwr_dyn.checks.conventions.ranking import RankedReadings, equally_plain
from lwr_dyn.checks.conventions.search import SearchResult

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
            far = (
                f"{search.nearest:.3g} times its room" if np.isfinite(search.nearest) else "infinitely many half digits"
            )
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
