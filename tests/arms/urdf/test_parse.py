"""Parsing a URDF: names, digest, our own header, rotors, and what is refused before yourdfpy sees it."""

import hashlib

import pytest

import lwr_dyn
from lwr_dyn.arms.urdf.parse import parse_urdf, placeholder_name
from lwr_dyn.arms.urdf.writer import urdf_text
from lwr_dyn.foundation.errors import UrdfError

LINK = (
    '<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    '<visual><geometry><mesh filename="none.stl"/></geometry></visual>'
)
ONE = (
    f'<robot name="r"><link name="a"/><link name="b">{LINK}</link><joint name="j" type="revolute">'
    '<parent link="a"/><child link="b"/><limit lower="-1" upper="inf" effort="9" velocity="1"/></joint></robot>'
)
DRAKE = (
    '<transmission><joint name="j"/><actuator name="m"><drake:gear_ratio xmlns:drake="https://drake.mit.edu/" '
    'value="50"/></actuator></transmission></robot>'
)


def parsed(tmp_path, text):
    path = tmp_path / "arm.urdf"
    path.write_text(text, encoding="utf-8")
    return parse_urdf(path)


def test_links_joints_and_digest_of_a_foreign_file(tmp_path):
    urdf = parsed(tmp_path, ONE)
    assert (urdf.name, urdf.file, list(urdf.links), list(urdf.joints)) == ("r", "arm.urdf", ["a", "b"], ["j"])
    assert urdf.digest == hashlib.sha256(ONE.encode()).hexdigest()
    assert urdf.links["b"].visuals == []
    assert (urdf.rotors, urdf.gravity) == ({}, None)


def test_a_missing_inertia_of_a_rotor_is_zero_as_in_drake(tmp_path):
    rotor = parsed(tmp_path, ONE.replace("</robot>", DRAKE)).rotors["j"]
    assert (rotor.gear_ratio, rotor.inertia, rotor.reflected) == (50.0, 0.0, False)
    backwards, massless = DRAKE.replace("50", "-50"), ONE.replace('"2"', '"0"').replace('i="1"', 'i="0"')
    assert parsed(tmp_path, massless.replace("</robot>", backwards)).rotors["j"].gear_ratio == -50.0
    inertia = DRAKE.replace("gear_ratio", "rotor_inertia").replace('"50"', '"0"')
    rotor = parsed(tmp_path, ONE.replace("</robot>", inertia)).rotors["j"]
    assert (rotor.gear_ratio, rotor.inertia, rotor.reflected) == (1.0, 0.0, False)
    for lost in ('<joint name="j"/>', '<drake:gear_ratio xmlns:drake="https://drake.mit.edu/" value="50"/>'):
        assert parsed(tmp_path, ONE.replace("</robot>", DRAKE.replace(lost, ""))).rotors == {}


def test_gravity_and_unknown_limits_are_read_from_our_own_header_only(tmp_path):
    arm = lwr_dyn.load("wam7")
    text = urdf_text(arm)
    urdf = parsed(tmp_path, text)
    assert urdf.gravity == tuple(arm.chain.gravity)
    unknown = {
        placeholder_name(joint, name)
        for joint, limit in zip(arm.joint_names, arm.limits, strict=True)
        for name in ("lower", "upper", "effort", "velocity")
        if getattr(limit, name) is None
    }
    assert unknown <= urdf.placeholders
    foreign = parsed(tmp_path, text.replace("lwr_dyn", "another"))
    assert foreign.gravity is None
    assert not unknown & foreign.placeholders


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('lower="-1"', 'lower="x"', "joint 'j' <limit> lower: 'x'; allowed: a finite number"),
        ('lower="-1"', 'lower="nan"', "joint 'j' <limit> lower: 'nan'; allowed: a finite number"),
        ('child link="b"', 'child link="z"', "joint 'j' <child>: 'z'; allowed: the name of a link of the file"),
        ('<robot name="r">', "<robot>", "robot: no name; allowed: a name"),
        ('name="r"', 'name="r&#9;s"', r"robot: the name 'r\ts'"),
        ('joint name="j"', 'joint name="j&#9;"', r"joint 1: the name 'j\t'"),
        ('link name="b"', 'link name="a"', "link a: used twice; allowed: a name of its own"),
        ('link name="b"', "link", "link 2: no name; allowed: a name of its own"),
        (' type="revolute"', "", "joint 'j': no type; allowed: revolute, continuous, prismatic, fixed"),
        ('<parent link="a"/>', "", "joint 'j' <parent>: 'nothing'; allowed: the name of a link of the file"),
        (' izz="1"', "", "link 'b' <inertia> izz: missing; allowed: a number"),
        ('<mass value="2"/>', "", "link 'b' <mass> value: missing; allowed: a number"),
        ('<mass value="2"/>', '<mass value="-0.1"/>', "link 'b' <mass> value: '-0.1'; allowed: a mass of at least 0"),
        ('<mass value="2"/>', '<mass value="1 2"/>', "link 'b' <mass> value: '1 2'; allowed: a finite number"),
        ('ixy="0"', 'ixy="inf"', "link 'b' <inertia> ixy: 'inf'; allowed: a finite number"),
        ('<parent link="a"/>', '<parent link="a"/><axis xyz="0 1"/>',
         "joint 'j' <axis> xyz: '0 1'; allowed: 3 finite numbers, separated by spaces"),
        ('<parent link="a"/>', '<parent link="a"/><origin rpy="${pi} 0 0"/>',
         "joint 'j' <origin> rpy: '${pi} 0 0'; allowed: 3 finite numbers, separated by spaces; expand its"),
        ("</robot>", DRAKE.replace("gear_ratio", "rotor_inertia").replace("50", "inf"),
         "transmission of 'j' <drake:rotor_inertia> value: 'inf'; allowed: a finite number of at least 0"),
        ("</robot>", DRAKE.replace("50", "inf"), "<drake:gear_ratio> value: 'inf'; allowed: a finite number"),
        (
            "</robot>",
            DRAKE.replace("gear_ratio", "rotor_inertia").replace("50", "-1"),
            "<drake:rotor_inertia> value: '-1'; allowed: a finite number of at least 0",
        ),
    ],
)  # fmt: skip
def test_a_fault_names_its_element(tmp_path, old, new, message):
    with pytest.raises(UrdfError) as fault:
        parsed(tmp_path, ONE.replace(old, new))
    assert str(fault.value).startswith("arm.urdf: ")
    assert message in str(fault.value)
