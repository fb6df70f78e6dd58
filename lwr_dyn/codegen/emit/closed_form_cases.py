"""The self-test of closed-form inverse kinematics in C: a few poses, and the branches that Python finds."""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.arm_geometry import SrsGeometry
from lwr_dyn.kinematics.branches import BRANCHES, joint_ranges
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.six_joints.spherical_wrist import all_branches
from lwr_dyn.kinematics.srs import closed_form
from lwr_dyn.model.arm import Arm

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
