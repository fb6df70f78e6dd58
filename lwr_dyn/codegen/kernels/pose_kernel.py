"""The search for one solution of a pose, by a kernel compiled for an arm when first used: the row "kernel".

The last steps, where the search by damped least squares has come near and stays there, are Newton's method: where an
arm is stretched and its axes are aligned at once, the pose error is a definite quadratic form of q, with coefficients
that differ by a thousand and more. J falls with the error, and steps by J alone go to and fro across a narrow valley.
The second derivatives see the valley. With E = |e|^2 / 2:

    dE/dq = -J^T e,    d2E/dq_i dq_j = J_i . J_j - e_p . (z_i x Jv_j) - e_r . (z_i x z_j) / 2    for i <= j

up to |e|^2, with z_i the axis of joint i (0 where it slides). Eigenvalues count by their magnitude: no way to a saddle.
"""

import threading
from collections.abc import Callable
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.kernel import address, aligned, cache_name, kept_code, require_packages
from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.version import package_version
from lwr_dyn.kinematics import pose_solver
from lwr_dyn.kinematics.forward import jacobian_at, joint_axes
from lwr_dyn.kinematics.pose_solver import FOUND, NOT_REACHED, OUTSIDE, TAIL, TOLERANCE, SearchRanges, search_ranges
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.spatial import pose_array

_STEPS, _LONGEST, _LEAST, _SETTLED = 60, 0.3, 1e-15, 1e-3
"""Steps at most; the longest [rad or m]; the least eigenvalue, above the rounding of J^T J; at a minimum of E above 0
the slope along the next step falls below this share of 2 E."""


def curvature(J: Array, e: Array) -> Array:
    """Second derivatives (n, n) of E at a Jacobian (6, n) and an error (6,)."""
    axes = J[3:].T[:, None]
    bend = np.triu(np.cross(axes, J[:3].T) @ e[:3] + np.cross(axes, J[3:].T) @ e[3:] / 2.0)
    out: Array = J.T @ J - bend - np.triu(bend, 1).T
    return out


def finish(chain: Chain, ranges: SearchRanges, T: Array, row: Array, near: Array | None) -> Array:
    """The row of a pose that was not reached, after these steps: solved, reached outside the limits, or as it was.

    Solutions are moved by whole turns next to `near` (n,), if it is given.
    """
    n = len(ranges.middle)
    T, q = pose_array("T", T), row[:n]
    for step in range(_STEPS):
        axes = joint_axes(chain, q)
        e, sizes = pose_solver.pose_error(T, axes.flange)
        if sizes[0] <= TOLERANCE**2 and sizes[1] <= TOLERANCE**2 and sizes[2] > 0.0:
            q = q if near is None else pose_solver.with_turns(q, near, ranges)
            outside = bool(((q < ranges.lower) | (q > ranges.upper)).any())
            return np.array([*q, OUTSIDE if outside else FOUND, *sizes, row[-2], row[-1] + step])
        J = jacobian_at(axes, axes.flange[:3, 3])
        values, directions = np.linalg.eigh(curvature(J, e))
        dq = directions @ (directions.T @ (J.T @ e) / np.maximum(np.abs(values), _LEAST))
        if (J @ dq) @ e < _SETTLED * (e @ e):
            break
        q = q + dq * min(1.0, _LONGEST / max(float(np.linalg.norm(dq)), 1e-300))
    return row


GENERATOR = 9
"""Version of the generator: raised when it writes another kernel for the same arm, so that cached ones are not used."""

_CLOSE, _AGAIN, _NEAR = 1e-11, 40, 1e-3
"""E of a miss that Newton's method shall finish; where that miss is a minimum of E, the ends of this many starts are
taken up too, to this E."""

_FLOAT = np.dtype(np.float64)


class _Desk(threading.local):
    """The numbers of one call, at the same addresses in every call of a thread: pose, q0, row, the kernel's buffer."""

    def __init__(self, n: int, room: int, full: Array, once: Array) -> None:
        self.T, self.q0, self.row = np.zeros((4, 4)), np.zeros(n), np.zeros(n + TAIL)
        self.buffer, place = aligned(room * _FLOAT.itemsize)
        T, q0, row = address(self.T), address(self.q0), address(self.row)
        self.cold = (T, 16, q0, -1, address(full), len(full), row, place, 0, 1)
        self.given = (T, 16, q0, n, address(full), len(full), row, place, 0, 1)
        self.once = (T, 16, q0, n, address(once), len(once), row, place, 0, 1)


