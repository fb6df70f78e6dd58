"""One fault at a time in an arm of boxes: its code, its link or joint, its severity, its line."""

import re

import pytest

from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.inertial_rules import arm_size, half_digit, placeholders
from lwr_dyn.checks.urdf.joint_rules import angles_in_degrees, angles_of_quaternions, several_roots, velocity_in_degrees
from lwr_dyn.checks.urdf.lint import RULES, explanation, lint_document
from lwr_dyn.checks.urdf.reports import grouped
from lwr_dyn.checks.urdf.schema_rules import misspelt_tags, nearest
from lwr_dyn.checks.urdf.shape_rules import meshes_missing
from tests.checks.urdf.box_arm import BoxArm

GOOD = BoxArm().text().replace('"0 1 0"', '"0 0 1"')
"""With axes that turn no box into its parent, which is a note."""
_INERTIAL = r'(<link name="l2">\n)<inertial>.*?</inertial>'
_TENSOR = r'(<link name="l2">.*?)<inertia [^>]*/>'
_LIMIT = r'(name="j2".*?<limit )lower="-2" upper="2" effort="150.0" velocity="2"'
_AXIS = r'(name="j2".*?<axis xyz=)"0 0 1"'


def moments(ixx: str, iyy: str, izz: str, ixy: str = "0") -> str:
    """Replacement of the second link's tensor."""
    return rf'\1<inertia ixx="{ixx}" ixy="{ixy}" ixz="0" iyy="{iyy}" iyz="0" izz="{izz}"/>'


