"""The MJCF that this package writes reads back as the same arm; others' MJCF, and changed numbers, are one line."""

import random
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.export.mjcf import mjcf_text
from lwr_dyn.arms.export.mjcf_reader import read_mjcf
from lwr_dyn.cli.main import main
from lwr_dyn.foundation.errors import FileAccessError, LwrDynError, OptionError, UnknownNameError, UrdfError
from lwr_dyn.model.arm import JointLimits
from tests.hostile.changes import changed
from tests.random_arms import random_arm

READINGS = [(robot, reading) for robot in ("kr30ha", "lwr4plus", "wam7") for reading in lwr_dyn.readings(robot)]
TOOL = {"xyz": [0, 0.02, 0.1], "rpy_deg": [30, 0, 10], "mass": 1.5, "com": [0, 0, 0.05], "inertia": [0.01, 0.01, 0.01]}
MOUNT = {"on": "ceiling", "xyz": [0.1, 0.2, 0.3], "rpy_deg": [10, 20, 30]}


def again(folder, arm):
    path = folder / "arm.xml"
    path.write_text(mjcf_text(arm), encoding="utf-8")
    return lwr_dyn.load(path)


def assert_same(arm, read):
    q, dq = np.random.default_rng(4).uniform(-2, 2, (2, 30, arm.n))
    engines = [lwr_dyn.dynamics_of(x, "newton-euler") for x in (arm, read)]
    for function, states in (("mass_matrix", (q,)), ("coriolis_matrix", (q, dq)), ("gravity_vector", (q,))):
        one, other = (getattr(engine, function)(*states) for engine in engines)
        assert np.abs(one - other).max() < 1e-12 * max(1.0, np.abs(one).max()), function
    assert max(np.abs(np.subtract(*(lwr_dyn.forward_kinematics(y, x) for y in (arm, read)))).max() for x in q) < 1e-12
    assert read.joint_names == arm.joint_names
    assert [link.link for link in read.chain.links] == [link.link for link in arm.chain.links]
    assert [link.rotor is None for link in read.chain.links] == [link.rotor is None for link in arm.chain.links]
    assert np.array_equal(read.armature, arm.armature)
    assert read.limits == tuple(arm.limits)


@pytest.mark.parametrize(("robot", "reading"), READINGS)
def test_every_robot_reads_back_as_the_same_arm(tmp_path, robot, reading):
    arm = lwr_dyn.load(robot, reading)
    read = again(tmp_path, arm)
    assert_same(arm, read)
    assert (read.name, read.reading, read.title) == (robot, "mjcf", "read from arm.xml")
    assert read.caveats.words(["inertia"]) == arm.caveats.words(["inertia"])
    assert again(tmp_path, read).limits == read.limits


@pytest.mark.parametrize("robot", ["kr30ha", "lwr4plus"])
def test_a_mount_and_a_tool_are_part_of_the_ends(tmp_path, robot):
    arm = lwr_dyn.load(robot, mount=MOUNT, tool=TOOL)
    assert_same(arm, again(tmp_path, arm))


@pytest.mark.parametrize("seed", range(12))
def test_arms_of_any_shape_read_back(tmp_path, seed):
    arm = random_arm(seed)
    limits = JointLimits(-1.25, 2.5, None if seed % 2 else 3.1, None if seed % 3 else 40.0, 0.3, 0.7)
    arm = replace(arm, limits=(limits, *(JointLimits(),) * (arm.n - 1)))
    assert_same(arm, again(tmp_path, arm))


def test_options_of_loading_act_as_on_any_arm(tmp_path):
    arm = lwr_dyn.load("lwr4plus")
    path = tmp_path / "arm.xml"
    path.write_text(mjcf_text(arm), encoding="utf-8")
    q = np.full(6, 0.3)
    locked, same = (lwr_dyn.load(x, lock={"joint_3": 0.2}, tool=TOOL) for x in (path, "lwr4plus"))
    assert np.abs(lwr_dyn.forward_kinematics(locked, q) - lwr_dyn.forward_kinematics(same, q)).max() < 1e-12
    with pytest.raises(UnknownNameError, match="no reading of an MJCF named 'printed'"):
        lwr_dyn.load(path, "printed")
    with pytest.raises(OptionError, match="tip: given for"):
        lwr_dyn.load(path, tip="flange")
    with pytest.raises(UnknownNameError, match="no joint of lwr4plus named 'j'"):
        lwr_dyn.load(path, lock={"j": 0.0})
    with pytest.raises(FileAccessError, match=r"allowed: a readable \.xml file"):
        lwr_dyn.load(tmp_path / "none.xml")


def test_a_run_of_it_finds_its_arm_again(tmp_path):
    arm = again(tmp_path, lwr_dyn.load("lwr4plus"))
    hold = lwr_dyn.reference("hold", arm, q=[0.1] * 7, duration=0.01)
    lwr_dyn.simulate(arm, lwr_dyn.controller("pid", arm), hold).save(tmp_path / "run.npz")
    lwr_dyn.replay(lwr_dyn.Run.load(tmp_path / "run.npz"), tmp_path / "run.html")
    assert (tmp_path / "run.html").is_file()
    (tmp_path / "arm.xml").write_text(mjcf_text(lwr_dyn.load("wam7")), encoding="utf-8")
    with pytest.raises(FileAccessError, match="has changed since the run was made"):
        lwr_dyn.replay(lwr_dyn.Run.load(tmp_path / "run.npz"), tmp_path / "run.html")


