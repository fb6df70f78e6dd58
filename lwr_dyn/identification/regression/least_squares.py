"""Linear least squares: base parameters, normal equations by their eigenvectors, weighted and robust estimates.

Base parameters are the combinations that a regressor determines, by a rank-revealing QR decomposition.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special
from scipy.linalg import qr, solve_triangular

from lwr_dyn.foundation.arrays import Array, freeze_arrays

BASE_RANK = 1e-9
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
        freeze_arrays(self, "grouping")

    @property
    def count(self) -> int:
        """Number of base parameters."""
        return int(self.kept.size)

    def of(self, parameters: Array) -> Array:
        """The base values (b,) of a full set (p,)."""
        return np.asarray(self.grouping @ parameters)

    def statements(self) -> tuple[str, ...]:
        """Every base parameter as a combination of the full ones, such as `Izz_2 + 0.16 m_3`."""
        found = []
        for row, kept in zip(self.grouping, self.kept, strict=True):
            terms = [self.names[kept]]
            for j in (j for j in np.flatnonzero(np.abs(row) > NEGLIGIBLE) if j != kept):
                factor = "" if abs(abs(row[j]) - 1.0) < NEGLIGIBLE else f"{abs(row[j]):.4g} "
                terms.append(f"{'+' if row[j] > 0 else '-'} {factor}{self.names[j]}")
            found.append(" ".join(terms))
        return tuple(found)


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
    seen = np.flatnonzero(norms > BASE_RANK * norms.max(initial=0.0))
    R, order = qr(stacked[:, seen] / norms[seen], mode="r", pivoting=True)
    sizes = np.abs(np.diag(R))
    rank = int(np.sum(sizes > BASE_RANK * sizes[0])) if sizes.size else 0
    beta = solve_triangular(R[:rank, :rank], R[:rank, rank:])
    kept, dropped = seen[order[:rank]], seen[order[rank:]]
    grouping = np.zeros((rank, stacked.shape[1]))
    grouping[np.arange(rank), kept] = 1.0
    grouping[:, dropped] = beta / norms[kept][:, None] * norms[dropped]
    grouping[np.abs(grouping) < ROUNDING] = 0.0
    by_place = np.argsort(kept)
    return BaseParameters(tuple(names), kept[by_place], grouping[by_place])


SPECTRUM_RANK = 1e-12
"""Eigenvalue, as a share of the largest, below which rounding alone can give it: the direction is not determined."""
SHARED = 1e-6
"""Share (squared) of the undetermined directions that makes a parameter undetermined."""


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """W^T W = D U diag(lengths) U^T D with D = diag(scale), rising lengths (p,) and axes U (p, p)."""

    scale: Array
    lengths: Array
    axes: Array

    @classmethod
    def of(cls, matrix: Array) -> "Spectrum":
        """Of normal equations (p, p); a column of zeros keeps the scale 1."""
        size = np.sqrt(np.diag(matrix))
        scale = np.where(size > 0.0, size, 1.0)
        return cls(scale, *np.linalg.eigh(matrix / np.outer(scale, scale)))

    @property
    def shown(self) -> NDArray[np.bool_]:
        """Which axes are determined, (p,)."""
        return np.asarray(self.lengths > max(SPECTRUM_RANK * self.lengths[-1], 0.0))

    @property
    def rank(self) -> int:
        """How many."""
        return int(np.count_nonzero(self.shown))

    @property
    def condition(self) -> float:
        """Condition number of the scaled columns W D^-1; infinite with an axis that is not determined."""
        return float(np.sqrt(self.lengths[-1] / self.lengths[0])) if self.shown[0] else float("inf")

    @property
    def determined(self) -> NDArray[np.bool_]:
        """Which parameters are, (p,): their share of the other axes is nothing."""
        return np.asarray(np.sum(self.axes[:, ~self.shown] ** 2, axis=1) < SHARED)

    def inverse(self) -> Array:
        """(W^T W)^-1 in the axes that are determined, 0 in the others, (p, p)."""
        root = self.axes[:, self.shown] / np.sqrt(self.lengths[self.shown]) / self.scale[:, None]
        return np.asarray(root @ root.T)

    def factor(self) -> Array:
        """R (p, p), upper triangular with a diagonal >= 0 and R^T R = W^T W."""
        R = np.linalg.qr(np.sqrt(np.maximum(self.lengths, 0.0))[:, None] * self.axes.T * self.scale, mode="r")
        return np.asarray(R * np.where(np.diag(R) < 0.0, -1.0, 1.0)[:, None])


def solved(matrix: Array, side: Array, inverse: Array) -> Array:
    """matrix^-1 side with one step of refinement; least length in scaled columns where the inverse is partial."""
    values = inverse @ side
    return np.asarray(values + inverse @ (side - matrix @ values))


SIGMAS = 3.0
"""Half-width of the intervals, as a normal deviation: 99.73 % of Student's t are inside."""
HUBER = 1.345
"""Residuals beyond this many standard deviations count less: 95 % efficiency on normal noise (Huber 1981)."""
ROUNDS = 100
SETTLED = 1e-12
IDENTIFIED, NOT_EXCITED, ZERO, NO_ERROR = "identified", "not excited", "0 within 3 sigma", "no error known"
"""States of an estimated parameter beside a model's own value."""
RANK = 1e-10
"""Singular value of scaled columns, as a share of the largest, below which they do not determine all parameters."""


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """Parameters (p,), their covariance (p, p) and residuals (m,); `dof` = m - p is what the noise was taken from."""

    values: Array
    covariance: Array
    residuals: Array
    dof: int

    def __post_init__(self) -> None:
        freeze_arrays(self, "values", "covariance", "residuals")

    @property
    def standard_errors(self) -> Array:
        """(p,), NaN where no point is left to estimate the noise."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def half_widths(self) -> Array:
        """Of the 3-sigma intervals, (p,): standard error times Student's t of 99.73 %."""
        return self.standard_errors * student_factor(self.dof)

    @property
    def rms(self) -> float:
        """Root mean square of the residuals."""
        return float(np.sqrt(np.mean(np.square(self.residuals))))


