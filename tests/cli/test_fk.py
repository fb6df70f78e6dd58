"""`lwr-dyn fk`: the pose beside forward kinematics in text and record, positions in every form, bad input."""

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lwr_dyn
from lwr_dyn.arms.papers.catalog import template

Q = np.radians([0, -90, 90, 0, 130, 20])
POINT = [0.01, 0.02, 0.1]


def test_text_and_record_are_those_of_the_pose(recorded, printed):
    arm = lwr_dyn.load("kr30ha")
    T = lwr_dyn.forward_kinematics(arm, Q)
    at, rpy = T[:3, :3] @ POINT + T[:3, 3], Rotation.from_matrix(T[:3, :3]).as_euler("xyz")
    line = ("fk", "kr30ha", "--q-deg", "0,-90,90,0,130,20", "--point", "0.01,0.02,0.1")
    record = recorded(*line)
    expected = {"q": Q, "T": T, "position": T[:3, 3], "rpy": rpy, "point": POINT, "point_in_base": at}
    for name, numbers in expected.items():
        np.testing.assert_allclose(record[name], numbers, atol=1e-12)
    beyond = [f"A5 is outside its limits by {np.radians(130) - arm.upper[4]:.6g}"]
    assert (record["robot"], record["reading"], record["outside"]) == ("kr30ha", "kuka", beyond)
    assert list(record["kuka"]["axes_deg"].values()) == pytest.approx(np.degrees(Q))
    lines = printed(*line).splitlines()
    assert lines[0] == "kr30ha, reading kuka: flange in base, metres"
    shown = [[float(x) for x in re.findall(r"-?\d+\.\d+", text)] for text in lines]
    np.testing.assert_allclose(shown[1:5], T, atol=5.1e-9)
    np.testing.assert_allclose(shown[5], T[:3, 3], atol=5.1e-10)
    np.testing.assert_allclose(shown[6], np.degrees(rpy), atol=5.1e-7)
    np.testing.assert_allclose(shown[7][:3], at, atol=5.1e-10)
    assert lines[7].endswith("m  (flange 0.01, 0.02, 0.1)")
    assert shown[8][:3] == pytest.approx(1e3 * T[:3, 3], abs=1e-5)
    assert lines[9:] == [f"note: {beyond[0]}"]
    assert "point  " not in printed(*line[:4])
    assert "KUKA" not in printed("fk", "lwr4", "--q", "0,0,0,0,0,0,0")
    assert "note: B is +90 deg" in printed("fk", "kr30ha", "--axes-deg", "A2=-90,A3=90")
    assert "-0.0000" not in printed("fk", "kr30ha", "--axes-deg", "A2=-90,A3=90")


def test_positions_in_every_form_give_the_same_pose(recorded, folder):
    (folder / "own.toml").write_text(template("own.toml", "own", "RPR"), encoding="utf-8")
    ways = (("--axes-deg", "joint_3=90,joint_2=0.2"), ("--q-deg", "0,0.2,90"), ("--q", f"0,0.2,{np.pi / 2!r}"))
    records = [recorded("fk", "own.toml", *way) for way in ways]
    assert records[0] == records[1] == records[2]
    for form in (("--q-deg", "-90,0,0,0,0,0,0"), ("--q-deg=-90,0,0,0,0,0,0",)):
        assert recorded("fk", "lwr4", *form)["position"] == pytest.approx([0, 0, 0.79])


def test_the_exercise_from_the_command_line(recorded):
    record = recorded("fk", "lwr4", "--q-deg", "0,90,90,-90,0,90,0", "--point", "0,0.05,0.1")
    assert record["point_in_base"] == pytest.approx([-0.3, -0.39, -0.05])


SYMBOLS = "--symbolic: with --json, --q or --q-deg; allowed: --symbolic alone: it prints symbols as text"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--axes-deg", "A7=3"), "no joint of kr30ha named 'A7'; known: A1, A2"),
        (("--axes-deg", "A1"), "is not a list of axes; allowed: NAME=DEG"),
        (("--axes-deg", "A1=nan"), "--axes-deg: nan at index (0,)"),
        (("--q", "0,0,0,0,0,0", "--axes-deg", "A1=0"), "--q, --q-deg, --axes-deg: none or several given"),
        (("--q", "0,0,0,0,0,0", "--q-deg", "0,0,0,0,0,0"), "--q, --q-deg, --axes-deg: none or several given"),
        ((), "--q, --q-deg, --axes-deg: none or several given; allowed: one of them"),
        (("--q-deg", "-90,0"), "--q-deg: 2 numbers; allowed: 6 numbers: kr30ha has 6 joints"),
        (("--q-deg", "a,b"), "not a list of numbers"),
        (("--q", "nan,0,0,0,0,0"), "--q: nan at index (0,); allowed: finite numbers"),
        (("--q", "0,0,0,0,0,0", "--point", "1,2"), "--point: 2 numbers; allowed: 3 numbers"),
        (("--symbolic", "--json"), SYMBOLS),
        (("--symbolic", "--q", "0"), SYMBOLS),
        (("--symbolic", "--q-deg", "0"), SYMBOLS),
    ],
)
def test_bad_input_is_one_line(arguments, message, refused):
    assert message in refused("fk", "kr30ha", *arguments)


def test_symbols_need_a_table(refused):
    assert "--symbolic: x.urdf; allowed: a robot with a DH table" in refused("fk", "x.urdf", "--symbolic")
