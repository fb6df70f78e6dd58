"""Instants of logs as the regression takes them: states from positions alone, torques as they were measured.

    q  through a Butterworth filter of order 4 without phase, dq and ddq by central differences; torques untouched;
    every so many rows; no equation of a joint that is slow, where friction is not what the columns say

Where a log has speeds of its own they may stand in for the differences: through the same filter, ddq by theirs.

References
----------
Gautier, Janot, Vandanjon, A new closed-loop output error method for parameter identification of robot dynamics (2013),
section III, for the filter on positions.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import ceil, isfinite

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.logs.clock import on_even_clock
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.log_columns import even_step, recordings
from lwr_dyn.model.transmission import Transmission

ORDER = 4
"""Of the Butterworth filter, forward and backward."""
NYQUIST = 0.8
"""Largest cut-off, as a share of half the rate."""
EDGE = 4.0
"""Periods of the cut-off that are left out at both ends of a recording, where the filter lacks rows."""
MEMORY = 16.0
"""Periods of the cut-off after which the filter has forgotten a row (to 1e-16)."""
PART = 20_000
"""Rows of a log at once."""
_STATES = ("t", "q", "dq", "ddq", "tau")
HALF = 2
"""Rows on each side in a central difference (error of order 4 in the step)."""
REACH = 1.0
"""Periods of the cut-off beside a reversal in which a joint has no equation: there the filtered speed may have the
wrong sign (0.8 of one on simulated logs, longest where the joint stuck), and friction would be that of the other
direction."""


@dataclass(frozen=True, slots=True, eq=False)
class SampleRule:
    """How instants are taken from logs.

    Parameters
    ----------
    cutoff : float or None
        Of the filter on positions [Hz], lowered to `NYQUIST` of half a log's rate; None for no filter. 5 to 40 Hz
        showed no bias on 1 kHz logs with 1e-5 rad of encoder noise; 2 and 80 Hz did.
    spacing : float
        Least time between two instants [s]: errors of filtered positions are not shared.
    slowest : float or (n,) array
        Speed up to which a joint's equation is left out [rad/s or m/s]; three times the Stribeck speed where the
        columns have no Stribeck term.
    transmission : Transmission, optional
        The motor map dq_m = T dq of columns with friction at the motors: `slowest` is then a speed of motors, and a
        joint's equation needs all motors that drive it to be faster.

    link_side : bool
        Whether torques are those of sensors behind the gears: columns that follow this rule have no rotors.
    own_speeds : bool
        Whether dq is the log's own where it has one, and ddq comes from it.
    reach : float
        Periods of the cut-off beside a reversal of a joint in which it has no equation; 0 for none left out.

    Raises
    ------
    OptionError
        A number that is not above 0 (for `slowest` and `reach` below 0).
    """

    cutoff: float | None = 20.0
    spacing: float = 0.01
    slowest: float | Array = 0.05
    transmission: Transmission | None = None
    reach: float = REACH
    own_speeds: bool = False
    link_side: bool = False

    def __post_init__(self) -> None:
        if self.cutoff is not None and not (isfinite(self.cutoff) and self.cutoff > 0.0):
            raise OptionError("sample cutoff", self.cutoff, "a frequency above 0, or none")
        if not (isfinite(self.spacing) and self.spacing > 0.0):
            raise OptionError("sample spacing", self.spacing, "a number above 0")
        if not (isfinite(self.reach) and self.reach >= 0.0):
            raise OptionError("sample reach", self.reach, "a number >= 0")
        slowest = np.asarray(self.slowest, dtype=np.float64)
        if not (np.isfinite(slowest).all() and (slowest >= 0.0).all()):
            raise OptionError("sample slowest", self.slowest, "a number >= 0, or one for each joint")

    def taking_all(self) -> "SampleRule":
        """The same instants, with every torque that was measured."""
        return replace(self, slowest=0.0, reach=0.0, transmission=None)

    def moving(self, dq: Array) -> NDArray[np.bool_]:
        """Which equations count at speeds (k, n), (k, n)."""
        return self._unless(np.abs(self._speeds(dq)) <= self.slowest)

    def clear_of_reversals(self, q: Array, rows: NDArray[np.intp], reach: int) -> NDArray[np.bool_]:
        """Which equations at some rows of positions (k, n) are more than `reach` rows from a reversal, (rows, n)."""
        forward = self._speeds(np.diff(q, axis=0)) > 0.0
        turns = np.zeros((len(q), forward.shape[1]), dtype=np.intp)
        np.cumsum(forward[1:] != forward[:-1], axis=0, out=turns[1:-1])
        turns[-1] = turns[-2]
        before, after = np.maximum(rows - reach - 1, 0), np.minimum(rows + reach, len(q) - 1)
        return self._unless(turns[after] > turns[before])

    def _speeds(self, dq: Array) -> Array:
        return dq if self.transmission is None else np.asarray(dq @ self.transmission.matrix.T)

    def _unless(self, left_out: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Equations of joints none of whose motors (each joint its own without a transmission) is left out."""
        if self.transmission is None:
            return ~left_out
        return np.asarray(~(left_out @ (self.transmission.matrix != 0.0)))


