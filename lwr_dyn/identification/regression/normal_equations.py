"""Normal equations of every joint by itself, summed over blocks of instants, so that a long log needs no memory."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arrays import Array, freeze_arrays
from lwr_dyn.identification.regression.base_parameters import BaseParameters
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns

BLOCK = 512
"""Instants at once: their columns stay in the cache."""


@dataclass(frozen=True, slots=True, eq=False)
class NormalEquations:
    """Of every joint over its equations: W^T W (n, b, b), W^T tau (n, b), tau^T tau (n,), and how many (n,).

    Those of several logs or recordings add up.
    """

    matrices: Array
    sides: Array
    squares: Array
    equations: NDArray[np.intp]

    def __post_init__(self) -> None:
        freeze_arrays(self, "matrices", "sides", "squares")

    def __add__(self, other: "NormalEquations") -> "NormalEquations":
        names = ("matrices", "sides", "squares", "equations")
        return NormalEquations(*(getattr(self, name) + getattr(other, name) for name in names))

    def weighted(self, noise: Array) -> tuple[Array, Array]:
        """Sum over joints of W^T W / noise^2 (b, b) and W^T tau / noise^2 (b,)."""
        weights = self.equations > 0
        weights = np.where(weights, 1.0 / np.where(weights, noise, 1.0) ** 2, 0.0)
        return np.tensordot(weights, self.matrices, 1), weights @ self.sides

    def residual_squares(self, values: Array) -> Array:
        """|tau - W values|^2 of every joint, (n,): exact to about 1e-15 of |tau|^2."""
        across = np.einsum("b,jbc,c->j", values, self.matrices, values)
        return np.asarray(np.maximum(self.squares - 2.0 * self.sides @ values + across, 0.0))


def normal_equations(samples: Samples, columns: TorqueColumns, base: BaseParameters) -> NormalEquations:
    """The normal equations of base parameters (b,), from the equations that are used."""
    n, b = columns.n, base.count
    matrices, sides, squares = np.zeros((n, b, b)), np.zeros((n, b)), np.zeros(n)
    for first in range(0, len(samples), BLOCK):
        rows = slice(first, first + BLOCK)
        Y = columns(samples.q[rows], samples.dq[rows], samples.ddq[rows])[:, :, base.kept]
        for j in range(n):
            used = samples.used[rows, j]
            W, tau = Y[used, j], samples.tau[rows, j][used]
            matrices[j] += W.T @ W
            sides[j] += W.T @ tau
            squares[j] += tau @ tau
    return NormalEquations(matrices, sides, squares, np.count_nonzero(samples.used, axis=0))
