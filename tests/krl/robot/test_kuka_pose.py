"""KUKA's pose: mm, A B C, Status and Turn; `fk` and `ik` in its units."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.kinematics.six_joints.spherical_wrist import require_wrist_arm
from lwr_dyn.krl.robot import kuka_pose as of_kuka
from lwr_dyn.model.spatial import rot_x, rot_y, rot_z

DIGITS = 1e-9
"""[mm, deg] A few roundings of a pose metres long."""


def six(pose):
    return (pose.x_mm, pose.y_mm, pose.z_mm, pose.a_deg, pose.b_deg, pose.c_deg)


def test_mastering_and_stretched_out_and_axes_turn_the_way_kuka_counts_them(arm):
    for q, pose, s, t in ((arm.mastering, (1340, 0, 1810, 0, 90, 0), 2, 2), ([0] * 6, (2190, 0, 960, 0, 90, 0), 0, 0)):
        found = of_kuka.kuka_pose(arm, np.array(q, dtype=float))
        assert (six(found), found.s, found.t) == (pytest.approx(pose, abs=DIGITS), s, t)
    steps = lwr_dyn.forward_kinematics(arm, 1e-3 * np.eye(6)[:3])[:, :3, 3] - [2.19, 0, 0.96]
    assert (steps[[0, 1, 2], [1, 2, 2]] < 0.0).all()  # A1 to -y, A2 and A3 to -z


@given(st.tuples(st.floats(-180, 180), st.floats(-90, 90), st.floats(-180, 180)))
def test_abc_there_and_back(abc):
    R = of_kuka.rotation_of_abc(abc)
    a, b, c = np.radians(abc)
    np.testing.assert_allclose(R, rot_z(a) @ rot_y(b) @ rot_x(c), atol=1e-15)
    np.testing.assert_allclose(of_kuka.rotation_of_abc(of_kuka.abc_of_rotation(R)), R, atol=1e-11)


@pytest.mark.parametrize("b", [90.0, -90.0])
def test_at_b_of_ninety_a_is_zero_and_c_takes_all(b):
    assert of_kuka.degenerate_abc((0, b, 0))
    assert not of_kuka.degenerate_abc((0, 0.99 * b, 0))
    found = of_kuka.abc_of_rotation(of_kuka.rotation_of_abc((20.0, b, 50.0)))
    assert found == pytest.approx((0.0, b, 50.0 - 20.0 * np.sign(b)))


def test_a_pose_is_its_matrix():
    pose = of_kuka.KukaPose(91.0, -1139.0, 1392.0, 10.0, 20.0, 30.0)
    assert six(of_kuka.pose_of_matrix(pose.matrix())) == pytest.approx(six(pose), abs=DIGITS)
    with pytest.raises(ShapeError):
        of_kuka.rotation_of_abc((1.0, 2.0))


def test_status_and_turn_bits_one_by_one(arm):
    phi = np.degrees(np.arctan2(145, 820))
    assert np.degrees(require_wrist_arm(arm).straight) == pytest.approx(phi)
    for degrees, s in (
        ((0, -90, 90, 0, 0, 0), 0b010),
        ((0, -30, phi - 0.01, 0, 0, 0), 0b000),
        ((0, -30, phi + 0.01, 0, 0, 0), 0b010),
        ((0, -30, 0, 0, -5, 0), 0b100),
        ((0, -30, 0, 0, 5, 0), 0b000),
        ((0, -130, -30, 0, 5, 0), 0b001),
        ((100, -130, -30, 0, -5, 0), 0b101),
    ):
        assert of_kuka.status(arm, np.radians(degrees)) == s, degrees
    rng = np.random.default_rng(0)
    for q in rng.uniform(arm.lower, arm.upper, (200, 6)):  # it does not change with the direction of the arm
        assert of_kuka.status(arm, q) == of_kuka.status(arm, np.append(rng.uniform(arm.lower[0], arm.upper[0]), q[1:]))
    assert of_kuka.turn(np.radians([-1, 1, -1, 1, -1, 1])) == 0b010101
    assert of_kuka.turn(np.array([-1e-15, 0, 0, 0, 0, -0.0])) == 0


def test_branches_of_one_pose_differ_in_status_which_chooses_among_them(arm):
    q = np.radians([20.0, -110.0, 110.0, 40.0, 50.0, -70.0])
    result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, q), limits=False)
    pairs = [(of_kuka.status(arm, s.q), of_kuka.turn(s.q)) for s in result.solutions]
    assert {s for s, _ in pairs} == set(range(8))
    assert len(set(pairs)) == len(pairs)
    q = np.radians([20.0, -60.0, 100.0, 40.0, 50.0, -70.0])
    result = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, q)).solutions
    (only,) = of_kuka.with_status_and_turn(arm, result, of_kuka.status(arm, q), of_kuka.turn(q))
    assert np.abs(only.q - q).max() < 1e-9
    assert len(of_kuka.with_status_and_turn(arm, result)) == len(result)
    for solutions, asked, words in (
        (result, (7, 1), "no solution has S 7, T 1; allowed: S "),
        ((), (0,), "the pose has no solution"),
    ):
        with pytest.raises(OptionError, match=words):
            of_kuka.with_status_and_turn(arm, solutions, *asked)


def test_kuka_axes_are_recognised(arm):
    arms = (arm, lwr_dyn.load("kr30ha", "printed"), lwr_dyn.load("lwr4plus"))
    assert [of_kuka.has_kuka_axes(x) for x in arms] == [True, False, False]


P1 = ("--xyz-mm", "91,-1139,1392", "--abc-deg", "0,0,0")
HOME = ("--axes-deg", "A3=90,A2=-90")


def test_fk_gives_both_units_by_axis_names_and_a_singular_pose_is_named(printed, recorded):
    out = printed("fk", "kr30ha", "--q-deg", "0,-90,90,0,0,0")
    for line in ("position  1.340000000 0.000000000 1.810000000 m", "B is +90 deg: A and C turn about one axis, only",
                 "X 1340.000000, Y 0.000000, Z 1810.000000, A 0.000000, B 90.000000, C 0.000000, S 2, T"):  # fmt: skip
        assert line in out
    assert printed("fk", "kr30ha", *HOME) == out
    record = recorded("fk", "kr30ha", *HOME)
    kuka = record["kuka"]
    assert record["position"] == pytest.approx([1.34, 0, 1.81])
    assert (kuka["x_mm"], kuka["z_mm"], kuka["b_deg"], kuka["s"], kuka["t"]) == pytest.approx((1340, 1810, 90, 2, 2))
    assert kuka["axes_deg"] == pytest.approx({"A1": 0, "A2": -90, "A3": 90, "A4": 0, "A5": 0, "A6": 0})
    assert recorded("fk", "lwr4plus", "--q", "0,0,0,0,0,0,0")["kuka"] is None
    out = printed("ik", "kr30ha", "--xyz-mm", "1340,0,1810", "--abc-deg", "0,90,0")
    assert "singular: wrist" in out
    assert "note: B is +90 deg" in out


def test_ik_in_kuka_units_and_in_si_are_one_and_status_turn_or_travel_choose(arm, recorded):
    kuka = recorded("ik", "kr30ha", *P1)
    si = recorded("ik", "kr30ha", "--xyz", "0.091,-1.139,1.392", "--rpy", "0,0,0")
    assert (kuka["complete"], len(kuka["solutions"]), len(si["solutions"])) == (True, 6, 6)
    for solution in kuka["solutions"]:
        T = lwr_dyn.forward_kinematics(arm, solution["q"])
        assert np.abs(T - kuka["T"]).max() < 1e-12
        assert solution["kuka"]["y_mm"] == pytest.approx(-1139)
        assert solution["kuka"]["axes_deg"]["A1"] == pytest.approx(85.432, abs=1e-3)
    pairs = {(0, 44), (0, 12), (0, 36), (0, 4), (4, 52), (4, 20)}
    assert {(s["kuka"]["s"], s["kuka"]["t"]) for s in kuka["solutions"]} == pairs
    (only,) = recorded("ik", "kr30ha", *P1, "--status", "4", "--turn", "52")["solutions"]
    (near,) = recorded("ik", "kr30ha", *P1, "--from-deg", "0,-90,90,0,0,0")["solutions"]
    assert only["q"] == near["q"]


SI = ("--xyz", "0,0.4,0.5", "--rpy", "0,0,0")
BAD = {
    "S that no branch has": (("ik", "kr30ha", *P1, "--status", "2"), 2, "no solution has S 2; allowed: S 0 T 4,"),
    "T that no branch has": (("ik", "kr30ha", *P1, "--turn", "1"), 2, "no solution has T 1; allowed: S 0 T 4,"),
    "S of another arm": (("ik", "lwr4plus", *SI, "--status", "2"), 2, "only for an arm with KUKA's axes"),
    "two positions": (("ik", "kr30ha", *P1, "--xyz", "0,0,0"), 2, "--xyz, --xyz-mm: both given"),
    "three orientations": (("ik", "kr30ha", *P1, "--rpy", "0,0,0", "--rpy-deg", "0,0,0"), 2, "several given"),
    "ABC of two": (("ik", "kr30ha", "--xyz-mm", "0,0,0", "--abc-deg", "0,0"), 2, "--abc-deg: 2 numbers; allowed: 3"),
    "out of reach": (("ik", "kr30ha", "--xyz-mm", "2600,0,900", "--abc-deg", "0,90,0"), 1, "of reach by 0.399015 m"),
    "outside limits": (("ik", "kr30ha", "--xyz-mm", "91,-139,292", "--abc-deg", "0,0,0"), 1, "limits: A2 by 0.11"),
    "arm angle": (("ik", "kr30ha", *P1, "--arm-angle-deg", "3"), 2, "only for an S-R-S arm"),
}  # fmt: skip


@pytest.mark.parametrize(("arguments", "code", "message"), BAD.values(), ids=BAD)
def test_bad_input_is_one_line(arguments, code, message, lwr_dyn_command):
    ended, _, err = lwr_dyn_command(*arguments)
    assert (ended, err.count("\n")) == (code, 1)
    assert message in err