FAULTS = {
    "another root": ("robot", "sdf", "root-tag", "", "error"),
    "no name": (r'<link name="l2">', "<link>", "name-missing", "", "error"),
    "link twice": (r'<link name="l2">', '<link name="l1">', "name-twice", "link l1", "error"),
    "joint twice": ('name="j2"', 'name="j1"', "name-twice", "joint j1", "error"),
    "misspelt tag": (r'(name="l2">\n)<inertial>(.*?)</inertial>', r"\1<intertial>\2</intertial>", "tag-misspelt",
                     "link l2", "error"),
    "capital tag": (r'(name="l2">.*?)<mass ', r"\1<Mass ", "tag-misspelt", "link l2", "error"),
    "misspelt attribute": (r'(name="j2".*?)origin xyz', r"\1origin xzy", "attribute-misspelt", "joint j2", "error"),
    "unknown tag": (r'(name="j2".*?)<axis', r"\1<flavour/><axis", "tag-unknown", "joint j2", "note"),
    "leftover of xacro": (r"</robot>", '<xacro:include filename="x"/></robot>', "xacro-leftover", "", "note"),
    "unknown attribute": (r'(name="j2".*?)<axis', r'\1<axis colour="red"', "attribute-unknown", "joint j2", "note"),
    "no value": (r'(name="l2">.*?)<mass value="[^"]*"', r"\1<mass", "attribute-missing", "link l2", "error"),
    "no effort": (_LIMIT, r'\1lower="-2" upper="2" velocity="2"', "attribute-missing", "joint j2", "error"),
    "nan": (r'(name="l2">.*?)<mass value="[^"]*"', r'\1<mass value="nan"', "number-malformed", "link l2", "error"),
    "comma": (r'(name="l2">.*?)<mass value="[^"]*"', r'\1<mass value="1,5"', "number-malformed", "link l2", "error"),
    "two numbers": (_AXIS, r'\1"0 1"', "number-malformed", "joint j2", "error"),
    "xacro left": (_AXIS, r'\1"${axis}"', "number-malformed", "joint j2", "error"),
    "too large": (r'(name="l2">.*?)<mass value="[^"]*"', r'\1<mass value="1e300"', "number-malformed", "link l2",
                  "error"),
    "two inertials": (_INERTIAL, r"\g<0><inertial/>", "element-twice", "link l2", "warning"),
    "type": (r'(name="j2" type=)"revolute"', r'\1"revolut"', "joint-type", "joint j2", "error"),
    "type of Drake": (r'(name="j2" type=)"revolute"', r'\1"ball"', "joint-type", "joint j2", "warning"),
    "unknown parent": (r'(name="j2".*?)parent link="l1"', r'\1parent link="l7"', "link-unknown", "joint j2", "error"),
    "no child": (r'(name="j2".*?)<child link="l2"/>', r"\1", "link-unknown", "joint j2", "error"),
    "two roots": (r"</robot>", '<link name="more"/></robot>', "tree-roots", "link more", "error"),
    "carried twice": (r'(name="j3".*?)child link="l3"', r'\1child link="l2"', "link-carried-twice", "joint j3",
                      "error"),
    "loop": (r'(name="j1".*?)parent link="l0"', r'\1parent link="l3"', "tree-loop", "link l1", "error"),
    "mimic": (r'(name="j2".*?)<axis', r'\1<mimic joint="j9"/><axis', "mimic-unknown", "joint j2", "error"),
    "no limit": (r'(name="j2".*?)<limit [^>]*/>', r"\1", "limit-missing", "joint j2", "error"),
    "degrees": (_LIMIT, r'\1lower="-170" upper="170" effort="150" velocity="2"', "limit-degrees", "joint j2", "error"),
    "unlimited": (_LIMIT, r'\1lower="-1e9" upper="1e9" effort="150" velocity="2"', "limit-range", "joint j2",
                  "warning"),
    "equal": (_LIMIT, r'\1lower="1" upper="1" effort="150" velocity="2"', "limit-equal", "joint j2", "warning"),
    "not written": (_LIMIT, r'\1effort="150" velocity="2"', "limit-equal", "joint j2", "warning"),
    "exchanged": (_LIMIT, r'\1lower="2" upper="-2" effort="150" velocity="2"', "limit-exchanged", "joint j2", "error"),
    "no speed": (_LIMIT, r'\1lower="-2" upper="2" effort="150" velocity="0"', "velocity-zero", "joint j2", "error"),
    "deg/s": (_LIMIT, r'\1lower="-2" upper="2" effort="150" velocity="180"', "velocity-degrees", "joint j2", "warning"),
    "no speed known": (_LIMIT, r'\1lower="-2" upper="2" effort="150" velocity="50000"', "velocity-degrees", "joint j2",
                       "note"),
    "no effort at all": (_LIMIT, r'\1lower="-2" upper="2" effort="0" velocity="2"', "effort-zero", "joint j2", "error"),
    "axis 0": (_AXIS, r'\1"0 0 0"', "axis-zero", "joint j2", "error"),
    "axis 0 1 1": (_AXIS, r'\1"0 1 1"', "axis-not-unit", "joint j2", "warning"),
    "mm": (r'(name="j2".*?)origin xyz="[^"]*"', r'\1origin xyz="0 0 450"', "origin-millimetres", "joint j2", "error"),
    "small mm": (r'(name="j2".*?)origin xyz="[^"]*"', r'\1origin xyz="0 0 9.5"', "origin-millimetres", "joint j2",
                 "error"),
    "angle": (r'(name="j2".*?)<origin ', r'\1<origin rpy="0 90 0" ', "rpy-degrees", "joint j2", "error"),
    "angle of a tensor": (r'(name="l2">.*?rpy=)"[^"]*"', r'\1"0 0 180"', "rpy-degrees", "link l2", "error"),
    "quaternion": (r'(name="j2".*?)<origin ', r'\1<origin rpy="0.70711 0 0" ', "rpy-quaternion", "joint j2", "warning"),
    "half a turn": (r'(name="j2".*?)<origin ', r'\1<origin rpy="0 -1 0" ', "rpy-quaternion", "joint j2", "note"),
    "no mass": (r'(name="l2">.*?)<mass [^>]*/>', r"\1", "element-missing", "link l2", "error"),
    "empty type": (r'(name="j2" type=)"revolute"', r'\1""', "joint-type", "joint j2", "error"),
    "negative mass of the base": (r'(name="l0">.*?)<mass value="', r'\1<mass value="-', "mass-negative", "link l0",
                                  "error"),
    "fixed": (r'(name="j2" type=)"revolute"', r'\1"fixed"', "fixed-limits", "joint j2", "warning"),
    "no inertial": (_INERTIAL, r"\1", "inertial-missing", "link l2", "error"),
    "negative mass": (r'(name="l2">.*?)<mass value="', r'\1<mass value="-', "mass-negative", "link l2", "error"),
    "mass 0": (r'(name="l2">.*?)<mass value="[^"]*"', r'\1<mass value="0"', "mass-zero", "link l2", "error"),
    "grams": (r'(name="l2">.*?)<mass value="[^"]*"', r'\1<mass value="6240"', "mass-grams", "link l2", "error"),
    "centre in mm": (r'(name="l2">.*?)<origin xyz="[^"]*"', r'\1<origin xyz="220 10 0"', "com-millimetres", "link l2",
                     "error"),
    "negative moment": (_TENSOR, moments("-0.01", "0.14", "0.13"), "inertia-not-positive", "link l2", "error"),
    "large product": (_TENSOR, moments("0.01", "0.14", "0.13", "0.5"), "inertia-not-positive", "link l2", "error"),
    "moment 0": (_TENSOR, moments("0", "0.13", "0.13"), "inertia-not-positive", "link l2", "note"),
    "triangle": (_TENSOR, moments("0.01", "0.14", "0.30"), "inertia-triangle", "link l2", "error"),
    "triangle of coarse digits": (_TENSOR, moments("0.01", "0.01", "0.03"), "inertia-triangle", "link l2", "warning"),
    "triangle by rounding": (_TENSOR, moments("0.010", "0.130", "0.141"), "inertia-triangle", "link l2", "note"),
    "tensor 0": (_TENSOR, moments("0", "0", "0"), "inertia-zero", "link l2", "warning"),
    "1 kg m^2": (_TENSOR, moments("1", "1", "1"), "inertial-placeholder", "link l2", "warning"),
    "1e-3 kg m^2": (_TENSOR, moments("0.001", "0.001", "1e-3"), "inertial-placeholder", "link l2", "warning"),
    "copied": (r'(<inertial>(?:(?!</inertial>).)*</inertial>)((?:(?!<inertial>).)*<link name="l2">\n)<inertial>.*?'
               "</inertial>", r"\1\2\1", "inertial-equal", "link l2", "note"),
    "no mesh": (r'(name="l2">.*?)<box size="[^"]*"', r'\1<mesh filename="no.stl"', "mesh-missing", "link l2", "error"),
    "no package": (r'(name="l2">.*?)<box size="[^"]*"', r'\1<mesh filename="package://none_such/a.stl"', "mesh-package",
                   "link l2", "note"),
    "flat": (r'(name="l2">.*?)<box size="[^"]*"', r'\1<mesh filename="package://none_such/a.stl" scale="1 0 1"',
             "mesh-scale", "link l2", "error"),
    "box of 0": (r'(name="l2">.*?)<box size="[^"]*"', r'\1<box size="0 1 1"', "shape-size", "link l2", "note"),
    "box below 0": (r'(name="l2">.*?)<box size="[^"]*"', r'\1<box size="-1 1 1"', "shape-size", "link l2", "error"),
}  # fmt: skip


