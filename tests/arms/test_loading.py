"""Options of loading: mounts, tools and rotors, what a run finds again, and what is refused in one line."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.loading import _LARGEST, arm_of
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.model.arm import Source, caveats_of
from lwr_dyn.model.caveats import ABSENT_ROTORS, DYNAMICS
from lwr_dyn.model.chain import MOUNTS, ends_of
from lwr_dyn.model.spatial import Pose, from_rpy
from tests.arms.urdf.small_files import saved_run
from tests.tolerances import EXACT

MOUNT = {"on": "wall", "xyz": [0.3, -0.2, 1.4], "rpy_deg": [0, 10, 35]}
TOOL = {"xyz": [0.02, 0, 0.15], "rpy": [0.1, 0.7, -0.3], "mass": 1.3, "inertia": [3e-3, 4e-3, 2e-3]}
STATES = np.random.default_rng(4).uniform(-1.0, 1.0, (1, 20, 7))


def test_ways_to_say_the_same_by_the_command_too(tmp_path, lwr_dyn_command):
    file = tmp_path / "tool.toml"
    file.write_text("xyz = [0, 0, 1]\nrpy_deg = [0, 90, 0]\nmass = 2\ninertia = [1, 0, 0, 2, 0, 2]\n")
    pose = Pose(from_rpy((0, np.pi / 2, 0)), np.array([0.0, 0.0, 1.0]))
    tools = [file, str(file), {"xyz": (0, 0, 1), "rpy": [0, np.pi / 2, 0], "mass": 2, "inertia": np.diag([1, 2, 2])}]
    arms = [lwr_dyn.load("lwr4plus", tool=tool) for tool in tools]
    for arm in arms:
        assert np.array_equal(arm.chain.flange.matrix(), arms[0].chain.flange.matrix())
        assert np.array_equal(arm.chain.bodies[-1].inertia_com, arms[0].chain.bodies[-1].inertia_com)
    only = lwr_dyn.load("lwr4plus", tool=pose.matrix())
    assert np.array_equal(only.chain.flange.matrix(), arms[0].chain.flange.matrix())
    assert only.chain.links[-1].body is not arms[0].chain.links[-1].body
    mounts = ["ceiling", {"on": "ceiling"}, {"rpy_deg": [180, 0, 0]}, MOUNTS["ceiling"].matrix()]
    bases = [ends_of(lwr_dyn.load("lwr4plus", mount=mount).installation)[0].matrix() for mount in mounts]
    assert all(np.array_equal(base, bases[0]) for base in bases)
    file = tmp_path / "g.toml"
    file.write_text("xyz = [0, 0, 0.1]\n")
    options = ["--mount", "ceiling", "--mount", "xyz=0,0,2.5", "--tool", str(file)]
    code, out, _ = lwr_dyn_command("fk", "lwr4plus", "--q", "0,0,0,0,0,0,0", "--json", *options)
    assert not code
    assert json.loads(out)["position"] == pytest.approx([0, 0, 2.5 - 0.968], abs=EXACT)


Q = np.array([0.1, -1.2, 1.4, 0.3, 0.7, -0.2])
ADVICE = (*DYNAMICS, ABSENT_ROTORS)
ZEROS = """<robot name="two">
  <link name="a"/>
  <joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="1"/><dynamics damping="0" friction="{friction}"/></joint>
  <link name="b"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>"""


@pytest.mark.parametrize("engine", ["pinocchio", "newton-euler"])
def test_they_are_added_to_the_diagonal_and_to_nothing_else(engine):
    bare, arm = lwr_dyn.load("kr30ha"), lwr_dyn.load("kr30ha", rotor={"A2": 80.0, "4": 0.25})
    # entries of B are up to 404 kg m^2
    more = lwr_dyn.dynamics_of(arm, engine).mass_matrix(Q) - lwr_dyn.dynamics_of(bare, engine).mass_matrix(Q)
    assert np.abs(more - np.diag([0, 80, 0, 0.25, 0, 0])).max() < EXACT * 400
    assert np.array_equal(*(lwr_dyn.dynamics_of(x, engine).gravity_vector(Q) for x in (bare, arm)))


def test_rotors_of_an_option_or_a_file_take_the_place_of_the_sources_own(tmp_path, lwr_dyn_command):
    own, arm = lwr_dyn.load("lwr4plus"), lwr_dyn.load("lwr4plus", rotor={1: 0.5})
    assert arm.armature.tolist() == [0.5, *own.armature[1:]]
    given = Source("rotor", "option of loading", "given", {"joint_1": 0.5}, "SI", "to SI")
    changed = dict.fromkeys(("joint_1.armature", "joint_1.rotor_inertia"), (given,))
    assert arm.sources == {x: y for x, y in own.sources.items() if x != "joint_1.gear_ratio"} | changed
    assert (own.loaded_with, arm.loaded_with, lwr_dyn.load("lwr4plus", rotor={}).sources) == (
        {},
        {"rotor": {"joint_1": 0.5}},
        own.sources,
    )
    assert lwr_dyn.load("lwr4plus", rotor={1: _LARGEST}).armature[0] == _LARGEST
    far = lwr_dyn.load("lwr4plus", mount={"xyz": [0, 0, -_LARGEST]})
    assert far.installation.mount.position.tolist() == [0, 0, -_LARGEST]
    (tmp_path / "rotors.toml").write_text("A2 = 80.0\n4 = 0.25\n")
    arm = lwr_dyn.load("kr30ha", rotor=tmp_path / "rotors.toml")
    assert arm.armature.tolist() == [0, 80, 0, 0.25, 0, 0]
    code, out, _ = lwr_dyn_command("urdf", "kr30ha", "--rotor", str(tmp_path / "rotors.toml"))
    assert (code, lwr_dyn_command("urdf", "kr30ha", "--rotor", "A2=80", "--rotor", "4=0.25")[1]) == (0, out)


def test_a_written_urdf_carries_rotors_and_a_run_finds_its_arm_with_them_its_mount_and_its_tool_again(tmp_path):
    arm = lwr_dyn.load("kr30ha", rotor={"A2": 80.0})
    for name, text in model_files(arm, "k").items():
        (tmp_path / name).write_text(text)
    assert lwr_dyn.load(tmp_path / "k.urdf").armature.tolist() == [0, 80, 0, 0, 0, 0]
    assert np.array_equal(arm_of(saved_run(tmp_path, arm, Q)).armature, arm.armature)
    arm = lwr_dyn.load("lwr4plus", mount=MOUNT, tool=TOOL)
    again = arm_of(saved_run(tmp_path, arm, STATES[0, 0]))
    assert np.array_equal(lwr_dyn.forward_kinematics(again, STATES[0]), lwr_dyn.forward_kinematics(arm, STATES[0]))
    assert np.array_equal(again.chain.bodies[-1].inertia_com, arm.chain.bodies[-1].inertia_com)
    run = lwr_dyn.simulate(
        arm, lwr_dyn.controller("pd-gravity", arm), lwr_dyn.reference("hold", arm, q=STATES[0, 0]), duration=0.002
    )
    assert arm_of(run) is arm
    with pytest.raises(LwrDynError, match="run: loaded with options that do not exist; allowed: a run made by simul"):
        arm_of(replace(run, setup=None, meta={**run.meta, "loaded_with": {"lens": 1}}))
    with pytest.raises(LwrDynError, match="run: does not say of which robot it is; allowed: a run made by simulate"):
        arm_of(replace(run, setup=None, meta={"robot": 3}))


def test_advice_says_which_are_missing_and_other_commands_do_not(lwr_dyn_command):
    assert not any("no rotor" in line for line in caveats_of([lwr_dyn.load("kr30ha")], DYNAMICS))
    assert caveats_of([lwr_dyn.load("wam7"), lwr_dyn.load("lwr4plus")], ADVICE) == ()
    bare, some = lwr_dyn.load("kr30ha"), lwr_dyn.load("kr30ha", rotor=dict.fromkeys(("A1", "A2", "A3", "A4"), 1.0))
    assert "no rotor inertia given (--rotor JOINT=VALUE adds it)" in caveats_of([bare], ADVICE)[-1]
    assert "no rotor inertia of A5 and A6 given" in caveats_of([some], ADVICE)[-1]
    none = dict.fromkeys(("A1", "A2", "A3", "A4", "A5", "A6"), 0.0)
    assert lwr_dyn.load("kr30ha", rotor=none).rotor_caveat() == ""  # direct drives
    given = [x for i in range(1, 7) for x in ("--rotor", f"{i}=9")]
    for options, said in (((), [False, True]), (given, [False])):
        _, out, _ = lwr_dyn_command("margins", "kr30ha", "--json", *options)
        assert ["no rotor inertia given" in line for line in json.loads(out)["caveats"]] == said
    assert "rotor" not in lwr_dyn_command("fk", "kr30ha", "--q", "0,0,0,0,0,0")[1]


def test_friction_of_zero_is_no_friction_of_its_own(tmp_path):
    (tmp_path / "two.urdf").write_text(ZEROS.format(friction="0"))
    arm = lwr_dyn.load(tmp_path / "two.urdf")
    assert not arm.has_friction
    assert arm_with_friction(arm, 0.03).friction[0].positive.coulomb == pytest.approx(0.3)
    (tmp_path / "two.urdf").write_text(ZEROS.format(friction="0.1"))
    with pytest.raises(LwrDynError, match="has friction of its own"):
        arm_with_friction(lwr_dyn.load(tmp_path / "two.urdf"), 0.03)


BAD = {
    "no such place": ({"mount": "roof"}, "no mount named 'roof'; known: floor, wall, ceiling"),
    "no such field": ({"tool": {"mas": 1}}, r"no field of a tool named 'mas' \(did you mean mass\?\)"),
    "a field of a tool": ({"mount": {"mass": 1}}, "no field of a mount named 'mass'"),
    "negative mass": ({"tool": {"mass": -1.0}}, "tool: mass -1, .*; allowed: an inertia that a body can have"),
    "impossible inertia": ({"tool": {"mass": 1, "inertia": [1, 1, 3]}}, r"tool: mass 1, inertia \[1.0, 1.0, 3.0\]"),
    "inertia without mass": ({"tool": {"inertia": [1, 1, 1]}}, "tool: mass 0"),
    "wrong size": ({"tool": {"mass": 1, "inertia": [1, 1]}}, r"tool inertia: shape \(2,\); allowed: 3 numbers"),
    "two numbers": ({"mount": {"xyz": [1, 2]}}, "mount xyz: 2 numbers; allowed: 3 numbers"),
    "two rotations": ({"mount": {"rpy": [0, 0, 0], "rpy_deg": [0, 0, 0]}}, "mount: rpy and rpy_deg; allowed: xyz with"),
    "not a rotation": ({"mount": np.diag([1, 2, 1, 1])}, r"mount pose: R\^T R differs"),
    "not a pose": ({"tool": 5}, r"tool pose: a single number; allowed: 4 x 4 numbers"),
    "text": ({"tool": {"mass": "heavy"}}, "tool mass: not an array of numbers"),
    "far away": ({"mount": {"xyz": [0, 0, 1e9]}}, "mount xyz: .* allowed: numbers up to 1e"),
    "no file": ({"tool": "gripper"}, r"tool: 'gripper'; allowed: a .toml file, or xyz=0,0,0.15; fields: xyz"),
    "missing file": ({"tool": "no.toml"}, "no.toml: no such file"),
    "a mount of two poses": ({"mount": {"xyz": [0, 0, 1], "pose": np.eye(4)}}, "mount: pose and xyz; allowed: xyz"),
    "a null": ({"robot": "lwr4\0plus"}, "'lwr4.x00plus': a null character; allowed: a robot's name or a path"),
    "a tip": ({"tip": "link_3"}, "tip: given for lwr4plus; allowed: only with a .urdf, .xacro or .xml file"),
    "arguments": ({"xacro_args": {"a": "b"}}, "xacro_args: given for lwr4plus; allowed: only with a .xacro file"),
    "trust": ({"trust_xacro": True}, "trust_xacro: given for lwr4plus; allowed: only with a .xacro file"),
    "just too far": ({"mount": {"xyz": [0, -2 * _LARGEST, 0]}}, "allowed: numbers up to 1e"),
    "a rotor below 0": ({"rotor": {"1": -1e-9}}, "rotor 1: -1e-09; allowed: a number from 0 to 1e"),
    "a rotor that is no number": ({"rotor": {"1": [1, 2]}}, "rotor 1"),
    "a rotor that is not finite": ({"rotor": {"1": np.nan}}, "rotor 1: nan; allowed: finite numbers"),
    "a missing file of rotors": ({"rotor": "none.toml"}, "none.toml: no such file"),
    "a rotor too large": ({"rotor": {"1": 2 * _LARGEST}}, "rotor 1: .*; allowed: a number from 0 to 1e"),
    "a joint too many": ({"rotor": {"8": 1.0}}, "no joint of lwr4plus named '8'"),
    "joint 0": ({"rotor": {"0": 1.0}}, "no joint of lwr4plus named '0'"),
    "a joint twice": ({"rotor": {"7": 1.0, "joint_7": 2.0}}, "rotor joint_7: joint_7 twice; allowed: each joint once"),
    "a rotor's file": ({"rotor": "rotors.txt"}, "rotor: 'rotors.txt'; allowed: a .toml file with a line joint = value"),
    "a list": ({"mount": {"on": [1]}}, "no mount named"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD, ids=str)
def test_what_cannot_be_is_refused(case):
    options, message = BAD[case]
    with pytest.raises(LwrDynError, match=message) as refusal:
        lwr_dyn.load(**{"robot": "lwr4plus", **options})
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--tool", "mass=x"], "--tool mass: 'x'; allowed: numbers such as 0,0,0.15; one field an option"),
        (["--tool", "mass=1", "--tool", "mass=2"], "--tool: 'mass'; allowed: each KEY=NUMBERS once, or one file"),
        (["--tool", "a.toml", "--tool", "mass=2"], "--tool: 'a.toml'; allowed: each KEY=NUMBERS once, or one file"),
        (["--mount", "floor", "--mount", "wall"], "--mount: 'wall'; allowed: each KEY=NUMBERS once"),
        *((["--rotor", text], f"--rotor: {text!r}; allowed: JOINT=VALUE once a joint, such as 2=0.5")
          for text in ("1", "1=x", "1=1,2")),
        (["--rotor", "1=2", "--rotor", "1=3"], "--rotor: '1=3'; allowed: JOINT=VALUE once a joint"),
        (["--rotor", "=1"], "no joint of lwr4plus named ''"),
    ],
)  # fmt: skip
def test_options_that_contradict_are_one_line(options, message, lwr_dyn_command):
    code, out, err = lwr_dyn_command("fk", "lwr4plus", "--q", "0,0,0,0,0,0,0", *options)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert message in err
