"""From options that remain to readings that can be ranked: repeated links must agree, exceptions are counted."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.audit.conventions.choices import CellChange, LinkChoice, Products, Reading
from lwr_dyn.audit.conventions.mirror import mirror_misses, rounding_miss
from lwr_dyn.audit.conventions.physics import fullness
from lwr_dyn.audit.conventions.printed import PrintedTable
from lwr_dyn.audit.conventions.search import Box, misfit
from lwr_dyn.audit.conventions.worlds import World
from lwr_dyn.model.chain import Body

PRODUCTS: tuple[Products, ...] = ("tensor", "integral")
Moved = tuple[int, tuple[CellChange, ...]]
"""Rows by which a column was moved and cells that were changed before the table was read."""
NOTHING_MOVED: Moved = (0, ())
MOST = 200
"""Candidates that are kept, the best first."""
TOLD_APART = 0.5
"""Logs of likelihoods are compared in these steps: a smaller difference says nothing."""
PRICE = 3.0
"""What an exception costs: a link read otherwise than its table is met once in twenty, e^-3."""
NO_BODY = -1e6
"""Stands for the fullness of what is no body, -inf."""
FACTOR = 2.0
"""Mirror misses within this factor of the smallest count as equally good."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A reading with what each criterion says of it."""

    reading: Reading
    bodies: tuple[Body, ...]
    exceptions: int
    """Links that are read otherwise than the rest of the table."""
    mirror_miss: float
    """Largest miss of repeated links in units of their printed tensor, 0 where rounding explains it, NaN without."""
    misfit: float
    """Half the chi-square of the published numbers, 0 without any."""
    infeasible: tuple[str, ...]
    """Links that could not be bodies."""
    fullness: float
    """Sum over the links of log det of their second moments: larger is more plausible."""
    remaining: tuple[tuple[tuple[LinkChoice, ...], ...], ...]
    """Per link every body that the same criteria leave open, as the choices that give it, this one's first."""
    alike: tuple[tuple[int, ...], ...]
    """Groups of repeated links that were made to agree."""

    def leaves_open(self, link: int, choice: LinkChoice) -> bool:
        """The criteria do not exclude a choice."""
        return any(choice in equal for equal in self.remaining[link])


@dataclass(frozen=True, slots=True, eq=False)
class _Agreement:
    """Options of alike links that agree with one another, per option of the first of them."""

    miss: float
    kept: tuple[dict[int, tuple[int, ...]], ...]
    """One entry per agreeing option of the group's first link: link -> options."""


def candidates(
    table: PrintedTable, world: World, box: Box, moved: Moved = NOTHING_MOVED, mirrored: bool = True
) -> tuple[Candidate, ...]:
    """The plainest readings in a box, one for each sign that the table's products may have as a rule.

    With `mirrored` repeated links must agree as well as they can; without, they are read one by one.
    """
    groups = [_agreement(table, world, box, group) for group in world.alike] if mirrored else []
    out = []
    for sign in PRODUCTS:
        picked = [_plainest(world, i, box[i], sign) for i in range(table.n)]
        for agreement in groups:
            for link, option in _plainest_group(world, agreement, sign).items():
                picked[link] = option
        out.append(_candidate(table, world, picked, sign, _open(world, box, groups), groups, moved))
    return tuple(out)


def exceptions_of(choice: LinkChoice, rule: Products) -> int:
    """How often a link departs from the rule of its table."""
    return int(choice.products != rule) + int(choice.moved) + int(choice.moves == "row")


def fewest_exceptions(world: World, box: Box) -> int:
    """Exceptions of the plainest reading in a box, whatever its repeated links."""
    return min(sum(_cost(world, i, _plainest(world, i, o, s), s)[0] for i, o in enumerate(box)) for s in PRODUCTS)


def _cost(world: World, link: int, option: int, rule: Products) -> tuple[int, float]:
    found = world.options[link]
    fewest = min(exceptions_of(c, rule) for c in found.choices[option])
    return fewest, -float(fullness(found)[option])


def _plainest(world: World, link: int, options: Sequence[int], rule: Products) -> int:
    return min(options, key=lambda o: _cost(world, link, o, rule))


