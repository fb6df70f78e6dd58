"""Relative motions: from the step that is programmed to the point where the motion ends."""

from __future__ import annotations

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.running.values import StructValue, Value, is_axes, pose_matrix, pose_value


def absolute_point(step: Value, now: StructValue, frame: str | None) -> StructValue:
    """The point at a step from where the arm stands: axes and components are added, in #TOOL poses are multiplied.

    Raises `ExecutionError`.
    """
    if not isinstance(step, StructValue):
        raise ExecutionError("type", "a relative motion to what is no structure", "{X 10} or {A1 10}")
    if not is_axes(step) and frame is not None and frame.upper() == "TOOL":
        whole = StructValue("FRAME", {**dict.fromkeys("XYZABC", 0.0), **step.parts})
        return pose_value(pose_matrix(now, "where the arm stands") @ pose_matrix(whole, "the step"), "FRAME")
    parts = dict(now.parts)
    for name, change in step.parts.items():
        before = parts.get(name, 0.0)
        if isinstance(before, int | float) and isinstance(change, int | float):
            parts[name] = before + change
    if not is_axes(step):
        parts = {name: parts[name] for name in "XYZABC"}
    return StructValue(now.type if is_axes(step) else "FRAME", parts)