def test_the_arm_itself_gives_no_finding():
    report = lint_document(document_of(GOOD, "boxes.urdf"))
    assert [(f.code, f.message) for f in report.findings] == []


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_found_where_it_is(fault):
    pattern, written, code, subject, level = FAULTS[fault]
    text, count = re.subn(pattern, written, GOOD, count=0 if fault == "another root" else 1, flags=re.DOTALL)
    assert count
    findings = [f for f in lint_document(document_of(text, "boxes.urdf")).findings if f.code == code]
    assert [(f.subject, f.level) for f in findings] == [(subject, level)]
    changed = [n for n, (a, b) in enumerate(zip(text.split("\n"), GOOD.split("\n"), strict=False), start=1) if a != b]
    assert findings[0].place.line in range(min(changed) - 1, max(changed) + 2)


def test_every_plain_rule_has_a_fault_here():
    plain = [
        name for name, row in RULES.rows.items()
        if (row.module.rsplit(".", 1)[-1] in ("schema_rules", "joint_rules", "inertial_rules")
        and name not in ("effort-weight", "effort-unlike"))
        or name in ("mesh-missing", "mesh-package", "mesh-scale", "shape-size")
    ]  # fmt: skip
    assert {code for *_, code, _, _ in FAULTS.values()} >= set(plain)


