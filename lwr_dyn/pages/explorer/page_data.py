"""What the page knows of an arm, as JSON values: its kinematics, bodies and inertial parameters.

`arm` and `bodies` are all that kinematics.js needs. Poses are 16 numbers, column after column; lengths in m, angles in
rad; null is unknown.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.dynamics.unknown_inertia import chain_with_dynamics
from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.installation import names_of_ends
from lwr_dyn.model.run import Run
from lwr_dyn.model.spatial import Pose
from lwr_dyn.pages.explorer.inertia_shape import inertia_ellipsoid, no_ellipsoid
from lwr_dyn.pages.replay import scene

_HALF_TURN, _SLIDE = float(np.pi), 1.0
"""Ends of a slider of a joint without known limits: [rad] of a turning joint, [m] of a sliding one."""
ORDER = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
"""Entries of a tensor among a link's inertial parameters, as `lwr_dyn.codegen.kernels` has them."""
_ROUNDING = 1e-9
"""[rad or m] by which a position may be outside its limits: one in whole degrees at a limit in rad."""


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


def inertial_record(arm: Arm) -> dict[str, Any]:
    """What the dynamics of an arm are computed with; of an arm without masses null.

    `inertia`: ten parameters of each link in its frame of the chain (m, m c, tensor about its origin as `ORDER`);
    `rotors`: of each joint [kg m^2 or kg]; `carrier`: the flange in the last link's frame, where a payload is added.
    """
    try:
        chain = chain_with_dynamics(arm)
    except MissingDataError:
        return {"inertia": None, "rotors": None, "carrier": None}
    rows = [body_parameters(link.body or Body.massless(), ORDER) for link in chain.links]
    return {
        "inertia": [float(x) for row in rows for x in row],
        "rotors": arm.armature.tolist(),
        "carrier": scene.column_major(chain.flange),
    }


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
