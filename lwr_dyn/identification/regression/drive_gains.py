"""Unknown gains of the torques: logs whose torques are currents times a drive gain that is known to some per cent.

    tau_j = g_j (W_j b) + noise,     log g_j ~ N(0, s^2)

A common factor of all gains over one of all bodies leaves the torques as they are: the prior of the gains, the table's
masses, or a mass that is known for certain fix it, and no log of one load does. About gains that are taken off the
torques already, and base parameters b0 that go with them, to first order in d = log of what is left of them

    tau_j = W_j b + d_j W_j b0,      d_j ~ N(-log of the gain taken off, s^2)

b0 without friction: that of a joint stays what it is in torques of the log, and a table's friction, which drives have
measured, is no witness to their gains. The column of a gain is the predicted torque, not the measured one: noise in a
column shrinks what it is the column of. It is a sum of other columns, so that everything follows from normal equations,
without the rows. Along the common factor, b = (1 - d) b0, this is exact.

Friction that grows with the load (`regression.load_friction`) is a share of what bodies ask, so that it stays in b0: a
gain is its factor as it is that of the bodies. What X^T S (tau - f(b)) = 0 has in place of -X^T S X as its slope,
-(X^T S X + E), is that of both: with d summed over, F = X^T S X less what d takes and E less the same.

References
----------
Gautier, Briot, New method for global identification of the joint drive gains of robots using a known payload mass
(2011); Global identification of joint drive gains and dynamic parameters of robots (2014): gains of all joints together
with the parameters, by total least squares, and the common factor by a known load. Fuller, Measurement Error Models
(1987), section 1.1, for the shrinking.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.identification.regression.information import Information, NormalEquations, solve, widened
from lwr_dyn.identification.regression.least_squares import BaseParameters, Spectrum, solved
from lwr_dyn.identification.regression.load_friction import load_indices, moved_precision
from lwr_dyn.identification.regression.torque_columns import TorqueColumns

QUIETEST = 1e-4
"""Noise of a joint as a share of its torques, below which it does not fall: rounding would hide the common factor."""
ROUNDS, SETTLED = 30, 1e-6
"""Of gains and base parameters in turn, at most; the change of the logs of gains that ends them."""
_LARGEST_STEP = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class DriveGains:
    """Gains of the torques, of the log over the true ones: `values` (n,) and standard errors `sigma` (n,)."""

    width: float
    """Standard deviation of their logs before the log: that of the prior."""
    values: Array
    covariance: Array
    """(n, n) of their logs, with what the table says of masses."""
    without_table: float
    """Standard error of the mean of their logs by log and prior alone."""
    moving: float = 0.0
    """By how many standard errors a gain would still move, were it found again: what numerical choices leave."""

    def __post_init__(self) -> None:
        freeze_arrays(self, "values", "covariance")

    @property
    def sigma(self) -> Array:
        """Standard errors (n,)."""
        return np.asarray(self.values * np.sqrt(np.diag(self.covariance)))

    @property
    def common(self) -> float:
        """Standard error of the mean of their logs: of the factor that gains and bodies share."""
        return _of_mean(self.covariance)


@dataclass(frozen=True, slots=True, eq=False)
class FreedGains:
    """What logs say where gains `taken` off their torques are known to a width: gains given base parameters."""

    taken: Array
    """(n,) logs of the gains that the torques of `given` were divided by."""
    width: float
    given: Information
    """With these gains as if they were known."""
    information: Information
    """With what is left of them unknown: values and precision of the base parameters, with the gains' prior."""
    _rate: Array
    """(n, b) of d for base parameters."""
    _start: Array
    """(n,) d at base parameters of 0."""
    _spread: Array
    """(n,) variance of d where the base parameters are known."""
    _turn: Array
    """(b, b): the identity, or F^-1 (F + E) with friction that grows with the load."""

    @classmethod
    def of(
        cls, given: Information, taken: Array, width: float, about: Array | None = None,
        volume: Array | float = 0.0, moving: Array | None = None,
    ) -> "FreedGains":  # fmt: skip
        """Of the information of torques that were divided by exp(taken), (n,).

        `about` are the base values b0 (b,): those of least squares have noise, and where a table has a say they are
        those with the table. `volume` (n,) is that of `volume_of`, `moving` (n, b, b) that of `loads_moved` at the
        values of `given`, whose precision is that of loads as if they were known.
        """
        normal, seen = given.normal, given.equations > 0
        rms = np.sqrt(normal.squares / np.maximum(normal.equations, 1))
        given = widened(given, np.where(seen, np.maximum(1.0, QUIETEST * rms / given.noise), 1.0))
        weights = _weights(given)
        moved = np.where(_of_dry_friction(given), 0.0, given.values if about is None else about)
        predicted = normal.matrices @ moved
        across = weights[:, None] * predicted
        alone = weights * (predicted @ moved) + width**-2.0
        side = weights * (normal.sides @ moved) - taken / width**2 - volume
        precision = given.precision - across.T @ (across / alone[:, None])
        precision = 0.5 * (precision + precision.T)
        right = given.precision @ given.values - across.T @ (side / alone)
        values = solved(precision, right, Spectrum.of(precision).inverse())
        freed = replace(given, values=values, precision=precision)
        if moving is None:
            turn = np.eye(values.size)
            return cls(taken, width, given, freed, -across / alone[:, None], side / alone, 1.0 / alone, turn)
        changes = weights[:, None, None] * moving
        of_gains = np.einsum("b,jbc->jc", moved, changes)  # (n, b): what E is for the equations of gains
        change, left = changes.sum(axis=0), changes.sum(axis=0) - across.T @ (of_gains / alone[:, None])
        step = np.linalg.solve(np.eye(values.size) + freed.covariance @ left, values - given.values)
        freed = replace(freed, values=given.values + step, precision=moved_precision(freed, left))
        loaded, side = replace(given, precision=moved_precision(given, change)), side + of_gains @ given.values
        turn, rate = np.eye(values.size) + given.covariance @ change, -(across + of_gains) / alone[:, None]
        return cls(taken, width, loaded, freed, rate, side / alone, 1.0 / alone, turn)

    def steps(self, base_values: Array) -> Array:
        """d (n,) at base values (b,): how much larger the logs of gains are than those taken."""
        d = self._start + self._rate @ base_values
        return np.asarray(-np.log1p(-np.clip(d, -_LARGEST_STEP, _LARGEST_STEP)))

    def covariance(self, of_base: Array) -> Array:
        """Covariance (n, n) of the logs of gains where the base parameters have theirs, (b, b)."""
        return np.asarray(np.diag(self._spread) + self._rate @ of_base @ self._rate.T)

    def gains(self, of_base: Array) -> DriveGains:
        """The gains taken, with errors where the base parameters have the covariance (b, b)."""
        alone = _of_mean(self.covariance(self.information.covariance))
        return DriveGains(self.width, np.exp(self.taken), self.covariance(of_base), alone)

    def with_errors_of(self, gains: DriveGains) -> Information:
        """Values at the gains taken; precision of base parameters with the errors that gains have in the end.

        Their covariance is C + J S J^T with J the change by gains, friction's too, whose covariance is S.
        """
        given = self.given
        across = _weights(given)[:, None] * (given.normal.matrices @ given.values) @ self._turn
        inner = np.linalg.inv(gains.covariance) + across @ given.covariance @ across.T
        precision = given.precision - across.T @ np.linalg.solve(inner, across)
        return replace(given, precision=0.5 * (precision + precision.T))

    def with_friction(self, parameters: Array, covariance: Array) -> Array:
        """Covariance (p, p) of parameters (p,) where that of friction has the errors of gains: f (1 - d) for f."""
        columns, rate = self.given.columns, self._rate @ self.given.base.grouping
        out, alone = np.eye(columns.count), np.zeros((columns.count, columns.n))
        for j in range(columns.n):
            part = columns.of_joint(j)
            own = np.setdiff1d(np.arange(part.start + 1, part.stop), load_indices(columns))
            out[own] -= parameters[own, None] * rate[j]
            alone[own, j] = parameters[own]
        return np.asarray(out @ covariance @ out.T + (alone * self._spread) @ alone.T)


