"""Candidate readings of a hypothesis, in their order; a link read otherwise than the rest counts as an exception."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, TypedDict

import numpy as np

from lwr_dyn.checks.conventions.hypotheses import TableHypothesis, mirror_misses, rounding_miss
from lwr_dyn.checks.conventions.printed_table import PRODUCTS, LinkChoice, Products, TableReading
from lwr_dyn.checks.conventions.search import OptionSets, misfit
from lwr_dyn.model.chain import Body

MOST_CANDIDATES = 200
"""Candidates that are kept, the best first."""
SIGNIFICANT = 0.5
"""Logs of likelihoods are compared in these steps: a smaller difference means nothing."""
PRICE = 3.0
"""Cost of an exception: one link in twenty is read otherwise than its table, e^-3."""
NO_BODY = -1e6
"""In place of the volume of an inertia that no body has, -inf."""
FACTOR = 2.0
"""Mirror misses within this factor of the smallest count as equally good."""


class CellRecord(TypedDict):
    """A cell that is read otherwise than it is printed, SI."""

    printed: float
    read: float


class ReadingRecord(TypedDict):
    """A candidate as JSON values."""

    convention: Annotated[Literal["standard", "modified"], "DH convention."]
    about: Annotated[str, "What the tensors are about: com or origin."]
    com_from: Annotated[str, "The end of the link that centres of mass are measured from."]
    products: Annotated[list[str], "Link by link: tensor entries or +integral."]
    axes: Annotated[list[str], "Order of the axes, link by link."]
    axes_move: Annotated[list[str], "What another order moves, link by link."]
    rows_lower: Annotated[int, "By how many rows the centres of mass belong lower."]
    cells: Annotated[dict[str, CellRecord], "Cells that are corrected, by name; SI."]
    exceptions: Annotated[int, "Links that are read apart from the rest."]
    mirror_miss: Annotated[float, "Share of their tensors by which repeated links differ; null without any."]
    infeasible: Annotated[list[str], "Links that cannot be bodies."]
    fullness: Annotated[float, "Log of the volume of the bodies' inertia; larger is fuller."]


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A reading with the figures of each criterion."""

    reading: TableReading
    bodies: tuple[Body, ...]
    exceptions: int
    """Links that are read otherwise than the rest of the table."""
    mirror_miss: float
    """Largest miss of repeated links in units of their printed tensor, 0 where rounding explains it, NaN without."""
    misfit: float
    """Half the chi-square of the published numbers, 0 without any."""
    infeasible: tuple[str, ...]
    """Links that cannot be bodies."""
    log_inertia_volume: float
    """Sum over the links of log det of their second moments: larger is more plausible."""
    remaining: tuple[tuple[tuple[LinkChoice, ...], ...], ...]
    """Per link every body that the same criteria leave open, as the choices that give it, this one's first."""
    alike: tuple[tuple[int, ...], ...]
    """Groups of repeated links that agree."""

    @property
    def price(self) -> float:
        """Exceptions and misfit on one scale, that of a negative log likelihood."""
        return PRICE * self.exceptions + self.misfit

    @property
    def volume_level(self) -> int:
        """Log volume of inertia, rounded to significant steps."""
        return round(max(self.log_inertia_volume, NO_BODY) / SIGNIFICANT)

    def is_mirrored(self, best: float) -> bool:
        """Repeated links agree as well as in the best, within the factor that counts as equal."""
        return not np.isfinite(self.mirror_miss) or self.mirror_miss <= FACTOR * best

    def record(self) -> ReadingRecord:
        """As JSON values."""
        r = self.reading
        return {
            "convention": r.table.convention.value, "about": r.table.about, "com_from": r.table.com_from,
            "products": [x.products for x in r.links], "axes": [x.axes for x in r.links],
            "axes_move": [x.moves for x in r.links], "rows_lower": r.shift,
            "cells": {x.name: {"printed": x.printed, "read": x.value} for x in r.cells},
            "exceptions": self.exceptions, "mirror_miss": self.mirror_miss, "infeasible": [*self.infeasible],
            "fullness": self.log_inertia_volume,
        }  # fmt: skip


Agreeing = list[dict[int, tuple[int, ...]]]
"""Options of alike links that agree, link -> options, an entry per agreeing option of the first of them."""


def candidates(hypothesis: TableHypothesis, sets: OptionSets, mirrored: bool = True) -> tuple[Candidate, ...]:
    """The plainest readings in sets of options, one for each sign that the table's products may have as a rule.

    With `mirrored` repeated links must agree as well as they can; without, they are read one by one.
    """
    groups = [_agreement(hypothesis, sets, group) for group in hypothesis.alike] if mirrored else []
    remaining = [tuple(s) for s in sets]
    for _, kept in groups:  # per link the options that some agreeing combination uses
        for link in kept[0]:
            remaining[link] = tuple(sorted({o for row in kept for o in row[link]}))
    miss, out = max((miss for miss, _ in groups), default=float("nan")), []
    for rule in PRODUCTS:
        picked = [_plainest(hypothesis, i, options, rule) for i, options in enumerate(sets)]
        for _, kept in groups:
            for link, option in _plainest_group(hypothesis, kept, rule).items():
                picked[link] = option
        out.append(_candidate(hypothesis, picked, rule, remaining, miss))
    return tuple(out)


