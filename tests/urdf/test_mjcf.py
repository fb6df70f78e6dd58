"""The MJCF: shapes weigh nothing however it is compiled, and each joint has one motor."""

import xml.etree.ElementTree as ElementTree

import mujoco
import pytest

import lwr_dyn
from lwr_dyn.errors import MissingDataError
from lwr_dyn.urdf.mjcf import mjcf_text


def test_shapes_weigh_nothing_in_another_model_either():
    arm = lwr_dyn.load("lwr4plus")
    for compiler in ("<compiler ", '<compiler inertiafromgeom="false" ', '<compiler fusestatic="true" '):
        text = mjcf_text(arm).replace("<compiler ", compiler)
        weight = mujoco.MjModel.from_xml_string(text).body_mass.sum()
        assert weight == pytest.approx(sum(body.mass for body in arm.chain.bodies), rel=1e-14)


def test_a_motor_gives_what_the_joint_can_bear():
    arm = lwr_dyn.load("kr30ha")
    motors = ElementTree.fromstring(mjcf_text(arm)).findall("actuator/motor")
    assert [x.get("joint") for x in motors] == list(arm.joint_names)
    assert [x.get("ctrlrange") is None for x in motors] == [limits.effort is None for limits in arm.limits]


def test_an_arm_without_masses_has_no_mjcf():
    with pytest.raises(MissingDataError):
        mjcf_text(lwr_dyn.load("lwr4"))
