"""One solution for a flange pose, fast: `solve(T, q0)`. All solutions: `kinematics.inverse`.

A search goes from q0, and where that fails from seeded starts, by damped least squares to position and rotation errors
of 1e-9 m and rad. It proves nothing: a pose that it does not reach may have a solution. The search on Pinocchio is for
where no kernel can be compiled:

    dq = pull + J^T (J J^T + damping)^-1 (e - J pull),    damping = 0.1 E + 1e-12,    E = |e|^2 / 2,    |dq| <= 1

Damping by the error itself: Sugihara, IEEE Transactions on Robotics 27(5), 2011. Where the pose is reached outside
the limits of a redundant arm, `pull` brings the joints inside along its self-motion.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any, NoReturn, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg.lapack import dgesv

from lwr_dyn.dynamics.pinocchio_engine import flange_and_jacobian
from lwr_dyn.foundation.arrays import Array, arm_argument, fixed_array, joint_array, real_array
from lwr_dyn.foundation.errors import MissingPackageError, OptionError, PoseNotReachedError, ShapeError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.kinematics.solution import TURN, drawing_range
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import pose_array

FOUND, OUTSIDE, NOT_REACHED, INVALID = range(4)
"""What became of a pose: solved, reached outside the limits only, not reached, no pose or q0 at all."""
TAIL = 6
"""Numbers behind q in a row: outcome, squares of position error and sin theta, cos theta, start (from 0), steps."""
TOLERANCE = 0.99e-9
"""[m and rad] Position and rotation error of a solution: 1e-9 with room for the rounding of who checks it."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchRanges:
    """What a search needs of the joints, (n,) each; lower and upper are infinite where they do not count."""

    lower: Array
    upper: Array
    middle: Array
    turning: NDArray[np.bool_]
    """Whether it is an angle."""
    room: Array
    """How far inside its limits a joint is brought that was outside [rad or m]."""
    starts: Array
    """(starts, n), drawn inside the limits; of an unlimited joint within half a turn (1 m) of its middle."""


def search_ranges(arm: Arm, limits: bool, starts: int, seed: int) -> SearchRanges:
    """Ranges and starts of a search."""
    turning, low, up = arm.chain.turning, arm.lower, arm.upper
    first, last = drawing_range(turning, low, up)
    half = (last - first) / 2.0
    reach = np.where(turning, np.minimum(half, np.pi), half)
    draw = np.random.default_rng(seed).uniform(-1.0, 1.0, (starts, arm.n)) * reach
    if not limits:
        low, up = low - np.inf, up + np.inf
    return SearchRanges(low, up, first + half, turning, np.minimum(0.3, half / 2.0), first + half + draw)


class PoseSearch(Protocol):
    """A search for joint positions; its rows hold q (the nearest miss where nothing is found) and `TAIL` numbers."""

    def one(self, T: Any, q0: Any, restart: bool) -> Array:
        """The row (n + TAIL,) of a pose (4, 4); q0 (n,) or None. The arguments are not checked before."""

    def rows(self, T: Array, q0: Array | None, restart: bool) -> Array:
        """The rows (k, n + TAIL) of poses (k, 4, 4); q0 (k, n) or None."""


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


