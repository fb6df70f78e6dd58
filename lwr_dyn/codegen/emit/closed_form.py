"""Closed-form inverse kinematics as C and JavaScript: S-R-S arms with an arm angle, six joints with a spherical wrist.

Numbers are double in every file, also beside functions of float.
"""

from collections.abc import Callable
from functools import partial
from importlib.resources import files
from typing import Any

import numpy as np

from lwr_dyn.codegen.emit.closed_form_cases import case_of_six_joints, case_of_srs
from lwr_dyn.codegen.emit.closed_form_vectors import NAME, vectors_of_six_joints, vectors_of_srs
from lwr_dyn.codegen.emit.functions import TemplateCase, TemplateFunction
from lwr_dyn.codegen.emit.own_angles import angle_constants, with_own_angles
from lwr_dyn.codegen.emit.restricted_c import c_text, declarations, javascript_text, used_functions
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.arm_geometry import SRS_ARM, SrsGeometry, srs_geometry
from lwr_dyn.kinematics.branches import joint_ranges
from lwr_dyn.kinematics.six_joints.six_joint_geometry import WRIST_ARM, SixJointGeometry, wrist_arm_geometry
from lwr_dyn.kinematics.srs_margins import UNLIMITED
from lwr_dyn.model.arm import Arm

SRS_FUNCTIONS = (NAME, f"{NAME}_arm_angle", f"{NAME}_intervals", f"{NAME}_near")
SIX_JOINT_FUNCTIONS = (NAME, f"{NAME}_near")
MOST_INTERVALS = 16
"""On one branch: each of 24 crossings ends at most one interval, each of 4 alignments at most two."""
_ROWS = (
    "out: a row for each of the branches +++ ++- +-+ +-- -++ -+- --+ --- (signs of shoulder, elbow, wrist), every "
    "joint within half a turn of the middle of its range; limits are not looked at; beyond reach rows are NaN. Gives "
    "by how much the wrist is out of reach [m], 0 within. All numbers are double in every file."
)
_NEAR = "_near: the branch nearest to q_near (whole turns too) that is inside the limits. Gives 0; {0}3 out of reach."
SRS_TEXT = "\n".join([
    "q [rad] of the eight branches, in closed form, for a flange pose (4 x 4 row by row, m) and an arm angle [rad]",
    _ROWS,
    "_arm_angle: the arm angle of q [rad], then its signs of shoulder, elbow and wrist.",
    "_intervals: arm angles [rad] at which all joints keep a margin [rad] from their limits: for branch b, counts[b] "
    "pairs (start, end) from out[32 b] on; an end above pi wraps.",
    _NEAR.format("1 at another arm angle, the nearest that the limits allow; 2 outside the limits at all of them; "),
])  # fmt: skip
SIX_JOINT_TEXT = "\n".join([
    "q [rad] of the eight branches, in closed form, for a flange pose (4 x 4 row by row, m)",
    _ROWS,
    _NEAR.format("2 outside the limits; "),
])  # fmt: skip


def inverse_kinematics_function(spec: KernelSpec, name: str, arm: Arm) -> TemplateFunction:
    """The row of `EMITTED`; raises `OptionError` for an arm without a closed form."""
    srs, six = srs_geometry(arm.chain), wrist_arm_geometry(arm.chain)
    if srs is not None:
        source = _source("shared", "srs", "srs_intervals")
        constants = _of_srs(srs) | _of_joints(arm, srs)
        return _template(
            source, SRS_FUNCTIONS, SRS_TEXT, constants, case_of_srs(arm, srs), partial(vectors_of_srs, arm, srs)
        )
    if six is not None:
        source, constants = _source("shared", "six_joints"), _of_six(six) | _of_joints(arm, None)
        return _template(
            source, SIX_JOINT_FUNCTIONS, SIX_JOINT_TEXT, constants, case_of_six_joints(arm),
            partial(vectors_of_six_joints, arm),
        )  # fmt: skip
    raise OptionError(name, f"{arm.name} has no closed form that is written out", f"{SRS_ARM}, or {WRIST_ARM}")


