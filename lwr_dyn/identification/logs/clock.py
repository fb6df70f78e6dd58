"""The clock of a log: how far its rows miss an even grid, and the log on an even one.

Rows miss it for two reasons. Either they were measured at those uneven times: then what was measured is interpolated.
Or they were measured evenly and stamped late, when they were written: then the times are wrong and an even clock is
right. The positions tell: on the right clock each is met by the cubic through its four neighbours.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.ndimage import median_filter

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LogError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.log_columns import GAP, JITTER, recordings

GAPS = 0.02
"""Share of the steps that may be gaps."""
EXPLAINED = 0.5
"""Share of what the jitter does to the positions (squared) that the better clock must explain."""
LEAST_ROWS = 8
_FIRST, _TRIED = 400, 4001
"""Rows that a clock starts from, and steps that are tried on them."""
_PHASE, _RATE = 0.05, 0.0006
"""Shares of a row's lateness that a clock takes over: it settles within some twenty rows, critically damped."""
_AGREE = 9
"""Rows of which most must agree that rows were lost before them."""
_NEIGHBOURS = (-2, -1, 1, 2)


@dataclass(frozen=True, slots=True, eq=False)
class Clock:
    """Times of a recording against an even grid.

    `step` [s] is that of the grid; `jitter` and `worst` [s] are how far times miss it, RMS and at most; `grid` (m,) [s]
    is the grid, `place` (k,) the index on it of each row; `even` says whether all steps are even to `JITTER`.
    """

    step: float
    jitter: float
    worst: float
    grid: Array
    place: NDArray[np.intp]
    even: bool

    @property
    def lost(self) -> int:
        """Rows of the grid that the recording lacks."""
        return int(self.grid.size - self.place.size)


def clock_of(t: Array) -> Clock:
    """The clock of times t (k,) [s] without gaps, k >= 2.

    >>> clock_of(np.array([0.0, 0.1, 0.2, 0.4, 0.5])).lost
    1
    """
    steps = np.diff(t)
    usual = float(np.median(steps))
    even = bool(np.all(np.abs(steps - usual) <= JITTER * usual))
    place = np.arange(t.size) if even else _places(t, usual)
    mean = place.mean()
    step = float((place - mean) @ (t - t.mean()) / ((place - mean) @ (place - mean)))
    grid = t.mean() + step * (np.arange(place[-1] + 1) - mean)
    off = t - grid[place]
    return Clock(step, float(np.sqrt(np.mean(off**2))), float(np.abs(off).max()), grid, place, even)


def _places(t: Array, usual: float) -> NDArray[np.intp]:
    """Index of each time on an even grid whose step is near the usual one: a clock that follows the times slowly.

    It starts with the step and phase in which the first times agree best, by their periodogram.
    """
    first = t[:_FIRST] - t[0]
    tried = usual * np.linspace(0.8, 1.2, _TRIED)
    turns = np.exp(2j * np.pi * first / tried[:, None]).mean(axis=1)
    best = int(np.argmax(np.abs(turns)))
    step = float(tried[best])
    clock, place, places = float(t[0] + np.angle(turns[best]) / (2 * np.pi) * step), 0, []
    for time in t.tolist():
        passed = round((time - clock) / step)
        late = time - (clock + passed * step)
        clock, place, step = time - (1.0 - _PHASE) * late, place + passed, step + _RATE * late
        places.append(place)
    rows = np.arange(t.size)
    lost = median_filter(np.array(places) - rows, _AGREE, mode="nearest")  # one row stamped late or early is none lost
    lost = np.maximum.accumulate(lost)
    return np.asarray(rows + lost - lost[0], dtype=np.intp)


