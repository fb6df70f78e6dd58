"""The URDF text: numbers survive it bit for bit, names survive it whole, and each number leaves a trail."""

import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.arms.urdf.elements import UNKNOWN_POSITION, header, unknown_limits
from lwr_dyn.arms.urdf.geometry import primitives
from lwr_dyn.arms.urdf.writer import urdf_text, urdf_with_sources
from lwr_dyn.model.arm import JointLimits
from lwr_dyn.model.spatial import Pose, from_rpy, to_rpy
from tests.arms.urdf.small_files import assert_indented

ROUNDING = 2e-15
"""A rotation made of three, through its angles and back: entries are a few products of numbers below one."""


def tree_of(arm):
    return ElementTree.fromstring(urdf_text(arm))


def names(root, tag):
    return [x.get("name") for x in root.findall(tag)]


angles = st.tuples(*[st.floats(-3.2, 3.2)] * 3)


@given(angles, angles, st.sampled_from([1e-4, 1e-6, 1e-8, 1e-11, 0.0]), st.sampled_from([0, 1, -1]))
def test_angles_give_the_rotation_back_at_every_pitch(rpy, other, off, pole):
    """Near a pole the entries that distinguish roll from yaw are lost in rounding when the rotation is a product."""
    roll, pitch, yaw = rpy
    near = from_rpy((roll, pole * np.pi / 2 + off if pole else pitch, yaw))
    turn = from_rpy(other)
    rotation = turn @ (turn.T @ near)
    assert np.abs(from_rpy(to_rpy(rotation)) - rotation).max() <= ROUNDING


def test_inertials_are_written_bit_for_bit():
    arm = lwr_dyn.load("lwr4plus")
    root = tree_of(arm)
    for link, body in zip(arm.chain.links, arm.bodies(), strict=True):
        inertial = root.find(f"link[@name='{link.link}']/inertial")
        assert float(inertial.find("mass").get("value")) == body.mass
        assert [float(x) for x in inertial.find("origin").get("xyz").split()] == list(body.com)
        assert inertial.find("origin").get("rpy") == "0.0 0.0 0.0"
        written = {name: float(x) for name, x in inertial.find("inertia").attrib.items()}
        assert written == {f"i{a}{b}": body.inertia_com[r, c] for r, a in enumerate("xyz") for c, b in enumerate("xyz")
                           if c >= r}  # fmt: skip


def test_unknown_limits_are_stand_ins_and_unknown_friction_is_not_written():
    arm = lwr_dyn.load("lwr4")
    text = urdf_text(arm)
    limit = ElementTree.fromstring(text).find("joint[@name='joint_3']/limit")
    assert (float(limit.get("upper")), float(limit.get("effort"))) == (UNKNOWN_POSITION, 1e9)
    assert ("joint_3", "upper") in unknown_limits(arm)
    assert "joint_3 upper" in text.partition("-->")[0]
    root = tree_of(replace(arm, limits=(JointLimits(viscous=0.5, coulomb=0.0), *arm.limits[1:])))
    assert root.find("joint[@name='joint_1']/dynamics").attrib == {"damping": "0.5", "friction": "0.0"}
    assert root.find("joint[@name='joint_2']/dynamics") is None


def test_names_that_need_quoting_are_quoted_and_a_joint_called_flange_joint_keeps_its_name():
    arm, odd = lwr_dyn.load("lwr4"), 'a<b&"c"'
    first = replace(arm.chain.links[0], joint=odd, link=f"{odd}--")
    last = replace(arm.chain.links[-1], joint="flange_joint")
    chain = replace(arm.chain, links=(first, *arm.chain.links[1:-1], last))
    root = tree_of(replace(arm.with_chain(chain), title="x --> y"))
    joints = names(root, "joint")
    assert (joints[0], names(root, "link")[1], joints[-2:]) == (odd, f"{odd}--", ["flange_joint", "flange_joint_"])


@pytest.mark.parametrize(
    ("path", "quantities"),
    [
        ("/robot/joint[@name='joint_1']/origin/@xyz", ()),
        ("/robot/joint[@name='joint_4']/origin/@xyz", ("joint_3.after",)),
        ("/robot/joint[@name='flange_joint']/origin/@xyz", ("joint_7.after",)),
        ("/robot/link[@name='link_3']/inertial/origin/@xyz", ("link_3.com", "joint_3.after")),
    ],
)
def test_in_a_standard_table_the_row_before_places_a_joint(path, quantities):
    assert urdf_with_sources(lwr_dyn.load("lwr4plus")).attributes[path].quantities == quantities


def test_a_flange_of_its_own_is_a_quantity_beside_the_last_row():
    arm, shift = lwr_dyn.load("lwr4plus"), Pose(np.eye(3), np.array([0.0, 0.0, 0.1]))
    moved = replace(arm, chain=replace(arm.chain, flange=shift))
    sourced = replace(arm, sources={**arm.sources, "flange": arm.sources["joint_7.dh"]})
    path = "/robot/joint[@name='flange_joint']/origin/@xyz"
    for one in (moved, sourced):
        assert urdf_with_sources(one).attributes[path].quantities == ("joint_7.after", "flange")


