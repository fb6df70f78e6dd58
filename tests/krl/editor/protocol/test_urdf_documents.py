"""URDF and xacro files in the editor: findings while one writes, quick fixes, and no code of a xacro runs."""

import pytest

from tests.krl.language_client import short
from tests.optional import need

URDF = """<robot name="r">
  <link name="a"/>
  <link name="b">
    <inertial>
      <mass value="2.31"/>
      <inertia ixx="0.012" ixy="0" ixz="0" iyy="0.013" iyz="0" izz="0.0047"/>
    </inertial>
  </link>
  <joint name="j" type="revolute">
    <parent link="a"/>
    <child link="b"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="1"/>
  </joint>
</robot>
"""


def codes(client, path):
    return [x["code"] for x in client.diagnostics(path)[1] if x["severity"] < 3]


def test_a_urdf_is_judged_as_it_is_written_and_its_fix_ends_the_finding(client, tmp_path):
    path = tmp_path / "a.urdf"
    client.open(path, URDF, "xml")
    assert codes(client, path) == []
    wrong = URDF.replace('name="b"', 'name="bx"').replace('<child link="b"/>', '<child\n      link="by"/>')
    client.change(path, wrong)
    found = next(x for x in client.diagnostics(path)[1] if x["code"] == "link-unknown")
    assert (short(found["range"]), found["severity"], found["source"]) == ((10, 4, 11, 17), 1, "lwr-dyn")
    (action,) = client.of("codeAction", path, range=found["range"], context={"diagnostics": [found]})
    assert (action["title"], action["diagnostics"]) == ('Write <child link="bx"/>', [found])
    (edit,) = action["edit"]["changes"][path.as_uri()]
    assert (edit["range"], edit["newText"]) == (found["range"], '<child link="bx"/>')
    client.change(path, wrong.replace('<child\n      link="by"/>', edit["newText"]))
    assert "link-unknown" not in codes(client, path)
    client.close(path)
    assert client.diagnostics(path)[1] == []
    assert client.ask("hover", path, 10, 4) is None


@pytest.mark.slow
def test_a_xacro_is_judged_where_its_macros_stand_and_runs_no_code(client, tmp_path):
    need("xacro")
    head = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">'
    part, path = tmp_path / "part.xacro", tmp_path / "a.urdf.xacro"
    part.write_text(f'{head}\n<xacro:macro name="m"><link name="x"><inertial/></link></xacro:macro>\n</robot>\n')
    path.write_text(f'{head}\n<xacro:include filename="part.xacro"/>\n<xacro:m/>\n</robot>\n')
    client.open(path, path.read_text(), "xml")
    assert client.diagnostics(path)[1] == []
    found = client.diagnostics(part)[1]
    assert {(x["code"], x["range"]["start"]["line"]) for x in found if x["severity"] == 1} == {("element-missing", 1)}
    evil = path.read_text().replace("<xacro:m/>", "${[x for x in (1, 2)]}")  # Python, which a trusted file may hold
    path.write_text(evil)
    client.change(path, evil)
    client.save(path)
    assert codes(client, path) == ["xacro-refused"]
    assert client.diagnostics(part)[1] == []


def test_a_file_that_cannot_be_read_says_so(client, tmp_path):
    path = tmp_path / "gone.xacro"
    client.open(path, "<robot/>", "xml")
    (found,) = client.diagnostics(path)[1]
    assert (found["code"], found["severity"], short(found["range"])) == ("not-judged", 2, (0, 0, 0, 8))
