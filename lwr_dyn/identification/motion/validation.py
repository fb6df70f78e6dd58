"""How well a fit predicts torques that it has not seen, and whether what it leaves is white noise.

Some motions are kept from a fit in turn: recordings, or parts of one, cut where it is slow. Whiteness:

    r_k = sum of e(i) e(i + k) / sum of e^2 over pairs k instants apart in one recording, both of them used

White noise has r_k of mean 0 and variance 1/(pairs), so that Q = sum of pairs r_k^2 over `LAGS` lags follows chi^2 with
`LAGS` degrees of freedom. A mean of N instants has the variance c^2 s^2 / N with c^2 = 1 + 2 sum r_k. A fit takes up
slow noise first: p parameters paid by N equations make every r_k of its residuals about c^2 p / N too small, so

    c^2 = (1 + 2 sum_k<=K r_k) / (1 - (2 K + 1) p / N)

References
----------
Box, Pierce, Distribution of residual autocorrelations in autoregressive-integrated moving average time series models
(1970), eq. 1.3; with pairs in place of the length where instants are left out. Anderson, The Statistical Analysis of
Time Series (1971), section 8.2, for the bias of correlations about a fitted mean.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import reduce
from itertools import pairwise
from operator import add

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.regression.information import Information, NormalEquations, normal_equations, solve
from lwr_dyn.identification.regression.least_squares import BaseParameters, Spectrum, solved
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns

LAGS = 10
"""Instants up to which residuals are compared with later ones."""
LONGEST = 300
"""Instants over which alike residuals are summed at most."""
LEAST_LEFT = 0.3
"""Least share of slow noise that a fit is taken to have left."""
WELL_SEEN = 1e4
"""Condition beyond which a fit without a fold says nothing of errors."""
LEVEL = 0.01
"""Share of white logs that are called not white."""


@dataclass(frozen=True, slots=True, eq=False)
class Whiteness:
    """Of one joint: autocorrelation (LAGS,) of its residuals from lag 1, the statistic Q and its probability.

    `inflation`: by how much a mean over many instants is more uncertain than that of white noise with the same
    variance, c over the lags up to the first that is not positive beyond its own noise: at least 1.
    """

    joint: int
    autocorrelation: Array
    statistic: float
    probability: float
    inflation: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "autocorrelation")

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
    """Root mean square of those that are not NaN; NaN of none.

    >>> rms(np.array([3.0, np.nan, -3.0]))
    3.0
    """
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(np.square(known)))) if known.size else float("nan")


def whiteness_of(residuals: Array, recording: NDArray[np.intp], paid: Array | float = 0.0) -> tuple[Whiteness, ...]:
    """Of residuals (k, n), NaN where not used, in recordings (k,); a joint without any is left out.

    `paid` (n,) are the parameters that each joint's equations paid for (`Information.paid`).
    """
    n = residuals.shape[1]
    taken = np.broadcast_to(paid, n).tolist()
    found = [_of_joint(j + 1, residuals[:, j], recording, taken[j]) for j in range(n)]
    return tuple(one for one in found if one is not None)


def inflation_of(whiteness: Sequence[Whiteness], joints: int) -> Array:
    """By how much the noise of every joint is larger in slow sums, (n,): 1 where its residuals are white."""
    out = np.ones(joints)
    for one in whiteness:
        out[one.joint - 1] = 1.0 if one.white else one.inflation
    return out


def _of_joint(joint: int, residual: Array, recording: NDArray[np.intp], paid: float) -> Whiteness | None:
    known = np.isfinite(residual)
    equations = int(np.count_nonzero(known))
    if equations <= LAGS:
        return None
    variance = float(np.mean(np.square(residual[known])))
    r, pairs = np.zeros(LAGS), np.zeros(LAGS)
    share, square, alike, cut = paid / equations, 1.0 / max(1.0 - paid / equations, LEAST_LEFT), 0.0, False
    for k in range(1, LONGEST + 1):
        if k > LAGS and cut:
            break
        product = residual[k:] * residual[:-k]
        together = np.isfinite(product) & (recording[k:] == recording[:-k])
        count = int(np.count_nonzero(together))
        correlation = float(np.mean(product[together])) / variance if variance > 0.0 and count else 0.0
        cut = cut or correlation + share * square <= 2.0 / np.sqrt(max(count, 1))
        if not cut:
            alike += correlation
            square = (1.0 + 2.0 * alike) / max(1.0 - (2 * k + 1) * share, LEAST_LEFT)
        if k <= LAGS:
            r[k - 1], pairs[k - 1] = correlation, count
    statistic = float(pairs @ np.square(r))
    inflation = float(np.sqrt(max(1.0, square)))
    return Whiteness(joint, r, statistic, float(stats.chi2.sf(statistic, LAGS)), inflation)


SEARCHED = 0.3
"""Share of a piece's length, on each side of an even division, in which the slowest instant is looked for."""


