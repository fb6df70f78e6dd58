"""The loop around the step of inverse kinematics: W starts at once, each in a lane of its own that is refilled.

Of many poses each lane takes one, and its starts one after the other. A single pose gets all lanes, and its solution is
that of the first start in order that ends in one; so both ways give the same solution. A lane takes a pose, begins a
start, judges a step and writes its row.

Buffer `b`, rows of W lanes, for n joints: q (n), T (12), repair, flag, next q (n), the measures of the step; then the
state of the lane, its nearest miss (n), the position that solutions shall be near to (n). Settings `s`: number of
starts, whether to move angles by whole turns, whether the arm is redundant, n; lower, upper, middle, turning (n each);
the starts.
"""

from typing import Any

from numba import carray, cfunc, njit, types

from lwr_dyn.kinematics.pose_solver import FOUND, INVALID, NOT_REACHED, OUTSIDE, TAIL, TOLERANCE

POSE, MEASURES, STATE = 12, 4, 9
"""Rows of T, of the measures and of the state."""

AT, START, STEPS, ALL, CODE, MISS, PLACE = range(STATE - 2)
"""The state of a lane: its pose (-1: none), its start, steps of the start and of the pose, the outcome of the nearest
miss, how far it misses, and its three measures."""

HEAD = 4
"""Settings before those of the joints."""


def buffer_size(n: int, lanes: int) -> int:
    """Numbers in the buffer for n joints."""
    return (4 * n + POSE + 2 + MEASURES + STATE) * lanes


_SQUARE = TOLERANCE**2

_FEW, _MANY, _MOST, _CLOSE, _CLOSEST = 15, 40, 1000, 1e-3, 1e-6
"""Steps of a start: of one whose E stays above 1e-3, above 1e-6, and below (where the arm is stretched or its axes are
aligned, E falls by a constant factor a step, or less); the last for this many starts of a pose:"""

_PATIENT = 40

PULL, HOLD = 1.0, 2.0
"""How a solution outside the limits is repaired: pulled along the self-motion, or held at the limits that it passes."""

_REPAIR_STEPS, _HOLD_FROM = 20, 6
"""Steps of each way; the start from which holding is tried where pulling has failed."""

_SMALL, _LARGE = 1e-4, 1e30
"""[rad or m] An excess up to the first is repaired by holding, also where the arm has no self-motion."""

_ORTHONORMAL, _FAR = 1e-6, 1e5
"""What a rotation may differ from one by (typed or printed numbers); the end of what is taken as a position."""

_TURN = 6.283185307179586

_MAGIC = 6755399441055744.0
"""Adding and subtracting it rounds to an integer."""

jit = njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)


@jit  # type: ignore[untyped-decorator]
def is_pose(T: Any, at: int) -> bool:
    """Whether 16 numbers are a homogeneous matrix: last row 0 0 0 1, R^T R = 1, det R > 0, all finite."""
    if not (T[at + 12] == 0.0 and T[at + 13] == 0.0 and T[at + 14] == 0.0 and T[at + 15] == 1.0):
        return False
    for i in range(3):
        if not abs(T[at + 4 * i + 3]) < 1e300:
            return False
        for j in range(i + 1):
            dot = T[at + i] * T[at + j] + T[at + 4 + i] * T[at + 4 + j] + T[at + 8 + i] * T[at + 8 + j]
            if not abs(dot - (1.0 if i == j else 0.0)) <= _ORTHONORMAL:
                return False
    first = T[at + 5] * T[at + 10] - T[at + 6] * T[at + 9]
    second = T[at + 6] * T[at + 8] - T[at + 4] * T[at + 10]
    third = T[at + 4] * T[at + 9] - T[at + 5] * T[at + 8]
    return bool(T[at] * first + T[at + 1] * second + T[at + 2] * third > 0.0)


@jit  # type: ignore[untyped-decorator]
def is_finite(q: Any, at: int, n: int) -> bool:
    """Whether n numbers are joint positions whose sines are exact."""
    good = 0
    for i in range(n):
        good += abs(q[at + i]) < _FAR
    return good == n


