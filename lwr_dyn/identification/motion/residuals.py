"""What a fit leaves of measured torques: residuals, and whether they are white noise.

r_k = sum of e(i) e(i + k) / sum of e^2 over pairs k instants apart in one recording, both of them used. White noise has
r_k of mean 0 and variance 1/(pairs), so that Q = sum of pairs r_k^2 over `LAGS` lags follows chi^2 with `LAGS` degrees
of freedom.

References
----------
Box, Pierce, Distribution of residual autocorrelations in autoregressive-integrated moving average time series models
(1970), eq. 1.3; with pairs in place of the length where instants are left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns

LAGS = 10
"""Instants up to which residuals are compared with later ones."""
LONGEST = 300
"""Instants over which alike residuals are summed at most."""
LEVEL = 0.01
"""Share of white logs that are called not white."""


@dataclass(frozen=True, slots=True, eq=False)
class Whiteness:
    """Of one joint: autocorrelation (LAGS,) of its residuals from lag 1, the statistic Q and its probability.

    `inflation`: by how much a mean over many instants is more uncertain than that of white noise with the same
    variance, sqrt(1 + 2 sum r_k) over the lags up to the first that is not positive beyond its own noise: at least 1.
    """

    joint: int
    autocorrelation: Array
    statistic: float
    probability: float
    inflation: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "autocorrelation", read_only(self.autocorrelation))

    @property
    def white(self) -> bool:
        """Whether noise alone would give as large a Q in more than `LEVEL` of logs."""
        return bool(self.probability > LEVEL)


def residuals_of(samples: Samples, columns: TorqueColumns, base_values: Array) -> Array:
    """Measured less predicted torques (k, n) [N m or N], NaN in equations that are not used."""
    out = predicted(samples, columns, base_values)
    np.subtract(samples.tau, out, out=out)
    out[~samples.used] = np.nan
    return out


def predicted(samples: Samples, columns: TorqueColumns, base_values: Array) -> Array:
    """Torques (k, n) of base values (b,) or of all parameters (p,)."""
    return columns.torques(samples.q, samples.dq, samples.ddq, base_values)


def rms(values: Array) -> float:
    """Root mean square of those that are not NaN; NaN of none."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(np.square(known)))) if known.size else float("nan")


def whiteness_of(residuals: Array, recording: NDArray[np.intp]) -> tuple[Whiteness, ...]:
    """Of residuals (k, n), NaN where not used, in recordings (k,); a joint without any is left out."""
    found = [_of_joint(j + 1, residuals[:, j], recording) for j in range(residuals.shape[1])]
    return tuple(one for one in found if one is not None)


def inflation_of(whiteness: Sequence[Whiteness], joints: int) -> Array:
    """By how much the noise of every joint is larger in slow sums, (n,): 1 where its residuals are white."""
    out = np.ones(joints)
    for one in whiteness:
        out[one.joint - 1] = 1.0 if one.white else one.inflation
    return out


def _of_joint(joint: int, residual: Array, recording: NDArray[np.intp]) -> Whiteness | None:
    known = np.isfinite(residual)
    if np.count_nonzero(known) <= LAGS:
        return None
    variance = float(np.mean(np.square(residual[known])))
    r, pairs = np.zeros(LAGS), np.zeros(LAGS)
    alike, cut = 0.0, False
    for k in range(1, LONGEST + 1):
        if k > LAGS and cut:
            break
        product = residual[k:] * residual[:-k]
        together = np.isfinite(product) & (recording[k:] == recording[:-k])
        count = int(np.count_nonzero(together))
        correlation = float(np.mean(product[together])) / variance if variance > 0.0 and count else 0.0
        cut = cut or correlation <= 2.0 / np.sqrt(max(count, 1))
        alike += 0.0 if cut else correlation
        if k <= LAGS:
            r[k - 1], pairs[k - 1] = correlation, count
    statistic = float(pairs @ np.square(r))
    inflation = float(np.sqrt(1.0 + 2.0 * alike))
    return Whiteness(joint, r, statistic, float(stats.chi2.sf(statistic, LAGS)), inflation)
