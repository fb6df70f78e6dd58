"""The loop around the step of inverse kinematics: W starts at once, each in a lane of its own that is refilled.

Of many poses each lane takes one, and its starts one after the other. A single pose gets all lanes, and its solution is
that of the first start in order that ends in one; so both ways give the same solution.
"""

from typing import Any

from numba import carray, cfunc, types

from lwr_dyn.codegen.kernels import pose_layout
from lwr_dyn.codegen.kernels.pose_lanes import begin, is_finite, is_pose, jit, judge, open_pose, write
from lwr_dyn.codegen.kernels.pose_layout import CODE, MEASURES, MISS, START
from lwr_dyn.kinematics.pose_solver import INVALID, TAIL


@jit  # type: ignore[untyped-decorator]
def _next(b: Any, lane: int, n: int, W: int, s: Any, x: Any, out: Any, p: int, stop: int) -> int:
    """The first start of the next pose goes to a lane; gives the number of the pose behind it."""
    T, T_step, q0, q0_step = x
    state = (2 * n + 14 + MEASURES) * W + lane
    given = q0_step >= 0
    b[state] = -1.0
    while p < stop:
        if is_pose(T, p * T_step) and (not given or is_finite(q0, p * q0_step, n)):
            b[state] = p
            open_pose(b, lane, n, W, s, T, p * T_step, q0, p * q0_step, given)
            begin(b, lane, n, W, s, q0, p * q0_step, given, 0)
            return p + 1
        for i in range(n + TAIL):
            out[p * (n + TAIL) + i] = INVALID if i == n else 0.0
        p += 1
    return stop


@jit  # type: ignore[untyped-decorator]
def _of_many(b: Any, lane: int, n: int, W: int, s: Any, x: Any, out: Any, waiting: int, stop: int) -> int:
    """What a lane does after a step when each has its own pose; gives the pose that is next."""
    state = (2 * n + 14 + MEASURES) * W + lane
    verdict, p, start = judge(b, lane, n, W, s), int(b[state]), int(b[state + START * W])
    if verdict == 2 and start + 1 < s[0]:
        begin(b, lane, n, W, s, x[2], p * x[3], x[3] >= 0, start + 1)
    elif verdict != 0:
        write(b, lane, n, W, out, p * (n + TAIL), verdict == 1)
        return int(_next(b, lane, n, W, s, x, out, waiting, stop))
    return waiting


@jit  # type: ignore[untyped-decorator]
def _of_one(b: Any, lane: int, n: int, W: int, s: Any, x: Any, out: Any, p: int, best: int) -> int:
    """What a lane does after a step when all have one pose; gives the first start that is solved."""
    state = (2 * n + 14 + MEASURES) * W + lane
    verdict, start = judge(b, lane, n, W, s), int(b[state + START * W])
    if verdict == 1 and start < best:
        write(b, lane, n, W, out, p * (n + TAIL), True)
        best = start
    if verdict == 2 and start + W < best:
        begin(b, lane, n, W, s, x[2], p * x[3], x[3] >= 0, start + W)
    elif verdict != 0 or start > best:
        b[state] = -1.0
    return best


@jit  # type: ignore[untyped-decorator]
def _nearest_miss(b: Any, n: int, W: int, out: Any, at: int) -> None:
    """The row of a pose without a solution: the nearest of the lanes' misses."""
    state, nearest = (2 * n + 14 + MEASURES) * W, 0
    for lane in range(1, W):
        code, known = b[state + CODE * W + lane], b[state + CODE * W + nearest]
        if code < known or (code == known and b[state + MISS * W + lane] < b[state + MISS * W + nearest]):
            nearest = lane
    write(b, nearest, n, W, out, at, False)


@jit  # type: ignore[untyped-decorator]
def _first_starts(b: Any, n: int, W: int, s: Any, x: Any, out: Any, start: int, stop: int) -> int:
    """Fills the lanes; gives the pose that is next, or of a single pose the number of its starts."""
    state, waiting = (2 * n + 14 + MEASURES) * W, start
    for lane in range(W):
        b[state + CODE * W + lane] = INVALID
        if stop - start > 1:
            waiting = _next(b, lane, n, W, s, x, out, waiting, stop)
        elif lane < s[0] and _next(b, lane, n, W, s, x, out, start, stop) == stop and b[state + lane] >= 0.0:
            begin(b, lane, n, W, s, x[2], start * x[3], x[3] >= 0, lane)
        else:
            b[state + lane] = -1.0
    return waiting if stop - start > 1 else int(s[0])


@jit  # type: ignore[untyped-decorator]
def _after_step(b: Any, n: int, W: int, s: Any, x: Any, out: Any, start: int, stop: int, next_or_best: int) -> int:
    """Judges every lane that works; gives what `_of_many` or `_of_one` gives."""
    for lane in range(W):
        if b[(2 * n + 14 + MEASURES) * W + lane] < 0.0:
            continue
        if stop - start > 1:
            next_or_best = _of_many(b, lane, n, W, s, x, out, next_or_best, stop)
        else:
            next_or_best = _of_one(b, lane, n, W, s, x, out, start, next_or_best)
    return next_or_best


@jit  # type: ignore[untyped-decorator]
def _is_working(b: Any, n: int, W: int) -> bool:
    """Whether a lane has a pose; the next q of all becomes q."""
    working = 0
    for lane in range(W):
        working += b[(2 * n + 14 + MEASURES) * W + lane] >= 0.0
    for i in range(n * W):
        b[i] = b[(n + 14) * W + i]
    return working > 0


def pose_kernel(body: Any, W: int) -> Any:
    """The compiled loop around a step `body` of W lanes."""
    number = types.CPointer(types.float64)
    row, buffer_size = (number, types.int64), jit(pose_layout.buffer_size)
    signature = types.int64(*row, *row, *row, number, number, types.int64, types.int64)

    @cfunc(signature, error_model="numpy")  # type: ignore[untyped-decorator]
    def kernel(
        T_: Any, T_step: int, q0_: Any, q0_step: int, s_: Any, s_step: int, out_: Any, b_: Any, start: int, stop: int
    ) -> int:
        s = carray(s_, (s_step,), types.float64)
        n = int(s[3])  # not a constant: numba would compile every function of a lane again for it
        x = carray(T_, (16,), types.float64), T_step, carray(q0_, (n,), types.float64), q0_step
        b, out = carray(b_, (buffer_size(n, W),), types.float64), carray(out_, (n + TAIL,), types.float64)
        for i in range(len(b)):
            b[i] = 0.0
        next_or_best, opened = _first_starts(b, n, W, s, x, out, start, stop), False
        while _is_working(b, n, W):
            body(b)
            next_or_best, opened = _after_step(b, n, W, s, x, out, start, stop, next_or_best), True
        if opened and stop - start == 1 and next_or_best == int(s[0]):
            _nearest_miss(b, n, W, out, start * (n + TAIL))
        return 0

    return kernel