def student_factor(dof: int) -> float:
    """The t that holds as much of Student's distribution as 3 sigma of the normal one; NaN without freedom.

    >>> round(student_factor(10), 3), round(student_factor(10**6), 3)
    (3.957, 3.0)
    """
    return float(special.stdtrit(dof, special.ndtr(SIGMAS))) if dof > 0 else float("nan")


def has_full_rank(X: Array) -> bool:
    """Whether the columns of X (m, p) determine every parameter."""
    norms = np.linalg.norm(X, axis=0)
    if len(X) < X.shape[1] or not norms.all():
        return False
    singular = np.linalg.svd(X / norms, compute_uv=False)
    return bool(singular[-1] > RANK * singular[0])


def weighted(X: Array, y: Array, weights: Array) -> Estimate:
    """min sum w (y - X b)^2 with cov(b) = s^2 (X^T W X)^-1, s^2 = sum w r^2 / (m - p).

    Parameters
    ----------
    X : (m, p) array
    y : (m,) array
    weights : (m,) array
        Inverse variances of y up to a common factor, which the residuals give.

    >>> weighted(np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]]), np.array([1.0, 3.0, 5.0]), np.ones(3)).values.round(9)
    array([1., 2.])
    """
    m, p = X.shape
    root = np.sqrt(weights)
    values = np.asarray(np.linalg.lstsq(X * root[:, None], y * root, rcond=None)[0], dtype=np.float64)
    residuals = y - X @ values
    dof = m - p
    variance = float(weights @ residuals**2) / dof if dof > 0 else float("nan")
    inverse = np.asarray(np.linalg.inv(X.T @ (X * weights[:, None])), dtype=np.float64)
    return Estimate(values, variance * inverse, residuals, dof)


def huber(X: Array, y: Array, weights: Array) -> Estimate:
    """The same with Huber's loss, so that outliers have little influence: least squares with weights that adapt.

    The scale is the median absolute deviation of the residuals. The covariance is Huber's: that of least squares on the
    bounded residuals psi, K^2 [sum psi^2/(m-p)] / mean(psi')^2 (X^T W X)^-1 with K = 1 + p/m (1 - mean psi')/mean psi'.
    It holds for many points: of five cruises and two parameters the 3-sigma intervals covered 98.2 %, not 99.7.

    References
    ----------
    Huber, Robust Statistics (1981), section 7.6.
    """
    m, p = X.shape
    root, estimate = np.sqrt(weights), weighted(X, y, weights)
    if m <= p:
        return estimate
    for _ in range(ROUNDS):
        scaled = root * estimate.residuals
        scale = 1.4826 * float(np.median(np.abs(scaled))) * np.sqrt(m / (m - p))
        if scale <= SETTLED * float(np.abs(root * y).max()):
            break  # more than half of the points are met exactly
        tamed = np.minimum(1.0, HUBER * scale / np.maximum(np.abs(scaled), 1e-300))
        fresh = weighted(X, y, weights * tamed)
        settled = np.abs(fresh.values - estimate.values).max() <= SETTLED * np.abs(fresh.values).max()
        estimate = fresh
        if settled:
            break
    else:
        scale = float("inf")
    scaled = root * estimate.residuals
    bounded = np.clip(scaled, -HUBER * scale, HUBER * scale)
    inside = float(np.mean(np.abs(scaled) < HUBER * scale)) or 1 / m
    factor = (1 + p / m * (1 - inside) / inside) ** 2 * float(bounded @ bounded) / (m - p) / inside**2
    return Estimate(estimate.values, factor * np.linalg.inv(X.T @ (X * weights[:, None])), estimate.residuals, m - p)
