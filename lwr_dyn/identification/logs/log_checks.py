"""The gate for logs: finite rows, rising times, and units that can be true; one clear line otherwise."""

from collections.abc import Sequence
from math import pi

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LogError
from lwr_dyn.identification.logs.log_columns import UNITS, LogColumn
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind

STEPS = (5e-5, 0.5)
"""Seconds between rows a log of a moving arm may have; ms declared as s gives 10, s declared as ms 1e-5."""
TURNS = 3.0
"""Turns a joint without known limits may make before its angles look like degrees."""
MARGIN = 0.2
"""[rad or m] past a limit that a log may show: the arm's mechanical stops are no hard walls."""
OVERLOAD = 3.0
"""Times its limit that a torque may reach in a log."""
AGREEMENT = 1.5
"""Factor by which measured speeds may miss the slope of the positions; deg for rad is 57."""
DEGREES = 4.0
"""Times its limit beyond which an angle looks like degrees: 57 in a motion through the whole range; arms reach 3."""
MOVED = 1e-3
"""[rad or m] a joint must travel in all before its speed is compared."""


def check_arm(file: str, joints: tuple[int, ...], arm: Arm) -> None:
    """Every joint of the arm must be in the log; raises `LogError`."""
    wanted = tuple(range(1, arm.n + 1))
    if joints != wanted:
        found = f"joints {', '.join(map(str, joints))}"
        raise LogError(file, "columns", found, f"q1..q{arm.n} and tau1..tau{arm.n}, the joints of {arm.name}")


def check_log(file: str, lines: int, columns: Sequence[LogColumn], table: Array, arm: Arm | None) -> None:
    """Judge a table (k, columns) as it stands in the file, before its units are converted; raises `LogError`."""
    _check_finite(file, lines, columns, table)
    _check_times(file, lines, columns[0], table[:, 0])
    q = {c.joint: i for i, c in enumerate(columns) if c.quantity == "q"}
    for i, column in enumerate(columns):
        if column.quantity == "q":
            _check_position(file, column, table[:, i], arm)
        elif column.quantity == "tau":
            _check_torque(file, column, table[:, i], arm)
        elif column.quantity == "dq" and column.joint in q:
            position = columns[q[column.joint]]
            travel = table[:, q[column.joint]] * position.factor
            _check_speed(file, column, position, table[:, 0] * columns[0].factor, travel, table[:, i])


def _row(lines: int, index: int) -> str:
    return f"row {index + 1} (line {index + 1 + lines})" if lines else f"row {index + 1}"


def _check_finite(file: str, lines: int, columns: Sequence[LogColumn], table: Array) -> None:
    if np.isfinite(table.sum()):  # one NaN makes the sum NaN; an infinity makes it infinite or NaN
        return
    finite = np.isfinite(table)
    if not finite.all():
        bad = np.flatnonzero(~finite.all(axis=1))
        row, column = int(bad[0]), columns[int(np.argmin(finite[bad[0]]))]
        found = f"{table[row, int(np.argmin(finite[row]))]}" + (f" ({bad.size} such rows)" if bad.size > 1 else "")
        raise LogError(
            file, f"{_row(lines, row)}, column {column.shown}", found, "finite numbers; drop or repair the rows"
        )


def _check_times(file: str, lines: int, column: LogColumn, time: Array) -> None:
    if time.size < 2:
        raise LogError(file, "rows", f"{time.size}", "a recording of at least a second")
    steps = np.diff(time)
    bad = np.flatnonzero(steps <= 0.0)
    if bad.size:
        row = int(bad[0]) + 1
        found = (
            "repeats the time before" if steps[row - 1] == 0.0 else f"goes back by {-steps[row - 1]:.6g} {column.unit}"
        )
        where = f"{_row(lines, row)}, column time"
        raise LogError(file, where, f"{time[row]:.10g} {column.unit} {found}", "times that rise from row to row")
    step = float(np.median(steps)) * column.factor
    if not STEPS[0] <= step <= STEPS[1]:
        found = f"{step:.3g} s from row to row, as [{column.unit}] is declared"
        fits = next((unit for unit, factor in UNITS["time"].items()
                     if column.unit == "s" and STEPS[0] <= step * factor <= STEPS[1]), None)  # fmt: skip
        needed = f"{STEPS[0]:g} to {STEPS[1]:g} s; declare the unit it is in{f' ({fits} would fit)' if fits else ''}"
        raise LogError(file, "column time", found, needed)


