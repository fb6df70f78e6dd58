"""Motions of which logs are made, to keep some from a fit: recordings, or parts of one, cut where it is slow."""

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.regression.samples import Samples

SEARCHED = 0.3
"""Share of a piece's length, on each side of an even division, in which the slowest instant is looked for."""


def motion_pieces(samples: Samples, folds: int) -> NDArray[np.intp]:
    """Which fold each instant belongs to, (k,), from 0: whole recordings where there are enough, else parts of them.

    Recordings are dealt out in turn. Where there are fewer than folds, each is cut into equal parts, near every
    division at the instant at which the fastest joint (as a share of its largest speed) is slowest: neighbours then
    share no fast motion.

    Raises
    ------
    OptionError
        Fewer than two folds, or more than there are instants.
    """
    if not 2 <= folds <= len(samples):
        raise OptionError("folds", folds, f"2 to {len(samples)}, the number of instants")
    numbers = np.unique(samples.recording)
    if len(numbers) >= folds:
        return np.asarray(np.searchsorted(numbers, samples.recording) % folds)
    out = np.empty(len(samples), dtype=np.intp)
    speed = _relative_speed(samples.dq)
    for number in numbers:
        rows = np.flatnonzero(samples.recording == number)
        cuts = _slow_cuts(speed[rows], folds)
        out[rows] = np.searchsorted(cuts, np.arange(len(rows)), side="right")
    return out


def _relative_speed(dq: Array) -> Array:
    """The largest over the joints of |dq| as a share of its joint's largest, (k,)."""
    fastest = np.abs(dq).max(axis=0)
    return np.asarray((np.abs(dq) / np.where(fastest > 0.0, fastest, 1.0)).max(axis=1))


def _slow_cuts(speed: Array, parts: int) -> NDArray[np.intp]:
    """First rows of the second and later parts."""
    length = len(speed) / parts
    cuts = []
    for i in range(1, parts):
        first = int((i - SEARCHED) * length)
        last = max(first + 1, int((i + SEARCHED) * length))
        cuts.append(first + int(np.argmin(speed[first:last])))
    return np.array(cuts, dtype=np.intp)
