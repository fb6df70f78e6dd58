"""One fault at a time in an arm of boxes: its severity, code, link or joint and line, and what is said of it."""

import re

import pytest

from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.inertial_rules import arm_size, half_digit
from lwr_dyn.checks.urdf.lint import RULES, explanation, lint_document
from lwr_dyn.checks.urdf.reports import grouped
from lwr_dyn.checks.urdf.schema_rules import nearest
from lwr_dyn.checks.urdf.shape_rules import meshes_missing
from tests.checks.urdf.box_arm import BoxArm, said

GOOD = BoxArm().text().replace('"0 1 0"', '"0 0 1"')
"""With axes that turn no box into its parent, which is a note."""
MASS, TENSOR, BOX, SHIFT = '<mass value="[^"]*"', "<inertia [^>]*/>", '<box size="[^"]*"', '<origin xyz="[^"]*"'
INERTIAL = "<inertial>.*?</inertial>"
FIRST, SECOND = re.findall(INERTIAL, GOOD, re.DOTALL)[:2]


def tensor(ixx, iyy, izz, ixy="0"):
    return f'<inertia ixx="{ixx}" ixy="{ixy}" ixz="0" iyy="{iyy}" iyz="0" izz="{izz}"/>'


IN_JOINT = {
    'lower="-2" upper="2"': {
        'lower="-170" upper="170"': 'error limit-degrees: limits -170 to 170 rad … lower="-2.96706" upper="2.96706"',
        'lower="-2.967" upper="170"': "error limit-degrees: limits -2.967 to 170 rad; 27 turns to one side; -2.967 "
        'looks like rad … lower="-2.967" upper="2.96706"',
        'lower="-5" upper="170"': 'error limit-degrees: limits … "-0.0872665" upper="2.96706"',  # a whole number
        'lower="-7.5" upper="720"': 'error limit-degrees: limits … "-0.1309" upper="12.5664"',  # over a turn in rad
        'lower="-12.57" upper="0"': 'error limit-degrees: limits -12.57 to 0 rad; 2 … lower="-0.219388" upper="0"',
        'lower="-12.56" upper="12.56"': "no limit-degrees", 'lower="0" upper="721"': "no limit-degrees",
        'lower="-1e9" upper="721"': "warning limit-range: a limit of 1e+09 rad",
        'lower="1" upper="1"': "warning limit-equal: lower = upper = 1; the joint cannot move",
        "": "warning limit-equal: lower = upper = 0; neither is written",
        'lower="2" upper="-2"': 'error limit-exchanged: lower 2 is above upper -2 … lower="-2" upper="2"',
    },
    'velocity="2"': {
        'velocity="0"': "error velocity-zero: velocity limit 0 … the motor's velocity, in rad/s",
        'velocity="51"': 'warning velocity-degrees: velocity limit 51 rad/s … velocity="0.890118"',
        'velocity="50"': "no velocity-degrees", 'velocity="1e6"': "no velocity-degrees",
        'velocity="2864"': 'warning velocity-degrees: velocity limit 2864 rad/s … velocity="49.9862"',
        'velocity="2865"': "note velocity-degrees: velocity limit 2865 rad/s … the joint's speed in rad/s",
    },
    'effort="150.0"': {
        'effort="0"': "error effort-zero: effort limit 0 … the motor's effort, in N m",
        "": 'error attribute-missing: <limit> without effort … velocity="2" effort="..."',
    },
    "<limit [^>]*/>": {"": 'error limit-missing: no <limit> … or type="continuous"'},
    '<axis xyz="0 0 1"': {
        '<axis xyz="0 0 0"': "error axis-zero: the axis is 0 0 0", '<axis xyz="0 0 1.0009"': "no axis-not-unit",
        '<axis xyz="0 3 4"': 'warning axis-not-unit: the axis 0 3 4 has length 5 … <axis xyz="0 0.6 0.8"',
        '<axis xyz="0 0 0.9989"': 'warning axis-not-unit: the axis 0 0 0.9989 … <axis xyz="0 0 1"',
        '<axis xyz="0 1"': "error number-malformed: xyz of <axis> is '0 1'; 2 numbers where 3 belong",
        '<axis xyz="${axis}"': "error number-malformed: xyz of <axis> is '${axis}'; a xacro expression",
        '<axis colour="red" xyz="0 0 1"': "note attribute-unknown: colour of <axis> is not known; <axis> has xyz",
    },
    "<axis": {
        "<flavour/><axis": "note tag-unknown: <flavour> is not known here; <joint> holds origin, parent, child, axis",
        '<mimic joint="j9"/><axis': "error mimic-unknown: it mimics 'j9', which is no joint … <mimic joint=\"j1\"",
        '<mimic joint="j2"/><axis': 'error mimic-unknown: it mimics itself … <mimic joint="j1"',
    },
    SHIFT: {
        '<origin xyz="0 0 450"': 'error origin-millimetres: its origin is 450 m … 0.45 m; write <origin xyz="0 0 0.45"',
        '<origin xyz="0 0 9.1"': 'error origin-millimetres: its origin is 9.1 m … <origin xyz="0 0 0.0091"',
        '<origin xyz="0 0 8.9"': "no origin-millimetres",
        '<origin xzy="0 0 0.5"': 'error attribute-misspelt: xzy of <origin> looks like xyz … <origin xyz="0 0 0.5"',
        '<origin xzy="0 0 9" xyz="0 0 0.5"': "no attribute-misspelt",
        '<origin flavour="sweet" xyz="0 0 0.5"': "no attribute-misspelt",
    },
    "<origin ": {
        '<origin rpy="0 90 0" ': "error rpy-degrees: rpy 0 90 0 rad; 90 rad is 14.3 turns … rpy=\"0 1.5708 0\" xyz",
        '<origin rpy="0 6.9 7" ': "error rpy-degrees: rpy 0 6.9 7 rad; 7 rad is 1.1 turns",
        '<origin rpy="0 6.292 0" ': "no rpy-degrees", '<origin rpy="0 0 7.854" ': "no rpy-degrees",
        '<origin rpy="0.7071 0 0" ': "warning rpy-quaternion: rpy 0.7071 … angles 40.5 0.0 0.0 … \"1.57078 0 0",
        '<origin rpy="0 -1 0" ': 'note rpy-quaternion: rpy 0 -1 0 … angles 0.0 -57.3 … <origin rpy="3.14159 0 3.14159"',
        '<origin rpy="-0.5 0.5 0.5" ': 'warning rpy-quaternion: rpy -0.5 0.5 0.5 … <origin rpy="0 1.5708 1.5708"',
        '<origin rpy="0 0 0.38268343" ': 'warning rpy-quaternion: rpy 0 0 0.382683 … <origin rpy="0 0 0.785398"',
        **{f'<origin rpy="{x}" ': f"warning rpy-quaternion: rpy {x}" for x in ("0.7071 0.7071 0", "0 0.92388 0.38268")},
        **{f'<origin rpy="{x}" ': "no rpy-quaternion" for x in (
            "0.7 0 0", "0.5 0 0", "0.785398 0 0", "1.5708 0 3.14159", "0.7073 0.7073 0", "0.71 0.71 0", "0.5 0.5 0")},
    },
    '"revolute"': {
        '"revolut"': "error joint-type: type 'revolut'; known: revolute, continuous … type=\"revolute\"",
        '"ball"': "warning joint-type: type 'ball'", '""': "error joint-type: type ''",
        '"fixed"': "warning fixed-limits: a fixed joint with limits",
    },
    'parent link="l1"': {
        'parent link="l7"': "error link-unknown: parent 'l7' is no link of the file; its 4 links … <parent link=\"l0\"",
        'parent link="world"': "error link-unknown: parent 'world' is no link … <link name=\"world\"",
    },
    '<child link="l2"/>': {
        "": 'error link-unknown: no <child> … <child link="..."',
        '<child link="l1"/>': "error link-carried-twice: link l1 is carried by two joints; j1 carries it too, line 26",
    },
}  # fmt: skip
"""Pattern in the second joint -> what is written in its place -> the finding, or "no" and the code of a silent rule."""
IN_LINK = {
    MASS: {
        "<mass": 'error attribute-missing: <mass> without value … <mass value="..."',
        '<mass value="nan"': "error number-malformed: value of <mass> is 'nan'; not finite",
        '<mass value="1,5"': "error number-malformed: value of <mass> is '1,5'; a decimal … value=\"1.5\"",
        '<mass value="1e15"': "error number-malformed: value of <mass> is '1e15'; larger than any robot",
        '<mass value="9e14"': "no number-malformed", '<mass value="1999"': "no mass-grams",
        '<Mass value="1"': "error tag-misspelt: <Mass> looks like <mass>",
        '<mass value="-6.24"': 'error mass-negative: mass -6.24 kg … <mass value="6.24"',
        '<mass value="0"': "error mass-zero: mass 0 with an inertia that is not 0",
        '<mass value="2001"': 'error mass-grams: mass 2001 kg in an arm of 1 m … <mass value="2.001"',
    },
    "<mass [^>]*/>": {"": "error element-missing: <inertial> without <mass> … <mass value=.../>"},
    SHIFT: {
        '<origin xyz="10.1 0 0"': "error com-millimetres: its centre of mass is 10.1 m … is 1 m … xyz=\"0.0101 0 0\"",
        '<origin xyz="0 3.1 0"': "error com-millimetres: its centre of mass is 3.1 m",
        '<origin xyz="0 0 2.9"': "no com-millimetres",
    },
    'rpy="0.0 0.0 0.0"': {'rpy="0 0 180"': "error rpy-degrees: rpy 0 0 180 rad; 180 rad is 28.6 turns"},
    TENSOR: {
        tensor(-0.01, 0.14, 0.13): "error inertia-not-positive: the … -0.01 0.13 0.14 kg m^2; a diagonal",
        tensor(0.01, 0.14, 0.13, 0.5): "error inertia-not-positive: the … -0.429207 0.13 0.579207 … product of 0.5",
        tensor(0, 0.13, 0.13): "note inertia-not-positive: a principal moment is 0: 0 0.13 0.13 kg m^2",
        tensor("0.010", "0.140", "0.152"): "note inertia-triangle: principal moments … 0.152 > 0.01 + 0.14",
        tensor("0.010", "0.140", "0.156"): "error inertia-triangle: principal moments 0.01 0.14 0.156 kg m^2",
        tensor("0.01", "0.01", "0.03"): "warning inertia-triangle: principal moments 0.01 0.01 0.03 kg m^2",
        tensor("0.01", "0.13", "0.15"): "note inertia-triangle: principal", tensor(1, 13, 14): "no inertia-triangle",
        tensor(0, 0, 0): "warning inertia-zero: a mass of 6.24 kg with a tensor of 0",
        tensor(1, 1, 1): "warning inertial-placeholder: a stand-in: mass 6.24 kg, moments 1 kg m^2 … 0.49029 m away",
        tensor(10, 10, "1e1"): "error inertial-placeholder: a stand-in … would be 1.55043 m away on average",
        tensor(0.001, 0.001, "1e-3"): "warning inertial-placeholder: a stand-in … would be 0.0155043 m away",
        tensor(0.0037, 0.0037, 0.0037): "no inertial-placeholder", tensor(1, 1, 2): "no inertial-placeholder",
    },
    INERTIAL: {
        "": "error inertial-missing: no <inertial>; a joint moves it and it has shapes",
        r"\g<0><inertial/>": "warning element-twice: a second <inertial> in <link>", FIRST: "no inertial-equal",
        "<intertial></intertial>": "error tag-misspelt: <intertial> looks like <inertial>",
        SECOND: "note inertial-equal: its inertial is that of link l1",
        f'<inertial><mass value="0.5"/>{tensor(0, 0, 0)}</inertial>': "warning inertia-zero: a mass of 0.5 kg",
    },
    BOX: {
        '<mesh filename="no.stl"': "error mesh-missing: the mesh no.stl is not there; looked for no.stl",
        '<mesh filename="https://x.org/a.stl"': "note mesh-missing: the mesh https://x.org/a.stl is on the web",
        '<mesh filename="package://none_such/a.stl"': "note mesh-package: the package none_such is not … 1 meshes come",
        '<mesh filename="a.stl" scale="1 0 1"': "error mesh-scale: a mesh scale of 0",
        '<mesh filename="a.stl" scale="1 100 1"': "warning mesh-scale: a mesh scale of 1 100 1; the axes differ",
        '<mesh filename="a.stl" scale="1 -99 1"': "note mesh-scale: a mesh scale of 1 -99 1; the shape is a",
        '<mesh filename="a.stl" scale="-1 -1 1"': "no mesh-scale", '<box size="1e-9 1 1"': "no shape-size",
        '<box size="0 1 1"': "note shape-size: a box with a length of 0 m; the shape has no volume",
        '<box size="-1 1 1"': "error shape-size: a box with a length of -1 m; no body has it",
    },
}  # fmt: skip
"""The same of the last but one link."""
ELSEWHERE = {
    ("robot", "sdf"): "error root-tag: the outermost element is <sdf>; it is SDF (Gazebo)",
    ('<link name="l2">', "<link>"): 'error name-missing: <link> without a name … <link name="..."',
    ('<link name="l2">', '<link name="l1">'): "error name-twice: link l1: its name is used twice; first in line 8",
    ('name="j2"', 'name="j1"'): "error name-twice: joint j1: its name is used twice; first in line 26",
    ("</robot>", '<xacro:arg name="x"/></robot>'): "note xacro-leftover: <xacro:arg> is left over from xacro",
    ("</robot>", '<link name="more"/></robot>'): "error tree-roots: link more: 2 links without a parent: l0, more",
    ("</robot>", '<limk name="x"/></robot>'): "error tag-misspelt: limk x: <limk> looks like <link>",
    ('parent link="l0"', 'parent link="l3"'): "error tree-loop: link l1: a loop through l1, l2, l3; no root reaches",
    (f'(name="l0">.*?){MASS}', r'\1<mass value="-2"'): "error mass-negative: link l0: mass -2 kg … value=\"2\"",
}  # fmt: skip
"""(pattern, what is written in its place) -> the finding, with its subject."""
FAULTS = {
    **{(rf'(<{kind} name="{name}".*?){pattern}', r"\g<1>" * (new[:2] != r"\g") + new): (f"{kind} {name}: ", words)
       for kind, name, table in (("joint", "j2", IN_JOINT), ("link", "l2", IN_LINK))
       for pattern, rows in table.items() for new, words in rows.items()},
    **{change: ("", words) for change, words in ELSEWHERE.items()},
}  # fmt: skip