def _check_position(file: str, column: LogColumn, values: Array, arm: Arm | None) -> None:
    low, high = float(values.min()) * column.factor, float(values.max()) * column.factor
    lower, upper, whose = -2 * pi * TURNS, 2 * pi * TURNS, f"within {TURNS:g} turns (or a robot with its limits)"
    if column.unit in ("m", "mm"):
        lower, upper = -np.inf, np.inf
    if arm is not None:
        j = column.joint - 1
        lower, upper = float(arm.lower[j]) - MARGIN, float(arm.upper[j]) + MARGIN
        whose = f"{arm.lower[j]:.4g} to {arm.upper[j]:.4g}, the limits of {arm.joint_names[j]}"
    if low < lower or high > upper:
        unit = "m" if _slides(column, arm) else "rad"
        found = f"{low:.4g} to {high:.4g} {unit}, as [{column.unit}] is declared"
        scale = UNITS["q"]["deg"]
        fits = column.unit == "rad" and low * scale >= lower and high * scale <= upper
        far = max(high / upper if upper > 0.0 else 0.0, low / lower if lower < 0.0 else 0.0) > DEGREES
        other = "" if arm is None else ", or take the robot that it is a log of"
        needed = f"{whose}; declare the unit it is in{' (deg would fit)' if fits and far else other}"
        raise LogError(file, f"column {column.shown}", found, needed)


def _check_torque(file: str, column: LogColumn, values: Array, arm: Arm | None) -> None:
    if arm is None:
        return
    limit = float(arm.effort[column.joint - 1])
    peak = max(float(values.max()), -float(values.min())) * column.factor
    if peak > OVERLOAD * limit:
        unit = "N" if _slides(column, arm) else "N m"
        found = f"reaches {peak:.4g} {unit}, as [{column.unit}] is declared"
        needed = f"at most {OVERLOAD:g} times {limit:g} {unit}, the limit of {arm.joint_names[column.joint - 1]}"
        fits = column.unit in ("N m", "Nm") and peak * UNITS["tau"]["mN m"] <= OVERLOAD * limit
        needed += f"; declare the unit it is in{' (mN m would fit)' if fits else ''}"
        raise LogError(file, f"column {column.shown}", found, needed)


def _check_speed(file: str, column: LogColumn, position: LogColumn, t: Array, q: Array, dq: Array) -> None:
    """Measured speeds against the slope of the positions, over spans of a tenth of a second."""
    span = max(1, round(0.1 / float(np.median(np.diff(t)))))
    slope = np.diff(q[::span]) / np.diff(t[::span])
    if slope.size < 2 or np.abs(np.diff(q[::span])).sum() < MOVED:
        return
    total = np.concatenate([[0.0], np.cumsum((dq[1:] + dq[:-1]) / 2 * np.diff(t))])[::span]
    mean = np.diff(total) / np.diff(t[::span]) * column.factor
    ratio = float((mean @ slope) / (slope @ slope))
    if not 1 / AGREEMENT < ratio < AGREEMENT:
        found = (
            f"{ratio:.4g} times the slope of {position.shown}, as [{column.unit}] and [{position.unit}] are declared"
        )
        raise LogError(
            file, f"column {column.shown}", found, "velocities of the same joint; declare the units they are in"
        )


def _slides(column: LogColumn, arm: Arm | None) -> bool:
    return arm is not None and arm.chain.links[column.joint - 1].kind is JointKind.PRISMATIC
