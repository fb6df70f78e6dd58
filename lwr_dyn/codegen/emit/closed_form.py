"""Closed-form inverse kinematics as C and JavaScript: S-R-S arms, six joints with spherical wrist or parallel axes.

Numbers are double in every file, also beside functions of float. Self-test and test vectors are a few calls, and what
Python finds.
"""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from lwr_dyn.codegen.emit import restricted_c
from lwr_dyn.codegen.emit.functions import Argument, TemplateCase, TemplateFunction
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.arm_geometry import SRS_ARM, SrsGeometry, srs_geometry
from lwr_dyn.kinematics.closed_forms.arm_numbers import numbers_of_srs
from lwr_dyn.kinematics.closed_forms.texts import ANGLE_NUMBERS, closed_form_text, used_functions, with_own_angles
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.six_joints.exact_arms import SixJointForm, six_joint_form
from lwr_dyn.kinematics.six_joints.snapped_arms import PARALLEL_ARM
from lwr_dyn.kinematics.six_joints.spherical_wrist import WRIST_ARM
from lwr_dyn.kinematics.solution import BRANCHES, joint_ranges
from lwr_dyn.kinematics.srs import arm_triangle, closed_form
from lwr_dyn.kinematics.srs_margins import intervals_at_level, margin_problem
from lwr_dyn.model.arm import Arm

NAME = "inverse_kinematics"

SRS_FUNCTIONS = (NAME, f"{NAME}_arm_angle", f"{NAME}_intervals", f"{NAME}_near")

SIX_JOINT_FUNCTIONS = (NAME, f"{NAME}_near")

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
    srs, six = srs_geometry(arm.chain), six_joint_form(arm)
    if srs is not None:
        return _template(
            closed_form_text("shared", "srs", "srs_intervals"), SRS_FUNCTIONS, SRS_TEXT, numbers_of_srs(arm, srs),
            case_of_srs(arm, srs), partial(vectors_of_srs, arm, srs),
        )  # fmt: skip
    if six is not None:
        return _template(
            closed_form_text(*six.texts, "six_joints_near"), SIX_JOINT_FUNCTIONS, SIX_JOINT_TEXT, six.numbers,
            case_of_six_joints(arm, six), partial(vectors_of_six_joints, arm, six),
        )  # fmt: skip
    allowed = f"{SRS_ARM}; {WRIST_ARM}; {PARALLEL_ARM}, to a billionth"
    raise OptionError(name, f"{arm.name} has no closed form that is written out", allowed)


def _template(
    source: str, functions: tuple[str, ...], text: str, constants: Mapping[str, Any], test: str,
    vectors: Callable[[], tuple[TemplateCase, ...]],
) -> TemplateFunction:  # fmt: skip
    constants = {**constants, **ANGLE_NUMBERS}
    library = used_functions(source, functions)
    texts = {}
    for kind, whole in (("", with_own_angles(source)), (" libm", source)):
        used = used_functions(whole, functions)
        texts[f"c{kind}"] = restricted_c.c_text(used, constants, "@NAME@")
        texts[f"js{kind}"] = restricted_c.javascript_text(used, constants)
    heads = {"c": restricted_c.declarations(library, functions, "@NAME@"), "js": ", ".join(functions)}
    return TemplateFunction(NAME, text, heads, texts, {"c": test}, vectors)


POSES = 3

TOLERANCE = 1e-9
"""[rad] Near a singularity angles lose digits."""

ARM_ANGLES = np.array([0.0, 0.7, -2.5])
"""[rad]"""

_TEST = """\
static int @NAME@_self_test(void)
{{
    static const double poses[{poses}][16] = {{{pose}}};
    static const double expected[{poses}][{width}] = {{{expected}}};
{angles}    double out[{width}];
    int failed = 0;
    int i;
    int j;
    for (i = 0; i < {poses}; i++) {{
        @NAME@(poses[i], {angle}out);
        for (j = 0; j < {width}; j++) {{
            const int both = isnan(out[j]) && isnan(expected[i][j]);
            failed += !both && !(fabs(out[j] - expected[i][j]) <= {tolerance});
        }}
    }}
    printf("@NAME@: %d angles differ\\n", failed);
    return failed;
}}
"""


def case_of_srs(arm: Arm, geometry: SrsGeometry) -> str:
    """Of an S-R-S arm."""
    T = poses(arm)
    return _text(T, branches(arm, geometry, T, ARM_ANGLES), ARM_ANGLES)


def case_of_six_joints(arm: Arm, form: SixJointForm) -> str:
    """Of an arm with a spherical wrist."""
    T = poses(arm)
    return _text(T, form.branches(T).q, None)


def positions(arm: Arm) -> Array:
    """Random positions inside the limits, (POSES, n)."""
    rng, ranges = np.random.default_rng(30), joint_ranges(arm)
    width = np.minimum(0.8 * ranges.half, 2.0)
    return np.asarray(ranges.middle + width * rng.uniform(-1.0, 1.0, (POSES, arm.n)))


def poses(arm: Arm) -> Array:
    """Their poses, (POSES, 4, 4)."""
    return flange_pose(arm.chain, positions(arm))


def branches(arm: Arm, geometry: SrsGeometry, T: Array, psi: Array) -> Array:
    """All branches at an arm angle each, (k, 8, n)."""
    q = [closed_form(geometry, joint_ranges(arm), T, psi, branch) for branch in BRANCHES]
    return np.stack(q, axis=1)


