"""References by name, and where a joint motion leaves its limits or comes nearest to them."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import UnknownNameError
from lwr_dyn.trajectory.references.joint_moves import hold
from lwr_dyn.trajectory.references.position_limits import LimitMargin, largest_violation, limit_margin
from lwr_dyn.trajectory.references.references import REFERENCES, reference
from tests.simulation.sample_runs import one_joint


@pytest.fixture(scope="module")
def arm():
    return lwr_dyn.load("lwr4plus")


def test_a_reference_is_made_by_its_row(arm):
    named, made = reference("hold", arm, q=[0.1] * 7, duration=0.5), hold(arm, [0.1] * 7, 0.5)
    times = np.linspace(0.0, 1.0, 5)
    assert named.duration == made.duration == 0.5
    assert np.array_equal(named.sample(times).q, made.sample(times).q)


def test_an_unknown_reference_is_refused_with_the_known_ones(arm):
    with pytest.raises(UnknownNameError, match=r"holt.*did you mean hold\?") as caught:
        reference("holt", arm)
    assert caught.value.known == REFERENCES.names


def test_the_largest_violation_names_row_joint_and_excess(arm):
    q = np.zeros((4, 7))
    assert largest_violation(arm, q) is None
    q[1, 2], q[3, 5] = arm.upper[2] + 0.1, arm.lower[5] - 0.2
    found = largest_violation(arm, q)
    assert (found.row, found.joint) == (3, "joint_6")
    assert found.excess == pytest.approx(0.2, rel=1e-12)
    assert found.fault == f"joint_6 at {q[3, 5]:.6g} rad, 0.2 rad outside its limits"
    assert found.allowed == f"{arm.lower[5]:.6g} to {arm.upper[5]:.6g} rad"
    assert largest_violation(arm, np.array([arm.upper, arm.lower])) is None  # on a limit is inside
    assert "m, 0.5 m outside" in largest_violation(one_joint(lower=0.0, upper=1.0), np.array([[1.5]])).fault


def test_the_margin_is_where_a_motion_comes_nearest_to_a_limit(arm):
    q, t = np.zeros((3, 7)), np.array([0.0, 0.5, 1.0])
    q[2, 3] = arm.lower[3] + 0.01
    nearest = limit_margin(arm, t, q)
    assert (nearest.joint, nearest.t) == ("joint_4", 1.0)
    assert nearest.margin == pytest.approx(0.01, rel=1e-9)
    q[1, 0] = arm.upper[0] + 0.02
    assert limit_margin(arm, t, q) == LimitMargin(float(arm.upper[0] - q[1, 0]), "joint_1", 0.5)
