import os

import pytest

from lwr_dyn.arms.urdf.xacro_files import expand_xacro, package_folder
from lwr_dyn.checks.urdf.document import read_document
from lwr_dyn.checks.urdf.lint import lint_file
from lwr_dyn.checks.urdf.xml_tree import Place

MACRO = """<?xml version="1.0"?>
<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="arm" params="prefix mass:=2">
    <link name="${prefix}one">
      <inertial>
        <mass value="${mass}"/>
        <!-- ä --><inertia ixx="0.10" iyy="0.10" izz="${0.15 * 2}"
                 ixy="0" ixz="0" iyz="0"/>
      </inertial>
    </link>
    <joint name="${prefix}turn" type="continuous"><parent link="base"/><child link="${prefix}one"/></joint>
  </xacro:macro>
</robot>
"""
MAIN = """<robot name="two" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="heavy" default="3"/>
  <xacro:include filename="$(find my_pkg)/urdf/arm_macro.xacro"/>
  <xacro:include filename="none.xacro" optional="true"/>
  <link name="base"/>
  <xacro:arm prefix="left_" mass="$(arg heavy)"/>
  <xacro:arm prefix="right_"/>
</robot>
"""


@pytest.fixture
def xacro_file(tmp_path, monkeypatch):
    folder = tmp_path / "my_pkg" / "urdf"
    folder.mkdir(parents=True)
    (folder / "arm_macro.xacro").write_text(MACRO, encoding="utf-8")
    (folder / "two.urdf.xacro").write_text(MAIN, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return "my_pkg/urdf/two.urdf.xacro"


def test_findings_and_elements_have_the_place_of_their_file(xacro_file):
    macro, main = (os.path.join("my_pkg", "urdf", name) for name in ("arm_macro.xacro", "two.urdf.xacro"))
    found = [(f.subject, f.place) for f in lint_file(xacro_file).findings if f.code == "inertia-triangle"]
    assert found == [("link left_one", Place(macro, 7, 19)), ("link right_one", Place(macro, 7, 19))]
    document = read_document(xacro_file)
    assert document.link("left_one").inertial.mass == 3.0
    assert {(link.place.file, link.place.line) for link in document.links} == {(main, 5), (macro, 4)}
    plain = expand_xacro(xacro_file, {"heavy": "4"})
    assert ("at.=" in plain, 'value="4"' in plain) == (False, True)


def test_a_checkout_of_another_name_is_found_by_its_package_file(xacro_file, tmp_path, monkeypatch):
    (tmp_path / "my_pkg").rename(tmp_path / "checkout")
    (found,) = lint_file("checkout/urdf/two.urdf.xacro").findings
    assert "the package my_pkg is not above or beside the file" in found.what
    (tmp_path / "checkout" / "package.xml").write_text("<package><name>my_pkg</name></package>", encoding="utf-8")
    assert read_document("checkout/urdf/two.urdf.xacro").link("left_one") is not None
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ws"))
    (tmp_path / "ws").mkdir()
    (tmp_path / "checkout").rename(tmp_path / "ws" / "my_pkg")
    assert package_folder("my_pkg", tmp_path / "elsewhere" / "x.urdf") == tmp_path / "ws" / "my_pkg"


@pytest.mark.parametrize("text", ["<robot><a></robot>", MAIN.replace("xacro:arm ", "xacro:leg "), MAIN.replace(
    "my_pkg", "no_pkg"), MAIN.replace("none.xacro\" optional=\"true", "none.xacro")])  # fmt: skip
def test_what_xacro_refuses_is_one_finding(xacro_file, text):
    with open(xacro_file, "w", encoding="utf-8") as stream:
        stream.write(text)
    report = lint_file(xacro_file)
    assert [f.code for f in report.findings] == ["xacro-refused"]
    assert "\n" not in report.findings[0].message


def test_arguments_of_the_command_reach_the_file_that_is_judged(xacro_file, lwr_dyn_command):
    assert "mass-negative" not in {f.code for f in lint_file(xacro_file).findings}
    (found,) = (f for f in lint_file(xacro_file, xacro_args={"heavy": "-1"}).findings if f.code == "mass-negative")
    assert found.subject == "link left_one"
    for command in ("check", "lint"):
        assert "link left_one: mass -1 kg" in lwr_dyn_command(command, xacro_file, "--xacro-arg", "heavy:=-1")[1]
        assert "mass-negative" not in lwr_dyn_command(command, xacro_file)[1]
    assert lwr_dyn_command("lint", xacro_file, "--xacro-arg", "heavy=-1")[0] == 2
