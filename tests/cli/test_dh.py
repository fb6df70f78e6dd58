"""`lwr-dyn dh` and the formats of `lwr-dyn urdf --out`, as a user types them."""

import mujoco
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.urdf.model_files import FORMATS
from tests.agreement.test_foreign_arms import ROBOTS
from tests.arms.export.test_data_file import FOREIGN

UR10 = str(ROBOTS / FOREIGN["ur10"][0])


def test_both_tables_with_what_they_leave(printed):
    out = printed("dh", UR10, "--tip", "tool0")
    assert "standard DH" in out
    assert "modified DH" in out
    assert out.count("  d [m]") == out.count("theta [deg]") == 2
    assert out.count("flange by the table against the model:") == 2
    assert "shoulder_lift_joint  0.612   0            0         q" in out


def test_json_gives_the_numbers(recorded):
    (table,) = recorded("dh", "lwr4plus", "--convention", "modified")["tables"]
    assert table["rows"][2]["d"] == 0.4
    assert table["residual_m"] < 1e-12


def test_a_data_file_that_check_takes(lwr_dyn_command, tmp_path):
    out = tmp_path / "arm.toml"
    assert lwr_dyn_command("dh", "lwr4plus", "--convention", "modified", "--out", str(out))[0] == 0
    assert lwr_dyn_command("check", str(out))[0] == 0


@pytest.mark.parametrize("ending", FORMATS.names)
def test_the_ending_decides(printed, tmp_path, ending):
    path = tmp_path / f"arm{ending}"
    assert printed("urdf", "lwr4plus", "--out", str(path)) == f"wrote {path}\n"
    assert [x.name for x in tmp_path.iterdir()] == [path.name]


def test_a_foreign_file_as_mjcf_moves_the_same(lwr_dyn_command, tmp_path):
    path = tmp_path / "ur10.xml"
    assert lwr_dyn_command("urdf", UR10, "--tip", "tool0", "--out", str(path))[0] == 0
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    data.qpos[:] = q = np.linspace(-1, 1, 6)
    mujoco.mj_kinematics(model, data)
    T = lwr_dyn.forward_kinematics(lwr_dyn.load(UR10, tip="tool0"), q)
    assert np.abs(data.body("flange").xpos - T[:3, 3]).max() < 1e-12


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("urdf", "lwr4", "--out", "x.sdf"), "ends in '.sdf'; allowed: a path that ends in .urdf, .srdf, .xml, .toml"),
        (("urdf", "lwr4", "--out", "x.srdf"), "rotors not given"),
        (("urdf", "lwr4", "--out", "x.xml"), "masses and inertias not given"),
        (("dh", "lwr4", "--out", "x.csv"), "a path that ends in .toml"),
        (("dh", "lwr4", "--convention", "standart"), "did you mean standard?"),
    ],
)
def test_bad_input_gets_one_line(refused, folder, arguments, message):
    assert message in refused(*arguments)
    assert list(folder.iterdir()) == []


def test_a_file_beyond_a_dh_table_is_refused_where_only_a_table_is_read(lwr_dyn_command, refused, tmp_path):
    out = tmp_path / "arm.toml"
    lwr_dyn_command("dh", str(ROBOTS / FOREIGN["kinova"][0]), "--tip", FOREIGN["kinova"][1], "--out", str(out))
    assert "base.xyz; allowed: a DH table without it" in refused("conventions", str(out))
