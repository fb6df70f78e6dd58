"""Solutions that are made when read behave as a tuple of them."""

import copy
import pickle

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics.closed_forms.lazy_solutions import LazySolutions


@pytest.fixture(scope="module")
def result():
    arm = lwr_dyn.load("kr30ha")
    return lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, [0.3, -0.8, 1.0, 2.5, -1.7, 0.9]))


def test_places_slices_and_iteration(result):
    ours, listed = result.solutions, tuple(result.solutions)
    assert isinstance(ours, LazySolutions)
    assert len(ours) == len(listed) > 4
    assert ours[0] is listed[0] is ours[-len(listed)]
    assert ours[1:3] == listed[1:3]
    assert ours[::-1] == listed[::-1]
    assert ours == listed
    assert ours + listed == listed + ours == ours + ours == listed + listed
    assert listed[2] in ours
    assert ours.index(listed[3]) == 3
    assert (*ours, *result.outside)[-1] is result.outside[-1]
    for place in (len(ours), -len(ours) - 1):
        with pytest.raises(IndexError, match="solution"):
            ours[place]
    assert np.array_equal(ours.q, [s.q for s in ours])
    assert not ours.q.flags.writeable


def test_copies_share_nothing_with_the_first(result):
    one = result.solutions[1]
    for other in (copy.deepcopy(one), pickle.loads(pickle.dumps(one))):
        assert other.record == one.record
    for other in (copy.deepcopy(result), pickle.loads(pickle.dumps(result))):
        assert other.solutions[0].rows is other.outside[0].rows
        assert [s.record for s in other.outside] == [s.record for s in result.outside]
        assert np.array_equal(other.solutions.q, result.solutions.q)
        read = other.solutions[2]  # a solution that was read stays the same one when all are listed
        assert tuple(other.solutions)[2] is read is other.solutions[2]
        assert [s.record for s in other.solutions] == [s.record for s in result.solutions]
