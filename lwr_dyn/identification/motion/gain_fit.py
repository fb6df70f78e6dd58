"""Gains of the torques and bodies near a table, found in turn from the same logs, and what is said of both.

Bodies near the table move the factor that gains and bodies share (`regression.drive_gains`), which no torque shows; the
gains that go with them are taken off the torques, and bodies found again, until neither moves.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.foundation.document import Fact, Note
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.bodies.consistent import ConsistentFit, Price
from lwr_dyn.identification.motion.validation import Folds
from lwr_dyn.identification.regression.drive_gains import DriveGains, FreedGains, gains_alone, volume_of
from lwr_dyn.identification.regression.information import Information

NearTheTable = Callable[[Information, ConsistentFit | None], ConsistentFit]
"""Bodies by what logs say of the base parameters, with the scales of another fit if one is given."""
ROUNDS, SETTLED = 6, 0.02
"""Of bodies and gains in turn, at most; the change of gains that ends them, as a share of their standard errors."""


@dataclass(frozen=True, slots=True, eq=False)
class GainFit:
    """`folds` of the torques over the `gains`; what they say (`information`, with the gains' errors), and `bodies`."""

    gains: DriveGains
    folds: Folds
    information: Information
    bodies: ConsistentFit | None


def fit_gains(
    folds: Folds, width: float, said: Callable[[Folds], Information], near_the_table: NearTheTable | None
) -> GainFit:
    """Gains and bodies of logs in turn.

    Parameters
    ----------
    folds : Folds
        Of the torques as logged.
    width : float
        Standard deviation of the logs of the gains before the logs.
    said : callable
        What folds say together where the gains are known.
    near_the_table : callable or None
        Bodies by that; None for an arm without masses, whose gains are those of log and prior.
    """
    logs, base = gains_alone(folds.information().normal, folds.columns, folds.base, width), folds.base
    for _ in range(ROUNDS):
        there = folds.times(np.exp(-logs))
        alone = FreedGains.of(said(there), logs, width)
        if near_the_table is None:
            gains = alone.gains(alone.information.covariance)
            return GainFit(gains, there, alone.with_errors_of(gains), None)
        freed, fit = _with_bodies(alone, near_the_table)
        gains = freed.gains(base.grouping @ fit.covariance @ base.grouping.T)
        step = freed.steps(base.of(fit.parameters))
        if (np.abs(step) < SETTLED * gains.sigma / gains.values).all():
            break
        logs = logs + step
    return GainFit(gains, there, freed.with_errors_of(gains), _in_true_torques(fit, freed))


def _with_bodies(alone: FreedGains, near_the_table: NearTheTable) -> tuple[FreedGains, ConsistentFit]:
    """Gains about bodies near the table, and bodies with these gains; their price is against log and prior alone."""
    sure = near_the_table(alone.given, near_the_table(alone.information, None))
    about, volume = alone.given.base.of(sure.parameters), volume_of(alone.given, sure.covariance)
    freed = FreedGains.of(alone.given, alone.taken, alone.width, about, volume)
    fit = near_the_table(freed.information, None)
    return freed, replace(fit, price=Price.of(alone.information, fit.parameters))


def _in_true_torques(fit: ConsistentFit, freed: FreedGains) -> ConsistentFit:
    """The fit with errors of friction that have those of the gains."""
    at, covariance = freed.given.columns.friction_indices, freed.with_friction(fit.parameters, fit.covariance)
    sigma = fit.sigma.copy()
    sigma[at] = np.sqrt(np.diag(covariance)[at])
    return replace(fit, covariance=covariance, sigma=sigma)


def gain_parts(gains: DriveGains | None, fit: ConsistentFit | None) -> list[Fact | Note | Table]:
    """The gains for people and programs, the total mass, and what fixes the factor that both share."""
    if gains is None:
        return []
    columns = (
        Heading("joint", key="joint", kind=int),
        Heading("torque of the log over the true one", format=".4g", key="gain", sigma="standard_error"),
        Heading(key="standard_error"),
    )
    rows = [(j + 1, g, s) for j, (g, s) in enumerate(zip(gains.values, gains.sigma, strict=True))]
    mass, error = (None, None) if fit is None else fit.total_mass
    words = _fixed_by(gains, fit)
    return [
        Table(f"gains of the torques, known to {_percent(gains.width)} before the log", columns, rows, key="joints",
              says="Of each joint's torques; all other numbers are of torques over them."),
        Fact("common_error", gains.common, "Standard error, as a share, of the factor that gains and bodies have in "
             "common, which no torque shows.", "factor common to gains and bodies known to", "", _percent),
        Fact("total_mass", mass, "Of the bodies near the table [kg].", "total mass", "kg",
             lambda x: f"{x:.4g} +- {error:.2g}", kind=float | None),
        Fact("total_mass_error", error, "Its standard error.", kind=float | None),
        Fact("fixed_by", words, "What fixes the common factor."),
        Note(words),
    ]  # fmt: skip


def _fixed_by(gains: DriveGains, fit: ConsistentFit | None) -> str:
    known, alone = _percent(gains.width), _percent(gains.without_table)
    alone = f"that gains are right to {known} each (alone: the factor to {alone})"
    unseen = "larger gains with lighter bodies give the same torques; what tells them apart is "
    if fit is None:
        return f"{unseen}{alone}"
    if fit.constraints:
        return f"{unseen}{alone}, the masses of the table, and what is known: {'; '.join(fit.constraints)}"
    return f"{unseen}{alone}, and the masses of the table; a weight from scales would say it (--known)"


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"
