"""`lwr-dyn ik`: every branch meets the pose; what is chosen of them; out of reach and limits in a line; bad input."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lwr_dyn
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.cli.ik import _how_found
from lwr_dyn.kinematics.inverse import nearest_point

LWR, KR = ("ik", "lwr4plus"), ("ik", "kr30ha")
POINT_1 = ("--xyz", "-0.05,-0.45,0.55", "--rpy-deg", "-90,0,0")
START = np.radians([0, -90, 90, 0, 0, 0])
CELL = ("--xyz-mm", "91,-1139,1392", "--abc-deg", "10,20,30")


def pose_of(xyz, angles, order):
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler(order, angles).as_matrix()
    pose[:3, 3] = xyz
    return pose


@pytest.mark.parametrize(
    ("arguments", "pose"),
    [
        ((*LWR, *POINT_1), pose_of([-0.05, -0.45, 0.55], [-np.pi / 2, 0, 0], "xyz")),
        (("ik", "lwr4plus", "--xyz=-0.05,-0.45,0.55", "--rpy", "-1.5,0.1,0.2"),
         pose_of([-0.05, -0.45, 0.55], [-1.5, 0.1, 0.2], "xyz")),
        ((*KR, *CELL), pose_of([0.091, -1.139, 1.392], np.radians([10, 20, 30]), "ZYX")),
    ],
)  # fmt: skip
def test_all_branches_meet_the_pose_and_the_table_shows_them(recorded, printed, arguments, pose):
    arm, record = lwr_dyn.load(arguments[1]), recorded(*arguments)
    np.testing.assert_allclose(record["T"], pose, atol=1e-12)
    found = lwr_dyn.inverse_kinematics(arm, record["T"])
    assert (record["status"], record["complete"], record["robot"]) == ("solved", True, arm.name)
    for key, solutions in (("solutions", found.solutions), ("outside", found.outside)):
        assert [x["branch"] for x in record[key]] == [x.branch for x in solutions]
        np.testing.assert_allclose([x["q"] for x in record[key]], [x.q for x in solutions], atol=1e-12)
        for one in record[key]:
            np.testing.assert_allclose(lwr_dyn.forward_kinematics(arm, one["q"]), pose, atol=1e-9)
    lines = printed(*arguments).splitlines()
    assert lines[0].startswith(f"{arm.name}, reading {arm.reading}: all branches")
    rows = [line for line in lines if re.search(r"  (inside|OUTSIDE)", line)]
    assert [row.split()[-1] for row in rows] == ["inside"] * len(found.solutions) + ["OUTSIDE"] * len(found.outside)
    for row, one in zip(rows, (*found.solutions, *found.outside), strict=True):
        numbers = [float(x) for x in re.findall(r"-?\d+\.\d{4}", row)]
        np.testing.assert_allclose(numbers[-arm.n - 1 : -1], np.degrees(one.q), atol=6e-5)
        assert numbers[-1] == pytest.approx(np.degrees(one.margin), abs=6e-5)
        if one.arm_angle is not None:
            assert numbers[0] == pytest.approx(np.degrees(one.arm_angle), abs=6e-5)
    ranges = [x.removeprefix("arm angle inside limits, ") for x in lines if x.startswith("arm angle inside limits")]
    assert [x.partition(": ")[0] for x in ranges] == list(found.arm_angle_intervals)
    ends = [np.degrees(np.ravel(x)) for x in found.arm_angle_intervals.values()]
    for text, expected in zip(ranges, ends, strict=True):
        assert [float(x) for x in re.findall(r"-?\d+\.\d+", text)] == pytest.approx(expected, abs=6e-5)
        assert ("none" in text) == (len(expected) == 0)


POLISHED = "branches of the nearest exact geometry, polished on the arm; not proven complete"
NUMERIC = "found numerically, not complete"


@pytest.mark.parametrize(
    ("result", "words"),
    [
        ({"position_only": True}, "one of many solutions for the position (most arms have infinitely many)"),
        ({"complete": True}, "all branches"),
        ({"complete": True, "arm_angle_intervals": {"+++": ()}}, "all branches, each at one arm angle"),
        ({"turns_left_out": 5},
         "all branches; 5 copies whole turns apart, inside the limits too, are not listed"),
        ({"solutions": ("", "+++")}, POLISHED),
        ({"outside": ("+++",), "arm_angle_intervals": {"+++": ()}}, f"{POLISHED}, each at one arm angle"),
        ({"solutions": ("", ""), "outside": ("",)}, NUMERIC),
        ({}, NUMERIC),
    ],
)  # fmt: skip
def test_how_solutions_were_found_is_said(result, words):
    usual = {"position_only": False, "complete": False, "turns_left_out": 0, "arm_angle_intervals": {}}
    branches = {key: [SimpleNamespace(branch=x) for x in result.get(key, ())] for key in ("solutions", "outside")}
    assert _how_found(SimpleNamespace(**usual | result | branches)) == words


def test_status_and_turn_of_a_kuka_arm_choose_among_all(recorded):
    """Together, of each alone, what has them; the record says which each solution has."""
    every = recorded(*KR, *CELL)["solutions"]
    kinds = {(x["kuka"]["s"], x["kuka"]["t"]) for x in every}
    assert len(kinds) > 2
    for s, t in kinds:
        for options, kept in (
            (("--status", str(s)), [x for x in every if x["kuka"]["s"] == s]),
            (("--turn", str(t)), [x for x in every if x["kuka"]["t"] == t]),
            (("--status", str(s), "--turn", str(t)), [x for x in every if (x["kuka"]["s"], x["kuka"]["t"]) == (s, t)]),
        ):
            record = recorded(*KR, *CELL, *options)
            assert (record["solutions"], record["outside"]) == (kept, [])


def test_the_record_and_the_notes_have_kukas_units_where_the_arm_has_its_axes(recorded, printed):
    record = recorded(*KR, "--xyz-mm", "1840,0,1000", "--abc-deg", "0,90,0")
    kuka = record["kuka"]
    assert [kuka[x] for x in ("x_mm", "y_mm", "z_mm", "b_deg")] == pytest.approx([1840, 0, 1000, 90])
    for one in record["solutions"]:
        assert list(one["kuka"]["axes_deg"].values()) == pytest.approx(np.degrees(one["q"]))
    out = printed(*KR, "--xyz-mm", "1840,0,1000", "--abc-deg", "0,90,0")
    assert "note: B is +90 deg: A and C turn about one axis" in out
    assert "S, T" in out
    record = recorded(*LWR, *POINT_1)
    assert (record["kuka"], record["solutions"][0]["kuka"]) == (None, None)
    assert "note: " not in printed(*LWR, *POINT_1)


def test_the_solution_with_the_least_axis_travel(recorded):
    every = recorded(*KR, *CELL)["solutions"]
    (near,) = recorded(*KR, *CELL, "--from-deg", "0,-90,90,0,0,0")["solutions"]
    travel = [np.abs(np.array(s["q"]) - START).sum() for s in every]
    assert near["q"] == every[int(np.argmin(travel))]["q"]


def test_a_solver_and_an_arm_angle_can_be_chosen(recorded, refused):
    result = recorded(*LWR, *POINT_1, "--solver", "numeric")
    assert (result["status"], result["complete"]) == ("solved", False)
    words = "solver spherical-wrist: lwr4plus is not an arm that it solves; allowed: a six-"
    assert words in refused(*LWR, *POINT_1, "--solver", "spherical-wrist")
    low, up = np.degrees(recorded(*LWR, *POINT_1)["arm_angle_intervals"]["++-"][0])
    chosen = recorded(*LWR, *POINT_1, "--arm-angle-deg", str((low + up) / 2))["solutions"]
    assert "++-" in [x["branch"] for x in chosen]
    angles = np.exp(1j * np.array([x["arm_angle"] for x in chosen]))
    np.testing.assert_allclose(angles, np.exp(0.5j * np.radians(low + up)), atol=1e-9)


LOCKS = ("--lock", "joint_3=0", "--lock", "joint_5=0")
ELSEWHERE = "at another it is inside"
MISSED = "the position is within reach, the orientation is not: the nearest found is off by "


@pytest.mark.parametrize(
    ("arguments", "out", "said"),
    [
        ((*LWR, "--xyz", "0,0,2", "--rpy", "0,0,0"), False,
         "lwr4plus: out of reach by 1.132 m; the nearest point in this orientation: 0.0000,0.0000,0.8680\n"),
        ((*LWR, "--xyz", "0,0,2"), False, "lwr4plus: out of reach by 1.132 m (numeric search, not proven)\n"),
        ((*LWR, "--xyz", "-0.05,-0.25,0.25", "--rpy-deg", "90,0,0"), True,
         "lwr4plus: outside limits: joint_4 by 0.247839 rad (14.2001 deg) at any arm angle\n"),
        ((*LWR, *POINT_1, "--arm-angle-deg", "0"), True,
         f"lwr4plus: outside limits: joint_6 by 0.496623 rad (28.4544 deg) at this arm angle; {ELSEWHERE}\n"),
        (("ik", "own.toml", "--xyz", "0.17880240,-0.88205992,0.7", "--rpy", "0,0,0.3"), True,
         "own: outside limits: joint_2 by 0.4 m (numeric search, not proven)\n"),
        ((*LWR, *LOCKS, *POINT_1[:2], "--rpy", "1,0.3,0"), False,
         f"lwr4plus: {MISSED}14.57 deg (numeric search, not proven)\n"),
    ],
)  # fmt: skip
def test_what_cannot_be_reached_is_exit_1_with_one_line(lwr_dyn_command, folder, arguments, out, said):
    (folder / "own.toml").write_text(template("own.toml", "own", "RPR"), encoding="utf-8")
    code, text, err = lwr_dyn_command(*arguments)
    assert (code, bool(text), err) == (1, out, f"lwr-dyn: {said}")
    record = json.loads(lwr_dyn_command(*arguments, "--json")[1])
    assert record["solutions"] == []
    assert bool(record["outside"]) == out


NO_ANGLES = "given without an orientation; allowed: with --rpy or --rpy-deg or --abc-deg"
ORIENTED = ("--xyz", "0,0,1", "--rpy", "0,0,0")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--rpy", "0,0,1"), "--xyz, --xyz-mm: neither given; allowed: one of them"),
        (("--xyz", "0,0,1", "--xyz-mm", "0,0,1"), "--xyz, --xyz-mm: both given; allowed: one of them"),
        (("--xyz", "0,0,1", "--turn", "2"), f"--status, --turn: {NO_ANGLES}"),
        (("--xyz", "0,0,1", "--status", "2"), f"--status, --turn: {NO_ANGLES}"),
        ((*ORIENTED, "--status", "2"), "--status, --turn: given for lwr4plus; allowed: only for an arm with KUKA's"),
        (("--xyz", "0,0,1", "--arm-angle-deg", "2"), "for a position only"),
        ((*ORIENTED, "--rpy-deg", "0,0,0"), "--rpy, --rpy-deg, --abc-deg: both given"),
        ((*ORIENTED, "--rpy-deg", "0,0,0", "--abc-deg", "0,0,0"), "--rpy, --rpy-deg, --abc-deg: several given"),
        (("--xyz", "0,0", "--rpy", "0,0,0"), "--xyz: 2 numbers; allowed: 3 numbers"),
        (("--xyz", "0,0,nan", "--rpy", "0,0,0"), "--xyz: nan at index (2,)"),
        (("--xyz", "0,0,1", "--abc-deg", "0,0"), "--abc-deg: 2 numbers; allowed: 3 numbers"),
        ((*ORIENTED, "--arm-angle-deg", "nan"), "arm_angle"),
        ((*ORIENTED, "--from-deg", "0,0"), "--from-deg: 2 numbers"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(arguments, message, refused):
    assert message in refused(*LWR, *arguments)


@pytest.mark.slow
def test_without_an_orientation_one_solution_near_a_start_is_given(printed, recorded):
    assert "one of many solutions for the position" in printed(*LWR, *POINT_1[:2])
    start = "10,-60,20,80,-30,40,50"
    (solution,) = recorded(*LWR, *POINT_1[:2], "--from-deg", start)["solutions"]
    arm = lwr_dyn.load("lwr4plus")
    T = lwr_dyn.forward_kinematics(arm, solution["q"])
    assert np.abs(T[:3, 3] - [-0.05, -0.45, 0.55]).max() < 1e-11
    q0 = np.radians([float(x) for x in start.split(",")])
    pose = pose_of([-0.05, -0.45, 0.55], [0, 0, 0], "xyz")
    expected = lwr_dyn.inverse_kinematics(arm, pose, position_only=True, q0=q0).solutions[0]
    np.testing.assert_allclose(solution["q"], expected.q, atol=1e-9)


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


def test_a_singular_wrist_is_said_to_stand_for_a_family(printed):
    out = printed(*KR, "--xyz-mm", "1840,0,1000", "--abc-deg", "0,90,0")
    assert "note: singular wrist" not in out
    T = lwr_dyn.forward_kinematics(lwr_dyn.load("kr30ha"), np.radians([20, -60, 80, 30, 0, 10]))
    place, rpy = (",".join(map(repr, x.tolist())) for x in (T[:3, 3], Rotation.from_matrix(T[:3, :3]).as_euler("xyz")))
    words = "note: singular wrist: such a solution is one of a family"
    out = printed(*KR, "--xyz", place, "--rpy", rpy)
    assert words in out
    assert "inside" in out
    assert "singular: wrist" in out


def test_a_sliding_joint_is_in_metres(printed, recorded, folder):
    (folder / "arm.toml").write_text(template("arm.toml", "arm", "RRPR", "modified"), encoding="utf-8")
    arm = lwr_dyn.load("arm.toml")
    q = np.array([0.2, 0.4, 0.5 * arm.upper[2], 0.1])
    xyz = ",".join(map(repr, lwr_dyn.forward_kinematics(arm, q)[:3, 3].tolist()))
    shown = np.where([True, True, False, True], np.degrees(q), q)
    line = ("ik", "arm.toml", "--xyz", xyz, "--from-deg", ",".join(map(repr, shown.tolist())))
    np.testing.assert_allclose(recorded(*line)["solutions"][0]["q"], q, atol=1e-9)
    lines = printed(*line).splitlines()
    assert any(x.endswith("; joints in deg (m for sliding joints)") for x in lines)
    row = next(x for x in lines if x.endswith("inside"))
    numbers = [float(x) for x in re.findall(r"-?\d+\.\d{4}", row)]
    assert numbers[:4] == pytest.approx(shown, abs=6e-5)
    margins = np.minimum(q - arm.lower, arm.upper - q)
    assert numbers[4] == pytest.approx(margins[2], abs=6e-5)
    assert row.split()[-2] == "joint_3"


@pytest.mark.parametrize(("robot", "rpy"), [("lwr4plus", (0.3, 0.5, 0.1)), ("kr30ha", (0.0, 1.5, 0.2))])
def test_the_nearest_point_is_on_the_border_of_reach(robot, rpy):
    arm = lwr_dyn.load(robot)
    place = [2.0, 2.5, 1.4]
    pose = pose_of(place, rpy, "xyz")
    result = lwr_dyn.inverse_kinematics(arm, pose)
    point = nearest_point(arm, pose, result)
    assert np.linalg.norm(point - place) == pytest.approx(result.distance, abs=1e-5)
    for share, status in ((1.001, "solved"), (0.999, "out of reach")):
        pose[:3, 3] = place + share * (point - place)
        assert lwr_dyn.inverse_kinematics(arm, pose, limits=False).status == status


@pytest.mark.slow
def test_a_distance_that_is_not_proven_gives_no_point():
    arm, pose = lwr_dyn.load("wam7"), pose_of([5.0, 0.0, 0.0], [0, 0, 0], "xyz")
    assert nearest_point(arm, pose, lwr_dyn.inverse_kinematics(arm, pose, solver="numeric")) is None