ENDS = ("--from-deg", "0,30,0,-70,0,35,0", "--to-deg", "1,31,0,-70,0,35,0")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("check",), "checks hold"),
        (("fk", "--q-deg", "0,30,0,-70,0,35,0"), "lwr4plus, reading mjcf: flange in base"),
        (("ik", "--xyz", "0.4,0,0.5", "--rpy-deg", "180,0,0"), "lwr4plus"),
        (("margins", "--q-deg", "0,30,0,-70,0,35,0"), "lwr4plus"),
        (("simulate", "--task", "point-to-point", *ENDS, "--duration", "0.5"), "lwr4plus, reading mjcf"),
        (("dh",), "lwr4plus"),
        (("urdf",), "<robot name="),
    ],
)
def test_commands_take_it(tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xml").write_text(mjcf_text(lwr_dyn.load("lwr4plus")), encoding="utf-8")
    with pytest.raises(SystemExit) as end:
        main([words[0], "arm.xml", *words[1:]])
    assert not end.value.code
    assert said in capsys.readouterr().out


GOOD = mjcf_text(lwr_dyn.load("lwr4plus"))
OTHERS = '<mujoco model="x"><worldbody><body name="a"><joint type="hinge"/><geom size="1"/></body></worldbody></mujoco>'
BAD = {
    "another's": (OTHERS, "<mujoco>: not written by lwr_dyn, whose MJCF alone is read; allowed: an MJCF that lwr_dyn"),
    "a URDF": ('<robot name="x"/>', "<robot>: a URDF; allowed: a name that ends in .urdf"),
    "an SDF": ("<sdf/>", "<sdf>: the outermost element; allowed: <mujoco>"),
    "no XML": ("<mujoco>", "XML: no element found: line 1, column 8; allowed: a well-formed MJCF"),
    "nan": (GOOD.replace('mass="2.7782"', 'mass="nan"', 1), "body 'link_1' <inertial> mass: 'nan'; allowed: 1 finite"),
    "no mass": (GOOD.replace('mass="2.7782"', "", 1), "body 'link_1' <inertial> mass: ''; allowed: 1 finite numbers"),
    "mass below 0": (
        GOOD.replace('mass="2', 'mass="-2', 1),
        "<inertial> mass: '-2.7782'; allowed: a mass of at least 0",
    ),
    "no inertial": (GOOD.replace("<inertial", "<inertia", 1), "body 'link_1': 0 elements <inertial>; allowed: one"),
    "armature": (GOOD.replace('armature="', 'armature="-', 1), "<joint> armature: '-0.160325'; allowed: a number of"),
    "axes": (
        GOOD.replace('0.0 0.0 1.0"', '0.0 0.0 2.0"', 1),
        "xyaxes: '1.0 0.0 0.0 0.0 0.0 2.0'; allowed: two directions",
    ),
    "axis": (GOOD.replace('axis="0 0 1"', 'axis="0 1 0"', 1), "<joint>: an axis beside z of the body; allowed: 0 0 1"),
    "ball": (GOOD.replace('"hinge"', '"ball"', 1), "<joint> type: 'ball'; allowed: hinge, slide"),
    "range": (GOOD.replace('range="-2.9', 'range="12.9', 1), "<joint> range: "),
    "joint twice": (GOOD.replace('name="joint_2"', 'name="joint_1"'), "joint joint_1: used twice"),
    "two chains": (GOOD.replace('<body name="link_7"', '<body name="z"/><body name="link_7"'), "2 elements <body>"),
    "no gravity": (GOOD.replace("<option gravity", "<option wind"), "<option> gravity: ''; allowed: 3 finite numbers"),
    "speed": (GOOD.replace("does not have: ", "does not have: x ", 1), "header: speed limits by joint"),
    "name": (GOOD.replace('name="link_1"', 'name=""'), "<body>: the name ''; allowed: a name"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_not_ours_or_wrong_is_one_line(tmp_path, case):
    text, words = BAD[case]
    path = tmp_path / "x.xml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UrdfError) as fault:
        lwr_dyn.load(path)
    assert str(fault.value).startswith("x.xml: ")
    assert words in str(fault.value)
    assert "\n" not in str(fault.value)


def test_a_header_without_speeds_leaves_them_unknown(tmp_path):
    text = "\n".join(line for line in GOOD.splitlines() if "speed limits" not in line)
    (tmp_path / "arm.xml").write_text(text, encoding="utf-8")
    assert np.isinf(read_mjcf(tmp_path / "arm.xml").velocity).all()


@pytest.mark.slow
def test_any_small_change_is_read_or_refused_in_our_words(tmp_path):
    read, said, path = 0, list[str](), tmp_path / "x.xml"
    for seed in range(400):
        path.write_text(changed(GOOD, random.Random(seed)), encoding="utf-8")
        try:
            arm = read_mjcf(path)
            assert np.isfinite(lwr_dyn.forward_kinematics(arm, np.full(arm.n, 0.1))).all()
            read += 1
        except LwrDynError as fault:
            said.append(str(fault))
    assert read > 50
    assert len(said) > 20
    assert not [line for line in said if "\n" in line]