def exceptions_of(choice: LinkChoice, rule: Products) -> int:
    """How often a link departs from the rule of its table."""
    return int(choice.products != rule) + int(choice.moved) + int(choice.moves == "row")


def fewest_exceptions(hypothesis: TableHypothesis, sets: OptionSets) -> int:
    """Exceptions of the plainest reading in sets of options; repeated links need not agree."""
    return min(
        sum(_cost(hypothesis, i, _plainest(hypothesis, i, options, rule), rule)[0] for i, options in enumerate(sets))
        for rule in PRODUCTS
    )


def _cost(hypothesis: TableHypothesis, link: int, option: int, rule: Products) -> tuple[int, float]:
    options = hypothesis.options[link]
    fewest = min(exceptions_of(c, rule) for c in options.choices[option])
    return fewest, -float(options.log_inertia_volume[option])


def _plainest(hypothesis: TableHypothesis, link: int, options: Sequence[int], rule: Products) -> int:
    return min(options, key=lambda o: _cost(hypothesis, link, o, rule))


def _agreement(hypothesis: TableHypothesis, sets: OptionSets, group: Sequence[int]) -> tuple[float, Agreeing]:
    """The miss of alike links, 0 where rounding explains it, and their options that agree as well as that."""
    options, (first, *others) = hypothesis.options, group
    misses = [mirror_misses(options[first], options[i], sets[first], sets[i]) for i in others]
    each = np.array([m.min(axis=1) for m in misses]).max(axis=0)
    floor = rounding_miss(hypothesis.table, options, group)
    best = float(each.min())
    bound = max(FACTOR * best, floor) if np.isfinite(best) else np.inf
    kept = []
    for a in np.flatnonzero(each <= bound):
        row: dict[int, tuple[int, ...]] = {first: (sets[first][a],)}
        for i, m in zip(others, misses, strict=True):
            row[i] = tuple(sets[i][b] for b in np.flatnonzero(m[a] <= bound))
        kept.append(row)
    return 0.0 if best <= floor else best, kept


def _plainest_group(hypothesis: TableHypothesis, kept: Agreeing, rule: Products) -> dict[int, int]:
    def total(picked: dict[int, int]) -> tuple[float, float]:
        exceptions, volumes = zip(*(_cost(hypothesis, i, o, rule) for i, o in picked.items()), strict=True)
        return sum(exceptions), sum(volumes)

    ways = ({i: _plainest(hypothesis, i, o, rule) for i, o in row.items()} for row in kept)
    return min(ways, key=total)


def _candidate(
    hypothesis: TableHypothesis,
    picked: Sequence[int],
    rule: Products,
    remaining: Sequence[tuple[int, ...]],
    miss: float,
) -> Candidate:
    options = hypothesis.options
    chosen = [min(options[i].choices[o], key=lambda c: exceptions_of(c, rule)) for i, o in enumerate(picked)]
    return Candidate(
        reading=TableReading(hypothesis.choice, tuple(chosen), hypothesis.shift, hypothesis.cells),
        bodies=tuple(o.body(k) for o, k in zip(options, picked, strict=True)),
        exceptions=sum(exceptions_of(c, rule) for c in chosen),
        mirror_miss=miss,
        misfit=misfit(hypothesis.rows, options, picked),
        infeasible=tuple(f"link_{i + 1}" for i, o in enumerate(picked) if o not in hypothesis.feasible[i]),
        log_inertia_volume=float(sum(o.log_inertia_volume[k] for o, k in zip(options, picked, strict=True))),
        remaining=tuple(
            (options[i].choices[o], *(options[i].choices[k] for k in remaining[i] if k != o))
            for i, o in enumerate(picked)
        ),
        alike=() if np.isnan(miss) else hypothesis.alike,
    )


def best_mirror_miss(readings: Sequence[Candidate]) -> float:
    """The smallest mirror miss of some candidates, 0 without repeated links."""
    return min((c.mirror_miss for c in readings if np.isfinite(c.mirror_miss)), default=0.0)


def ranked(readings: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """The best first: repeated links agree, then fewest exceptions and nearest numbers, then the largest volumes."""
    best = best_mirror_miss(readings)

    def key(c: Candidate) -> tuple[float, int, int, int]:
        tier = 0.0 if c.is_mirrored(best) else c.mirror_miss
        return (tier, round(c.price / SIGNIFICANT), c.exceptions, -c.volume_level)

    unique: dict[tuple[object, ...], Candidate] = {}
    for c in sorted(readings, key=key):
        unique.setdefault((c.reading.table, c.reading.links, c.reading.cells), c)
    return tuple(itertools.islice(unique.values(), MOST_CANDIDATES))
