"""Base parameters: the combinations of parameters that a regressor determines, by a rank-revealing QR decomposition."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, solve_triangular

from lwr_dyn.foundation.arrays import Array, read_only

RANK = 1e-9
"""Share of the largest diagonal element of R below which a column is a combination of those before it."""
ROUNDING = 1e-12
"""Share by which a column may enter a combination from rounding alone: it is 0."""
NEGLIGIBLE = 1e-8
"""Share by which a column may enter a combination and not be named."""


@dataclass(frozen=True, slots=True, eq=False)
class BaseParameters:
    """Which columns stand (`kept`, b of them) and how all (p) group on them: base = grouping @ pi, (b, p).

    Two parameter sets with the same base give the same torques everywhere.
    """

    names: tuple[str, ...]
    kept: NDArray[np.intp]
    grouping: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "grouping", read_only(self.grouping))

    @property
    def count(self) -> int:
        """Number of base parameters."""
        return int(self.kept.size)

    def of(self, parameters: Array) -> Array:
        """The base values (b,) of a full set (p,)."""
        return np.asarray(self.grouping @ parameters)

    def statements(self) -> tuple[str, ...]:
        """Every base parameter as a combination of the full ones, such as `Izz_2 + 0.16 m_3`."""
        return tuple(self._statement(row, int(k)) for row, k in zip(self.grouping, self.kept, strict=True))

    def _statement(self, row: Array, kept: int) -> str:
        others = [j for j in np.flatnonzero(np.abs(row) > NEGLIGIBLE) if j != kept]
        terms = [f"{'+' if row[j] > 0 else '-'} {_factor(abs(row[j]))}{self.names[j]}" for j in others]
        return " ".join([self.names[kept], *terms])


def _factor(value: float) -> str:
    return "" if abs(value - 1.0) < NEGLIGIBLE else f"{value:.4g} "


def base_parameters(stacked: Array, names: Sequence[str]) -> BaseParameters:
    """The base parameters of stacked regressor rows (m, p).

    Columns are scaled to length 1, then chosen one after the other, each the longest in what the chosen ones leave;
    when none is left, W = W_kept [1, beta], and beta groups the others on the kept ones.

    References
    ----------
    Gautier, Numerical calculation of the base inertial parameters of robots (1991); Golub and Van Loan, section 5.4.

    >>> base_parameters(np.array([[1.0, 2.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 3.0]]), "abc").statements()
    ('b + 0.5 a', 'c')
    """
    norms = np.linalg.norm(stacked, axis=0)
    seen = np.flatnonzero(norms > RANK * norms.max(initial=0.0))
    R, order = qr(stacked[:, seen] / norms[seen], mode="r", pivoting=True)
    sizes = np.abs(np.diag(R))
    rank = int(np.sum(sizes > RANK * sizes[0])) if sizes.size else 0
    beta = solve_triangular(R[:rank, :rank], R[:rank, rank:])
    kept, dropped = seen[order[:rank]], seen[order[rank:]]
    grouping = np.zeros((rank, stacked.shape[1]))
    grouping[np.arange(rank), kept] = 1.0
    grouping[:, dropped] = beta / norms[kept][:, None] * norms[dropped]
    grouping[np.abs(grouping) < ROUNDING] = 0.0
    by_place = np.argsort(kept)
    return BaseParameters(tuple(names), kept[by_place], grouping[by_place])
