"""Closed-form inverse kinematics as C and JavaScript: S-R-S arms with an arm angle, six joints with a spherical wrist.

Numbers are double in every file, also beside functions of float. Self-test and test vectors are a few calls, and what
Python finds.
"""

import math
from collections.abc import Callable
from functools import partial
from importlib.resources import files
from typing import Any

import numpy as np

from lwr_dyn.codegen.emit import restricted_c
from lwr_dyn.codegen.emit.functions import Argument, TemplateCase, TemplateFunction
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.arm_geometry import SRS_ARM, SrsGeometry, srs_geometry
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.six_joints.spherical_wrist import WRIST_ARM, SixJointGeometry, all_branches, wrist_arm_geometry
from lwr_dyn.kinematics.solution import BRANCHES, joint_ranges
from lwr_dyn.kinematics.srs import arm_triangle, closed_form
from lwr_dyn.kinematics.srs_margins import UNLIMITED, intervals_at_level, margin_problem
from lwr_dyn.model.arm import Arm

NAME = "inverse_kinematics"

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
    constants |= restricted_c.angle_constants()
    library = restricted_c.used_functions(source, functions)
    texts = {}
    for kind, whole in (("", restricted_c.with_own_angles(source)), (" libm", source)):
        used = restricted_c.used_functions(whole, functions)
        texts[f"c{kind}"] = restricted_c.c_text(used, constants, "@NAME@")
        texts[f"js{kind}"] = restricted_c.javascript_text(used, constants)
    heads = {"c": restricted_c.declarations(library, functions, "@NAME@"), "js": ", ".join(functions)}
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


def case_of_six_joints(arm: Arm) -> str:
    """Of an arm with a spherical wrist."""
    T = poses(arm)
    return _text(T, all_branches(arm, T).q, None)


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


def vectors_of_six_joints(arm: Arm) -> tuple[TemplateCase, ...]:
    """Of the two functions of an arm with a spherical wrist; one pose is out of reach."""
    T = poses(arm)
    found, q = all_branches(arm, T), positions(arm)
    beyond = all_branches(arm, _far(T)).reach_excess.min()
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
