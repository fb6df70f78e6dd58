"""What the runs of a study are: points of the unit cube, and from them values by the inverse distribution.

Run number i has the same point however the study is cut into chunks.

grid              every combination of the levels, the last parameter fastest
sobol             scrambled Sobol points; best with a power of 2 of runs, and few numbers a run
latin-hypercube   each parameter's range is cut into slices with one run in each: as many as there are runs, where that
                  is a power of 2; more runs come into the slices' empty halves, the first ones stay
random            independent points
saltelli          for Sobol indices: of each base point a row A, a row B, and A with each parameter in turn from B

The hypercubes are nested: Qian, "Nested Latin hypercube designs", Biometrika 96 (2009); what each doubling adds is one
too, so they are sliced as well: Qian, "Sliced Latin hypercube designs", J. American Statistical Association 107 (2012).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from lwr_dyn.foundation.arrays import Array

DISTRIBUTIONS = ("uniform", "normal", "choice", "levels", "fixed")
EDGE = 2.0**-53
"""Nearest that a share of a normal distribution comes to 0 and 1."""
Values = Array | NDArray[np.str_]
"""Numbers, or texts of a choice such as that of a reading."""


@dataclass(frozen=True, slots=True)
class VariedParameter:
    """A path, how its values are distributed, and the columns that it fills (one value of a run each).

    Parameters
    ----------
    path : str
        As "payload.mass", see `parameter_paths`.
    distribution : {"uniform", "normal", "choice", "levels", "fixed"}
    columns : tuple of str
        Names of its numbers of a run: ("payload.mass",), or ("arm.com.1.x", "arm.com.1.y", ...), each drawn by itself.
    unit, words : str
        Of the path.
    values : tuple
        Of "choice", "levels" (evenly from the lowest to the highest) and "fixed" (one).
    low, high : float
        Of "uniform"; where a "normal" distribution is cut, infinite where it is not.
    mean, deviation : float
        Of "normal".
    kind, note : str
        Where the distribution comes from: a kind of the data files ("assumed", "datasheet", ...), and free words.
    nominal : float or None
        As modelled; None where it depends on the controller or the task.
    """

    path: str
    distribution: str
    columns: tuple[str, ...]
    unit: str = ""
    words: str = ""
    values: tuple[float, ...] | tuple[str, ...] = ()
    low: float = -np.inf
    high: float = np.inf
    mean: float = 0.0
    deviation: float = 0.0
    kind: str = "assumed"
    note: str = ""
    nominal: float | None = None

    @property
    def is_varied(self) -> bool:
        """Whether runs differ in it."""
        return self.distribution != "fixed"

    @property
    def is_text(self) -> bool:
        """Whether its values are names."""
        return bool(self.values) and isinstance(self.values[0], str)

    @property
    def lowest(self) -> float | str:
        """The least value; three deviations below the mean where a normal distribution is not cut there."""
        if self.values:
            return self.values[0] if self.is_text else min(self.values)
        return self.low if np.isfinite(self.low) else self.mean - 3.0 * self.deviation

    @property
    def highest(self) -> float | str:
        """The largest value; three deviations above the mean where a normal distribution is not cut there."""
        if self.values:
            return self.values[-1] if self.is_text else max(self.values)
        return self.high if np.isfinite(self.high) else self.mean + 3.0 * self.deviation

    def values_of(self, shares: Array) -> Values:
        """Values of shares in [0, 1), of any shape, by the inverse of the distribution.

        >>> half = VariedParameter("payload.mass", "uniform", ("payload.mass",), low=0.0, high=7.0)
        >>> half.values_of(np.array([0.0, 0.5]))
        array([0. , 3.5])
        """
        if self.values:
            index = np.minimum((shares * len(self.values)).astype(int), len(self.values) - 1)
            chosen: Values = np.asarray(self.values)[index]
            return chosen
        if self.distribution == "uniform":
            return np.asarray(self.low + (self.high - self.low) * shares)
        least, most = ndtr((self.low - self.mean) / self.deviation), ndtr((self.high - self.mean) / self.deviation)
        inside = np.clip(least + (most - least) * shares, EDGE, 1.0 - EDGE)
        return np.asarray(np.clip(self.mean + self.deviation * ndtri(inside), self.low, self.high))

    @property
    def distribution_words(self) -> str:
        """The distribution in words, without a unit.

        >>> VariedParameter("loop.delay", "choice", ("loop.delay",), values=(0.0, 1.0, 2.0)).distribution_words
        'one of 0, 1, 2'
        """
        if self.distribution == "uniform":
            return f"uniform from {self.low:g} to {self.high:g}"
        if self.distribution == "normal":
            words = f"normal, mean {self.mean:g}, deviation {self.deviation:g}"
            ends = [f"{side} {end:g}" for side, end in (("from", self.low), ("to", self.high)) if np.isfinite(end)]
            return " ".join([words, "cut", *ends] if ends else [words])
        shown = ", ".join(x if isinstance(x, str) else f"{x:g}" for x in self.values)
        return {"fixed": shown, "choice": f"one of {shown}", "levels": f"levels {shown}"}[self.distribution]


HYPERCUBE = "latin-hypercube"
METHODS = ("grid", "sobol", HYPERCUBE, "random", "saltelli")
FEW = 16
"""Numbers a run up to which 512 Sobol points keep all pairs of them apart, better than the other methods do.

