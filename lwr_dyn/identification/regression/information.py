"""What logs say of the base parameters: weighted least squares with the noise of every joint, and what they leave open.

    chi^2(b) = sum_j |tau_j - W_j b|^2 / s_j^2,    precision = sum_j W_j^T W_j / s_j^2,    R^T R = precision

s_j is the noise of joint j, from its own residuals unless it is given.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.regression.base_parameters import BaseParameters
from lwr_dyn.identification.regression.grouped import grouped
from lwr_dyn.identification.regression.normal_equations import NormalEquations, normal_equations
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.spectrum import Spectrum
from lwr_dyn.identification.regression.torque_columns import TorqueColumns


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
    def joint_precision(self) -> Array:
        """W_j^T W_j / s_j^2 of every joint, (n, b, b): their sum is the precision."""
        seen = self.equations > 0
        return self.normal.matrices * np.where(seen, 1.0 / np.where(seen, self.noise, 1.0) ** 2, 0.0)[:, None, None]

    @property
    def covariance(self) -> Array:
        """(b, b): the inverse of the precision in the directions that the log shows; see `sigma` for the others."""
        return Spectrum.of(self.precision).inverse()

    @property
    def sigma(self) -> Array:
        """Standard errors (b,), infinite where not determined."""
        return np.where(self.determined, np.sqrt(np.diag(self.covariance)), np.inf)

    @property
    def factor(self) -> Array:
        """R (b, b), upper triangular with R^T R = precision."""
        return Spectrum.of(self.precision).factor()

    @property
    def condition(self) -> float:
        """Condition number of the weighted columns scaled to length 1; infinite where a parameter is not seen."""
        return Spectrum.of(self.precision).condition

    def chi2_of(self, values: Array) -> float:
        """chi^2 of other base values (b,)."""
        away = values - self.values
        return self.chi2 + float(away @ self.precision @ away)

    def residual_rms(self, values: Array) -> Array:
        """RMS residual of every joint (n,) with base values (b,) [N m or N]; NaN without equations."""
        squares = self.normal.residual_squares(values)
        return np.sqrt(np.where(self.equations > 0, squares / np.maximum(self.equations, 1), np.nan))


def information_of(
    samples: Samples | Iterable[Samples],
    columns: TorqueColumns,
    base: BaseParameters | None = None,
    noise: Array | None = None,
) -> Information:
    """What instants of logs say of the base parameters.

    Parameters
    ----------
    samples : Samples or iterable of Samples
        All instants, or a part at a time (`sample_parts`).
    columns : TorqueColumns
    base : BaseParameters, optional
        Those of the columns if not given.
    noise : (n,) array, optional
        Standard deviation of every joint's torque [N m or N]; estimated from the residuals if not given.

    Returns
    -------
    Information

    Raises
    ------
    ShapeError
        Samples of another number of joints.
    """
    chosen = columns.base() if base is None else base
    return solve(normal_equations(samples, columns, chosen), columns, chosen, noise)


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
