"""Noise of slow sums: what is left of noise whose neighbours cancel, such as that of differenced positions."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.signal import oaconvolve
from scipy.signal.windows import hann

from lwr_dyn.foundation.arrays import Array

WINDOW = 0.1
"""[s] Longer than the memory of noise, shorter than a motion. A fit takes up slow noise: from windows of 0.2 s errors
of 10 s logs came out 8 % too small, of 0.1 s 4 %."""
HANN_BAND = 1.5
"""Independent sums under Hann windows in the length of one (equivalent noise bandwidth, Harris 1978)."""
OVERLAP = 4
"""Windows that begin within the length of one."""


def window_sums(series: Array, recording: NDArray[np.intp], length: int) -> Array:
    """v (w, m) of a series (k, m) with v^T v = S, the covariance of its sum over k as slow windows show it.

    The sums are under Hann windows of `length` rows inside one recording, scaled so that white noise gives k times its
    variance. Noise whose sums cancel, as second differences do, gives what is left of it and not its own size.

    References
    ----------
    Priestley, Spectral Analysis and Time Series (1981), section 6.2: S is k times the spectrum at frequency 0.

    >>> noise = np.diff(np.random.default_rng(0).normal(size=(4002, 1)), n=2, axis=0)
    >>> v = window_sums(noise, np.zeros(4000, dtype=int), 200)
    >>> bool((v**2).sum() / 4000 < 1e-3 * noise.var())
    True
    """
    out = []
    for part in _parts(recording):
        size = min(length, part.stop - part.start)
        shape = hann(size + 2)[1:-1]
        sums = oaconvolve(series[part], shape[:, None], mode="valid", axes=0)[:: max(1, size // OVERLAP)]
        share = (part.stop - part.start) / len(sums)  # every recording counts with its rows
        out.append(sums * np.sqrt(share / (shape @ shape)))
    return np.concatenate(out)


def _parts(recording: NDArray[np.intp]) -> Iterator[slice]:
    edges = [0, *(np.flatnonzero(np.diff(recording)) + 1).tolist(), len(recording)]
    return (slice(a, b) for a, b in pairwise(edges) if b > a)
