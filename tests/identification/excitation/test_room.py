"""Whether an arm has room beside floor, column and own links, and strength: what no pose meets."""

import dataclasses

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.excitation import room
from lwr_dyn.identification.excitation.motion_limits import MotionLimits, TorqueUse, clearance_of
from lwr_dyn.identification.excitation.room import ExcitationError, check_room


def checked(arm, share=0.8, **clearance):
    limits = MotionLimits.of(arm, torque_share=share)
    check_room(clearance_of(arm, **clearance), limits, TorqueUse.of(arm, limits.torque))


def test_the_column_says_what_it_reaches_and_what_it_does_not_hold():
    arm = lwr_dyn.load("lwr4plus", "physical")
    assert room.column_words(clearance_of(arm, column=0.0)) == ""
    words = room.column_words(clearance_of(arm, column=0.3))
    assert words.startswith("column of radius 0.3 m up to joint_1 at 0 m, its top round; its distance to ")
    drawn, wide = (room.links_inside(clearance_of(arm, column=x)) for x in (None, 0.3))
    assert set(drawn) < set(wide)
    assert set(wide) < set(room.links_inside(clearance_of(arm, column=5.0)))
    room.check_column(clearance_of(arm, column=0.3), 0.3)
    with pytest.raises(OptionError, match="column: 5"):
        room.check_column(clearance_of(arm, column=5.0), 5.0)


@pytest.mark.parametrize("robot", ["lwr4plus", "wam7", "kr30ha"])
def test_arms_that_stand_as_drawn_have_room(robot):
    checked(lwr_dyn.load(robot))


@pytest.mark.slow
def test_a_pair_that_is_never_far_enough_apart_is_named(iiwa):
    checked(iiwa)
    with pytest.raises(ExcitationError, match=r"link_5 and link_3 are at best 0\.0538 m apart; 0\.06 m is to be kept"):
        checked(iiwa, kept=0.06)


def narrow(arm, **joints):
    """The arm with other position limits of some joints, `j2=(lower, upper)`."""
    limits = [
        dataclasses.replace(x, lower=joints[f"j{j}"][0], upper=joints[f"j{j}"][1]) if f"j{j}" in joints else x
        for j, x in enumerate(arm.limits, 1)
    ]
    return dataclasses.replace(arm, limits=tuple(limits))


def test_a_joint_that_cannot_hold_the_arm_anywhere_is_named(lwr):
    lying = narrow(lwr, j2=(1.0, 1.6), j4=(-0.2, 0.2))
    checked(lying, share=0.5, floor=-5.0)
    with pytest.raises(ExcitationError, match=r"joint_2 needs at best 2\.38 times the torque .*--torque-share"):
        checked(lying, share=0.1, floor=-5.0)


@pytest.mark.slow
def test_what_is_met_one_by_one_but_not_at_once_is_seen():
    """Hanging low takes little torque, and hanging above the floor little height, but not both."""
    high, low = (
        narrow(lwr_dyn.load("lwr4plus", "physical", mount={"on": "ceiling", "xyz": (0.0, 0.0, z)}),
               j2=(0.5, 1.4), j4=(-0.2, 0.2))
        for z in (2.0, 0.7)
    )  # fmt: skip
    checked(high, share=0.15)
    checked(low, share=0.8)
    with pytest.raises(ExcitationError, match=r"in the best pose for all at once"):
        checked(low, share=0.15)


def test_poses_are_moved_before_they_are_judged(lwr, monkeypatch):
    """All drawn poses lie on the floor; one of them moved is clear."""
    low = np.radians([[0, 90, 0, -60, 0, 0, 0], [0, 120, 0, -20, 0, 0, 0]])
    assert clearance_of(lwr).of(low).min(axis=1).max() < 0.0
    monkeypatch.setattr(room, "drawn_poses", lambda limits: low)
    checked(lwr)


def test_the_gradient_of_what_is_asked_is_that_of_its_differences(lwr):
    limits = MotionLimits.of(lwr)
    asked, h = room.Demands(clearance_of(lwr), TorqueUse.of(lwr, limits.torque)), 1e-6
    q = room.drawn_poses(limits, 20)
    assert len(asked.names) == asked.of(q).shape[1]
    differences = [(asked.of(q + h * e) - asked.of(q - h * e)) / (2 * h) for e in np.eye(lwr.n)]
    assert np.abs(np.stack(differences, axis=-1) - asked.gradient(q)).max() < 1e-7
