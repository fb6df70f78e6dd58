"""What logs say of the base parameters: weighted least squares with the noise of every joint, and what they leave open.

    chi^2(b) = sum_j |tau_j - W_j b|^2 / s_j^2,    precision = sum_j W_j^T W_j / s_j^2,    R^T R = precision

s_j is the noise of joint j, from its own residuals unless it is given. The normal equations of every joint are summed
over blocks of instants, so that a long log needs no memory. `grouped` does the same for groups of equations whose
columns are not those of one arm alone: a load in its hand, the two sides of its gears.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dsyrk

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.identification.regression.least_squares import BaseParameters, Spectrum, solved, student_factor
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

    def times(self, factors: Array) -> "NormalEquations":
        """The same where the torques of each joint are multiplied by a factor, (n,)."""
        sides, squares = self.sides * factors[:, None], self.squares * factors**2
        return NormalEquations(self.matrices, sides, squares, self.equations)

    def weighted(self, noise: Array) -> tuple[Array, Array]:
        """Sum over joints of W^T W / noise^2 (b, b) and W^T tau / noise^2 (b,)."""
        weights = self.equations > 0
        weights = np.where(weights, 1.0 / np.where(weights, noise, 1.0) ** 2, 0.0)
        return np.tensordot(weights, self.matrices, 1), weights @ self.sides

    def residual_squares(self, values: Array) -> Array:
        """|tau - W values|^2 of every joint, (n,): exact to about 1e-15 of |tau|^2."""
        across = np.einsum("b,jbc,c->j", values, self.matrices, values)
        return np.asarray(np.maximum(self.squares - 2.0 * self.sides @ values + across, 0.0))

    def residual_rms(self, values: Array) -> Array:
        """Root of their mean, (n,); NaN without equations."""
        count = self.equations
        return np.sqrt(np.where(count > 0, self.residual_squares(values) / np.maximum(count, 1), np.nan))


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
    own = columns.own_columns(part.q, part.dq, part.ddq)
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


ROUNDS = 50
"""Of noise and fit in turn, at most."""
SETTLED = 1e-6
"""Share by which the noise may still change in the last round."""
QUIET = 1e-7
"""Noise below this share of a group's right side may be rounding alone."""
LEAST = 1e-9
"""[N m or N] Least noise, also of a group whose right sides are all 0: its weight stays a number that others bear."""


@dataclass(frozen=True, slots=True, eq=False)
class GroupedEstimate:
    """Parameters (p,) with covariance (p, p), and the noise (g,) of every group of equations, NaN of an empty one.

    Parameters that the equations leave open are those of least norm among scaled columns; `determined` (p,) says which
    are not, and their variance is infinite.
    """

    values: Array
    covariance: Array
    noise: Array
    normal: NormalEquations
    determined: NDArray[np.bool_]

    def __post_init__(self) -> None:
        freeze_arrays(self, "values", "covariance", "noise")

    @property
    def sigma(self) -> Array:
        """Standard errors (p,), infinite where a parameter is not determined."""
        return np.sqrt(np.diag(self.covariance))


def equations_of(X: Array, y: Array, used: NDArray[np.bool_]) -> NormalEquations:
    """The normal equations of rows X (k, g, p), y (k, g) where `used` (k, g)."""
    rows = [(X[u, g], y[u, g]) for g, u in enumerate(used.T)]
    return NormalEquations(
        np.array([W.T @ W for W, _ in rows]), np.array([W.T @ b for W, b in rows]), np.array([b @ b for _, b in rows]),
        np.count_nonzero(used, axis=0),
    )  # fmt: skip


def grouped(normal: NormalEquations, start: Array, known: bool = False) -> GroupedEstimate:
    """min sum over groups of |y - X b|^2 / s_g^2, with s_g^2 = |y - X b|^2 / (m_g - p_g) from the round before.

    Parameters
    ----------
    normal : NormalEquations
        Of g groups.
    start : (g,) array
        Noise of the groups in the first round, above 0.
    known : bool
        That noise is right and stays.

    Notes
    -----
    p_g = trace(X_g^T X_g C) / s_g^2 is the share of the parameters that a group pays for: they sum to p, and the noise
    has no bias (C the covariance of b).

    References
    ----------
    Harville, Maximum likelihood approaches to variance component estimation, J. Am. Stat. Assoc. 72 (1977), 3.

    >>> rows = equations_of(np.ones((3, 1, 1)), np.array([[1.0], [2.0], [3.0]]), np.ones((3, 1), dtype=bool))
    >>> fit = grouped(rows, np.ones(1))
    >>> fit.values.round(6).tolist(), fit.noise.round(6).tolist()
    ([2.0], [1.0])
    """
    count = normal.equations
    floor = QUIET * np.sqrt(normal.squares / np.maximum(count, 1)) + LEAST
    noise = np.asarray(start, dtype=np.float64)
    for _ in range(0 if known else ROUNDS):
        matrix, side = normal.weighted(noise)
        inverse = Spectrum.of(matrix).inverse()
        squares = normal.residual_squares(solved(matrix, side, inverse))
        before, paid = noise, np.einsum("gij,ji->g", normal.matrices, inverse) / noise**2
        freedom = count - paid
        found = np.sqrt(squares / np.maximum(freedom, 0.5))
        noise = np.where(freedom > 0.5, np.maximum(found, floor), noise)
        if np.abs(noise / before - 1.0).max() < SETTLED:
            break
    matrix, side = normal.weighted(noise)
    spectrum = Spectrum.of(matrix)
    covariance, determined = spectrum.inverse(), spectrum.determined
    values = solved(matrix, side, covariance)
    covariance[~determined] = covariance[:, ~determined] = 0.0
    covariance[~determined, ~determined] = np.inf
    return GroupedEstimate(values, covariance, np.where(count > 0, noise, np.nan), normal, determined)