def _weights(information: Information) -> Array:
    """One over the variance of each joint's torques, (n,); 0 without equations."""
    seen = information.equations > 0
    return np.where(seen, np.where(seen, information.noise, 1.0) ** -2.0, 0.0)


def _of_dry_friction(information: Information) -> NDArray[np.bool_]:
    """Which base parameters are friction that is no share of the load, (b,)."""
    columns = information.columns
    return np.isin(information.base.kept, np.setdiff1d(columns.friction_indices, load_indices(columns)))


def volume_of(given: Information, covariance: Array) -> Array:
    """How many parameters of bodies the equations of each joint say, (n,).

    The density of gains has all else summed over: it has det(sum_j W_j^T W_j / (s_j g_j)^2)^-1/2 as a factor, the room
    that a log leaves to base parameters, whose log rises by this number where the log of a gain falls by 1. Without it
    noise of the table shrinks the bodies to which it is a witness, as noise of a column would. Rotors, whose logarithm
    has a prior, and friction, of which the prior says no size, do not count.

    Parameters
    ----------
    given : Information
        With the gains as if they were known.
    covariance : (p, p) array
        Of all parameters by log and table, with known gains.
    """
    bodies, grouping = slice(0, given.columns.bodies), given.base.grouping
    across = grouping @ covariance[:, bodies] @ grouping[:, bodies].T
    return np.asarray(_weights(given) * np.einsum("jbc,cb->j", given.normal.matrices, across))


def gains_alone(normal: NormalEquations, columns: TorqueColumns, base: BaseParameters, width: float) -> Array:
    """Logs of gains (n,) by log and prior, without a table: a start, which need not have settled.

    Gauss and Newton's method: gains taken off the torques, base parameters and noise found again, in turn.
    """
    logs = np.zeros(columns.n)
    for _ in range(ROUNDS):
        freed = FreedGains.of(solve(normal.times(np.exp(-logs)), columns, base), logs, width)
        step = freed.steps(freed.information.values)
        logs = logs + step
        if np.abs(step).max() < SETTLED:
            break
    return logs


def _of_mean(covariance: Array) -> float:
    return float(np.sqrt(covariance.sum()) / len(covariance))
