"""Undeclared prefixes are read as the engines read them; a xacro is named; endings count in any case."""

import pytest

import lwr_dyn
from lwr_dyn.arms.urdf.parse import parse_xml
from lwr_dyn.foundation.errors import UrdfError

BODY = (
    '<link name="a"/><link name="b"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" '
    'iyz="0"/></inertial></link><joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
)
DRAKE = (
    '<transmission><joint name="j"/><actuator name="m"><drake:gear_ratio value="50"/>'
    '<drake:rotor_inertia value="0.01"/></actuator></transmission>'
)
URDF = f'<?xml version="1.0"?>\n<!-- <robot name="x:y"> -->\n<robot name="r">{BODY}{DRAKE}<gazebo foo:bar="1"/></robot>'


def loaded(folder, name, text):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return lwr_dyn.load(path)


def test_undeclared_prefixes_are_read_and_drakes_are_drakes(tmp_path):
    assert loaded(tmp_path, "arm.URDF", URDF).armature.tolist() == [25.0]


def test_a_prefix_declared_further_in_is_not_enough_for_the_rest():
    text = f'<robot name="r"><gazebo xmlns:foo="x" foo:a="1"/><gazebo foo:b="1"/>{BODY}</robot>'
    assert len(parse_xml(text.encode(), "arm.urdf")) == 5


@pytest.mark.parametrize("tag", ["gazebo", "transmission", "visual"])
def test_elements_nested_without_end_are_refused(tag):
    text = f"<robot name='r'><{tag}>{'<x>' * 3000}{'</x>' * 3000}</{tag}></robot>"
    with pytest.raises(UrdfError, match="nested 3002 deep; allowed: at most 100 levels"):
        parse_xml(text.encode(), "arm.urdf")


@pytest.mark.parametrize("text", ["<robot name='r'><a:b/>", "<a:b/>", "<!-- <robot> --><a:b/>", "<robot x:='1'/>"])
def test_other_faults_of_the_xml_stay_faults(text):
    with pytest.raises(UrdfError, match="a well-formed URDF"):
        parse_xml(text.encode(), "arm.urdf")


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        (
            "arm.urdf",
            f"<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:arm name='x'/>{BODY}</robot>",
            "arm.urdf: <xacro:arm>: a file of xacro macros; allowed: the URDF that it expands to, or a "
            "name that ends in .xacro: xacro arm.urdf > expanded.urdf",
        ),
        (
            "arm.urdf",
            f"<robot name='r'><xacro:property name='x'/>{BODY}<link name='${{x}}'/></robot>",
            "arm.urdf: <xacro:property>: a file of xacro macros",
        ),
    ],
)
def test_a_xacro_is_named_with_the_command_that_expands_it(tmp_path, name, text, message):
    with pytest.raises(UrdfError) as fault:
        loaded(tmp_path, name, text)
    assert message in str(fault.value)


@pytest.mark.parametrize("space", ["", " xmlns:xacro='http://www.ros.org/wiki/xacro'"])
def test_leftovers_that_make_nothing_are_passed_over(tmp_path, space):
    tags = "<xacro:include filename='$(find x)/a.xacro'/><xacro:macro name='m'><gazebo reference='${x}'/></xacro:macro>"
    tags += "<xacro:m x='b'/><xacro:m x='c'/><material name='grey'><xacro:grey/></material>"
    arm, plain = (loaded(tmp_path, "arm.urdf", f"<robot name='r'{space}>{x}{BODY}</robot>") for x in (tags, ""))
    assert arm.n == plain.n == 1
    assert [x.body.mass for x in arm.chain.links] == [x.body.mass for x in plain.chain.links]
    assert arm.notes == (
        "arm.urdf: <xacro:include>, <xacro:macro>, <xacro:m>, <xacro:grey> left over from xacro, "
        "passed over as every reader does",
    )
    assert plain.notes == ()


@pytest.mark.parametrize("body", ["<link name='z'/>", "<inertial/>", "<xacro:other/>"])
def test_a_call_of_a_macro_that_makes_a_part_is_no_leftover(tmp_path, body):
    macro = f"<xacro:macro name='m'>{body}</xacro:macro>"
    assert loaded(tmp_path, "arm.urdf", f"<robot name='r'>{macro}{BODY}</robot>").n == 1
    with pytest.raises(UrdfError, match="<xacro:m>: a file of xacro macros"):
        loaded(tmp_path, "arm.urdf", f"<robot name='r'>{macro}{BODY}<xacro:m/></robot>")


def test_a_declaration_that_an_expanded_file_kept_is_no_macro(tmp_path):
    text = f"<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>{BODY}</robot>"
    assert loaded(tmp_path, "arm.urdf", text).n == 1


@pytest.mark.parametrize("word", ["1_0", "\u0661", "\uff11"])
def test_a_mass_of_pythons_own_digits_is_a_slip(tmp_path, word):
    with pytest.raises(UrdfError, match=r"link 'b' <mass> value: .* allowed: a finite number"):
        loaded(tmp_path, "arm.urdf", URDF.replace('mass value="2"', f'mass value="{word}"'))
