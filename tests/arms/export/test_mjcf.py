"""The MJCF: shapes weigh nothing however it is compiled, and each joint has one motor."""

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import mujoco
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.export.mjcf import mjcf_text, unheld_links
from lwr_dyn.arms.urdf.geometry import COLOURS, primitives
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.chain import Body
from tests.arms.urdf.small_files import assert_indented
from tests.random_arms import random_arm


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("<compiler ", "<compiler "),
        ("<compiler ", '<compiler inertiafromgeom="false" '),
        ("<compiler ", '<compiler fusestatic="true" '),
        ('density="0"', 'density="1000"'),
    ],
)
def test_shapes_weigh_nothing_in_another_model_or_where_their_density_is_changed(old, new):
    """MuJoCo below 3.3.7 refuses a body of which all shapes weigh nothing, if it makes its inertia of them."""
    arm = lwr_dyn.load("lwr4plus")
    weight = mujoco.MjModel.from_xml_string(mjcf_text(arm).replace(old, new)).body_mass.sum()
    assert weight == pytest.approx(sum(body.mass for body in arm.chain.bodies), rel=1e-14)


def test_a_motor_gives_what_the_joint_can_bear_and_a_frame_where_its_parent_is_has_no_axes():
    arm = lwr_dyn.load("kr30ha")
    motors = ElementTree.fromstring(mjcf_text(arm)).findall("actuator/motor")
    assert [x.get("joint") for x in motors] == list(arm.joint_names)
    efforts = [x.effort for x in arm.limits]
    assert [x.get("ctrlrange") for x in motors] == [None if x is None else f"{-x!r} {x!r}" for x in efforts]
    assert [x.get("name") for x in motors] == [f"{name}_motor" for name in arm.joint_names]
    text = mjcf_text(lwr_dyn.load("lwr4plus"))
    assert 'pos="0.0 0.0 0.0" xyaxes="1.0 0.0 0.0 0.0 1.0 0.0"' not in text
    assert text.count("xyaxes=") > 3


def test_shapes_stand_where_they_are_drawn_and_touch_nothing():
    tool = {"xyz": [0.0, 0.0, 0.2], "mass": 1.0, "inertia": [1e-3] * 3}
    for arm in (lwr_dyn.load("lwr4plus", mount="wall", tool=tool), lwr_dyn.load("kr30ha")):
        text = mjcf_text(arm)
        assert_indented(text)
        model = mujoco.MjModel.from_xml_string(text)
        bodies = [model.body(b).name for b in range(model.nbody)]
        drawn = sorted(primitives(arm), key=lambda x: bodies.index(x.link))
        for shape, geom in zip(drawn, map(model.geom, range(model.ngeom)), strict=True):
            turned = np.zeros(9)
            mujoco.mju_quat2Mat(turned, geom.quat)
            np.testing.assert_allclose(turned.reshape(3, 3), shape.pose.rotation, atol=1e-12)
            np.testing.assert_allclose(geom.pos, shape.pose.position, atol=1e-12)
            numbers = [bodies[geom.bodyid[0]], *geom.size[:2], *geom.contype, *geom.conaffinity, *geom.group]
            assert numbers == [shape.link, shape.radius, shape.length / 2, 0, 0, 2]
            np.testing.assert_allclose(model.mat_rgba[geom.matid[0]], COLOURS[shape.colour], rtol=1e-6)


def without_mass(arm, index, tensor):
    """The arm whose link (from 0) has this tensor and no mass."""
    links = list(arm.chain.links)
    links[index] = replace(links[index], body=replace(Body.massless(), inertia_com=tensor))
    return arm.with_chain(replace(arm.chain, links=tuple(links)))


def test_moments_without_mass_that_no_mjcf_holds_are_named_and_no_file_is_written(tmp_path, lwr_dyn_command):
    bare = without_mass(lwr_dyn.load("lwr4plus"), 2, np.diag([0.1, 0.1, 0.1]))
    axis, sliding = np.diag([0.0, 0.0, 0.1]), random_arm(1, "PR")
    assert unheld_links(without_mass(lwr_dyn.load("lwr4plus"), 0, axis)) == ()
    assert unheld_links(without_mass(sliding, 0, axis)) == (sliding.chain.links[0].link,)
    for arm, words in (
        (bare, "masses of link_3 not given; needed for MuJoCo"),
        (lwr_dyn.load("lwr4"), "masses and in"),
    ):
        with pytest.raises(MissingDataError, match=words):
            mjcf_text(arm)
    assert "x.xml" not in model_files(bare, "x")
    source, out = tmp_path / "bare.urdf", tmp_path / "x.urdf"
    source.write_text(lwr_dyn.urdf_text(bare), encoding="utf-8")
    code, text, err = lwr_dyn_command("urdf", str(source), "--out", str(out))
    assert not code
    assert "no x.xml: MuJoCo refuses a moving link without mass, as link_3" in text + err


@pytest.mark.parametrize("robot", ["puma560", "lwr4plus"])
def test_a_link_without_mass_moves_in_mujoco_as_here(robot):
    """The first link of the Puma has a moment about its axis, and nothing else; link 4 of the LWR is made so."""
    arm = lwr_dyn.load(robot)
    arm = arm if robot == "puma560" else without_mass(arm, 3, np.zeros((3, 3)))
    text, stands_in = mjcf_text(arm), "no mass, which MuJoCo refuses: 1e-09 kg and kg m^2 stand in"
    moved = "; its moment about its axis, 0.35 kg m^2, is in the armature of joint_1"
    line = f"  link_1: {stands_in}{moved}" if robot == "puma560" else f"  link_4: {stands_in}"
    assert line in text.splitlines()
    model = mujoco.MjModel.from_xml_string(text)
    data, dynamics = mujoco.MjData(model), lwr_dyn.dynamics_of(arm)
    x = np.random.default_rng(5).uniform(-1.0, 1.0, (3, arm.n))
    data.qpos[:], data.qvel[:], data.qacc[:] = x
    mujoco.mj_inverse(model, data)
    np.testing.assert_allclose(data.qfrc_inverse, dynamics.inverse_dynamics(*x), atol=1e-7)


def test_the_friction_of_the_wam_is_said_not_written_and_its_rotors_are_armature():
    arm = lwr_dyn.load("wam7")
    text = model_files(arm)["wam7.xml"]
    assert "friction differs by direction" in text
    assert "frictionloss" not in text
    assert re.findall(r'armature="([^"]+)"', text) == [str(x) for x in arm.armature.tolist()]