def found_in(text, code):
    return [f for f in lint_document(document_of(text, "boxes.urdf")).findings if f.code == code]


@pytest.mark.parametrize("change", FAULTS, ids=str)
def test_a_fault_is_found_where_it_is(change):
    subject, said_of = FAULTS[change]
    text, count = re.subn(*change, GOOD, count=0 if change[0] == "robot" else 1, flags=re.DOTALL)
    assert count
    level, code, *words = re.split(":? ", said_of, maxsplit=2)
    findings = found_in(text, code)
    assert said(findings, *(f"{level} {subject}{word}" for word in words))
    lines = enumerate(zip(text.split("\n"), GOOD.split("\n"), strict=False), start=1)
    changed = [n for n, (a, b) in lines if a != b]
    assert all(f.place.line in range(min(changed) - 1, max(changed) + 2) for f in findings)


def test_the_arm_itself_and_foreign_elements_give_no_finding():
    foreign = GOOD.replace('velocity="2"', 'velocity="1e9"').replace(
        "</robot>",
        '<gazebo><plugin filename="x"/></gazebo><transmission name="t"><type>a</type></transmission>'
        '<ros2_control name="r" type="system"><hardware/></ros2_control>'
        '<drake:collision_filter_group name="g"/></robot>',
    )
    assert [lint_document(document_of(text, "f")).findings for text in (GOOD, foreign)] == [(), ()]


