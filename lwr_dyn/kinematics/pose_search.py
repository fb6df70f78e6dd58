"""The search for one solution on Pinocchio, where no kernel can be compiled.

    dq = pull + J^T (J J^T + damping)^-1 (e - J pull),    damping = 0.1 E + 1e-12,    E = |e|^2 / 2,    |dq| <= 1

Damping by the error itself: Sugihara, IEEE Transactions on Robotics 27(5), 2011. Where the pose is reached outside
the limits of a redundant arm, `pull` brings the joints inside along its self-motion.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg.lapack import dgesv

from lwr_dyn.dynamics.pinocchio_engine import flange_and_jacobian
from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.kinematics.pose_solver import FOUND, NOT_REACHED, OUTSIDE, TAIL, TOLERANCE, SearchRanges, search_ranges
from lwr_dyn.kinematics.solution import TURN
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import pose_array

_PATIENCE = ((1e-6, 300), (1e-3, 40), (np.inf, 15))
"""Steps of a start by its E: where an arm is stretched, E falls by a constant factor a step."""
_REPAIR = 20
"""Steps of a repair."""


@dataclass(frozen=True, slots=True, eq=False)
class PinocchioSearch:
    """The search of one arm. Not for use by two threads at once."""

    ranges: SearchRanges
    flange: Callable[[Array], tuple[Array, Array]]

    def one(self, T: ArrayLike, q0: ArrayLike | None, restart: bool) -> Array:
        """As `PoseSearch.one`; raises `ShapeError`, `OptionError`."""
        cold = q0 is None and restart
        first = None if cold else fixed_array("q0", q0, self.ranges.middle.shape)  # type: ignore[arg-type]
        return self._row(pose_array("T", fixed_array("T", T, (4, 4))), first, restart)

    def rows(self, T: Array, q0: Array | None, restart: bool) -> Array:
        """As `PoseSearch.rows`."""
        poses = enumerate(pose_array("T", T))
        rows = [self._row(pose, None if q0 is None else q0[k], restart) for k, pose in poses]
        return np.array(rows).reshape(len(T), -1)

    def _row(self, T: Array, q0: Array | None, restart: bool) -> Array:
        x, best, steps = self.ranges, (float(NOT_REACHED), np.inf), 0
        near = x.middle if q0 is None else np.clip(q0, x.lower, x.upper)
        row = np.array([*near, NOT_REACHED, *[0.0] * (TAIL - 1)])
        given = [] if q0 is None else [q0]
        for start, first in enumerate(chain(given, x.starts[: len(x.starts) - len(given)] if restart else [])):
            for q, error, judged in self._steps(T, first, near if restart else None):
                steps += 1
                if judged is None:
                    continue
                excess = float(np.maximum(x.lower - q, q - x.upper).max())
                rank = (judged, error[0] + 2.0 * (1.0 - error[2])) if judged else (OUTSIDE * (excess > 0.0), excess)
                if rank < best:
                    best, row = rank, np.array([*q, rank[0], *error, start, steps])
                if rank[0] == FOUND:
                    return row
        return row

    def _steps(self, T: Array, q: Array, near: Array | None) -> Iterator[tuple[Array, tuple[float, ...], int | None]]:
        """The positions of one start: q, its three errors, and FOUND, NOT_REACHED, or None to go on."""
        x, k, most, pulling = self.ranges, 0, 0, False
        while k <= most:
            pose, J = self.flange(q)
            error, sizes = pose_error(T, pose)
            half, k = error @ error / 2.0, k + 1
            most = most if pulling else next(count for level, count in _PATIENCE if half < level)
            reached = sizes[0] <= TOLERANCE**2 and sizes[1] <= TOLERANCE**2 and sizes[2] > 0.0
            if reached and near is not None:
                q = with_turns(q, near, x)
            yield q, sizes, FOUND if reached else NOT_REACHED if k == most and not pulling else None
            if reached and not pulling:
                pulling, most = True, k + (_REPAIR if len(q) > len(error) else 0)
            square = J @ J.T
            square.flat[::7] += 0.1 * half + 1e-12
            if pulling:
                outside = (q < x.lower) | (q > x.upper)
                pull = outside * (np.clip(q, x.lower + x.room, x.upper - x.room) - q)
                step = pull + J.T @ _solved(square, error - J @ pull)
            else:
                step = J.T @ _solved(square, error)
            q = q + step / max(1.0, math.sqrt(step @ step))


def _solved(square: Array, right: Array) -> Array:
    """square^-1 right by LAPACK itself, as NumPy's checks take longer than these 6 equations."""
    x: Array = dgesv(square, right, overwrite_a=1)[2]
    return x


def pose_error(T: Array, pose: Array) -> tuple[Array, tuple[float, ...]]:
    """[p_T - p; 2 sin(theta/2) u], and the squares of its position and of sin theta, and cos theta."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = (T[:3, :3] @ pose[:3, :3].T).tolist()
    a, b, c = (T[:3, 3] - pose[:3, 3]).tolist()
    sine, cosine = ((zy - yz) / 2.0, (xz - zx) / 2.0, (yx - xy) / 2.0), (xx + yy + zz - 1.0) / 2.0
    scale = 1.0 / math.sqrt(max((1.0 + cosine) / 2.0, 1e-12))
    error = np.array([a, b, c, *(scale * s for s in sine)])
    return error, (a * a + b * b + c * c, sum(s * s for s in sine), cosine)


def with_turns(q: Array, near: Array, x: SearchRanges) -> Array:
    """Angles moved by whole turns next to a position, and inside the limits if they can be."""
    q = np.where(x.turning, q - TURN * np.round((q - near) / TURN), q)
    q = np.where(x.turning & (q > x.upper) & (q - TURN >= x.lower), q - TURN, q)
    out: Array = np.where(x.turning & (q < x.lower) & (q + TURN <= x.upper), q + TURN, q)
    return out


def pinocchio_search(arm: Arm, limits: bool, starts: int, seed: int) -> PinocchioSearch:
    """The row "pinocchio" of `POSE_SEARCHES`."""
    return PinocchioSearch(search_ranges(arm, limits, starts, seed), flange_and_jacobian(arm))