def motion_pieces(samples: Samples, folds: int) -> NDArray[np.intp]:
    """Which fold each instant belongs to, (k,), from 0: whole recordings where there are enough, else parts of them.

    Recordings are dealt out in turn. Where there are fewer than folds, each is cut into equal parts, near every
    division at the instant at which the fastest joint (as a share of its largest speed) is slowest: neighbours then
    share no fast motion.

    Raises
    ------
    OptionError
        Fewer than two folds, or more than there are instants.
    """
    if not 2 <= folds <= len(samples):
        raise OptionError("folds", folds, f"2 to {len(samples)}, the number of instants")
    numbers = np.unique(samples.recording)
    if len(numbers) >= folds:
        return np.asarray(np.searchsorted(numbers, samples.recording) % folds)
    out = np.empty(len(samples), dtype=np.intp)
    fastest = np.abs(samples.dq).max(axis=0)
    speed = (np.abs(samples.dq) / np.where(fastest > 0.0, fastest, 1.0)).max(axis=1)
    for number in numbers:
        rows = np.flatnonzero(samples.recording == number)
        cuts = _slow_cuts(speed[rows], folds)
        out[rows] = np.searchsorted(cuts, np.arange(len(rows)), side="right")
    return out


def _slow_cuts(speed: Array, parts: int) -> NDArray[np.intp]:
    """First rows of the second and later parts."""
    length = len(speed) / parts
    cuts = []
    for i in range(1, parts):
        first = int((i - SEARCHED) * length)
        last = max(first + 1, int((i + SEARCHED) * length))
        cuts.append(first + int(np.argmin(speed[first:last])))
    return np.array(cuts, dtype=np.intp)


THIRDS = 3
"""Bands of speed of equal width, up to a joint's largest."""
Refit = Callable[[Information], Array]
"""From what logs say to the parameters (p,) of bodies."""


@dataclass(frozen=True, slots=True)
class SpeedBand:
    """RMS of what the fit leaves of unseen torques at speeds |dq| from `slowest` to `fastest` [rad/s or m/s]."""

    slowest: float
    fastest: float
    equations: int
    left: float


