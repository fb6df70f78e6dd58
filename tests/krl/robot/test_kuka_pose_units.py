"""fk and ik of the KR 30 HA in SI and in KUKA's units, and one line for bad input."""

import numpy as np
import pytest

import lwr_dyn

SI = ("--xyz", "0,0.4,0.5", "--rpy", "0,0,0")
P1 = ("--xyz-mm", "91,-1139,1392", "--abc-deg", "0,0,0")


def test_fk_prints_both_units(printed):
    out = printed("fk", "kr30ha", "--q-deg", "0,-90,90,0,0,0")
    assert "position  1.340000000 0.000000000 1.810000000 m" in out
    assert "X 1340.000000, Y 0.000000, Z 1810.000000, A 0.000000, B 90.000000, C 0.000000, S 2, T 2" in out
    assert "B is +90 deg: A and C turn about one axis, only C - A counts" in out
    assert printed("fk", "kr30ha", "--axes-deg", "A3=90,A2=-90") == out


def test_fk_by_axis_name_and_json(recorded):
    record = recorded("fk", "kr30ha", "--axes-deg", "A3=90,A2=-90")
    assert record["position"] == pytest.approx([1.34, 0, 1.81])
    kuka = record["kuka"]
    assert (kuka["x_mm"], kuka["z_mm"], kuka["b_deg"], kuka["s"], kuka["t"]) == pytest.approx((1340, 1810, 90, 2, 2))
    assert kuka["axes_deg"] == pytest.approx({"A1": 0, "A2": -90, "A3": 90, "A4": 0, "A5": 0, "A6": 0})
    assert recorded("fk", "lwr4plus", "--q", "0,0,0,0,0,0,0")["kuka"] is None


def test_ik_in_kuka_units_and_in_si_are_one(arm, recorded):
    kuka = recorded("ik", "kr30ha", *P1)
    si = recorded("ik", "kr30ha", "--xyz", "0.091,-1.139,1.392", "--rpy", "0,0,0")
    assert kuka["complete"]
    assert len(kuka["solutions"]) == len(si["solutions"]) == 6
    for solution in kuka["solutions"]:
        T = lwr_dyn.forward_kinematics(arm, solution["q"])
        assert np.abs(T - kuka["T"]).max() < 1e-12
        assert solution["kuka"]["y_mm"] == pytest.approx(-1139)
        assert solution["kuka"]["axes_deg"]["A1"] == pytest.approx(85.432, abs=1e-3)
    assert {(s["kuka"]["s"], s["kuka"]["t"]) for s in kuka["solutions"]} == {
        (0, 44), (0, 12), (0, 36), (0, 4), (4, 52), (4, 20),
    }  # fmt: skip


def test_ik_chooses_by_status_turn_or_travel(recorded):
    only = recorded("ik", "kr30ha", *P1, "--status", "4", "--turn", "52")["solutions"]
    near = recorded("ik", "kr30ha", *P1, "--from-deg", "0,-90,90,0,0,0")["solutions"]
    assert [s["q"] for s in only] == [s["q"] for s in near]
    assert len(only) == 1


def test_ik_table_names_singularities(printed):
    out = printed("ik", "kr30ha", "--xyz-mm", "1340,0,1810", "--abc-deg", "0,90,0")
    assert "singular: wrist" in out
    assert "note: B is +90 deg" in out


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


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_one_line(name, lwr_dyn_command):
    arguments, code, message = BAD[name]
    ended, _, err = lwr_dyn_command(*arguments)
    assert (ended, err.count("\n")) == (code, 1)
    assert message in err
