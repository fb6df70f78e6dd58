"""From a programmed point to axes: reach, limits, Status and Turn, with diagnostics of faults and their distance.

Of a relative motion the point where it ends; of a path how the orientation is led ($ORI_TYPE, $CIRC_TYPE, $IPO_MODE).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.solution import InverseResult, nearest_solution
from lwr_dyn.kinematics.solution_rows import Solution
from lwr_dyn.krl.diagnostics import ExecutionError, Report
from lwr_dyn.krl.robot.kuka_pose import status, turn
from lwr_dyn.krl.running import values as v
from lwr_dyn.krl.running.controller import ControllerState
from lwr_dyn.krl.running.values import AXIS_NAMES, POSE_NAMES, EnumValue, StructValue, Value
from lwr_dyn.model.arm import Arm

TOUCH = 1e-9
"""[rad] Rounding allowed at a limit."""


@dataclass(frozen=True, slots=True, eq=False)
class RobotState:
    """The arm and its axes q (n,) [rad], None before the first motion; base and tool (4, 4) [m]."""

    arm: Arm
    q: Array | None
    base: Array
    tool: Array
    pose: StructValue | None
    """The pose of the tool in the base, for components that a point leaves out."""
    ignores_turn: bool = False
    """Whether the nearest solution is taken in place of the one with the Turn of a point."""


def axes_of_point(robot: RobotState, point: Value, first: bool, report: Report) -> Array | None:
    """The axes (n,) [rad] of a PTP's point; None where it cannot be reached, which is reported."""
    if not isinstance(point, StructValue) or not (point.is_axes or point.is_pose):
        raise ExecutionError("type", f"the target is {v.value_text(point)}", "a POS, E6POS, AXIS or E6AXIS")
    _note_external_axes(point, report)
    if point.is_axes:
        return _axes(robot, point, first, report)
    s, t = _whole(point, "S"), _whole(point, "T")
    _check_complete(point, first, s, t, report)
    t = None if robot.ignores_turn else t
    flange = np.asarray(point_in_world(robot, point) @ np.linalg.inv(robot.tool))
    return _axes_of_flange(robot, flange, s, t, report)


def point_in_world(robot: RobotState, point: StructValue) -> Array:
    """The pose (4, 4) [m] of the tool at a point; components left out keep their present values."""
    parts = dict(robot.pose.parts) if robot.pose is not None else {}
    parts |= {name: value for name, value in point.parts.items() if name in POSE_NAMES}
    return np.asarray(robot.base @ v.pose_matrix(StructValue("FRAME", parts), "the target"))


def _axes(robot: RobotState, point: StructValue, first: bool, report: Report) -> Array | None:
    arm = robot.arm
    missing = [name for name in AXIS_NAMES if name not in point.parts]
    if missing and first:
        _report_incomplete(", ".join(missing), report)
    if missing and robot.q is None:
        return None
    now = np.zeros(arm.n) if robot.q is None else robot.q
    values = [_number(point, name) for name in AXIS_NAMES]
    q = np.array([now[i] if x is None else np.radians(x) for i, x in enumerate(values)])
    outside = np.maximum(q - arm.upper, arm.lower - q)
    for i in np.flatnonzero(outside > TOUCH):
        low, up = np.degrees([arm.lower[i], arm.upper[i]])
        place = f"{arm.joint_names[i]} = {np.degrees(q[i]):.6g} deg"
        message = f"{place} is outside its range by {np.degrees(outside[i]):.4g} deg"
        report("error", "outside-limits", message, f"from {low:.6g} to {up:.6g} deg")
    return None if (outside > TOUCH).any() else q


def _check_complete(point: StructValue, first: bool, s: int | None, t: int | None, report: Report) -> None:
    missing = [name for name in POSE_NAMES if name not in point.parts]
    lacks = [name for name, value in (("S", s), ("T", t)) if value is None]
    if first and (missing or lacks):
        _report_incomplete(", ".join([*missing, *lacks]), report)
    elif lacks:
        message = f"the point has no {' and no '.join(lacks)}: the arm takes the solution nearest to where it stands"
        report("warning", "no-status-turn", message, "give S and T, as a taught point has them")


def _report_incomplete(missing: str, report: Report) -> None:
    hint = "begin with a PTP to all six axes, or to X, Y, Z, A, B, C, S, T"
    report("error", "first-motion", f"the first motion is not to a full position: {missing} missing", hint)


def _axes_of_flange(robot: RobotState, T: Array, s: int | None, t: int | None, report: Report) -> Array | None:
    arm, now = robot.arm, robot.q
    _check_outside_base(arm, T, report)
    result = inverse_kinematics(arm, T)
    if result.status != "solved":
        _report_unreachable(arm, result, s, report)
        return None
    matching = _matching(arm, result, s, t, report)
    if not matching:
        return None
    if now is None:
        return np.array((matching[0] if t is not None else nearest_solution(matching, np.zeros(arm.n))).q)
    if s is None:
        matching = [x for x in matching if status(arm, x.q) == status(arm, now)] or matching
    return np.array(nearest_solution(matching, now).q)