@dataclass(frozen=True, slots=True)
class Validation:
    """RMS torques of one joint [N m or N]: measured, and what is left of them.

    `fitted`: by the fit, of torques it saw. `held_out`: by fits that did not see the motion. `consistent`: by fits
    whose links are bodies, that did not see it either; None if there are none. `model`: by the arm's own model with its
    own friction. `by_speed` splits `held_out`. `left_out`: by fits that did not see the motion, of torques at instants
    that no fit takes, slower than its slowest speed or beside a reversal; None without such instants.
    """

    joint: int
    measured: float
    fitted: float
    held_out: float
    consistent: float | None
    model: float
    by_speed: tuple[SpeedBand, ...] = ()
    left_out: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Folds:
    """Motions of which some are kept from a fit in turn: which fold an instant is of, and their normal equations."""

    samples: Samples
    known: NDArray[np.bool_]
    """Which torques (k, n) were measured, whether a fit takes them or not."""
    columns: TorqueColumns
    base: BaseParameters
    fold: NDArray[np.intp]
    normal: tuple[NormalEquations, ...]

    @classmethod
    def of(cls, samples: Samples, columns: TorqueColumns, count: int, known: NDArray[np.bool_]) -> "Folds":
        """Motions dealt to `count` folds; raises `OptionError` as `motion_pieces`."""
        base, fold = columns.base(), motion_pieces(samples, count)
        return cls(samples, known, columns, base, fold, _by_fold(samples, columns, fold, count))

    def times(self, factors: Array) -> "Folds":
        """The same with the torques of each joint multiplied by a factor, (n,)."""
        normal = tuple(part.times(factors) for part in self.normal)
        return Folds(self.samples.times(factors), self.known, self.columns, self.base, self.fold, normal)

    def with_columns(self, columns: TorqueColumns) -> "Folds":
        """The same motions in the same folds, with other columns."""
        normal = _by_fold(self.samples, columns, self.fold, len(self.normal))
        return replace(self, columns=columns, base=columns.base(), normal=normal)

    def information(self) -> Information:
        """What all of them say."""
        return solve(reduce(add, self.normal), self.columns, self.base)

    def inflation(self, information: Information) -> float:
        """How much more base values move when a fold is left out than their errors say: kappa, at least 1.

            kappa^2 = sum_f d_f^T A d_f / sum_f (tr(A A_-f^-1) - b)

        d_f is the change of the b values without fold f, A their precision. It is 1 for independent errors and more
        for those that last as long as a fold, or belong to a part of the joints' ranges. Folds without which a value
        is hardly seen are passed over.

        References
        ----------
        Shao, Wu, A general theory for jackknife variance estimation (1989), for leaving out blocks.
        """
        noise = np.where(np.isfinite(information.noise), information.noise, 1.0)
        matrix, side = reduce(add, self.normal).weighted(noise)
        if not information.determined.all():
            return 1.0
        values, moved, expected = information.values, 0.0, 0.0
        for part in self.normal:
            own, right = part.weighted(noise)
            spectrum = Spectrum.of(matrix - own)
            if spectrum.condition < WELL_SEEN:
                inverse = spectrum.inverse()
                change = solved(matrix - own, side - right, inverse) - values
                moved += float(change @ matrix @ change)
                expected += float(np.trace(matrix @ inverse)) - len(values)
        return float(np.sqrt(max(1.0, moved / expected))) if expected > 0.0 else 1.0

    def held_out(self, noise: Array, refit: Refit | None = None) -> Array:
        """Residuals (k, n) of torques by fits to the other folds, NaN where not known; `refit` makes bodies of them."""
        out = np.full(self.samples.tau.shape, np.nan)
        for i in range(len(self.normal)):
            rows = self.fold == i
            if not rows.any():
                continue
            others = reduce(add, (part for k, part in enumerate(self.normal) if k != i))
            found = solve(others, self.columns, self.base, noise)
            values = found.values if refit is None else self.base.of(refit(found))
            out[rows] = self.samples.tau[rows] - predicted(self.samples.select(rows), self.columns, values)
        return np.where(self.known, out, np.nan)


def _by_fold(
    samples: Samples, columns: TorqueColumns, fold: NDArray[np.intp], count: int
) -> tuple[NormalEquations, ...]:
    base = columns.base()
    return tuple(normal_equations(samples.select(fold == i), columns, base) for i in range(count))


def cross_validation(
    folds: Folds, information: Information, own: Array, refit: Refit | None = None
) -> tuple[Validation, ...]:
    """One `Validation` a joint, over motions kept from the fit in turn.

    Parameters
    ----------
    information : Information
        Of all of them.
    own : (p,) array
        The arm's own parameters.
    refit : callable, optional
        Makes bodies of what a part of the logs says.
    """
    samples, columns = folds.samples, folds.columns
    noise = np.where(np.isfinite(information.noise), information.noise, 1.0)
    unseen = folds.held_out(noise)
    bodies = None if refit is None else folds.held_out(noise, refit)
    seen = residuals_of(samples, columns, information.values)
    return _by_joint(samples, seen, unseen, bodies, residuals_of(samples, columns, own))


