"""Recordings: the pieces of a log without a gap in time."""

from collections.abc import Iterator

import numpy as np

from lwr_dyn.arrays import Array

GAP = 3.0
"""A step between rows longer than this many usual ones ends a recording and begins another."""


def recordings(t: Array) -> Iterator[slice]:
    """The rows (slices) of t (k,) [s] that stand without a gap in time.

    >>> list(recordings(np.array([0.0, 0.1, 0.2, 0.9, 1.0])))
    [slice(0, 3, None), slice(3, 5, None)]
    """
    steps = np.diff(t)
    ends = np.flatnonzero(steps > GAP * np.median(steps)) + 1 if steps.size else np.empty(0, dtype=np.intp)
    for first, last in zip([0, *ends.tolist()], [*ends.tolist(), t.size], strict=True):
        yield slice(first, last)
