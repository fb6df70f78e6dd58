"""References by name, and where a joint motion leaves its limits or comes nearest to them."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import UnknownNameError
from lwr_dyn.trajectory.references.joint_moves import hold
from lwr_dyn.trajectory.references.position_limits import LimitMargin, largest_violation, limit_margin
from lwr_dyn.trajectory.references.references import REFERENCES, reference
from tests.simulation.sample_runs import one_joint


def test_a_reference_is_made_by_its_row_and_an_unknown_one_refused_with_the_known_ones(arm):
    named, times = reference("hold", arm, q=[0.1] * 7, duration=0.5), np.linspace(0.0, 1.0, 5)
    assert named.duration == 0.5
    assert np.array_equal(named.sample(times).q, hold(arm, [0.1] * 7, 0.5).sample(times).q)
    with pytest.raises(UnknownNameError, match=r"holt.*did you mean hold\?") as caught:
        reference("holt", arm)
    assert caught.value.known == REFERENCES.names


def test_the_largest_violation_names_row_joint_and_excess(arm):
    q = np.zeros((4, 7))
    q[0], q[1] = arm.upper, arm.lower
    assert largest_violation(arm, q) is None  # on a limit is inside
    q[1, 2], q[3, 5] = arm.upper[2] + 0.1, arm.lower[5] - 0.2
    fault = f"joint_6 at {q[3, 5]:.6g} rad, 0.2 rad outside its limits"
    allowed = f"{arm.lower[5]:.6g} to {arm.upper[5]:.6g} rad"
    assert largest_violation(arm, q) == (3, "joint_6", fault, allowed, pytest.approx(0.2, rel=1e-12))
    slider = largest_violation(one_joint(lower=0.0, upper=1.0), np.array([[1.5]]))
    assert slider == (0, "joint_1", "joint_1 at 1.5 m, 0.5 m outside its limits", "0 to 1 m", 0.5)


def test_the_margin_is_where_a_motion_comes_nearest_to_a_limit(arm):
    q, t = np.zeros((3, 7)), np.array([0.0, 0.5, 1.0])
    q[2, 3] = arm.lower[3] + 0.01
    assert limit_margin(arm, t, q) == LimitMargin(pytest.approx(0.01, rel=1e-9), "joint_4", 1.0)
    q[1, 0] = arm.upper[0] + 0.02
    assert limit_margin(arm, t, q) == LimitMargin(float(arm.upper[0] - q[1, 0]), "joint_1", 0.5)