def test_every_rule_explains_itself():
    for code in RULES.names:
        assert len(explanation(code).split("\n\n", 1)[1]) > 60, code


def test_what_to_write_instead():
    text = GOOD.replace('lower="-2" upper="2"', 'lower="-90" upper="180"', 1)
    (found,) = [f for f in lint_document(document_of(text, "f")).findings if f.code == "limit-degrees"]
    assert found.instead == '<limit lower="-1.5708" upper="3.14159" effort="150.0" velocity="2"/>'
    text = GOOD.replace('<axis xyz="0 0 1"/>', '<axis xyz="0 3 4"/>', 1)
    (found,) = [f for f in lint_document(document_of(text, "f")).findings if f.code == "axis-not-unit"]
    assert found.instead == '<axis xyz="0 0.6 0.8"/>'


@pytest.mark.parametrize(
    ("written", "instead"),
    [
        ('lower="-2.967" upper="170"', 'lower="-2.967" upper="2.96706"'),
        ('lower="-170" upper="2.967"', 'lower="-2.96706" upper="2.967"'),
        ('lower="-5" upper="170"', 'lower="-0.0872665" upper="2.96706"'),  # a whole number
        ('lower="-7.5" upper="170"', 'lower="-0.1309" upper="2.96706"'),  # more than a turn in rad
    ],
)
def test_only_the_limit_that_is_in_degrees_is_converted(written, instead):
    text = GOOD.replace('lower="-2" upper="2"', written, 1)
    (found,) = [f for f in lint_document(document_of(text, "f")).findings if f.code == "limit-degrees"]
    assert found.instead == f'<limit {instead} effort="150.0" velocity="2"/>'
    assert ("looks like rad" in found.why) == ("2.967" in written)


@pytest.mark.parametrize("rpy", ["0.7071 0.7071 0", "-0.5 0.5 0.5", "0 0 0.38268343", "0 0.92388 0.38268"])
def test_parts_of_a_quaternion_as_angles(rpy):
    text = GOOD.replace('<origin xyz="0.0 0.0 0.45"', f'<origin rpy="{rpy}" xyz="0.0 0.0 0.45"', 1)
    (found,) = angles_of_quaternions(document_of(text, "f"))
    assert "parts of a quaternion" in found.what


def test_the_angles_of_a_quaternion_and_other_angles():
    text = GOOD.replace('<origin xyz="0.0 0.0 0.45"', '<origin rpy="0.70710678 0 0" xyz="0.0 0.0 0.45"', 1)
    (found,) = angles_of_quaternions(document_of(text, "f"))
    assert found.instead.startswith('<origin rpy="1.5708 0 0"')
    for rpy in (
        "0.7 0 0",
        "0.5 0 0",
        "0.785398 0 0",
        "1.5708 0 3.14159",
        "0.7073 0.7073 0",
        "0.71 0.71 0",
        "0.5 0.5 0",
    ):
        text = GOOD.replace('<origin xyz="0.0 0.0 0.45"', f'<origin rpy="{rpy}" xyz="0.0 0.0 0.45"', 1)
        assert list(angles_of_quaternions(document_of(text, "f"))) == []


def test_one_cause_of_several_rules_is_one_group():
    masses = re.sub(r'<mass value="([^"]*)"', lambda m: f'<mass value="{1000 * float(m[1])}"', GOOD)
    (group,) = grouped(lint_document(document_of(masses, "f")).findings)
    assert (group.cause, group.severity) == ("masses in g", "error")
    assert {f.code for f in group.findings} >= {"mass-grams", "density"}