With 38, two of them go along: in the worst pair, the share of one's upper half over a fifth of the other was off by
0.36, in a Latin hypercube by 0.18 (means of three seeds)."""
BLOCK = 1024
"""Points that are drawn at once: a power of 2, as Sobol points need."""


def points(method: str, sizes: Sequence[int], levels: Sequence[int], seed: int, first: int, stop: int) -> Array:
    """The points (stop - first, d) of runs first ... stop - 1, each number in [0, 1); the same in a study of more runs.

    Parameters
    ----------
    method : {"grid", "sobol", "latin-hypercube", "random", "saltelli"}
    sizes : sequence of int
        Numbers of each parameter, which are taken from B together; d is their sum.
    levels : sequence of int
        Of each of the d numbers, for a grid.
    """
    d = sum(sizes)
    if d == 0:
        return np.zeros((stop - first, 0))
    if method == "grid":
        index = np.unravel_index(np.arange(first, stop), tuple(levels))
        return np.stack([(k + 0.5) / size for k, size in zip(index, levels, strict=True)], axis=-1)
    if method == HYPERCUBE:  # which cannot be drawn in parts
        return _hypercube(d, (stop - 1).bit_length(), seed)[first:stop]
    if method != "saltelli":
        return _blocks(method, d, seed, first, stop)
    rows = saltelli_rows(len(sizes))
    base = first // rows
    A, B = np.split(_blocks("sobol", 2 * d, seed, base, -(-stop // rows)), 2, axis=1)
    out = np.repeat(A[:, None, :], rows, axis=1)
    out[:, 1] = B
    for j, (low, high) in enumerate(pairwise(np.cumsum([0, *sizes]))):
        out[:, 2 + j, low:high] = B[:, low:high]
    return out.reshape(-1, d)[first - base * rows : stop - base * rows]


def saltelli_rows(parameters: int) -> int:
    """Runs of each base point: A, B, and A with each parameter from B."""
    return parameters + 2


@lru_cache(maxsize=2)
def _hypercube(d: int, doublings: int, seed: int) -> Array:
    """2^doublings points, in whole multiples of 2^-53, so that no rounding moves one out of its slice."""
    rng = np.random.default_rng(seed)
    x = rng.integers(2**_BITS, size=(1, d))
    for width in range(_BITS - 1, _BITS - 1 - doublings, -1):  # of a slice: half of what it was
        empty = (x >> width) ^ 1
        x = np.concatenate([x, (rng.permuted(empty, axis=0) << width) + rng.integers(2**width, size=x.shape)])
    return np.asarray(np.ldexp(x.astype(np.float64), -_BITS))


_BITS = 53


def _blocks(method: str, d: int, seed: int, first: int, stop: int) -> Array:
    """Points of whole blocks, cut to the runs that are wanted."""
    begin, end = first // BLOCK, -(-stop // BLOCK)
    if method == "random":
        drawn = [np.random.default_rng([seed, block]).random((BLOCK, d)) for block in range(begin, end)]
    else:
        from scipy.stats import qmc  # a quarter of a second that most commands do not need

        sobol = qmc.Sobol(d, seed=np.random.default_rng(seed))
        if begin:
            sobol.fast_forward(begin * BLOCK)
        drawn = [sobol.random(BLOCK) for _ in range(begin, end)]
    return np.concatenate(drawn)[first - begin * BLOCK : stop - begin * BLOCK]
