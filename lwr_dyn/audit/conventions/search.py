"""Which bodies of the links give the published numbers: a search from the flange inward, one link at a time.

B_ii and g_i see only the links beyond joint i, so the last joint's numbers judge the last link alone, the next one's
two links, and so on: what a link adds is kept as one vector over all numbers still to come, options that add the same
are one class (no number can tell them apart), and what misses a number is dropped at once. The full product of all
links' options is never formed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arrays import Array
from lwr_dyn.audit.conventions.choices import LinkOptions
from lwr_dyn.audit.conventions.contributions import Rows

DEVIATIONS = 4.0
"""Standard deviations of the rounding of the table's cells that a number may be missed by beyond half a digit."""
SAME = 0.02
"""Two options add the same to a number when they differ by less than this share of what it may be missed by."""
PLAIN = 2
"""The first two options of a link have its axes as printed, the products with either sign."""
MOST = 3000
"""States carried at most; beyond it the plainest are kept."""

Box = tuple[tuple[int, ...], ...]
"""Per link the options that remain; every combination of them is a way to read the table."""


@dataclass(frozen=True, slots=True, eq=False)
class Fits:
    """What the search found: boxes that fit every number, or how far it came."""

    boxes: tuple[Box, ...]
    matched: int
    """Numbers matched before the search ran dry (all of them when it did not)."""
    failed: tuple[int, ...]
    """Indices into the rows of the numbers that no state matched."""
    partial: tuple[Box, ...]
    """Boxes of the links beyond the joint at which it ran dry."""
    nearest: float
    """Smallest miss of the failed numbers, in units of what they may be missed by."""


@dataclass(frozen=True, slots=True, eq=False)
class _Class:
    """Options of one link that add the same to every number."""

    members: tuple[int, ...]
    adds: Array


@dataclass(frozen=True, slots=True, eq=False)
class _States:
    """S states: what the links so far add to every row, and the boxes of options that add that."""

    sums: Array
    """(S, R)"""
    boxes: tuple[tuple[Box, ...], ...]


def fit_numbers(rows: Rows, options: Sequence[LinkOptions], allowed: Sequence[Sequence[int]]) -> Fits:
    """Every combination of the links' allowed options that gives all the numbers.

    Parameters
    ----------
    rows : Rows
        The numbers as linear rows.
    options : sequence of n LinkOptions
    allowed : sequence of n sequences of int
        The options of each link that come into question.
    """
    room = allowances(rows, options)
    per_row = np.repeat(room, np.diff(rows.start))
    states = _States(np.zeros((1, len(per_row))), (((),),))
    matched = 0
    for link in reversed(range(len(options))):
        classes = _classes(rows, options[link], allowed[link], link, per_row)
        grown = _grown(states, classes)
        here = [k for k, joint in enumerate(rows.joint) if joint == link]
        miss = misses(rows, grown.sums, room, here)
        good = np.flatnonzero(miss <= 1.0)
        if len(good) == 0:
            partial = tuple(box for boxes in states.boxes for box in boxes)
            return Fits((), matched, tuple(here), partial, float(miss.min(initial=np.inf)))
        matched += len(here)
        states = _merged(rows, grown, good, link, per_row)
    boxes = sorted((box for boxes in states.boxes for box in boxes), key=oddity)
    return Fits(tuple(boxes), matched, (), (), 0.0)


def misses(rows: Rows, sums: Array, room: Array, here: Sequence[int]) -> Array:
    """The worst miss of some numbers, (S,), for sums (S, R), in units of what they may be missed by."""
    worst = np.zeros(len(sums))
    for k in here:
        value = sums[:, rows.start[k] : rows.start[k + 1]].max(axis=-1)
        worst = np.maximum(worst, np.abs(value - rows.value[k]) / room[k])
    return worst


def _grown(states: _States, classes: Sequence[_Class]) -> _States:
    if not classes:
        return _States(states.sums[:0], ())
    sums = states.sums[:, None, :] + np.array([c.adds for c in classes])
    boxes = tuple(tuple((c.members, *box) for box in old) for old in states.boxes for c in classes)
    return _States(sums.reshape(len(boxes), sums.shape[-1]), boxes)


def allowances(rows: Rows, options: Sequence[LinkOptions]) -> Array:
    """By how much each number may be missed, (K,): half its last digit and the rounding of the table's cells."""
    found: Array = rows.half * (1.0 + 1e-6) + DEVIATIONS * _spread(rows, options)
    return found


def _spread(rows: Rows, options: Sequence[LinkOptions]) -> Array:
    """What rounding of the table's cells does to each number, (K,), one standard deviation."""
    deviation = np.array([o.deviation for o in options])
    per_row = np.sqrt(((rows.coefficients * deviation) ** 2).sum(axis=(1, 2)))
    return np.array([per_row[a:b].max(initial=0.0) for a, b in zip(rows.start[:-1], rows.start[1:], strict=True)])


def values(rows: Rows, options: Sequence[LinkOptions], picked: Sequence[int]) -> Array:
    """The numbers under one option per link, (K,), less the rotors' share."""
    sums = sum((rows.coefficients[:, i] @ options[i].parameters[o] for i, o in enumerate(picked)), np.zeros(1))
    return np.array([sums[a:b].max() for a, b in zip(rows.start[:-1], rows.start[1:], strict=True)])


def misfit(rows: Rows, options: Sequence[LinkOptions], picked: Sequence[int]) -> float:
    """Half the chi-square of the numbers under one option per link: minus the log of how likely the misses are."""
    variance = rows.half**2 / 3.0 + _spread(rows, options) ** 2
    return float(((values(rows, options, picked) - rows.value) ** 2 / variance).sum() / 2.0)


def _classes(rows: Rows, options: LinkOptions, allowed: Sequence[int], link: int, per_row: Array) -> list[_Class]:
    adds = rows.coefficients[:, link] @ options.parameters.T
    classes: list[_Class] = []
    for o in allowed:
        for i, known in enumerate(classes):
            if (np.abs(known.adds - adds[:, o]) <= SAME * per_row).all():
                classes[i] = _Class((*known.members, o), known.adds)
                break
        else:
            classes.append(_Class((o,), adds[:, o]))
    return classes


def _merged(rows: Rows, states: _States, good: NDArray[np.intp], link: int, per_row: Array) -> _States:
    """The good states; those whose sums agree on every number still to come are one."""
    blocks = [np.arange(rows.start[k], rows.start[k + 1]) for k, joint in enumerate(rows.joint) if joint < link]
    ahead = np.concatenate([*blocks, np.zeros(0, dtype=int)])
    keys = np.round(states.sums[np.ix_(good, ahead)] / (SAME * per_row[ahead])).astype(np.int64)
    merged: dict[bytes, list[int]] = {}
    for key, s in zip(keys, good, strict=True):
        merged.setdefault(key.tobytes(), []).append(int(s))
    boxes = [sorted((box for s in g for box in states.boxes[s]), key=oddity)[:MOST] for g in merged.values()]
    groups = sorted(zip(merged.values(), boxes, strict=True), key=lambda g: oddity(g[1][0]))[:MOST]
    return _States(states.sums[[g[0] for g, _ in groups]], tuple(tuple(b) for _, b in groups))


def oddity(box: Box) -> int:
    """Links of a box that cannot be read with their axes as printed: options are in order, the plainest first."""
    return sum(min(options) >= PLAIN for options in box)