@jit  # type: ignore[untyped-decorator]
def _take_pose(T: Any, at: int, b: Any, place: int, W: int) -> None:
    """A pose to a lane, its rotation made exact by a Newton step of the polar decomposition: R (3 - R^T R) / 2."""
    for j in range(3):
        for i in range(3):
            total = 1.5 * T[at + 4 * i + j]
            for k in range(3):
                dot = T[at + j] * T[at + k] + T[at + 4 + j] * T[at + 4 + k] + T[at + 8 + j] * T[at + 8 + k]
                total -= 0.5 * T[at + 4 * i + k] * dot
            b[place + (4 * i + j) * W] = total
    for i in range(3):
        b[place + (4 * i + 3) * W] = T[at + 4 * i + 3]


@jit  # type: ignore[untyped-decorator]
def begin(b: Any, lane: int, n: int, W: int, s: Any, q0: Any, at: int, given: bool, start: int) -> None:
    """The next q of a lane is that of its start: q0 where it is given, then row by row of the table."""
    state = (2 * n + 14 + MEASURES) * W + lane
    b[state + START * W] = start
    b[state + STEPS * W] = b[(n + POSE) * W + lane] = 0.0
    table = HEAD + 4 * n + (start - (1 if given else 0)) * n
    for i in range(n):
        b[(n + 14 + i) * W + lane] = q0[at + i] if given and start == 0 else s[table + i]


@jit  # type: ignore[untyped-decorator]
def _settle(b: Any, lane: int, n: int, W: int, s: Any) -> float:
    """Moves the angles of q by whole turns to the reference and into the limits; gives the largest excess."""
    excess = -1e300
    for i in range(n):
        low, up, near = s[HEAD + i], s[HEAD + n + i], b[(3 * n + 14 + MEASURES + STATE + i) * W + lane]
        q = b[i * W + lane]
        if s[1] != 0.0 and s[HEAD + 3 * n + i] != 0.0:
            q -= _TURN * ((q - near) / _TURN + _MAGIC - _MAGIC)
            if q > up and q - _TURN >= low:
                q -= _TURN
            elif q < low and q + _TURN <= up:
                q += _TURN
            b[i * W + lane] = q
        excess = max(excess, max(low - q, q - up))
    return excess


@jit  # type: ignore[untyped-decorator]
def _remember(b: Any, lane: int, n: int, W: int, code: float, miss: float) -> None:
    """Keeps a miss if it is the nearest of its pose: outside the limits by least, else of the smallest E."""
    state = (2 * n + 14 + MEASURES) * W + lane
    known, least = b[state + CODE * W], b[state + MISS * W]
    if code > known or (code == known and not miss < least):
        return
    b[state + CODE * W], b[state + MISS * W] = code, miss
    for i in range(3):
        b[state + (PLACE + i) * W] = b[(2 * n + 14 + i) * W + lane]
    for i in range(n):
        b[(2 * n + 14 + MEASURES + STATE + i) * W + lane] = b[i * W + lane]


@jit  # type: ignore[untyped-decorator]
def _hold(b: Any, lane: int, n: int, W: int, s: Any, first: int) -> None:
    """The next q of a lane is the one at row `first`, moved to the limits that it passes."""
    for i in range(n):
        b[(n + 14 + i) * W + lane] = min(max(b[(first + i) * W + lane], s[HEAD + i]), s[HEAD + n + i])


@jit  # type: ignore[untyped-decorator]
def _repair(b: Any, lane: int, n: int, W: int, s: Any, excess: float) -> int:
    """The pose is reached outside the limits: begin to pull, or hold, or give this start up; as `_judge`."""
    if excess > (_LARGE if s[2] != 0.0 else _SMALL):
        return 2
    b[(n + POSE) * W + lane] = PULL if s[2] != 0.0 and excess > _SMALL else HOLD
    b[(2 * n + 14 + MEASURES + STEPS) * W + lane] = 0.0
    _hold(b, lane, n, W, s, 0)
    return 0


