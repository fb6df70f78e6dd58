import json
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lwr_dyn
from lwr_dyn.kinematics.inverse import nearest_point

LWR = ("ik", "lwr4plus")
POINT_1 = ("--xyz", "-0.05,-0.45,0.55", "--rpy-deg", "-90,0,0")


@pytest.mark.parametrize("pose", [POINT_1, ("--xyz=-0.05,-0.45,0.55", *POINT_1[2:])])
def test_all_branches_are_printed(pose, printed):
    out = printed(*LWR, *pose)
    assert "1.2027  joint_6  inside" in out
    assert sum(line.startswith("arm angle inside limits") for line in out.splitlines()) == 8


def test_json_is_one_object_whose_joints_meet_the_pose(recorded):
    result = recorded(*LWR, "--xyz", "-0.05,-0.45,0.55", "--rpy", "-1.5707963267948966,0,0")
    assert (result["status"], result["complete"]) == ("solved", True)
    for solution in result["solutions"]:
        T = lwr_dyn.forward_kinematics(lwr_dyn.load("lwr4plus"), solution["q"])
        assert np.abs(T - result["T"]).max() < 1e-12


def test_a_solver_can_be_chosen(recorded, refused):
    result = recorded(*LWR, *POINT_1, "--solver", "numeric")
    assert (result["status"], result["complete"]) == ("solved", False)
    words = "solver spherical-wrist: lwr4plus is not an arm that it solves; allowed: a six-"
    assert words in refused(*LWR, *POINT_1, "--solver", "spherical-wrist")


def test_out_of_reach_exits_1_with_one_line(lwr_dyn_command):
    nearest = "0.0000,0.0000,0.8680"
    line = f"lwr-dyn: lwr4plus: out of reach by 1.132 m; the nearest point in this orientation: {nearest}\n"
    assert lwr_dyn_command(*LWR, "--xyz", "0,0,2", "--rpy", "0,0,0") == (1, "", line)


def test_outside_limits_exits_1_and_names_the_joint(lwr_dyn_command):
    code, out, err = lwr_dyn_command(*LWR, "--xyz", "-0.05,-0.25,0.25", "--rpy-deg", "90,0,0", "--json")
    assert (code, json.loads(out)["status"]) == (1, "outside limits")
    assert "joint_4 by 0.247839 rad (14.2001 deg) at any arm angle" in err
    code, _, err = lwr_dyn_command(*LWR, *POINT_1, "--arm-angle-deg", "0")
    assert code == 1
    assert "at this arm angle; at another it is inside" in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--rpy", "0,0,1"], "neither given"),
        (["--xyz", "0,0,1", "--turn", "2"], "given without an orientation"),
        (["--xyz", "0,0,1", "--arm-angle-deg", "2"], "for a position only"),
        (["--xyz", "0,0,1", "--rpy", "0,0,0", "--rpy-deg", "0,0,0"], "both given"),
        (["--xyz", "0,0", "--rpy", "0,0,0"], "--xyz"),
        (["--xyz", "0,0,nan", "--rpy", "0,0,0"], "--xyz"),
        (["--xyz", "0,0,1", "--rpy", "0,0,0", "--arm-angle-deg", "nan"], "arm_angle"),
    ],
)
def test_bad_input_is_one_line(arguments, message, refused):
    assert message in refused(*LWR, *arguments)


@pytest.mark.slow
def test_without_an_orientation_one_solution_near_a_start_is_given(lwr_dyn_command, printed, recorded):
    assert "one of many solutions for the position" in printed(*LWR, *POINT_1[:2])
    result = recorded(*LWR, *POINT_1[:2], "--from-deg", "10,-60,20,80,-30,40,50")
    (solution,) = result["solutions"]
    T = lwr_dyn.forward_kinematics(lwr_dyn.load("lwr4plus"), solution["q"])
    assert np.abs(T[:3, 3] - [-0.05, -0.45, 0.55]).max() < 1e-11
    assert result["position_only"]
    code, _, err = lwr_dyn_command(*LWR, "--xyz", "0,0,2")
    assert (code, err) == (1, "lwr-dyn: lwr4plus: out of reach by 1.132 m (numeric search, not proven)\n")


def test_many_whole_turn_copies_are_counted_and_listed_with_all(printed, recorded, tmp_path):
    file = tmp_path / "turning.urdf"
    text = lwr_dyn.urdf_text(lwr_dyn.load("kr30ha"))
    limits = 'lower="-6.2" upper="6.2"'
    file.write_text(re.sub(r'lower="[^"]*" upper="[^"]*"', limits, text), encoding="utf-8")
    pose = ("ik", str(file), "--xyz", "1.4,0,1.2", "--rpy", "0,1,0")
    short, whole = printed(*pose), printed(*pose, "--all")
    rows = [line for line in short.splitlines() if line.endswith("inside")]
    copies = len(recorded(*pose)["solutions"]) - len(rows)
    assert copies > 32
    assert f"and {copies} copies of these, whole turns of joints apart: --all, --json\n" in short
    assert len({line[:4] for line in rows}) == len(rows)
    assert whole.count(" inside") == len(rows) + copies
    assert "copies of these" not in whole