DEFAULT_SAMPLES = SampleRule()


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Instants: t (k,) [s]; q, dq, ddq, tau (k, n); which equations count, `used` (k, n); whose they are.

    `recording` (k,) numbers the recordings (a log with gaps has several) from 0, `sources` names them.
    """

    t: Array
    q: Array
    dq: Array
    ddq: Array
    tau: Array
    used: NDArray[np.bool_]
    recording: NDArray[np.intp]
    sources: tuple[str, ...]

    def __post_init__(self) -> None:
        for name in ("t", "q", "dq", "ddq", "tau", "used", "recording"):
            view = np.asarray(getattr(self, name)).view()  # they may be large: nothing is copied
            view.flags.writeable = False
            object.__setattr__(self, name, view)

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.q.shape[1])

    def __len__(self) -> int:
        return len(self.t)

    @property
    def equations(self) -> int:
        """How many are used."""
        return int(np.count_nonzero(self.used))

    def times(self, factors: Array) -> "Samples":
        """The same with the torques of each joint multiplied by a factor, (n,)."""
        return replace(self, tau=self.tau * factors)

    def rows_in(self, seconds: float) -> int:
        """How many instants are as far apart, at least 1."""
        return max(1, round(seconds / float(np.median(np.diff(self.t)))))

    def select(self, rows: NDArray[np.bool_] | NDArray[np.intp] | slice) -> "Samples":
        """The instants at some rows; recordings keep their numbers."""
        t, q, dq, ddq, tau = (x[rows] for x in (self.t, self.q, self.dq, self.ddq, self.tau))
        return Samples(t, q, dq, ddq, tau, self.used[rows], self.recording[rows], self.sources)


def samples_of(logs: Iterable[JointLog], rule: SampleRule = DEFAULT_SAMPLES) -> Samples:
    """Instants of recordings of any motion.

    Parameters
    ----------
    logs : iterable of JointLog
        Uneven rows are brought to an even clock (`on_even_clock`), as commands do. A torque of NaN (cut out) is an
        equation that is not used.

    Raises
    ------
    LogError
        Rows that no even clock fits, or no recording long enough for the filter.
    """
    parts = list(sample_parts(logs, rule))
    t, q, dq, ddq, tau = (np.concatenate([getattr(part, name) for part in parts]) for name in _STATES)
    used, recording = np.concatenate([p.used for p in parts]), np.concatenate([p.recording for p in parts])
    return Samples(t, q, dq, ddq, tau, used, recording, parts[-1].sources)


def sample_parts(logs: Iterable[JointLog], rule: SampleRule = DEFAULT_SAMPLES) -> Iterator[Samples]:
    """The same a part at a time, so that a long log needs little memory; a part knows the sources up to its own."""
    sources: tuple[str, ...] = ()
    short = ("logs", 0)
    for log in map(on_even_clock, logs):
        for piece in recordings(log.t):
            count = len(sources)
            for t, q, dq, ddq, tau, clear in _piece(log, piece, rule):
                sources = (*sources[:count], log.source)
                known = np.isfinite(tau)
                used = rule.moving(dq) & known & clear
                whose = np.full(t.size, count, dtype=np.intp)
                yield Samples(t, q, dq, ddq, np.where(known, tau, 0.0), used, whose, sources)
            short = (log.source, piece.stop - piece.start)
    if not sources:
        raise LogError(short[0], "rows", f"{short[1]} between gaps in time", "recordings longer than the filter")


def _piece(
    log: JointLog, piece: slice, rule: SampleRule
) -> Iterator[tuple[Array, Array, Array, Array, Array, NDArray[np.bool_]]]:
    t, positions = log.t[piece], log.q[piece]
    if t.size < 2 * HALF + 1:
        return
    step = even_step(log.source, t, piece.start)
    edge, memory, reach, sos = HALF, 0, 0, None
    if rule.cutoff is not None:
        cutoff = min(rule.cutoff, NYQUIST * 0.5 / step)
        sos = butter(ORDER, cutoff * 2 * step, output="sos")
        period = 1.0 / (cutoff * step)  # in rows
        edge, memory, reach = HALF + ceil(EDGE * period), ceil(MEMORY * period), ceil(rule.reach * period)
    rows = np.arange(edge, t.size - edge, max(1, round(rule.spacing / step)))
    for part in np.array_split(rows, -(-(t.size) // PART)) if rows.size else ():
        first, last = max(0, part[0] - HALF - memory), min(t.size, part[-1] + HALF + memory + 1)
        q, speeds = positions[first:last], None
        if rule.own_speeds and log.dq is not None:
            speeds = log.dq[piece][first:last]
        if sos is not None:
            q = sosfiltfilt(sos, q, axis=0, padlen=min(edge, len(q) - 1))
            speeds = None if speeds is None else sosfiltfilt(sos, speeds, axis=0, padlen=min(edge, len(q) - 1))
        a, b, c, d, e = (q[part - first + i] for i in range(-HALF, HALF + 1))
        dq = (a - 8 * b + 8 * d - e) / (12 * step)
        ddq = (-a + 16 * b - 30 * c + 16 * d - e) / (12 * step**2)
        if speeds is not None:
            a, b, dq, d, e = (speeds[part - first + i] for i in range(-HALF, HALF + 1))
            ddq = (a - 8 * b + 8 * d - e) / (12 * step)
        clear = rule.clear_of_reversals(q, part - first, reach) if reach else np.ones(c.shape, dtype=np.bool_)
        yield t[part], c, dq, ddq, log.tau[piece][part], clear


def exact_samples(t: Array, q: Array, dq: Array, ddq: Array, tau: Array, slowest: float = 0.0) -> Samples:
    """Instants of one motion that is known, such as a simulated one."""
    whole = np.zeros(len(t), dtype=np.intp)
    return Samples(t, q, dq, ddq, tau, np.abs(dq) > slowest, whole, ("",))


_FEW = 3
"""Gaps that are named."""


def sample_notes(logs: Iterable[JointLog], rule: SampleRule) -> tuple[str, ...]:
    """A line for every log with gaps in time, and one for every log that is too slow for the filter."""
    notes = []
    for log in logs:
        starts = [piece.start for piece in recordings(log.t)][1:]
        if starts:
            gaps = [f"{log.t[i] - log.t[i - 1]:.4g} s at {log.t[i - 1]:.6g} s" for i in starts[:_FEW]]
            more = f" and {len(starts) - _FEW} more" if len(starts) > _FEW else ""
            notes.append(f"{log.source}: {len(starts) + 1} recordings, split at gaps of {', '.join(gaps)}{more}")
        if rule.cutoff is not None and log.t.size > 1:
            rate = 1.0 / float(np.median(np.diff(log.t)))
            if rule.cutoff > NYQUIST * 0.5 * rate:
                notes.append(
                    f"{log.source}: filtered at {NYQUIST * 0.5 * rate:.4g} Hz in place of {rule.cutoff:g} Hz, "
                    f"which is too near to half of its rate of {rate:.4g} Hz"
                )
    return tuple(notes)