@jit  # type: ignore[untyped-decorator]
def _judge_repair(b: Any, lane: int, n: int, W: int, s: Any, steps: float, half: float) -> int:
    """After a step of a repair; as `_judge`."""
    if not half < _LARGE:
        return 2
    mode, state = b[(n + POSE) * W + lane], (2 * n + 14 + MEASURES) * W + lane
    if steps >= _REPAIR_STEPS:
        if mode == HOLD or b[state + START * W] < _HOLD_FROM:
            return 2
        b[(n + POSE) * W + lane], b[state + STEPS * W] = HOLD, 0.0
        mode = HOLD
    if mode == HOLD:
        _hold(b, lane, n, W, s, n + 14)
    return 0


@jit  # type: ignore[untyped-decorator]
def judge(b: Any, lane: int, n: int, W: int, s: Any) -> int:
    """After a step: 0 go on, 1 solved, 2 this start has failed."""
    state, measures = (2 * n + 14 + MEASURES) * W + lane, (2 * n + 14) * W + lane
    place, sine, cosine = b[measures], b[measures + W], b[measures + 2 * W]
    b[state + STEPS * W] += 1.0
    b[state + ALL * W] += 1.0
    steps, mode = b[state + STEPS * W], b[(n + POSE) * W + lane]
    half = place / 2.0 + 1.0 - cosine
    if place <= _SQUARE and sine <= _SQUARE and cosine > 0.0 and (mode != PULL or b[measures + 3 * W] == 0.0):
        excess = _settle(b, lane, n, W, s)
        if excess <= 0.0:
            return 1
        _remember(b, lane, n, W, OUTSIDE, excess)
        if mode == 0.0:
            return int(_repair(b, lane, n, W, s, excess))
    if mode != 0.0:
        return int(_judge_repair(b, lane, n, W, s, steps, half))
    most = _FEW if half > _CLOSE else _MANY
    if half < _CLOSEST and b[state + START * W] < _PATIENT:
        most = _MOST
    if half < _LARGE and steps < most:
        return 0
    _remember(b, lane, n, W, NOT_REACHED, half)
    return 2


@jit  # type: ignore[untyped-decorator]
def open_pose(b: Any, lane: int, n: int, W: int, s: Any, T: Any, t: int, q0: Any, at: int, given: bool) -> None:
    """A pose to a lane: its target, the position that its solution shall be near to, an empty record."""
    state = (2 * n + 14 + MEASURES) * W + lane
    _take_pose(T, t, b, n * W + lane, W)
    b[state + ALL * W], b[state + CODE * W] = 0.0, INVALID
    for i in range(n):
        near = min(max(q0[at + i], s[HEAD + i]), s[HEAD + n + i]) if given else s[HEAD + 2 * n + i]
        b[(3 * n + 14 + MEASURES + STATE + i) * W + lane] = near


@jit  # type: ignore[untyped-decorator]
def write(b: Any, lane: int, n: int, W: int, out: Any, at: int, solved: bool) -> None:
    """The row of a pose: the q of the lane, or its nearest miss."""
    state = (2 * n + 14 + MEASURES) * W + lane
    q, measures = (lane, (2 * n + 14) * W + lane) if solved else (state + STATE * W, state + PLACE * W)
    for i in range(n):
        out[at + i] = b[q + i * W]
    out[at + n] = FOUND if solved else b[state + CODE * W]
    for i in range(3):
        out[at + n + 1 + i] = b[measures + i * W]
    out[at + n + 4], out[at + n + 5] = b[state + START * W], b[state + ALL * W]


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
    row, room = (number, types.int64), jit(buffer_size)
    signature = types.int64(*row, *row, *row, number, number, types.int64, types.int64)

    @cfunc(signature, error_model="numpy")  # type: ignore[untyped-decorator]
    def kernel(
        T_: Any, T_step: int, q0_: Any, q0_step: int, s_: Any, s_step: int, out_: Any, b_: Any, start: int, stop: int
    ) -> int:
        s = carray(s_, (s_step,), types.float64)
        n = int(s[3])  # not a constant: numba would compile every function of a lane again for it
        x = carray(T_, (16,), types.float64), T_step, carray(q0_, (n,), types.float64), q0_step
        b, out = carray(b_, (room(n, W),), types.float64), carray(out_, (n + TAIL,), types.float64)
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
