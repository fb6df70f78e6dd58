"""An MJCF read as an arm: ours comes back as the same arm, others' agree with MuJoCo; what is wrong is one line."""

import random
import sys
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.export.mjcf import mjcf_text
from lwr_dyn.arms.export.mjcf_reader import read_mjcf
from lwr_dyn.foundation.errors import FileAccessError, LwrDynError, MissingPackageError, UnknownNameError, UrdfError
from lwr_dyn.model.arm import JointLimits
from tests.arms.export.beside_mujoco import differences
from tests.arms.urdf.small_files import saved_run, written
from tests.hostile.changes import changed
from tests.random_arms import random_arm

READINGS = [(robot, reading) for robot in ("kr30ha", "lwr4plus", "wam7") for reading in lwr_dyn.readings(robot)]
TOOL = {"xyz": [0, 0.02, 0.1], "rpy_deg": [30, 0, 10], "mass": 1.5, "com": [0, 0, 0.05], "inertia": [0.01, 0.01, 0.01]}
MOUNT = {"on": "ceiling", "xyz": [0.1, 0.2, 0.3], "rpy_deg": [10, 20, 30]}


def again(folder, arm):
    return lwr_dyn.load(written(folder, mjcf_text(arm), "arm.xml"))


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


@pytest.mark.parametrize("case", ["kr30ha", "lwr4plus", *range(12)])
def test_arms_of_any_shape_mounted_ones_with_a_tool_too_read_back(tmp_path, case):
    if isinstance(case, str):
        arm = lwr_dyn.load(case, mount=MOUNT, tool=TOOL)
    else:
        limits = JointLimits(-1.25, 2.5, None if case % 2 else 3.1, None if case % 3 else 40.0, 0.3, 0.7)
        arm = random_arm(case)
        arm = replace(arm, limits=(limits, *(JointLimits(),) * (arm.n - 1)))
    assert_same(arm, again(tmp_path, arm))


def test_options_of_loading_act_as_on_any_arm(tmp_path):
    arm = lwr_dyn.load("lwr4plus")
    path = written(tmp_path, mjcf_text(arm), "arm.xml")
    q = np.full(6, 0.3)
    locked, same = (lwr_dyn.load(x, lock={"joint_3": 0.2}, tool=TOOL) for x in (path, "lwr4plus"))
    assert np.abs(lwr_dyn.forward_kinematics(locked, q) - lwr_dyn.forward_kinematics(same, q)).max() < 1e-12
    assert lwr_dyn.load(path, tip="link_4").n == 4
    for options, words in (
        ({"reading": "printed"}, "no reading of an MJCF named 'printed'"),
        ({"tip": "hand"}, r"no link of arm\.xml named 'hand'"),
        ({"lock": {"j": 0.0}}, r"no moving joint of arm\.xml named 'j'"),
    ):
        with pytest.raises(UnknownNameError, match=words):
            lwr_dyn.load(path, **options)
    with pytest.raises(FileAccessError, match=r"allowed: a readable \.xml file"):
        lwr_dyn.load(tmp_path / "none.xml")


