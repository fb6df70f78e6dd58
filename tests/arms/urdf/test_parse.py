"""Parsing a URDF: names, digest, our own header, rotors, foreign XML, and what is refused before yourdfpy sees it."""

import hashlib

import pytest

import lwr_dyn
from lwr_dyn.arms.urdf.elements import WRITTEN_BY
from lwr_dyn.arms.urdf.parse import own_header, parse_urdf, parse_xml, placeholder_name
from lwr_dyn.arms.urdf.writer import urdf_text
from lwr_dyn.foundation.errors import UrdfError
from tests.arms.urdf.small_files import written

MASS, ORIGIN = '<mass value="2"/>', '<origin xyz="0 0 0"/>'
LINK = (
    '<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    '<visual><geometry><mesh filename="none.stl"/></geometry></visual>'
)
ONE = (
    f'<robot name="r"><link name="a"/><link name="b">{LINK}</link><joint name="j" type="revolute">'
    '<parent link="a"/><child link="b"/><origin xyz="0 0 0"/><limit lower="-1" upper="inf" effort="9" velocity="1"/>'
    "</joint></robot>"
)
DRAKE = (
    '<transmission><joint name="j"/><actuator name="m"><drake:gear_ratio xmlns:drake="https://drake.mit.edu/" '
    'value="50"/></actuator></transmission></robot>'
)


def parsed(tmp_path, text):
    return parse_urdf(written(tmp_path, text))


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
    assert own_header(f"<a/><!--{WRITTEN_BY} x\n  b--><!--c-->") == [f"{WRITTEN_BY} x", "b"]
    assert own_header(f"<!--a--><!--{WRITTEN_BY}-->") == own_header(WRITTEN_BY) == []  # the first comment alone


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('lower="-1"', 'lower="x"', "joint 'j' <limit> lower: 'x'; allowed: a finite number"),
        ('lower="-1"', 'lower="nan"', "joint 'j' <limit> lower: 'nan'; allowed: a finite number"),
        ('child link="b"', 'child link="z"', "joint 'j' <child>: 'z'; allowed: the name of a link of the file"),
        ('<child link="b"/>', "", "joint 'j' <child>: 'nothing'; allowed: the name of a link of the file"),
        ('<parent link="a"/>', "", "joint 'j' <parent>: 'nothing'; allowed: the name of a link of the file"),
        ('<robot name="r">', "<robot>", "robot: no name; allowed: a name"),
        ('name="r"', 'name="r&#9;s"', r"robot: the name 'r\ts'"),
        ('joint name="j"', 'joint name="j&#9;"', r"joint 1: the name 'j\t'"),
        ('link name="b"', 'link name="a"', "link a: used twice; allowed: a name of its own"),
        ('link name="b"', "link", "link 2: no name; allowed: a name of its own"),
        (' type="revolute"', "", "joint 'j': no type; allowed: revolute, continuous, prismatic, fixed"),
        (' izz="1"', "", "link 'b' <inertia> izz: missing; allowed: a number"),
        ('<mass value="2"/>', "", "link 'b' <mass> value: missing; allowed: a number"),
        *((MASS, MASS.replace("2", word), f"link 'b' <mass> value: {word!r}; allowed: a finite number")
          for word in ("1 2", "two", "inf", "1_0", "\u0661", "\uff11")),
        (MASS, '<mass value="-0.1"/>', "link 'b' <mass> value: '-0.1'; allowed: a mass of at least 0"),
        ('ixy="0"', 'ixy="inf"', "link 'b' <inertia> ixy: 'inf'; allowed: a finite number"),
        *((ORIGIN, f'<origin xyz="{word}"/>',
           f"joint 'j' <origin> xyz: '{word}'; allowed: 3 finite numbers, separated by spaces")
          for word in ("0 1", "nan 0 0")),
        (ORIGIN, '<axis xyz="0 1"/>', "joint 'j' <axis> xyz: '0 1'; allowed: 3 finite numbers, separated by spaces"),
        (ORIGIN, '<origin rpy="${pi} 0 0"/>',
         "joint 'j' <origin> rpy: '${pi} 0 0'; allowed: 3 finite numbers, separated by spaces; expand its"),
        ("</robot>", DRAKE.replace("50", "inf"), "<drake:gear_ratio> value: 'inf'; allowed: a finite number"),
        *(("</robot>", DRAKE.replace("gear_ratio", "rotor_inertia").replace("50", word),
           f"transmission of 'j' <drake:rotor_inertia> value: '{word}'; allowed: a finite number of at least 0")
          for word in ("inf", "-1")),
    ],
)  # fmt: skip
def test_a_fault_names_its_element(tmp_path, old, new, message):
    assert old in ONE
    with pytest.raises(UrdfError) as fault:
        parsed(tmp_path, ONE.replace(old, new))
    assert str(fault.value).startswith(
        f"arm.urdf: {message}" if message[0] != "<" else "arm.urdf: transmission of 'j' "
    )
    assert message in str(fault.value)


