"""Cruises: the stretches of a recording in which a joint moves at constant speed, by its positions alone."""

from dataclasses import dataclass
from math import isfinite, sqrt

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.logs.recordings import recordings

SIGMAS = 5.0
"""Standard deviations of the position noise by which a speed may wander and count as constant."""
LEAST_ROWS = 5


@dataclass(frozen=True, slots=True)
class CruiseRule:
    """What counts as a cruise.

    Parameters
    ----------
    shortest : float
        Least duration [s].
    window : float
        Span over which a speed is taken [s]; a change of speed is one between two neighbouring spans.
    tolerance : float
        Share of its speed by which a cruise may wander.
    slowest : float
        Least speed that is a motion [rad/s or m/s].

    Raises
    ------
    OptionError
        A number that is not above 0.
    """

    shortest: float = 0.5
    window: float = 0.2
    tolerance: float = 0.03
    slowest: float = 1e-3

    def __post_init__(self) -> None:
        for name in ("shortest", "window", "tolerance", "slowest"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0.0):
                raise OptionError(f"cruise {name}", value, "a number above 0")


DEFAULT_CRUISE = CruiseRule()


@dataclass(frozen=True, slots=True)
class Cruise:
    """Rows `first` to `last` (from 0, both inside) in which a joint moves at constant speed, and for how long [s]."""

    first: int
    last: int
    duration: float


def find_cruises(t: Array, q: Array, rule: CruiseRule = DEFAULT_CRUISE) -> tuple[Cruise, ...]:
    """Every constant-speed stretch of one joint, t and q (k,), the short ones too: see `CruiseRule.shortest`.

    The speed of a row is the slope between the rows half a window before and after it. It is steady where neighbouring
    slopes differ by at most the tolerance (or by what the position noise explains); a steady stretch is then cut to the
    longest part that stays within the tolerance of its own median.

    >>> t = np.arange(300) / 100
    >>> [(c.first, c.last) for c in find_cruises(t, 0.2 * np.clip(t, 0.5, 2.5))]
    [(67, 233)]
    """
    cruises: list[Cruise] = []
    for piece in recordings(t):
        cruises += _in_piece(t[piece], q[piece], piece.start, rule)
    return tuple(cruises)


def position_noise(q: Array) -> float:
    """Standard deviation of the noise in positions (k,) [rad or m], rounding to counts included.

    Third differences are free of any motion of constant acceleration; white noise enters them 20-fold in variance.
    A joint that stands still shows no rounding, so a count over sqrt(12) is the least.
    """
    third = np.abs(np.diff(q, 3))
    moves = np.abs(np.diff(q))
    moves = moves[moves > 0.0]
    if not (third.size and moves.size):
        return 0.0
    return max(1.4826 * float(np.median(third)) / sqrt(20.0), float(moves.min()) / sqrt(12.0))


def _in_piece(t: Array, q: Array, start: int, rule: CruiseRule) -> list[Cruise]:
    if t.size < LEAST_ROWS:
        return []
    step = float(np.median(np.diff(t)))
    h = max(1, round(rule.window / (2 * step)))
    if t.size < 4 * h + LEAST_ROWS:
        return []
    speed = (q[2 * h :] - q[: -2 * h]) / (t[2 * h :] - t[: -2 * h])  # of rows h .. k-h-1
    noise = SIGMAS * sqrt(2.0) * position_noise(q) / (2 * h * step)
    inner = speed[h:-h]  # of rows 2h .. k-2h-1
    change = np.abs(speed[2 * h :] - speed[: -2 * h])
    moving = np.abs(inner) > np.maximum(rule.slowest, 2 * noise)
    steady = moving & (change <= rule.tolerance * np.abs(inner) + sqrt(2.0) * noise)
    cruises = []
    for first, last in _stretches(steady, LEAST_ROWS):
        part = inner[first : last + 1]
        middle = float(np.median(part))
        near = np.abs(part - middle) <= rule.tolerance * abs(middle) + noise
        inside = _stretches(near, LEAST_ROWS)
        if inside:
            a, b = max(inside, key=lambda span: span[1] - span[0])
            i, j = first + a + 2 * h, first + b + 2 * h
            cruises.append(Cruise(start + i, start + j, float(t[j] - t[i])))
    return cruises


def _stretches(mask: NDArray[np.bool_], least: int) -> list[tuple[int, int]]:
    """First and last index of every run of at least `least` true values."""
    edges = np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8))
    first, last = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    long = last - first + 1 >= least
    return list(zip(first[long].tolist(), last[long].tolist(), strict=True))
