"""A solution is a place in rows that all solutions of its pose share."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.solution_rows import Solution, SolutionRows

ROWS = SolutionRows(
    ("A1", "A2"), np.array([[0.5, -1.0, 0.25, 1.0, 1.0], [3.0, 2.0, -0.5, 0.0, 0.0]]), ("+++", "++-"), (None, 0.25),
    (1e-16, 2e-16), ((), ("elbow",)),
)  # fmt: skip


def test_what_a_row_says():
    one, other = Solution(ROWS, 0), Solution(ROWS, 1)
    assert one.record == {
        "q": [0.5, -1.0], "branch": "++-", "arm_angle": 0.25, "margin": 0.25, "joint": "A2", "inside_limits": True,
        "residual": 2e-16, "singular": ["elbow"],
    }  # fmt: skip
    assert (other.branch, other.arm_angle, other.margin, other.joint) == ("+++", None, -0.5, "A1")
    assert (other.inside_limits, other.residual, other.singular) == (False, 1e-16, ())
    assert repr(other).startswith("Solution(q=array([3., 2.]), branch='+++', arm_angle=None, margin=-0.5, joint='A1'")
    assert [type(x) for x in (one.margin, one.residual, one.inside_limits, one.joint)] == [float, float, bool, str]


@pytest.mark.parametrize("name", ["kr30ha", "ur10", "lwr4plus", "panda"])
def test_every_number_is_that_of_its_position(name):
    """Margins, joints and residuals of all roads: closed forms as machine code, and the search."""
    arm = lwr_dyn.load(name)
    T = lwr_dyn.forward_kinematics(arm, np.clip(np.full(arm.n, 0.4), arm.lower, arm.upper))
    result = lwr_dyn.inverse_kinematics(arm, T)
    solutions = (*result.solutions, *result.outside)
    assert solutions
    for one in solutions:
        room = np.minimum(arm.upper - one.q, one.q - arm.lower)
        assert one.margin == room.min()
        assert one.joint == arm.joint_names[room.argmin()]
        assert one.inside_limits == (room.min() >= -1e-12)
        assert one.residual == pytest.approx(np.abs(flange_pose(arm.chain, one.q) - T).max(), abs=1e-14)
        assert not one.q.flags.writeable