def on_even_clock(log: JointLog) -> JointLog:
    """The log with evenly spaced rows in each of its recordings, and a note that says what was done.

    Positions are interpolated by cubic splines, torques, speeds and currents linearly; a log that is even comes back as
    it is.

    Raises
    ------
    LogError
        Times that do not rise; neither the times of the rows nor an even clock explains the positions, or the times
        jump all the time; with figures.
    """
    steps = np.diff(log.t)
    gaps = int(np.sum(steps > GAP * np.median(steps)))
    if gaps > GAPS * steps.size and np.median(steps) > 0.0:
        found = f"{gaps} of {steps.size} steps are gaps (median {np.median(steps):.3g} s, mean {steps.mean():.3g} s)"
        raise LogError(log.source, "column time", found, "times of measurement, not those of writing in blocks")
    still = np.flatnonzero(~(steps > 0.0))
    if still.size:
        row, several = int(still[0]) + 2, f" ({still.size} such rows)" if still.size > 1 else ""
        found = f"{log.t[row - 1]:.10g} s after {log.t[row - 2]:.10g} s{several}"
        raise LogError(log.source, f"row {row}, column time", found, "times that rise from row to row")
    notes, parts = [], []
    for rows in recordings(log.t):
        clock = clock_of(log.t[rows]) if rows.stop - rows.start >= LEAST_ROWS else None
        if clock is None or clock.even:
            parts.append(_columns(log, rows))
            continue
        stamped = _stamps_are_right(log, rows, clock)
        parts.append(_resampled(log, rows, clock, log.t[rows] if stamped else clock.grid[clock.place]))
        lost = f", {clock.lost} rows lost" if clock.lost else ""
        done = "interpolated on" if stamped else "measured evenly and stamped unevenly: put on"
        notes.append(
            f"{log.source}: rows {rows.start + 1} to {rows.stop} miss an even clock by {clock.jitter:.3g} s RMS, "
            f"{clock.worst:.3g} s at most{lost}; {done} a grid of {clock.step:.6g} s"
        )
    if not notes:
        return log
    fields: dict[str, Any] = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return replace(log, **fields, notes=(*log.notes, *notes))


def _columns(log: JointLog, rows: slice) -> dict[str, Array]:
    arrays = {name: getattr(log, name) for name in ("t", "q", "tau", "dq", "motor_q", "current")}
    return {name: array[rows] for name, array in arrays.items() if array is not None}


def _resampled(log: JointLog, rows: slice, clock: Clock, times: Array) -> dict[str, Array]:
    """The columns of a recording, measured at `times`, on its grid (inside of them)."""
    grid = clock.grid[(clock.grid >= times[0]) & (clock.grid <= times[-1])]
    out = {}
    for name, values in _columns(log, rows).items():
        if name == "t":
            out[name] = grid
        elif name in ("q", "motor_q"):
            known = not np.isnan(values).any()
            out[name] = CubicSpline(times, values)(grid) if known else np.full((grid.size, values.shape[1]), np.nan)
        else:  # NaN stays NaN, for both neighbours
            out[name] = np.column_stack([np.interp(grid, times, column) for column in values.T])
    return out


def _stamps_are_right(log: JointLog, rows: slice, clock: Clock) -> bool:
    """Whether the positions are smooth in the times of the rows, and not on the even clock."""
    t = log.t[rows]
    q = (log.q if not np.isnan(log.q).any() else log.motor_q if log.motor_q is not None else log.q)[rows]
    stamped, even = _roughness(t, q), _roughness(clock.grid[clock.place], q)
    shift = _roughness(t, q, clock.grid[clock.place])
    explained, error = abs(even[0] - stamped[0]), 4.0 * float(np.hypot(stamped[1], even[1]))
    if explained + error < EXPLAINED * shift[0]:
        left = float(np.sqrt(min(stamped[0], even[0])))
        found = (
            f"rows {rows.start + 1} to {rows.stop} miss an even clock by {clock.jitter:.3g} s RMS, {clock.worst:.3g} s "
            f"at most, and the positions are smooth on neither clock ({left:.3g} rad or m RMS are left)"
        )
        raise LogError(log.source, "column time", found, "times of measurement with less jitter")
    return stamped[0] <= even[0]


def _roughness(t: Array, q: Array, moved_to: Array | None = None) -> tuple[float, float]:
    """Mean square by which positions (k, n) at times (k,) miss the cubics of their neighbours, and its error.

    With `moved_to`, of the part that moving each row from t to those times makes, at the speed of its neighbours.
    """
    k = t.size
    inner = np.arange(2, k - 2)
    nodes = np.stack([t[inner + o] for o in _NEIGHBOURS])
    at = t[inner]
    guess = np.zeros((inner.size, q.shape[1]))
    for i, o in enumerate(_NEIGHBOURS):
        weight = np.ones(inner.size)
        for j in range(len(_NEIGHBOURS)):
            if j != i:
                weight *= (at - nodes[j]) / (nodes[i] - nodes[j])
        guess += weight[:, None] * q[inner + o]
    squares = ((q[inner] - guess) ** 2).sum(axis=1)
    if moved_to is not None:
        speed = (q[inner + 2] - q[inner - 2]) / (nodes[3] - nodes[0])[:, None]
        squares = ((speed * (t - moved_to)[inner, None]) ** 2).sum(axis=1)
    return float(squares.mean()), float(squares.std() / np.sqrt(squares.size))
