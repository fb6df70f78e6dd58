"""Instrumental variables for logs without a filter: columns of the motion that was commanded stand in for noisy ones.

    values = (Z^T W)^-1 Z^T tau,   W = Y(q, dq, ddq) as measured,   Z = w Y(q_r, dq_r, ddq_r) of the reference

Differences of unfiltered positions put noise into W, which least squares turns into bias. Z has no noise and is close
to the true columns, so Z^T (tau - W b) is 0 on average at the true b. Every row is used: a sum of second differences
of noise under a smooth Z cancels but for its ends, so w, which leaves out slow instants, falls to 0 smoothly. With
every tenth row nothing cancels: of 10 s with 1e-5 rad at 1 kHz the standard errors were 1000 times larger.

References
----------
Janot, Vandanjon, Gautier, A generic instrumental variable approach for industrial robot identification (2014), eqs. 17
to 22 (IDIM-IV); Preisig, Rippin, Theory and application of the modulating function method (1993), for smooth weights.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from lwr_dyn.foundation.arrays import Array, fixed_array, freeze_arrays
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.regression.base_parameters import BaseParameters
from lwr_dyn.identification.regression.long_run import HANN_BAND, WINDOW, window_sums
from lwr_dyn.identification.regression.normal_equations import BLOCK
from lwr_dyn.identification.regression.samples import SampleRule, Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.run import Motion, Run

UNFILTERED = SampleRule(cutoff=None, spacing=1e-9, slowest=0.0)
"""Every row of a log, as it is."""
ROUNDS = 2
"""Of noise and estimate in turn: from the first the weights are right within the noise of the noise."""
WEAK = 1e-12
"""Singular value of the scaled Z^T W, as a share of the largest, below which a reference does not determine all."""
Blocks = Callable[[], Iterator[tuple[slice, Array, Array]]]
"""Rows, W and Z (k, g, p) of them, as often as asked."""


@dataclass(frozen=True, slots=True, eq=False)
class InstrumentalEstimate:
    """Base parameters (b,) with a sandwich covariance (b, b); `noise` (n,) is that of the torques in slow sums.

    White noise of the torques shows as itself there, that of unfiltered accelerations hardly.
    """

    columns: TorqueColumns
    base: BaseParameters
    values: Array
    covariance: Array
    noise: Array
    equations: int

    def __post_init__(self) -> None:
        freeze_arrays(self, "values", "covariance", "noise")

    @property
    def sigma(self) -> Array:
        """Standard errors (b,)."""
        return np.sqrt(np.diag(self.covariance))


def motion_of_run(run: Run, t: Array) -> Motion:
    """The motion of a simulated run at times t (k,) [s] inside it: what the loop does, not what it was asked for.

    Accelerations are slopes of a spline through the run's own velocities.
    """
    speed = CubicSpline(run.t, run.dq)
    return Motion(t, CubicSpline(run.t, run.q)(t), speed(t), speed(t, 1))


def instrumental(
    samples: Samples, columns: TorqueColumns, motion: Motion, slowest: float = 0.05, window: float = WINDOW
) -> InstrumentalEstimate:
    """Base parameters by instrumental variables.

    Parameters
    ----------
    samples : Samples
        Every row without a filter: `samples_of(logs, UNFILTERED)`.
    columns : TorqueColumns
    motion : Motion
        The reference sampled at `samples.t`, or the motion of a simulated run (`motion_of_run`): (k, n) each.
    slowest : float
        Speed of the reference up to which a joint's equation is left out [rad/s or m/s]; from twice that on it counts
        fully. The measured speed would choose by its noise.
    window : float
        Of the sums in which noise is seen [s].

    Returns
    -------
    InstrumentalEstimate

    Raises
    ------
    ShapeError
        A motion of other instants.
    OptionError
        A window or slowest speed that is not above 0.
    LogError
        A motion that does not determine all base parameters.
    """
    for name, value in (("window", window), ("slowest", slowest)):
        if not (np.isfinite(value) and value > 0.0):
            raise OptionError(f"instrumental {name}", value, "a number above 0")
    for name in ("q", "dq", "ddq"):
        fixed_array(f"{name} of the motion", getattr(motion, name), (len(samples), columns.n))
    base = columns.base()

    def blocks() -> Iterator[tuple[slice, Array, Array]]:
        for first in range(0, len(samples), BLOCK):
            rows = slice(first, first + BLOCK)
            W, Z = (columns(x.q[rows], x.dq[rows], x.ddq[rows])[:, :, base.kept] for x in (samples, motion))
            yield rows, W, Z

    taper = smooth_step(np.abs(motion.dq) / slowest - 1.0) * samples.used
    values, covariance, noise = instrumental_fit(blocks, samples.tau, taper, samples, window)
    return InstrumentalEstimate(columns, base, values, covariance, noise, int(np.count_nonzero(taper)))


def smooth_step(x: Array) -> Array:
    """From 0 at x <= 0 to 1 at x >= 1, with two continuous derivatives."""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x**3 * (10.0 - 15.0 * x + 6.0 * x * x))


def instrumental_fit(
    blocks: Blocks, y: Array, taper: Array, samples: Samples, window: float
) -> tuple[Array, Array, Array]:
    """Values (p,), covariance (p, p) and noise (g,) of equations y (k, g) with weights `taper` (k, g), by g groups.

    Groups are weighted by their noise in slow sums. The covariance is (Z^T W)^-1 S (W^T Z)^-1 with S that of the sum of
    Z^T (y - W b), all groups of an instant together, as an error of one position is in all torques. Raises `LogError`.
    """
    groups = y.shape[1]
    parts = [_products(W, Z * taper[rows, :, None], y[rows]) for rows, W, Z in blocks()]
    across, sides = (np.sum(x, axis=0) for x in zip(*parts, strict=True))
    length = _rows_of(samples, window)
    power = np.sum(taper**2, axis=0)
    noise = np.ones(groups)
    for _ in range(ROUNDS):
        values, inverse = _solve(across, sides, noise, samples)
        left = np.concatenate([y[rows] - W @ values for rows, W, _ in blocks()]) * taper
        squares = (window_sums(left, samples.recording, length) ** 2).sum(axis=0)
        noise = np.where(power > 0.0, np.sqrt(np.maximum(squares, 1e-300) / np.maximum(power, 1e-300)), 1.0)
    values, inverse = _solve(across, sides, noise, samples)
    scores = np.concatenate([
        np.einsum("kgp,kg->kp", Z, (y[rows] - W @ values) * taper[rows] / noise**2, optimize=True)
        for rows, W, Z in blocks()
    ])  # fmt: skip
    root = inverse @ window_sums(scores, samples.recording, length).T
    slow = HANN_BAND * np.count_nonzero(taper) / length  # independent slow sums, of which the parameters take up theirs
    return values, root @ root.T * (slow / max(slow - len(values), 1.0)), noise


def _products(W: Array, Z: Array, y: Array) -> tuple[Array, Array]:
    """Z^T W (g, p, p) and Z^T y (g, p)."""
    groups = range(y.shape[1])
    return np.array([Z[:, g].T @ W[:, g] for g in groups]), np.array([Z[:, g].T @ y[:, g] for g in groups])


def _rows_of(samples: Samples, window: float) -> int:
    return max(1, round(window / float(np.median(np.diff(samples.t)))))


def _solve(across: Array, sides: Array, noise: Array, samples: Samples) -> tuple[Array, Array]:
    """Values and (Z^T W)^-1 with the weights of some noise."""
    matrix, side = np.tensordot(noise**-2.0, across, 1), noise**-2.0 @ sides
    size = np.sqrt(np.abs(np.diag(matrix)))
    scale = np.where(size > 0.0, size, 1.0)
    scaled = matrix / np.outer(scale, scale)
    singular = np.linalg.svd(scaled, compute_uv=False)
    if not singular[-1] > WEAK * singular[0]:
        needed = "a motion of every joint both ways, at changing speeds"
        where = ", ".join(dict.fromkeys(samples.sources))
        raise LogError(where, "columns q1..", "the motion does not determine all parameters", needed)
    inverse = np.linalg.inv(scaled) / np.outer(scale, scale)
    return inverse @ side, inverse