def validated_on(
    samples: Samples, known: NDArray[np.bool_], columns: TorqueColumns, values: Array, own: Array,
    parameters: Array | None = None,
) -> tuple[Validation, ...]:  # fmt: skip
    """The same on logs that no fit saw: base values (b,), parameters (p,) of bodies; `fitted` is NaN.

    `known` (k, n): which torques were measured, whether a fit would take them or not.
    """
    unseen = np.where(known, samples.tau - predicted(samples, columns, values), np.nan)
    bodies = None if parameters is None else residuals_of(samples, columns, columns.base().of(parameters))
    nothing = np.full(unseen.shape, np.nan)
    return _by_joint(samples, nothing, unseen, bodies, residuals_of(samples, columns, own))


def _by_joint(
    samples: Samples, fitted: Array, unseen: Array, bodies: Array | None, model: Array
) -> tuple[Validation, ...]:
    measured, taken = (np.where(samples.used, x, np.nan) for x in (samples.tau, unseen))
    beside = np.where(samples.used, np.nan, unseen)
    others = None if bodies is None else np.where(samples.used, bodies, np.nan)
    return tuple(
        Validation(
            j + 1, rms(measured[:, j]), rms(fitted[:, j]), rms(taken[:, j]),
            None if others is None else rms(others[:, j]), rms(model[:, j]),
            speed_bands(samples.dq[:, j], taken[:, j]),
            rms(beside[:, j]) if np.isfinite(beside[:, j]).any() else None,
        )
        for j in range(samples.n)
    )  # fmt: skip


def speed_bands(dq: Array, left: Array) -> tuple[SpeedBand, ...]:
    """Residuals (k,), NaN where not used, by thirds of the largest speed of dq (k,); bands without any are left out."""
    used = np.isfinite(left)
    speed = np.abs(dq)
    if not used.any():
        return ()
    edges: Sequence[float] = np.linspace(0.0, float(speed[used].max()), THIRDS + 1).tolist()
    out = []
    for slowest, fastest in pairwise(edges):
        rows = used & (speed > slowest) & (speed <= fastest)
        if rows.any():
            out.append(SpeedBand(slowest, fastest, int(np.count_nonzero(rows)), rms(left[rows])))
    return tuple(out)


def validation_table(found: Sequence[Validation], about: str, key: str, says: str) -> Table:
    """One row a joint: RMS torques that are left."""
    columns = (
        Heading("joint", key="joint", kind=int), Heading("RMS torque", "", ".4g", "measured", kind=float),
        Heading("left, seen", "", ".4g", "fitted", "Left by the fit, of torques it saw.", float),
        Heading("left, unseen", "", ".4g", "held_out", "Left by fits that did not see the motion.", float),
        Heading("by bodies", "", ".4g", "consistent", "Left by bodies that did not see the motion.", float),
        Heading("by the model", "", ".4g", "model", "Left by the robot's own model.", float),
        Heading("unseen, thirds of the speed, slow first", "",
                lambda bands: " ".join(f"{band['left']:.3g}" for band in bands), "by_speed",
                "Held out, by thirds of the speed.", list[SpeedBand]),
        Heading("unseen, left out", "", ".3g", "left_out",
                "Held out, at instants that no fit takes: slow, or beside a reversal.", float),
    )  # fmt: skip
    rows = [[asdict(v)[h.key or ""] for h in columns] for v in found]
    return Table(f"validation, RMS in N m (N): {about}", columns, rows, "", key, says)


def whiteness_table(found: Sequence[Whiteness]) -> Table:
    """One row a joint that moved."""
    columns = (
        Heading("joint", key="joint", kind=int),
        Heading("white", "", lambda x: "yes" if x else "no", "white", kind=bool),
        Heading("lag 1", "", lambda r: f"{r[0]:+.2f}", "autocorrelation", "From lag 1 on.", list[float]),
        Heading("probability", "", ".3g", "probability", "Of as large a statistic from noise alone.", float),
        Heading("errors x", "", ".2g", "inflation", "By how much the errors are widened where it is not white.", float),
    )
    rows = [(w.joint, w.white, w.autocorrelation, w.probability, w.inflation) for w in found]
    title = f"residuals, white at {LEVEL:.0%} over {LAGS} instants (Box, Pierce)"
    return Table(title, columns, rows, "", "whiteness")
