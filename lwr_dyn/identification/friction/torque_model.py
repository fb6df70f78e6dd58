"""The part of measured torques that an arm's model explains: gravity, inertia (B ddq + C dq), or both, row by row."""

from dataclasses import replace
from typing import Literal, get_args

import numpy as np
from scipy.signal import savgol_filter

from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.recordings import even_step, recordings
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.vectors import ZERO

Subtract = Literal["none", "gravity", "inertia", "all"]
SUBTRACT = get_args(Subtract)
CHUNK = 20_000
"""Rows the recursion takes at once, so that its intermediate values stay in the cache."""
DEGREE = 3
"""Of the local polynomials: their slope is exact where the acceleration changes linearly."""


class ModelTorque:
    """The torques of an arm's model along a log, by the recursion on its own frames in batches."""

    __slots__ = ("_recursion", "_weightless", "arm", "subtract", "window")

    def __init__(self, arm: Arm, subtract: Subtract = "gravity", window: float = 0.08) -> None:
        """Raises `OptionError` for another word than `SUBTRACT`, `MissingDataError` for an arm without inertias."""
        if subtract not in SUBTRACT:
            raise OptionError("subtract", repr(subtract), ", ".join(SUBTRACT))
        self.arm, self.subtract, self.window = arm, subtract, window
        self._recursion = Recursion.of(arm.require_dynamics())
        self._weightless = replace(self._recursion, gravity=ZERO)

    def gravity(self, log: JointLog) -> Array:
        """g(q) of every row, (k, n) [N m or N]."""
        parts = [self._recursion.gravity_vector(q) for q in _chunks(log.q)]
        return np.concatenate(parts)

    def inertia(self, log: JointLog) -> Array:
        """B ddq + C dq of every row, (k, n) [N m or N], from positions alone; raises `LogError` for uneven rows."""
        out = np.empty_like(log.q)
        for piece in recordings(log.t):
            dq, ddq = local_derivatives(log, piece, self.window)
            q = log.q[piece]
            rows = zip(_chunks(q), _chunks(dq), _chunks(ddq), strict=True)
            out[piece] = np.concatenate([self._weightless.inverse_dynamics(*row) for row in rows])
        return out


def local_derivatives(log: JointLog, piece: slice, window: float) -> tuple[Array, Array]:
    """Velocities and accelerations of a stretch of a log from local cubics over `window` [s], (k, n) each.

    Raises
    ------
    LogError
        Rows that are not evenly spaced, or fewer than a window holds.

    References
    ----------
    Savitzky and Golay, Smoothing and differentiation of data by simplified least squares procedures (1964).
    """
    t = log.t[piece]
    step = even_step(log.source, t, piece.start)
    rows = max(DEGREE + 2, 2 * round(window / (2 * step)) + 1) if step else DEGREE + 2
    if t.size < rows:
        where = f"rows {piece.start + 1} to {piece.start + t.size}"
        raise LogError(log.source, where, f"{t.size} between gaps in time", f"at least {rows}")
    dq, ddq = (savgol_filter(log.q[piece], rows, DEGREE, deriv=d, delta=step, axis=0) for d in (1, 2))
    return np.asarray(dq), np.asarray(ddq)


def _chunks(array: Array) -> list[Array]:
    return [array[i : i + CHUNK] for i in range(0, len(array), CHUNK)]
