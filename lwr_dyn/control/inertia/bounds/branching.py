"""Boxes halved, depth first, until no box can hold more than what is known already.

A box is its control values, a flat array with the last joint fastest. The largest bounds the function on the box; those
at corners are values of the function. A box whose bound is not above the threshold is done; any other is halved along
the joint whose control values bend most.
"""

from typing import Any

import numpy as np
from numba import njit

jit = njit(error_model="numpy", nogil=True, cache=True)
LEVELS = 26
"""Halvings of one joint at most: then its interval is 1e-8 of the first one."""
ROWS = 160
"""Boxes that wait at most, each with its control values."""


@jit  # type: ignore[untyped-decorator]
def contract(values: Any, out: Any, size: int, inner: int, matrix: Any, count: int) -> None:
    """`matrix` (count, count) along the joint whose `count` control values are `inner` apart."""
    for start in range(0, size, count * inner):
        for m in range(count):
            at = start + m * inner
            for y in range(inner):
                out[at + y] = matrix[m, 0] * values[start + y]
            for k in range(1, count):
                a = matrix[m, k]
                if a != 0.0:
                    for y in range(inner):
                        out[at + y] += a * values[start + k * inner + y]


@jit  # type: ignore[untyped-decorator]
def bend(values: Any, size: int, inner: int, count: int) -> float:
    """The largest second difference of the control values along one joint."""
    most = 0.0
    for start in range(0, size, count * inner):
        for k in range(1, count - 1):
            for y in range(start + k * inner, start + (k + 1) * inner):
                most = max(most, abs(values[y - inner] - 2.0 * values[y] + values[y + inner]))
    return most


@jit  # type: ignore[untyped-decorator]
def extremes(values: Any, corners: Any, known: float) -> tuple[float, float]:
    """The largest control value, and the best of `known` and the values at the corners of the box."""
    highest = values[0]
    for x in range(len(values)):
        highest = max(highest, values[x])
    for x in corners:
        known = max(known, values[x])
    return highest, known


@jit  # type: ignore[untyped-decorator]
def most_bent(values: Any, levels: Any, counts: Any) -> tuple[int, int]:
    """The joint along which a box is halved, and how far apart its control values are; -1 where none bends any more."""
    chosen, its_inner, largest, inner = -1, 1, 0.0, 1
    for back in range(len(counts)):
        j = len(counts) - 1 - back
        if levels[j] < LEVELS:
            here = bend(values, len(values), inner, counts[j])
            if here > largest:
                chosen, its_inner, largest = j, inner, here
        inner *= counts[j]
    return chosen, its_inner


@jit  # type: ignore[untyped-decorator]
def search(
    counts: Any, lefts: Any, rights: Any, corners: Any, gap: float, known: float, most: int, pool: Any
) -> tuple[float, float, int]:
    """The bound over one box, whose control values stand in pool[0]: (bound, best value met, boxes).

    `counts` (d,) control values a joint; `lefts`, `rights` (d, LEVELS, 5, 5) halvings by level; `corners` (2^d,) places
    of corners; `known` the best value before; a box is done at known (1 + gap). Where `most` boxes or the rows of
    `pool` are not enough, the bound is larger than that, and holds all the same.
    """
    size, last = pool.shape[1], pool.shape[0] - 1  # the last row is for the box that is being halved
    levels = np.zeros((last, len(counts)), dtype=np.int64)
    bound, boxes, top = -np.inf, 0, 0
    while top >= 0:
        boxes += 1
        highest, known = extremes(pool[top], corners, known)
        j, inner = -1, 1
        if highest > known * (1.0 + gap) and boxes < most and top + 1 < last:
            j, inner = most_bent(pool[top], levels[top], counts)
        if j < 0:
            bound = max(bound, highest)
            top -= 1
            continue
        level = levels[top, j]
        pool[last] = pool[top]
        contract(pool[last], pool[top + 1], size, inner, lefts[j, level], counts[j])
        contract(pool[last], pool[top], size, inner, rights[j, level], counts[j])
        levels[top, j] = level + 1
        levels[top + 1] = levels[top]
        top += 1
    return bound, known, boxes