def test_a_mount_and_a_tool_are_links_of_names_that_are_free():
    tool = {"xyz": [0.0, 0.0, 0.2], "rpy": [0.0, 0.3, 0.0], "mass": 1.0, "inertia": [1e-3] * 3}
    arm = lwr_dyn.load("lwr4plus", mount={"on": "ceiling", "xyz": [0, 0, 2]}, tool=tool)
    joint = replace(arm.chain.links[0], joint="mount", link="world")
    named = replace(arm, chain=replace(arm.chain, links=(joint, *arm.chain.links[1:])))
    for one, world, mount in ((arm, "world", "mount"), (named, "world_", "mount_")):
        root = tree_of(one)
        links = names(root, "link")
        assert (links[-2:], len(links)) == ([world, "tool"], one.n + 4)
        first, last = root.findall("joint")[-2:]
        ends = [(x.find("parent").get("link"), x.find("child").get("link")) for x in (first, last)]
        assert ends == [(world, "base"), ("flange", "tool")]
        assert (first.get("name"), last.get("name"), first.get("type")) == (mount, "tool_joint", "fixed")
        assert [float(x) for x in first.find("origin").get("xyz").split()] == [0.0, 0.0, 2.0]
        assert [float(x) for x in last.find("origin").get("xyz").split()] == [0.0, 0.0, 0.2]
        assert root.find("link[@name='tool']/inertial/mass").get("value") == "0.0"
    assert ["the base is mounted" in "".join(header(x)) for x in (arm, lwr_dyn.load("lwr4plus"))] == [True, False]
    weighing = lwr_dyn.load("lwr4plus", tool={"mass": 1.0, "inertia": [1e-3] * 3})
    assert "tool" not in names(tree_of(weighing), "link")


@pytest.mark.parametrize("name", ["lwr4plus", "lwr4", "wam7", "kr30ha", "panda"])
def test_each_line_is_one_tag_indented_by_its_depth(name):
    tool = {"xyz": [0.0, 0.0, 0.2]} | ({} if name == "lwr4" else {"mass": 1.0, "inertia": [1e-3] * 3})
    assert_indented(lwr_dyn.urdf_text(lwr_dyn.load(name, mount={"on": "wall"}, tool=tool)))


def test_links_without_a_mass_of_the_file_are_weightless_where_they_are_drawn(tmp_path):
    """A bare frame of a file stays bare; a drawn link that rests is weightless; a mass of the file is kept."""
    shape = "<visual><geometry><sphere radius='0.1'/></geometry></visual>"
    mass = '<inertial><mass value="3"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    fixed = '<joint name="{0}" type="fixed"><parent link="{1}"/><child link="{2}"/></joint>'
    text = (
        f'<robot name="r"><link name="ground"/><link name="drawn">{shape}</link><link name="heavy">{mass}</link>'
        f'<link name="arm">{mass}</link>{fixed.format("f1", "ground", "drawn")}{fixed.format("f2", "drawn", "heavy")}'
        '<joint name="j" type="revolute"><parent link="heavy"/><child link="arm"/>'
        '<limit lower="-1" upper="1" effort="9" velocity="1"/></joint></robot>'
    )
    path = tmp_path / "r.urdf"
    path.write_text(text, encoding="utf-8")
    root = tree_of(lwr_dyn.load(path))
    weights = {x.get("name"): x.find("inertial/mass") for x in root.findall("link")}
    assert weights["ground"] is None
    assert [float(weights[name].get("value")) for name in ("drawn", "heavy", "arm")] == [0.0, 3.0, 3.0]
    assert root.find("link[@name='drawn']/visual/geometry/sphere").get("radius") == "0.1"


def test_joints_and_motors_are_written_with_their_axes_and_names():
    arm = lwr_dyn.load("lwr4plus")
    root = tree_of(arm)
    parents = ["base", *(link.link for link in arm.chain.links)]
    for link, parent, joint in zip(arm.chain.links, parents, root.findall("joint"), strict=False):
        assert (joint.get("name"), joint.get("type")) == (link.joint, "revolute")
        assert (joint.find("parent").get("link"), joint.find("child").get("link")) == (parent, link.link)
        assert joint.find("axis").get("xyz") == "0.0 0.0 1.0"
        drive = root.find(f"transmission[@name='{link.joint}_transmission']")
        assert drive.find("type").text == "transmission_interface/SimpleTransmission"
        driven = (drive.find("joint").get("name"), drive.find("actuator").get("name"))
        assert driven == (link.joint, f"{link.joint}_motor")
    for tag in ("visual", "collision"):  # every drawn shape is both
        assert len(root.findall(f"link/{tag}")) == len(primitives(arm))
    assert names(root, "material") == ["orange", "grey", "dark"]
    assert {len(x.find("actuator")) for x in tree_of(lwr_dyn.load("lwr4")).findall("transmission")} == {0}
    assert "<!--" in urdf_text(arm)[:80]
    assert urdf_text(arm).endswith("</robot>\n")