class KernelSearch:
    """The search of one arm, by its kernel, whose buffer has `room` numbers; `made_from` makes it again."""

    __slots__ = ("_call", "_chain", "_desk", "_full", "_made_from", "_once", "_ranges", "_room", "n")

    def __init__(
        self,
        chain: Chain,
        ranges: SearchRanges,
        call: Callable[..., int],
        room: int,
        made_from: tuple[Arm, bool, int, int],
    ) -> None:
        self._made_from = made_from
        self.n, self._call, self._room, self._chain, self._ranges = chain.n, call, room, chain, ranges
        joints = (ranges.lower, ranges.upper, ranges.middle, ranges.turning)
        redundant = float(self.n > 6)
        self._full = np.concatenate([(len(ranges.starts), 1.0, redundant, self.n), *joints, ranges.starts.ravel()])
        self._once = np.concatenate([(1.0, 0.0, redundant, self.n), *joints])
        self._desk = _Desk(self.n, room, self._full, self._once)

    def __reduce__(self) -> tuple[Callable[..., "KernelSearch"], tuple[Arm, bool, int, int]]:
        return kernel_search, self._made_from

    def one(self, T: Any, q0: Any, restart: bool) -> Array:
        """As `PoseSearch.one`; raises `ShapeError`."""
        desk = self._desk
        if type(T) is not np.ndarray or T.shape != (4, 4) or T.dtype is not _FLOAT:
            T = fixed_array("T", T, (4, 4))
        desk.T[:] = T
        if q0 is None and restart:
            self._call(*desk.cold)
        else:
            if type(q0) is not np.ndarray or q0.shape != (self.n,) or q0.dtype is not _FLOAT:
                q0 = fixed_array("q0", q0, (self.n,))
            desk.q0[:] = q0
            self._call(*(desk.given if restart else desk.once))
        row = desk.row.copy()
        return row if row.item(self.n) != NOT_REACHED else self._finished(row, T, q0, restart)

    def rows(self, T: Array, q0: Array | None, restart: bool) -> Array:
        """As `PoseSearch.rows`."""
        out = self._rows(T, q0, restart)
        for k in np.flatnonzero(out[:, self.n] == NOT_REACHED):
            out[k] = self._finished(out[k], T[k], None if q0 is None else q0[k], restart)
        return out

    def _rows(self, T: Array, q0: Array | None, restart: bool) -> Array:
        """The kernel's rows."""
        T, out = np.ascontiguousarray(T), np.empty((len(T), self.n + TAIL))
        settings = self._full if restart else self._once
        first, step = (out, -1) if q0 is None else (np.ascontiguousarray(q0), self.n)
        kept, place = aligned(self._room * _FLOAT.itemsize)
        given = address(T), 16, address(first), step, address(settings), len(settings)
        self._call(*given, address(out), place, 0, len(T))
        del kept
        return out

    def _finished(self, row: Array, T: Array, q0: Any, restart: bool) -> Array:
        """The row of a pose that was not reached, after Newton's method where it is near."""
        x, n = self._ranges, self.n
        if not _half(row) < _CLOSE:
            return row
        near = None if not restart else x.middle if q0 is None else np.clip(q0, x.lower, x.upper)
        found = finish(self._chain, x, T, row, near)
        if found[n] == FOUND or not restart:
            return found
        first = x.starts[:_AGAIN]
        ends = self._rows(np.broadcast_to(T, (len(first), 4, 4)), first, False)
        misses = (end for end in ends if end[n] == NOT_REACHED and _half(end) < _NEAR)
        others = (finish(self._chain, x, T, miss, near) for miss in misses)
        return next((other for other in others if other[n] == FOUND), found)


def _half(row: Array) -> float:
    """E of a row."""
    return float(row[1 - TAIL] / 2.0 + 1.0 - row[3 - TAIL])


def kernel_search(arm: Arm, limits: bool, starts: int, seed: int) -> KernelSearch:
    """The row "kernel" of `POSE_SEARCHES`; raises `MissingPackageError`."""
    require_packages()
    from lwr_dyn.codegen.kernels.machine_code import lanes_of
    from lwr_dyn.codegen.kernels.pose_driver import buffer_size

    room = buffer_size(arm.n, lanes_of("float64"))
    given = arm, limits, starts, seed
    return KernelSearch(arm.chain, search_ranges(*given), _kernel(arm).call, room, given)


def _kernel(arm: Arm) -> Any:
    """The arm's kernel."""
    from lwr_dyn.codegen.kernels.machine_code import lanes_of

    def made() -> bytes:
        from lwr_dyn.codegen.kernels.pose_source import pose_loop

        return pose_loop(arm.chain, search_ranges(arm, True, 1, 0), lanes_of("float64")).machine_code()

    return kept_code(_key(arm), made, inputs=3)


def _key(arm: Arm) -> str:
    """Name of the kernel in the cache, from the arm's geometry and limits, the generator, compiler and processor."""
    from lwr_dyn.codegen.kernels.machine_code import host_cpu, lanes_of

    frames = [matrix for link in arm.chain.links for matrix in (link.before.matrix(), link.after.matrix())]
    numbers = [*frames, arm.chain.flange.matrix(), arm.lower, arm.upper]
    text = [f"generator {GENERATOR}", *(link.kind.value for link in arm.chain.links)]
    text += [np.asarray(x, dtype=np.float64).tobytes().hex() for x in numbers]
    text += [*host_cpu(), str(lanes_of("float64")), package_version("llvmlite")]
    return cache_name("pose", text)
