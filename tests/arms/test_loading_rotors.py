"""Rotors given at loading: they are the diagonal of B, are carried on, and what lacks them says so."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.loading import arm_of
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.model.arm import caveats_of
from lwr_dyn.model.caveats import ABSENT_ROTORS, DYNAMICS
from tests.tolerances import EXACT

Q = np.array([0.1, -1.2, 1.4, 0.3, 0.7, -0.2])
ADVICE = (*DYNAMICS, ABSENT_ROTORS)
ZEROS = """<robot name="two">
  <link name="a"/>
  <joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="1"/><dynamics damping="0" friction="{friction}"/></joint>
  <link name="b"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>"""


@pytest.mark.parametrize("engine", ["pinocchio", "newton-euler"])
def test_they_are_added_to_the_diagonal_and_to_nothing_else(engine):
    bare, arm = lwr_dyn.load("kr30ha"), lwr_dyn.load("kr30ha", rotor={"A2": 80.0, "4": 0.25})
    # entries of B are up to 404 kg m^2
    more = lwr_dyn.dynamics_of(arm, engine).mass_matrix(Q) - lwr_dyn.dynamics_of(bare, engine).mass_matrix(Q)
    assert np.abs(more - np.diag([0, 80, 0, 0.25, 0, 0])).max() < EXACT * 400
    assert np.array_equal(*(lwr_dyn.dynamics_of(x, engine).gravity_vector(Q) for x in (bare, arm)))


def test_one_takes_the_place_of_the_sources_own():
    own, arm = lwr_dyn.load("lwr4plus"), lwr_dyn.load("lwr4plus", rotor={1: 0.5})
    assert arm.armature.tolist() == [0.5, *own.armature[1:]]
    assert [x.where for x in arm.sources["joint_1.armature"]] == ["option of loading"]
    assert arm.sources["joint_2.armature"] == own.sources["joint_2.armature"]


def test_a_file_beside_a_urdf_gives_them(tmp_path, lwr_dyn_command):
    (tmp_path / "rotors.toml").write_text("A2 = 80.0\n4 = 0.25\n")
    arm = lwr_dyn.load("kr30ha", rotor=tmp_path / "rotors.toml")
    assert arm.armature.tolist() == [0, 80, 0, 0.25, 0, 0]
    code, out, _ = lwr_dyn_command("urdf", "kr30ha", "--rotor", str(tmp_path / "rotors.toml"))
    assert (code, lwr_dyn_command("urdf", "kr30ha", "--rotor", "A2=80", "--rotor", "4=0.25")[1]) == (0, out)


def test_a_written_urdf_and_a_run_carry_them(tmp_path):
    arm = lwr_dyn.load("kr30ha", rotor={"A2": 80.0})
    for name, text in model_files(arm, "k").items():
        (tmp_path / name).write_text(text)
    assert lwr_dyn.load(tmp_path / "k.urdf").armature.tolist() == [0, 80, 0, 0, 0, 0]
    hold = lwr_dyn.reference("hold", arm, q=Q, duration=0.01)
    lwr_dyn.simulate(arm, lambda *_: np.zeros(6), hold).save(tmp_path / "x.npz")
    assert np.array_equal(arm_of(lwr_dyn.Run.load(tmp_path / "x.npz")).armature, arm.armature)


def test_advice_says_which_are_missing_and_other_commands_do_not(lwr_dyn_command):
    assert not any("no rotor" in line for line in caveats_of([lwr_dyn.load("kr30ha")], DYNAMICS))
    assert caveats_of([lwr_dyn.load("wam7"), lwr_dyn.load("lwr4plus")], ADVICE) == ()
    bare, some = lwr_dyn.load("kr30ha"), lwr_dyn.load("kr30ha", rotor=dict.fromkeys(("A1", "A2", "A3", "A4"), 1.0))
    assert "no rotor inertia given (--rotor JOINT=VALUE adds it)" in caveats_of([bare], ADVICE)[-1]
    assert "no rotor inertia of A5 and A6 given" in caveats_of([some], ADVICE)[-1]
    none = dict.fromkeys(("A1", "A2", "A3", "A4", "A5", "A6"), 0.0)
    assert lwr_dyn.load("kr30ha", rotor=none).rotor_caveat() == ""  # direct drives
    given = [x for i in range(1, 7) for x in ("--rotor", f"{i}=9")]
    for options, said in (((), [False, True]), (given, [False])):
        _, out, _ = lwr_dyn_command("margins", "kr30ha", "--json", *options)
        assert ["no rotor inertia given" in line for line in json.loads(out)["caveats"]] == said
    assert "rotor" not in lwr_dyn_command("fk", "kr30ha", "--q", "0,0,0,0,0,0")[1]


def test_friction_of_zero_is_no_friction_of_its_own(tmp_path):
    (tmp_path / "two.urdf").write_text(ZEROS.format(friction="0"))
    arm = lwr_dyn.load(tmp_path / "two.urdf")
    assert not arm.has_friction
    assert arm_with_friction(arm, 0.03).friction[0].positive.coulomb == pytest.approx(0.3)
    (tmp_path / "two.urdf").write_text(ZEROS.format(friction="0.1"))
    with pytest.raises(LwrDynError, match="has friction of its own"):
        arm_with_friction(lwr_dyn.load(tmp_path / "two.urdf"), 0.03)
