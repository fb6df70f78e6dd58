"""Who is trusted is said by the user alone, file by file: `trust_xacro`, `--trust-xacro`."""

from pathlib import Path

import pytest
import xacro  # noqa: F401  its tests are skipped without it

import lwr_dyn
from lwr_dyn.arms.loading import arm_of
from lwr_dyn.checks.urdf.lint import lint_file
from lwr_dyn.foundation.errors import UrdfError
from tests.arms.urdf.small_files import saved_run

NEEDS_PYTHON = """<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:property name="n" value="${[k for k in [3, 4]][1]}"/>
<link name="base"/>
<link name="arm"><inertial><origin xyz="0 0 0.1"/><mass value="${n}"/>
  <inertia ixx="0.021" ixy="0" ixz="0" iyy="0.022" iyz="0" izz="0.008"/></inertial></link>
<joint name="a" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
  <limit lower="-1" upper="1" effort="500" velocity="2"/></joint></robot>
"""


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.urdf.xacro").write_text(NEEDS_PYTHON, encoding="utf-8")
    return "x.urdf.xacro"


def test_load_and_lint_run_python_only_when_it_is_trusted(file):
    with pytest.raises(UrdfError, match=r"ListComp in an expression.*trust_xacro=True"):
        lwr_dyn.load(file)
    arm = lwr_dyn.load(file, trust_xacro=True)
    assert (arm.chain.bodies[0].mass, arm.loaded_with["trust_xacro"]) == (4.0, True)
    assert [f.code for f in lint_file(file).findings] == ["xacro-refused"]
    assert "xacro-refused" not in [f.code for f in lint_file(file, trust_xacro=True).findings]


@pytest.mark.parametrize(
    "words", [("fk", "--q-deg", "0"), ("urdf", "--out", "y.urdf"), ("lint",), ("parity", "--only", "pinocchio")]
)
def test_commands_trust_a_file_that_is_named_so(file, words, lwr_dyn_command):
    command, *others = words
    code, out, err = lwr_dyn_command(command, file, *others)
    assert code in (1, 2)
    assert "--trust-xacro" in out + err
    code, out, err = lwr_dyn_command(command, file, "--trust-xacro", *others)
    assert code == 0, out + err


def test_a_folder_is_never_trusted(file, lwr_dyn_command):
    for words, code, said in (
        (("lint", "."), 1, "xacro refuses the file"),
        (("lint", ".", "--trust-xacro"), 2, "a folder is never trusted"),
        (("lint", "wam7", "--trust-xacro"), 2, "would do nothing here"),
    ):
        found, out, err = lwr_dyn_command(*words)
        assert found == code
        assert said in out + err


def test_a_run_does_not_say_what_to_trust(file):
    """A run file of a stranger may name a xacro beside it."""
    arm = lwr_dyn.load(file, trust_xacro=True)
    kept = saved_run(Path("."), arm, [0.0])
    assert kept.meta["loaded_with"]["trust_xacro"] is True
    with pytest.raises(UrdfError, match="ListComp"):
        arm_of(kept)
