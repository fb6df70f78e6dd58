"""From a programmed point to axes: reach, limits, Status and Turn, each with a diagnosis that says by how much."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.kuka_pose import status, turn
from lwr_dyn.kinematics.solution import InverseResult, Solution, nearest_solution
from lwr_dyn.krl.values import AXIS_NAMES, PLACE_NAMES, HaltError, Struct, Value, is_axes, is_pose, pose_matrix, said
from lwr_dyn.model.arm import Arm

TOUCH = 1e-9
"""[rad] A limit is kept to rounding."""
Say = Callable[[str, str, str, str], None]
"""severity, code, message, hint"""


@dataclass(frozen=True, slots=True, eq=False)
class Where:
    """Where the arm stands: q (n,) [rad], None before the first motion; base and tool (4, 4) [m]."""

    arm: Arm
    q: Array | None
    base: Array
    tool: Array
    pose: Struct | None
    """The pose of the tool in the base that components left out are taken from."""


def axes_of_point(where: Where, point: Value, first: bool, say: Say) -> Array | None:
    """The axes (n,) [rad] of a PTP's point; None where it cannot be reached, which is said."""
    if not isinstance(point, Struct):
        raise HaltError("type", f"the target is {said(point)}", "a POS, E6POS, AXIS or E6AXIS")
    _external_axes(point, say)
    if is_axes(point):
        return _axes(where, point, first, say)
    if not is_pose(point):
        raise HaltError("type", f"the target is {said(point)}", "a POS, E6POS, AXIS or E6AXIS")
    s, t = _whole(point, "S"), _whole(point, "T")
    _completeness(point, first, s, t, say)
    return _posed(where, flange_of_point(where, point), s, t, say)


def flange_of_point(where: Where, point: Struct) -> Array:
    """The flange (4, 4) [m] in the arm's base at which the tool is at a point."""
    return np.asarray(point_in_world(where, point) @ np.linalg.inv(where.tool))


def point_in_world(where: Where, point: Struct) -> Array:
    """The pose (4, 4) [m] of the tool at a point; components left out stay as they are."""
    parts = dict(where.pose.parts) if where.pose is not None else {}
    parts |= {name: value for name, value in point.parts.items() if name in PLACE_NAMES}
    return np.asarray(where.base @ pose_matrix(Struct("FRAME", parts), "the target"))


def _axes(where: Where, point: Struct, first: bool, say: Say) -> Array | None:
    missing = [name for name in AXIS_NAMES if name not in point.parts]
    if missing and first:
        _not_full(", ".join(missing), say)
    if missing and where.q is None:
        return None
    now = np.zeros(where.arm.n) if where.q is None else where.q
    values = [_number(point, name) for name in AXIS_NAMES]
    q = np.array([now[i] if x is None else np.radians(x) for i, x in enumerate(values)])
    fine = True
    for i, name in enumerate(where.arm.joint_names):
        over = max(q[i] - where.arm.upper[i], where.arm.lower[i] - q[i])
        if over > TOUCH:
            low, up = np.degrees([where.arm.lower[i], where.arm.upper[i]])
            message = f"{name} = {np.degrees(q[i]):.6g} deg is outside its range by {np.degrees(over):.4g} deg"
            say("error", "outside-limits", message, f"from {low:.6g} to {up:.6g} deg")
            fine = False
    return q if fine else None


def _completeness(point: Struct, first: bool, s: int | None, t: int | None, say: Say) -> None:
    missing = [name for name in PLACE_NAMES if name not in point.parts]
    lacks = [name for name, value in (("S", s), ("T", t)) if value is None]
    if first and (missing or lacks):
        _not_full(", ".join([*missing, *lacks]), say)
    elif lacks:
        said_ = f"the point has no {' and no '.join(lacks)}: the arm takes the solution nearest to where it stands"
        say("warning", "no-status-turn", said_, "give S and T, as a taught point has them")