def test_columns_stand_below_long_joint_names(printed, tmp_path):
    file = tmp_path / "long.urdf"
    text = lwr_dyn.urdf_text(lwr_dyn.load("kr30ha")).replace('"A2"', '"shoulder_lift_joint"')
    file.write_text(text, encoding="utf-8")
    lines = printed("ik", str(file), "--xyz", "1.4,0,1.2", "--rpy", "0,1,0").splitlines()
    end = lines[1].index("shoulder_lift_joint") + len("shoulder_lift_joint")
    assert lines[3][:end].endswith("-72.5586")


def test_an_orientation_that_cannot_be_met_is_not_called_out_of_reach(lwr_dyn_command):
    locks = ("--lock", "joint_3=0", "--lock", "joint_5=0")
    code, out, err = lwr_dyn_command(*LWR, *locks, *POINT_1[:2], "--rpy", "1,0.3,0", "--json")
    assert code == 1
    assert "the position is within reach, the orientation is not: the nearest found is off by" in err
    assert 0.01 < json.loads(out)["turn_missed"] < np.pi


def test_a_singular_wrist_is_said_to_stand_for_a_family(printed):
    out = printed("ik", "kr30ha", "--xyz-mm", "1840,0,1000", "--abc-deg", "0,90,0")
    assert "note: singular wrist" not in out
    T = lwr_dyn.forward_kinematics(lwr_dyn.load("kr30ha"), np.radians([20, -60, 80, 30, 0, 10]))
    place, rpy = (",".join(map(repr, x.tolist())) for x in (T[:3, 3], Rotation.from_matrix(T[:3, :3]).as_euler("xyz")))
    words = "note: singular wrist: such a solution is one of a family"
    assert words in printed("ik", "kr30ha", "--xyz", place, "--rpy", rpy)


def test_the_solution_with_the_least_axis_travel(recorded):
    pose = ("ik", "kr30ha", "--xyz-mm", "91,-1139,1392", "--rpy", "0,0,0")
    every = recorded(*pose)["solutions"]
    near = recorded(*pose, "--from-deg", "0,-90,90,0,0,0")["solutions"]
    travel = [np.abs(np.array(s["q"]) - np.radians([0, -90, 90, 0, 0, 0])).sum() for s in every]
    assert len(near) == 1
    assert near[0]["q"] == every[int(np.argmin(travel))]["q"]


def test_a_sliding_joint_starts_at_metres(printed, recorded, tmp_path):
    path = tmp_path / "arm.toml"
    printed("new", "arm", str(path), "--joints", "RRPR", "--convention", "modified")
    arm = lwr_dyn.load(path)
    q = np.array([0.2, 0.4, 0.5 * arm.upper[2], 0.1])
    xyz = ",".join(map(repr, lwr_dyn.forward_kinematics(arm, q)[:3, 3].tolist()))
    start = ",".join(repr(float(x)) for x in np.where([True, True, False, True], np.degrees(q), q))
    found = recorded("ik", str(path), "--xyz", xyz, "--from-deg", start)["solutions"][0]
    np.testing.assert_allclose(found["q"], q, atol=1e-9)


@pytest.mark.parametrize(("robot", "rpy"), [("lwr4plus", (0.3, 0.5, 0.1)), ("kr30ha", (0.0, 1.5, 0.2))])
def test_the_nearest_point_is_on_the_border_of_reach(robot, rpy):
    arm = lwr_dyn.load(robot)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix()
    pose[:3, 3] = [2.0, 2.5, 1.4]
    result = lwr_dyn.inverse_kinematics(arm, pose)
    point = nearest_point(arm, pose, result)
    assert np.linalg.norm(point - pose[:3, 3]) == pytest.approx(result.distance, abs=1e-5)
    for share, status in ((1.001, "solved"), (0.999, "out of reach")):
        pose[:3, 3] = [2.0, 2.5, 1.4] + share * (point - [2.0, 2.5, 1.4])
        assert lwr_dyn.inverse_kinematics(arm, pose, limits=False).status == status


@pytest.mark.slow
def test_a_distance_that_is_not_proven_gives_no_point():
    arm = lwr_dyn.load("wam7")
    pose = np.eye(4)
    pose[0, 3] = 5.0
    assert nearest_point(arm, pose, lwr_dyn.inverse_kinematics(arm, pose, solver="numeric")) is None
