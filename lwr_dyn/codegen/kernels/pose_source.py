"""Generates the step of an arm's inverse kinematics as straight-line code, and its kernel, the step in its loop.

From q towards the pose T of the flange:

    e = [p_T - p; 2 sin(theta/2) u],    E = |e|^2 / 2,    damping = 0.1 E + 1e-12
    dq = pull + J^T (J J^T + damping)^-1 (e - J pull),    scaled to |dq| <= 1 rad

with theta u the rotation from the flange to T. `pull` moves a redundant arm along its self-motion; it is 0 mostly.
Levenberg 1944, Marquardt 1963; damping by the error itself: Sugihara, IEEE Transactions on Robotics 27(5), 2011.
"""

from typing import Any

import casadi
import numpy as np

from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.kernels.kernel_source import placed_lines
from lwr_dyn.codegen.kernels.loop_code import KernelLoop, LaneBody
from lwr_dyn.codegen.kernels.pose_driver import NUMBERS, POSE, pose_driver
from lwr_dyn.codegen.kernels.straight_line import straight_line_code
from lwr_dyn.codegen.kernels.symbolic_functions import column, ldl_factor, ldl_solve, scalars
from lwr_dyn.kinematics.forward import jacobian_at, joint_axes
from lwr_dyn.kinematics.pose_solver import SearchRanges
from lwr_dyn.model.chain import Chain

SHARE, LEAST = 0.1, 1e-12
"""Damping: this share of E, and at least this."""

LONGEST = 1.0
"""[rad or m] Longest step."""

_HALF_TURN = 1e-12
"""Keeps the rotation error finite at half a turn."""


def pose_step(chain: Chain, ranges: SearchRanges) -> Any:
    """casadi.Function of q (n), T (12) and repair (1): the next q (n), then the measures at q.

    With repair = 1 joints outside their limits are pulled inside, with repair = 2 those at them (or outside) are held.
    Measures: squares of the position error and of sin theta, cos theta, and with repair the number of joints outside.
    """
    q, target, repair = (casadi.SX.sym(name, size) for name, size in (("q", chain.n), ("T", POSE), ("repair", 1)))
    axes = joint_axes(chain, scalars(q))
    error, measures = _pose_error(axes.flange, np.reshape(scalars(target), (3, 4)))
    pulls, free, outside = zip(*map(_at_limits, scalars(q), ranges.lower, ranges.upper, ranges.room), strict=True)
    pull, hold = repair * (2.0 - repair) * column(pulls), repair * (repair - 1.0) / 2.0
    J = _matrix(jacobian_at(axes, axes.flange[:3, 3]) * [1.0 - hold * (1.0 - x) for x in free])
    damping = SHARE / 2.0 * casadi.sumsqr(error) + LEAST
    factor = ldl_factor(J @ J.T + damping * casadi.SX.eye(6))
    dq = pull + J.T @ ldl_solve(factor, error - J @ pull)
    square = casadi.sumsqr(dq) / LONGEST**2
    longer = square > 1.0
    scaled = dq / casadi.sqrt(1.0 + longer * (square - 1.0))
    out = casadi.vertcat(q + scaled, *measures, repair * sum(outside))
    return casadi.Function("pose_step", [q, target, repair], [casadi.densify(casadi.SX(out))])


def _at_limits(q: Any, low: float, up: float, room: float) -> tuple[Any, Any, Any]:
    """The way from outside the limits to the inside (0 from within), whether q is within, whether it is outside."""
    pull, free, outside = 0.0, 1.0, 0.0
    if np.isfinite(low):
        pull, free, outside = (q < low) * (low + room - q), q > low, q < low
    if np.isfinite(up):
        pull, free, outside = pull + (q > up) * (up - room - q), free * (q < up), outside + (q > up)
    return pull, free, outside


def _matrix(rows: Any) -> Any:
    """An array of scalars as a casadi matrix."""
    return casadi.vertcat(*(casadi.horzcat(*(casadi.SX(x) for x in row)) for row in rows))


def _pose_error(flange: Any, pose: Any) -> tuple[Any, tuple[Any, Any, Any]]:
    """The error e (6), and the three measures."""
    turn = [[sum(pose[i, k] * flange[j, k] for k in range(3)) for j in range(3)] for i in range(3)]
    sine = column([(turn[2][1] - turn[1][2]) / 2.0, (turn[0][2] - turn[2][0]) / 2.0, (turn[1][0] - turn[0][1]) / 2.0])
    cosine = (turn[0][0] + turn[1][1] + turn[2][2] - 1.0) / 2.0
    rotation = sine / casadi.sqrt((1.0 + cosine) / 2.0 + _HALF_TURN)
    position = column([pose[i, 3] - flange[i, 3] for i in range(3)])
    measures = (casadi.sumsqr(position), casadi.sumsqr(sine), cosine)
    return casadi.vertcat(position, rotation), measures


_TEXT = """def body(b):
    for k in range({lanes}):
{body}
"""


def step_source(chain: Chain, ranges: SearchRanges, lanes: int) -> str:
    """The step of a chain on a buffer of W lanes, as Python.

    The flag and what `pose_step` gives stand behind q, T and repair.
    """
    code = straight_line_code(pose_step(chain, ranges), sincos("float64"))
    widths = (chain.n, POSE, 1)
    slots = {("in", row, j): sum(widths[:row]) + j for row, width in enumerate(widths) for j in range(width)}
    flag = sum(widths)
    body = "\n".join(placed_lines(code, slots, range(flag, flag + 1 + len(code.results)), lanes))
    return _TEXT.format(lanes=lanes, body=body)


def pose_loop(chain: Chain, ranges: SearchRanges, lanes: int) -> KernelLoop:
    """The kernel of a chain: the search around its step."""
    step = LaneBody("body", step_source(chain, ranges, lanes))
    return KernelLoop(pose_driver(chain.n, lanes), "search", (step,), constants=NUMBERS)
