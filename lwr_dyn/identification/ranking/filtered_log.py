"""A log as all sets are scored on it: positions and torques through one filter, on even rows.

    q, tau through a Butterworth filter of order 4 without phase; dq, ddq by differences of the filtered q; `EDGE` cut
    off at both ends; a row each `spacing`

The filter matters more than any set (the floor of one log is 0.11 N m at 5 Hz and 0.59 at 20): compare inside one only.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite

import numpy as np
from scipy.signal import butter, sosfiltfilt

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.log_columns import recordings

ORDER = 4
EDGE = 0.5
"""[s] cut off at both ends of a recording, where the filter lacks rows."""
LEAST_ROWS = 40
"""Of a recording after that: fewer say nothing of the friction."""
EVEN = 0.01
"""Share of a step that times may miss an even clock by, as rounded ones do."""
NYQUIST = 0.99
"""Largest cut-off as a share of half the rate."""


@dataclass(frozen=True, slots=True)
class FilterRule:
    """The one filter of a ranking.

    Parameters
    ----------
    cutoff : float
        [Hz]
    spacing : float
        [s] between two rows.
    share : float
        Of the rows that train, from the start, where no other log tests.

    Raises
    ------
    OptionError
        A cutoff or spacing that is not above 0, a share outside 0.1 to 0.9.
    """

    cutoff: float = 10.0
    spacing: float = 0.01
    share: float = 0.6

    def __post_init__(self) -> None:
        for name in ("cutoff", "spacing"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0.0):
                raise OptionError(f"filter {name}", value, "a number above 0")
        if not 0.1 <= self.share <= 0.9:
            raise OptionError("filter share", self.share, "0.1 to 0.9")


@dataclass(frozen=True, slots=True, eq=False)
class FilteredLog:
    """Rows: t (k,) [s]; q, dq, ddq, tau (k, n), filtered [rad, rad/s, rad/s^2, N m; m, N of sliding joints]."""

    t: Array
    q: Array
    dq: Array
    ddq: Array
    tau: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "t", "q", "dq", "ddq", "tau")

    def __len__(self) -> int:
        return len(self.t)

    def rows(self, which: slice) -> "FilteredLog":
        """Some of the rows."""
        return FilteredLog(*(x[which] for x in (self.t, self.q, self.dq, self.ddq, self.tau)))


def filtered_log(log: JointLog, rule: FilterRule) -> FilteredLog:
    """The rows of a log.

    Raises
    ------
    LogError
        Torques that are not finite numbers, or no recording that is long enough.
    """
    if not np.isfinite(log.tau).all():
        raise LogError(log.source, "columns tau", "torques that are not finite numbers", "a log with all torques")
    parts = [part for part in _parts(log, rule) if len(part[0]) >= LEAST_ROWS]
    if not parts:
        needed = f"a recording with {LEAST_ROWS} rows after {EDGE:g} s are cut off at both ends"
        raise LogError(log.source, "rows", f"{log.t.size}, the last at {log.t[-1] - log.t[0]:.3g} s", needed)
    return FilteredLog(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _parts(log: JointLog, rule: FilterRule) -> Iterator[tuple[Array, ...]]:
    for piece in recordings(log.t):
        t = log.t[piece]
        if t.size < LEAST_ROWS:
            continue
        step = float(np.median(np.diff(t)))
        mean = float(t[-1] - t[0]) / (t.size - 1)
        even = bool(np.abs(t - t[0] - mean * np.arange(t.size)).max() <= EVEN * mean)
        step, grid = (mean, t) if even else (step, np.arange(t[0], t[-1], step))
        sos = butter(ORDER, min(rule.cutoff * 2.0 * step, NYQUIST), output="sos")
        q, tau = (
            sosfiltfilt(sos, np.column_stack([x if even else np.interp(grid, t, x) for x in of[piece].T]), axis=0)
            for of in (log.q, log.tau)
        )
        dq = np.gradient(q, step, axis=0)
        ddq = np.gradient(dq, step, axis=0)
        cut = round(EDGE / step)
        rows = slice(cut, grid.size - cut, max(1, round(rule.spacing / step)))
        yield tuple(x[rows] for x in (grid, q, dq, ddq, tau))


def trained_and_tested(whole: FilteredLog, share: float) -> tuple[FilteredLog, FilteredLog]:
    """The first `share` of the rows, and the rest."""
    count = int(len(whole) * share)
    return whole.rows(slice(0, count)), whole.rows(slice(count, None))
