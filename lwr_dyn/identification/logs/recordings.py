"""Recordings: the pieces of a log without a gap in time, and their step."""

from collections.abc import Iterator

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LogError

GAP = 3.0
"""A step between rows longer than this many usual ones ends a recording and begins another."""
JITTER = 0.05
"""Share of the usual step by which rows may miss an even grid before accelerations cannot be had."""


def recordings(t: Array) -> Iterator[slice]:
    """The rows (slices) of t (k,) [s] that stand without a gap in time.

    >>> list(recordings(np.array([0.0, 0.1, 0.2, 0.9, 1.0])))
    [slice(0, 3, None), slice(3, 5, None)]
    """
    steps = np.diff(t)
    ends = np.flatnonzero(steps > GAP * np.median(steps)) + 1 if steps.size else np.empty(0, dtype=np.intp)
    for first, last in zip([0, *ends.tolist()], [*ends.tolist(), t.size], strict=True):
        yield slice(first, last)


def even_step(source: str, t: Array, start: int = 0) -> float:
    """The step of even rows t (k,) [s]; raises `LogError` that names the uneven ones, counted from `start`."""
    steps = np.diff(t)
    step = float(np.median(steps)) if steps.size else 0.0
    uneven = np.flatnonzero(np.abs(steps - step) > JITTER * step)
    if uneven.size:
        where = f"rows {start + uneven[0] + 1} and {start + uneven[0] + 2}"
        found = f"{steps[uneven[0]]:.6g} s apart, {step:.6g} s as a rule"
        raise LogError(source, where, found, "evenly spaced rows, where accelerations are wanted")
    return step