def _source(*names: str) -> str:
    folder = files("lwr_dyn.codegen.emit")
    return "\n".join((folder / f"branches_{name}.c").read_text(encoding="utf-8") for name in names)


def _template(
    source: str, functions: tuple[str, ...], text: str, constants: dict[str, Any], test: str,
    vectors: Callable[[], tuple[TemplateCase, ...]],
) -> TemplateFunction:  # fmt: skip
    constants |= angle_constants()
    library, own = (used_functions(each, functions) for each in (source, with_own_angles(source)))
    texts = {"c": c_text(own, constants, "@NAME@"), "c libm": c_text(library, constants, "@NAME@")}
    texts |= {"js": javascript_text(own, constants), "js libm": javascript_text(library, constants)}
    heads = {"c": declarations(library, functions, "@NAME@"), "js": ", ".join(functions)}
    return TemplateFunction(NAME, text, heads, texts, {"c": test}, vectors)


def _of_joints(arm: Arm, srs: SrsGeometry | None) -> dict[str, Any]:
    ranges = joint_ranges(arm)
    numbers: dict[str, Any] = {
        "JOINTS": arm.n, "UNLIMITED": UNLIMITED, "MIDDLE": ranges.middle, "HALF": np.minimum(ranges.half, UNLIMITED),
        "NOWHERE": np.zeros(3),
    }  # fmt: skip
    if srs is None:
        return numbers
    offsets = np.array([srs.first.offset, 0.0, 0.0, 0.0, srs.last.offset])
    centre = ranges.middle + np.array([0.0, offsets[0], 0.0, 0.0, 0.0, offsets[4], 0.0])
    return numbers | {
        "MOST": MOST_INTERVALS, "OFFSETS": offsets, "CENTRE_COSINE": np.cos(centre), "CENTRE_SINE": np.sin(centre),
    }  # fmt: skip


def _of_srs(g: SrsGeometry) -> dict[str, Any]:
    return {
        "LENGTHS": np.array(g.lengths), "SHOULDER": g.shoulder, "UPPER": g.upper, "FORE": g.fore,
        "ELBOW_AXIS": g.elbow_axis, "STRAIGHT": g.straight, "WRIST_IN_FLANGE": g.wrist_in_flange,
        "HOME_BACK": g.home_rotation.T @ g.last.back, "FIRST_TURNED": g.first.basis.T, "FIRST_BACK": g.first.back,
        "FIRST_BASIS": g.first.basis, "FIRST_FRONT": g.first.back.T, "LAST_BASIS": g.last.basis,
        "REFERENCE": g.reference, "SPARE": np.eye(3)[int(np.argmin(np.abs(g.reference)))],
        "AXIS_Y": np.array([0.0, 1.0, 0.0]), "AXIS_Z": np.array([0.0, 0.0, 1.0]),
    }  # fmt: skip


def _of_six(g: SixJointGeometry) -> dict[str, Any]:
    return {
        "LENGTHS": np.array(g.lengths), "FRAME_TURNED": g.frame.T, "AXIS_1": g.frame[:, 2], "AXIS_2": g.frame[:, 1],
        "ORIGIN": g.origin, "LATERAL": g.lateral, "SHOULDER": g.shoulder,
        "LEAN": float(np.arctan2(g.upper[1], g.upper[0])),
        "ELBOW_SIGN": float(g.elbow_sign), "FRONT": float(g.front), "STRAIGHT": g.straight,
        "WRIST_IN_FLANGE": g.wrist_in_flange, "HOME_BACK": g.home_rotation.T @ g.ball.back,
        "BALL_BASIS": g.ball.basis, "OFFSET": g.ball.offset,
    }  # fmt: skip