def test_stand_ins_and_foreign_elements_stay_silent():
    text = GOOD.replace('velocity="2"', 'velocity="1e9"').replace(
        "</robot>",
        '<gazebo><plugin filename="x"/></gazebo><transmission name="t"><type>a</type></transmission>'
        '<ros2_control name="r" type="system"><hardware/></ros2_control>'
        '<drake:collision_filter_group name="g"/></robot>',
    )
    assert lint_document(document_of(text, "f")).findings == ()


@pytest.mark.parametrize(("moment", "found"), [("0.001", True), ("1", True), ("0.0037", False), ("0.00100001", False)])
def test_three_equal_moments_are_a_stand_in_where_they_are_round(moment, found):
    tensor = f'<inertia ixx="{moment}" iyy="{moment}" izz="{moment}" ixy="0" ixz="0" iyz="0"/>'
    document = document_of(re.sub(r"<inertia [^>]*/>", tensor, GOOD, count=1), "f")
    assert bool(list(placeholders(document))) == found


def test_an_element_that_is_not_known_names_its_place():
    findings = lint_document(document_of(GOOD.replace("</robot>", '<limk name="x"/></robot>'), "f")).findings
    assert any("limk x" in f.subject for f in findings if "<limk>" in f.what)


def test_a_link_without_mass_between_two_joints_is_a_note():
    text = re.sub(r'(<link name="l2">\n)<inertial>.*?</inertial>\n<visual>.*?</visual>', r"\1", GOOD, flags=re.DOTALL)
    findings = lint_document(document_of(text, "f")).findings
    assert [f.level for f in findings if f.code == "inertial-missing"] == ["note"]


def test_parts_of_rules():
    document = document_of(GOOD, "f")
    assert arm_size(document) == pytest.approx(1.0, rel=1e-12)
    assert document.mass_beyond("l1", through_moving=False) == 0.0
    assert half_digit("12") == 0.5
    assert half_digit("1e99999") == half_digit("1e5.5") == 0.0
    assert nearest("fricton", ("friction", "damping")) == "friction"
    assert nearest("effort", ("velocity",)) == ""
    rules = (angles_in_degrees, velocity_in_degrees, meshes_missing, misspelt_tags, several_roots)
    assert not any(list(rule(document)) for rule in rules)


def test_numbers_that_no_arithmetic_bears_do_not_stop_it():
    for number in ("1e308", "-1e308", "1e-320", "inf", "nan", "9" * 5000, "0x10", "\uff11", "1_0", "", "e"):
        text = re.sub(r'"-?\d+(\.\d+)?(e-?\d+)?"', f'"{number}"', GOOD)
        assert lint_document(document_of(text, "f")).findings
        text = re.sub(r'xyz="[^"]*"', f'xyz="{number} {number} 0"', GOOD)
        assert lint_document(document_of(text, "f")).findings


def test_an_empty_robot_and_three_thousand_nested_tags():
    for text in ("<robot/>", "<robot name='r'>" + "<link>" * 3000 + "</link>" * 3000 + "</robot>"):
        assert lint_document(document_of(text, "f")).findings


def test_a_mesh_that_misses_in_a_package_that_is_there_under_another_name(tmp_path):
    (tmp_path / "checkout" / "meshes").mkdir(parents=True)
    (tmp_path / "checkout" / "meshes" / "A.STL").write_bytes(b"")
    file = tmp_path / "checkout" / "x.urdf"
    shape = '<visual><geometry><mesh filename="package://pkg/meshes/{}"/></geometry></visual>'
    text = f'<robot name="r"><link name="a">{shape.format("A.STL")}{shape.format("b.stl")}</link></robot>'
    found = {f.code: f for f in lint_document(document_of(text, str(file))).findings}
    assert set(found) >= {"mesh-missing"}
    assert "mesh-package" not in found
    found = list(meshes_missing(document_of(text.replace("A.STL", "a.stl").replace("package://pkg/", ""), str(file))))
    assert [f.instead for f in found] == ["meshes/A.STL", ""]
