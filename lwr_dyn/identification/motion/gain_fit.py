"""Gains of the torques and bodies near a table, found in turn from the same logs, and what is said of both.

Bodies near the table move the factor that gains and bodies share (`regression.drive_gains`), which no torque shows; the
gains that go with them are taken off the torques, and bodies found again, until neither moves. Friction that grows with
the load is found again with them, for what bodies ask is a torque over its gain.

Scales of the table, and how long noise lasts, are chosen among some: two choices that are as good as each other leave
steps that do not end. The round whose step is least is taken then, and its step is said.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.document import Fact, Note
from lwr_dyn.foundation.errors import LogError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.bodies.consistent import ConsistentFit, Price
from lwr_dyn.identification.motion.validation import Folds
from lwr_dyn.identification.regression.drive_gains import DriveGains, FreedGains, gains_alone, volume_of
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.regression.load_friction import loads_moved, with_load_friction

NearTheTable = Callable[[Information, ConsistentFit | None], ConsistentFit]
"""Bodies by what logs say of the base parameters, with the scales of another fit if one is given."""
ROUNDS, SETTLED = 6, 0.02
"""Of bodies and gains in turn, at most; the change of gains that ends them, as a share of their standard errors."""
MOST = 0.5
"""Standard errors by which a gain may still move where no round settled."""


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

    Raises
    ------
    LogError
        No round after which gains move by less than `MOST`; friction with the load that does not settle.
    """
    logs = gains_alone(folds.information().normal, folds.columns, folds.base, width)
    best: GainFit | None = None
    for _ in range(ROUNDS):
        there = _at_torques_over(folds, np.exp(logs))
        found, step = _round(there, said(there), logs, width, near_the_table)
        if best is None or found.gains.moving < best.gains.moving:
            best = found
        if found.gains.moving < SETTLED:
            return found
        logs = logs + step
    assert best is not None
    if best.gains.moving > MOST:
        source = ", ".join(dict.fromkeys(folds.samples.sources))
        moves = f"move by {best.gains.moving:.2g} sigma after {ROUNDS} rounds with the bodies"
        needed = "a longer motion, torques with a sensor's noise, or a smaller --gains"
        raise LogError(source, "gains of the torques", moves, needed)
    return best


def _at_torques_over(folds: Folds, gains: Array) -> Folds:
    there = folds.times(1.0 / gains)
    if there.columns.carried is None:
        return there
    return there.with_columns(with_load_friction(there.samples, there.columns))


def _round(
    folds: Folds, given: Information, logs: Array, width: float, near_the_table: NearTheTable | None
) -> tuple[GainFit, Array]:
    """Bodies at gains exp(logs), and by how much the logs (n,) of the gains that go with them are larger."""
    loads = None if folds.columns.carried is None else loads_moved(folds.samples, given, given.values)
    freed, fit, base = FreedGains.of(given, logs, width, moving=loads), None, folds.base
    values, covariance = freed.information.values, freed.information.covariance
    if near_the_table is not None:
        alone = freed
        sure = near_the_table(alone.given, near_the_table(alone.information, None))
        about, volume = base.of(sure.parameters), volume_of(alone.given, sure.covariance)
        freed = FreedGains.of(given, logs, width, about, volume, loads)
        fit = near_the_table(freed.information, None)
        fit = replace(fit, price=Price.of(alone.information, fit.parameters))  # against log and prior alone
        values, covariance = base.of(fit.parameters), base.grouping @ fit.covariance @ base.grouping.T
        fit = _in_true_torques(fit, freed)
    gains, step = freed.gains(covariance), freed.steps(values)
    gains = replace(gains, moving=float((np.abs(step) * gains.values / gains.sigma).max()))
    return GainFit(gains, folds, freed.with_errors_of(gains), fit), step


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
        Fact("moving", gains.moving, "By how many of its standard errors a gain would move at most in another round of "
             "gains and bodies in turn."),
        Note(words),
        Note(f"gains and bodies, found in turn, did not settle: another round would move a gain by {gains.moving:.2g} "
             "of its plus-minus", gains.moving > SETTLED),
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