def test_a_run_of_it_finds_its_arm_again(tmp_path):
    arm = again(tmp_path, lwr_dyn.load("lwr4plus"))
    run = saved_run(tmp_path, arm, [0.1] * 7)
    lwr_dyn.replay(run, tmp_path / "run.html")
    assert (tmp_path / "run.html").is_file()
    (tmp_path / "arm.xml").write_text(mjcf_text(lwr_dyn.load("wam7")), encoding="utf-8")
    with pytest.raises(FileAccessError, match="has changed since the run was made"):
        lwr_dyn.replay(run, tmp_path / "run.html")


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
def test_commands_take_it(tmp_path, monkeypatch, lwr_dyn_command, words, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xml").write_text(mjcf_text(lwr_dyn.load("lwr4plus")), encoding="utf-8")
    code, out, _ = lwr_dyn_command(words[0], "arm.xml", *words[1:])
    assert not code
    assert said in out


GOOD = mjcf_text(lwr_dyn.load("lwr4plus"))
_HINGE = '<joint axis="0 1 0"/><geom size=".1" density="9" group="0"/>'
TWO = f'<body name="other">{_HINGE}<body>{_HINGE}<body>{_HINGE}<body>{_HINGE}</body></body></body></body>'
COPIES = '<worldbody><replicate count="{}" offset="1 0 0"><site/></replicate>'
BAD = {
    "a URDF": ('<robot name="x"/>', "<robot>: a URDF; allowed: a name that ends in .urdf"),
    "an SDF": ("<sdf/>", "MuJoCo refuses it: XML Error: Unrecognized XML model type: 'sdf'; allowed: an MJCF"),
    "no XML": ("<mujoco>", "MuJoCo refuses it: XML parse error"),
    "nothing": ("", "MuJoCo refuses it: "),
    "no joint": ("<mujoco><worldbody><body/></worldbody></mujoco>", "chain: no moving joint between root and tip"),
    "nan": (GOOD.replace('mass="2.7782"', 'mass="nan"', 1), "MuJoCo refuses it: Error: mass and inertia of"),
    "position": (GOOD.replace('pos="0.0 0.0 0.0"', 'pos="nan 0.0 0.0"'), "a number that is not finite"),
    "no mass": (GOOD.replace('mass="2.7782"', "", 1), "required attribute missing: 'mass'"),
    "armature": (GOOD.replace('armature="', 'armature="-', 1), "joint 'joint_1' armature: -0.160325; allowed: a"),
    "ball": (
        GOOD.replace('"hinge" axis="0 0 1"', '"ball"', 3).replace(' range="-', ' user="-'),
        "type ball, in a chain of joints with one coordinate each; allowed: ",
    ),
    "range": (GOOD.replace('range="-2.9', 'range="12.9', 1), "joint 'joint_1' range: "),
    "joint twice": (GOOD.replace('name="joint_2"', 'name="joint_1"'), "repeated name 'joint_1' in joint"),
    "two arms": (GOOD.replace('<body name="base"', TWO + '<body name="base"'), "the tree has 2 arms or legs"),
    "speed": (GOOD.replace("does not have: 1.9", "does not have: -1.9", 1), "header: speed limits by joint"),
    "name": (GOOD.replace('name="link_1"', 'name="a&#10;b"'), "the name 'a\\nb'; allowed: letters that can"),
    "too many": (GOOD.replace("<worldbody>", '<worldbody><replicate count="1e6"/>'), "1e+06 copies; allowed: at most"),
    "one too many": (GOOD.replace("<worldbody>", COPIES.format(1001)), "1001 copies; allowed: at most 1000 an element"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_not_ours_or_wrong_is_one_line(tmp_path, case):
    text, words = BAD[case]
    with pytest.raises(UrdfError) as fault:
        lwr_dyn.load(written(tmp_path, text, "x.xml"))
    assert str(fault.value).startswith("x.xml: ")
    assert words in str(fault.value)
    assert "\n" not in str(fault.value)


def test_a_header_without_speeds_leaves_them_unknown(tmp_path):
    text = "\n".join(line for line in GOOD.splitlines() if "speed limits" not in line)
    text = text.replace("<worldbody>", COPIES.format(1000))  # as many as may be
    assert np.isinf(read_mjcf(written(tmp_path, text, "arm.xml")).velocity).all()


TREE = Path("tests/hostile/good/tree.xml").read_text(encoding="utf-8")
_DEFAULTS = next(line for line in TREE.splitlines() if "<default>" in line)
FOREIGN = TREE.replace(_DEFAULTS, '<include file="classes.xml"/>')
CLASSES = f"<mujoco>{_DEFAULTS}</mujoco>"


@pytest.fixture
def foreign(tmp_path):
    (tmp_path / "classes.xml").write_text(CLASSES)
    path = tmp_path / "foreign.xml"
    path.write_text(FOREIGN)
    return path


def test_all_ways_to_write_a_chain_agree_with_mujoco_and_a_site_is_a_tip(foreign):
    arm = lwr_dyn.load(foreign)
    assert arm.joint_names == ("off_centre", "first", "second", "third")
    assert [link.link for link in arm.chain.links] == ["upper", "two_before_second", "two", "wrist"]
    assert (arm.name, arm.reading) == ("foreign", "mjcf")
    assert "held: free at 0, a at 0.1, b at 0; other values: --lock JOINT=VALUE" in arm.notes
    assert differences(foreign, arm).max() < 1e-12
    assert differences(foreign, lwr_dyn.load(foreign, tip="bracket"), tip="bracket").max() < 1e-12
    moved = lwr_dyn.load(foreign, tip="wrist", lock={"a": 0.17, "first": 0.4})
    assert moved.joint_names == ("off_centre", "second", "third")
    poses = lwr_dyn.forward_kinematics(moved, [0.1, 0.2, 0.3]), lwr_dyn.forward_kinematics(arm, [0.1, 0.4, 0.2, 0.3])
    assert np.abs(poses[0] - poses[1]).max() < 1e-12
    body, site = (lwr_dyn.load(foreign, tip=name) for name in ("wrist", "point"))
    poses = [lwr_dyn.forward_kinematics(arm, np.full(4, 0.3)) for arm in (body, site)]
    foreign.write_text(FOREIGN.replace('site name="point"', 'site name="wrist"'))  # which is the body's name
    again = lwr_dyn.load(foreign, tip="wrist")
    assert np.array_equal(lwr_dyn.forward_kinematics(again, np.full(4, 0.3)), poses[0])
    foreign.write_text(FOREIGN.replace('name="third"', 'name="point_site"').replace('"third"', '"point_site"'))
    with pytest.raises(UrdfError, match=r"foreign.xml: joint point_site: used twice; allowed: a name of its own"):
        lwr_dyn.load(foreign, tip="point")
    c, s = np.cos(np.radians(10)), np.sin(np.radians(10))
    turned = np.array([[c, -s, 0, 0.1], [s, c, 0, 0.2], [0, 0, 1, 0.3], [0, 0, 0, 1]])  # eulerseq begins with z
    assert np.abs(poses[0] @ turned - poses[1]).max() < 1e-12


def test_gears_drives_and_losses_are_those_of_the_joint(foreign):
    """Efforts: 50 x 2; none; 10 x 3 x 2 + 5; a servo."""
    arm = lwr_dyn.load(foreign)
    assert arm.armature.tolist() == [0.3] * 4
    assert [(x.viscous, x.coulomb) for x in arm.limits] == [(0.7, 0.2)] * 4
    assert [(x.effort, x.lower) for x in arm.limits] == [(100.0, None), (None, None), (65.0, -1.0), (None, None)]
    for own, effort in (("-30 20", 30.0), ("-300 300", 100.0)):  # the joint's own bound beside that of its motor
        foreign.write_text(FOREIGN.replace('name="off_centre"', f'name="off_centre" actuatorfrcrange="{own}"'))
        assert lwr_dyn.load(foreign).limits[0].effort == effort
    assert arm.chain.gravity.tolist() == [0.1, -0.2, -9.7]
    assert arm.sources["off_centre.viscous"][0].cell == "//joint[@name='off_centre']/@damping"
    assert arm.sources["wrist.mass"][0].cell == "//body[@name='wrist']"


EFFORTS = {  # motors of the joint j -> its effort
    '<motor joint="j" gear="-3" forcerange="-7 5"/>': 21.0,
    '<motor joint="j" gear="3" forcerange="-5 7" ctrlrange="-1 1"/>': 21.0,
    '<motor jointinparent="j" gear="2" ctrlrange="-1 4"/><motor joint="j" ctrlrange="-3 2"/>': 11.0,
    '<general joint="j" gear="2" gainprm="-3" ctrlrange="-4 1"/>': 24.0,
    '<motor joint="j" ctrlrange="-1 1"/><motor joint="j"/>': None,
    '<position joint="j" kp="2" forcerange="-5 4"/>': 5.0,
    '<position joint="j" kp="2" ctrlrange="-5 4"/>': None,
    '<damper joint="j" kv="2" ctrlrange="0 4"/>': None,
    '<motor joint="k" ctrlrange="-4 4"/><motor site="s" ctrlrange="-4 4"/>': None,
}


@pytest.mark.parametrize("motors", EFFORTS)
def test_an_effort_is_the_sum_of_what_the_motors_of_the_joint_alone_can_give(tmp_path, motors):
    body = '<body><joint name="{}" damping=".1"/><geom size=".1"/><site name="{}"/>{}</body>'
    bodies = body.format("k", "t", body.format("j", "s", ""))
    text = f"<mujoco><worldbody>{bodies}</worldbody><actuator>{motors}</actuator></mujoco>"
    assert lwr_dyn.load(written(tmp_path, text, "x.xml")).limits[1].effort == EFFORTS[motors]


def test_what_an_arm_has_no_place_for_is_named_and_so_is_a_missing_mujoco(foreign, monkeypatch):
    notes = "\n".join(lwr_dyn.load(foreign).notes)
    for what in ("springs of joints", "equality constraints", "tendons", "fluid forces", "feedback of servos"):
        assert f"foreign.xml: {what} of the MJCF left out" in notes
    assert "gravity compensation" not in notes
    foreign.write_text(FOREIGN.replace('name="wrist"', 'name="wrist" gravcomp="1"').replace('density="1.2"', ""))
    notes = "\n".join(lwr_dyn.load(foreign).notes)
    assert "gravity compensation of bodies of the MJCF left out" in notes
    assert "fluid" not in notes
    foreign.write_text(FOREIGN.replace(' density="1.2"/>', '><flag gravity="disable"/></option>'))
    weightless = lwr_dyn.load(foreign)
    assert not weightless.chain.gravity.any()
    (foreign.parent / "classes.xml").write_text(CLASSES.replace("0.7", "0.8"))
    assert lwr_dyn.load(foreign).digest != weightless.digest  # a change in an included file
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingPackageError, match=r"mujoco is not installed; .*'lwr_dyn\[parity"):
        lwr_dyn.load(foreign)


@pytest.mark.skipif(int(mujoco.__version__.split(".")[0]) < 4, reason="a motor has an armature from MuJoCo 4 on")
def test_an_armature_of_a_motor_counts_with_the_square_of_its_gear(tmp_path):
    path = tmp_path / "geared.xml"
    motor = '<actuator><motor joint="j" gear="-10" armature="0.5" damping="0.2"/></actuator>'
    body = '<worldbody><body><joint name="j" armature="0.1"/><geom size=".1"/></body></worldbody>'
    path.write_text(f"<mujoco>{body}{motor}</mujoco>")
    arm = lwr_dyn.load(path)
    assert arm.armature.tolist() == [50.1]
    assert differences(path, arm).max() < 1e-12
    assert arm.limits[0].viscous == pytest.approx(20.0)


@pytest.mark.slow
def test_any_small_change_is_read_or_refused_in_our_words(tmp_path):
    read, said, path = 0, list[str](), tmp_path / "x.xml"
    for seed in range(400):
        path.write_text(changed(GOOD if seed % 2 else TREE, random.Random(seed)), encoding="utf-8")
        try:
            arm = read_mjcf(path)
            assert np.isfinite(lwr_dyn.forward_kinematics(arm, np.full(arm.n, 0.1))).all()
            read += 1
        except LwrDynError as fault:
            said.append(str(fault))
    assert read > 50
    assert len(said) > 20
    assert not [line for line in said if "\n" in line]