POSE_SEARCHES: Registry[Callable[[Arm, bool, int, int], PoseSearch]] = Registry(
    "pose search",
    {
        "kernel": Row(
            "lwr_dyn.codegen.kernels.pose_kernel:kernel_search", "compiled for the arm when first used", "batch"
        ),
        "pinocchio": Row("lwr_dyn.kinematics.pose_solver:pinocchio_search", "the same search on Pinocchio"),
    },
)
"""Searches for one solution of a pose, the fastest first: factories of (arm, limits, starts, seed)."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseBatch:
    """Joint positions for many poses."""

    q: Array
    """(..., n) [rad or m]; NaN where none was found."""
    found: NDArray[np.bool_]
    """(...)"""
    outside: NDArray[np.bool_]
    """(...): reached, but outside the limits only."""
    distance: Array
    """(...) Position error [m] of the nearest position that the search met; below 1e-9 where `found` or `outside`."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseSolver:
    """`solve(T, q0)`: one solution of a pose; with the search "kernel" for use by several threads at once."""

    arm: Arm
    search: PoseSearch

    def __call__(self, T: ArrayLike, q0: ArrayLike | None = None) -> Array:
        """Joint positions (n,) [rad or m] whose flange pose is T (4, 4), inside the limits.

        They are those that q0 (n,) leads to, or the nearest whole turns of them; another solution where it leads to
        none. Without q0 the solution depends on T alone.

        Raises
        ------
        PoseNotReachedError
            Nothing was found; says by how much.
        ShapeError, OptionError
            T is not a pose, or q0 is not n numbers.
        """
        return self._found(self.search.one(T, q0, True), T, q0)

    def near(self, T: ArrayLike, q0: ArrayLike) -> Array:
        """As `solve(T, q0)`, from q0 alone: no other start and no whole turn, so that a path stays one path."""
        return self._found(self.search.one(T, q0, False), T, q0)

    def batch(self, T: ArrayLike, q0: ArrayLike | None = None) -> PoseBatch:
        """Joint positions for poses T (..., 4, 4), from q0 (..., n) or (n,), each as `solve` finds them.

        Raises `ShapeError` and `OptionError`; a pose that is not reached is marked.
        """
        pose, n = real_array("T", T), self.arm.n
        if pose.shape[-2:] != (4, 4):
            raise ShapeError("T", f"shape {pose.shape}", "(..., 4, 4), homogeneous matrices")
        lead = pose.shape[:-2]
        first = None if q0 is None else _starting_points(q0, (*lead, n))
        row = self.search.rows(pose.reshape(-1, 4, 4), first, True).reshape(*lead, n + TAIL)
        if (row[..., n] == INVALID).any():
            self._refuse(T, first)
        found = row[..., n] == FOUND
        q = np.where(found[..., None], row[..., :n], np.nan)
        return PoseBatch(q, found, row[..., n] == OUTSIDE, np.sqrt(row[..., n + 1]))

    def _found(self, row: Array, T: ArrayLike, q0: ArrayLike | None) -> Array:
        n = self.arm.n
        if row[n] == FOUND:
            return row[:n]
        if row[n] == INVALID:
            self._refuse(T, q0)
        q, angle = row[:n].copy(), float(np.arctan2(np.sqrt(row[n + 2]), row[n + 3]))
        excess = np.maximum(self.arm.lower - q, q - self.arm.upper) if row[n] == OUTSIDE else np.zeros(n)
        joint = self.arm.joint_names[int(np.argmax(excess))] if row[n] == OUTSIDE else None
        raise PoseNotReachedError(self.arm.name, float(np.sqrt(row[n + 1])), angle, q, joint, float(excess.max()))

    def _refuse(self, T: ArrayLike, q0: ArrayLike | None) -> NoReturn:
        pose_array("T", T)
        joint_array("q0", 0.0 if q0 is None else q0, self.arm.n)
        raise OptionError("q0", "a position beyond 1e5", "angles [rad] and lengths [m] below it")


def _starting_points(q0: ArrayLike, shape: tuple[int, ...]) -> Array:
    first = joint_array("q0", q0, shape[-1])
    try:
        return np.ascontiguousarray(np.broadcast_to(first, shape)).reshape(-1, shape[-1])
    except ValueError:
        raise ShapeError("q0", f"shape {first.shape}", f"{shape} or ({shape[-1]},), as T") from None


def ik_solver(
    arm: Arm, *, limits: bool = True, starts: int = 300, seed: int = 0, search: str | None = None
) -> PoseSolver:
    """A function `solve(T, q0)` that gives one solution fast; see `PoseSolver`, and `inverse_kinematics` for all.

    Parameters
    ----------
    arm : Arm
    limits : bool
        False: solutions outside the position limits count too.
    starts, seed : int
        Starts before a pose is given up, and the seed they are drawn by.
    search : str, optional
        One of `POSE_SEARCHES`; the first one installed if not given.

    Raises
    ------
    UnknownNameError, MissingPackageError, OptionError
        No such search, its packages are missing, or starts below 1.

    >>> import lwr_dyn
    >>> arm = lwr_dyn.load("kr30ha")
    >>> q = [0.1, -1.2, 1.3, 0.2, 0.4, 0.5]
    >>> solve = ik_solver(arm, search="pinocchio")
    >>> solve(lwr_dyn.forward_kinematics(arm, q), q).round(9).tolist() == q
    True
    """
    arm_argument(arm)
    if starts < 1:
        raise OptionError("starts", starts, "an integer >= 1")
    for name in POSE_SEARCHES.rows if search is None else (search,):
        try:
            return PoseSolver(arm, POSE_SEARCHES.load(name)(arm, limits, starts, seed))
        except MissingPackageError:
            if name in (search, "pinocchio"):
                raise
    raise OptionError("search", repr(search), ", ".join(POSE_SEARCHES.names))