def _agreement(table: PrintedTable, world: World, box: Box, group: Sequence[int]) -> _Agreement:
    first, *others = group
    misses = [mirror_misses(world.options[first], world.options[i], box[first], box[i]) for i in others]
    each = np.array([m.min(axis=1) for m in misses]).max(axis=0)
    floor = rounding_miss(table, world.options, group)
    best = float(each.min())
    bound = max(FACTOR * best, floor) if np.isfinite(best) else np.inf
    kept = []
    for a in np.flatnonzero(each <= bound):
        row: dict[int, tuple[int, ...]] = {first: (box[first][a],)}
        for i, m in zip(others, misses, strict=True):
            row[i] = tuple(box[i][b] for b in np.flatnonzero(m[a] <= bound))
        kept.append(row)
    return _Agreement(0.0 if best <= floor else best, tuple(kept))


def _plainest_group(world: World, agreement: _Agreement, rule: Products) -> dict[int, int]:
    ways = [{i: _plainest(world, i, o, rule) for i, o in row.items()} for row in agreement.kept]
    costs = [[_cost(world, i, o, rule) for i, o in way.items()] for way in ways]
    totals = [(sum(c[0] for c in cost), sum(c[1] for c in cost)) for cost in costs]
    return ways[min(range(len(ways)), key=lambda k: totals[k])]


def _open(world: World, box: Box, groups: Sequence[_Agreement]) -> list[tuple[int, ...]]:
    """Per link the options that some agreeing combination uses."""
    left = [tuple(b) for b in box]
    for agreement in groups:
        for link in agreement.kept[0]:
            left[link] = tuple(sorted({o for row in agreement.kept for o in row[link]}))
    return left


def _candidate(
    table: PrintedTable, world: World, picked: Sequence[int], rule: Products, left: Sequence[tuple[int, ...]],
    groups: Sequence[_Agreement], moved: Moved,
) -> Candidate:  # fmt: skip
    chosen = [min(world.options[i].choices[o], key=lambda c: exceptions_of(c, rule)) for i, o in enumerate(picked)]
    remaining = tuple(
        (world.options[i].choices[o], *(world.options[i].choices[k] for k in left[i] if k != o))
        for i, o in enumerate(picked)
    )
    return Candidate(
        reading=Reading(world.choice, tuple(chosen), *moved),
        bodies=tuple(o.body(k) for o, k in zip(world.options, picked, strict=True)),
        exceptions=sum(exceptions_of(c, rule) for c in chosen),
        mirror_miss=max((g.miss for g in groups), default=float("nan")),
        misfit=misfit(world.rows, world.options, picked),
        infeasible=tuple(f"link_{i + 1}" for i, o in enumerate(picked) if o not in world.feasible[i]),
        fullness=float(sum(fullness(o)[k] for o, k in zip(world.options, picked, strict=True))),
        remaining=remaining, alike=world.alike if groups else (),
    )  # fmt: skip


def as_mirrored(found: Candidate, best: float) -> bool:
    """Repeated links agree as well as in the best, within the factor that counts as equal."""
    return not np.isfinite(found.mirror_miss) or found.mirror_miss <= FACTOR * best


def best_mirror_miss(found: Sequence[Candidate]) -> float:
    """The smallest mirror miss of some candidates, 0 without repeated links."""
    return min((c.mirror_miss for c in found if np.isfinite(c.mirror_miss)), default=0.0)


def price(found: Candidate) -> float:
    """Exceptions and misfit on one scale, that of a negative log likelihood."""
    return PRICE * found.exceptions + found.misfit


def fullness_step(found: Candidate) -> int:
    """Fullness in steps that say something."""
    return round(max(found.fullness, NO_BODY) / TOLD_APART)


def ranked(found: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """The best first: repeated links agree, then fewest exceptions and nearest numbers, then the fullest bodies."""
    best = best_mirror_miss(found)

    def key(c: Candidate) -> tuple[float, int, int, int]:
        tier = 0.0 if as_mirrored(c, best) else c.mirror_miss
        return (tier, round(price(c) / TOLD_APART), c.exceptions, -fullness_step(c))

    unique: dict[tuple[object, ...], Candidate] = {}
    for c in sorted(found, key=key):
        unique.setdefault((c.reading.table, c.reading.links, c.reading.cells), c)
    return tuple(itertools.islice(unique.values(), MOST))