def _text(T: Array, q: Array, angles: Array | None) -> str:
    q = q.reshape(len(T), -1)
    listed = "" if angles is None else f"    static const double angles[{len(angles)}] = {{{_row(angles)}}};\n"
    return _TEST.format(
        poses=len(T), width=q.shape[1], pose=_rows(T.reshape(len(T), -1)), expected=_rows(q), angles=listed,
        angle="" if angles is None else "angles[i], ", tolerance=TOLERANCE,
    )  # fmt: skip


def _rows(rows: Array) -> str:
    return ",\n        ".join(f"{{{_row(row)}}}" for row in rows)


def _row(row: Array) -> str:
    numbers = ["(double)NAN" if x != x else repr(x) for x in row.tolist()]
    return ",\n        ".join(", ".join(numbers[i : i + 5]) for i in range(0, len(numbers), 5))


MARGIN = 0.05
"""[rad]"""

_FAR, _AWAY = 10.0, 1e-3

_POSE, _ARM_ANGLE = Argument("pose", 16, "4 x 4 row by row, m"), Argument("arm_angle", 1, "rad")


def vectors_of_srs(arm: Arm, geometry: SrsGeometry) -> tuple[TemplateCase, ...]:
    """Of the four functions of an S-R-S arm; one pose is out of reach."""
    T = poses(arm)
    q, excess = branches(arm, geometry, T, ARM_ANGLES), arm_triangle(geometry, T).reach_excess
    some = list(range(POSES))
    of_branches = np.column_stack([ARM_ANGLES, np.array(BRANCHES, dtype=np.float64)[some]])
    angles, position = [[float(x)] for x in (*ARM_ANGLES, 0.0)], Argument("q", arm.n, "rad")
    pairs = [_intervals(arm, geometry, pose) for pose in T]
    return (
        _all(T, q, (*excess, float(arm_triangle(geometry, _far(T)).reach_excess[0])), ((_ARM_ANGLE, angles),)),
        TemplateCase(f"{NAME}_arm_angle", ((position, q[some, some].tolist()),), "rad; signs of shoulder, elbow, wrist",
                     of_branches.tolist(), None, TOLERANCE),
        TemplateCase(f"{NAME}_intervals", ((_POSE, _flat(T)), (Argument("margin", 1, "rad"), [[MARGIN]] * POSES)),
                     "rad, pairs (start, end) of each branch", pairs, excess.tolist(), TOLERANCE),
        _near(arm, *_inside(arm, geometry, T)),
    )  # fmt: skip


def vectors_of_six_joints(arm: Arm, form: SixJointForm) -> tuple[TemplateCase, ...]:
    """Of the two functions of an arm with a spherical wrist; one pose is out of reach."""
    T = poses(arm)
    found, q = form.branches(T), positions(arm)
    beyond = form.branches(_far(T)).reach_excess.min()
    return (
        _all(T, found.q, (*found.reach_excess.min(axis=1), float(beyond)), ()),
        _near(arm, T, None, q),
    )


def _all(
    T: Array, q: Array, excess: tuple[float, ...], more: tuple[tuple[Argument, list[list[float]]], ...]
) -> TemplateCase:  # fmt: skip
    """All branches of some poses, and none of one far out."""
    rows = [*_flat(q), [math.nan] * q[0].size]
    pose = (_POSE, [*_flat(T), *_flat(_far(T))])
    return TemplateCase(NAME, (pose, *more), "rad", rows, [float(x) for x in excess], TOLERANCE)


def _near(arm: Arm, T: Array, psi: Array | None, q: Array) -> TemplateCase:
    """From close by, each position is found again."""
    angle = () if psi is None else ((_ARM_ANGLE, psi[:, None].tolist()),)
    start = (Argument("q_near", arm.n, "rad"), (q + _AWAY).tolist())
    return TemplateCase(f"{NAME}_near", ((_POSE, _flat(T)), *angle, start), "rad", q.tolist(), [0.0] * len(q),
                        TOLERANCE)  # fmt: skip


def _inside(arm: Arm, geometry: SrsGeometry, T: Array) -> tuple[Array, Array, Array]:
    """(pose, arm angle, position inside the limits) of each pose where one of some arm angles has one."""
    ranges = joint_ranges(arm)
    rows = []
    for pose in T:
        psi = np.linspace(-3.0, 3.0, 61)
        q = branches(arm, geometry, np.broadcast_to(pose, (len(psi), 4, 4)), psi)
        good = np.argwhere((np.abs(q - ranges.middle) < ranges.half).all(axis=-1))
        rows += [(pose, psi[k], q[k, b]) for k, b in good[len(good) // 2 :][:1]]
    return np.array([r[0] for r in rows]), np.array([r[1] for r in rows]), np.array([r[2] for r in rows])


def _intervals(arm: Arm, geometry: SrsGeometry, T: Array) -> list[list[tuple[float, float]]]:
    every = np.broadcast_to(T, (len(BRANCHES), 4, 4))
    problem = margin_problem(geometry, joint_ranges(arm), every, np.array(BRANCHES, dtype=np.float64))
    found = intervals_at_level(problem, MARGIN)
    return [[(float(a), float(b)) for a, b in found.of(k)] for k in range(len(BRANCHES))]


def _far(T: Array) -> Array:
    """The first pose, out of reach."""
    out = T[:1].copy()
    out[:, :3, 3] *= _FAR
    return out


def _flat(rows: Array) -> list[list[float]]:
    return [row.ravel().tolist() for row in rows]
