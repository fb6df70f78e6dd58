"""The page's data: complete, finite, and apart from what draws it."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.pages.explorer import page_data
from lwr_dyn.pages.explorer.page_data import start_pose
from tests.pages.explorer.explored import NAMES, explored_arm


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_data_are_json_and_the_start_is_inside_the_limits(name):
    arm = explored_arm(name)
    shown = page_data.readings_shown(arm)
    records = page_data.shown_records(shown, [0] * len(shown))["arms"]
    assert json.loads(json.dumps(records, allow_nan=False))[0]["start"] == records[0]["start"]
    data = records[0]
    start = np.array(data["start"])
    assert ((arm.lower <= start) & (start <= arm.upper)).all()
    low, up = np.array(page_data.slider_ranges(arm)).T
    assert ((low <= start) & (start <= up)).all()
    assert ((arm.lower <= low) & (up <= arm.upper)).all()
    assert [b["mass"] for b in data["bodies"]] == [None if b is None else b.mass for b in arm.bodies()]


def test_what_is_unknown_stays_unknown():
    record = page_data.arm_record(lwr_dyn.load("lwr4"))
    assert {(joint["lower"], joint["upper"]) for joint in record["joints"]} == {(None, None)}
    assert record["joints"][0]["slider"] == (-np.pi, np.pi)
    assert page_data.body_record(None) == {"mass": None, "ellipsoid": None, "why": "no mass and inertia given"}


def test_frames_of_the_source_are_there_where_they_differ():
    assert len(page_data.arm_record(lwr_dyn.load("lwr4plus"))["native"]) == 7
    assert page_data.arm_record(explored_arm("panda"))["native"] is None


def test_a_pose_outside_the_limits_or_of_another_length_is_refused(arm):
    at_the_limit = np.radians([170.0, 0, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(start_pose(arm, at_the_limit), at_the_limit)
    with pytest.raises(OptionError, match=r"q of joint_2: 130 deg; allowed: its limits, -120 deg to 120 deg"):
        start_pose(arm, np.radians([0, 130.0, 0, 0, 0, 0, 0]))
    with pytest.raises(ShapeError, match="q: 3 numbers"):
        start_pose(arm, [0, 0, 0])
    with pytest.raises(ShapeError):
        start_pose(arm, [np.nan] * 7)