def _not_full(missing: str, say: Say) -> None:
    hint = "begin with a PTP to all six axes, or to X, Y, Z, A, B, C, S, T"
    say("error", "first-motion", f"the first motion is not to a full position: {missing} missing", hint)


def _posed(where: Where, T: Array, s: int | None, t: int | None, say: Say) -> Array | None:
    inside_robot(where.arm, T, say)
    found = inverse_kinematics(where.arm, T)
    if found.status != "solved":
        unreachable(where.arm, found, s, say)
        return None
    chosen = _by_status(where, found, s, t, say)
    if not chosen:
        return None
    best = chosen[0] if where.q is None else nearest_solution(chosen, where.q)
    if s is None and where.q is not None:
        kept = [x for x in chosen if status(where.arm, x.q) == status(where.arm, where.q)]
        best = nearest_solution(kept or chosen, where.q)
    return np.array(best.q)


def unreachable(arm: Arm, found: InverseResult, s: int | None, say: Say) -> None:
    """Say why a pose has no solution: by how much it is out of reach, or which axis leaves its range by how much."""
    if found.status == "out of reach":
        message = f"the point is out of reach by {1e3 * (found.distance or 0.0):.4g} mm"
        say("error", "out-of-reach", message, "the wrist centre must stay within reach")
        return
    best = next((x for x in found.outside if s is not None and status(arm, x.q) == s), found.outside[0])
    message = f"{best.joint} leaves its range by {np.degrees(-best.margin):.4g} deg there"
    say("error", "outside-limits", message, f"the best of {len(found.outside)} solutions; none is inside the limits")


def _by_status(where: Where, found: InverseResult, s: int | None, t: int | None, say: Say) -> Sequence[Solution]:
    arm = where.arm
    of_status = [x for x in found.solutions if s is None or status(arm, x.q) == s & 7]
    chosen = [x for x in of_status if t is None or turn(x.q) == t & 63]
    if chosen:
        return chosen
    pairs = sorted({(status(arm, x.q), turn(x.q)) for x in found.solutions})
    there = "; ".join(f"S {a} T {b}" for a, b in pairs)
    if not of_status:
        outside = [x for x in found.outside if status(arm, x.q) == (s or 0) & 7]
        why = "is outside the limits" if outside else "does not exist"
        if outside:
            why += f" ({outside[0].joint} by {np.degrees(-outside[0].margin):.4g} deg)"
        say("error", "status-turn", f"the solution with S {s} {why} at this point", f"there are {there}")
    else:
        message = f"no solution with S {'any' if s is None else s} has T {t}: S and T disagree with the point"
        say("error", "status-turn", message, f"there are {there}")
    return ()


def inside_robot(arm: Arm, T: Array, say: Say) -> None:
    """Say so when the flange would be inside the robot's own base, or the wrist under the floor."""
    point = T[:3, 3]
    for c in arm.drawing.cylinders:
        a, b = np.array(c.start), np.array(c.end)
        way = b - a
        along = float((point - a) @ way / (way @ way))
        aside = float(np.linalg.norm(point - a - along * way))
        if c.link == "base" and 0.0 <= along <= 1.0 and aside <= c.radius:
            x, y, z = 1e3 * point + 0.0
            message = f"the flange at ({x:.6g}, {y:.6g}, {z:.6g}) mm is inside the robot's own base"
            say("error", "inside-robot", message, "mastering is a set of axes: {A1 0, A2 -90, A3 90, A4 0, A5 0, A6 0}")
            return


def _external_axes(point: Struct, say: Say) -> None:
    moved = [n for n in ("E1", "E2", "E3", "E4", "E5", "E6") if point.parts.get(n) not in (None, 0, 0.0)]
    if moved:
        say("note", "external-axes", f"{', '.join(moved)} not moved: the model has six axes", "")


def _number(point: Struct, name: str) -> float | None:
    value = point.parts.get(name)
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None


def _whole(point: Struct, name: str) -> int | None:
    value = _number(point, name)
    return None if value is None else int(value)