def test_every_plain_rule_has_a_fault_here_and_every_rule_explains_itself():
    modules = ("schema_rules", "joint_rules", "inertial_rules")
    plain = {name for name, row in RULES.rows.items() if row.module.rsplit(".", 1)[-1] in modules}
    codes = {re.split(":? ", words)[1] for _, words in FAULTS.values()}
    assert codes >= plain | {"mesh-missing", "mesh-package", "mesh-scale", "shape-size"}
    assert all(len(explanation(code).split("\n\n", 1)[1]) > 60 for code in RULES.names)


def test_one_cause_of_several_rules_is_one_group():
    masses = re.sub(r'<mass value="([^"]*)"', lambda m: f'<mass value="{1000 * float(m[1])}"', GOOD)
    (group,) = grouped(lint_document(document_of(masses, "f")).findings)
    assert (group.cause, group.severity) == ("masses in g", "error")
    assert {f.code for f in group.findings} >= {"mass-grams", "density"}


def test_links_without_mass():
    """Between two joints, with no shape: a note; the last one: an error; where another is fixed to it: a note."""
    bare = r'(<link name="l{}">\n)<inertial>.*?</inertial>\n<visual>.*?</visual>'
    weld = '<joint name="weld" type="fixed"><parent link="l3"/><child link="tool"/></joint></robot>'
    tool = '<link name="tool"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>'
    two, three = (re.sub(bare.format(k), r"\1", GOOD, flags=re.DOTALL) for k in (2, 3))
    found = [found_in(text, "inertial-missing") for text in (two, three, three.replace("</robot>", tool + weld))]
    assert [[(f.level, f.what, f.why) for f in some] for some in found] == [
        [("note", "no <inertial>", "links further out have mass")],
        [("error", "no <inertial>", "a joint moves it and nothing else")],
        [("note", "no <inertial>", "its mass is that of links fixed to it")],
    ]
    zero = re.sub(f"{MASS}(/>\n){TENSOR}", rf'<mass value="0"\1{tensor(0, 0, 0)}', GOOD)
    assert found_in(zero, "inertial-missing") == []  # kinematics only


