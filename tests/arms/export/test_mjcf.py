"""The MJCF: shapes weigh nothing however it is compiled, and each joint has one motor."""

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import mujoco
import pytest
from click.testing import CliRunner

import lwr_dyn
from lwr_dyn.arms.export.mjcf import mjcf_text
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.cli.urdf import command
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.chain import Body


def test_shapes_weigh_nothing_in_another_model_either():
    arm = lwr_dyn.load("lwr4plus")
    for compiler in ("<compiler ", '<compiler inertiafromgeom="false" ', '<compiler fusestatic="true" '):
        text = mjcf_text(arm).replace("<compiler ", compiler)
        weight = mujoco.MjModel.from_xml_string(text).body_mass.sum()
        assert weight == pytest.approx(sum(body.mass for body in arm.chain.bodies), rel=1e-14)


def test_no_inertia_is_made_of_shapes_even_where_their_density_is_changed():
    """MuJoCo below 3.3.7 refuses a body of which all shapes weigh nothing, if it makes its inertia of them."""
    arm = lwr_dyn.load("lwr4plus")
    model = mujoco.MjModel.from_xml_string(mjcf_text(arm).replace('density="0"', 'density="1000"'))
    assert model.body_mass.sum() == pytest.approx(sum(body.mass for body in arm.chain.bodies), rel=1e-14)


def test_a_motor_gives_what_the_joint_can_bear():
    arm = lwr_dyn.load("kr30ha")
    motors = ElementTree.fromstring(mjcf_text(arm)).findall("actuator/motor")
    assert [x.get("joint") for x in motors] == list(arm.joint_names)
    assert [x.get("ctrlrange") is None for x in motors] == [limits.effort is None for limits in arm.limits]


def test_an_arm_without_masses_has_no_mjcf():
    with pytest.raises(MissingDataError):
        mjcf_text(lwr_dyn.load("lwr4"))


def test_a_moving_link_of_mass_0_is_named_and_no_file_is_written(tmp_path):
    arm = lwr_dyn.load("lwr4plus")
    first = replace(arm.chain.links[0], body=Body.massless())
    bare = arm.with_chain(replace(arm.chain, links=(first, *arm.chain.links[1:])))
    with pytest.raises(MissingDataError, match="masses of link_1 not given; needed for MuJoCo"):
        mjcf_text(bare)
    assert "x.xml" not in model_files(bare, "x")
    source, out = tmp_path / "bare.urdf", tmp_path / "x.urdf"
    source.write_text(lwr_dyn.urdf_text(bare), encoding="utf-8")
    result = CliRunner().invoke(command, [str(source), "--out", str(out)])
    assert result.exit_code == 0
    assert "no x.xml: MuJoCo refuses a moving link without mass, as link_1" in result.output


def test_a_frame_that_is_where_its_parent_is_has_no_axes():
    text = mjcf_text(lwr_dyn.load("lwr4plus"))
    assert 'pos="0.0 0.0 0.0" xyaxes="1.0 0.0 0.0 0.0 1.0 0.0"' not in text
    assert text.count("xyaxes=") > 3


def test_the_friction_of_the_wam_is_said_not_written_and_its_rotors_are_armature():
    arm = lwr_dyn.load("wam7")
    text = model_files(arm)["wam7.xml"]
    assert "friction differs by direction" in text
    assert "frictionloss" not in text
    assert re.findall(r'armature="([^"]+)"', text) == [str(x) for x in arm.armature.tolist()]
