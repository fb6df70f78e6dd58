"""The page's data: what it holds of arms word for word, complete, finite, and apart from what draws it."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.arm import JointLimits
from lwr_dyn.model.chain import JointKind
from lwr_dyn.pages.explorer import page_data
from lwr_dyn.pages.explorer.page_data import position_text, slider_ranges, start_pose
from lwr_dyn.pages.replay.replay_page import column_major
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


def test_an_arm_is_recorded_with_its_joints_flange_gravity_and_ends():
    arm = explored_arm("hung")
    record = page_data.arm_record(arm)
    assert {key: x for key, x in record.items() if key not in ("joints", "native")} == {
        "name": "lwr4plus", "reading": "physical", "flange": column_major(arm.flange()),
        "gravity": arm.chain.gravity.tolist(), "ends": ["world", "tool centre point"],
    }  # fmt: skip
    for joint, slider, each in zip(arm.joints(), slider_ranges(arm), record["joints"], strict=True):
        assert {key: each[key] for key in ("name", "kind", "origin", "lower", "upper", "slider")} == {
            "name": joint.name, "kind": "revolute", "origin": column_major(joint.origin),
            "lower": joint.limits.lower, "upper": joint.limits.upper, "slider": slider,
        }  # fmt: skip


def test_what_the_dynamics_are_computed_with():
    """Of each link m, m c and the tensor about the origin of its frame: I = I_c + m (c.c E - c c^T)."""
    arm = lwr_dyn.load("kr30ha")
    record = page_data.inertial_record(arm)
    rows = np.reshape(record["inertia"], (6, 10))
    for row, link in zip(rows, arm.chain.links, strict=True):
        body, c = link.body, link.body.com
        tensor = body.inertia_com + body.mass * (c @ c * np.eye(3) - np.outer(c, c))
        order = [tensor[i, j] for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))]
        np.testing.assert_allclose(row, [body.mass, *(body.mass * c), *order], rtol=1e-12, atol=1e-12)
    assert (record["rotors"], record["carrier"]) == (arm.armature.tolist(), column_major(arm.chain.flange))
    assert page_data.inertial_record(lwr_dyn.load("lwr4")) == {"inertia": None, "rotors": None, "carrier": None}


def test_a_body_is_recorded_with_the_ellipsoid_of_its_inertia():
    body = lwr_dyn.load("lwr4plus").bodies()[1]
    record = page_data.body_record(body)
    assert {key: record[key] for key in ("mass", "com", "inertia")} == {
        "mass": body.mass, "com": body.com.tolist(), "inertia": body.inertia_com.tolist(),
    }  # fmt: skip
    half = np.reshape(record["ellipsoid"], (4, 4)).T
    second = body.mass / 5.0 * half[:3, :3] @ half[:3, :3].T
    np.testing.assert_allclose(np.trace(second) * np.eye(3) - second, body.inertia_com, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(half[:3, 3], body.com)


def test_what_is_unknown_stays_unknown():
    record = page_data.arm_record(lwr_dyn.load("lwr4"))
    assert {(joint["lower"], joint["upper"]) for joint in record["joints"]} == {(None, None)}
    assert page_data.body_record(None) == {"mass": None, "ellipsoid": None, "why": "no mass and inertia given"}


@pytest.mark.parametrize(
    ("limits", "turning", "sliding"),
    [
        ((None, None), (-np.pi, np.pi), (-1.0, 1.0)),
        ((None, -4.0), (-4.0, -4.0), (-4.0, -4.0)),
        ((None, 0.5), (-np.pi, 0.5), (-1.0, 0.5)),
        ((0.5, None), (0.5, np.pi), (0.5, 1.0)),
        ((4.0, None), (4.0, 4.0), (4.0, 4.0)),
        ((-0.1, 0.2), (-0.1, 0.2), (-0.1, 0.2)),
    ],
)
def test_sliders_end_at_the_limits_or_half_a_turn_or_a_metre_away(tmp_path, limits, turning, sliding):
    (tmp_path / "own.toml").write_text(template("own.toml", "own", "RP"), encoding="utf-8")
    arm = replace(lwr_dyn.load(tmp_path / "own.toml"), limits=(JointLimits(*limits),) * 2)
    assert slider_ranges(arm) == [turning, sliding]


def test_frames_of_the_source_are_there_where_they_differ():
    arm = lwr_dyn.load("lwr4plus")
    assert page_data.arm_record(arm)["native"] == [column_major(link.after) for link in arm.chain.links]
    assert page_data.arm_record(explored_arm("panda"))["native"] is None


def test_a_pose_outside_the_limits_or_of_another_length_is_refused(arm):
    for degrees in ([170.0, 0, 0, 0, 0, 0, 0], [170.0 + 5e-8, 0, 0, 0, 0, 0, -170.0 - 5e-8]):
        np.testing.assert_array_equal(start_pose(arm, np.radians(degrees)), np.radians(degrees))
    for joint, degrees, allowed in ((2, 130.0, "-120 deg to 120 deg"), (1, -170.001, "-170 deg to 170 deg")):
        with pytest.raises(OptionError, match=rf"q of joint_{joint}: {degrees:g} deg; allowed: its limits, {allowed}"):
            start_pose(arm, np.radians(degrees * np.eye(7)[joint - 1]))
    for q in ([0, 0, 0], [np.nan] * 7):
        with pytest.raises(ShapeError, match=r"q: (3 numbers|nan)"):
            start_pose(arm, q)
    free = replace(arm, limits=(JointLimits(lower=1.0), *arm.limits[1:]))
    assert start_pose(free).tolist() == [1.0, *[0.0] * 6]
    assert start_pose(free, 9.0 * np.eye(7)[0])[0] == 9.0


def test_positions_are_texts_in_the_units_of_the_command_line():
    turning, sliding = JointKind.REVOLUTE, JointKind.PRISMATIC
    assert [position_text(*x) for x in ((turning, np.pi / 2), (sliding, 0.25), (turning, None))] == [
        "90 deg", "0.25 m", "unknown",
    ]  # fmt: skip


def test_the_records_of_a_page_say_label_group_start_and_efforts(arm):
    shown = page_data.beside_each_other(arm, lwr_dyn.load("wam7"), np.full(7, 0.1))
    records = page_data.shown_records(shown, [4, None])
    found = [
        {key: each[key] for key in ("label", "group", "set", "run", "start", "motors")} for each in records["arms"]
    ]
    wam = lwr_dyn.load("wam7")
    at = np.clip(np.full(7, 0.1), wam.lower, wam.upper).tolist()
    assert found == [
        {"label": "lwr4plus", "group": 0, "set": 4, "run": 0, "start": [0.1] * 7, "motors": arm.effort.tolist()},
        {"label": "wam7", "group": 1, "set": None, "run": 1, "start": at, "motors": wam.effort.tolist()},
    ]
    assert len(records["stage"]["runs"]) == 2
    other = page_data.beside_each_other(arm, lwr_dyn.load("kr30ha"), np.full(7, 0.1))[1]
    assert other.start.tolist() == start_pose(lwr_dyn.load("kr30ha")).tolist()


def test_a_scene_is_short_commands():
    shown = page_data.readings_shown(lwr_dyn.load("kr30ha"))
    whole, short = (page_data.shown_records(shown, [0, 1], live)["stage"]["scene"] for live in (True, False))
    assert len(whole) == len(short)
    for command, row in zip(whole, short, strict=True):
        run, link = int(command["path"].split("/")[2][4:]), command["path"].count("link_") - 1
        if command["type"] == "set_transform":
            assert row == [run, link, command["matrix"]]
            continue
        made = command["object"]
        (solid,), (paint,), mesh = made["geometries"], made["materials"], made["object"]
        assert row == [run, link, mesh["matrix"], [solid["radiusTop"], solid["radiusBottom"], solid["height"], 40],
                       [paint["color"], paint["specular"], 35], mesh["userData"]["token"]]  # fmt: skip
    assert {row[0] for row in short} == {0, 1}
