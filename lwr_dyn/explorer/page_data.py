"""What the page knows of an arm, as JSON values: its kinematics and bodies, and apart from them what is drawn.

`arm` and `bodies` are all that kinematics.js needs; `stage` holds the shapes, as meshcat commands. Poses are 16
numbers, column after column; lengths in m, angles in rad; null is unknown.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, fixed_array
from lwr_dyn.errors import OptionError
from lwr_dyn.explorer.inertia_shape import inertia_ellipsoid, no_ellipsoid
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.installation import names_of_ends
from lwr_dyn.model.run import Run
from lwr_dyn.model.spatial import Pose
from lwr_dyn.viewer import scene
from lwr_dyn.viewer.page_parts import generator_line
from lwr_dyn.viewer.replay_page import run_record
from lwr_dyn.viewer.replayed_runs import replayed_runs

SCHEMA = 1
_HALF_TURN, _SLIDE = float(np.pi), 1.0
"""Ends of a slider of a joint without known limits: [rad] of a turning joint, [m] of a sliding one."""
_ROUNDING = 1e-9
"""[rad or m] by which a position may be outside its limits: one in whole degrees at a limit in rad."""


def explorer_data(arm: Arm, q: ArrayLike | None = None) -> dict[str, Any]:
    """The data of an arm's page, with the pose at the start, q (n,) [rad or m]; `start_pose` if not given.

    Raises
    ------
    ShapeError, OptionError
        q of another shape, or outside the limits.
    """
    start = start_pose(arm, q)
    return {
        "schema": SCHEMA,
        "arm": arm_record(arm),
        "bodies": [body_record(body) for body in arm.bodies()],
        "start": start.tolist(),
        "stage": _stage(arm, start),
        "made_by": generator_line(),
    }


def arm_record(arm: Arm) -> dict[str, Any]:
    """The arm's kinematics: joints in URDF frames, the flange in the last link, gravity in the first frame [m/s^2]."""
    first, last = names_of_ends(arm.installation)
    ranges = slider_ranges(arm)
    return {
        "name": arm.name,
        "reading": arm.reading,
        "joints": [
            {
                "name": joint.name,
                "kind": joint.kind.value,
                "origin": scene.column_major(joint.origin),
                "lower": joint.limits.lower,
                "upper": joint.limits.upper,
                "slider": ranges[i],
            }
            for i, joint in enumerate(arm.joints())
        ],
        "flange": scene.column_major(arm.flange()),
        "native": [scene.column_major(link.after) for link in arm.chain.links] if has_frames_of_its_own(arm) else None,
        "gravity": arm.chain.gravity.tolist(),
        "ends": [first, last],
    }


def has_frames_of_its_own(arm: Arm) -> bool:
    """Whether the source's frames (of a DH table) are other than the URDF's."""
    return not all(link.after.is_identity() for link in arm.chain.links)


def body_record(body: Body | None) -> dict[str, Any]:
    """A link's body in its URDF frame, with its ellipsoid as the image of the unit sphere, or why it has none."""
    if body is None:
        return {"mass": None, "ellipsoid": None, "why": no_ellipsoid(body)}
    record = {"mass": body.mass, "com": body.com.tolist(), "inertia": body.inertia_com.tolist()}
    shape = inertia_ellipsoid(body)
    if shape is None:
        return record | {"ellipsoid": None, "why": no_ellipsoid(body)}
    return record | {"ellipsoid": scene.column_major(Pose(shape.axes * shape.semi_axes, body.com))}


def motor_limits(arm: Arm) -> list[float | None]:
    """Each joint's largest torque [N m or N]; None is unknown."""
    return [joint.limits.effort for joint in arm.joints()]


def slider_ranges(arm: Arm) -> list[tuple[float, float]]:
    """Both ends of each joint's slider [rad or m]: its limits, and where one is unknown half a turn or a metre."""
    out = []
    for joint in arm.joints():
        low, up = joint.limits.lower, joint.limits.upper
        span = _HALF_TURN if joint.kind is JointKind.REVOLUTE else _SLIDE
        low = min(-span, up or 0.0) if low is None else low
        out.append((low, max(span, low) if up is None else up))
    return out


def start_pose(arm: Arm, q: ArrayLike | None = None) -> Array:
    """The positions at the start, (n,) [rad or m]: as given, or zero, moved into the limits where they exclude it.

    Raises
    ------
    ShapeError
        q that is not (n,) or not finite.
    OptionError
        A position outside its limits.
    """
    if q is None:
        return np.clip(np.zeros(arm.n), arm.lower, arm.upper)
    given = fixed_array("q", q, (arm.n,))
    for joint, x in zip(arm.joints(), given, strict=True):
        low, up = joint.limits.lower, joint.limits.upper
        if (low is not None and x < low - _ROUNDING) or (up is not None and x > up + _ROUNDING):
            allowed = f"its limits, {position_text(joint.kind, low)} to {position_text(joint.kind, up)}"
            raise OptionError(f"q of {joint.name}", position_text(joint.kind, float(x)), allowed)
    return given


def position_text(kind: JointKind, x: float | None) -> str:
    """A position in the units of the command line: deg, of a sliding joint m; "unknown" for None."""
    if x is None:
        return "unknown"
    return f"{np.degrees(x):.6g} deg" if kind is JointKind.REVOLUTE else f"{x:.6g} m"


def pose_as_run(arm: Arm, q: Array) -> Run:
    """A pose as a run of one sample, which is what the stage draws."""
    nothing, zero = np.zeros((1, arm.n)), np.zeros(1)
    return Run(zero, q[None], nothing, q[None], nothing, nothing, nothing, nothing, zero, {})


def _stage(arm: Arm, q: Array) -> dict[str, Any]:
    (shown,) = replayed_runs([pose_as_run(arm, q)], arm, [arm.name])
    commands: Sequence[Any] = list(scene.arm_commands(shown, 0))
    return {"scene": commands, "runs": [run_record(shown)]}
