"""The points of a study in the unit cube: run number i has the same point however the study is cut into chunks.

grid              every combination of the levels, the last parameter fastest
sobol             scrambled Sobol points; best with a power of 2 of runs, and few numbers a run
latin-hypercube   each parameter's range is cut into as many slices as there are runs, one run in each
random            independent points
saltelli          for Sobol indices: of each base point a row A, a row B, and A with each parameter in turn from B
"""

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from math import prod

import numpy as np
from scipy.stats import qmc

from lwr_dyn.foundation.arrays import Array

METHODS = ("grid", "sobol", "latin-hypercube", "random", "saltelli")
FEW = 16
"""Numbers a run up to which 512 Sobol points keep all pairs of them apart, better than the other methods do.

With 38, two of them go along: in the worst pair, the share of one's upper half over a fifth of the other was off by
0.36, in a Latin hypercube by 0.18 (means of three seeds)."""
BLOCK = 1024
"""Points that are drawn at once: a power of 2, as Sobol points need."""


def points(
    method: str, sizes: Sequence[int], levels: Sequence[int], runs: int, seed: int, first: int, stop: int
) -> Array:
    """The points (stop - first, d) of runs first ... stop - 1, each number in [0, 1).

    Parameters
    ----------
    method : {"grid", "sobol", "latin-hypercube", "random", "saltelli"}
    sizes : sequence of int
        Numbers of each parameter, which are taken from B together; d is their sum.
    levels : sequence of int
        Of each of the d numbers, for a grid.
    runs : int
        Of the whole study.
    seed, first, stop : int
    """
    d = sum(sizes)
    if d == 0:
        return np.zeros((stop - first, 0))
    if method == "grid":
        index = np.unravel_index(np.arange(first, stop), tuple(levels))
        return np.stack([(k + 0.5) / size for k, size in zip(index, levels, strict=True)], axis=-1)
    if method == "latin-hypercube":
        return _hypercube(d, runs, seed)[first:stop]
    if method == "saltelli":
        return _saltelli(sizes, seed, first, stop)
    return _blocks(method, d, seed, first, stop)


def usual_method(numbers: int) -> str:
    """The method where none is named, for so many numbers a run."""
    return "sobol" if numbers <= FEW else "latin-hypercube"


def saltelli_rows(parameters: int) -> int:
    """Runs of each base point: A, B, and A with each parameter from B."""
    return parameters + 2


def grid_runs(levels: Sequence[int]) -> int:
    """Runs of a grid."""
    return prod(levels)


def _blocks(method: str, d: int, seed: int, first: int, stop: int) -> Array:
    """Points of whole blocks, cut to the runs that are wanted."""
    begin = first // BLOCK
    rows = [_block(method, d, seed, block) for block in range(begin, -(-stop // BLOCK))]
    return np.concatenate(rows)[first - begin * BLOCK : stop - begin * BLOCK]


def _block(method: str, d: int, seed: int, block: int) -> Array:
    if method == "random":
        return np.random.default_rng([seed, block]).random((BLOCK, d))
    sobol = qmc.Sobol(d, seed=np.random.default_rng(seed))
    if block:
        sobol.fast_forward(block * BLOCK)
    return np.asarray(sobol.random(BLOCK))


@lru_cache(maxsize=2)
def _hypercube(d: int, runs: int, seed: int) -> Array:
    """All points: a Latin hypercube cannot be drawn in parts."""
    return np.asarray(qmc.LatinHypercube(d, seed=np.random.default_rng(seed)).random(runs))


def _saltelli(sizes: Sequence[int], seed: int, first: int, stop: int) -> Array:
    rows, d = saltelli_rows(len(sizes)), sum(sizes)
    base = first // rows
    both = _blocks("sobol", 2 * d, seed, base, -(-stop // rows))
    A, B = both[:, :d], both[:, d:]
    out = np.repeat(A[:, None, :], rows, axis=1)
    out[:, 1] = B
    for j, (low, high) in enumerate(pairwise(np.cumsum([0, *sizes]))):
        out[:, 2 + j, low:high] = B[:, low:high]
    return out.reshape(-1, d)[first - base * rows : stop - base * rows]