@dataclass(frozen=True, slots=True, eq=False)
class Information:
    """Base parameters that fit best, and how well logs determine all of them.

    `values` (b,) and `precision` (b, b) in SI; `noise` (n,) [N m or N], NaN for a joint without equations; `equations`
    (n,) used; `chi2` at the values, `dof` equations less parameters; `determined` (b,): whether the log shows a
    parameter at all. Where it does not the values are those of least length (columns scaled) and sigma is infinite.
    """

    columns: TorqueColumns
    base: BaseParameters
    values: Array
    precision: Array
    noise: Array
    equations: NDArray[np.intp]
    chi2: float
    dof: int
    determined: NDArray[np.bool_]
    normal: NormalEquations
    """Of every joint alone, for residuals by joint and for other weights."""
    inflation: Array
    """How much larger `noise` was taken than that of an instant, (n,), where residuals are not white; see `widened`."""

    def __post_init__(self) -> None:
        freeze_arrays(self, "values", "precision", "noise", "inflation")

    @property
    def residual_noise(self) -> Array:
        """Noise of every joint at an instant, (n,) [N m or N]."""
        return self.noise / self.inflation

    @property
    def paid(self) -> Array:
        """How many parameters the equations of each joint pay for, (n,): they sum to the rank."""
        seen = self.equations > 0
        weights = np.where(seen, 1.0 / np.where(seen, self.noise, 1.0) ** 2, 0.0)
        return np.asarray(weights * np.einsum("jab,ba->j", self.normal.matrices, self.covariance))

    @property
    def covariance(self) -> Array:
        """(b, b): the inverse of the precision in the directions that the log shows; see `sigma` for the others."""
        return Spectrum.of(self.precision).inverse()

    @property
    def sigma(self) -> Array:
        """Standard errors (b,), infinite where not determined."""
        return np.where(self.determined, np.sqrt(np.diag(self.covariance)), np.inf)

    @property
    def half_widths(self) -> Array:
        """Of the 3-sigma intervals (b,), with Student's t; infinite where not determined."""
        return np.asarray(self.sigma * student_factor(self.dof))

    @property
    def factor(self) -> Array:
        """R (b, b), upper triangular with R^T R = precision."""
        return Spectrum.of(self.precision).factor()

    @property
    def condition(self) -> float:
        """Condition number of the weighted columns scaled to length 1; infinite where a parameter is not seen."""
        return Spectrum.of(self.precision).condition


def information_of(
    samples: Samples | Iterable[Samples], columns: TorqueColumns, noise: Array | None = None
) -> Information:
    """What instants of logs say of the base parameters.

    Parameters
    ----------
    samples : Samples or iterable of Samples
        All instants, or a part at a time (`sample_parts`).
    noise : (n,) array, optional
        Standard deviation of every joint's torque [N m or N]; estimated from the residuals if not given.

    Raises
    ------
    ShapeError
        Samples of another number of joints.
    """
    base = columns.base()
    return solve(normal_equations(samples, columns, base), columns, base, noise)


def solve(
    normal: NormalEquations, columns: TorqueColumns, base: BaseParameters, noise: Array | None = None
) -> Information:
    """The same from normal equations, such as sums of those of recordings."""
    start = np.ones(columns.n) if noise is None else np.asarray(noise, dtype=np.float64)
    fit = grouped(normal, start, known=noise is not None)
    seen = normal.equations > 0
    precision, _ = normal.weighted(np.where(seen, fit.noise, 1.0))
    chi2 = float((normal.residual_squares(fit.values)[seen] / fit.noise[seen] ** 2).sum())
    dof = int(normal.equations.sum()) - Spectrum.of(precision).rank
    return Information(
        columns, base, fit.values, precision, fit.noise, normal.equations, chi2, dof, fit.determined, normal,
        np.ones(columns.n),
    )  # fmt: skip


def widened(information: Information, inflation: Array) -> Information:
    """The same logs where errors of a joint that stay longer than an instant count as what they are in slow sums.

    Noise whose neighbours are alike, such as friction or a motion that the columns lack, does not go down with the
    number of instants. The noise of joint j is taken `inflation` (n,) >= 1 times as large, sqrt(1 + 2 sum of its
    autocorrelation), and the fit made again with it: values, precision, sigma. `chi2` is then below `dof`.

    Raises
    ------
    OptionError
        An inflation that is not at least 1.

    References
    ----------
    Priestley, Spectral Analysis and Time Series (1981), section 5.3: the variance of a mean under correlated errors.
    """
    factor = information.inflation * np.asarray(inflation, dtype=np.float64)
    if not (factor >= 1.0).all():
        raise OptionError("inflation", f"{factor.min():g}", "numbers of at least 1")
    if (factor == 1.0).all():
        return information
    noise = np.where(np.isfinite(information.noise), information.residual_noise, 1.0) * factor
    found = solve(information.normal, information.columns, information.base, noise)
    return replace(found, inflation=factor)
