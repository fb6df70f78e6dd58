"""Springs and dampers of gears: what is no spring is refused; how an option of `simulate` chooses them."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError
from lwr_dyn.model.transmission import JointElasticity, chosen_elasticity

ARM = lwr_dyn.load("lwr4plus")


@pytest.mark.parametrize(
    ("stiffness", "damping", "message"),
    [
        ([1.0, 0.0], [0.0, 0.0], "stiffness of joint 2: 0; allowed: numbers above 0"),
        ([-5.0, 1.0], [0.0, 0.0], "stiffness of joint 1: -5; allowed"),
        ([1.0, 1.0], [0.0, -1e-9], "damping of joint 2: -1e-09; allowed: numbers of at least 0"),
        ([1.0, np.inf], [0.0, 0.0], "joint stiffness: inf at index"),
        ([1.0, 1.0], [0.0], "joint damping: 1 number; allowed: 2 numbers"),
        ([[1.0, 1.0]], [[0.0, 0.0]], "joint stiffness: an array of 1 x 2 numbers; allowed: 2 numbers"),
    ],
)
def test_what_is_no_spring_or_damper_is_refused(stiffness, damping, message):
    with pytest.raises((OptionError, ShapeError), match=message):
        JointElasticity(stiffness, damping)


def test_a_number_is_the_largest_stiffness_and_keeps_the_proportions_of_the_file():
    stiff = chosen_elasticity(ARM, 3e4)
    assert np.allclose(stiff.stiffness, 3.0 * ARM.elasticity.stiffness, rtol=1e-15)
    assert np.allclose(stiff.damping, 3.0 * ARM.elasticity.damping, rtol=1e-15)
    assert stiff.source.startswith("assumed")
    even = chosen_elasticity(replace(ARM, elasticity=None), 3e4)
    assert (even.stiffness.tolist(), even.damping.tolist()) == ([3e4] * 7, [30.0] * 7)


def test_other_choices():
    own = JointElasticity(np.full(7, 5.0), np.zeros(7))
    assert chosen_elasticity(ARM, None) is None
    assert chosen_elasticity(ARM, "file") is ARM.elasticity
    assert chosen_elasticity(ARM, own) is own


@pytest.mark.parametrize("option", [0.0, -1.0, np.nan, np.inf, "soft", True])
def test_a_choice_that_means_nothing_is_refused(option):
    with pytest.raises(OptionError, match=r'stiffness: .* allowed: "file", a number above 0'):
        chosen_elasticity(ARM, option)


def test_what_an_arm_does_not_give_is_missing():
    with pytest.raises(MissingDataError, match="lwr4plus: joint stiffness not given; needed for elastic joints"):
        chosen_elasticity(replace(ARM, elasticity=None), "file")
    with pytest.raises(ShapeError, match="2 numbers; allowed: 7"):
        chosen_elasticity(ARM, JointElasticity([1.0, 1.0], [0.0, 0.0]))


def test_a_locked_joint_takes_its_spring_along():
    locked = ARM.with_locked_joint("joint_4", 0.0)
    assert locked.elasticity.stiffness.tolist() == [1e4, 1e4, 1e4, 6e3, 6e3, 6e3]
