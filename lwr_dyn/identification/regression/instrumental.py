"""Instrumental variables for logs without a filter: columns of the motion that was commanded stand in for noisy ones.

    values = (Z^T W)^-1 Z^T tau,   W = Y(q, dq, ddq) as measured,   Z = w Y(q_r, dq_r, ddq_r) of the reference

Differences of unfiltered positions put noise into W, which least squares turns into bias. Z has no noise and is close
to the true columns, so Z^T (tau - W b) is 0 on average at the true b. Every row is used: a sum of second differences
of noise under a smooth Z cancels but for its ends, so w, which leaves out slow instants, falls to 0 smoothly. With
every tenth row nothing cancels: of 10 s with 1e-5 rad at 1 kHz the standard errors were 1000 times larger. What is left
of such noise shows in slow sums (`window_sums`).

References
----------
Janot, Vandanjon, Gautier, A generic instrumental variable approach for industrial robot identification (2014), eqs. 17
to 22 (IDIM-IV); Preisig, Rippin, Theory and application of the modulating function method (1993), for smooth weights.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import oaconvolve
from scipy.signal.windows import hann

from lwr_dyn.foundation.arrays import Array, fixed_array, freeze_arrays
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.regression.information import BLOCK, Information, normal_equations
from lwr_dyn.identification.regression.least_squares import BaseParameters
from lwr_dyn.identification.regression.samples import SampleRule, Samples, samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.run import Motion

WINDOW = 0.1
"""[s] Longer than the memory of noise, shorter than a motion. A fit takes up slow noise: from windows of 0.2 s errors
of 10 s logs came out 8 % too small, of 0.1 s 4 %."""
HANN_BAND = 1.5
"""Independent sums under Hann windows in the length of one (equivalent noise bandwidth, Harris 1978)."""
OVERLAP = 4
"""Windows that begin within the length of one."""


def window_sums(series: Array, recording: NDArray[np.intp], length: int) -> Array:
    """v (w, m) of a series (k, m) with v^T v = S, the covariance of its sum over k as slow windows show it.

    The sums are under Hann windows of `length` rows inside one recording, scaled so that white noise gives k times its
    variance. Noise whose sums cancel, as second differences do, gives what is left of it and not its own size.

    References
    ----------
    Priestley, Spectral Analysis and Time Series (1981), section 6.2: S is k times the spectrum at frequency 0.

    >>> noise = np.diff(np.random.default_rng(0).normal(size=(4002, 1)), n=2, axis=0)
    >>> v = window_sums(noise, np.zeros(4000, dtype=int), 200)
    >>> bool((v**2).sum() / 4000 < 1e-3 * noise.var())
    True
    """
    out = []
    for part in _parts(recording):
        size = min(length, part.stop - part.start)
        shape = hann(size + 2)[1:-1]
        sums = oaconvolve(series[part], shape[:, None], mode="valid", axes=0)[:: max(1, size // OVERLAP)]
        share = (part.stop - part.start) / len(sums)  # every recording counts with its rows
        out.append(sums * np.sqrt(share / (shape @ shape)))
    return np.concatenate(out)


def _parts(recording: NDArray[np.intp]) -> Iterator[slice]:
    edges = [0, *(np.flatnonzero(np.diff(recording)) + 1).tolist(), len(recording)]
    return (slice(a, b) for a, b in pairwise(edges) if b > a)


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


def instrumental(
    samples: Samples, columns: TorqueColumns, motion: Motion, slowest: float = 0.05, window: float = WINDOW
) -> InstrumentalEstimate:
    """Base parameters by instrumental variables.

    Parameters
    ----------
    samples : Samples
        Every row without a filter: `samples_of(logs, UNFILTERED)`.
    motion : Motion
        The reference sampled at `samples.t`, or the motion of a simulated run there: (k, n) each.
    slowest : float
        Speed of the reference up to which a joint's equation is left out [rad/s or m/s]; from twice that on it counts
        fully. The measured speed would choose by its noise.
    window : float
        Of the sums in which noise is seen [s].

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
    length = samples.rows_in(window)
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


def commanded_motion(command: JointLog, t: Array) -> Motion:
    """The motion that was commanded at times t (k,) [s], by a spline through its positions.

    Parameters
    ----------
    command : JointLog
        Its times and positions count, its torques need not be there: the file of `lwr-dyn excite`, or a run of the same
        command by `lwr-dyn simulate`, whose motion is nearer to that of the arm.
    t : (k,) array

    Raises
    ------
    LogError
        A command that does not cover these times.
    """
    slack = 0.5 * float(np.median(np.diff(command.t)))
    if t[0] < command.t[0] - slack or t[-1] > command.t[-1] + slack:
        found = f"{command.t[0]:g} to {command.t[-1]:g} s"
        raise LogError(command.source, "column time", found, f"all times of the log, {t[0]:g} to {t[-1]:g} s")
    q = CubicSpline(command.t, command.q)
    return Motion(t, q(t), q(t, 1), q(t, 2))


def instrumental_information(
    logs: Sequence[JointLog], commands: Sequence[JointLog], columns: TorqueColumns, slowest: float
) -> tuple[Information, Samples]:
    """What logs without a filter say of the base parameters, and their torques along the commanded motion.

    Parameters
    ----------
    logs, commands : sequence of JointLog
        Recordings, and the command of each.
    slowest : float
        Speed of the command up to which a joint's equation is left out [rad/s or m/s].

    Returns
    -------
    Information, Samples
        Values, precision and noise of `instrumental`; chi^2 is that of the noise, which is taken from the residuals.
        Normal equations and samples have the states of the command, which have no noise: they compare predictions.

    Raises
    ------
    OptionError
        Another number of commands than of logs.
    LogError
        A command that does not cover the times of its log; as `samples_of` and `instrumental`.
    """
    if len(commands) != len(logs):
        raise OptionError("instruments", f"{len(commands)} for {len(logs)} logs", "one for each log, in their order")
    samples = samples_of(logs, UNFILTERED)
    motions = [commanded_motion(c, samples_of([log], UNFILTERED).t) for log, c in zip(logs, commands, strict=True)]
    t, q, dq, ddq = (np.concatenate([getattr(m, name) for m in motions]) for name in ("t", "q", "dq", "ddq"))
    found = instrumental(samples, columns, Motion(t, q, dq, ddq), slowest)
    used = samples.used & (np.abs(dq) > slowest)
    along = replace(samples, q=q, dq=dq, ddq=ddq, used=used)
    dof = found.equations - found.base.count
    information = Information(
        columns, found.base, found.values, np.asarray(np.linalg.inv(found.covariance), dtype=np.float64), found.noise,
        np.count_nonzero(used, axis=0), float(dof), dof, np.ones(found.base.count, dtype=np.bool_),
        normal_equations(along, columns, found.base), np.ones(columns.n),
    )  # fmt: skip
    return information, along