def _report_unreachable(arm: Arm, result: InverseResult, s: int | None, report: Report) -> None:
    """Report by how much a pose is out of reach, or which axis leaves its range by how much."""
    if result.status == "out of reach":
        message = f"the point is out of reach by {1e3 * (result.distance or 0.0):.4g} mm"
        report("error", "out-of-reach", message, "the wrist centre must stay within reach")
        return
    outside = result.outside
    best = next((x for x in outside if s is not None and status(arm, x.q) == s), outside[0])
    message = f"{best.joint} leaves its range by {np.degrees(-best.margin):.4g} deg there"
    report("error", "outside-limits", message, f"the best of {len(outside)} solutions; none is inside the limits")


def _matching(arm: Arm, result: InverseResult, s: int | None, t: int | None, report: Report) -> Sequence[Solution]:
    """The solutions with this Status and Turn; none is reported."""
    of_status = [x for x in result.solutions if s is None or status(arm, x.q) == s & 7]
    matching = [x for x in of_status if t is None or turn(x.q) == t & 63]
    if matching:
        return matching
    pairs = sorted({(status(arm, x.q), turn(x.q)) for x in result.solutions})
    there = "; ".join(f"S {a} T {b}" for a, b in pairs)
    if not of_status:
        outside = [x for x in result.outside if status(arm, x.q) == (s or 0) & 7]
        why = "is outside the limits" if outside else "does not exist"
        if outside:
            why += f" ({outside[0].joint} by {np.degrees(-outside[0].margin):.4g} deg)"
        report("error", "status-turn", f"the solution with S {s} {why} at this point", f"there are {there}")
    else:
        message = f"no solution with S {'any' if s is None else s} has T {t}: S and T disagree with the point"
        report("error", "status-turn", message, f"there are {there}")
    return ()


def _check_outside_base(arm: Arm, T: Array, report: Report) -> None:
    """Report a flange (4, 4) [m] inside the robot's own base."""
    point = T[:3, 3]
    for c in arm.drawing.cylinders:
        a, b = np.array(c.start), np.array(c.end)
        way = b - a
        along = float((point - a) @ way / (way @ way))
        aside = float(np.linalg.norm(point - a - along * way))
        if c.link == "base" and 0.0 <= along <= 1.0 and aside <= c.radius:
            x, y, z = 1e3 * point + 0.0
            message = f"the flange at ({x:.6g}, {y:.6g}, {z:.6g}) mm is inside the robot's own base"
            hint = "mastering is a set of axes: {A1 0, A2 -90, A3 90, A4 0, A5 0, A6 0}"
            report("error", "inside-robot", message, hint)
            return


def _note_external_axes(point: StructValue, report: Report) -> None:
    moved = [n for n in ("E1", "E2", "E3", "E4", "E5", "E6") if point.parts.get(n) not in (None, 0, 0.0)]
    if moved:
        report("note", "external-axes", f"{', '.join(moved)} not moved: the model has six axes", "")


def _number(point: StructValue, name: str) -> float | None:
    value = point.parts.get(name)
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None


def _whole(point: StructValue, name: str) -> int | None:
    """S or T; raises `ExecutionError` for a number that is none, as a cell file may give it."""
    value = _number(point, name)
    if value is not None and not math.isfinite(value):
        raise ExecutionError("type", f"{name} is {value}", "a whole number")
    return None if value is None else int(value)


def absolute_point(step: Value, now: StructValue, frame: str | None) -> StructValue:
    """The point at a step from where the arm stands: axes and components are added, in #TOOL poses are multiplied.

    Raises `ExecutionError`.
    """
    if not isinstance(step, StructValue):
        raise ExecutionError("type", "a relative motion to what is no structure", "{X 10} or {A1 10}")
    if not step.is_axes and frame is not None and frame.upper() == "TOOL":
        whole = StructValue("FRAME", {**dict.fromkeys("XYZABC", 0.0), **step.parts})
        return v.pose_value(v.pose_matrix(now, "where the arm stands") @ v.pose_matrix(whole, "the step"), "FRAME")
    parts = dict(now.parts)
    for name, change in step.parts.items():
        before = parts.get(name, 0.0)
        if isinstance(before, int | float) and isinstance(change, int | float):
            parts[name] = before + change
    if not step.is_axes:
        parts = {name: parts[name] for name in "XYZABC"}
    return StructValue(now.type if step.is_axes else "FRAME", parts)


TURNED = {
    "$ORI_TYPE": ("JOINT", "the orientation of LIN and CIRC turns about one axis, as with #VAR"),
    "$CIRC_TYPE": ("PATH", "the orientation of CIRC is led as with #BASE"),
    "$IPO_MODE": ("TCP", "a fixed tool is not modelled: as with #BASE"),
}
"""Values of system variables that are not modelled, and what is done instead."""


def led_pose(c: ControllerState, start: Array, end: Array) -> Array:
    """The pose (4, 4) [m] at the end of a path from `start`; $ORI_TYPE #CONSTANT keeps the orientation."""
    values = {name: c.variables[name].value for name in TURNED if name in c.variables}
    for name, (value, text) in TURNED.items():
        if values.get(name) == EnumValue(value):
            c.assume(f"{name} #{value}", "", text)
    if values.get("$ORI_TYPE") != EnumValue("CONSTANT"):
        return end
    kept = end.copy()
    kept[:3, :3] = start[:3, :3]
    return kept
