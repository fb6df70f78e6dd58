"""Which parameters logs identify, which of them only together, and why the others not."""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.regression.least_squares import (
    IDENTIFIED,
    NO_ERROR,
    NOT_EXCITED,
    SIGMAS,
    ZERO,
    student_factor,
)

NOT_DETERMINED = "not determined"
"""The motion does not show the parameter at all."""
TOGETHER = 0.9
"""Correlation from which two parameters count as known only together."""
FROM_LOG, FROM_BOTH, FROM_TABLE = "log", "log and table", "table"
"""Where a parameter of a body comes from: its standard error is below a third of what the table alone gives, below nine
tenths, or is not."""
MOSTLY_LOG, MOSTLY_TABLE = 1.0 / 3.0, 0.9


def half_widths(information: Information) -> Array:
    """Of the 3-sigma intervals (b,), with Student's t; infinite where not determined."""
    return np.asarray(information.sigma * student_factor(information.dof))


def parameter_states(information: Information, own: Array) -> tuple[str, ...]:
    """Of each base parameter, beside the arm's own values (b,): identified, or why not."""
    half, values = half_widths(information), information.values
    rows = [
        ~information.determined, np.isnan(half), np.abs(values) > half, (own != 0.0) & (np.abs(own) <= half),
    ]  # fmt: skip
    return tuple(np.select(rows, [NOT_DETERMINED, NO_ERROR, IDENTIFIED, NOT_EXCITED], ZERO).tolist())


MEANING = {
    IDENTIFIED: f"|value| above {SIGMAS:g} sigma (Student's t of 99.73 %)",
    NOT_EXCITED: f"nor is the model's own value above {SIGMAS:g} sigma: this motion cannot separate it from 0",
    ZERO: f"within {SIGMAS:g} sigma of 0, and the model's own value is not, or is 0",
    NOT_DETERMINED: "this motion does not show it at all",
    NO_ERROR: "as many equations as parameters",
}
"""What the states of a parameter mean."""


@dataclass(frozen=True, slots=True)
class CorrelatedGroup:
    """Base parameters, by index, that logs know only together: each has a correlation above `TOGETHER` with another."""

    members: tuple[int, ...]
    largest: float
    """Correlation of the closest pair, signed."""


def correlated_groups(information: Information, limit: float = TOGETHER) -> tuple[CorrelatedGroup, ...]:
    """Groups of two and more of the determined base parameters, the closest first."""
    chosen = np.flatnonzero(information.determined & np.isfinite(information.sigma))
    if not chosen.size:
        return ()
    covariance = information.covariance[np.ix_(chosen, chosen)]
    sigma = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(sigma, sigma)
    np.fill_diagonal(correlation, 0.0)
    near = np.abs(correlation) > limit
    left, out = set(np.flatnonzero(near.any(axis=1)).tolist()), []
    while left:
        group, border = set(), {min(left)}
        while border:
            group |= border
            border = {int(i) for j in border for i in np.flatnonzero(near[j])} - group
        left -= group
        rows = sorted(group)
        block = correlation[np.ix_(rows, rows)]
        largest = float(block.flat[int(np.argmax(np.abs(block)))])
        out.append(CorrelatedGroup(tuple(int(chosen[i]) for i in rows), largest))
    return tuple(sorted(out, key=lambda group: -abs(group.largest)))


def cell_origins(sigma: Array, table_sigma: Array) -> tuple[str, ...]:
    """Where parameters (p,) come from: their standard errors with the log against those of the table alone."""
    share = np.divide(sigma, table_sigma, out=np.ones_like(sigma), where=table_sigma > 0.0)
    return tuple(np.select([share < MOSTLY_LOG, share < MOSTLY_TABLE], [FROM_LOG, FROM_BOTH], FROM_TABLE).tolist())