def test_parts_of_rules():
    document = document_of(GOOD, "f")
    assert arm_size(document) == pytest.approx(1.0, rel=1e-12)
    assert document.mass_beyond("l1", through_moving=False) == 0.0
    assert [half_digit(text) for text in ("12", "1.20", "2.5E-3", "1e99999", "1e5.5")] == [0.5, 0.005, 5e-5, 0.0, 0.0]
    known = ("friction", "damping", "rgba")
    words = ("fricton", "frction", "frcton", "fritcion", "frc", "rgb", "rg", "rbga", "rgbax", "velocity")
    assert [nearest(word, known) for word in words] == ["friction"] * 4 + [""] + ["rgba", "", "rgba", "rgba", ""]


def test_numbers_that_no_arithmetic_bears_do_not_stop_it():
    for number in ("1e308", "-1e308", "1e-320", "inf", "nan", "9" * 5000, "0x10", "\uff11", "1_0", "", "e"):
        text = re.sub(r'"-?\d+(\.\d+)?(e-?\d+)?"', f'"{number}"', GOOD)
        assert lint_document(document_of(text, "f")).findings
        text = re.sub(r'xyz="[^"]*"', f'xyz="{number} {number} 0"', GOOD)
        assert lint_document(document_of(text, "f")).findings


def test_a_mesh_that_misses_in_a_package_that_is_there_under_another_name(tmp_path):
    (tmp_path / "checkout" / "meshes").mkdir(parents=True)
    (tmp_path / "checkout" / "meshes" / "A.STL").write_bytes(b"")
    file = tmp_path / "checkout" / "x.urdf"
    shape = '<visual><geometry><mesh filename="package://pkg/meshes/{}"/></geometry></visual>'
    text = f'<robot name="r"><link name="a">{shape.format("A.STL")}{shape.format("b.stl")}</link></robot>'
    codes = {f.code for f in lint_document(document_of(text, str(file))).findings}
    assert (codes >= {"mesh-missing"}, "mesh-package" in codes) == (True, False)
    found = list(meshes_missing(document_of(text.replace("A.STL", "a.stl").replace("package://pkg/", ""), str(file))))
    assert [f.instead for f in found] == ["meshes/A.STL", ""]