BODY = ONE.partition('name="r">')[2].removesuffix("</robot>")
XACRO = " xmlns:xacro='http://www.ros.org/wiki/xacro'"


def loaded(folder, inside, attributes="", name="arm.urdf"):
    return lwr_dyn.load(written(folder, f"<robot name='r'{attributes}>{inside}</robot>", name))


def test_undeclared_prefixes_are_read_as_engines_read_them_and_endings_count_in_any_case(tmp_path):
    drake = '<drake:gear_ratio value="50"/><drake:rotor_inertia value="0.01"/>'
    drive = f'<transmission><joint name="j"/><actuator name="m">{drake}</actuator></transmission>'
    arm = loaded(tmp_path, f'<!-- <robot name="x:y"> -->{BODY}{drive}<gazebo foo:bar="1"/>', name="arm.URDF")
    assert arm.armature.tolist() == [25.0]
    text = f'<robot name="r"><gazebo xmlns:foo="x" foo:a="1"/><gazebo foo:b="1"/>{BODY}</robot>'
    assert len(parse_xml(text.encode(), "arm.urdf")) == 5  # declared further in is not enough for the rest
    assert loaded(tmp_path, BODY, XACRO).n == 1  # a declaration that an expanded file kept is no macro


@pytest.mark.parametrize("tag", ["gazebo", "transmission", "visual"])
def test_elements_nested_without_end_are_refused(tag):
    text = f"<robot name='r'><{tag}>{'<x>' * 3000}{'</x>' * 3000}</{tag}></robot>"
    with pytest.raises(UrdfError, match="nested 3002 deep; allowed: at most 100 levels"):
        parse_xml(text.encode(), "arm.urdf")


@pytest.mark.parametrize("text", ["<robot name='r'><a:b/>", "<a:b/>", "<!-- <robot> --><a:b/>", "<robot x:='1'/>"])
def test_other_faults_of_the_xml_stay_faults(text):
    with pytest.raises(UrdfError, match="a well-formed URDF"):
        parse_xml(text.encode(), "arm.urdf")
    with pytest.raises(UrdfError, match="XML: mismatched tag: line 1, column 21; "):  # as it stands in the file
        parse_xml(b"<robot name='r'><x></robot><a:b/>", "arm.urdf")


@pytest.mark.parametrize("space", ["", XACRO])
def test_leftovers_of_xacro_that_make_nothing_are_passed_over(tmp_path, space):
    tags = "<xacro:include filename='$(find x)/a.xacro'/><xacro:macro name='m'><gazebo reference='${x}'/></xacro:macro>"
    tags += "<xacro:m x='b'/><xacro:m x='c'/><material name='grey'><xacro:grey/></material>"
    arm, plain = (loaded(tmp_path, x + BODY, space) for x in (tags, ""))
    assert [x.body.mass for x in arm.chain.links] == [x.body.mass for x in plain.chain.links] == [2.0]
    passed = "<xacro:include>, <xacro:macro>, <xacro:m>, <xacro:grey>"
    assert arm.notes == (f"arm.urdf: {passed} left over from xacro, passed over as every reader does",)
    assert plain.notes == ()


MACRO = "<xacro:macro name='m'>{}</xacro:macro>"


@pytest.mark.parametrize(
    ("space", "inside", "message"),
    [
        (XACRO, "<xacro:arm name='x'/>", "<xacro:arm>: a file of xacro macros; allowed: the URDF that it expands to, "
         "or a name that ends in .xacro: xacro arm.urdf > expanded.urdf"),
        ("", "<xacro:property name='x'/><link name='${x}'/>", "<xacro:property>: a file of xacro macros"),
        *(("", MACRO.format(part) + "<xacro:m/>", "<xacro:m>: a file of xacro macros")
          for part in ("<link name='z'/>", "<inertial/>", "<xacro:other/>")),
    ],
)  # fmt: skip
def test_a_xacro_is_named_with_the_command_that_expands_it(tmp_path, space, inside, message):
    with pytest.raises(UrdfError) as fault:
        loaded(tmp_path, inside + BODY, space)
    assert str(fault.value).startswith(f"arm.urdf: {message}")
    if "<xacro:m/>" in inside:  # a call that makes a part; the macro alone makes nothing
        assert loaded(tmp_path, inside.replace("<xacro:m/>", "") + BODY).n == 1
