"""A mounted arm with a tool as a file: URDF, MJCF and sources, read again and by other engines."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.export.mjcf import mjcf_text
from lwr_dyn.arms.urdf.model_files import UNSOURCED, provenance_text
from lwr_dyn.arms.urdf.reader import read_urdf
from tests.arms.test_loading_installation import MOUNT, STATES, TOOL, relative
from tests.arms.urdf.small_files import LINK, joint, robot, written
from tests.tolerances import EXACT


def foreign(tmp_path):
    """A file whose root is called world, with a tool frame."""
    chain = [joint("pan", "world", "arm"), joint("tilt", "arm", "tool"), joint("weld", "tool", "tip", "fixed", "")]
    return written(tmp_path, robot(*chain, world="", arm=LINK, tool=LINK, tip=""))


@pytest.mark.parametrize("robot_name", ["lwr4plus", "wam7", ""])
def test_the_written_urdf_is_the_installed_arm(robot_name, tmp_path):
    arm = lwr_dyn.load(robot_name or foreign(tmp_path), mount=MOUNT, tool=TOOL)
    again = read_urdf(written(tmp_path, lwr_dyn.urdf_text(arm), "again.urdf"))
    q = STATES[0, :, : arm.n]
    assert np.abs(lwr_dyn.forward_kinematics(again, q) - lwr_dyn.forward_kinematics(arm, q)).max() <= EXACT
    one, other = (lwr_dyn.dynamics_of(x) for x in (again, arm))
    assert relative(one.mass_matrix(q), other.mass_matrix(q)) <= EXACT
    assert relative(one.gravity_vector(q), other.gravity_vector(q)) <= EXACT


def test_the_links_of_the_written_file_are_world_and_tool_under_names_that_are_free(tmp_path):
    """Those of a robot of ours are in `test_writer.py`."""
    text = lwr_dyn.urdf_text(lwr_dyn.load(foreign(tmp_path), mount=MOUNT, tool=TOOL))
    for element in ('<link name="world_">', '<parent link="world_"/>', '<link name="tool_">'):
        assert element in text
    assert "world_" not in lwr_dyn.urdf_text(lwr_dyn.load(foreign(tmp_path), tool=TOOL))


@pytest.mark.parametrize("robot_name", ["lwr4plus", ""])
def test_drake_makes_the_same_of_the_written_urdf(robot_name, tmp_path):
    """Drake welds a link of the name world to its own, whose gravity is along -z."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    arm = lwr_dyn.load(robot_name or foreign(tmp_path), mount=MOUNT, tool=TOOL)
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(written(tmp_path, lwr_dyn.urdf_text(arm), "mounted.urdf")))
    plant.mutable_gravity_field().set_gravity_vector(arm.chain.gravity)
    plant.Finalize()
    context, q = plant.CreateDefaultContext(), STATES[0, 0, : arm.n]
    plant.SetPositions(context, q)
    g = lwr_dyn.dynamics_of(arm).gravity_vector(q)
    assert relative(-plant.CalcGravityGeneralizedForces(context), g) <= EXACT
    end = plant.GetFrameByName("tool" if robot_name else "tool_").CalcPoseInWorld(context).GetAsMatrix4()
    assert np.abs(end - lwr_dyn.forward_kinematics(arm, q)).max() <= EXACT


def test_mujoco_makes_the_same_of_the_written_mjcf():
    import mujoco

    arm = lwr_dyn.load("lwr4plus", mount=MOUNT, tool=TOOL)
    model = mujoco.MjModel.from_xml_string(mjcf_text(arm))
    data, g, T = mujoco.MjData(model), lwr_dyn.dynamics_of(arm).gravity_vector(STATES[0]), STATES[0]
    for q, torque, pose in zip(T, g, lwr_dyn.forward_kinematics(arm, T), strict=True):
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        assert np.abs(data.qfrc_bias - torque).max() <= EXACT * np.abs(g).max()
        assert np.abs(data.site_xpos[0] - pose[:3, 3]).max() <= EXACT


def test_every_number_of_mount_and_tool_has_its_source():
    record = json.loads(provenance_text(lwr_dyn.load("lwr4plus", mount=MOUNT, tool=TOOL)))
    assert record["attributes"]["/robot/joint[@name='mount']/origin/@xyz"]["quantities"] == ["mount"]
    assert record["quantities"]["mount"][0]["value"]["on"] == "wall"
    assert [cell["cell"] for cell in record["quantities"]["link_7.mass"]][-1] == "tool"
    assert len(record["quantities"]["link_7.mass"]) == 2
    assert not any(item.get("word") == UNSOURCED for item in record["attributes"].values())
