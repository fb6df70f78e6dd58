"""Normal equations of every joint by itself, summed over blocks of instants, so that a long log needs no memory."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dsyrk

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.identification.regression.base_parameters import BaseParameters
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import FROM_KERNEL, TorqueColumns

BLOCK = 1024
"""Instants at once: their columns stay in the cache."""
CHUNK = 4096
"""Instants whose rotor and friction columns are made at once."""


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


def normal_equations(
    samples: Samples | Iterable[Samples], columns: TorqueColumns, base: BaseParameters
) -> NormalEquations:
    """The normal equations of base parameters (b,), from the equations that are used.

    Joint by joint: only columns that reach the joint, those of its own link and of links beyond, and of its friction,
    are multiplied. A million instants take seconds and a few megabytes.

    Parameters
    ----------
    samples : Samples or iterable of Samples
        All instants, or a part at a time (`sample_parts`).
    columns : TorqueColumns
    base : BaseParameters
        Of these columns.

    Raises
    ------
    ShapeError
        Samples of another number of joints.
    """
    joints = [_JointSums.of(j, columns, base) for j in range(columns.n)]
    equations = np.zeros(columns.n, dtype=np.intp)
    for part in (samples,) if isinstance(samples, Samples) else samples:
        if part.n != columns.n:
            raise ShapeError("samples", f"{part.n} joints", f"{columns.n}, those of the columns")
        equations += np.count_nonzero(part.used, axis=0)
        for first in range(0, len(part), CHUNK):
            _add(part.select(slice(first, first + CHUNK)), columns, joints)
    n, b = columns.n, base.count
    matrices, sides, squares = np.zeros((n, b, b)), np.zeros((n, b)), np.zeros(n)
    for j, joint in enumerate(joints):
        whole = joint.sums + np.triu(joint.sums, 1).T
        matrices[j][np.ix_(joint.places, joint.places)] = whole[:-1, :-1]
        sides[j][joint.places], squares[j] = whole[:-1, -1], whole[-1, -1]
    return NormalEquations(matrices, sides, squares, equations)


@dataclass(frozen=True, slots=True, eq=False)
class _JointSums:
    """The columns that reach a joint, and the sums of their products (upper triangle), the torque last."""

    bodies: NDArray[np.intp]
    """Of the bodies' columns, as the kernel orders them."""
    own: tuple[tuple[int, NDArray[np.intp], float], ...]
    """Of rotors and friction: whose, which of its columns, times what."""
    places: NDArray[np.intp]
    """Of all of them among the base parameters."""
    sums: Array
    rows: Array
    """Room for one block, (BLOCK, columns and torque)."""

    @classmethod
    def of(cls, joint: int, columns: TorqueColumns, base: BaseParameters) -> "_JointSums":
        at = {int(k): place for place, k in enumerate(base.kept)}
        bodies = [k for k in at if 10 * joint <= k < columns.bodies]
        own, places = [], [at[k] for k in bodies]
        for i in range(columns.n):
            reach = columns.reach(joint, i)
            picks = [k for k in range(columns.of_joint(i).start, columns.of_joint(i).stop) if k in at and reach]
            if picks:
                own.append((i, np.array(picks) - columns.of_joint(i).start, reach))
                places += [at[k] for k in picks]
        from_kernel = np.array(bodies, dtype=np.intp)
        if columns.kernel is not None:
            from_kernel = 10 * (from_kernel // 10) + FROM_KERNEL[from_kernel % 10]
        wide = len(places) + 1
        sums, rows = np.zeros((wide, wide), order="F"), np.empty((BLOCK, wide))
        return cls(from_kernel, tuple(own), np.array(places, dtype=np.intp), sums, rows)


def _add(part: Samples, columns: TorqueColumns, joints: Sequence[_JointSums]) -> None:
    own = [columns.own_columns(i, part.dq, part.ddq) for i in range(columns.n)]
    for first in range(0, len(part), BLOCK):
        rows = slice(first, first + BLOCK)
        Y = columns.raw_bodies(part.q[rows], part.dq[rows], part.ddq[rows])
        for j, joint in enumerate(joints):
            used = part.used[rows, j]
            W = joint.rows[: len(Y)]
            stop = joint.bodies.size
            np.take(Y[:, j], joint.bodies, axis=1, out=W[:, :stop], mode="clip")
            for i, picks, factor in joint.own:
                start, stop = stop, stop + picks.size
                np.multiply(own[i][rows, picks], factor, out=W[:, start:stop])
            W[:, -1] = part.tau[rows, j]
            if not used.all():
                W = W[used]
            dsyrk(1.0, W.T, 1.0, joint.sums, overwrite_c=1)
